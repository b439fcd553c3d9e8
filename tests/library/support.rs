//! The master seed of the tests, and generators derived from it.

use proptest::strategy::Strategy;
use proptest::test_runner::{Config, RngSeed, TestRunner};
use whitefurnace::harness::trial::Context;
use whitefurnace::sampling::rng::{Stream, seed_for, stream};

/// Returns the context of the environment for the test with this name.
pub fn context(name: &str) -> Context {
    Context::from_environment()
        .expect("WHITEFURNACE_SEED and WHITEFURNACE_SCALE")
        .named(name)
}

/// Returns the master seed of the environment.
pub fn master() -> u64 {
    context("").seed
}

/// Returns a test's own generator. Its output shows how to repeat the test if it fails.
pub fn rng(name: &str) -> Stream {
    println!("{}", repeat());
    stream(seed_for(master(), name), 0, 0)
}

/// Runs `check` on `cases` values of the strategy; a failure is shrunk and shown, never stored.
pub fn property<S: Strategy>(name: &str, cases: u32, strategy: &S, check: impl Fn(S::Value)) {
    let config = Config {
        cases,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(seed_for(master(), name)),
        ..Config::default()
    };
    let result = TestRunner::new(config).run(strategy, |value| {
        check(value);
        Ok(())
    });
    if let Err(error) = result {
        panic!("{name}: {error}\n{}", repeat());
    }
}

fn repeat() -> String {
    format!(
        "repeat with WHITEFURNACE_SEED={} cargo test -p whitefurnace --test library",
        master()
    )
}
