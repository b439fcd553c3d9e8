//! Error rates and power of the statistics, measured at a small size over replications with streams of
//! their own. Bounds are valid at 1e-9.

use rayon::prelude::*;
use whitefurnace::harness::chi_square::{binomial, chi_square, count};
use whitefurnace::harness::domain::{Domain, Partition};
use whitefurnace::harness::ks::kolmogorov_smirnov;
use whitefurnace::harness::mean::{Values, bounded_mean, mean, welch};
use whitefurnace::harness::outcome::{ALPHA, Claim, Outcome, Verdict};
use whitefurnace::harness::sequential::{ConfidenceSequence, Decision, Sprt};
use whitefurnace::harness::tails::{binomial_sf, binomial_two_sided, normal_sf, normal_upper};
use whitefurnace::rng::{Stream, stream, uniform, uniform2};
use whitefurnace::sampling::uniform_hemisphere;

use crate::support::context;

const REPLICATIONS: u32 = 2000;

/// One result per replication, each with a stream of its own.
fn replicate<T: Send>(name: &str, run: impl Fn(&mut Stream) -> T + Sync) -> Vec<T> {
    let seed = context(name).seed_of("replications");
    (0..REPLICATIONS)
        .into_par_iter()
        .map(|i| run(&mut stream(seed, i, 0)))
        .collect()
}

/// p-values of a true hypothesis are uniform, up to what the statistic's own approximations allow.
fn assert_uniform(name: &str, run: impl Fn(&mut Stream) -> Outcome + Sync) {
    let mut p: Vec<f64> = replicate(name, |rng| run(rng).p);
    let outcome = kolmogorov_smirnov(name, &mut p, |p| p, 1.0);
    assert!(outcome.p >= ALPHA, "{name}: {}", outcome.worst);
}

const ANY: Claim = Claim::Exact { delta: 1.0 };

fn uniforms(rng: &mut Stream, n: u64) -> Values {
    Values::collect(0.5, n, || uniform(rng))
}

/// What is done in one replication, with its own stream.
type Replication<T> = fn(&mut Stream) -> T;

/// Statistics of continuous variables, under a true hypothesis.
const CONTINUOUS: [(&str, Replication<Outcome>); 4] = [
    ("t", |rng| mean("t", &uniforms(rng, 2000), 0.5, ANY)),
    ("Welch", |rng| {
        welch("w", &uniforms(rng, 1000), &uniforms(rng, 3000), ANY)
    }),
    ("Kolmogorov", |rng| {
        let mut values: Vec<f64> = (0..2000).map(|_| uniform(rng)).collect();
        kolmogorov_smirnov("ks", &mut values, |x| x, 1.0)
    }),
    ("chi-square", |rng| {
        let partition = Partition::equal(Domain::Hemisphere, 3, 4);
        let sample = || Some(uniform_hemisphere(uniform2(rng)));
        let counts = count(&partition, 24_000, sample, |_| true);
        chi_square("cells", &partition, &counts, 1.0)
    }),
];

#[test]
fn p_values_of_true_hypotheses_are_uniform() {
    for (name, statistic) in CONTINUOUS {
        assert_uniform(&format!("calibration of {name}"), statistic);
    }
}

/// How often something happens is what is claimed, at most.
fn assert_rate_at_most(name: &str, happened: &[bool], rate: f64) {
    let k = happened.iter().filter(|&&h| h).count() as u64;
    let p = binomial_sf(k, happened.len() as u64, rate);
    assert!(
        p >= ALPHA,
        "{name}: {k} of {}, at most {rate} claimed",
        happened.len()
    );
}

/// The level at which promises are checked.
const LEVEL: f64 = 0.05;

/// A test of 1/2 against 0.6 with errors of [`LEVEL`]: whether it ends with `wrong`.
fn sprt(rng: &mut Stream, truth: f64, wrong: Decision) -> bool {
    let mut test = Sprt::new(LEVEL, LEVEL);
    while test.bernoulli(uniform(rng) < truth, 0.5, 0.6) == Decision::Continue {}
    test.decision() == wrong
}

/// What must not happen, and how often it may at most.
const PROMISES: [(&str, f64, Replication<bool>); 6] = [
    ("empirical Bernstein rejects a true mean", LEVEL, |rng| {
        bounded_mean("b", &uniforms(rng, 500), 0.5, [0.0, 1.0], ANY).p < LEVEL
    }),
    ("binomial test rejects a true share", LEVEL, |rng| {
        let k = (0..500).filter(|_| uniform(rng) < 0.3).count() as u64;
        binomial("k", k, 500, 0.3, 1.0).p < LEVEL
    }),
    ("confidence sequence ever excludes the mean", LEVEL, |rng| {
        let mut sequence = ConfidenceSequence::new(LEVEL, [0.0, 1.0]);
        // Looking after every value must not cost anything.
        (0..1000).any(|_| {
            sequence.push(uniform(rng));
            sequence.decide(0.5, 0.0) == Decision::Alternative
        })
    }),
    ("SPRT rejects a true hypothesis", LEVEL, |rng| {
        sprt(rng, 0.5, Decision::Alternative)
    }),
    ("SPRT accepts a false hypothesis", LEVEL, |rng| {
        sprt(rng, 0.6, Decision::Null)
    }),
    // Just at the margin: at level 1e-9, practically never.
    ("equivalence concluded at the very margin", ALPHA, |rng| {
        let claim = Claim::Approximate { margin: 0.05 };
        mean("e", &uniforms(rng, 500), 0.45, claim).verdict() == Verdict::Holds
    }),
];

#[test]
fn statistics_that_only_promise_a_bound_keep_it() {
    for (name, rate, happened) in PROMISES {
        assert_rate_at_most(name, &replicate(name, happened), rate);
    }
}

/// Powers at which the stated curve is checked.
const POWERS: [f64; 2] = [0.5, 0.9];

/// How many assertions of this module chance can turn.
pub const ASSERTIONS: usize = CONTINUOUS.len() + PROMISES.len() + POWERS.len();

/// The share of rejections of a wrong mean is what the normal law says, where power is 0.5 and 0.9.
#[test]
fn power_of_the_t_test_is_what_is_stated() {
    let level = 0.01;
    let n = 4000_u64;
    let standard_error = (1.0 / 12.0 / n as f64).sqrt();
    for power in POWERS {
        let effect = (normal_upper(level / 2.0) - normal_upper(power)) * standard_error;
        let rejected = replicate(&format!("power {power}"), |rng| {
            mean("t", &uniforms(rng, n), 0.5 + effect, ANY).p < level
        });
        let k = rejected.iter().filter(|&&r| r).count() as u64;
        let stated = normal_sf(normal_upper(level / 2.0) - effect / standard_error);
        let p = binomial_two_sided(k, u64::from(REPLICATIONS), stated);
        assert!(
            p >= ALPHA,
            "{k} of {REPLICATIONS} rejected, power {stated} stated"
        );
    }
}
