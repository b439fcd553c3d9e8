//! Exact tests of sequential tests: thresholds, errors summed over all runs, confidence sequences
//! by their theorem.

use super::*;

/// Returns the logarithm of the likelihood ratio at which a test decides, to steps of `sign` ·
/// 2⁻²⁰.
fn threshold(mut test: Sprt, sign: f64) -> f64 {
    const STEP: f64 = 1.0 / (1 << 20) as f64;
    // A normal value of standard deviation 1, mean 0 against 1, adds its distance from 1/2.
    while test.normal(0.5 + sign * STEP, 0.0, 1.0, 1.0) == Decision::Continue {}
    assert_eq!(
        test.decision() == Decision::Alternative,
        sign > 0.0,
        "it decides on its side"
    );
    sign * test.count() as f64 * STEP
}

/// The thresholds are ln(1/α) and ln β; neither depends on the other error, and they are far from
/// where Wald's two forms agree.
#[test]
fn thresholds_are_those_of_the_guarantee() {
    for (alpha, beta) in [
        (0.05, 0.5),
        (0.5, 0.05),
        (0.05, 0.05),
        (0.25, 0.5),
        (0.01, 0.2),
        (1e-3, 0.9),
    ] {
        let test = || Sprt::new(alpha, beta);
        assert_abs_diff_eq!(threshold(test(), 1.0), -f64::ln(alpha), epsilon = 2e-6);
        assert_abs_diff_eq!(threshold(test(), -1.0), f64::ln(beta), epsilon = 2e-6);
    }
}

/// Returns the probabilities of the decisions [null, alternative] of a Bernoulli test where
/// successes have probability `truth`, and of no decision within `most` values. The test is a
/// function of the numbers of successes and failures, so that all runs are summed.
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
                        *slot = Some((test, slot.map_or(0.0, |(_, mass)| mass) + mass));
                    }
                }
            }
        }
        running = next;
    }
    (
        decided,
        running.into_iter().flatten().map(|(_, mass)| mass).sum(),
    )
}

#[test]
fn errors_summed_over_all_runs_keep_the_guarantee() {
    for pair in [[1.0 / 3.0, 2.0 / 3.0], [0.2, 0.5], [0.6, 0.3], [0.5, 0.6]] {
        for (alpha, beta) in [
            (0.25, 0.5),
            (0.5, 0.25),
            (0.05, 0.05),
            (0.05, 0.5),
            (0.5, 0.05),
            (0.125, 0.75),
        ] {
            let test = Sprt::new(alpha, beta);
            let ([_, rejected], open) = decisions(test, pair, pair[0], 2000);
            assert!(
                rejected + open <= alpha,
                "α {alpha}, β {beta}, {pair:?}: {rejected}"
            );
            let ([accepted, _], open) = decisions(test, pair, pair[1], 2000);
            assert!(
                accepted + open <= beta,
                "α {alpha}, β {beta}, {pair:?}: {accepted}"
            );
        }
    }
}

/// Returns the number of equal steps that a test takes to its decision, and that decision.
fn steps(mut test: Sprt, mut step: impl FnMut(&mut Sprt) -> Decision) -> (u64, Decision) {
    while step(&mut test) == Decision::Continue {}
    // Further values do not change it.
    assert_eq!(step(&mut test), test.decision());
    (test.count(), test.decision())
}

#[test]
fn likelihood_ratios_are_those_of_the_laws() {
    // Steps of this logarithm reach ln 1e4 or ln 1e-6.
    let decided = |log: f64| {
        let (threshold, decision) = if log > 0.0 {
            (1e-4, Decision::Alternative)
        } else {
            (1e-6, Decision::Null)
        };
        ((f64::ln(threshold) / log).abs().ceil() as u64, decision)
    };
    let new = || Sprt::new(1e-4, 1e-6);
    for (null, alternative) in [(0.2, 0.3), (0.5, 0.25)] {
        for success in [true, false] {
            let of = |q: f64| if success { q } else { 1.0 - q };
            let found = steps(new(), |test| test.bernoulli(success, null, alternative));
            assert_eq!(
                found,
                decided((of(alternative) / of(null)).ln()),
                "{null} {alternative} {success}"
            );
        }
    }
    // Half the difference of squared distances, in units of the variance.
    for (value, null, alternative, sigma) in [
        (2.5, 1.0, 3.0, 4.0),
        (1.5, 1.0, 3.0, 4.0),
        (-2.0, 1.5, 0.5, 3.0),
    ] {
        let square = |mean: f64| ((value - mean) / sigma).powi(2);
        let found = steps(new(), |test| test.normal(value, null, alternative, sigma));
        assert_eq!(
            found,
            decided(0.5 * (square(null) - square(alternative))),
            "{value} {null} {alternative}"
        );
    }
}

#[test]
fn a_decision_is_reached_at_the_threshold_itself() {
    // Ratios of 4 and 1/4 against thresholds of 4 and 1/4.
    let new = || Sprt::new(0.25, 0.25);
    assert_eq!(new().decision(), Decision::Continue);
    assert_eq!(new().bernoulli(true, 0.125, 0.5), Decision::Alternative);
    assert_eq!(new().bernoulli(true, 0.5, 0.125), Decision::Null);
}

/// Intervals of theorem 2 after so many values of [0, 1], with every sum computed anew in 50
/// digits.
const INTERVALS: [(u64, [f64; 2]); 4] = [
    (1, [-7.474_332_498_507_85, 7.474_332_498_507_85]),
    (2, [-3.719_892_136_476_32, 3.769_892_136_476_32]),
    (10, [-0.374_444_347_327_65, 1.184_444_347_327_65]),
    (300, [0.343_470_795_831_978, 0.457_178_638_941_791]),
];

#[test]
fn confidence_sequences_are_those_of_the_theorem() {
    let [low, high] = [-1.0, 3.0];
    let mut sequence = ConfidenceSequence::new(0.05, [low, high]);
    assert_eq!((sequence.interval(), sequence.count()), ([low, high], 0));
    for i in 0..300 {
        // Bets are clipped at first and free later on.
        sequence.push(low + (high - low) * f64::from(i * i % 17) / 20.0);
        let found = sequence.interval();
        assert_eq!(sequence.minimum_detectable_effect(), found[1] - found[0]);
        if let Some((_, expected)) = INTERVALS
            .iter()
            .find(|(count, _)| *count == sequence.count())
        {
            assert_relative_eq!(
                found[..],
                expected.map(|x| low + (high - low) * x)[..],
                max_relative = 1e-9
            );
        }
    }
    assert_eq!(sequence.count(), 300);
}

#[test]
fn a_sequence_decides_at_its_borders() {
    // Before any value the interval is [0, 2].
    let decide =
        |reference, margin| ConfidenceSequence::new(0.05, [0.0, 2.0]).decide(reference, margin);
    for (reference, margin, expected) in [
        (1.0, 1.0, Decision::Null),
        (2.0, 2.0, Decision::Null),
        (0.0, 2.0, Decision::Null),
        (0.0, 1.0, Decision::Continue),
        (2.0, 1.0, Decision::Continue),
        (1.0, 0.5, Decision::Continue),
        (2.5, 9.0, Decision::Alternative),
        (-0.5, 9.0, Decision::Alternative),
    ] {
        assert_eq!(
            decide(reference, margin),
            expected,
            "{reference} ± {margin}"
        );
    }
}
