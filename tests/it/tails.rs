//! Tails and quantiles against values of 25 digits and against each other.

use approx::assert_relative_eq;
use whitefurnace::harness::tails;

use crate::reference::{fields, number};
use crate::support::property;

fn evaluate(function: &str, a: &[f64]) -> f64 {
    match function {
        "normal_sf" => tails::normal_sf(a[0]),
        "normal_upper" => tails::normal_upper(a[0]),
        "student_two_sided" => tails::student_two_sided(a[0], a[1]),
        "chi_square_sf" => tails::chi_square_sf(a[0], a[1]),
        "f_sf" => tails::f_sf(a[0], a[1], a[2]),
        "kolmogorov_limit_sf" => tails::kolmogorov_limit_sf(a[0]),
        "kolmogorov_sf_body" => tails::kolmogorov_sf(a[0] as u64, a[1]),
        "binomial_sf" => tails::binomial_sf(a[0] as u64, a[1] as u64, a[2]),
        "binomial_cdf" => tails::binomial_cdf(a[0] as u64, a[1] as u64, a[2]),
        "poisson_sf" => tails::poisson_sf(a[0] as u64, a[1]),
        "poisson_cdf" => tails::poisson_cdf(a[0] as u64, a[1]),
        other => panic!("no function {other}"),
    }
}

#[test]
fn tails_agree_with_reference_values() {
    let mut wrong = Vec::new();
    for row in fields(include_str!("data/tails.csv")) {
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
            wrong.push(format!(
                "{function}{arguments:?}: {found:e}, should be {value:e}, error {error:e}"
            ));
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn student_and_kolmogorov_quantiles_undo_their_tails() {
    for p in [0.4, 1e-3, 5e-10, 1e-100] {
        for dof in [3.0, 40.0, 1e6] {
            let t = tails::student_upper(p, dof);
            assert_relative_eq!(
                0.5 * tails::student_two_sided(t, dof),
                p,
                max_relative = 1e-9
            );
        }
    }
    let d = tails::kolmogorov_upper(5000, 1e-9);
    assert_relative_eq!(tails::kolmogorov_sf(5000, d), 1e-9, max_relative = 1e-12);
}

#[test]
fn binomial_and_poisson_tails_sum_to_one() {
    property(
        "binomial tails",
        256,
        &(1_u64..5000, 0.0..1.0, 0.0..1.0),
        |(n, share, q)| {
            let k = (share * n as f64) as u64;
            let sum = tails::binomial_cdf(k, n, q) + tails::binomial_sf(k + 1, n, q);
            assert!((sum - 1.0).abs() < 1e-10, "{sum}");
            let sum = tails::poisson_cdf(k, q * 100.0) + tails::poisson_sf(k + 1, q * 100.0);
            assert!((sum - 1.0).abs() < 1e-10, "{sum}");
        },
    );
}

#[test]
fn clopper_pearson_ends_have_the_tails_they_promise() {
    let [low, high] = tails::binomial_interval(30, 1000, 1e-6);
    assert_relative_eq!(tails::binomial_sf(30, 1000, low), 1e-6, max_relative = 1e-6);
    assert_relative_eq!(
        tails::binomial_cdf(30, 1000, high),
        1e-6,
        max_relative = 1e-6
    );
    assert_eq!(tails::binomial_interval(0, 10, 1e-3)[0], 0.0);
    assert_eq!(tails::binomial_interval(10, 10, 1e-3)[1], 1.0);
}
