//! The guard of the error budget: refuses an outcome that chance would turn red more often than its
//! share allows.
//!
//! A right subject is red not only when it is rejected, but also when it stays undecided; a fault
//! is red when it is accepted. Both are as rare as the budget says only if the effect in question
//! is far enough from what can be told apart: δ (or the margin) of a subject that is to hold must
//! be at least its minimum detectable effect, and a fault must be so far off that a miss is
//! practically impossible. Every row that chance can turn red in `cargo test` goes through one of
//! the two functions here.
//!
//! The guard judges the sizes of samples, not the program: it is asked under the default seed alone
//! ([`Context::is_planned`](super::trial::Context::is_planned)). There it says the same in every
//! run, so no chance of its own adds to the budget, and under other seeds it cannot refuse. What it
//! asks for is [`ROOM`]: then verdicts under other seeds have the chances that the shares count.

use super::mean::{LARGEST_SKEW_TERM, Sigma};
use super::outcome::{ALPHA, Claim, Outcome, Verdict};
use super::power::Sensitivity;
use super::tails::normal_upper;

/// So many standard deviations of its own noise must a standard error, or a sample's skewness, be
/// within what is allowed under the default seed. At six, the true standard error and skewness are
/// within it as well, but for a chance of a share, and with them the power stated under every seed.
pub const ROOM: f64 = 6.0;

/// A fault must be rejected by this many standard errors. Seen once, the effect is, but for a
/// chance of 1e-12 ([`FAR_MISS`]), at least 13 standard errors, and then the chance that another
/// seed's rejection stays below the critical value is again less than that.
pub const FAR: f64 = 20.2;

/// The chance that a fault held to [`FAR`] is not rejected, at most.
pub const FAR_MISS: f64 = 1e-12;

/// The relative noise of the outcome's standard error; 0 where it is known, or the law is that of
/// counts.
fn noise(outcome: &Outcome) -> f64 {
    match outcome.sensitivity {
        Sensitivity::Normal { dof, .. } => (0.5 / dof).sqrt(),
        _ => 0.0,
    }
}

/// How much of what skewness may do it does, and the noise of that: the skewness of n values varies
/// by √(6/n), and its effect on the tail falls as 1/√n. Kurtosis counts by the degrees of freedom
/// that it leaves.
fn skewness(outcome: &Outcome) -> [f64; 2] {
    let Sensitivity::Normal { dof, .. } = outcome.sensitivity else {
        return [0.0; 2];
    };
    let n = outcome.n as f64;
    let used = if outcome.valid_from <= 2 {
        0.0
    } else {
        (outcome.valid_from as f64 / n).sqrt()
    };
    let (values, sigma) = if dof.is_finite() {
        (dof, Sigma::Estimated)
    } else {
        (n, Sigma::Known)
    };
    let z = normal_upper(0.5 * ALPHA);
    [
        used,
        sigma.skew_term(6_f64.sqrt() / values, z) / LARGEST_SKEW_TERM,
    ]
}

/// Why an outcome that is to hold may end red by chance more often than its share: its δ or margin
/// is not its minimum detectable effect with room for the noise of its own standard error, or too
/// little of what skewness may do is left. `None` if all is well, or nothing is random.
pub fn may_not_hold(outcome: &Outcome) -> Option<String> {
    if !outcome.is_random() {
        return None;
    }
    let [used, noise_of_skewness] = skewness(outcome);
    if used + ROOM * noise_of_skewness > 1.0 {
        return Some(format!(
            "{}: skewness uses {used:.2} of what it may, varying by {noise_of_skewness:.2}; needs about {:.0} samples",
            outcome.name,
            outcome.n as f64 * (used + ROOM * noise_of_skewness).powi(2)
        ));
    }
    let found = outcome.minimum_detectable_effect() * (1.0 + ROOM * noise(outcome));
    let size = outcome.claim.size();
    // NaN is refused, too.
    let seen = if outcome.claim == Claim::Test {
        found.is_finite()
    } else {
        found <= size
    };
    (!seen).then(|| {
        format!(
            "{}: detects {found:.3e} for certain, not {size:.3e}; power {}; needs {:.0} samples",
            outcome.name,
            outcome.power(),
            outcome.n as f64 * (found / size).powi(2)
        )
    })
}

/// By how many standard errors the outcome is rejected: of the claim's p-value, of the distance
/// beyond the margin of an approximate one; infinite for an exact identity, 0 where it is not
/// rejected.
pub fn distance(outcome: &Outcome) -> f64 {
    if outcome.verdict() != Verdict::Fails || outcome.p.is_nan() {
        return 0.0;
    }
    if !outcome.is_random() {
        return f64::INFINITY;
    }
    match outcome.claim {
        Claim::Approximate { margin } => {
            let beyond = (outcome.estimate - outcome.reference).abs() - margin;
            beyond / outcome.half_width() * normal_upper(0.5 * ALPHA)
        }
        // Where p is too small for a number, so is any doubt.
        Claim::Exact { .. } | Claim::Test if outcome.p <= 0.0 => f64::INFINITY,
        Claim::Exact { .. } | Claim::Test => normal_upper(0.5 * outcome.p),
    }
}

/// Why an outcome that must reject a fault may not do so by chance: it is not rejected by [`FAR`]
/// standard errors. `None` if it is.
pub fn may_hold(outcome: &Outcome) -> Option<String> {
    let distance = distance(outcome);
    (distance < FAR).then(|| {
        format!(
            "{}: rejected by {distance:.1} standard errors, needs {FAR}",
            outcome.name
        )
    })
}

/// Whether a fault is rejected so that a larger sample would add nothing: by [`FAR`] standard
/// errors, for a finite estimate, from a sample whose skewness is known to half of what it may be.
pub fn settled(outcome: &Outcome) -> bool {
    let [_, noise_of_skewness] = skewness(outcome);
    noise_of_skewness <= 0.5 && outcome.estimate.is_finite() && distance(outcome) >= FAR
}
