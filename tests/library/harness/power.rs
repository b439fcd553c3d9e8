//! Tests of stated power against closed forms and against sums over whole distributions.

use super::*;
use crate::reference::assert_table;

fn law(name: &str, a: &[f64]) -> Sensitivity {
    match name {
        "binomial" => Sensitivity::Binomial {
            n: a[0] as u64,
            probability: a[1],
        },
        "poisson" => Sensitivity::Poisson { mean: a[0] },
        "normal" => Sensitivity::Normal {
            standard_error: a[0],
            dof: a[1],
            tests: a[2] as usize,
        },
        "cells" => Sensitivity::Cells {
            dof: a[0],
            n: a[1],
            min_probability: a[2],
            tests: a[3] as usize,
        },
        other => panic!("no law {other}"),
    }
}

#[test]
fn misses_are_those_of_the_laws() {
    assert_table(include_str!("../data/power.csv"), |row, arguments| {
        let (effect, parameters) = arguments.split_last().expect("an effect");
        let (name, quantity) = row.split_once(' ').unwrap_or((row, "missed"));
        let law = law(name, parameters);
        match quantity {
            "rejected" => 1.0 - law.miss(*effect),
            "at worst" => law.worst_miss(*effect),
            _ => law.miss(*effect),
        }
    });
}

#[test]
fn smallest_effects_are_seen_for_certain() {
    for standard_error in [1e-9, 2.0, 1e9] {
        let found = normal(standard_error, f64::INFINITY).smallest_effect(ALPHA);
        let expected = standard_error * (normal_upper(0.5 * ALPHA) + normal_upper(ALPHA));
        assert_relative_eq!(found, expected, max_relative = 1e-8);
    }
    let nothing = Sensitivity::Cells {
        dof: 0.0,
        n: 1e6,
        min_probability: 1.0,
        tests: 1,
    };
    assert_eq!(nothing.smallest_effect(ALPHA), f64::INFINITY);
    // √(ln(2/α)/2n) to be rejected, √(ln(1/α)/2n) for certainty.
    let distance = Sensitivity::Distance { n: 5000 };
    let expected = ((2.0 / ALPHA).ln() / 1e4).sqrt() + ((1.0 / ALPHA).ln() / 1e4).sqrt();
    assert_relative_eq!(
        distance.smallest_effect(ALPHA),
        expected,
        max_relative = 1e-8
    );
    assert_eq!(distance.miss(0.04), 1.0);
}

/// At the returned level the power is as requested; no level is finer than the suite's own.
#[test]
fn levels_of_a_power_are_found() {
    let laws = [
        normal(1.0, 200.0),
        Sensitivity::Cells {
            dof: 5.0,
            n: 5.0,
            min_probability: 0.5,
            tests: 2,
        },
        Sensitivity::Distance { n: 2 },
        Sensitivity::Bernstein {
            root: 0.4,
            range: 0.01,
        },
    ];
    for law in laws {
        let mut last = 0.0;
        for power in [0.5, 0.9] {
            let level = law.level_with_power(2.2, power);
            assert!(last < level && level < 1.0, "{law:?} {power} {level}");
            assert_abs_diff_eq!(law.miss_at(2.2, level), 1.0 - power, epsilon = 1e-6);
            last = level;
        }
        assert_eq!(law.level_with_power(1e3, 0.9), ALPHA);
        assert_eq!(law.miss(2.2), law.miss_at(2.2, ALPHA));
    }
    // z exceeds its critical value by 2.2 half of the time, and 1.28 below it.
    let known = normal(1.0, f64::INFINITY);
    for (power, critical) in [(0.5, 2.2), (0.9, 2.2 - normal_upper(0.1))] {
        let level = 2.0 * normal_sf(critical);
        assert_relative_eq!(
            known.level_with_power(2.2, power),
            level,
            max_relative = 1e-2
        );
    }
    // Counts jump: the power is at least as requested at the level, and less just below it.
    let coin = Sensitivity::Binomial {
        n: 400,
        probability: 0.5,
    };
    let level = coin.level_with_power(0.05, 0.9);
    assert!(coin.miss_at(0.05, level) <= 0.1 && coin.miss_at(0.05, 0.9999 * level) > 0.1);
    assert_eq!(
        Sensitivity::Poisson { mean: 1e-4 }.level_with_power(0.125, 0.5),
        1.0
    );
}

/// Finds the detectable effect with the statistic itself: of hypotheses at growing distance from
/// the data, the first that is rejected has the effect that is missed half of the time.
#[test]
fn outcomes_state_the_power_of_their_own_statistic() {
    let claim = Claim::Equal { delta: 0.1 };
    let values = around(1.0, 1.0, 10_000);
    let first_rejected = |outcome: &dyn Fn(f64) -> Outcome| {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if outcome(middle).p < ALPHA {
                high = middle;
            } else {
                low = middle;
            }
        }
        high
    };
    let t = |effect: f64| mean("t", &values, 1.0 + effect, claim);
    let other = |effect: f64| welch("w", &values, &around(1.0 + effect, 1.0, 10_000), claim);
    for statistic in [&t as &dyn Fn(f64) -> Outcome, &other] {
        let at = first_rejected(statistic);
        assert_relative_eq!(
            statistic(0.0).sensitivity.miss(at),
            0.5,
            max_relative = 1e-3
        );
    }
    let ratio = |effect: f64| variance_ratio("r", &values, &values, 1.0 + effect, 0.1);
    let at = first_rejected(&ratio);
    // The hypothesis changes its own standard error, here by 8 % at the critical value.
    assert_relative_eq!(
        ratio(0.0).sensitivity.miss(at / 1.045),
        0.5,
        max_relative = 0.1
    );
    let bounded = |effect: f64| bounded_mean("b", &values, 1.0 + effect, [0.0, 2.0], claim);
    let at = first_rejected(&bounded);
    assert_relative_eq!(bounded(0.0).sensitivity.miss(at), 1.0);
    assert!(bounded(0.0).sensitivity.miss(1.2 * at) < 1.0);
    let detected = bounded(0.0).minimum_detectable_effect();
    // Rejection needs ln(4/α), and certainty on both sides as much again.
    assert_relative_eq!(detected, 2.0 * at, max_relative = 1e-3);
}

#[test]
fn few_or_equal_values_have_little_power() {
    // No variance: nothing is known.
    let outcome = mean(
        "c",
        &around(1.0, 0.0, 1000),
        1.0,
        Claim::Equal { delta: 0.1 },
    );
    assert!(outcome.miss() > 0.999);
    assert_eq!(outcome.minimum_detectable_effect(), f64::INFINITY);
    let weak = mean(
        "t",
        &around(1.0, 1.0, 10_000),
        1.0,
        Claim::Equal { delta: 0.06 },
    );
    assert!(weak.power().starts_with("0."), "{}", weak.power());
    let rare = poisson("rare", 0, 1_000_000, 1e-4, 30.0);
    assert!(rare.miss() < 1e-9 && rare.verdict().word() == "holds");
    assert!(chi_square_sf(rare.minimum_detectable_effect(), 2.0) < 1e-5);
    let detected = binomial("coin", 500, 1000, 0.5, 0.2).minimum_detectable_effect();
    // About 12 standard errors of 0.0158, slightly fewer because the distribution is narrower
    // there.
    assert!(0.17 < detected && detected < 0.19, "{detected}");
}
