//! The sequential probability ratio test, exactly: its thresholds, and its errors summed over all runs.

use std::f64::consts::LN_2;

use approx::assert_abs_diff_eq;
use whitefurnace::harness::sequential::{Decision, Sprt};

/// The summed likelihood ratio at which a test decides, by steps of `sign` · 2⁻²⁰ in its logarithm.
fn threshold(mut test: Sprt, sign: f64) -> f64 {
    const STEP: f64 = 1.0 / (1 << 20) as f64;
    // A normal value of standard deviation 1, mean 0 against 1, adds its distance from 1/2.
    while test.normal(0.5 + sign * STEP, 0.0, 1.0, 1.0) == Decision::Continue {}
    assert_eq!(test.decision() == Decision::Alternative, sign > 0.0, "it decides on its side");
    sign * test.count() as f64 * STEP
}

/// ln(1/α) and ln β, neither of which knows the other error, far from where both forms of Wald's agree.
#[test]
fn thresholds_are_those_of_the_guarantee() {
    for (alpha, beta) in
        [(0.05, 0.5), (0.5, 0.05), (0.05, 0.05), (0.25, 0.5), (0.01, 0.2), (1e-3, 0.9)]
    {
        let test = || Sprt::new(alpha, beta);
        assert_abs_diff_eq!(threshold(test(), 1.0), -f64::ln(alpha), epsilon = 2e-6);
        assert_abs_diff_eq!(threshold(test(), -1.0), f64::ln(beta), epsilon = 2e-6);
    }
}

/// Probabilities of the decisions [null, alternative] of a Bernoulli test where successes have probability
/// `truth`, and of none within `most` values. The test is a function of the numbers of successes and
/// failures, so that all runs are summed without leaving one out.
fn decisions(
    start: Sprt,
    [null, alternative]: [f64; 2],
    truth: f64,
    most: usize,
) -> ([f64; 2], f64) {
    let mut decided = [0.0; 2];
    // By the number of successes so far.
    let mut running = vec![Some((start, 1.0))];
    for _ in 0..most {
        let mut next = vec![None; running.len() + 1];
        for (successes, state) in running.into_iter().enumerate() {
            let Some((test, mass)) = state else { continue };
            for (success, probability) in [(true, truth), (false, 1.0 - truth)] {
                let mut test: Sprt = test;
                let mass = mass * probability;
                match test.bernoulli(success, null, alternative) {
                    Decision::Null => decided[0] += mass,
                    Decision::Alternative => decided[1] += mass,
                    Decision::Continue => {
                        let slot: &mut Option<(Sprt, f64)> =
                            &mut next[successes + usize::from(success)];
                        let before = slot.map_or(0.0, |(_, mass)| mass);
                        *slot = Some((test, before + mass));
                    }
                }
            }
        }
        running = next;
    }
    let open = running.into_iter().flatten().map(|(_, mass)| mass).sum();
    (decided, open)
}

#[test]
fn errors_summed_over_all_runs_keep_the_guarantee() {
    for pair in [[1.0 / 3.0, 2.0 / 3.0], [0.2, 0.5], [0.6, 0.3], [0.5, 0.6]] {
        for (alpha, beta) in
            [(0.25, 0.5), (0.5, 0.25), (0.05, 0.05), (0.05, 0.5), (0.5, 0.05), (0.125, 0.75)]
        {
            let test = Sprt::new(alpha, beta);
            let ([_, rejected], open) = decisions(test, pair, pair[0], 2000);
            assert!(rejected + open <= alpha, "α {alpha}, β {beta}, {pair:?}: {rejected}");
            let ([accepted, _], open) = decisions(test, pair, pair[1], 2000);
            assert!(accepted + open <= beta, "α {alpha}, β {beta}, {pair:?}: {accepted}");
        }
    }
}

/// Between 1/3 and 2/3 each value is a step of ±ln 2: with errors 2^(−a) and 2^(−b) the sum meets the thresholds
/// exactly, and the gambler's ruin gives the probabilities.
#[test]
fn a_walk_of_whole_steps_is_the_gamblers_ruin() {
    for (a, b) in [(1, 1), (1, 3), (4, 1), (5, 5)] {
        // A hair above, so that rounding does not ask for one step more.
        let [alpha, beta] = [a, b].map(|steps| (-f64::from(steps) * LN_2 + 1e-9).exp());
        let ([_, rejected], open) =
            decisions(Sprt::new(alpha, beta), [1.0 / 3.0, 2.0 / 3.0], 1.0 / 3.0, 2000);
        let [up, down] = [2f64.powi(a), 2f64.powi(-b)];
        assert_abs_diff_eq!(rejected, (1.0 - down) / (up - down), epsilon = 1e-12);
        assert!(open < 1e-15);
    }
}
