//! Running moments of the Monte Carlo estimator, in floating point and exactly.

use crate::error::{Error, MAX_RADIANCE};

/// The estimator of (16), ⟨E⟩ = 1/N Σ f(Xᵢ)/p(Xᵢ), with the running second moment that gives its
/// standard error (Welford 1962; merging after Chan, Golub and LeVeque 1979).
///
/// Equation: [`crate::equation::ESTIMATOR`]. The values pushed are the ratios f/p.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    count: u64,
    mean: f64,
    /// Sum of squared deviations from the mean.
    squares: f64,
}

impl Moments {
    /// Adds one value f(X)/p(X).
    #[inline]
    pub fn push(&mut self, value: f64) {
        self.count += 1;
        let deviation = value - self.mean;
        self.mean += deviation / self.count as f64;
        self.squares += deviation * (value - self.mean);
    }

    /// Creates the moments of `count` values with this mean and unbiased sample variance.
    pub fn of(count: u64, mean: f64, variance: f64) -> Self {
        let squares = if count < 2 {
            0.0
        } else {
            variance * (count - 1) as f64
        };
        Self {
            count,
            mean,
            squares,
        }
    }

    /// Returns the moments of both sets of values together.
    pub fn merge(self, other: Self) -> Self {
        let count = self.count + other.count;
        if count == 0 {
            return self;
        }
        let (n, m) = (self.count as f64, other.count as f64);
        let difference = other.mean - self.mean;
        Self {
            count,
            mean: self.mean + difference * (m / (n + m)),
            squares: self.squares + other.squares + difference * difference * (n * m / (n + m)),
        }
    }

    /// Returns the number of values.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Returns the estimate: the arithmetic mean (0 when empty).
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// Returns the unbiased sample variance; infinite below two values, where it is unknown.
    pub fn variance(&self) -> f64 {
        if self.count < 2 {
            return f64::INFINITY;
        }
        self.squares / (self.count - 1) as f64
    }

    /// Returns the standard error of the mean; infinite below two values.
    pub fn standard_error(&self) -> f64 {
        (self.variance() / self.count as f64).sqrt()
    }
}

impl FromIterator<f64> for Moments {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        let mut moments = Self::default();
        values.into_iter().for_each(|value| moments.push(value));
        moments
    }
}

/// Unit to whose multiples values are rounded once; every later step is exact.
pub const FIXED_POINT_UNIT: f64 = 1.0 / 4_294_967_296.0;

/// First and second moment (16) as integers, so that merging is exact: associative, commutative,
/// and independent of threads, passes and machines.
///
/// A value is rounded to the nearest multiple of [`FIXED_POINT_UNIT`] = 2⁻³² and must not exceed
/// [`MAX_RADIANCE`] = 2²⁴ in absolute value. Its square is then a multiple of 2⁻⁶⁴ below 2⁴⁸,
/// and sums of fewer than 2¹⁵ such squares fit 128 bits even when every value is the largest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ExactMoments {
    sum: i128,
    squares: i128,
}

/// Returns the error of an accumulator that is full.
pub(crate) fn full() -> Error {
    Error::Option("a pixel's sums are full: take fewer samples in one film".to_owned())
}

/// Returns the nearest multiple of [`FIXED_POINT_UNIT`], halves away from zero.
#[inline]
pub fn in_units(value: f64) -> i64 {
    (value * (1.0 / FIXED_POINT_UNIT)).round() as i64
}

impl ExactMoments {
    /// Adds one value; the caller keeps the count (channels of a pixel share it).
    ///
    /// # Errors
    /// [`Error::Radiance`] if the value is not finite or exceeds [`MAX_RADIANCE`];
    /// [`Error::Option`] as [`merge`](Self::merge).
    #[inline]
    pub fn push(&mut self, value: f64) -> Result<(), Error> {
        // The comparison is false for NaN, too.
        if value.abs() <= MAX_RADIANCE {
            let sum = i128::from(in_units(value));
            self.merge(&Self {
                sum,
                squares: sum * sum,
            })
        } else {
            Err(Error::Radiance {
                value,
                place: String::new(),
            })
        }
    }

    /// Adds the values of another accumulator: exact, in any order.
    ///
    /// # Errors
    /// [`Error::Option`] if the sum of squares would leave 128 bits; the accumulator stays as it
    /// was.
    #[inline]
    pub fn merge(&mut self, other: &Self) -> Result<(), Error> {
        // Squares bound the sum: a multiple of the unit is at most its square.
        let squares = self.squares.checked_add(other.squares).ok_or_else(full)?;
        self.sum += other.sum;
        self.squares = squares;
        Ok(())
    }

    /// Returns both sums, for files.
    pub(crate) fn sums(&self) -> [i128; 2] {
        [self.sum, self.squares]
    }

    /// Restores the moments of `count` values of at least 0 from their sums; `None` if no such
    /// values have them.
    pub(crate) fn of_sums([sum, squares]: [i128; 2], count: u32) -> Option<Self> {
        let most = i128::from(count) * i128::from(in_units(MAX_RADIANCE));
        ((0..=most).contains(&sum) && sum <= squares).then_some(Self { sum, squares })
    }

    /// Returns the mean of `count` values; 0 if there are none.
    pub fn mean(&self, count: u32) -> f64 {
        if count == 0 {
            return 0.0;
        }
        self.sum as f64 / f64::from(count) * FIXED_POINT_UNIT
    }

    /// Returns the unbiased sample variance of `count` values; infinite below two values.
    pub fn variance(&self, count: u32) -> f64 {
        if count < 2 {
            return f64::INFINITY;
        }
        // Σ(q − m)² about an integer m near the mean, in exact arithmetic (products may overflow
        // and wrap, but the result fits), then the remaining shift of the mean in floating point.
        let n = i128::from(count);
        let centre = self.sum / n;
        let about_centre = self
            .squares
            .wrapping_sub((2 * centre).wrapping_mul(self.sum))
            .wrapping_add(n.wrapping_mul(centre.wrapping_mul(centre)));
        let shift = (self.sum - centre * n) as f64;
        let squares = about_centre as f64 - shift * shift / f64::from(count);
        squares.max(0.0) / f64::from(count - 1) * FIXED_POINT_UNIT * FIXED_POINT_UNIT
    }

    /// Returns the standard error of the mean of `count` values; infinite below two values.
    pub fn standard_error(&self, count: u32) -> f64 {
        (self.variance(count) / f64::from(count)).sqrt()
    }
}
