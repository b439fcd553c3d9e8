//! Named faults, each with the trials that must reject it.
//!
//! A [`Family`] is a type of subject (a sampler, a reflectance, an estimator's components ...), the
//! correct subject of that type, trials that take any subject of it, and faulty subjects. It yields
//! the registry's trials (a fault is the negative control of each trial that names it), the list of
//! faults, and the table of every fault under every trial of its family.

use std::sync::Arc;

use whitefurnace::equation::Equation;
use whitefurnace::harness::outcome::Outcome;
use whitefurnace::harness::trial::{Context, NegativeControl, Run, Trial};

/// A trial's function, for any subject of the family's type.
pub type SharedTrialFn<S> = Arc<dyn Fn(&Context, S) -> Vec<Outcome> + Send + Sync>;

/// A trial's function that captures nothing.
pub type TrialFn<S> = fn(&Context, S) -> Vec<Outcome>;

/// A trial that takes any subject of its family.
pub struct FamilyTrial<S> {
    /// The trial as data; the family fills in its functions.
    pub trial: Trial,
    /// The trial's function.
    pub on: SharedTrialFn<S>,
}

/// Builds a trial from its name, its property, the symptom in a renderer where that is false, its
/// equation, the code on trial, the statistic that judges it, and its function.
pub fn trial<S>(
    name: impl Into<String>,
    property: impl Into<String>,
    consequence: impl Into<String>,
    equation: &'static Equation,
    subject: &'static str,
    statistic: &'static str,
    on: impl Fn(&Context, S) -> Vec<Outcome> + Send + Sync + 'static,
) -> FamilyTrial<S> {
    let (run, controls) = (Box::new(|_: &Context| Vec::new()), Vec::new());
    let trial = Trial {
        name: name.into(),
        property: property.into(),
        consequence: consequence.into(),
        source: equation.id,
        subject,
        statistic,
        run,
        controls,
    };
    FamilyTrial {
        trial,
        on: Arc::new(on),
    }
}

/// A subject that differs from the correct one.
pub struct Fault<S> {
    /// Its name, unique within the family.
    pub name: &'static str,
    /// The equation that it breaks.
    pub equation: &'static Equation,
    /// The error in one line; for an equivalent mutant, the reason why there is none.
    pub wrong: &'static str,
    /// The faulty subject.
    pub subject: S,
    /// The trials that must reject it, each alone or with the outcomes that must: "trial: outcome |
    /// outcome" (see [`NegativeControl::rejected_by`]). For an equivalent mutant, the trials that
    /// must accept it.
    pub rejected_by: &'static [&'static str],
}

/// Splits an entry of [`Fault::rejected_by`] into the trial and its outcomes.
fn entry(rejected_by: &'static str) -> (&'static str, Vec<&'static str>) {
    match rejected_by.split_once(": ") {
        Some((trial, outcomes)) => (trial, outcomes.split(" | ").collect()),
        None => (rejected_by, Vec::new()),
    }
}

/// Returns the outcomes of a trial that `rejected_by` names; `None` if it does not name the trial.
fn outcomes_of(rejected_by: &[&'static str], trial: &str) -> Option<Vec<&'static str>> {
    let mut entries = rejected_by
        .iter()
        .map(|text| entry(text))
        .filter(|(name, _)| *name == trial)
        .peekable();
    entries.peek()?;
    Some(entries.flat_map(|(_, outcomes)| outcomes).collect())
}

/// Builds a fault from its fields, in their order.
pub fn fault<S>(
    name: &'static str,
    equation: &'static Equation,
    wrong: &'static str,
    subject: S,
    rejected_by: &'static [&'static str],
) -> Fault<S> {
    Fault {
        name,
        equation,
        wrong,
        subject,
        rejected_by,
    }
}

/// Trials of one type of subject, and faults of that type.
pub struct Family<S> {
    /// Its name.
    pub name: &'static str,
    /// Whether its subjects act through a whole estimator.
    pub whole_estimator: bool,
    /// The correct subject.
    pub correct: S,
    /// The trials.
    pub trials: Vec<FamilyTrial<S>>,
    /// The faults.
    pub faults: Vec<Fault<S>>,
    /// Mutants that are as correct as the correct subject.
    pub equivalents: Vec<Fault<S>>,
}

/// A fault as data.
#[derive(Clone, Debug, PartialEq)]
pub struct FaultData {
    /// The family, whose trials can be run on it.
    pub family: &'static str,
    /// Its name, unique within the family.
    pub name: &'static str,
    /// The equation that it breaks.
    pub equation: &'static Equation,
    /// The error in one line; for an equivalent mutant, the reason why there is none.
    pub wrong: &'static str,
    /// The trials that must reject it (accept it, if it is equivalent), without duplicates.
    pub rejected_by: Vec<&'static str>,
    /// Whether it acts through a whole estimator.
    pub whole_estimator: bool,
    /// Whether it is a mutant that no trial can or should reject.
    pub equivalent: bool,
}

/// A fault under a trial of its family.
pub struct Pair {
    /// The fault.
    pub fault: FaultData,
    /// Name of the trial.
    pub trial: String,
    /// Whether the trial is one of those that must reject (or accept) the fault.
    pub required: bool,
    /// The outcomes that must reject it, as in [`NegativeControl::rejected_by`].
    pub rejected_by: Vec<&'static str>,
    /// The trial's function on the fault.
    pub run: Run,
}

/// A [`Family`] without its type of subject.
pub trait AnyFamily: Send + Sync {
    /// Returns the trials, with the faults that name them as negative controls.
    fn trials(&self) -> Vec<Trial>;
    /// Returns the faults, then the equivalent mutants.
    fn faults(&self) -> Vec<FaultData>;
    /// Returns every fault and equivalent mutant under every trial.
    fn pairs(&self) -> Vec<Pair>;
}

impl<S: Copy + Send + Sync + 'static> Family<S> {
    /// Returns a family with the correct subject `correct` and no trials or faults.
    pub fn new(name: &'static str, correct: S) -> Self {
        Self {
            name,
            whole_estimator: false,
            correct,
            trials: Vec::new(),
            faults: Vec::new(),
            equivalents: Vec::new(),
        }
    }

    /// Returns a family without trials or faults whose subjects act through a whole estimator.
    pub fn whole(name: &'static str, correct: S) -> Self {
        Self {
            whole_estimator: true,
            ..Self::new(name, correct)
        }
    }

    fn all(&self) -> impl Iterator<Item = (&Fault<S>, bool)> {
        let faults = self.faults.iter().map(|fault| (fault, false));
        faults.chain(self.equivalents.iter().map(|mutant| (mutant, true)))
    }

    fn fault(&self, mutant: &Fault<S>, equivalent: bool) -> FaultData {
        FaultData {
            family: self.name,
            name: mutant.name,
            equation: mutant.equation,
            wrong: mutant.wrong,
            rejected_by: {
                let mut trials: Vec<_> = mutant
                    .rejected_by
                    .iter()
                    .map(|text| entry(text).0)
                    .collect();
                trials.dedup();
                trials
            },
            whole_estimator: self.whole_estimator,
            equivalent,
        }
    }

    /// Returns a trial's function on a mutant.
    fn on(family_trial: &FamilyTrial<S>, mutant: &Fault<S>) -> Run {
        let (on, subject) = (Arc::clone(&family_trial.on), mutant.subject);
        Box::new(move |context| on(context, subject))
    }
}

impl<S: Copy + Send + Sync + 'static> AnyFamily for Family<S> {
    fn trials(&self) -> Vec<Trial> {
        let trial = |family_trial: &FamilyTrial<S>| {
            let (on, correct) = (Arc::clone(&family_trial.on), self.correct);
            let data = &family_trial.trial;
            let named = self.faults.iter().filter_map(|fault| {
                outcomes_of(fault.rejected_by, &data.name).map(|outcomes| (fault, outcomes))
            });
            Trial {
                name: data.name.clone(),
                property: data.property.clone(),
                consequence: data.consequence.clone(),
                run: Box::new(move |context| on(context, correct)),
                controls: named
                    .map(|(fault, rejected_by)| NegativeControl {
                        name: fault.name,
                        wrong: fault.wrong,
                        run: Self::on(family_trial, fault),
                        rejected_by,
                    })
                    .collect(),
                ..*data
            }
        };
        self.trials.iter().map(trial).collect()
    }

    fn faults(&self) -> Vec<FaultData> {
        self.all()
            .map(|(mutant, equivalent)| self.fault(mutant, equivalent))
            .collect()
    }

    fn pairs(&self) -> Vec<Pair> {
        self.all()
            .flat_map(|(mutant, equivalent)| {
                self.trials.iter().map(move |family_trial| {
                    let outcomes = outcomes_of(mutant.rejected_by, &family_trial.trial.name);
                    Pair {
                        fault: self.fault(mutant, equivalent),
                        trial: family_trial.trial.name.clone(),
                        required: outcomes.is_some(),
                        rejected_by: outcomes.unwrap_or_default(),
                        run: Self::on(family_trial, mutant),
                    }
                })
            })
            .collect()
    }
}
