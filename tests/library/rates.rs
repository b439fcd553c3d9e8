//! Orders of convergence, ratios of variances and sequential tests, against their definitions.

use approx::assert_relative_eq;
use whitefurnace::harness::convergence::{f_test, log_slope, slope, variance_ratio};
use whitefurnace::harness::mean::{Sigma, Values, skewness_of_sum};
use whitefurnace::harness::outcome::{ALPHA, Claim};
use whitefurnace::harness::power::Sensitivity;
use whitefurnace::harness::sequential::{ConfidenceSequence, Decision, Sprt};
use whitefurnace::harness::tails::{student_two_sided, student_upper};

#[test]
fn slopes_are_drawn_through_the_mean_errors() {
    let sizes = [1.0, 10.0, 100.0, 1000.0];
    let errors = |factor: f64| -> Vec<f64> { sizes.iter().map(|n: &f64| factor / n).collect() };
    assert_relative_eq!(log_slope(&[1.0, 2.0, 8.0], &[5.0, 10.0, 40.0]), 1.0);
    // Residuals 1, −2, 1 are orthogonal to a line over equal steps.
    let e = std::f64::consts::E;
    let bent = [e, 1.0 / (e * e) / 100.0, e / 10_000.0];
    assert_relative_eq!(log_slope(&[1.0, 10.0, 100.0], &bent), -2.0, max_relative = 1e-12);
    let found = slope("order", &sizes, &[errors(1.0), errors(16.0)], -0.5, 0.1);
    assert_eq!((found.name.as_str(), found.n), ("order", 2));
    assert_relative_eq!(found.estimate, -1.0, max_relative = 1e-12);
    assert_eq!(found.reference, -0.5);
    assert_eq!(found.claim, Claim::Approximate { margin: 0.1 });
    assert_eq!(found.cells.len(), 4);
    for (cell, n) in found.cells.iter().zip(sizes) {
        assert_eq!(cell.place, format!("N = {n}"));
        // Geometric means of 1/N and 16/N, and the line of slope −1/2 through their centre √1000.
        assert_relative_eq!(cell.observed, 4.0 / n, max_relative = 1e-12);
        let centre = 1000_f64.sqrt();
        let line = 4.0 / centre * (centre / n).sqrt();
        assert_relative_eq!(cell.expected, line, max_relative = 1e-12);
    }
}

/// n values with the given mean that lie `spread` above and below it.
fn around(mean: f64, spread: f64, n: u64) -> Values {
    let mut side = -1.0;
    Values::collect(mean, n, || {
        side = -side;
        mean + side * spread
    })
}

#[test]
fn the_interval_of_a_ratio_is_fiellers() {
    let (a, b) = (around(3.0, 0.5, 4000), around(2.5, 0.25, 1000));
    let found = variance_ratio("ratio", &a, &b, 1.25, 0.02);
    // The unbiased variance of n values one spread from their mean is n/(n − 1) spread².
    let [va, vb] = [0.25 / 3999.0, 0.0625 / 999.0];
    let distance = |ratio: f64| (3.0 - ratio * 2.5) / (va + ratio * ratio * vb).sqrt();
    assert_eq!((found.name.as_str(), found.n, found.dof), ("ratio", 1000, Some(999.0)));
    assert_relative_eq!(found.value, distance(1.25), max_relative = 1e-9);
    assert_relative_eq!(found.p, student_two_sided(distance(1.25), 999.0), max_relative = 1e-6);
    assert_relative_eq!(found.estimate, 1.2, max_relative = 1e-12);
    assert_eq!(found.reference, 1.25);
    assert_relative_eq!(found.claim.size(), 0.025, max_relative = 1e-12);
    let Sensitivity::Normal { standard_error, dof, tests } = found.sensitivity else {
        panic!("{:?}", found.sensitivity);
    };
    let error = (va + 1.25 * 1.25 * vb).sqrt() / 2.5;
    assert_relative_eq!(standard_error, error, max_relative = 1e-9);
    assert_eq!((dof, tests), (999.0, 1));
    // Each side's batches are held to what the other side and the ratio make of it.
    for (side, expected) in [("first, ", 1.25 * 2.5), ("second, ", 3.0 / 1.25)] {
        let mut cells = found.cells.iter().filter(|cell| cell.place.starts_with(side));
        assert!(cells.clone().count() >= 10);
        assert!(cells.all(|cell| (cell.expected / expected - 1.0).abs() < 1e-12));
    }
    let critical = student_upper(ALPHA / 2.0, 999.0);
    let [low, high] = found.interval;
    assert_relative_eq!(distance(low), critical, max_relative = 1e-9);
    assert_relative_eq!(distance(high), -critical, max_relative = 1e-9);
    // A divisor that may be zero leaves every ratio possible.
    let nothing = variance_ratio("ratio", &a, &around(0.001, 1.0, 1000), 1.0, 0.02);
    assert_eq!(nothing.interval, [f64::NEG_INFINITY, f64::INFINITY]);
}

#[test]
fn skewness_of_either_side_counts_for_a_ratio() {
    let mut i = 0;
    let rare = Values::collect(0.01, 1000, || {
        i += 1;
        f64::from(u8::from(i % 100 == 0))
    });
    let even = around(2.0, 0.25, 1000);
    let from = |a, b, ratio| variance_ratio("ratio", a, b, ratio, 0.02).valid_from as f64;
    let part = |v: &Values, ratio: f64| (v.skewness(), ratio * ratio * v.moments.variance(), 1);
    for ratio in [0.1, 1.0, 7.0] {
        for (a, b) in [(&rare, &even), (&even, &rare)] {
            let skewness = skewness_of_sum([part(a, 1.0), part(b, ratio)]);
            let expected = Sigma::Estimated.valid_from(1, skewness, ALPHA) as f64;
            assert_relative_eq!(from(a, b, ratio), expected, max_relative = 1e-3);
        }
    }
    assert!(from(&rare, &even, 0.1) > 1e6 && from(&even, &rare, 0.1) < 100.0);
}

#[test]
fn the_f_test_has_closed_forms() {
    // Two degrees of freedom above: P(F ≥ f) = (1 + 2f/d)^(−d/2).
    for f in [0.1, 0.5, 3.0, 6.0] {
        let upper: f64 = (1.0 + 2.0 * f / 4.0_f64).powi(-2);
        let expected = 2.0 * upper.min(1.0 - upper);
        let found = f_test((2.0 * f * 7.0, 3), (7.0, 5), 2.0);
        assert_relative_eq!(found, expected, max_relative = 1e-9);
        // The same question asked the other way round.
        let back = f_test((7.0, 5), (2.0 * f * 7.0, 3), 0.5);
        assert_relative_eq!(back, expected, max_relative = 1e-9);
    }
}

/// How many equal steps a test takes to its decision, and that decision.
fn steps(mut test: Sprt, mut step: impl FnMut(&mut Sprt) -> Decision) -> (u64, Decision) {
    while step(&mut test) == Decision::Continue {}
    // Further values change nothing.
    assert_eq!(step(&mut test), test.decision());
    (test.count(), test.decision())
}

#[test]
fn likelihood_ratios_are_those_of_the_laws() {
    let new = || Sprt::new(1e-4, 1e-6);
    let needed = |log: f64, threshold: f64| (threshold.ln() / log).abs().ceil() as u64;
    for (null, alternative) in [(0.2, 0.3), (0.5, 0.25)] {
        for success in [true, false] {
            let of = |q: f64| if success { q } else { 1.0 - q };
            let log = (of(alternative) / of(null)).ln();
            let expected = if log > 0.0 {
                (needed(log, 1e-4), Decision::Alternative)
            } else {
                (needed(log, 1e-6), Decision::Null)
            };
            let found = steps(new(), |test| test.bernoulli(success, null, alternative));
            assert_eq!(found, expected, "{null} {alternative} {success}");
        }
    }
    // Half the difference of squared distances, in units of the variance.
    for (value, null, alternative, sigma) in
        [(2.5, 1.0, 3.0, 4.0), (1.5, 1.0, 3.0, 4.0), (-2.0, 1.5, 0.5, 3.0)]
    {
        let square = |mean: f64| ((value - mean) / sigma).powi(2);
        let log: f64 = 0.5 * (square(null) - square(alternative));
        let expected = if log > 0.0 {
            (needed(log, 1e-4), Decision::Alternative)
        } else {
            (needed(log, 1e-6), Decision::Null)
        };
        let found = steps(new(), |test| test.normal(value, null, alternative, sigma));
        assert_eq!(found, expected, "{value} {null} {alternative}");
    }
}

#[test]
fn a_decision_is_reached_at_the_threshold_itself() {
    // Ratios of 4 and 1/4 against thresholds of 4 and 1/4.
    let new = || Sprt::new(0.25, 0.25);
    assert_eq!(new().decision(), Decision::Continue);
    assert_eq!(new().bernoulli(true, 0.125, 0.5), Decision::Alternative);
    assert_eq!(new().bernoulli(true, 0.5, 0.125), Decision::Null);
}

/// The interval of theorem 2 after all values of [0, 1], with every sum taken anew.
fn empirical_bernstein_sequence(alpha: f64, x: &[f64]) -> [f64; 2] {
    let log = (2.0 / alpha).ln();
    let mean = |t: usize| (0.5 + x[..t].iter().sum::<f64>()) / (t as f64 + 1.0);
    let variance = |t: usize| {
        let squares: f64 = (0..t).map(|i| (x[i] - mean(i + 1)).powi(2)).sum();
        (0.25 + squares) / (t as f64 + 1.0)
    };
    let bet = |i: usize| {
        let t = i as f64 + 1.0;
        f64::min(0.5, (2.0 * log / (variance(i) * t * (t + 1.0).ln())).sqrt())
    };
    let psi = |bet: f64| (-(1.0 - bet).ln() - bet) / 4.0;
    let (mut weights, mut weighted, mut penalty) = (0.0, 0.0, 0.0);
    for (i, x) in x.iter().enumerate() {
        let bet = bet(i);
        weights += bet;
        weighted += bet * x;
        penalty += 4.0 * (x - mean(i)).powi(2) * psi(bet);
    }
    let half = (log + penalty) / weights;
    [weighted / weights - half, weighted / weights + half]
}

#[test]
fn confidence_sequences_are_those_of_the_theorem() {
    // Bets are cut off at first and free later on.
    let x: Vec<f64> = (0..300).map(|i| f64::from(i * i % 17) / 20.0).collect();
    let [low, high] = [-1.0, 3.0];
    let mut sequence = ConfidenceSequence::new(0.05, [low, high]);
    assert_eq!((sequence.interval(), sequence.count()), ([low, high], 0));
    for (i, &value) in x.iter().enumerate() {
        sequence.push(low + (high - low) * value);
        assert_eq!(sequence.count(), i as u64 + 1);
        let [left, right] = sequence.interval();
        assert_eq!(sequence.minimum_detectable_effect(), right - left);
        if [0, 1, 9, 299].contains(&i) {
            let expected = empirical_bernstein_sequence(0.05, &x[..=i]);
            for (found, expected) in sequence.interval().iter().zip(expected) {
                assert_relative_eq!(*found, low + (high - low) * expected, max_relative = 1e-9);
            }
        }
    }
}

#[test]
fn a_sequence_decides_at_its_borders() {
    // Before any value the interval is [0, 2].
    let decide =
        |reference, margin| ConfidenceSequence::new(0.05, [0.0, 2.0]).decide(reference, margin);
    for (reference, margin, expected) in [
        (1.0, 1.0, Decision::Null),
        (2.0, 2.0, Decision::Null),
        (0.0, 2.0, Decision::Null),
        (0.0, 1.0, Decision::Continue),
        (2.0, 1.0, Decision::Continue),
        (1.0, 0.5, Decision::Continue),
        (2.5, 9.0, Decision::Alternative),
        (-0.5, 9.0, Decision::Alternative),
    ] {
        assert_eq!(decide(reference, margin), expected, "{reference} ± {margin}");
    }
}
