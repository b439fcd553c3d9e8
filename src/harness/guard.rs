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
//! cannot refuse.
//!
//! It knows only estimates under the default seed. It passes a size if, whatever the true values
//! are, the estimates would be as good as they are *and* another seed's outcome red with at most
//! the probability that the budget allows. An estimate X under the default seed and another seed's
//! estimate Y, of equal mean and variances v and w, differ by a normal amount of variance v + w. If
//! X is k √(v + w) away from a limit, Y is beyond the limit only if they differ by more, which has
//! the probability of k standard deviations or less.

use std::f64::consts::SQRT_2;

use super::mean::{MAX_SKEW_TERM, Sigma};
use super::outcome::{ALPHA, Claim, DECISIVE_DIVISOR, DECISIVE_LEVEL, Outcome, Verdict};
use super::power::Sensitivity;
use super::tails::normal_upper;

/// Number of standard deviations of the difference between two seeds by which an outcome that is to
/// hold must stay within a limit: more have a probability of less than [`ALPHA`].
pub const SAFETY_SIGMAS: f64 = 6.0;

/// Number of standard deviations of the difference between two seeds by which a fault must be
/// beyond the limits of what is rejected: more have a probability of less than [`MAX_FAULT_MISS`],
/// even where a fault has a dozen chances to be clearly rejected.
pub const FAULT_SAFETY_SIGMAS: f64 = 7.4;

/// Largest probability that the guard passes a fault that another seed does not reject.
pub const MAX_FAULT_MISS: f64 = 1e-12;

/// Skewness of a sample, as a fraction of the largest with which the tail is valid.
#[derive(Clone, Copy)]
struct Skewness {
    /// Estimated fraction; falls as the root of the sample's size.
    used: f64,
    /// Standard deviation of the estimate: the skewness of n values varies by √(6/n), and its
    /// effect on the tail falls as 1/√n. Kurtosis counts through the degrees of freedom.
    noise: f64,
}

impl Skewness {
    fn of(outcome: &Outcome) -> Self {
        let Sensitivity::Normal { dof, .. } = outcome.sensitivity else {
            return Self {
                used: 0.0,
                noise: 0.0,
            };
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
        let noise = sigma.skew_term(6_f64.sqrt() / values, z) / MAX_SKEW_TERM;
        Self { used, noise }
    }

    /// Returns the largest fraction that another seed's sample, `growth` times as large, may use.
    fn worst(self, sigmas: f64, growth: f64) -> f64 {
        // Scaled to the larger sample, this one's estimate varies by √growth times as much as that
        // sample's own.
        let difference = self.noise / growth * (growth + 1.0).sqrt();
        self.used / growth.sqrt() + sigmas * difference
    }
}

/// Returns why an outcome that is to hold may end red by chance more often than its share: its δ or
/// margin is below its minimum detectable effect, or its skewness too near the limit. `None` if all
/// is well, or nothing is random.
///
/// The estimated standard error, of which the effect is a multiple, needs no room. It varies by
/// less than a hundredth where skewness is known well enough: the lower an estimate is, the less
/// likely it is, by more than what it adds to the probability of a red outcome.
pub fn power_objection(outcome: &Outcome) -> Option<String> {
    if !outcome.is_random() {
        return None;
    }
    let skewness = Skewness::of(outcome);
    let worst = skewness.worst(SAFETY_SIGMAS, 1.0);
    if worst > 1.0 {
        return Some(format!(
            "{}: skewness uses {:.2} of its limit, under other seeds up to {worst:.2}; needs about {:.0} samples",
            outcome.name,
            skewness.used,
            outcome.n as f64 * worst.powi(2)
        ));
    }
    let detected = outcome.minimum_detectable_effect();
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

/// Returns how many standard errors the outcome is away from its claim: from the claim's p-value,
/// or the distance beyond the margin of an approximate one; infinite for an exact identity that
/// fails, 0 where nothing speaks against the claim, or for NaN.
pub fn rejection_sigmas(outcome: &Outcome) -> f64 {
    if outcome.p.is_nan() {
        return 0.0;
    }
    match outcome.claim {
        _ if !outcome.is_random() && outcome.verdict() == Verdict::Fails => f64::INFINITY,
        Claim::Equivalent { margin } => {
            let beyond = (outcome.estimate - outcome.reference).abs() - margin;
            (beyond / outcome.half_width() * normal_upper(0.5 * ALPHA)).max(0.0)
        }
        // A p-value that underflows leaves no doubt.
        Claim::Equal { .. } | Claim::Test if outcome.p <= 0.0 => f64::INFINITY,
        Claim::Equal { .. } | Claim::Test => normal_upper(0.5 * outcome.p).max(0.0),
    }
}

/// Returns a bound of the standard deviation of [`rejection_sigmas`] among seeds, for a sample that
/// is `growth` times as large.
fn rejection_noise(outcome: &Outcome, growth: f64) -> f64 {
    match outcome.sensitivity {
        Sensitivity::Certain | Sensitivity::Bernstein { .. } => 1.0,
        // The standard error in the denominator varies as well.
        Sensitivity::Normal { dof, .. } => {
            (1.0 + normal_upper(0.5 * DECISIVE_LEVEL).powi(2) / (2.0 * dof * growth)).sqrt()
        }
        // The noise of counts grows with the effect.
        Sensitivity::Cells { .. }
        | Sensitivity::Distance { .. }
        | Sensitivity::Binomial { .. }
        | Sensitivity::Poisson { .. } => SQRT_2,
    }
}

/// Returns why an outcome that rejects a fault, found by a part `share` in (0, 1] of the trial's
/// sample, may not be found under other seeds, which have the whole sample in the end: it is
/// rejected by too few standard errors, or skewness is too near the limit above which nothing is
/// rejected. `None` if all is well.
pub fn fault_objection(outcome: &Outcome, share: f64) -> Option<String> {
    objection_after_growth(outcome, share, 1.0)
}

/// Returns the [`fault_objection`] to a part that is `growth` times as large as the one of this
/// outcome, `share` of the whole, if its estimates stay the same: standard errors grow as the root
/// of the size.
fn objection_after_growth(outcome: &Outcome, share: f64, growth: f64) -> Option<String> {
    let sigmas = rejection_sigmas(outcome) * growth.sqrt();
    let skewness = Skewness::of(outcome);
    let skewness = Skewness {
        used: skewness.used / growth.sqrt(),
        noise: skewness.noise / growth,
    };
    let part = share * growth;
    let worst = skewness.worst(FAULT_SAFETY_SIGMAS, 1.0 / part);
    // So far out a rejection stands for that many times as many values (`DECISIVE_LEVEL`).
    let limit = (DECISIVE_DIVISOR as f64).sqrt();
    if worst > limit {
        return Some(format!(
            "{}: skewness uses {:.2} of its limit, under other seeds up to {worst:.2}; a fault may use {limit}",
            outcome.name, skewness.used
        ));
    }
    let level = if worst > 1.0 { DECISIVE_LEVEL } else { ALPHA };
    // Sigmas of the whole sample are 1/√part as many; all are counted in those of the part.
    let needed = normal_upper(0.5 * level) * part.sqrt()
        + FAULT_SAFETY_SIGMAS * rejection_noise(outcome, growth) * (1.0 + part).sqrt();
    (sigmas < needed).then(|| {
        format!(
            "{}: rejected by {sigmas:.1} standard errors, needs {needed:.1}",
            outcome.name
        )
    })
}

/// Returns whether a fault is rejected so clearly by a part `share` in (0, 1] of the trial's sample
/// that the rest would add nothing: by a finite estimate, without
/// [objection](fault_objection).
pub fn is_clearly_rejected(outcome: &Outcome, share: f64) -> bool {
    outcome.verdict() == Verdict::Fails
        && outcome.estimate.is_finite()
        && fault_objection(outcome, share).is_none()
}

/// Returns whether a part `later` of the trial's sample is likely to be
/// [clearly rejected](is_clearly_rejected), after an outcome of the part `share`: without objection
/// if the estimates stay the same.
pub fn is_promising(outcome: &Outcome, share: f64, later: f64) -> bool {
    objection_after_growth(outcome, share, later / share).is_none()
}
