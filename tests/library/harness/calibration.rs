//! Error rates and power of the statistics, measured at a small size over replications with streams of
//! their own. Bounds are valid at 1e-9; what is compared goes through the guard, and wrong statistics are seen.

use rayon::prelude::*;

use super::*;

const REPLICATIONS: u32 = 2000;

/// One result per replication, each with a stream of its own.
fn replicate<T: Send>(name: &str, run: impl Fn(&mut Stream) -> T + Sync) -> Vec<T> {
    let seed = context(name).seed_of("replications");
    (0..REPLICATIONS).into_par_iter().map(|i| run(&mut stream(seed, i, 0))).collect()
}

/// An effect of this size on a law or a rate is seen for certain with so many replications.
const SEEN: f64 = 0.15;

/// Asserts that an outcome at this size holds, and that the guard lets it through.
fn assert_holds(outcome: &Outcome) {
    assert_eq!(may_not_hold(outcome), None);
    let Outcome { name, worst, .. } = outcome;
    assert_eq!(outcome.verdict(), Verdict::Holds, "{name}: {worst}");
}

/// Whether p-values are uniform, as those of a true hypothesis are, up to what the statistic's own
/// approximations allow.
fn uniformity(name: &str, run: impl Fn(&mut Stream) -> Outcome + Sync) -> Outcome {
    let mut p: Vec<f64> = replicate(name, |rng| run(rng).p);
    kolmogorov_smirnov(name, &mut p, |p| p, SEEN)
}

/// How often something happened, against a rate.
fn rate(name: &str, happened: &[bool], rate: f64) -> Outcome {
    let k = happened.iter().filter(|&&h| h).count() as u64;
    binomial(name, k, happened.len() as u64, rate, SEEN)
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
    ("Welch", |rng| welch("w", &uniforms(rng, 1000), &uniforms(rng, 3000), ANY)),
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
        assert_holds(&uniformity(&format!("calibration of {name}"), statistic));
    }
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
    ("SPRT rejects a true hypothesis", LEVEL, |rng| sprt(rng, 0.5, Decision::Alternative)),
    ("SPRT accepts a false hypothesis", LEVEL, |rng| sprt(rng, 0.6, Decision::Null)),
    // Just at the margin: at level 1e-9, practically never.
    ("equivalence concluded at the very margin", ALPHA, |rng| {
        mean("e", &uniforms(rng, 500), 0.45, Claim::Approximate { margin: 0.05 }).verdict() == Verdict::Holds
    }),
];

#[test]
fn statistics_that_only_promise_a_bound_keep_it() {
    for (name, promised, happened) in PROMISES {
        let found = rate(name, &replicate(name, happened), promised);
        // Fewer are no fault: the upper side alone is tested, where an effect is seen as well.
        assert!(found.sensitivity.miss(SEEN) <= ALPHA, "{name}");
        let p = binomial_sf(found.value as u64, found.n, promised);
        assert!(p >= ALPHA, "{}, at most {promised} claimed", found.worst);
    }
}

/// Powers at which the stated curve is checked.
const POWERS: [f64; 2] = [0.5, 0.9];

/// How many assertions of this module chance can turn.
pub const ASSERTIONS: usize = CONTINUOUS.len() + PROMISES.len() + POWERS.len() + 1;

/// The share of rejections of a wrong mean is what the normal law says, where power is 0.5 and 0.9.
#[test]
fn power_of_the_t_test_is_what_is_stated() {
    let level = 0.01;
    let n = 4000_u64;
    let standard_error = (1.0 / 12.0 / n as f64).sqrt();
    for power in POWERS {
        let effect = (normal_upper(level / 2.0) - normal_upper(power)) * standard_error;
        let rejected =
            replicate(&format!("power {power}"), |rng| mean("t", &uniforms(rng, n), 0.5 + effect, ANY).p < level);
        let stated = normal_sf(normal_upper(level / 2.0) - effect / standard_error);
        assert_holds(&rate(&format!("power {power}"), &rejected, stated));
    }
}

/// A t test of values that each count four times: its standard error is half of what it should be.
fn repeated(rng: &mut Stream) -> Outcome {
    let mut values = Values::new(0.5);
    for _ in 0..500 {
        let value = uniform(rng);
        (0..4).for_each(|_| values.push(value));
    }
    mean("repeated", &values, 0.5, ANY)
}

/// The negative control: no seed takes its rejection back. One share of the budget is enough for both.
#[test]
fn a_wrong_statistic_is_seen() {
    let law = uniformity("calibration of repeated values", repeated);
    let happened = replicate("rate of repeated values", |rng| repeated(rng).p < LEVEL);
    for outcome in [law, rate("repeated values reject", &happened, LEVEL)] {
        assert_eq!(may_hold(&outcome), None);
    }
}
