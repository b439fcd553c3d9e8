//! Graded controls: the right subject's values, off by exactly the size of the claim.
//!
//! Gross faults show that a trial can fail; these show that it fails where it says. Each statistic
//! runs again on transformed values: drawn ones are scaled or shifted, samples are moved from cell
//! to cell, counts change by as many events. Nothing new is drawn, so they cost nothing.
//!
//! For statistics with an interval they are no new chance of a false alarm: a claim holds if its
//! interval lies within δ, and then the values that are off by δ are rejected. Cells are tested
//! jointly, and have shares of their own.

use super::outcome::{Claim, Outcome, Verdict};

/// What a statistic says of values that are off by a known effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Graded {
    /// By how much the estimated value is off, with its sign, in the units of the estimate.
    pub effect: f64,
    /// The statistic on those values.
    pub outcome: Outcome,
}

/// Room for rounding where an effect is compared with a margin.
const ROUNDING: f64 = 1e-9;

impl Graded {
    /// Whether the verdict is what the effect demands: an exact claim fails at δ; an approximate
    /// one, whose value need not be the reference, does not hold where the estimate lies at its
    /// margin, and fails if twice the margin is added.
    pub fn is_answered(&self) -> bool {
        let verdict = self.outcome.verdict();
        match self.outcome.claim {
            Claim::Approximate { margin }
                if self.effect.abs() < 2.0 * margin * (1.0 - ROUNDING) =>
            {
                verdict != Verdict::Holds
            }
            Claim::Test => true,
            Claim::Exact { .. } | Claim::Approximate { .. } => verdict == Verdict::Fails,
        }
    }
}

/// The outcome with its graded controls, of both signs; `again` runs the statistic on values that
/// are off by an effect, or says that no values can be.
pub(super) fn grade(mut outcome: Outcome, again: impl Fn(f64) -> Option<Outcome>) -> Outcome {
    let size = outcome.claim.size();
    let off = outcome.estimate - outcome.reference;
    let effects = match outcome.claim {
        Claim::Exact { .. } => vec![size, -size],
        Claim::Approximate { .. } => vec![size - off, -size - off, 2.0 * size, -2.0 * size],
        Claim::Test => Vec::new(),
    };
    if !outcome.is_random() || size.is_nan() || size <= 0.0 {
        return outcome;
    }
    outcome.graded = effects
        .into_iter()
        .filter_map(|effect| {
            let mut outcome = again(effect)?;
            outcome.cells = Vec::new();
            Some(Graded { effect, outcome })
        })
        .collect();
    outcome
}
