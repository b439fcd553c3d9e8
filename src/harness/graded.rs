//! Graded controls: the correct subject's values, off by exactly the size of the claim.
//!
//! Gross faults show that a trial can fail; graded controls show that it fails at the size it
//! claims. Each statistic runs again on transformed values: values are scaled or shifted, samples
//! moved from cell to cell, counts changed. Nothing new is drawn, so they cost nothing.
//!
//! For statistics with an interval they add no chance of a false alarm: a claim holds if its
//! interval lies within δ, and then the values that are off by δ are rejected. Cells are tested
//! jointly, and have their own shares of the error budget.

use super::outcome::{Claim, Graded, Outcome};

/// Adds to the outcome its graded controls, of both signs. `rerun` runs the statistic on values
/// that are off by an effect; `None` if no values can be.
pub(super) fn grade(mut outcome: Outcome, rerun: impl Fn(f64) -> Option<Outcome>) -> Outcome {
    let size = outcome.claim.size();
    let off = outcome.estimate - outcome.reference;
    let effects = match outcome.claim {
        Claim::Equal { .. } => vec![size, -size],
        Claim::Equivalent { .. } => vec![size - off, -size - off, 2.0 * size, -2.0 * size],
        Claim::Test => Vec::new(),
    };
    if !outcome.is_random() || size.is_nan() || size <= 0.0 {
        return outcome;
    }
    outcome.graded = effects
        .into_iter()
        .filter_map(|effect| {
            let mut outcome = rerun(effect)?;
            outcome.cells = Vec::new();
            Some(Graded { effect, outcome })
        })
        .collect();
    outcome
}
