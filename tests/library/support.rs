//! The master seed of the tests, and generators derived from it.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use proptest::strategy::Strategy;
use proptest::test_runner::{Config, RngSeed, TestRunner};
use whitefurnace::harness::trial::Context;
use whitefurnace::sampling::rng::{Stream, seed_for, stream};

use crate::shares::IDENTITIES;

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

/// Takes a share of the error budget for the running test, which draws random arguments.
///
/// # Panics
/// If more than [`IDENTITIES`] tests do.
fn take_share() {
    static TESTS: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    // The harness names a test's thread after it.
    let test = std::thread::current().name().unwrap_or_default().to_owned();
    let mut tests = TESTS.lock().unwrap_or_else(PoisonError::into_inner);
    tests.insert(test);
    let count = tests.len();
    assert!(
        count <= IDENTITIES,
        "{count} tests have random arguments, shares::IDENTITIES is {IDENTITIES}"
    );
}

/// Returns an empty folder of the running test's own, since tests run beside each other.
///
/// # Panics
/// In a thread that a test started.
pub fn folder() -> PathBuf {
    let thread = std::thread::current();
    // The harness names a test's thread after it.
    let test = thread.name().expect("the thread of a test");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(test.replace("::", "-"));
    // An earlier run may have left it.
    drop(fs::remove_dir_all(&folder));
    fs::create_dir_all(&folder).expect("a folder for tests");
    folder
}

/// Returns a test's own generator. Its output shows how to repeat the test if it fails.
pub fn rng(name: &str) -> Stream {
    take_share();
    println!("{}", repeat());
    stream(seed_for(master(), name), 0, 0)
}

/// Runs `check` on `cases` values of the strategy; a failure is shrunk and shown, never stored.
pub fn property<S: Strategy>(name: &str, cases: u32, strategy: &S, check: impl Fn(S::Value)) {
    take_share();
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
        "repeat with WHITEFURNACE_SEED={} cargo test --test library",
        master()
    )
}
