//! What several test modules need.

use proptest::strategy::Strategy;
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestRng, TestRunner};
use whitefurnace::harness::trial::Context;

/// The context of the environment for the test with this name.
pub fn context(name: &str) -> Context {
    Context::from_environment()
        .expect("WHITEFURNACE_SEED and WHITEFURNACE_SCALE")
        .named(name)
}

/// Checks a property on random arguments. The random numbers come from the master seed and the name;
/// no file is written.
pub fn property<S: Strategy>(
    name: &str,
    arguments: S,
    test: impl Fn(S::Value) -> Result<(), TestCaseError>,
) {
    let context = context(name);
    let mut seed = [0; 32];
    for (i, word) in seed.chunks_exact_mut(8).enumerate() {
        word.copy_from_slice(&context.seed_of(&format!("proptest word {i}")).to_le_bytes());
    }
    let config = Config {
        failure_persistence: None,
        ..Config::default()
    };
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &seed);
    if let Err(error) = TestRunner::new_with_rng(config, rng).run(&arguments, test) {
        panic!("{name} (WHITEFURNACE_SEED={}): {error}", context.seed);
    }
}

/// The rows of a data file: comma-separated, '#' for comments.
pub fn rows(text: &'static str) -> impl Iterator<Item = Vec<&'static str>> {
    text.lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| line.split(',').collect())
}

/// A number of a data file.
pub fn number(text: &str) -> f64 {
    text.parse().expect("a number in a data file")
}
