//! Largest skewness that leaves the far tail of a mean's test valid: Edgeworth's first term.

use crate::harness::tails::normal_upper;

/// Largest relative effect of skewness on one far tail: the first term of the Edgeworth expansion.
/// The other tail becomes lighter by as much.
pub const MAX_SKEW_TERM: f64 = 0.3;

/// Number of values of a distribution of |skewness| at most 0.2 that leaves a t tail valid: the
/// skewness of a sample, which varies by √(6/n), then exceeds the limit of
/// [`Values::valid_from`](super::Values::valid_from) with probability below
/// [`ALPHA`](crate::harness::outcome::ALPHA).
pub const MIN_SYMMETRIC_VALUES: u64 = 8_500;

/// Standard deviation by which a mean's difference from its reference is divided. Where it is
/// estimated from the same values, skewness bends the tail twice as much: a mean that is too low
/// comes with a standard deviation that is too small.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sigma {
    /// Known in closed form: the expansion's first term is γ(z² − 1)/(6√n) times the density.
    Known,
    /// Estimated (t, Welch): γ(2z² + 1)/(6√n) times the density (Hall 1987, "Edgeworth expansion
    /// for Student's t statistic under minimal moment conditions").
    Estimated,
}

impl Sigma {
    /// Returns the first term of the Edgeworth expansion relative to the tail beyond z, to leading
    /// order, for the skewness of the mean (γ/√n): |γ| z³/(6√n) or |γ| z³/(3√n).
    pub fn skew_term(self, skewness_of_mean: f64, z: f64) -> f64 {
        let divisor = match self {
            Self::Known => 6.0,
            Self::Estimated => 3.0,
        };
        skewness_of_mean.abs() * z.powi(3) / divisor
    }

    /// Returns the number of values from which the tails at the two-sided level `alpha` are valid,
    /// if `n` values give their mean this skewness: [`skew_term`](Self::skew_term) ≤
    /// [`MAX_SKEW_TERM`], where the skewness falls as 1/√n. At least 2; `u64::MAX` for NaN.
    pub fn valid_from(self, n: u64, skewness_of_mean: f64, alpha: f64) -> u64 {
        let term = self.skew_term(skewness_of_mean, normal_upper(alpha / 2.0));
        if term.is_nan() {
            return u64::MAX;
        }
        // A float cast saturates.
        ((n as f64 * (term / MAX_SKEW_TERM).powi(2)).ceil() as u64).max(2)
    }
}

/// Returns a bound of the skewness of a sum or difference of independent means, each given by the
/// skewness of its values, the variance of the mean, and the number of values: Σ |γ| v^1.5/√n / (Σ
/// v)^1.5. Skewnesses might cancel; the bound ignores that. 0 if nothing varies.
pub fn skewness_of_sum(parts: impl IntoIterator<Item = (f64, f64, u64)>) -> f64 {
    let (mut third, mut second) = (0.0, 0.0);
    for (skewness, variance, n) in parts {
        third += skewness.abs() * variance.powf(1.5) / (n as f64).sqrt();
        second += variance;
    }
    if second == 0.0 {
        0.0
    } else {
        third / second.powf(1.5)
    }
}
