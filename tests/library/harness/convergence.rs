//! Tests of orders of convergence and ratios of variances against their definitions.

use whitefurnace::harness::convergence::{f_test, log_slope};

use super::*;

#[test]
fn slopes_are_drawn_through_the_mean_errors() {
    let sizes = [1.0, 10.0, 100.0, 1000.0];
    let errors = |factor: f64| -> Vec<f64> { sizes.iter().map(|n: &f64| factor / n).collect() };
    assert_relative_eq!(log_slope(&[1.0, 2.0, 8.0], &[5.0, 10.0, 40.0]), 1.0);
    // Residuals 1, −2, 1 are orthogonal to a line over equal steps.
    let e = std::f64::consts::E;
    let bent = [e, 1.0 / (e * e) / 100.0, e / 10_000.0];
    assert_relative_eq!(
        log_slope(&[1.0, 10.0, 100.0], &bent),
        -2.0,
        max_relative = 1e-12
    );
    let found = slope("order", &sizes, &[errors(1.0), errors(16.0)], -0.5, 0.1);
    assert_eq!((found.name.as_str(), found.n), ("order", 2));
    assert_relative_eq!(found.estimate, -1.0, max_relative = 1e-12);
    assert_eq!(found.reference, -0.5);
    assert_eq!(found.claim, Claim::Equivalent { margin: 0.1 });
    assert_eq!(found.cells.len(), 4);
    for (cell, n) in found.cells.iter().zip(sizes) {
        // Geometric means of 1/N and 16/N, and the line of slope −1/2 through their centre √1000.
        let centre = 1000_f64.sqrt();
        assert_cell(
            cell,
            &format!("N = {n}"),
            [4.0 / centre * (centre / n).sqrt(), 4.0 / n, cell.sigmas],
        );
    }
}

#[test]
fn the_interval_of_a_ratio_is_fiellers() {
    let (a, b) = (around(3.0, 0.5, 4000), around(2.5, 0.25, 1000));
    let found = variance_ratio("ratio", &a, &b, 1.25, 0.02);
    // The unbiased variance of n values one spread from their mean is n/(n − 1) spread².
    let [va, vb] = [0.25 / 3999.0, 0.0625 / 999.0];
    let distance = |ratio: f64| (3.0 - ratio * 2.5) / (va + ratio * ratio * vb).sqrt();
    assert_eq!(
        (found.name.as_str(), found.n, found.dof),
        ("ratio", 1000, Some(999.0))
    );
    assert_relative_eq!(found.value, distance(1.25), max_relative = 1e-9);
    assert_relative_eq!(
        found.p,
        student_two_sided(distance(1.25), 999.0),
        max_relative = 1e-6
    );
    assert_relative_eq!(found.estimate, 1.2, max_relative = 1e-12);
    assert_eq!(found.reference, 1.25);
    assert_relative_eq!(found.claim.size(), 0.025, max_relative = 1e-12);
    let Sensitivity::Normal {
        standard_error,
        dof,
        tests,
    } = found.sensitivity
    else {
        panic!("{:?}", found.sensitivity);
    };
    assert_relative_eq!(
        standard_error,
        (va + 1.25 * 1.25 * vb).sqrt() / 2.5,
        max_relative = 1e-9
    );
    assert_eq!((dof, tests), (999.0, 1));
    // The batches of each side are compared with those expected from the other side and the ratio.
    for (side, expected) in [("first, ", 1.25 * 2.5), ("second, ", 3.0 / 1.25)] {
        let mut cells = found
            .cells
            .iter()
            .filter(|cell| cell.place.starts_with(side));
        assert!(cells.clone().count() >= 10);
        assert!(cells.all(|cell| (cell.expected / expected - 1.0).abs() < 1e-12));
    }
    let critical = student_upper(ALPHA / 2.0, 999.0);
    let [low, high] = found.interval;
    assert_relative_eq!(distance(low), critical, max_relative = 1e-9);
    assert_relative_eq!(distance(high), -critical, max_relative = 1e-9);
    // A divisor that may be zero makes every ratio possible.
    let nothing = variance_ratio("ratio", &a, &around(0.001, 1.0, 1000), 1.0, 0.02);
    assert_eq!(nothing.interval, [f64::NEG_INFINITY, f64::INFINITY]);
}

#[test]
fn skewness_of_either_side_counts_for_a_ratio() {
    let rare = rare(1000);
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
        assert_relative_eq!(
            f_test([2.0 * f * 7.0, 7.0], [3, 5], 2.0),
            expected,
            max_relative = 1e-9
        );
        // Exchanging the sides gives the same result.
        assert_relative_eq!(
            f_test([7.0, 2.0 * f * 7.0], [5, 3], 0.5),
            expected,
            max_relative = 1e-9
        );
    }
}
