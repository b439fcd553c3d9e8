//! Runs the registry of trials in parallel for the experiments.

use rayon::prelude::*;
use whitefurnace::error::Error;
use whitefurnace::harness::outcome::Verdict;
use whitefurnace::harness::trial::{Context, Row, Trial, run_trial};

use crate::run::Run;
use crate::run::progress::{Bar, interrupted};

/// Returns the scale of sample sizes at which experiments repeat the suite: that of the suite
/// itself at the full tier.
pub fn scale(run: &Run) -> f64 {
    run.scale(run.by_tier(1.0 / 16.0, 1.0))
}

/// Family-wise level of an experiment.
pub const FAMILYWISE_LEVEL: f64 = 1e-3;

/// Does `work` for every item on all cores; the results are in the items' order.
pub fn parallel_map<I: IntoParallelIterator<Iter: IndexedParallelIterator>, R: Send>(
    items: I,
    work: impl Fn(I::Item) -> R + Sync,
) -> Result<Vec<R>, Error> {
    let items = items.into_par_iter();
    let bar = Bar::new("", items.len() as u64, "parts");
    items
        .map(|item| {
            if interrupted() {
                return Err(Error::Interrupted);
            }
            let done = work(item);
            bar.advance(1);
            Ok(done)
        })
        .collect()
}

/// Returns the rows of every trial at that scale, in the trials' order.
pub fn rows(run: &Run, trials: &[Trial]) -> Result<Vec<Vec<Row>>, Error> {
    let context = Context::new(run.seed(), scale(run))?;
    parallel_map(trials, |trial| run_trial(trial, &context))
}

/// Returns the joint verdict on several outcomes: fails if one does, holds if all do.
pub fn joint_verdict<'a>(rows: impl IntoIterator<Item = &'a Row>) -> Verdict {
    rows.into_iter().fold(Verdict::Holds, |joint_verdict, row| {
        match (joint_verdict, row.verdict) {
            (Verdict::Fails, _) | (_, Verdict::Fails) => Verdict::Fails,
            (Verdict::Undecided { needed: a }, Verdict::Undecided { needed: b }) => {
                Verdict::Undecided { needed: a.max(b) }
            }
            (Verdict::Holds, other) | (other, Verdict::Holds) => other,
        }
    })
}
