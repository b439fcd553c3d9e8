//! The error budget: everything that chance can turn red in `cargo test`, counted in one place.

use std::path::Path;

use whitefurnace::harness::bsdf_checkup::{CheckUp, assertions};
use whitefurnace::harness::guard::FAR_MISS;
use whitefurnace::harness::outcome::{ALPHA, CAPACITY};
use whitefurnace::harness::trial::Trial;
use whitefurnace::trials::all;
use whitefurnace::zoo::equivalents;

use crate::{calibration, checkup, checkup_parts, failures, lobes};

/// Tests with random arguments that compare something only where a ray hits or a path arrives: their
/// names, the count to be exceeded, and how often they ask. Each has a share of the budget, although
/// the counts are far away.
const ENOUGH: [(&str, usize, usize); 11] = [
    ("misses", 500, 1),
    ("mixed", 100, 1),
    ("flat", 100, 3),
    ("scales", 200, 4),
    ("large mesh", 8, 1),
    ("far spheres", 1000, 1),
    ("around", 2500, 1),
    ("through glass", 2500, 1),
    ("inside glass", 1500, 1),
    ("inside glass, bidirectional", 1500, 1),
    ("behind nothing", 100, 2),
];

/// Asserts that a test of [`ENOUGH`] has compared enough.
pub fn enough(name: &str, count: usize) {
    let known = ENOUGH.iter().find(|(test, ..)| *test == name);
    let Some((_, least, _)) = known else {
        panic!("{name} has no share of the error budget: add it to ENOUGH");
    };
    assert!(count > *least, "{name}: only {count} were compared");
}

/// The assertions outside the registry that chance can turn red, by where they stand.
fn outside() -> [(&'static str, usize); 9] {
    let check_up = assertions(&CheckUp::default());
    [
        ("calibration", calibration::ASSERTIONS),
        ("checkup", check_up + checkup::FAULTY.len()),
        ("lobes", lobes::PASSES.iter().sum::<usize>() + lobes::FAULTY),
        ("checkup parts", checkup_parts::ASSERTIONS),
        ("failures", failures::TOYS),
        ("ENOUGH", ENOUGH.iter().map(|(.., times)| times).sum()),
        // The printed distances of far spheres are worse by far.
        ("spheres", 1),
        // Streams do not meet.
        ("rng", 1),
        // The examples of `harness` and of its `bsdf_checkup` and `lobe_checkup`.
        ("documentation", 1 + check_up + lobes::PASSES[2]),
    ]
}

/// Tests of identities with random arguments, by their calls for them in the sources of the tests: a
/// share each.
fn identities() -> usize {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/it");
    let files = std::fs::read_dir(&folder).expect("the tests' sources");
    files
        .map(|file| std::fs::read_to_string(file.expect("an entry").path()).unwrap_or_default())
        .map(|text| {
            let calls = |line: &&str| line.contains("property(") || line.contains(" rng(\"");
            text.lines().filter(calls).count()
        })
        .sum()
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
    let elsewhere: usize = outside().iter().map(|(_, count)| count).sum();
    let identities = identities();
    let used = right + faults + graded + accepted + elsewhere + identities;
    let table = format!(
        "{used} shares of {CAPACITY}: {right} of the registry's right subjects, {faults} of {rejections} \
         rejections of its faults, {graded} of graded controls of cells, {accepted} of equivalent mutants, \
         {identities} of identities in the tests, {elsewhere} elsewhere: {:?}",
        outside()
    );
    println!("{table}");
    assert!(used <= CAPACITY, "{table}");
}
