//! Values whose mean is tested, kept as moments up to the fourth.

use super::skewness::Sigma;
use crate::harness::batches::Batches;
use crate::harness::outcome::{ALPHA, Cell};
use crate::math::moments::Moments;

/// Independent values whose mean is tested, kept as moments up to the fourth.
#[derive(Clone, Copy, Debug)]
pub struct Values {
    /// Count, mean and variance.
    pub moments: Moments,
    /// Means of consecutive values, for the data file.
    pub batches: Batches,
    /// Value near the mean, about which third and fourth powers are summed.
    centre: f64,
    cubes: f64,
    fourths: f64,
}

impl Values {
    /// Starts without values; the mean is expected near `centre`.
    pub fn new(centre: f64) -> Self {
        Self {
            moments: Moments::default(),
            batches: Batches::default(),
            centre,
            cubes: 0.0,
            fourths: 0.0,
        }
    }

    /// Draws `n` values from a sampler.
    pub fn collect(centre: f64, n: u64, mut sample: impl FnMut() -> f64) -> Self {
        let mut values = Self::new(centre);
        (0..n).for_each(|_| values.push(sample()));
        values
    }

    /// Returns all numbers that decide a statistic, to be stored: count, mean, variance, centre,
    /// and sum of cubes about it. The batches are left out.
    pub fn state(&self) -> [f64; 5] {
        let m = &self.moments;
        // Unknown below two values, and NaN is no number of a file.
        let variance = if m.count() < 2 { 0.0 } else { m.variance() };
        [
            m.count() as f64,
            m.mean(),
            variance,
            self.centre,
            self.cubes,
        ]
    }

    /// Restores the values with this [`state`](Self::state), without batches.
    pub fn from_state([count, mean, variance, centre, cubes]: [f64; 5]) -> Self {
        Self {
            moments: Moments::of(count as u64, mean, variance),
            centre,
            cubes,
            ..Self::new(centre)
        }
    }

    /// Adds one value.
    #[inline]
    pub fn push(&mut self, value: f64) {
        self.moments.push(value);
        self.batches.push(value);
        let shifted = value - self.centre;
        let cube = shifted * shifted * shifted;
        self.cubes += cube;
        self.fourths += cube * shifted;
    }

    /// Returns the sample skewness; 0 where the variance is 0 or unknown.
    pub fn skewness(&self) -> f64 {
        let variance = self.moments.variance();
        let n = self.moments.count() as f64;
        if variance <= 0.0 || n < 2.0 {
            return 0.0;
        }
        let shift = self.moments.mean() - self.centre;
        // Central moments divide by n.
        let second = variance * (n - 1.0) / n;
        let third = self.cubes / n - shift * (3.0 * second + shift * shift);
        third / variance.powf(1.5)
    }

    /// Returns the effective degrees of freedom of the sample variance, 2n/(κ − 1) for the fourth
    /// standardised moment κ: its relative variance is (κ − 1)/n, 2/(n − 1) for normal values. At
    /// most n − 1.
    pub fn variance_dof(&self) -> f64 {
        let n = self.moments.count() as f64;
        // Central moments divide by n.
        let second = self.moments.variance() * (n - 1.0) / n;
        let shift = self.moments.mean() - self.centre;
        let square = shift * shift;
        let fourth = self.fourths / n - 4.0 * shift * self.cubes / n
            + square * (6.0 * (second + square) - 3.0 * square);
        let dof = 2.0 * n / (fourth / (second * second) - 1.0);
        // Two equally frequent values have κ = 1; a constant has none.
        if dof > 0.0 { dof.min(n - 1.0) } else { n - 1.0 }
    }

    /// Returns the number of values from which the tail of a t test at [`ALPHA`] is valid, as far
    /// as skewness decides it.
    pub fn valid_from(&self) -> u64 {
        self.valid_from_at(ALPHA)
    }

    /// Returns the number of values from which the tail of a t test at the two-sided level `alpha`
    /// is valid, as far as skewness decides it.
    pub fn valid_from_at(&self, alpha: f64) -> u64 {
        self.valid(Sigma::Estimated, alpha)
    }

    pub(super) fn valid(&self, sigma: Sigma, alpha: f64) -> u64 {
        let n = self.moments.count();
        sigma.valid_from(n, self.skewness() / (n as f64).sqrt(), alpha)
    }

    /// Returns skewness, variance of the mean and count: one part of
    /// [`skewness_of_sum`](super::skewness_of_sum).
    pub fn skewness_part(&self) -> (f64, f64, u64) {
        let n = self.moments.count();
        (self.skewness(), self.moments.variance() / n as f64, n)
    }

    /// Returns the values times `factor` plus `shift`.
    pub fn transformed(&self, factor: f64, shift: f64) -> Self {
        let m = self.moments;
        Self {
            moments: Moments::of(
                m.count(),
                factor * m.mean() + shift,
                factor * factor * m.variance(),
            ),
            batches: self.batches.transformed(factor, shift),
            centre: factor * self.centre + shift,
            cubes: factor.powi(3) * self.cubes,
            fourths: factor.powi(4) * self.fourths,
        }
    }

    /// Returns the values of a subject whose mean is off `reference` by `effect`: by a factor, as
    /// for faults of weights and densities; by a shift, if the mean is near 0.
    pub(super) fn with_error(&self, effect: f64, reference: f64) -> Self {
        if effect.abs() > 0.5 * reference.abs() {
            self.transformed(1.0, effect)
        } else {
            self.transformed(1.0 + effect / reference, 0.0)
        }
    }

    /// Returns the batches as cells against the mean `expected`; `prefix` begins their places.
    pub fn cells(&self, prefix: &str, expected: f64) -> Vec<Cell> {
        self.batches
            .cells(prefix, expected, self.moments.variance())
    }
}
