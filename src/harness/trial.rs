//! Trials as data: a property, a statistic, a size, and functions that run it on the correct
//! subject and on faulty ones.

mod check;
mod context;
mod reject;
mod shared;

pub use check::{
    assert_holds, check, check_control, check_subject, command, control_is_green, power_objections,
    required_outcomes, trial_is_green, write_cells,
};
pub use context::{Context, DEFAULT_SEED, SCALES, shard_from_environment};
pub use reject::{Rejection, reject};
pub use shared::Shared;

use super::outcome::{Outcome, Verdict};

/// Function of a trial: takes random numbers and sizes from the context, returns outcomes.
pub type Run = Box<dyn Fn(&Context) -> Vec<Outcome> + Send + Sync>;

/// Negative control: a faulty subject on which the same trial must fail.
pub struct NegativeControl {
    /// Short name, unique within its trial.
    pub name: &'static str,
    /// The fault, in one line.
    pub wrong: &'static str,
    /// Names of the outcomes that must all reject it. May be empty where the trial leaves no
    /// choice: see [`required_outcomes`].
    pub rejected_by: Vec<&'static str>,
    /// The trial's function with the faulty subject. It runs on parts of the sample first: see
    /// [`reject`].
    pub run: Run,
}

impl NegativeControl {
    /// Creates a control that the trial's only outcome rejects.
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

/// A property under test. Sizes and claims are those of its outcomes ([`Outcome::n`],
/// [`Outcome::claim`]).
///
/// Its power follows from the noise of its outcomes ([`Outcome::miss`]); the tests assert that each
/// random outcome misses an effect of its δ with probability at most
/// [`ALPHA`](super::outcome::ALPHA).
pub struct Trial {
    /// Unique name, words joined by '-', parts by '/': "hemisphere/uniform/chi-square". The first
    /// part is the [`group`].
    pub name: String,
    /// The statement that is true or false.
    pub property: String,
    /// Symptom in a renderer where the property is false: a clause that a user would say.
    pub consequence: String,
    /// Source of the property: the id of an [`Equation`](crate::equation::Equation), or a source in
    /// words.
    pub source: &'static str,
    /// Subject: the path of the function under test.
    pub subject: &'static str,
    /// Name of the statistic.
    pub statistic: &'static str,
    /// Function on the correct subject.
    pub run: Run,
    /// The trial's function on faulty subjects; at least one.
    pub controls: Vec<NegativeControl>,
}

/// One line of the report: one outcome of a trial.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Name of the trial.
    pub trial: String,
    /// Name of the control; empty for the trial itself.
    pub control: String,
    /// Property of the trial.
    pub property: String,
    /// Source of the property.
    pub source: &'static str,
    /// Outcome.
    pub outcome: Outcome,
    /// Verdict on the outcome.
    pub verdict: Verdict,
    /// Master seed.
    pub seed: u64,
}

/// Columns of [`Row::csv`].
pub const CSV_HEADER: &str = "trial,control,equation,measure,statistic,n,estimate,reference,low,high,\
     p,verdict,delta,minimum_detectable_effect,power,seed";

impl Row {
    /// Returns the row with the columns of [`CSV_HEADER`].
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
    rows(trial, "", (trial.run)(&context.named(&trial.name)), context)
}

/// Runs a trial on a faulty subject, with its own random numbers, on no more of the sample than it
/// takes to [reject] it.
pub fn run_control(trial: &Trial, control: &NegativeControl, context: &Context) -> Vec<Row> {
    let found = reject_control(trial, control, context);
    rows(trial, control.name, found.outcomes, context)
}

fn reject_control(trial: &Trial, control: &NegativeControl, context: &Context) -> Rejection {
    let named = context.named(&full_name(&trial.name, control.name));
    reject(&control.run, &control.rejected_by, &named)
}

fn rows(trial: &Trial, control: &str, outcomes: Vec<Outcome>, context: &Context) -> Vec<Row> {
    outcomes
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

/// Returns the name of a trial, or of a control under it: "trial!control".
pub fn full_name(trial: &str, control: &str) -> String {
    if control.is_empty() {
        trial.to_owned()
    } else {
        format!("{trial}!{control}")
    }
}

/// Returns the part of a trial's name before the first '/': the name of its integration test.
pub fn group(trial: &str) -> &str {
    trial.split('/').next().unwrap_or(trial)
}
