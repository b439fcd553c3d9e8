//! The error budget: everything that chance can turn red in `cargo test`, counted in one place.

use std::path::Path;

use registry::all;
use registry::equivalents;
use whitefurnace::harness::guard::FAR_MISS;
use whitefurnace::harness::outcome::{ALPHA, CAPACITY};
use whitefurnace::harness::trial::Trial;

use crate::shares::{ENOUGH, OUTSIDE};

/// Tests of identities with random arguments, by their calls for them in the sources of the tests: a
/// share each.
fn identities(folder: &Path) -> usize {
    let entries = std::fs::read_dir(folder).expect("the tests' sources");
    let count = |path: &Path| {
        if path.is_dir() {
            return identities(path);
        }
        let text = std::fs::read_to_string(path).expect("a source file");
        let calls = |line: &&str| line.contains("property(") || line.contains(" rng(");
        text.lines().filter(calls).count()
    };
    entries.map(|entry| count(&entry.expect("an entry").path())).sum()
}

/// The registry, its equivalent mutants and everything outside it: no more than was divided by. Faults of
/// the registry are held by the guard to a thousandth of a share.
#[test]
fn the_error_budget_is_kept() {
    let trials = all();
    let right: usize = trials.iter().map(Trial::budget).sum();
    let rejections: usize = trials.iter().map(Trial::rejections).sum();
    let faults = (rejections as f64 * FAR_MISS / ALPHA).ceil() as usize;
    // A graded control of cells is no consequence of their verdict, on either side.
    let graded: usize = trials
        .iter()
        .filter(|trial| trial.statistic.contains("chi-square"))
        .map(|trial| 2 * trial.assertions)
        .sum();
    let accepted: usize = equivalents()
        .iter()
        .filter_map(|pair| trials.iter().find(|trial| trial.name == pair.trial))
        .map(Trial::budget)
        .sum();
    let elsewhere: usize = OUTSIDE.iter().map(|(_, count)| count).sum::<usize>()
        + ENOUGH.iter().map(|(.., times)| times).sum::<usize>();
    let identities = identities(&Path::new(env!("CARGO_MANIFEST_DIR")).join("library"));
    let used = right + faults + graded + accepted + elsewhere + identities;
    let table = format!(
        "{used} shares of {CAPACITY}: {right} of the registry's right subjects, {faults} of {rejections} \
         rejections of its faults, {graded} of graded controls of cells, {accepted} of equivalent mutants, \
         {identities} of identities in the tests, {elsewhere} elsewhere: {OUTSIDE:?}"
    );
    println!("{table}");
    assert!(used <= CAPACITY, "{table}");
}
