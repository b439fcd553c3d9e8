//! Error rates and power of the statistics, measured at a small size over replications with
//! independent streams. Bounds are valid at 1e-9; comparisons go through the guard, and wrong
//! statistics are detected.

use rayon::prelude::*;
use trials::statistics::{LEVEL, N, continuous, error_rate_bounds};
use whitefurnace::harness::chi_square::binomial;
use whitefurnace::harness::guard::{fault_objection, power_objection};
use whitefurnace::harness::ks::kolmogorov_smirnov;
use whitefurnace::harness::mean::{Values, mean};
use whitefurnace::harness::outcome::{ALPHA, Claim, Outcome, Verdict};
use whitefurnace::harness::tails::{binomial_sf, normal_sf, normal_upper};
use whitefurnace::harness::trial::Context;
use whitefurnace::sampling::rng::{Stream, stream, uniform};

const REPLICATIONS: u32 = 2000;

/// Returns one result per replication, each with a stream of its own.
fn replicate<T: Send>(name: &str, run: impl Fn(&mut Stream) -> T + Sync) -> Vec<T> {
    let context = Context::from_environment()
        .expect("WHITEFURNACE_SEED and WHITEFURNACE_SCALE")
        .named(name);
    let seed = context.seed_of("replications");
    (0..REPLICATIONS)
        .into_par_iter()
        .map(|i| run(&mut stream(seed, i, 0)))
        .collect()
}

/// Returns whether the guard is used in this run.
fn planned() -> bool {
    Context::from_environment()
        .expect("WHITEFURNACE_SEED and WHITEFURNACE_SCALE")
        .guard_applies()
}

/// Effect on a distribution or a rate that this many replications detect with certainty.
const DETECTED_EFFECT: f64 = 0.15;

/// Asserts that an outcome at this size holds, and, where sizes are planned, that the guard passes
/// it.
fn assert_holds(outcome: &Outcome) {
    assert!(
        !planned() || power_objection(outcome).is_none(),
        "{:?}",
        power_objection(outcome)
    );
    assert_eq!(outcome.verdict(), Verdict::Holds, "{outcome}");
}

/// Tests whether p-values are uniform, as those of a true hypothesis are, up to the statistic's own
/// approximations.
fn uniformity(name: &str, run: impl Fn(&mut Stream) -> Outcome + Sync) -> Outcome {
    kolmogorov_smirnov(
        name,
        &mut replicate(name, |rng| run(rng).p),
        |p| p,
        DETECTED_EFFECT,
    )
}

/// Compares the frequency of an event with a rate.
fn rate(name: &str, happened: &[bool], rate: f64) -> Outcome {
    let k = happened.iter().filter(|&&h| h).count() as u64;
    binomial(name, k, happened.len() as u64, rate, DETECTED_EFFECT)
}

#[test]
fn p_values_of_true_hypotheses_are_uniform() {
    for statistic in continuous() {
        let name = format!("calibration of {}", statistic.name);
        assert_holds(&uniformity(&name, |rng| (statistic.run)(rng, 0.0)));
    }
}

#[test]
fn statistics_that_only_promise_a_bound_keep_it() {
    for bound in error_rate_bounds() {
        let found = rate(
            bound.name,
            &replicate(bound.name, bound.happened),
            bound.rate,
        );
        // A lower rate is no fault: only the upper side is tested, where an effect is detected as
        // well.
        assert!(
            found.sensitivity.miss(DETECTED_EFFECT) <= ALPHA,
            "{}",
            bound.name
        );
        let p = binomial_sf(found.value as u64, found.n, bound.rate);
        assert!(
            p >= ALPHA,
            "{}, at most {} claimed",
            found.worst,
            bound.rate
        );
    }
}

/// Powers at which the stated curve is checked.
const POWERS: [f64; 2] = [0.5, 0.9];

/// Number of random assertions of this module.
pub fn assertions() -> usize {
    continuous().len() + error_rate_bounds().len() + POWERS.len() + 1
}

/// The rate of rejections of a wrong mean follows the normal distribution at powers 0.5 and 0.9.
#[test]
fn power_of_the_t_test_is_what_is_stated() {
    let [_, t, ..] = continuous();
    let level = 0.01;
    for power in POWERS {
        let effect = (normal_upper(level / 2.0) - normal_upper(power)) * t.unit;
        let name = format!("power {power} of {} with {N} values", t.name);
        let rejected = replicate(&name, |rng| (t.run)(rng, effect).p < level);
        assert_holds(&rate(
            &name,
            &rejected,
            normal_sf(normal_upper(level / 2.0) - effect / t.unit),
        ));
    }
}

/// A t test of values that each count four times: its standard error is half of the right one.
fn repeated(rng: &mut Stream) -> Outcome {
    let mut values = Values::new(0.5);
    for _ in 0..500 {
        let value = uniform(rng);
        (0..4).for_each(|_| values.push(value));
    }
    mean("repeated", &values, 0.5, Claim::Equal { delta: 1.0 })
}

/// Negative control: its rejection holds for any seed. One share of the budget is enough for both.
#[test]
fn a_wrong_statistic_is_seen() {
    let law = uniformity("calibration of repeated values", repeated);
    let happened = replicate("rate of repeated values", |rng| repeated(rng).p < LEVEL);
    for outcome in [law, rate("repeated values reject", &happened, LEVEL)] {
        assert_eq!(outcome.verdict(), Verdict::Fails, "{outcome}");
        assert!(
            !planned() || fault_objection(&outcome, 1.0).is_none(),
            "{:?}",
            fault_objection(&outcome, 1.0)
        );
    }
}
