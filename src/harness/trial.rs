//! Trials as data: a property, a statistic, a size, and functions that run it on the right subject
//! and on faulty ones.

mod check;
mod context;

pub use check::{
    assert_holds, check, check_control, check_subject, command, control_is_green, meant, refused,
    trial_is_green, write_cells,
};
pub use context::{Context, DEFAULT_SEED, SCALES, shard_from_environment};

use super::outcome::{Outcome, Verdict};

/// What a trial does: takes its random numbers and sizes from the context, returns what it found.
pub type Run = Box<dyn Fn(&Context) -> Vec<Outcome> + Send + Sync>;

/// A faulty subject on which the same trial must fail.
pub struct Control {
    /// A short name, unique within its trial.
    pub name: &'static str,
    /// What is wrong, in one line.
    pub wrong: &'static str,
    /// The outcomes that must all reject it, by name. May be empty where the trial leaves no
    /// choice: see [`meant`].
    pub rejected_by: Vec<&'static str>,
    /// The trial's function with the faulty subject.
    pub run: Run,
}

impl Control {
    /// A control that the trial's only outcome rejects.
    pub fn new(
        name: &'static str,
        wrong: &'static str,
        run: impl Fn(&Context) -> Vec<Outcome> + Send + Sync + 'static,
    ) -> Self {
        Self {
            name,
            wrong,
            rejected_by: Vec::new(),
            run: Box::new(run),
        }
    }
}

/// A property on trial. Sizes and claims are those of its outcomes ([`Outcome::n`],
/// [`Outcome::claim`]).
///
/// Its power follows from what its outcomes vary ([`Outcome::miss`]); the tests assert that each
/// random outcome misses an effect of its δ with probability at most
/// [`ALPHA`](super::outcome::ALPHA).
pub struct Trial {
    /// Unique name, words joined by '-', parts by '/': "hemisphere/uniform/chi-square". The first
    /// part is the [`group`].
    pub name: String,
    /// The statement that is true or false.
    pub property: String,
    /// What the property belongs to: the id of an [`Equation`](crate::equation::Equation), or a
    /// source in words.
    pub source: &'static str,
    /// What is examined: the path of the function.
    pub subject: &'static str,
    /// Which statistic.
    pub statistic: &'static str,
    /// The function on the right subject.
    pub run: Run,
    /// The same function on faulty subjects; at least one.
    pub controls: Vec<Control>,
}

/// One line of the report: what one outcome of a trial says.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The trial's name.
    pub trial: String,
    /// The control's name; empty for the trial itself.
    pub control: String,
    /// The trial's property.
    pub property: String,
    /// The trial's source.
    pub source: &'static str,
    /// What was found.
    pub outcome: Outcome,
    /// The verdict on it.
    pub verdict: Verdict,
    /// The master seed.
    pub seed: u64,
}

/// The columns of [`Row::csv`].
pub const CSV_HEADER: &str = "trial,control,equation,measure,statistic,n,estimate,reference,low,high,\
     p,verdict,delta,minimum_detectable_effect,power,seed";

impl Row {
    /// The row with the columns of [`CSV_HEADER`].
    pub fn csv(&self) -> String {
        let o = &self.outcome;
        let quoted = || format!("\"{}\"", self.source.replace('"', "\"\""));
        let source = if self.source.contains([',', '"']) {
            quoted()
        } else {
            self.source.to_owned()
        };
        format!(
            "{},{},{source},\"{}\",{},{},{:e},{:e},{:e},{:e},{:e},{},{:e},{:e},{},{}",
            self.trial,
            self.control,
            o.name,
            o.statistic,
            o.n,
            o.estimate,
            o.reference,
            o.interval[0],
            o.interval[1],
            o.p,
            self.verdict.word(),
            o.claim.size(),
            o.minimum_detectable_effect(),
            o.power(),
            self.seed
        )
    }
}

/// Runs a trial on its subject.
pub fn run_trial(trial: &Trial, context: &Context) -> Vec<Row> {
    rows(trial, "", &trial.run, context)
}

/// Runs a trial on a faulty subject, with random numbers of its own.
pub fn run_control(trial: &Trial, control: &Control, context: &Context) -> Vec<Row> {
    rows(trial, control.name, &control.run, context)
}

fn rows(trial: &Trial, control: &str, run: &Run, context: &Context) -> Vec<Row> {
    run(&context.named(&full_name(&trial.name, control)))
        .into_iter()
        .map(|outcome| Row {
            trial: trial.name.clone(),
            control: control.to_owned(),
            property: trial.property.clone(),
            source: trial.source,
            verdict: outcome.verdict(),
            outcome,
            seed: context.seed,
        })
        .collect()
}

/// The name of a trial, or of a fault (control) under it: "trial!fault".
pub fn full_name(trial: &str, control: &str) -> String {
    if control.is_empty() {
        trial.to_owned()
    } else {
        format!("{trial}!{control}")
    }
}

/// The part of a trial's name before the first '/': the name of its integration test.
pub fn group(trial: &str) -> &str {
    trial.split('/').next().unwrap_or(trial)
}
