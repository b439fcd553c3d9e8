//! Tests of outcomes and verdicts at their limits: the fields of an outcome, its power, and its
//! decision.

use whitefurnace::harness::outcome::{
    CAPACITY, SUITE_BUDGET, equality_verdict, equivalence_verdict,
};

use super::*;

#[test]
fn the_budget_is_shared_evenly() {
    assert_relative_eq!(SUITE_BUDGET, 1e-6, max_relative = 1e-15);
    assert_relative_eq!(SUITE_BUDGET / CAPACITY as f64, ALPHA, max_relative = 1e-15);
}

#[test]
fn claims_and_verdicts_have_sizes_and_words() {
    assert_eq!(Claim::Equal { delta: 0.25 }.size(), 0.25);
    assert_eq!(Claim::Equivalent { margin: 0.5 }.size(), 0.5);
    assert_eq!(Claim::Test.size(), 0.0);
    let undecided = Verdict::Undecided { needed: 1 };
    assert_eq!(
        [Verdict::Holds, Verdict::Fails, undecided].map(Verdict::word),
        ["holds", "fails", "undecided"]
    );
}

#[test]
fn borders_belong_to_the_claim() {
    // Numbers that are exact in binary: the interval ends exactly on the margin.
    let exact = |p, interval| equality_verdict(p, interval, 2.0, 0.25, 100);
    assert_eq!(exact(ALPHA, [1.75, 2.25]), Verdict::Holds);
    let approximate = |interval| equivalence_verdict(interval, 2.0, 0.25, 100);
    assert_eq!(approximate([1.75, 2.25]), Verdict::Holds);
    for touching in [[2.25, 2.5], [1.5, 1.75]] {
        assert!(matches!(approximate(touching), Verdict::Undecided { .. }));
    }
    for wrong in [[2.26, 2.5], [1.5, 1.74], [f64::NAN, 2.0], [2.0, f64::NAN]] {
        assert_eq!(approximate(wrong), Verdict::Fails);
    }
}

/// n (width/δ)², and more than n if the interval is narrow enough but lies to one side.
#[test]
fn undecided_asks_for_what_would_decide() {
    for (interval, needed) in [
        ([1.625, 2.125], 400),
        ([1.875, 2.5], 625),
        ([2.125, 2.3125], 101),
        ([2.0, f64::INFINITY], u64::MAX),
    ] {
        assert_eq!(
            equality_verdict(1.0, interval, 2.0, 0.25, 100),
            Verdict::Undecided { needed }
        );
    }
}

#[test]
fn an_outcome_is_judged_by_its_claim() {
    let exact = outcome(3.0, 0.1, Claim::Equal { delta: 0.125 });
    assert_eq!(exact.verdict(), Verdict::Holds);
    let few = |valid_from| Outcome {
        valid_from,
        ..exact.clone()
    };
    assert_eq!(few(99).verdict(), Verdict::Holds);
    assert_eq!(few(100).verdict(), Verdict::Holds);
    assert_eq!(few(101).verdict(), Verdict::Undecided { needed: 101 });
    // With a margin the margin decides whatever p is; without one p decides.
    let with_p = |p, claim| Outcome {
        p,
        ..outcome(3.0, 0.1, claim)
    };
    let [tiny, small] = [0.5 * ALPHA, ALPHA];
    for (claim, at_tiny, at_small) in [
        (
            Claim::Equal { delta: 0.125 },
            Verdict::Fails,
            Verdict::Holds,
        ),
        (
            Claim::Equivalent { margin: 0.125 },
            Verdict::Holds,
            Verdict::Holds,
        ),
        (Claim::Test, Verdict::Fails, Verdict::Holds),
    ] {
        assert_eq!(with_p(tiny, claim).verdict(), at_tiny, "{claim:?}");
        assert_eq!(with_p(small, claim).verdict(), at_small, "{claim:?}");
        assert_eq!(with_p(1.0, claim).verdict(), Verdict::Holds, "{claim:?}");
        assert_eq!(with_p(f64::NAN, claim).verdict(), Verdict::Fails);
    }
}

#[test]
fn exact_identities_use_no_chance() {
    let found = |error| Outcome::identity("identity", 7, error, 0.5, "everywhere").named("renamed");
    let on_the_border = found(-0.5);
    assert_eq!(on_the_border.verdict(), Verdict::Holds);
    assert_eq!(
        (&*on_the_border.name, &*on_the_border.worst),
        ("renamed", "everywhere")
    );
    assert_eq!(
        (on_the_border.n, on_the_border.p, on_the_border.interval),
        (7, 1.0, [-0.5, -0.5])
    );
    assert!(!on_the_border.is_random());
    assert!(outcome(3.0, 0.1, Claim::Test).is_random());
    let beyond = found(0.75);
    assert_eq!((beyond.p, beyond.verdict()), (0.0, Verdict::Fails));
}

/// Returns the outcome of a z test with a standard error of 1/8.
fn measured(claim: Claim) -> Outcome {
    Outcome {
        sensitivity: normal(0.125, f64::INFINITY),
        ..outcome(3.0, 0.75, claim)
    }
}

#[test]
fn power_is_that_of_the_claim() {
    let critical = normal_upper(ALPHA / 2.0);
    let exact = measured(Claim::Equal {
        delta: 0.125 * (critical + 2.0),
    });
    assert_relative_eq!(exact.half_width(), 0.75, max_relative = 1e-15);
    // P(Z ≥ 2), on either side.
    let tail = 0.022_750_131_948_179_2;
    assert_relative_eq!(exact.miss(), 2.0 * tail, max_relative = 1e-9);
    assert_eq!(exact.power(), "0.95");
    let equal = measured(Claim::Equivalent {
        margin: exact.claim.size(),
    });
    assert_relative_eq!(equal.miss(), 2.0 * tail, max_relative = 1e-9);
    assert_eq!(equal.power(), "0.95");
    // A margin of zero is missed with certainty.
    assert_eq!(measured(Claim::Equivalent { margin: 0.0 }).miss(), 1.0);
    let strong = measured(Claim::Equal { delta: 2.0 });
    assert_eq!(strong.power(), format!("1 - {:.1e}", strong.miss()));
    assert!(strong.miss() < ALPHA);
    for (claim, sides) in [
        (Claim::Test, 1.0),
        (Claim::Equal { delta: 1.0 }, 2.0),
        (Claim::Equivalent { margin: 1.0 }, 2.0),
    ] {
        let effect = measured(claim).minimum_detectable_effect();
        assert_relative_eq!(
            effect,
            0.125 * (critical + normal_upper(ALPHA / sides)),
            max_relative = 1e-8
        );
    }
    assert_eq!(measured(Claim::Test).miss(), ALPHA);
    let identity = Outcome::identity("identity", 1, 0.0, 0.25, "");
    assert_eq!((identity.power().as_str(), identity.miss()), ("exact", 0.0));
    assert_eq!(identity.minimum_detectable_effect(), 0.25);
}
