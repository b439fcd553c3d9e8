//! Rejection of faulty subjects by no more of the sample than it takes.

use std::f64::consts::FRAC_1_SQRT_2;

use super::check::required_outcomes;
use super::{Context, Run, Shared};
use crate::harness::guard::{is_clearly_rejected, is_promising};
use crate::harness::outcome::Outcome;

/// Outcomes of a trial on a faulty subject.
pub struct Rejection {
    /// Outcomes.
    pub outcomes: Vec<Outcome>,
    /// Fraction of the trial's sample that gave them, in (0, 1].
    pub share: f64,
}

/// Fractions of a trial's sample on which a fault runs before the whole: powers of √½.
const PARTS: [f64; 12] = [
    1.0 / 64.0,
    FRAC_1_SQRT_2 / 32.0,
    1.0 / 32.0,
    FRAC_1_SQRT_2 / 16.0,
    1.0 / 16.0,
    FRAC_1_SQRT_2 / 8.0,
    1.0 / 8.0,
    FRAC_1_SQRT_2 / 4.0,
    1.0 / 4.0,
    FRAC_1_SQRT_2 / 2.0,
    1.0 / 2.0,
    FRAC_1_SQRT_2,
];

/// Runs a trial's function on a faulty subject that the outcomes named `rejected_by` must reject
/// (see [`required_outcomes`]). Most effects are many times δ, so the function runs on a part of
/// the sample first, and on a larger one only if the fault is not
/// [clearly rejected](is_clearly_rejected). The parts are fixed beforehand; those that hardly
/// [promise](is_promising) a clear rejection, after what a smaller one has shown, are left out.
/// After one that did not keep its promise the next is twice as large or more. The function is told
/// [which outcomes](Context::asked) must reject, and makes what all parts need
/// [once](Context::once).
pub fn reject(run: &Run, rejected_by: &[&'static str], context: &Context) -> Rejection {
    let context = &Context {
        asked: rejected_by.to_vec(),
        shared: Shared::default().next_run(),
        ..context.clone()
    };
    let [first, ..] = PARTS;
    let mut next = first;
    for share in PARTS {
        if share < next {
            continue;
        }
        let part = Context {
            scale: context.scale * share,
            shared: context.shared.next_run(),
            ..context.clone()
        };
        let outcomes = run(&part);
        let required = required_outcomes(rejected_by, &outcomes);
        let is_clear = |outcome: &&Outcome| is_clearly_rejected(outcome, share);
        if !required.is_empty() && required.iter().all(is_clear) {
            return Rejection { outcomes, share };
        }
        let promises = |later: &f64| required.iter().all(|o| is_promising(o, share, *later));
        // Between a step and the next, so that rounding of powers does not matter.
        let least = if share > first {
            1.7 * share
        } else {
            1.2 * share
        };
        let larger = PARTS.into_iter().filter(|later| *later > least);
        next = larger.into_iter().find(promises).unwrap_or(1.0);
    }
    Rejection {
        outcomes: run(context),
        share: 1.0,
    }
}
