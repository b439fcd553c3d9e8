//! Guard of the error budget: refuses an outcome that chance would turn red more often than its
//! share of the budget allows.
//!
//! A correct subject is red not only when it is rejected, but also when it stays undecided; a fault
//! is red when it is accepted. Both are as rare as the budget says only if the effect in question
//! is large enough: δ (or the margin) of a subject that is to hold must be at least its minimum
//! detectable effect, and a fault must be so far off that a miss is practically impossible. Every
//! row that chance can turn red in `cargo test` goes through one of the two functions here.
//!
//! The guard judges sample sizes, not the program: it runs under the default seed alone
//! ([`Context::guard_applies`](super::trial::Context::guard_applies)). There it gives the same
//! answer in every run, so it adds no chance of its own to the budget, and under other seeds it
//! cannot refuse. It demands [`SAFETY_SIGMAS`]; then verdicts under other seeds have the
//! probabilities that the budget counts.

use super::mean::{MAX_SKEW_TERM, Sigma};
use super::outcome::{ALPHA, Claim, DECISIVE_DIVISOR, Outcome, Verdict};
use super::power::Sensitivity;
use super::tails::normal_upper;

/// Number of standard deviations of its own noise by which a standard error, or a sample's
/// skewness, must be within its limit under the default seed. At six, the true standard error and
/// skewness are within it as well, except with the probability of a share, and with them the power
/// stated holds under every seed.
pub const SAFETY_SIGMAS: f64 = 6.0;

/// Number of standard errors by which a fault must be rejected. If a fault is rejected by so many
/// once, the true effect exceeds 13 standard errors except with probability 1e-12
/// ([`MAX_FAULT_MISS`]), so other seeds reject it, too, except with a smaller probability still.
pub const FAULT_SIGMAS: f64 = 20.2;

/// Largest probability that a fault held to [`FAULT_SIGMAS`] is not rejected.
pub const MAX_FAULT_MISS: f64 = 1e-12;

/// Returns the relative noise of the outcome's standard error; 0 where it is known, or for counts.
fn standard_error_noise(outcome: &Outcome) -> f64 {
    match outcome.sensitivity {
        Sensitivity::Normal { dof, .. } => (0.5 / dof).sqrt(),
        _ => 0.0,
    }
}

/// Returns the used fraction of the allowed skewness, and its noise: the skewness of n values
/// varies by √(6/n), and its effect on the tail falls as 1/√n. Kurtosis counts through the degrees
/// of freedom.
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
        sigma.skew_term(6_f64.sqrt() / values, z) / MAX_SKEW_TERM,
    ]
}

/// Returns why an outcome that is to hold may end red by chance more often than its share: its δ or
/// margin is not its minimum detectable effect with room for the noise of its own standard error,
/// or skewness is too near its limit. `None` if all is well, or nothing is random.
pub fn power_objection(outcome: &Outcome) -> Option<String> {
    if !outcome.is_random() {
        return None;
    }
    let [used, noise_of_skewness] = skewness(outcome);
    if used + SAFETY_SIGMAS * noise_of_skewness > 1.0 {
        return Some(format!(
            "{}: skewness uses {used:.2} of its limit, varying by {noise_of_skewness:.2}; needs about {:.0} samples",
            outcome.name,
            outcome.n as f64 * (used + SAFETY_SIGMAS * noise_of_skewness).powi(2)
        ));
    }
    let detected =
        outcome.minimum_detectable_effect() * (1.0 + SAFETY_SIGMAS * standard_error_noise(outcome));
    let size = outcome.claim.size();
    // NaN is refused, too.
    let is_detected = if outcome.claim == Claim::Test {
        detected.is_finite()
    } else {
        detected <= size
    };
    (!is_detected).then(|| {
        format!(
            "{}: detects {detected:.3e} for certain, not {size:.3e}; power {}; needs {:.0} samples",
            outcome.name,
            outcome.power(),
            outcome.n as f64 * (detected / size).powi(2)
        )
    })
}

/// Returns by how many standard errors the outcome is rejected: from the claim's p-value, or the
/// distance beyond the margin of an approximate one; infinite for an exact identity, 0 where it is
/// not rejected.
pub fn rejection_sigmas(outcome: &Outcome) -> f64 {
    if outcome.verdict() != Verdict::Fails || outcome.p.is_nan() {
        return 0.0;
    }
    if !outcome.is_random() {
        return f64::INFINITY;
    }
    match outcome.claim {
        Claim::Equivalent { margin } => {
            let beyond = (outcome.estimate - outcome.reference).abs() - margin;
            beyond / outcome.half_width() * normal_upper(0.5 * ALPHA)
        }
        // A p-value that underflows leaves no doubt.
        Claim::Equal { .. } | Claim::Test if outcome.p <= 0.0 => f64::INFINITY,
        Claim::Equal { .. } | Claim::Test => normal_upper(0.5 * outcome.p),
    }
}

/// Returns why an outcome that must reject a fault may miss it by chance: it is not rejected by
/// [`FAULT_SIGMAS`] standard errors, or skewness is too near the limit above which nothing is
/// rejected. `None` if all is well.
pub fn fault_objection(outcome: &Outcome) -> Option<String> {
    let rejection_sigmas = rejection_sigmas(outcome);
    if rejection_sigmas < FAULT_SIGMAS {
        return Some(format!(
            "{}: rejected by {rejection_sigmas:.1} standard errors, needs {FAULT_SIGMAS}",
            outcome.name
        ));
    }
    let [used, noise] = skewness(outcome);
    // So far out a rejection stands for that many times as many values (`DECISIVE_LEVEL`).
    let limit = (DECISIVE_DIVISOR as f64).sqrt();
    (used + SAFETY_SIGMAS * noise > limit).then(|| {
        format!(
            "{}: skewness uses {used:.2} of its limit, varying by {noise:.2}; a fault may use {limit}",
            outcome.name
        )
    })
}

/// Returns whether a fault is rejected so clearly that a larger sample would add nothing: without
/// [objection](fault_objection), for a finite estimate, from a sample whose skewness is known to
/// half of its limit.
pub fn is_clearly_rejected(outcome: &Outcome) -> bool {
    let [_, noise_of_skewness] = skewness(outcome);
    noise_of_skewness <= CLEAR_SKEWNESS_NOISE
        && outcome.estimate.is_finite()
        && fault_objection(outcome).is_none()
}

/// Largest noise of the used fraction of the allowed skewness at which a rejection is clear.
const CLEAR_SKEWNESS_NOISE: f64 = 0.5;

/// Fraction of [`FAULT_SIGMAS`] below which an expected rejection is not tried.
const HOPELESS: f64 = 0.9;

/// Returns how many times larger a sample must be to have a chance of being
/// [clearly rejected](is_clearly_rejected): standard errors grow as the root of its size, and the
/// noise of skewness falls with it. What is not rejected at all tells nothing of the former.
pub fn growth_to_clear_rejection(outcome: &Outcome) -> f64 {
    let [_, noise_of_skewness] = skewness(outcome);
    let sigmas = rejection_sigmas(outcome);
    let growth = if sigmas > 0.0 {
        (HOPELESS * FAULT_SIGMAS / sigmas).powi(2)
    } else {
        0.0
    };
    growth.max(noise_of_skewness / CLEAR_SKEWNESS_NOISE)
}
