//! Tests of means: against a closed form, against another mean, exactly or within a margin.

mod skewness;
mod values;

pub use skewness::{MAX_SKEW_TERM, MIN_SYMMETRIC_VALUES, Sigma, skewness_of_sum};
pub use values::Values;

use super::graded::grade;
use super::outcome::{ALPHA, Claim, Outcome};
use super::power::{Sensitivity, bernstein_exponent};
use super::tails::{normal_sf, normal_upper, student_two_sided, student_upper};
use crate::math::moments::Moments;

/// Fraction of the reference below which differences are rounding: sums of up to 1e9 values stay
/// well within it.
pub const ROUNDING: f64 = 1e-12;

/// Number of equal values that is evidence against another mean; fewer are none. At level [`ALPHA`]
/// no other value has a probability above ln(1/α)/n, which is 0.2 % here.
pub const MIN_CONSTANT_VALUES: u64 = 10_000;

/// A nearly normal difference: the common part of z, t and Welch tests.
struct Difference {
    estimate: f64,
    reference: f64,
    /// Magnitude of the means, to which rounding is relative.
    scale: f64,
    standard_error: f64,
    dof: f64,
    /// Degrees of freedom of the noise of the standard error: see [`Values::variance_dof`].
    noise_dof: f64,
}

impl Difference {
    fn outcome(&self, name: &str, statistic: &'static str, n: u64, claim: Claim) -> Outcome {
        let rounding = ROUNDING * self.scale;
        let difference = self.estimate - self.reference;
        let equal = difference.abs() <= rounding;
        let t = if equal {
            0.0
        } else {
            // Infinite if nothing varies and yet the mean is wrong; NaN stays NaN and fails.
            difference / self.standard_error
        };
        let p = if self.dof.is_finite() && self.dof > 0.0 {
            student_two_sided(t, self.dof)
        } else {
            f64::NAN
        };
        let half = student_upper(ALPHA / 2.0, self.dof.max(1.0)) * self.standard_error + rounding;
        let outcome = Outcome {
            name: name.to_owned(),
            statistic,
            value: t,
            dof: Some(self.dof),
            p,
            n,
            valid_from: 2,
            estimate: self.estimate,
            reference: self.reference,
            interval: [self.estimate - half, self.estimate + half],
            claim,
            sensitivity: Sensitivity::Normal {
                standard_error: self.standard_error,
                dof: self.noise_dof,
                tests: 1,
            },
            worst: format!("{t:+.2} standard errors"),
            cells: Vec::new(),
            graded: Vec::new(),
        };
        if n < 2 {
            outcome.undecided("fewer than two values", 2)
        } else if self.standard_error > rounding || self.standard_error.is_nan() {
            outcome
        } else if equal {
            outcome.undecided("no value differs from the others", u64::MAX)
        } else if n < MIN_CONSTANT_VALUES {
            outcome.undecided("few values, all the same", MIN_CONSTANT_VALUES)
        } else {
            outcome
        }
    }
}

/// Tests a mean against a closed form by Student's t. Skewness decides whether the tail is valid:
/// below [`Values::valid_from`] the outcome is undecided. It is also undecided if nothing varies,
/// as a sampler that is stuck cannot be told from one that need not vary.
///
/// A claim with δ = 0 says more: *every* value is the reference, to within [`ALL_EQUAL_TOLERANCE`]
/// (an identity, not random).
pub fn mean(name: &str, values: &Values, reference: f64, claim: Claim) -> Outcome {
    let moments = values.moments;
    if claim == (Claim::Equal { delta: 0.0 }) {
        let tolerance = ALL_EQUAL_TOLERANCE * reference.abs().max(1.0);
        return all_equal(name, moments, reference, tolerance);
    }
    grade(student_test(name, values, reference, claim), |effect| {
        let wrong = values.with_error(effect, reference);
        Some(student_test(name, &wrong, reference, claim))
    })
}

fn student_test(name: &str, values: &Values, reference: f64, claim: Claim) -> Outcome {
    let moments = values.moments;
    let mut outcome = Difference {
        estimate: moments.mean(),
        reference,
        scale: reference.abs().max(moments.mean().abs()),
        standard_error: moments.standard_error(),
        dof: moments.count() as f64 - 1.0,
        noise_dof: values.variance_dof(),
    }
    .outcome(name, "t", moments.count(), claim);
    outcome.valid_from = outcome.valid_from.max(values.valid_from());
    outcome.cells = values.cells("", reference);
    outcome
}

/// Largest difference of a single value from a reference that all values have, relative to it
/// (absolute below one): hundreds of roundings.
pub const ALL_EQUAL_TOLERANCE: f64 = 1e-9;

/// Checks whether all values are the reference: none is further from their mean than √(n − 1)
/// standard deviations (Samuelson 1968, "How deviant can you be?").
pub fn all_equal(name: &str, moments: Moments, reference: f64, tolerance: f64) -> Outcome {
    let n = moments.count() as f64;
    let spread = if n < 2.0 {
        0.0
    } else {
        (moments.variance() * (n - 1.0)).sqrt()
    };
    let error = (moments.mean() - reference).abs() + spread;
    let worst = format!(
        "mean {}, no value further from it than {spread:.3e}; each should be {reference}",
        moments.mean()
    );
    Outcome::identity(name, moments.count(), error, tolerance, worst)
}

/// Tests a mean whose standard deviation `sigma` > 0 is known in closed form by the z test.
pub fn mean_known_sigma(
    name: &str,
    values: &Values,
    reference: f64,
    sigma: f64,
    claim: Claim,
) -> Outcome {
    grade(z_test(name, values, reference, sigma, claim), |effect| {
        let wrong = values.transformed(1.0, effect);
        Some(z_test(name, &wrong, reference, sigma, claim))
    })
}

fn z_test(name: &str, values: &Values, reference: f64, sigma: f64, claim: Claim) -> Outcome {
    let moments = values.moments;
    let n = moments.count();
    let standard_error = sigma / (n as f64).sqrt();
    let z = (moments.mean() - reference) / standard_error;
    let half = normal_upper(ALPHA / 2.0) * standard_error;
    let outcome = Outcome {
        name: name.to_owned(),
        statistic: "z",
        value: z,
        dof: None,
        p: 2.0 * normal_sf(z.abs()),
        n,
        valid_from: values.valid(Sigma::Known, ALPHA),
        estimate: moments.mean(),
        reference,
        interval: [moments.mean() - half, moments.mean() + half],
        claim,
        sensitivity: Sensitivity::Normal {
            standard_error,
            dof: f64::INFINITY,
            tests: 1,
        },
        worst: format!("{z:+.2} standard errors"),
        cells: values.batches.cells("", reference, sigma * sigma),
        graded: Vec::new(),
    };
    if n < 2 {
        outcome.undecided("fewer than two values", 2)
    } else if sigma <= 0.0 || moments.variance() == 0.0 {
        outcome.undecided("nothing varies", u64::MAX)
    } else {
        outcome
    }
}

/// Tests the mean of values in [low, high], for every n ≥ 2 and every distribution: the two-sided
/// empirical Bernstein inequality (Maurer and Pontil, COLT 2009, theorem 4).
///
/// |mean − μ| > √(2VL/n) + 7(high − low)L/(3(n − 1)) has probability at most 4 exp(−L).
pub fn bounded_mean(
    name: &str,
    values: &Values,
    reference: f64,
    bounds: [f64; 2],
    claim: Claim,
) -> Outcome {
    let test = |values: &Values| bernstein_test(name, values, reference, bounds, claim);
    grade(test(values), |effect| {
        Some(test(&values.with_error(effect, reference)))
    })
}

fn bernstein_test(
    name: &str,
    values: &Values,
    reference: f64,
    [low, high]: [f64; 2],
    claim: Claim,
) -> Outcome {
    let moments = values.moments;
    let n = moments.count() as f64;
    let root = (2.0 * moments.variance() / n).sqrt();
    let range = 7.0 * (high - low) / (3.0 * (n - 1.0));
    let radius = |l: f64| root * l.sqrt() + range * l;
    let deviation = (moments.mean() - reference).abs();
    // The L at which the interval just reaches the reference.
    let l = bernstein_exponent(deviation, root, range);
    let p = if deviation == 0.0 {
        1.0
    } else if l.is_nan() {
        f64::NAN
    } else {
        (4.0 * (-l).exp()).min(1.0)
    };
    let half = radius((4.0 / ALPHA).ln());
    let outcome = Outcome {
        name: name.to_owned(),
        statistic: "empirical Bernstein",
        value: deviation,
        dof: None,
        p,
        n: moments.count(),
        valid_from: 2,
        estimate: moments.mean(),
        reference,
        interval: [
            (moments.mean() - half).max(low),
            (moments.mean() + half).min(high),
        ],
        claim,
        sensitivity: Sensitivity::Bernstein { root, range },
        worst: format!("{deviation:.3e} from the reference"),
        cells: values.cells("", reference),
        graded: Vec::new(),
    };
    if moments.count() < 2 {
        outcome.undecided("fewer than two values", 2)
    } else if high <= low {
        outcome.undecided("the bounds leave one value", u64::MAX)
    } else {
        outcome
    }
}

/// Tests the difference of two means by Welch's t; the claim's size is in the units of the
/// difference.
///
/// [`Claim::Equal`] is for two unbiased estimators: their means are equal, whatever the margin.
/// [`Claim::Equivalent`] tests the equivalence of two means: the interval lies within ±Δ if two
/// one-sided tests reject.
pub fn welch(name: &str, a: &Values, b: &Values, claim: Claim) -> Outcome {
    grade(welch_test(name, a, b, claim), |effect| {
        let wrong = a.with_error(effect, b.moments.mean());
        Some(welch_test(name, &wrong, b, claim))
    })
}

fn welch_test(name: &str, a: &Values, b: &Values, claim: Claim) -> Outcome {
    let (ma, mb) = (a.moments, b.moments);
    let [va, vb] = [ma, mb].map(|m| m.variance() / m.count() as f64);
    let mut outcome = Difference {
        estimate: ma.mean() - mb.mean(),
        reference: 0.0,
        // Rounding is relative to the means, not to their difference.
        scale: ma.mean().abs().max(mb.mean().abs()),
        standard_error: (va + vb).sqrt(),
        dof: welch_satterthwaite([(va, ma.count()), (vb, mb.count())]),
        noise_dof: satterthwaite([(va, a.variance_dof()), (vb, b.variance_dof())]),
    }
    .outcome(name, "Welch", ma.count().min(mb.count()), claim);
    let skewness = skewness_of_sum([a.skewness_part(), b.skewness_part()]);
    let from = Sigma::Estimated.valid_from(outcome.n, skewness, ALPHA);
    outcome.valid_from = outcome.valid_from.max(from);
    outcome.cells = a.cells("first, ", mb.mean());
    outcome.cells.extend(b.cells("second, ", ma.mean()));
    outcome
}

/// Returns the degrees of freedom (Welch-Satterthwaite) of a sum of independent variances of means
/// of n values (v, n); infinite variance of few values gives NaN, and no variance at all the number
/// of values.
pub fn welch_satterthwaite(parts: impl IntoIterator<Item = (f64, u64)>) -> f64 {
    satterthwaite(parts.into_iter().map(|(v, n)| (v, n as f64 - 1.0)))
}

/// Returns the degrees of freedom of a sum of independent variances (v, degrees of freedom);
/// infinite or no variance as in [`welch_satterthwaite`].
pub(crate) fn satterthwaite(parts: impl IntoIterator<Item = (f64, f64)>) -> f64 {
    let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
    for (v, dof) in parts {
        sum += v;
        squares += v * v / dof;
        count += dof;
    }
    if squares == 0.0 {
        count
    } else {
        sum * sum / squares
    }
}
