//! Tests of tails and quantiles against values of 25 digits and against each other.

use whitefurnace::harness::tails;

use crate::prelude::*;
use crate::reference::assert_table;

fn evaluate(function: &str, a: &[f64]) -> f64 {
    match function {
        "normal_sf" => tails::normal_sf(a[0]),
        "normal_upper" => tails::normal_upper(a[0]),
        "student_two_sided" => tails::student_two_sided(a[0], a[1]),
        "student_upper" => tails::student_upper(a[0], a[1]),
        "chi_square_sf" => tails::chi_square_sf(a[0], a[1]),
        "chi_square_upper" => tails::chi_square_upper(a[0], a[1]),
        "noncentral_chi_square_cdf" => tails::noncentral_chi_square_cdf(a[0], a[1], a[2]),
        "f_sf" => tails::f_sf(a[0], a[1], a[2]),
        "kolmogorov_limit_sf" => tails::kolmogorov_limit_sf(a[0]),
        "kolmogorov_sf_body" => tails::kolmogorov_sf(a[0] as u64, a[1]),
        "binomial_sf" => tails::binomial_sf(a[0] as u64, a[1] as u64, a[2]),
        "binomial_cdf" => tails::binomial_cdf(a[0] as u64, a[1] as u64, a[2]),
        "binomial_two_sided" => tails::binomial_two_sided(a[0] as u64, a[1] as u64, a[2]),
        "binomial_low" => tails::binomial_interval(a[0] as u64, a[1] as u64, a[2])[0],
        "binomial_high" => tails::binomial_interval(a[0] as u64, a[1] as u64, a[2])[1],
        "poisson_sf" => tails::poisson_sf(a[0] as u64, a[1]),
        "poisson_cdf" => tails::poisson_cdf(a[0] as u64, a[1]),
        "poisson_low" => tails::poisson_interval(a[0] as u64, a[1])[0],
        "poisson_high" => tails::poisson_interval(a[0] as u64, a[1])[1],
        "gamma_p" => tails::gamma_p(a[0], a[1]),
        "gamma_q" => tails::gamma_q(a[0], a[1]),
        "beta" => tails::beta(a[0], a[1], a[2], a[3]),
        other => panic!("no function {other}"),
    }
}

#[test]
fn tails_agree_with_reference_values() {
    assert_table(include_str!("../data/tails.csv"), evaluate);
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

/// Below the switch the p-value is an upper bound; the quantile inverts it.
#[test]
fn kolmogorov_quantiles_undo_the_tail() {
    let d = tails::kolmogorov_upper(5000, 1e-9);
    assert_relative_eq!(tails::kolmogorov_sf(5000, d), 1e-9, max_relative = 1e-12);
    let below = tails::kolmogorov_upper(1000, tails::KOLMOGOROV_BOUND_LEVEL);
    assert!(tails::kolmogorov_sf(1000, below) <= tails::KOLMOGOROV_BOUND_LEVEL);
}
