//! Sequential tests: their error is bounded whenever they stop.

/// Decision of a sequential test so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// Not enough values yet.
    Continue,
    /// The null hypothesis is accepted against the alternative.
    Null,
    /// The alternative is accepted against the null hypothesis.
    Alternative,
}

/// Wald's sequential probability ratio test (Ann. Math. Stat. 16(2), 1945).
///
/// Guarantee: with thresholds ln(1/α) and ln β, a true null hypothesis is rejected with probability
/// at most α, a true alternative at most β, at whatever time the test stops: its power is at least
/// 1 − β by construction. (The likelihood ratio is a non-negative martingale under the null
/// hypothesis, its reciprocal under the alternative; Ville's inequality.)
#[derive(Clone, Copy, Debug)]
pub struct Sprt {
    log_ratio: f64,
    upper: f64,
    lower: f64,
    count: u64,
}

impl Sprt {
    /// Creates a test with error probabilities at most `alpha` and `beta`, both in (0, 1).
    pub fn new(alpha: f64, beta: f64) -> Self {
        Self {
            log_ratio: 0.0,
            upper: -alpha.ln(),
            lower: beta.ln(),
            count: 0,
        }
    }

    /// Adds one Bernoulli value; probability `null` against `alternative`, both in (0, 1).
    pub fn bernoulli(&mut self, success: bool, null: f64, alternative: f64) -> Decision {
        self.add(if success {
            (alternative / null).ln()
        } else {
            ((1.0 - alternative) / (1.0 - null)).ln()
        })
    }

    /// Adds one normal value with known standard deviation `sigma`; mean `null` against
    /// `alternative`.
    pub fn normal(&mut self, value: f64, null: f64, alternative: f64, sigma: f64) -> Decision {
        let middle = 0.5 * (null + alternative);
        self.add((alternative - null) * (value - middle) / (sigma * sigma))
    }

    /// Returns the number of values.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Returns the decision so far; final once it is not [`Decision::Continue`].
    pub fn decision(&self) -> Decision {
        if self.log_ratio >= self.upper {
            Decision::Alternative
        } else if self.log_ratio <= self.lower {
            Decision::Null
        } else {
            Decision::Continue
        }
    }

    fn add(&mut self, log_likelihood_ratio: f64) -> Decision {
        if self.decision() == Decision::Continue {
            self.count += 1;
            self.log_ratio += log_likelihood_ratio;
        }
        self.decision()
    }
}

/// A confidence sequence for the mean of values in [low, high]: the predictable plug-in empirical
/// Bernstein sequence of Waudby-Smith and Ramdas ("Estimating means of bounded random variables by
/// betting", JRSS B 86(1), 2024, theorem 2).
///
/// Guarantee: the probability that the mean is *ever* outside the interval is at most α, for every
/// law on [low, high]; looking after every value costs nothing.
#[derive(Clone, Debug)]
pub struct ConfidenceSequence {
    bounds: [f64; 2],
    log_term: f64,
    count: f64,
    sum: f64,
    squares: f64,
    weights: f64,
    weighted: f64,
    penalty: f64,
}

/// Bound of the bets, so that ln(1 − λ) is finite (the paper's c).
const LARGEST_BET: f64 = 0.5;

impl ConfidenceSequence {
    /// Creates a sequence at level 1 − `alpha` for values in [low, high].
    pub fn new(alpha: f64, bounds: [f64; 2]) -> Self {
        Self {
            bounds,
            log_term: (2.0 / alpha).ln(),
            count: 0.0,
            sum: 0.0,
            squares: 0.0,
            weights: 0.0,
            weighted: 0.0,
            penalty: 0.0,
        }
    }

    /// Adds one value. NaN makes the interval NaN.
    pub fn push(&mut self, value: f64) {
        let [low, high] = self.bounds;
        let x = (value - low) / (high - low);
        let t = self.count + 1.0;
        // The bet depends only on values before x.
        let mean_before = (0.5 + self.sum) / t;
        let variance_before = (0.25 + self.squares) / t;
        let bet = (2.0 * self.log_term / (variance_before * t * (1.0 + t).ln()))
            .sqrt()
            .min(LARGEST_BET);
        let surprise = (x - mean_before).powi(2);
        self.weights += bet;
        self.weighted += bet * x;
        self.penalty += surprise * (-(-bet).ln_1p() - bet);
        self.count = t;
        self.sum += x;
        let mean_now = (0.5 + self.sum) / (t + 1.0);
        self.squares += (x - mean_now).powi(2);
    }

    /// Returns the interval so far.
    pub fn interval(&self) -> [f64; 2] {
        let [low, high] = self.bounds;
        if self.count == 0.0 {
            return [low, high];
        }
        let centre = self.weighted / self.weights;
        let half = (self.log_term + self.penalty) / self.weights;
        [centre - half, centre + half].map(|x| low + (high - low) * x)
    }

    /// Returns the smallest effect that is detected with probability at least 1 − α after these
    /// values: the width of the interval. As long as the interval covers the mean, it excludes
    /// every reference further off.
    pub fn minimum_detectable_effect(&self) -> f64 {
        let [low, high] = self.interval();
        high - low
    }

    /// Returns the number of values.
    pub fn count(&self) -> u64 {
        self.count as u64
    }

    /// Decides whether the mean is within ±`margin` of `reference`: [`Decision::Null`] once the
    /// interval lies within, [`Decision::Alternative`] once it excludes `reference` itself.
    pub fn decide(&self, reference: f64, margin: f64) -> Decision {
        let [low, high] = self.interval();
        if low > reference || high < reference {
            Decision::Alternative
        } else if low >= reference - margin && high <= reference + margin {
            Decision::Null
        } else {
            Decision::Continue
        }
    }
}
