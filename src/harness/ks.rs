//! Kolmogorov-Smirnov test of one-dimensional distributions.

use super::graded::grade;
use super::outcome::{ALPHA, Cell, Claim, Outcome};
use super::power::Sensitivity;
use super::tails::{kolmogorov_sf, kolmogorov_upper};

/// Number of points of the two distribution functions kept for the data file.
const MAX_POINTS: usize = 64;

/// Tests whether independent values follow the distribution with the continuous distribution
/// function `cdf`.
///
/// The estimate is D, the largest distance between the two distribution functions; the claim is
/// that the distribution's own distance is at most `delta`. Massart's inequality gives the interval
/// and the far tail (see [`kolmogorov_sf`]). Values are sorted in place.
pub fn kolmogorov_smirnov(
    name: &str,
    values: &mut [f64],
    cdf: impl Fn(f64) -> f64,
    delta: f64,
) -> Outcome {
    values.sort_by(f64::total_cmp);
    grade(ks_test(name, values, &cdf, delta), |effect| {
        // The uniform numbers cdf(x), bent so that their distribution is off by the effect at one
        // half.
        let perturbed: Vec<f64> = values.iter().map(|&x| perturbed(cdf(x), effect)).collect();
        let uniform = |u: f64| u.clamp(0.0, 1.0);
        Some(ks_test(name, &perturbed, &uniform, delta))
    })
}

/// Maps a uniform number to one with density constant on either half of [0, 1] and probability
/// 1/2 + effect in the lower: the distribution functions differ most at the middle.
fn perturbed(u: f64, effect: f64) -> f64 {
    let lower = (0.5 + effect).clamp(0.0, 1.0);
    if u < lower {
        0.5 * u / lower
    } else {
        0.5 + 0.5 * (u - lower) / (1.0 - lower).max(f64::MIN_POSITIVE)
    }
}

/// Returns the statistic of sorted values.
fn ks_test(name: &str, values: &[f64], cdf: &impl Fn(f64) -> f64, delta: f64) -> Outcome {
    let count = values.len() as u64;
    let n = values.len() as f64;
    let (mut d, mut at) = (0.0, f64::NAN);
    for (i, &x) in values.iter().enumerate() {
        let expected = cdf(x);
        let gap = (expected - i as f64 / n).max((i as f64 + 1.0) / n - expected);
        // NaN from the distribution or among the values counts as the largest distance.
        if gap.is_nan() {
            return not_a_number(name, count);
        }
        if gap > d {
            (d, at) = (gap, x);
        }
    }
    let cells = values
        .iter()
        .enumerate()
        .step_by((values.len() / MAX_POINTS).max(1))
        .map(|(i, &x)| {
            let (expected, observed) = (cdf(x), (i as f64 + 0.5) / n);
            Cell {
                place: format!("{x:.6}"),
                expected,
                observed,
                sigmas: (observed - expected) * n.sqrt() / (expected * (1.0 - expected)).sqrt(),
            }
        })
        .collect();
    let radius = kolmogorov_upper(count, ALPHA);
    let outcome = Outcome {
        name: name.to_owned(),
        statistic: "Kolmogorov-Smirnov",
        value: n.sqrt() * d,
        dof: None,
        p: kolmogorov_sf(count, d),
        n: count,
        valid_from: 100,
        estimate: d,
        reference: 0.0,
        interval: [(d - radius).max(0.0), d + radius],
        claim: Claim::Equal { delta },
        sensitivity: Sensitivity::Distance { n: count },
        worst: format!("distribution functions differ by {d:.5} at {at:.6}"),
        cells,
        graded: Vec::new(),
    };
    if count == 0 {
        outcome.undecided("no values", 1)
    } else {
        outcome
    }
}

/// Returns the failing outcome for NaN among the values or in the distribution.
fn not_a_number(name: &str, n: u64) -> Outcome {
    Outcome::identity(name, n, f64::NAN, 0.0, "a value or its cdf is NaN")
}
