//! The error budget: all outcomes in `cargo test` that can fail by chance, counted.

use std::collections::BTreeMap;

use rayon::prelude::*;
use trials::{all, equivalents};
use whitefurnace::harness::guard::MAX_FAULT_MISS;
use whitefurnace::harness::outcome::{ALPHA, CAPACITY, Outcome};
use whitefurnace::harness::trial::{Context, DEFAULT_SEED, SCALES, Trial, run_trial};

use crate::calibration;
use library_tests::shares::{IDENTITIES, MIN_COMPARISONS, RANDOM_ASSERTIONS};

/// Returns the outcomes of a trial on its correct subject. Their number is the same at every scale,
/// so the smallest is used.
fn outcomes(trial: &Trial) -> Vec<Outcome> {
    let context = Context::new(DEFAULT_SEED, *SCALES.start()).expect("a legal scale");
    run_trial(trial, &context)
        .into_iter()
        .map(|row| row.outcome)
        .collect()
}

/// Returns the number of shares: one for each random outcome, as rejection and indecision are one
/// event if δ is the minimum detectable effect; and one for an identity that is tested on random
/// arguments.
fn shares(outcomes: &[Outcome]) -> usize {
    outcomes
        .iter()
        .filter(|outcome| outcome.is_random())
        .count()
        .max(1)
}

/// The registry, its equivalent mutants and everything outside it use no more shares than the level
/// was divided by. The guard limits faults of the registry to a thousandth of a share each.
#[test]
fn the_error_budget_is_kept() {
    let trials = all();
    let found: BTreeMap<&str, Vec<Outcome>> = trials
        .par_iter()
        .map(|trial| (trial.name.as_str(), outcomes(trial)))
        .collect();
    let right: usize = found.values().map(|outcomes| shares(outcomes)).sum();
    let controls = trials.iter().flat_map(|trial| &trial.controls);
    let rejections: usize = controls
        .map(|control| control.rejected_by.len().max(1))
        .sum();
    let faults = (rejections as f64 * MAX_FAULT_MISS / ALPHA).ceil() as usize;
    // The verdict on cells does not imply that of their graded control, on either side.
    let cells = |outcome: &&Outcome| outcome.statistic.contains("chi-square");
    let graded = 2 * found.values().flatten().filter(cells).count();
    let accepted: usize = equivalents()
        .iter()
        .map(|pair| shares(&found[pair.trial.as_str()]))
        .sum();
    let enough: usize = MIN_COMPARISONS.iter().map(|(.., times)| times).sum();
    let elsewhere = RANDOM_ASSERTIONS
        .iter()
        .map(|(_, count)| count)
        .sum::<usize>()
        + enough
        + calibration::assertions();
    let used = right + faults + graded + accepted + elsewhere + IDENTITIES;
    let table = format!(
        "{used} shares of {CAPACITY}: {right} of the registry's correct subjects, {faults} of {rejections} \
         rejections of its faults, {graded} of graded controls of cells, {accepted} of equivalent mutants, \
         {IDENTITIES} for identities in the tests, {elsewhere} elsewhere: calibration, {RANDOM_ASSERTIONS:?}"
    );
    println!("{table}");
    assert!(used <= CAPACITY, "{table}");
}
