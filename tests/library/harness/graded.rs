//! Tests of graded controls: every statistic is run again on values shifted by the size of its
//! claim.

use super::*;

fn exact(delta: f64) -> Claim {
    Claim::Equal { delta }
}

/// Returns the outcomes of all statistics with a claim of this size, on right values whose estimate
/// is exact.
fn all(size: f64) -> Vec<Outcome> {
    let v = around(2.0, 0.2, 1_000_000);
    let observed = [5, 3, 2].map(|share| 400_000 * share).to_vec();
    let counts = Counts {
        n: 4_000_000,
        observed,
        ..Counts::default()
    };
    let mut uniform: Vec<f64> = (0..1_000_000).map(|i| (f64::from(i) + 0.5) / 1e6).collect();
    vec![
        mean("t", &v, 2.0, exact(0.003 * size)),
        mean(
            "t about 0",
            &v.transformed(1.0, -2.0),
            0.0,
            exact(0.003 * size),
        ),
        mean_known_sigma("z", &v, 2.0, 0.2, exact(0.003 * size)),
        bounded_mean("bounded", &v, 2.0, [1.0, 3.0], exact(0.004 * size)),
        welch("Welch", &v, &v, exact(0.004 * size)),
        variance_ratio("ratio", &v, &v, 1.0, 0.003 * size),
        chi_square("cells", &cells(&[0.5, 0.3, 0.2]), &counts, 0.02 * size),
        kolmogorov_smirnov("law", &mut uniform, |x| x, 0.005 * size),
        binomial("share", 300_000, 1_000_000, 0.3, 0.007 * size),
        poisson("events", 10_000, 1_000_000, 10_000.0, 1500.0 * size),
        mean(
            "equal",
            &v,
            2.0,
            Claim::Equivalent {
                margin: 0.003 * size,
            },
        ),
        welch(
            "alike",
            &v,
            &v,
            Claim::Equivalent {
                margin: 0.004 * size,
            },
        ),
    ]
}

/// If n is right, all are decided on both sides; if the claim is finer than n allows, no effect of
/// the claim's size is rejected.
#[test]
fn effects_of_the_size_of_the_claim_are_answered() {
    for outcome in all(1.0) {
        assert_eq!(outcome.verdict(), Verdict::Holds, "{outcome:?}");
        let (up, down) = outcome.graded.iter().fold((0, 0), |(up, down), graded| {
            assert!(
                graded.has_required_verdict(),
                "{}: {graded:?}",
                outcome.name
            );
            if graded.effect > 0.0 {
                (up + 1, down)
            } else {
                (up, down + 1)
            }
        });
        let wanted = match outcome.claim {
            Claim::Equivalent { .. } => 2,
            Claim::Equal { .. } | Claim::Test => 1,
        };
        assert_eq!((up, down), (wanted, wanted), "{}", outcome.name);
    }
    for outcome in all(0.25) {
        let rejected = outcome
            .graded
            .iter()
            .any(|graded| graded.outcome.verdict() == Verdict::Fails);
        assert!(!rejected, "{}", outcome.name);
    }
}

/// The transformed values have the effect, and change by nothing else.
#[test]
fn transformed_values_are_off_by_the_effect() {
    for outcome in all(1.0) {
        for graded in &outcome.graded {
            let moved = graded.outcome.estimate - outcome.estimate;
            // A distance grows whatever the sign.
            let distance = outcome.statistic == "Kolmogorov-Smirnov";
            let expected = if distance {
                graded.effect.abs()
            } else {
                graded.effect
            };
            assert_relative_eq!(moved, expected, max_relative = 1e-3);
            assert!(graded.outcome.graded.is_empty());
        }
    }
    let v = around(2.0, 0.2, 1_000_000).transformed(3.0, 1.0);
    assert_relative_eq!(v.moments.mean(), 7.0, max_relative = 1e-12);
    assert_relative_eq!(v.moments.variance(), 0.36, max_relative = 1e-5);
    assert_relative_eq!(v.batches.means()[0], 7.0, max_relative = 1e-9);
    // Skewness does not depend on the unit.
    let skewed = values(0.0, &[0.0, 0.0, 0.0, 1.0]);
    for sign in [1.0, -1.0] {
        let found = skewed.transformed(sign * 3.0, 1.0).skewness();
        assert_relative_eq!(found, sign * skewed.skewness(), max_relative = 1e-12);
    }
}
