//! Power: the probability that a statistic rejects under an effect of a given size.
//!
//! A probability near 1 loses its information in 16 digits, so the complement is computed: the
//! probability of a miss. The experiment `power` measures these curves where they can be measured.

use super::level::ALPHA;
use super::tails::{
    binomial_cdf, binomial_sf, chi_square_upper, kolmogorov_upper, noncentral_chi_square_cdf,
    normal_sf, normal_upper, poisson_cdf, poisson_sf, student_upper,
};

/// Response of a statistic to an effect. Effects are in the units of the estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sensitivity {
    /// Nothing is random: every error above the tolerance is found.
    Certain,
    /// A difference over its standard error: z, t, Welch, ratios of means.
    Normal {
        /// Standard error of the estimate, ≥ 0.
        standard_error: f64,
        /// Degrees of freedom of the standard error: fewer than its test's where values have
        /// outliers; infinite if it is known.
        dof: f64,
        /// Number of such statistics that share the level (Bonferroni), at least 1.
        tests: usize,
    },
    /// Pearson's statistic; the effect is the relative error of some cell's probability.
    Cells {
        /// Degrees of freedom.
        dof: f64,
        /// Number of samples in the cells.
        n: f64,
        /// Smallest probability of a cell, in which an effect is hardest to detect.
        min_probability: f64,
        /// Number of tests that share the level (Bonferroni), at least 1: two where losses are
        /// tested, too.
        tests: usize,
    },
    /// Kolmogorov's distance of n values; the effect is the distance of the two distributions.
    Distance {
        /// Number of values.
        n: u64,
    },
    /// Successes among n, by exact tails; the effect is a change of the probability.
    Binomial {
        /// Number of values.
        n: u64,
        /// Probability under the hypothesis.
        probability: f64,
    },
    /// A Poisson count, by exact tails; the effect is a change of its mean.
    Poisson {
        /// Mean under the hypothesis.
        mean: f64,
    },
    /// The empirical Bernstein inequality: a deviation above `root` √L + `range` L has probability
    /// at most 2 exp(−L) on each side.
    Bernstein {
        /// √(2V/n).
        root: f64,
        /// 7(high − low)/(3(n − 1)).
        range: f64,
    },
}

impl Sensitivity {
    /// Returns the probability that an effect of this size and sign is *not* rejected at level
    /// [`ALPHA`]: exact for counts and cells, close for normal statistics, an upper bound for
    /// distances and bounded values. Zero effect is missed with probability about 1.
    pub fn miss(&self, effect: f64) -> f64 {
        self.miss_at(effect, ALPHA)
    }

    /// Returns the probability that an effect is not rejected, as [`miss`](Self::miss), at a level
    /// in (0, 1].
    pub fn miss_at(&self, effect: f64, alpha: f64) -> f64 {
        self.miss_beyond(effect, alpha, self.critical(alpha))
    }

    /// Returns the value of the statistic beyond which a level rejects; 0 where none is used.
    fn critical(&self, alpha: f64) -> f64 {
        match *self {
            Self::Normal { dof, tests, .. } => critical(dof, alpha / tests as f64),
            Self::Cells { dof, tests, .. } if dof >= 1.0 => {
                chi_square_upper(alpha / tests as f64, dof)
            }
            Self::Distance { n } => kolmogorov_upper(n, alpha),
            _ => 0.0,
        }
    }

    /// Returns [`miss_at`](Self::miss_at) for a level with this [`critical`](Self::critical) value.
    fn miss_beyond(&self, effect: f64, alpha: f64, critical: f64) -> f64 {
        let size = effect.abs();
        match *self {
            Self::Certain => 0.0,
            Self::Normal {
                standard_error,
                dof,
                ..
            } => normal_miss(size, standard_error, dof, critical),
            Self::Cells {
                dof,
                n,
                min_probability,
                ..
            } => {
                if dof < 1.0 {
                    // One cell holds everything: no effect is detectable.
                    return 1.0;
                }
                // Of all distributions with this relative error in some cell, the one that takes it
                // evenly from all others has the least Σ (p' − p)²/p.
                let noncentrality = n * size * size * min_probability / (1.0 - min_probability);
                noncentral_chi_square_cdf(critical, dof, noncentrality)
            }
            Self::Distance { n } => {
                // Where the distributions differ most, the fraction of values deviates by more than
                // the excess with at most this probability (Hoeffding 1963, theorem 1).
                let excess = (size - critical).max(0.0);
                (-2.0 * n as f64 * excess * excess).exp()
            }
            Self::Binomial { n, probability } => {
                binomial_miss(n, probability, probability + effect, alpha)
            }
            Self::Poisson { mean } => poisson_miss(mean, mean + effect, alpha),
            Self::Bernstein { root, range } => {
                let radius = |l: f64| root * l.sqrt() + range * l;
                let excess = (size - radius((4.0 / alpha).ln())).max(0.0);
                (2.0 * (-bernstein_exponent(excess, root, range)).exp()).min(1.0)
            }
        }
    }

    /// Returns the smallest level, at least [`ALPHA`], at which an effect of this size and sign is
    /// rejected with at least this probability; 1 if that takes rejecting everything. Found by
    /// bisection, to a relative 1e-9.
    pub fn level_with_power(&self, effect: f64, power: f64) -> f64 {
        let detects = |level: f64| self.miss_at(effect, level) <= 1.0 - power;
        if detects(ALPHA) {
            return ALPHA;
        }
        let (mut low, mut high) = (ALPHA, 1.0);
        while high > low * (1.0 + 1e-9) {
            let middle = (low * high).sqrt();
            if detects(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        high
    }

    /// Returns the probability of a miss on the worse side of the hypothesis; an effect that is
    /// impossible on one side (a probability above 1) is looked for on the other.
    pub fn worst_miss(&self, size: f64) -> f64 {
        self.worst_miss_beyond(size, ALPHA, self.critical(ALPHA))
    }

    fn worst_miss_beyond(&self, size: f64, alpha: f64, critical: f64) -> f64 {
        let miss = |effect| self.miss_beyond(effect, alpha, critical);
        match self {
            Self::Binomial { .. } | Self::Poisson { .. } => miss(size).max(miss(-size)),
            // Both sides are alike.
            _ => miss(size),
        }
    }

    /// Returns the smallest effect that is missed with probability at most `chance`, on either
    /// side; infinite if there is none.
    pub fn smallest_effect(&self, chance: f64) -> f64 {
        self.smallest_effect_at(chance, ALPHA)
    }

    /// Returns the smallest effect that is missed with probability at most `chance` at level
    /// `alpha`.
    pub fn smallest_effect_at(&self, chance: f64, alpha: f64) -> f64 {
        let critical = self.critical(alpha);
        smallest_detected(|size| self.worst_miss_beyond(size, alpha, critical) <= chance)
    }
}

/// Returns the smallest effect, in *estimated* standard errors, that a t test at a two-sided
/// `level` misses with probability at most `chance`, averaged over the estimate: an effect found in
/// some values is looked for in others, whose standard error is another estimate. `dof` > 0,
/// infinite if the standard error is known.
pub fn smallest_effect_in_estimates(dof: f64, level: f64, chance: f64) -> f64 {
    // Equally likely quantiles of the estimate over the true standard error.
    let quantiles: Vec<f64> = match dof < 1e6 {
        true => (0..64)
            .map(|i| (chi_square_upper((f64::from(i) + 0.5) / 64.0, dof) / dof).sqrt())
            .collect(),
        false => vec![1.0],
    };
    let critical = critical(dof, level);
    let miss = |size: f64| {
        quantiles
            .iter()
            .map(|estimate| noncentral_miss(size * estimate, critical, dof))
            .sum::<f64>()
    };
    smallest_detected(|size| miss(size) <= chance * quantiles.len() as f64)
}

/// Returns the smallest detected size, if larger ones are detected, too; infinite if none is.
fn smallest_detected(detects: impl Fn(f64) -> bool) -> f64 {
    if detects(f64::MIN_POSITIVE) {
        return 0.0;
    }
    // Powers of two bracket it, bisection narrows it down: misses fall as effects grow. From below,
    // as it takes long to sum the probability to miss an effect of many standard errors.
    let mut high = 0.5_f64.powi(20);
    while !detects(high) {
        high *= 2.0;
        if high > 1e30 {
            return f64::INFINITY;
        }
    }
    while detects(0.5 * high) {
        high *= 0.5;
    }
    let mut low = 0.5 * high;
    while high - low > 1e-9 * high {
        let middle = 0.5 * (low + high);
        if detects(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

/// Returns the L at which a deviation just reaches the radius `root` √L + `range` L: a quadratic
/// equation in √L, solved without cancellation.
pub(crate) fn bernstein_exponent(deviation: f64, root: f64, range: f64) -> f64 {
    (2.0 * deviation / (root + (root * root + 4.0 * range * deviation).sqrt())).powi(2)
}

fn normal_miss(size: f64, standard_error: f64, dof: f64, critical: f64) -> f64 {
    if standard_error == 0.0 {
        return if size > 0.0 { 0.0 } else { 1.0 };
    }
    noncentral_miss(size / standard_error, critical, dof)
}

/// Returns the t beyond which a two-sided level rejects.
fn critical(dof: f64, level: f64) -> f64 {
    if dof.is_finite() {
        student_upper(level / 2.0, dof.max(1.0))
    } else {
        normal_upper(level / 2.0)
    }
}

/// Returns the miss probability from the noncentral t distribution at the critical value c: (c (1 −
/// 1/(4ν)) − δ)/√(1 + c²/(2ν)) is close to normal (Abramowitz and Stegun, 26.7.10).
fn noncentral_miss(shift: f64, critical: f64, dof: f64) -> f64 {
    let spread = (1.0 + critical * critical / (2.0 * dof)).sqrt();
    let bound = critical * (1.0 - 0.25 / dof);
    // Values beyond the other critical value are rejected, too.
    normal_sf((shift - bound) / spread) - normal_sf((shift + bound) / spread)
}

/// Returns P(k is accepted) under probability q of the two-sided exact test of `null`; 0 for the
/// impossible q outside [0, 1].
fn binomial_miss(n: u64, null: f64, q: f64, alpha: f64) -> f64 {
    if !(0.0..=1.0).contains(&q) {
        return 0.0;
    }
    // First rejected count above, and number of rejected counts below.
    let above = first_true(n + 1, |k| 2.0 * binomial_sf(k, n, null) < alpha);
    let below = first_true(n + 1, |k| 2.0 * binomial_cdf(k, n, null) >= alpha);
    let (cdf, sf) = (|k| binomial_cdf(k, n, q), |k| binomial_sf(k, n, q));
    acceptance_probability(below, above, cdf, sf)
}

/// Returns P(k is accepted) under a Poisson mean `mean` of the two-sided exact test of `null`; 0
/// for the impossible mean below 0.
fn poisson_miss(null: f64, mean: f64, alpha: f64) -> f64 {
    if mean < 0.0 {
        return 0.0;
    }
    let max_count = (null + 100.0 * null.sqrt() + 1000.0).ceil() as u64;
    let above = first_true(max_count, |k| 2.0 * poisson_sf(k, null) < alpha);
    let below = first_true(max_count, |k| 2.0 * poisson_cdf(k, null) >= alpha);
    let (cdf, sf) = (|k| poisson_cdf(k, mean), |k| poisson_sf(k, mean));
    acceptance_probability(below, above, cdf, sf)
}

/// Returns P(below ≤ K < above), from the tails on the side on which they are small.
fn acceptance_probability(
    below: u64,
    above: u64,
    cdf: impl Fn(u64) -> f64,
    sf: impl Fn(u64) -> f64,
) -> f64 {
    if above <= below {
        0.0
    } else if cdf(above - 1) < sf(below) {
        cdf(above - 1) - below.checked_sub(1).map_or(0.0, &cdf)
    } else {
        sf(below) - sf(above)
    }
}

/// Returns the first of 0..end where an increasing condition is true; `end` if there is none.
fn first_true(end: u64, holds: impl Fn(u64) -> bool) -> u64 {
    let (mut low, mut high) = (0, end);
    while low < high {
        let middle = low + (high - low) / 2;
        if holds(middle) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    low
}
