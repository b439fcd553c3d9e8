//! Outcome of one statistic, and the three-valued verdict on it.

use std::fmt;

pub use super::level::{ALPHA, CAPACITY, SUITE_BUDGET};
use super::power::Sensitivity;

/// Level, 20 standard errors, at which a rejection stands even where the normal approximation of
/// the tail is not valid at [`ALPHA`], if n is at least 1/[`DECISIVE_DIVISOR`] of the number for
/// which it is.
///
/// Skewness γ changes the logarithm of a tail probability by up to |γ| z³/(3√n). For a valid tail
/// that is at most 0.3 at z = 6.1; for a sixteenth of the samples 1.2, and so 42 at z = 20, where
/// the logarithm itself is z²/2 = 200.
pub const DECISIVE_LEVEL: f64 = 1e-90;
/// Divisor of the number of values that [`DECISIVE_LEVEL`] requires.
pub const DECISIVE_DIVISOR: u64 = 16;

/// Claim about an estimate, with its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Claim {
    /// Equal to the reference; an effect of size `delta` must be detected.
    Equal {
        /// δ > 0, in the units of the estimate.
        delta: f64,
    },
    /// Within ±`margin` of the reference.
    Equivalent {
        /// Δ > 0, in the units of the estimate.
        margin: f64,
    },
    /// Rejected or not rejected; no size of effect is claimed (maps of tiles and pixels).
    Test,
}

impl Claim {
    /// Returns δ or Δ; 0 where no size is claimed.
    pub fn size(self) -> f64 {
        match self {
            Self::Equal { delta } => delta,
            Self::Equivalent { margin } => margin,
            Self::Test => 0.0,
        }
    }
}

/// Verdict of a test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The claim stands, at its size.
    Holds,
    /// The claim is rejected.
    Fails,
    /// There are too few samples to decide.
    Undecided {
        /// About how many samples would decide.
        needed: u64,
    },
}

impl Verdict {
    /// Returns one word for tables.
    pub fn word(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Fails => "fails",
            Self::Undecided { .. } => "undecided",
        }
    }
}

/// Returns the verdict on an exact claim: fails if p < [`ALPHA`]; holds if not, and the interval
/// lies within ±`delta` of the reference; else undecided. `n` samples gave the interval.
pub fn equality_verdict(p: f64, interval: [f64; 2], reference: f64, delta: f64, n: u64) -> Verdict {
    if p < ALPHA || p.is_nan() {
        Verdict::Fails
    } else if within(interval, reference, delta) {
        Verdict::Holds
    } else {
        undecided_verdict(interval, delta, n)
    }
}

/// Returns the verdict on an approximate claim: holds if the interval lies within ±`margin` of the
/// reference, fails if it lies wholly outside, else undecided.
pub fn equivalence_verdict(interval: [f64; 2], reference: f64, margin: f64, n: u64) -> Verdict {
    let [low, high] = interval;
    if low.is_nan() || high.is_nan() || low > reference + margin || high < reference - margin {
        Verdict::Fails
    } else if within(interval, reference, margin) {
        Verdict::Holds
    } else {
        undecided_verdict(interval, margin, n)
    }
}

fn within([low, high]: [f64; 2], reference: f64, size: f64) -> bool {
    low >= reference - size && high <= reference + size
}

/// Estimates the samples needed: the interval's half-width shrinks as 1/√n, and a claim is decided
/// almost surely once its size is twice that.
fn undecided_verdict([low, high]: [f64; 2], size: f64, n: u64) -> Verdict {
    let needed = n as f64 * ((high - low) / size).powi(2);
    Verdict::Undecided {
        // A float cast saturates: an infinite interval asks for u64::MAX samples.
        needed: needed.ceil().max(n as f64 + 1.0) as u64,
    }
}

/// A cell of a histogram, a tile or a pixel, for data files and plots.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// Place, in words.
    pub place: String,
    /// Expected value under the hypothesis.
    pub expected: f64,
    /// Observed value.
    pub observed: f64,
    /// Difference in standard deviations.
    pub sigmas: f64,
}

impl Cell {
    /// Creates a cell whose observed value has this standard deviation. An observed value that is
    /// the expected one is 0 standard deviations off, even if that is 0.
    pub(super) fn new(place: String, expected: f64, observed: f64, deviation: f64) -> Self {
        let difference = observed - expected;
        Self {
            place,
            expected,
            observed,
            sigmas: if difference == 0.0 {
                0.0
            } else {
                difference / deviation
            },
        }
    }
}

/// Outcome of one statistic.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Quantity that was measured: "mean of z", "chi-square".
    pub name: String,
    /// Name of the statistic: "t", "chi-square", "binomial", "exact".
    pub statistic: &'static str,
    /// Value of the statistic.
    pub value: f64,
    /// Degrees of freedom of the statistic, where it has any.
    pub dof: Option<f64>,
    /// p-value: the probability of a value at least as extreme under the hypothesis.
    pub p: f64,
    /// Number of independent values.
    pub n: u64,
    /// Least number of values for which the tail is valid.
    pub valid_from: u64,
    /// Estimated quantity (a mean, a worst relative deviation).
    pub estimate: f64,
    /// Value that the estimate should have.
    pub reference: f64,
    /// Confidence interval of the estimate at level 1 − [`ALPHA`].
    pub interval: [f64; 2],
    /// Claim about the estimate.
    pub claim: Claim,
    /// Response of the statistic to an effect, which gives its power.
    pub sensitivity: Sensitivity,
    /// Worst cell, tile, pixel or argument, in words.
    pub worst: String,
    /// Contents of the data file and its plot: the cells of a histogram, tiles, pixels, means of
    /// batches, points of a distribution function. Empty for exact identities.
    pub cells: Vec<Cell>,
    /// The statistic on the same values made wrong by the size of the claim; empty where nothing is
    /// random.
    pub graded: Vec<Graded>,
}

impl Outcome {
    /// Creates the outcome of an identity that is not random: the largest error found over `n`
    /// arguments against its tolerance; `worst` names the argument. Without arguments it is
    /// undecided.
    pub fn identity(
        name: impl Into<String>,
        n: u64,
        error: f64,
        tolerance: f64,
        worst: impl Into<String>,
    ) -> Self {
        Self {
            name: name.into(),
            statistic: "exact",
            value: error,
            dof: None,
            // NaN must fail, hence the comparison that NaN does not satisfy.
            p: if error.abs() <= tolerance { 1.0 } else { 0.0 },
            n,
            valid_from: 1,
            estimate: error,
            reference: 0.0,
            interval: [error, error],
            claim: Claim::Equal { delta: tolerance },
            sensitivity: Sensitivity::Certain,
            worst: worst.into(),
            cells: Vec::new(),
            graded: Vec::new(),
        }
    }

    /// Makes the outcome undecided because its sample is no evidence (no values, one value, one
    /// cell, no variance). `needed` values might decide; `u64::MAX` if more of the same will not.
    /// NaN still fails.
    pub(crate) fn undecided(mut self, why: &str, needed: u64) -> Self {
        let bad = self.estimate.is_nan() && self.n > 0;
        self.p = if bad { f64::NAN } else { 1.0 };
        self.interval = [f64::NEG_INFINITY, f64::INFINITY];
        self.valid_from = needed.max(self.n.saturating_add(1));
        // No effect would be detected.
        self.sensitivity = Sensitivity::Normal {
            standard_error: f64::INFINITY,
            dof: f64::INFINITY,
            tests: 1,
        };
        self.worst = format!("says nothing: {why}");
        self
    }

    /// Returns the outcome under another name.
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// Claims equality within ±δ only: for two means one of which is known to be biased.
    pub fn as_equivalence(mut self) -> Self {
        self.claim = Claim::Equivalent {
            margin: self.claim.size(),
        };
        self
    }

    /// Returns whether chance can change the verdict: such outcomes use up the suite's error
    /// budget.
    pub fn is_random(&self) -> bool {
        self.statistic != "exact"
    }

    /// Returns the verdict at level [`ALPHA`].
    pub fn verdict(&self) -> Verdict {
        if self.p.is_nan() {
            return Verdict::Fails;
        }
        let verdict = self.verdict_of_claim();
        let decisive = verdict == Verdict::Fails
            && self.p < DECISIVE_LEVEL
            && self.value.is_finite()
            && self.n >= self.valid_from / DECISIVE_DIVISOR;
        if self.n < self.valid_from && !decisive {
            return Verdict::Undecided {
                needed: self.valid_from,
            };
        }
        verdict
    }

    /// Returns the verdict if the tail is valid.
    fn verdict_of_claim(&self) -> Verdict {
        match self.claim {
            Claim::Equal { delta } => {
                equality_verdict(self.p, self.interval, self.reference, delta, self.n)
            }
            Claim::Equivalent { margin } => {
                equivalence_verdict(self.interval, self.reference, margin, self.n)
            }
            Claim::Test if self.p < ALPHA => Verdict::Fails,
            Claim::Test => Verdict::Holds,
        }
    }

    /// Returns half the width of the interval.
    pub fn half_width(&self) -> f64 {
        0.5 * (self.interval[1] - self.interval[0])
    }

    /// Returns the smallest δ or margin for which the verdict is right with probability at least 1
    /// − [`ALPHA`]: an effect of that size is rejected, and a correct subject holds. For an exact
    /// identity, its tolerance.
    pub fn minimum_detectable_effect(&self) -> f64 {
        if self.is_random() {
            self.sensitivity.smallest_effect(ALPHA / self.sides())
        } else {
            self.claim.size()
        }
    }

    /// Returns 1 − power: the probability that an effect of the claim's size is not rejected, or
    /// that a correct subject does not hold, on either side. Where no size is claimed, that of the
    /// minimum detectable effect, which is [`ALPHA`] by definition. 0 for exact identities.
    pub fn miss(&self) -> f64 {
        if self.claim == Claim::Test {
            ALPHA
        } else {
            (self.sides() * self.sensitivity.worst_miss(self.claim.size())).min(1.0)
        }
    }

    /// Returns the power in words: "exact", "0.87", or near 1 as its complement: "1 - 2.3e-12".
    pub fn power(&self) -> String {
        let miss = self.miss();
        if !self.is_random() {
            String::from("exact")
        } else if miss < 0.01 {
            format!("1 - {miss:.1e}")
        } else {
            format!("{:.2}", 1.0 - miss)
        }
    }

    /// Returns the number of sides on which an estimate may leave ±δ or the margin. With both
    /// counted, a correct subject stays undecided with the level's own probability: for an exact
    /// claim that is the very event of a rejection if the minimum detectable effect is δ.
    fn sides(&self) -> f64 {
        match self.claim {
            Claim::Equal { .. } | Claim::Equivalent { .. } => 2.0,
            Claim::Test => 1.0,
        }
    }
}

/// Prints one line: "mean: fails; 0.510 in [0.503, 0.517], should be 0.5 ± 0.001 (t = 9.2, n =
/// 1000000, p = 3.1e-20)".
impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [low, high] = self.interval;
        write!(
            f,
            "{}: {}; {} in [{low}, {high}], should be {} ± {} ({} = {}, n = {}, p = {:.1e})",
            self.name,
            self.verdict().word(),
            self.estimate,
            self.reference,
            self.claim.size(),
            self.statistic,
            self.value,
            self.n,
            self.p
        )?;
        if self.worst.is_empty() {
            Ok(())
        } else {
            write!(f, "; {}", self.worst)
        }
    }
}

/// Outcome of a statistic on values that are off by a known effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Graded {
    /// Error of the estimated value, with its sign, in the units of the estimate.
    pub effect: f64,
    /// Outcome of the statistic on those values.
    pub outcome: Outcome,
}

/// Relative allowance for rounding where an effect is compared with a margin.
const ROUNDING: f64 = 1e-9;

impl Graded {
    /// Returns whether the verdict is the one that the effect demands: an exact claim fails at δ;
    /// an approximate one, whose value need not be the reference, does not hold where the estimate
    /// lies at its margin, and fails if twice the margin is added.
    pub fn has_required_verdict(&self) -> bool {
        let verdict = self.outcome.verdict();
        match self.outcome.claim {
            Claim::Equivalent { margin } if self.effect.abs() < 2.0 * margin * (1.0 - ROUNDING) => {
                verdict != Verdict::Holds
            }
            Claim::Test => true,
            Claim::Equal { .. } | Claim::Equivalent { .. } => verdict == Verdict::Fails,
        }
    }
}
