//! Judges the image mean of a case of the matrix.

use whitefurnace::harness::mean::welch_satterthwaite;

use super::claims::{Case, Claim, margin};
use super::{Mean, Total};
use crate::experiments::prelude::*;
use crate::plot::agreement::{Agreement, MatrixCell};

/// Relative half width below which an interval is rounding, whose skewness is meaningless.
const ROUNDING_TOLERANCE: f64 = 1e-9;

/// Compares a case with its reference, records it, and returns its cell of the matrix. If the
/// method leaves out light, the expected amount is added first and has to explain the whole
/// difference.
pub(super) fn judge(
    run: &mut Run,
    case: &Case,
    total: &Total,
    reference: Mean,
    missing_light: Option<Mean>,
    level: f64,
) -> MatrixCell {
    let own = total.moments;
    if let (Mean::Measured(_), EstimatorName::Mis) = (reference, case.estimator) {
        let error = 100.0 * own.standard_error() / own.mean();
        run.note(
            &case.label(),
            format!("reference, {:.6} ± {error:.3} % standard error", own.mean()),
        );
        return MatrixCell {
            text: format!("{:.4} ± {error:.3} %", own.mean()),
            agreement: Agreement::Reference,
        };
    }
    let missing_light = missing_light.unwrap_or(Mean::Known(0.0));
    let mean = reference.value();
    let own_mean = Mean::Measured(*total);
    let parts = [&own_mean, &reference, &missing_light];
    let is_skewed = is_skewed(&parts, level, mean);
    let half = |of: &[&Mean]| if is_skewed { chebyshev_half_width(of, level) } else { welch_half_width(of, level) } / mean;
    let difference = own.mean() / mean - 1.0;
    let shown = half(&[&own_mean, &reference]);
    let expected = -missing_light.value() / mean;
    let key = case.key();
    let (size, why) = match case.claim {
        Claim::Equal => (margin(case.scene, run.tier()), ""),
        Claim::Biased(bias, why) => (bias, why),
        Claim::Lacks(_, why) => (margin(case.scene, run.tier()), why),
    };
    let n = own.count();
    run.numbers(
        &key,
        [
            ("difference", difference),
            ("half", shown),
            ("replications", n as f64),
            ("margin", size),
        ],
    );
    let half = half(&parts);
    let rest = difference - expected;
    let interval = [rest - half, rest + half];
    let verdict = match equivalence_verdict(interval, 0.0, size, n) {
        // More images reduce the effect of skewness.
        Verdict::Undecided { .. } if is_skewed => Verdict::Undecided {
            needed: (n as f64 * skew_ratio(&parts).powi(2)).ceil() as u64,
        },
        verdict => verdict,
    };
    let mut value = format!("{:+.3} % ± {:.3} %", 100.0 * difference, 100.0 * shown);
    if let Claim::Lacks(..) = case.claim {
        run.numbers(
            &key,
            [("expected", expected), ("rest", rest), ("rest_half", half)],
        );
        let [expected, rest, half] = [expected, rest, half].map(|x| 100.0 * x);
        value += &format!(", expected {expected:+.3} %: {rest:+.3} % ± {half:.3} % remain");
    }
    value += &format!(", within {:.1} %", 100.0 * size);
    if !why.is_empty() {
        value += &format!(" ({why})");
    }
    if is_skewed {
        value += "; by Chebyshev's inequality, as they are skewed";
    }
    if let Verdict::Undecided { needed } = verdict {
        value += &format!("; needs about {needed} images");
    }
    run.claim(&case.label(), value, verdict);
    let agreement = match (verdict, case.claim) {
        (Verdict::Fails, _) => Agreement::Differs,
        (Verdict::Undecided { .. }, _) => Agreement::Undecided,
        (Verdict::Holds, Claim::Lacks(..)) => Agreement::Explained,
        // A bias that is claimed but too small to detect counts as agreement.
        (Verdict::Holds, _) if within(interval, margin(case.scene, run.tier())) => {
            Agreement::Agrees
        }
        (Verdict::Holds, _) => Agreement::Biased,
    };
    let mut text = format!("{} ± {:.3} %", signed(100.0 * difference), 100.0 * shown);
    if let Claim::Lacks(..) = case.claim {
        text += &format!("\nexpected {} %", signed(100.0 * expected));
    }
    MatrixCell { text, agreement }
}

fn within(interval: [f64; 2], margin: f64) -> bool {
    interval.iter().all(|end| end.abs() <= margin)
}

/// Formats a number with three decimals and a sign, except zero.
fn signed(value: f64) -> String {
    let text = format!("{value:+.3}");
    match text.trim_start_matches(['+', '-']) {
        "0.000" => "0.000".to_owned(),
        _ => text.replace('-', "−"),
    }
}

/// Returns the distortion of a sum's tail by skewness, relative to the allowed one. The distortion
/// of n values is √(valid_from/n), in proportion to their skewness; a part with a share w of the
/// sum's variance contributes w^(3/2) of that, as third cumulants add.
fn skew_ratio(means: &[&Mean; 3]) -> f64 {
    let all = standard_error(means);
    let part = |total: &Total| {
        let alone = total.valid_from as f64 / total.moments.count() as f64;
        alone.sqrt() * (total.moments.standard_error() / all).powi(3)
    };
    means
        .iter()
        .filter_map(|mean| mean.measured())
        .map(part)
        .sum()
}

/// Returns true if skewness makes the tail of Welch's interval of a sum of means unreliable, unless
/// the interval is rounding at this `scale`.
fn is_skewed(means: &[&Mean; 3], level: f64, scale: f64) -> bool {
    skew_ratio(means) > 1.0 && welch_half_width(means, level) / scale > ROUNDING_TOLERANCE
}

/// Returns the half width of Welch's interval of a sum or difference of means.
fn welch_half_width(means: &[&Mean], level: f64) -> f64 {
    let dof = welch_satterthwaite(variances(means)).max(1.0);
    student_upper(0.5 * level, dof) * standard_error(means)
}

/// Returns the half width of Chebyshev's interval of a sum or difference of means, which holds for
/// any distribution with this variance. If the variance is that of k rare values among many equal
/// ones, the interval allows for √(k/level) more of them: hundreds, after a single one.
fn chebyshev_half_width(means: &[&Mean], level: f64) -> f64 {
    standard_error(means) / level.sqrt()
}

fn standard_error(means: &[&Mean]) -> f64 {
    variances(means)
        .map(|(variance, _)| variance)
        .sum::<f64>()
        .sqrt()
}

/// Returns the variances of the measured means, and their numbers of images.
fn variances(means: &[&Mean]) -> impl Iterator<Item = (f64, u64)> {
    let measured = means.iter().filter_map(|mean| mean.measured());
    measured.map(|total| {
        (
            total.moments.variance() / total.moments.count() as f64,
            total.moments.count(),
        )
    })
}

impl Mean {
    fn value(&self) -> f64 {
        match self {
            Self::Known(mean) => *mean,
            Self::Measured(total) => total.moments.mean(),
        }
    }

    fn measured(&self) -> Option<&Total> {
        match self {
            Self::Known(_) => None,
            Self::Measured(total) => Some(total),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEVEL: f64 = 1e-5;

    /// Returns the mean of `count` images, every `rare`-th of which is 2 and the others 1.
    fn images(count: u64, rare: u64) -> Mean {
        let mut values = Values::new(1.0);
        (0..count).for_each(|i| values.push(if i % rare == 0 { 2.0 } else { 1.0 }));
        Mean::Measured(Total {
            moments: values.moments,
            valid_from: values.valid_from_at(LEVEL),
        })
    }

    #[test]
    fn rare_values_leave_students_interval_unsure_and_chebyshevs_wide() {
        let known = Mean::Known(1.0);
        let [even, few] = [images(40_000, 2), images(40_000, 10_000)];
        let is_skewed = |means: [&Mean; 3], scale| is_skewed(&means, LEVEL, scale);
        assert!(!is_skewed([&even, &known, &known], 1.0));
        assert!(is_skewed([&few, &known, &known], 1.0));
        // In a sum with larger parts its skewness counts little, and relative to a large mean it is
        // rounding.
        assert!(!is_skewed([&few, &even, &known], 1.0));
        assert!(!is_skewed([&few, &known, &known], 1e7));
        // Four were observed: √(4/level) more would be within the interval.
        let more = 40_000.0 * chebyshev_half_width(&[&few], LEVEL);
        assert!((more / (4.0 / LEVEL).sqrt() - 1.0).abs() < 1e-3, "{more}");
        assert!(welch_half_width(&[&few], LEVEL) < 0.02 * chebyshev_half_width(&[&few], LEVEL));
    }

    #[test]
    fn three_decimals_have_a_sign() {
        assert_eq!(
            [0.0004, -0.0004, 0.0126, -1.5].map(signed),
            ["0.000", "0.000", "+0.013", "−1.500"]
        );
    }
}
