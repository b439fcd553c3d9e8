//! The error budget: everything that chance can turn red in `cargo test`, counted in one place.

use whitefurnace::harness::bsdf_checkup::{CheckUp, assertions};
use whitefurnace::harness::outcome::CAPACITY;
use whitefurnace::trials::all;
use whitefurnace::zoo::equivalents;

use crate::{calibration, checkup, checkup_parts, failures, lobes};

/// Tests with random arguments that compare something only where a ray hits or a path arrives: their
/// names, the count to be exceeded, and how often they ask. Each has a share of the budget, although
/// the counts are far away.
const ENOUGH: [(&str, usize, usize); 10] = [
    ("misses", 500, 1),
    ("mixed", 100, 1),
    ("flat", 100, 3),
    ("scales", 200, 4),
    ("large mesh", 8, 1),
    ("far spheres", 1000, 1),
    ("around", 2500, 1),
    ("through glass", 2500, 1),
    ("inside glass", 1500, 1),
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

/// The registry, its equivalent mutants and everything outside it: no more than was divided by.
#[test]
fn the_error_budget_is_kept() {
    let trials = all();
    let registry: usize = trials.iter().map(|trial| trial.budget()).sum();
    let accepted: usize = equivalents()
        .iter()
        .filter_map(|pair| trials.iter().find(|trial| trial.name == pair.trial))
        .map(|trial| trial.assertions)
        .sum();
    let elsewhere: usize = outside().iter().map(|(_, count)| count).sum();
    let used = registry + accepted + elsewhere;
    let table = format!(
        "{used} assertions of {CAPACITY}: {registry} of the registry, {accepted} of equivalent mutants, \
         {elsewhere} outside: {:?}",
        outside()
    );
    println!("{table}");
    assert!(used <= CAPACITY, "{table}");
}
