//! The whole suite under fresh master seeds at a reduced scale, for `false-alarms` and `power`.
//!
//! The result of a seed is a function of the program, the run's seed and the scale. It is stored
//! beside the experiments, so that each is computed once; `power` does without mutants, which take
//! as long again.

use serde::{Deserialize, Serialize};
use trials::equivalents;
use trials::faults::Pair;
use whitefurnace::harness::trial::{NegativeControl, control_is_green, full_name, run_control};

use crate::experiments::prelude::*;
use crate::run::part_cache::PartCache;
use trials::statistics::is_bound;

/// Scale of sample sizes. Exact identities keep their arguments.
pub const SCALE: f64 = 1.0 / 32.0;

/// Faults, which cost as much as correct subjects, are run under every seed with an index divisible
/// by this.
pub const FAULTS_SEED_STRIDE: u64 = 4;

/// Powers at which graded controls are counted.
pub const POWERS: [f64; 2] = [0.5, 0.9];

/// Results of the suite on mutants under one master seed.
#[derive(Serialize, Deserialize)]
pub struct Mutants {
    /// Outcomes of equivalent mutants.
    pub equivalents: Vec<Measure>,
    /// Answers to faults; empty under most seeds ([`FAULTS_SEED_STRIDE`]).
    pub faults: Vec<(String, Answer)>,
}

/// Stored outcome of a correct subject or an equivalent mutant.
#[derive(Clone, Serialize, Deserialize)]
pub struct Measure {
    /// "trial: outcome".
    pub name: String,
    /// Name of the statistic.
    pub statistic: String,
    /// The verdict.
    pub verdict: Judgement,
    /// True if the outcome is random.
    pub random: bool,
    /// True if only equality within a margin is claimed.
    pub approximate: bool,
    /// The p-value; 0 for NaN.
    pub p: f64,
    /// Number of independent values.
    pub n: u64,
    /// Least number of values for which the tail at the suite's level is valid.
    pub valid_from: u64,
    /// True if the stated power is only a lower bound.
    pub bound: bool,
    /// Graded controls of an exact claim.
    pub graded: Vec<Graded>,
}

/// Stored graded control.
#[derive(Clone, Serialize, Deserialize)]
pub struct Graded {
    /// True if its values are too large, false if too small.
    pub up: bool,
    /// The p-value.
    pub p: f64,
    /// For each of [`POWERS`]: the level at which it is stated, and the power stated at that level.
    pub levels: [[f64; 2]; 2],
}

/// Joint result of the outcomes that must reject a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Answer {
    /// All of them reject it.
    Rejected,
    /// Not all of them reject it at this scale.
    Undecided,
    /// An error in `cargo test` at any scale: one accepts the fault, or rejects it because of NaN.
    Red,
}

/// Experiments that use the stored seeds. They belong to one shard, since only one program at a
/// time may write the parts in the folder.
pub const SHARED_BY: [&str; 2] = ["power", "false-alarms"];

/// Seeds of a run.
pub struct SuiteSeeds {
    parts: PartCache,
    master: u64,
    /// Scale of sample sizes.
    pub scale: f64,
    /// The registry.
    pub trials: Vec<Trial>,
    equivalents: Vec<Pair>,
}

impl SuiteSeeds {
    /// Opens the seeds of this run's master seed, at its scale.
    pub fn open(run: &Run) -> Result<Self, Error> {
        let scale = run.scale(SCALE);
        Ok(Self {
            parts: run.shared("suite-seeds", &format!("{} {scale}", run.seed()))?,
            master: run.seed(),
            scale,
            trials: trials::all(),
            equivalents: equivalents(),
        })
    }

    /// Returns the suite's outcomes on correct subjects under seed number `k`.
    pub fn subjects(&self, k: u64) -> Result<Vec<Measure>, Error> {
        self.parts.part(&format!("subjects-{k}"), || {
            let context = self.context(k)?;
            let subjects = parallel_map(&self.trials, |trial| -> Vec<Measure> {
                let rows = run_trial(trial, &context);
                rows.iter()
                    .map(|row| measure(&trial.name, &row.outcome))
                    .collect()
            })?;
            Ok(subjects.concat())
        })
    }

    /// Returns the suite's outcomes on mutants under seed number `k`.
    pub fn mutants(&self, k: u64) -> Result<Mutants, Error> {
        self.parts.part(&format!("mutants-{k}"), || {
            let context = self.context(k)?;
            let equivalents = parallel_map(&self.equivalents, |pair| -> Vec<Measure> {
                let name = full_name(&pair.trial, pair.fault.name);
                let found = (pair.run)(&context.named(&name));
                found.iter().map(|found| measure(&name, found)).collect()
            })?;
            let faults: Vec<(&Trial, &NegativeControl)> = self
                .trials
                .iter()
                .filter(|_| k.is_multiple_of(FAULTS_SEED_STRIDE))
                .flat_map(|trial| trial.controls.iter().map(move |control| (trial, control)))
                .collect();
            let faults = parallel_map(&faults, |(trial, control)| {
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

fn answer(trial: &Trial, control: &NegativeControl, context: &Context) -> Answer {
    let rows = run_control(trial, control, context);
    let outcomes = rows.iter().map(|row| &row.outcome);
    let required = required_outcomes(&control.rejected_by, outcomes);
    if !control_is_green(control, &rows, context) {
        Answer::Red
    } else if required.iter().all(|o| o.verdict() == Verdict::Fails) {
        Answer::Rejected
    } else {
        Answer::Undecided
    }
}

/// Returns a p-value; 0, the smallest, for NaN.
fn number(p: f64) -> f64 {
    if p.is_nan() { 0.0 } else { p }
}

fn measure(trial: &str, o: &Outcome) -> Measure {
    let exact = matches!(o.claim, Claim::Equal { .. });
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
        approximate: matches!(o.claim, Claim::Equivalent { .. }),
        p: number(o.p),
        n: o.n,
        valid_from: o.valid_from,
        bound: is_bound(&o.sensitivity),
        graded: graded.collect(),
    }
}
