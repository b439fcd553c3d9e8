//! Tests of the order of convergence, and of the ratio of two samplers' variances.

use super::graded::grade;
use super::mean::{ROUNDING, Sigma, Values, mean, satterthwaite, skewness_of_sum};
use super::outcome::{ALPHA, Cell, Claim, Outcome};
use super::power::Sensitivity;
use super::tails::{f_sf, student_two_sided, student_upper};

/// Returns the least-squares slope of ln `errors` against ln `sizes`.
pub fn log_slope(sizes: &[f64], errors: &[f64]) -> f64 {
    let n = sizes.len() as f64;
    let x: Vec<f64> = sizes.iter().map(|s| s.ln()).collect();
    let centre = x.iter().sum::<f64>() / n;
    let spread: f64 = x.iter().map(|x| (x - centre).powi(2)).sum();
    x.iter()
        .zip(errors)
        .map(|(x, e)| (x - centre) * e.ln())
        .sum::<f64>()
        / spread
}

/// Tests the order of convergence: the mean over independent `groups` of the slope of ln error
/// against ln N must be within ±`margin` of `reference`.
///
/// Each group holds one error (variance or mean squared error) per size. The logarithm of a noisy
/// error is biased, but equally at every size if each group's errors come from the same number of
/// replications at all sizes: then the slope is unbiased.
pub fn slope(
    name: &str,
    sizes: &[f64],
    groups: &[Vec<f64>],
    reference: f64,
    margin: f64,
) -> Outcome {
    let mut slopes = Values::new(reference);
    groups
        .iter()
        .for_each(|errors| slopes.push(log_slope(sizes, errors)));
    let mut outcome = mean(name, &slopes, reference, Claim::Equivalent { margin });
    outcome.cells = mean_errors(sizes, groups, reference);
    outcome
}

/// Returns mean errors per size against the line of the reference slope through their centre.
fn mean_errors(sizes: &[f64], groups: &[Vec<f64>], reference: f64) -> Vec<Cell> {
    let logs: Vec<f64> = (0..sizes.len())
        .map(|i| groups.iter().map(|g| g[i].ln()).sum::<f64>() / groups.len() as f64)
        .collect();
    let centre = |v: &mut dyn Iterator<Item = f64>| v.sum::<f64>() / sizes.len() as f64;
    let (x, y) = (
        centre(&mut sizes.iter().map(|s| s.ln())),
        centre(&mut logs.iter().copied()),
    );
    sizes
        .iter()
        .zip(&logs)
        .map(|(&size, &log)| Cell {
            place: format!("N = {size}"),
            expected: (y + reference * (size.ln() - x)).exp(),
            observed: log.exp(),
            sigmas: 0.0,
        })
        .collect()
}

/// Tests the ratio of the variances of two samplers whose means are known, against a closed form:
/// within ±`delta`, relative. Valid for every distribution with a finite fourth moment: it compares
/// the mean of (x − μ)² with `ratio` times that of (y − ν)²; the interval of the ratio is Fieller's
/// (1954).
///
/// `a` and `b` hold the squared deviations.
pub fn variance_ratio(name: &str, a: &Values, b: &Values, ratio: f64, delta: f64) -> Outcome {
    grade(ratio_test(name, a, b, ratio, delta), |effect| {
        let wrong = a.transformed(1.0 + effect / ratio, 0.0);
        Some(ratio_test(name, &wrong, b, ratio, delta))
    })
}

fn ratio_test(name: &str, a: &Values, b: &Values, ratio: f64, delta: f64) -> Outcome {
    let (ma, mb) = (a.moments, b.moments);
    let n = ma.count().min(mb.count());
    let dof = n as f64 - 1.0;
    let [va, vb] = [ma, mb].map(|m| m.variance() / m.count() as f64);
    let standard_error = (va + ratio * ratio * vb).sqrt();
    let t = (ma.mean() - ratio * mb.mean()) / standard_error;
    let (skewness_b, variance_b, n_b) = b.skewness_part();
    let skewness = skewness_of_sum([
        a.skewness_part(),
        (skewness_b, ratio * ratio * variance_b, n_b),
    ]);
    let mut cells = a.cells("first, ", ratio * mb.mean());
    cells.extend(b.cells("second, ", ma.mean() / ratio));
    let critical = student_upper(ALPHA / 2.0, dof.max(1.0));
    let outcome = Outcome {
        name: name.to_owned(),
        statistic: "variance ratio",
        value: t,
        dof: Some(dof),
        p: student_two_sided(t, dof),
        n,
        valid_from: Sigma::Estimated.valid_from(n, skewness, ALPHA),
        estimate: ma.mean() / mb.mean(),
        reference: ratio,
        interval: fieller([ma.mean(), mb.mean()], [va, vb], critical),
        claim: Claim::Equal {
            delta: delta * ratio,
        },
        // An effect on the ratio moves the difference by that times the second mean.
        sensitivity: Sensitivity::Normal {
            standard_error: standard_error / mb.mean(),
            dof: satterthwaite([
                (va, a.variance_dof()),
                (ratio * ratio * vb, b.variance_dof()),
            ])
            .min(dof),
            tests: 1,
        },
        worst: format!("{t:+.2} standard errors"),
        cells,
        graded: Vec::new(),
    };
    if dof < 1.0 {
        outcome.undecided("fewer than two values", 2)
    } else if standard_error <= ROUNDING * ma.mean().abs().max(mb.mean().abs()) {
        outcome.undecided("no square differs from the others", u64::MAX)
    } else {
        outcome
    }
}

/// Returns all r with |x − r y| ≤ c √(v_x + r² v_y), for independent x and y; the whole line if y
/// is not clearly different from zero.
fn fieller([x, y]: [f64; 2], [vx, vy]: [f64; 2], c: f64) -> [f64; 2] {
    let g = y * y - c * c * vy;
    if g <= 0.0 {
        return [f64::NEG_INFINITY, f64::INFINITY];
    }
    // A quarter of the quadratic equation's discriminant, without the part (xy)² that cancels.
    let root = c * (vx * g + vy * x * x).sqrt();
    [(x * y - root) / g, (x * y + root) / g]
}

/// Returns the p-value of the two-sided F test of the ratio of two sample variances s² of `counts`
/// *normal* values each.
pub fn f_test(variances: [f64; 2], counts: [u64; 2], ratio: f64) -> f64 {
    let f = variances[0] / variances[1] / ratio;
    let [d1, d2] = counts.map(|n| n as f64 - 1.0);
    // The lower tail is the upper tail of the reciprocal.
    2.0 * f_sf(f, d1, d2).min(f_sf(1.0 / f, d2, d1))
}
