//! Tails and quantiles against values of 25 digits and against each other.

use whitefurnace::harness::tails;

use super::*;
use crate::reference::{fields, number};

fn evaluate(function: &str, a: &[f64]) -> f64 {
    match function {
        "normal_sf" => normal_sf(a[0]),
        "normal_upper" => normal_upper(a[0]),
        "student_two_sided" => student_two_sided(a[0], a[1]),
        "chi_square_sf" => chi_square_sf(a[0], a[1]),
        "f_sf" => tails::f_sf(a[0], a[1], a[2]),
        "kolmogorov_limit_sf" => tails::kolmogorov_limit_sf(a[0]),
        "kolmogorov_sf_body" => tails::kolmogorov_sf(a[0] as u64, a[1]),
        "binomial_sf" => binomial_sf(a[0] as u64, a[1] as u64, a[2]),
        "binomial_cdf" => binomial_cdf(a[0] as u64, a[1] as u64, a[2]),
        "poisson_sf" => poisson_sf(a[0] as u64, a[1]),
        "poisson_cdf" => poisson_cdf(a[0] as u64, a[1]),
        other => panic!("no function {other}"),
    }
}

#[test]
fn tails_agree_with_reference_values() {
    let mut wrong = Vec::new();
    for row in fields(include_str!("../data/tails.csv")) {
        let (function, value) = (row[0], number(row[2]));
        let arguments: Vec<f64> = row[1].split(' ').map(number).collect();
        let found = evaluate(function, &arguments);
        // The finite-n Kolmogorov law is a corrected limit law with a stated absolute error of 1e-3.
        let error = if function == "kolmogorov_sf_body" {
            (found - value).abs() * (1e-9 / 1e-3)
        } else {
            (found / value - 1.0).abs()
        };
        if error.is_nan() || error > 1e-9 {
            wrong.push(format!("{function}{arguments:?}: {found:e}, should be {value:e}, error {error:e}"));
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn quantiles_undo_their_tails() {
    for p in [0.9, 0.4, 1e-3, 5e-10, 1e-100] {
        // The macro's absolute tolerance would hide everything about the last p.
        let close = |tail: f64, dof: f64| {
            assert!((tail / p - 1.0).abs() < 1e-9, "{p:e} {dof}: {tail:e}");
        };
        for dof in [3.0, 40.0, 1e6] {
            if p < 0.5 {
                close(0.5 * student_two_sided(student_upper(p, dof), dof), dof);
            }
        }
        for dof in [1.0, 32.0, 50.0, 1000.0] {
            close(chi_square_sf(tails::chi_square_upper(p, dof), dof), dof);
        }
        // Two degrees: the tail is exp(−x/2).
        let x = tails::chi_square_upper(p, 2.0);
        assert_relative_eq!(x, -2.0 * f64::ln(p), max_relative = 1e-12);
    }
    let d = tails::kolmogorov_upper(5000, 1e-9);
    assert_relative_eq!(tails::kolmogorov_sf(5000, d), 1e-9, max_relative = 1e-12);
}

#[test]
fn binomial_and_poisson_tails_sum_to_one() {
    property("binomial tails", 256, &(1_u64..5000, 0.0..1.0, 0.0..1.0), |(n, share, q)| {
        let k = (share * n as f64) as u64;
        let sum = binomial_cdf(k, n, q) + binomial_sf(k + 1, n, q);
        assert!((sum - 1.0).abs() < 1e-10, "{sum}");
        let sum = poisson_cdf(k, q * 100.0) + poisson_sf(k + 1, q * 100.0);
        assert!((sum - 1.0).abs() < 1e-10, "{sum}");
    });
}

#[test]
fn clopper_pearson_ends_have_the_tails_they_promise() {
    let [low, high] = tails::binomial_interval(30, 1000, 1e-6);
    assert_relative_eq!(binomial_sf(30, 1000, low), 1e-6, max_relative = 1e-6);
    assert_relative_eq!(binomial_cdf(30, 1000, high), 1e-6, max_relative = 1e-6);
    assert_eq!(tails::binomial_interval(0, 10, 1e-3)[0], 0.0);
    assert_eq!(tails::binomial_interval(10, 10, 1e-3)[1], 1.0);
}

#[test]
fn tails_at_the_ends_of_their_ranges() {
    assert_relative_eq!(normal_upper(0.9), -normal_upper(0.1));
    assert_eq!(normal_upper(0.5), 0.0);
    for x in [0.0, -1.0] {
        assert_eq!(tails::kolmogorov_limit_sf(x), 1.0);
        assert_eq!((tails::gamma_p(2.5, x), tails::gamma_q(2.5, x)), (0.0, 1.0));
        assert_eq!(tails::beta(2.0, 3.0, x, 1.0), 0.0);
        assert_eq!(tails::beta(2.0, 3.0, 1.0, x), 1.0);
        assert_eq!(binomial_sf(3, 10, x), 0.0);
    }
    assert_eq!(student_two_sided(0.0, 5.0), 1.0);
    assert_eq!(student_two_sided(f64::NEG_INFINITY, 5.0), 0.0);
    assert!(student_two_sided(f64::NAN, 5.0).is_nan());
    assert_eq!(binomial_sf(0, 10, 0.3), 1.0);
    assert_eq!(binomial_sf(11, 10, 0.3), 0.0);
    assert_relative_eq!(binomial_sf(10, 10, 0.5), 0.5_f64.powi(10));
    assert_eq!(binomial_cdf(10, 10, 0.3), 1.0);
    assert_relative_eq!(binomial_cdf(0, 10, 0.5), 0.5_f64.powi(10));
    assert_eq!(binomial_two_sided(5, 10, 0.5), 1.0);
    assert_eq!(poisson_sf(0, 3.0), 1.0);
    // Leading terms of tails far below the resolution of 1: n q, λ³/6, and t⁻³ √12/π of three degrees.
    for (found, expected) in [
        (binomial_sf(1, 5, 1e-30), 5e-30),
        (poisson_sf(3, 1e-30), 1e-90 / 6.0),
        (student_two_sided(1e20, 3.0), 2.0 * 12_f64.sqrt() / (PI * 1e60)),
    ] {
        assert!((found / expected - 1.0).abs() < 1e-9, "{found:e} {expected:e}");
    }
    // Below the switch the p-value is a bound that never exceeds it.
    let below = tails::kolmogorov_upper(1000, tails::KOLMOGOROV_SWITCH);
    assert!(tails::kolmogorov_sf(1000, below) <= tails::KOLMOGOROV_SWITCH);
}

/// Both methods for each function, on either side of where one takes over from the other.
#[test]
fn tails_have_closed_forms() {
    for x in [0.05, 0.7, 1.9, 2.1, 4.0, 9.0, 80.0] {
        let exp = f64::exp(-0.5 * x);
        let close = |found: f64, expected: f64| {
            assert!((found / expected - 1.0).abs() < 1e-10, "{x}: {found:e} {expected:e}");
        };
        close(chi_square_sf(x, 2.0), exp);
        close(chi_square_sf(x, 4.0), exp * (1.0 + 0.5 * x));
        close(tails::gamma_p(1.0, x), -(-x).exp_m1());
        close(tails::gamma_p(1.0, x) + tails::gamma_q(1.0, x), 1.0);
        close(tails::gamma_p(30.0, x) + tails::gamma_q(30.0, x), 1.0);
        // One degree of freedom is Cauchy's law, two have a root.
        close(student_two_sided(x, 1.0), 2.0 * (1.0 / x).atan() / PI);
        let root = (2.0 + x * x).sqrt();
        close(student_two_sided(-x, 2.0), 2.0 / (root * (root + x)));
        close(tails::f_sf(x, 2.0, 6.0), (1.0 + x / 3.0).powi(-3));
        close(tails::beta(3.5, 1.0, x / 100.0, 1.0 - x / 100.0), (x / 100.0).powf(3.5));
    }
}

/// Where five terms of Stirling's series take over, the fifth is 1e-14 of the tail.
#[test]
fn tails_keep_fourteen_digits() {
    for (k, mean) in [(15_u64, 17.5), (15, 30.0), (16, 18.5), (19, 24.0)] {
        // exp(−m) Σ mʲ/j! over the first counts.
        let term = |j: u64| (1..=j).fold(1.0, |product, i| product * mean / i as f64);
        let expected = f64::exp(-mean) * (0..=k).map(term).sum::<f64>();
        assert_relative_eq!(poisson_cdf(k, mean), expected, max_relative = 1e-14, epsilon = 0.0);
    }
}

/// P(½, x) is erf √x, close to 2 √(x/π) for small x.
#[test]
fn small_arguments_are_summed_up() {
    let expected = 2e-10 / PI.sqrt();
    let found = tails::gamma_p(0.5, 1e-20);
    assert!((found / expected - 1.0).abs() < 1e-12, "{found:e}");
    assert!((tails::gamma_q(0.5, 1e-20) - (1.0 - expected)).abs() < 1e-15);
    // Cauchy's law in the middle: 1 − 2t/π.
    let found = student_two_sided(1e-8, 1.0);
    assert!((found - (1.0 - 2e-8 / PI)).abs() < 1e-15);
}
