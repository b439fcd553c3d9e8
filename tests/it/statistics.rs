//! The statistics' own code, tested exactly: tails against values of 25 digits.

use whitefurnace::harness::tails;

/// One line of `data/tails.csv`.
struct Row {
    function: &'static str,
    arguments: Vec<f64>,
    value: f64,
}

fn rows() -> impl Iterator<Item = Row> {
    include_str!("data/tails.csv")
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| {
            let mut fields = line.split(',');
            let mut next = || fields.next().expect("three fields");
            Row {
                function: next(),
                arguments: next()
                    .split(' ')
                    .map(|x| x.parse().expect("number"))
                    .collect(),
                value: next().parse().expect("number"),
            }
        })
}

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
    for row in rows() {
        let found = evaluate(row.function, &row.arguments);
        // The finite-n Kolmogorov law is a corrected limit law with a stated absolute error.
        let error = if row.function == "kolmogorov_sf_body" {
            (found - row.value).abs() * (1e-9 / 1e-3)
        } else {
            (found / row.value - 1.0).abs()
        };
        if error.is_nan() || error > 1e-9 {
            wrong.push(format!(
                "{}{:?}: {found:e}, should be {:e}, error {error:e}",
                row.function, row.arguments, row.value
            ));
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}
