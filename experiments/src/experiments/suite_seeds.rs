//! The whole suite under fresh master seeds at a reduced scale: what `false-alarms` counts and
//! `power` measures.
//!
//! What a seed gives is a function of the program, the run's seed and the scale. It is kept beside
//! the experiments, so that each is paid once; `power` does without mutants, which take as long
//! again.

use registry::equivalents;
use registry::faults::Pair;
use serde::{Deserialize, Serialize};
use whitefurnace::harness::trial::{Control, control_is_green, full_name, run_control};

use crate::experiments::prelude::*;
use crate::run::unfinished::Unfinished;
use registry::statistics::is_bound;

/// The scale of sample sizes. Exact identities keep their arguments.
pub const SCALE: f64 = 1.0 / 32.0;

/// Faults are as dear as right subjects: they are run under every so many-th seed.
pub const FAULTS_EVERY: u64 = 4;

/// Powers at which graded controls are counted.
pub const POWERS: [f64; 2] = [0.5, 0.9];

/// What the suite found of mutants under one master seed.
#[derive(Serialize, Deserialize)]
pub struct Mutants {
    /// Of those that are equivalent.
    pub equivalents: Vec<Measure>,
    /// Of faults; empty under most seeds ([`FAULTS_EVERY`]).
    pub faults: Vec<(String, Answer)>,
}

/// What is kept of an outcome of a right subject or an equivalent mutant.
#[derive(Clone, Serialize, Deserialize)]
pub struct Measure {
    /// "trial: outcome".
    pub name: String,
    /// The statistic.
    pub statistic: String,
    /// The verdict.
    pub verdict: Judgement,
    /// Whether chance has a part.
    pub random: bool,
    /// Whether it is claimed to be within a margin only.
    pub approximate: bool,
    /// The p-value; 0 where it is none.
    pub p: f64,
    /// Independent values.
    pub n: u64,
    /// The least number of values for which the tail at the suite's level is valid.
    pub valid_from: u64,
    /// Whether the stated power is a lower bound only.
    pub bound: bool,
    /// The graded controls of an exact claim.
    pub graded: Vec<Graded>,
}

/// What is kept of a graded control.
#[derive(Clone, Serialize, Deserialize)]
pub struct Graded {
    /// Whether its values are too large, or too small.
    pub up: bool,
    /// The p-value.
    pub p: f64,
    /// For each of [`POWERS`]: the level at which it is stated, and the power stated at that level.
    pub levels: [[f64; 2]; 2],
}

/// What the outcomes that must reject a fault say together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Answer {
    /// All of them reject it.
    Rejected,
    /// Not yet at this scale.
    Undecided,
    /// Red in `cargo test` at any scale: one accepts it, or rejects it for a number that is none.
    Red,
}

/// The experiments that draw on them: one shard runs both, since the parts in the folder are
/// written by one at a time.
pub const TOGETHER: [&str; 2] = ["power", "false-alarms"];

/// The seeds of a run.
pub struct Seeds {
    parts: Unfinished,
    master: u64,
    /// The scale of sample sizes.
    pub scale: f64,
    /// The registry.
    pub trials: Vec<Trial>,
    equivalents: Vec<Pair>,
}

impl Seeds {
    /// The seeds of this run's master seed, at its scale.
    pub fn open(run: &Run) -> Result<Self, Error> {
        let scale = run.scale(SCALE);
        Ok(Self {
            parts: run.shared("suite-seeds", &format!("{} {scale}", run.seed()))?,
            master: run.seed(),
            scale,
            trials: registry::all(),
            equivalents: equivalents(),
        })
    }

    /// What the suite finds of right subjects under seed number `k`.
    pub fn subjects(&self, k: u64) -> Result<Vec<Measure>, Error> {
        self.parts.part(&format!("subjects-{k}"), || {
            let context = self.context(k)?;
            let subjects = parallel(&self.trials, |trial| -> Vec<Measure> {
                let rows = run_trial(trial, &context);
                rows.iter()
                    .map(|row| measure(&trial.name, &row.outcome))
                    .collect()
            })?;
            Ok(subjects.concat())
        })
    }

    /// What it finds of mutants.
    pub fn mutants(&self, k: u64) -> Result<Mutants, Error> {
        self.parts.part(&format!("mutants-{k}"), || {
            let context = self.context(k)?;
            let equivalents = parallel(&self.equivalents, |pair| -> Vec<Measure> {
                let name = full_name(&pair.trial, pair.fault.name);
                let found = (pair.run)(&context.named(&name));
                found.iter().map(|found| measure(&name, found)).collect()
            })?;
            let faults: Vec<(&Trial, &Control)> = self
                .trials
                .iter()
                .filter(|_| k.is_multiple_of(FAULTS_EVERY))
                .flat_map(|trial| trial.controls.iter().map(move |control| (trial, control)))
                .collect();
            let faults = parallel(&faults, |(trial, control)| {
                (
                    full_name(&trial.name, control.name),
                    answer(trial, control, &context),
                )
            })?;
            Ok(Mutants {
                equivalents: equivalents.concat(),
                faults,
            })
        })
    }

    fn context(&self, k: u64) -> Result<Context, Error> {
        Context::new(seed_for(self.master, &format!("suite {k}")), self.scale)
    }
}

fn answer(trial: &Trial, control: &Control, context: &Context) -> Answer {
    let rows = run_control(trial, control, context);
    let outcomes = rows.iter().map(|row| &row.outcome);
    let meant = meant(&control.rejected_by, outcomes);
    if !control_is_green(control, &rows, context) {
        Answer::Red
    } else if meant.iter().all(|o| o.verdict() == Verdict::Fails) {
        Answer::Rejected
    } else {
        Answer::Undecided
    }
}

/// A p-value; 0, the least there is, for NaN.
fn number(p: f64) -> f64 {
    if p.is_nan() { 0.0 } else { p }
}

fn measure(trial: &str, o: &Outcome) -> Measure {
    let exact = matches!(o.claim, Claim::Exact { .. });
    let graded = o.graded.iter().filter(|_| exact).map(|graded| {
        let level = |power: f64| {
            let level = o.sensitivity.level_with_power(graded.effect, power);
            [level, 1.0 - o.sensitivity.miss_at(graded.effect, level)]
        };
        Graded {
            up: graded.effect > 0.0,
            p: number(graded.outcome.p),
            levels: POWERS.map(level),
        }
    });
    Measure {
        name: format!("{trial}: {}", o.name),
        statistic: o.statistic.to_owned(),
        verdict: o.verdict().into(),
        random: o.is_random(),
        approximate: matches!(o.claim, Claim::Approximate { .. }),
        p: number(o.p),
        n: o.n,
        valid_from: o.valid_from,
        bound: is_bound(&o.sensitivity),
        graded: graded.collect(),
    }
}
