//! Tests of the guard of the error budget at its limits: outcomes that it passes, and outcomes that
//! it refuses.

use whitefurnace::harness::guard::{
    FAULT_SAFETY_SIGMAS, MAX_FAULT_MISS, SAFETY_SIGMAS, is_clearly_rejected, is_promising,
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
fn a_subject_needs_its_minimum_detectable_effect() {
    let exact = |delta| t(0.0, Claim::Equal { delta });
    let detected = exact(1.0).minimum_detectable_effect();
    assert!((12.2..12.3).contains(&detected), "{detected}");
    for (factor, passes) in [(1.001, true), (0.999, false)] {
        let size = factor * detected;
        for claim in [
            Claim::Equal { delta: size },
            Claim::Equivalent { margin: size },
        ] {
            let objection = power_objection(&t(0.0, claim));
            assert_eq!(objection.is_none(), passes, "{claim:?}");
            assert!(objection.is_none_or(|why| why.contains("detects")));
        }
    }
    assert!(power_objection(&exact(f64::NAN)).is_some());
    assert!(power_objection(&Outcome::identity("identity", 1, 0.0, 1.0, "")).is_none());
}

/// An effect that equals the estimated minimum detectable effect is as good as one that exceeds the
/// true one: whatever the true standard error is, it is rare that the estimate passes the guard and
/// another seed's outcome misses the effect on either side. From 5000 values on; the guard's limit
/// of skewness asks for more.
#[test]
fn the_standard_error_needs_no_room() {
    let fewest = SAFETY_SIGMAS * 12_f64.sqrt() * normal_upper(0.5 * ALPHA).powi(3) / 0.9;
    assert!(fewest > 5000.0, "{fewest}");
    for dof in [5000.0, 20_000.0, 1e6] {
        let detected = normal(1.0, dof).smallest_effect(0.5 * ALPHA);
        for deviation in (-80..80).map(|i| 0.1 * f64::from(i)) {
            let estimate_is_lower = normal_sf(deviation);
            let standard_error = 1.0 + deviation / (2.0 * dof).sqrt();
            let red = 2.0 * normal(standard_error, dof).miss(detected);
            assert!(
                estimate_is_lower * red <= ALPHA,
                "{dof} {deviation}: {estimate_is_lower} {red}"
            );
        }
    }
}

/// Returns the outcome with a skewness of this fraction of its limit: valid_from/n is the square of
/// the fraction.
fn skewed(outcome: Outcome, used: f64) -> Outcome {
    Outcome {
        valid_from: (used * used * DOF) as u64,
        ..outcome
    }
}

/// Standard deviation of the difference of two seeds' skewness, as a fraction of its limit.
fn noise_of_skewness() -> f64 {
    let z = normal_upper(0.5 * ALPHA);
    12_f64.sqrt() / DOF * z.powi(3) / 0.9
}

#[test]
fn a_subject_needs_room_for_the_noise_of_its_skewness() {
    let skewed = |used| skewed(t(0.0, Claim::Equal { delta: 20.0 }), used);
    let most = 1.0 - SAFETY_SIGMAS * noise_of_skewness();
    assert!((0.7..0.8).contains(&most), "{most}");
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
        (16.5, false),
        (16.9, true),
        (60.0, true),
    ] {
        for outcome in [t(effect, any), t(-effect, any)] {
            let objection = fault_objection(&outcome, 1.0);
            assert_eq!(objection.is_none(), passes, "{effect}: {objection:?}");
        }
    }
    // The distance counts from the margin, not from the reference.
    let margin = Claim::Equivalent { margin: 12.5 };
    assert!(fault_objection(&t(12.5 + 16.5, margin), 1.0).is_some());
    assert!(fault_objection(&t(12.5 + 16.9, margin), 1.0).is_none());
    // The distance of NaN, and of an estimate within the margin, is 0; a failed identity is certain.
    let nan = Outcome {
        p: f64::NAN,
        ..t(30.0, any)
    };
    assert_eq!(rejection_sigmas(&nan), 0.0);
    assert_eq!(rejection_sigmas(&t(12.0, margin)), 0.0);
    let identity = Outcome::identity("identity", 1, 2.0, 1.0, "");
    assert_eq!(rejection_sigmas(&identity), f64::INFINITY);
    // The noise of counts is larger.
    let counts = Outcome {
        sensitivity: Sensitivity::Poisson { mean: 1000.0 },
        ..t(20.0, any)
    };
    assert!(fault_objection(&counts, 1.0).is_some());
}

/// Parts of a sample on which a fault runs.
fn parts() -> impl Iterator<Item = f64> {
    (0..=12).map(|k| 0.5_f64.powf(0.5 * f64::from(k)))
}

/// Whatever a fault's true effect is, it is rare that a part of the sample rejects it clearly under
/// one seed, and that the whole does not reject it under another.
#[test]
fn a_fault_is_clearly_rejected_or_missed_but_rarely_both() {
    let claim = Claim::Equal { delta: 12.5 };
    // Sigmas that are enough, by bisection.
    let enough = |share: f64| {
        let (mut low, mut high) = (0.0, 37.0);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            let outcome = Outcome {
                p: 2.0 * normal_sf(middle),
                ..t(middle, claim)
            };
            match fault_objection(&outcome, share) {
                Some(_) => low = middle,
                None => high = middle,
            }
        }
        high
    };
    let needed: Vec<(f64, f64)> = parts().map(|share| (share, enough(share))).collect();
    assert!(
        needed.windows(2).all(|pair| pair[0].1 > pair[1].1),
        "{needed:?}"
    );
    assert!((16.5..16.9).contains(&needed[0].1), "{needed:?}");
    let critical = normal_upper(0.5 * ALPHA);
    for effect in (0..400).map(|i| 0.1 * f64::from(i)) {
        let clear: f64 = needed
            .iter()
            .map(|(share, needed)| normal_sf(needed - effect * share.sqrt()))
            .sum();
        let missed = normal_sf(effect - critical);
        assert!(
            clear * missed <= MAX_FAULT_MISS,
            "{effect}: {clear} {missed}"
        );
    }
}

/// A rejection with a valid tail needs room up to the limit of skewness, as another seed's skewness
/// may be larger; beyond, it must be decisive, and needs room up to the limit of that.
#[test]
fn a_fault_needs_room_for_the_noise_of_its_skewness() {
    let any = Claim::Equal { delta: 12.5 };
    let decisive = normal_upper(0.5 * DECISIVE_LEVEL) + 1.05 * FAULT_SAFETY_SIGMAS * 2_f64.sqrt();
    let room = FAULT_SAFETY_SIGMAS * noise_of_skewness();
    for (effect, limit) in [(20.0, 1.0), (decisive, (DECISIVE_DIVISOR as f64).sqrt())] {
        let [below, above] = [-1e-3, 1e-3].map(|off| skewed(t(effect, any), limit - room + off));
        assert_eq!(fault_objection(&below, 1.0), None, "{effect}");
        assert!(fault_objection(&above, 1.0).is_some(), "{effect}");
    }
    let most = skewed(t(60.0, any), (DECISIVE_DIVISOR as f64).sqrt() - 0.5 * room);
    assert!(fault_objection(&most, 1.0).is_some_and(|why| why.contains("skewness")));
    assert_eq!(most.verdict(), Verdict::Fails);
    // In a fourth of the sample, skewness is estimated worse, and the whole has half of it. Its noise
    // is that of this sample divided by √2, and for the difference multiplied by √(1/16 + 1/4).
    let most = 2.0 * (1.0 - (5.0_f64 / 32.0).sqrt() * room);
    assert!((1.6..1.9).contains(&most), "{most}");
    let [below, above] = [-1e-3, 1e-3].map(|off| skewed(t(17.0, any), most + off));
    assert_eq!(fault_objection(&below, 0.25), None);
    assert!(fault_objection(&above, 0.25).is_some());
    // The part itself must reject the fault.
    assert!(matches!(below.verdict(), Verdict::Undecided { .. }));
    assert!(!is_clearly_rejected(&below, 0.25));
    assert!(is_clearly_rejected(&skewed(t(17.0, any), 0.9), 0.25));
}

/// A larger part promises a clear rejection if its outcome would be clear with the same estimates.
#[test]
fn a_part_promises_a_clear_rejection_if_its_estimates_stay() {
    let any = Claim::Equal { delta: 12.5 };
    let sample = |effect: f64, count: f64, used: f64| {
        let deviation = effect * count.sqrt();
        Outcome {
            n: count as u64,
            valid_from: (used * used * count) as u64,
            p: 2.0 * normal_sf(deviation),
            sensitivity: normal(1.0, count),
            ..outcome(deviation, normal_upper(0.5 * ALPHA), any)
        }
    };
    let whole = 100_000.0;
    let mut seen = [0; 2];
    for effect in [0.0, 0.01, 0.03, 0.06, 0.09] {
        for used in [0.1, 0.9, 3.0, 8.0] {
            let small = sample(effect, whole / 64.0, used);
            assert!(!is_clearly_rejected(&sample(effect, whole, 4.5), 1.0));
            for share in parts().filter(|share| *share > 1.0 / 64.0) {
                let later = sample(effect, whole * share, used / (64.0 * share).sqrt());
                let promises = is_promising(&small, 1.0 / 64.0, share);
                assert_eq!(
                    promises,
                    fault_objection(&later, share).is_none(),
                    "{effect} {used} {share}"
                );
                let clear = is_clearly_rejected(&later, share);
                assert_eq!(promises && later.verdict() == Verdict::Fails, clear);
                seen[usize::from(promises)] += 1;
            }
        }
    }
    assert!(seen.into_iter().all(|count| count > 20), "{seen:?}");
    // What is no evidence promises nothing, and NaN is not clear.
    let constant = Outcome {
        p: 1.0,
        sensitivity: normal(f64::INFINITY, f64::INFINITY),
        ..t(0.0, any)
    };
    assert!(!is_promising(&constant, 0.5, 1.0));
    let nan = Outcome {
        p: f64::NAN,
        ..t(60.0, any)
    };
    assert!(!is_clearly_rejected(&nan, 1.0));
}

/// Normal deviates of the constants.
#[test]
fn distances_are_as_rare_as_the_budget_says() {
    assert!(normal_sf(SAFETY_SIGMAS) <= ALPHA);
    assert!(parts().count() as f64 * normal_sf(FAULT_SAFETY_SIGMAS) <= MAX_FAULT_MISS);
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
