//! Tests of the guard of the error budget at its limits: outcomes that it passes, and outcomes that
//! it refuses.

use whitefurnace::harness::guard::{
    FAULT_SIGMAS, MAX_FAULT_MISS, SAFETY_SIGMAS, growth_to_clear_rejection, is_clearly_rejected,
    rejection_sigmas,
};
use whitefurnace::harness::outcome::{DECISIVE_DIVISOR, DECISIVE_LEVEL};

use super::*;

const DOF: f64 = 20_000.0;

/// Returns the outcome of a t test with `effect` standard errors of 1 and this claim.
fn t(effect: f64, claim: Claim) -> Outcome {
    Outcome {
        p: student_two_sided(effect, DOF),
        n: DOF as u64,
        reference: 0.0,
        sensitivity: normal(1.0, DOF),
        ..outcome(effect, normal_upper(0.5 * ALPHA), claim)
    }
}

#[test]
fn a_subject_needs_its_minimum_detectable_effect_with_room() {
    let exact = |delta| t(0.0, Claim::Equal { delta });
    let detected = exact(1.0).minimum_detectable_effect();
    assert!((12.2..12.3).contains(&detected), "{detected}");
    // The standard error of 20 000 normal values varies by 1/200.
    let least = detected * (1.0 + SAFETY_SIGMAS / 200.0);
    for (factor, passes) in [(1.001, true), (0.999, false)] {
        let size = factor * least;
        for claim in [
            Claim::Equal { delta: size },
            Claim::Equivalent { margin: size },
        ] {
            assert_eq!(
                power_objection(&t(0.0, claim)).is_none(),
                passes,
                "{claim:?}"
            );
        }
    }
    assert!(power_objection(&exact(detected)).is_some_and(|why| why.contains("detects")));
    assert!(power_objection(&exact(f64::NAN)).is_some());
    assert!(power_objection(&Outcome::identity("identity", 1, 0.0, 1.0, "")).is_none());
}

/// Returns the outcome with a skewness of this fraction of its limit: valid_from/n is the square of
/// the fraction.
fn skewed(outcome: Outcome, used: f64) -> Outcome {
    Outcome {
        valid_from: (used * used * DOF) as u64,
        ..outcome
    }
}

/// Returns the largest fraction of the limit of skewness that leaves room below `limit`.
fn most_with_room(limit: f64) -> f64 {
    let z = normal_upper(0.5 * ALPHA);
    limit - SAFETY_SIGMAS * 6_f64.sqrt() / DOF * z.powi(3) / 0.9
}

#[test]
fn a_subject_needs_room_for_the_noise_of_its_skewness() {
    let skewed = |used| skewed(t(0.0, Claim::Equal { delta: 20.0 }), used);
    let most = most_with_room(1.0);
    assert!((0.8..0.95).contains(&most), "{most}");
    assert!(power_objection(&skewed(most - 1e-3)).is_none());
    assert!(power_objection(&skewed(most + 1e-3)).is_some_and(|why| why.contains("skewness")));
    assert_eq!(skewed(most + 1e-3).verdict(), Verdict::Holds);
}

#[test]
fn a_fault_needs_a_distance_that_no_seed_takes_back() {
    let any = Claim::Equal { delta: 12.5 };
    for (effect, passes) in [
        (0.0, false),
        (7.0, false),
        (19.0, false),
        (21.5, true),
        (60.0, true),
    ] {
        for outcome in [t(effect, any), t(-effect, any)] {
            assert_eq!(fault_objection(&outcome).is_none(), passes, "{effect}");
        }
    }
    // The distance counts from the margin, not from the reference.
    let margin = Claim::Equivalent { margin: 12.5 };
    assert!(fault_objection(&t(12.5 + 20.1, margin)).is_some());
    assert!(fault_objection(&t(12.5 + 20.3, margin)).is_none());
    // The distance of NaN is NaN; a failed identity is certain.
    assert_eq!(
        rejection_sigmas(&Outcome {
            p: f64::NAN,
            ..t(30.0, any)
        }),
        0.0
    );
    assert_eq!(
        rejection_sigmas(&Outcome::identity("identity", 1, 2.0, 1.0, "")),
        f64::INFINITY
    );
}

/// A rejection that stands without a valid tail needs room up to the limit of skewness above which
/// it does not: another seed's skewness may be larger.
#[test]
fn a_fault_needs_room_for_the_noise_of_its_skewness() {
    let fault = || t(60.0, Claim::Equal { delta: 12.5 });
    let most = most_with_room((DECISIVE_DIVISOR as f64).sqrt());
    let [below, above] = [-1e-3, 1e-3].map(|off| skewed(fault(), most + off));
    assert!(fault_objection(&below).is_none());
    assert!(fault_objection(&above).is_some_and(|why| why.contains("skewness")));
    assert_eq!(above.verdict(), Verdict::Fails);
}

/// Standard errors grow as the root of the sample's size, the noise of skewness falls with it: a
/// sample that grows by less is not clearly rejected.
#[test]
fn a_sample_too_small_for_a_clear_rejection_says_how_small() {
    let any = Claim::Equal { delta: 12.5 };
    let grown = |by: f64| is_clearly_rejected(&t(10.0 * by.sqrt(), any));
    let growth = growth_to_clear_rejection(&t(10.0, any));
    assert!((3.0..3.5).contains(&growth), "{growth}");
    assert!(!grown(growth) && grown(1.3 * growth));

    let few = |count: f64| Outcome {
        n: count as u64,
        sensitivity: normal(1.0, count),
        ..t(60.0, any)
    };
    let growth = growth_to_clear_rejection(&few(1000.0));
    assert!((1.0..3.0).contains(&growth), "{growth}");
    for (factor, is_clear) in [(0.99, false), (1.01, true)] {
        let outcome = few(factor * growth * 1000.0);
        assert_eq!(is_clearly_rejected(&outcome), is_clear, "{factor}");
    }
    assert!(growth_to_clear_rejection(&t(0.0, any)) < 1.0);
    let failed_identity = Outcome::identity("identity", 1, 2.0, 1.0, "");
    assert!(growth_to_clear_rejection(&failed_identity) < 1.0);
}

/// A rejection by [`FAULT_SIGMAS`] standard errors means an effect so large that another seed
/// rejects it, too; each of the two steps fails with probability [`MAX_FAULT_MISS`].
#[test]
fn the_far_distance_is_two_misses_beyond_the_critical_value() {
    let miss = normal_upper(MAX_FAULT_MISS);
    assert!(FAULT_SIGMAS - miss - miss >= normal_upper(0.5 * ALPHA) - 0.2);
    assert!(normal_sf(FAULT_SIGMAS - miss - normal_upper(0.5 * ALPHA)) <= MAX_FAULT_MISS);
    assert!((normal_upper(0.5 * DECISIVE_LEVEL) - FAULT_SIGMAS).abs() < 0.05);
}

/// A far rejection stands without a valid tail, within limits; a near one, or a correct subject, is
/// undecided.
#[test]
fn far_rejections_stand_without_a_valid_tail() {
    let claim = Claim::Equal { delta: 12.5 };
    let skewed = |effect, times: u64| {
        Outcome {
            valid_from: times * DOF as u64,
            ..t(effect, claim)
        }
        .verdict()
    };
    assert_eq!(skewed(21.5, DECISIVE_DIVISOR), Verdict::Fails);
    for (effect, times) in [(21.5, DECISIVE_DIVISOR + 1), (19.0, 2), (0.0, 2)] {
        assert!(
            matches!(skewed(effect, times), Verdict::Undecided { .. }),
            "{effect} {times}"
        );
    }
}
