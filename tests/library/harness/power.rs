//! Stated power against closed forms and against sums over whole laws.

use super::*;

/// P(accepted) by adding up the law, value by value.
fn added_up(values: u64, mass: impl Fn(u64) -> f64, accepted: impl Fn(u64) -> bool) -> f64 {
    (0..=values).filter(|&k| accepted(k)).map(mass).sum()
}

/// The probability of k successes among n.
fn binomial_law(n: u64, q: f64) -> impl Fn(u64) -> f64 {
    move |k| {
        let choose = (0..k).fold(1.0, |c, i| c * (n - i) as f64 / (i + 1) as f64);
        choose * q.powi(k as i32) * (1.0 - q).powi((n - k) as i32)
    }
}

#[test]
fn misses_of_counts_are_sums_over_their_laws() {
    let n = 60;
    let test = Sensitivity::Binomial { n, probability: 0.4 };
    for effect in [-0.39, -0.2, 0.0, 0.1, 0.3, 0.55] {
        let accepted = |k| binomial_two_sided(k, n, 0.4) >= ALPHA;
        let expected = added_up(n, binomial_law(n, 0.4 + effect), accepted);
        assert_relative_eq!(test.miss(effect), expected, max_relative = 1e-9);
    }
    // A probability above 1 does not exist.
    assert_eq!(test.miss(0.7), 0.0);

    let poisson_law = |mean: f64| move |k: u64| (1..=k).fold((-mean).exp(), |mass, i| mass * mean / i as f64);
    let test = Sensitivity::Poisson { mean: 30.0 };
    for effect in [-29.0, -10.0, 0.0, 20.0, 70.0] {
        let accepted = |k| 2.0 * poisson_sf(k, 30.0).min(poisson_cdf(k, 30.0)) >= ALPHA;
        let expected = added_up(400, poisson_law(30.0 + effect), accepted);
        assert_relative_eq!(test.miss(effect), expected, max_relative = 1e-9);
    }
}

#[test]
fn the_worse_side_of_an_effect_counts() {
    // A share of 0.9 may fall by 0.3, a share of 0.1 may rise by it; the other way is impossible.
    let share = |probability| Sensitivity::Binomial { n: 40, probability };
    for (probability, possible) in [(0.9, -0.3), (0.1, 0.3)] {
        let share = share(probability);
        assert_eq!(share.miss(-possible), 0.0);
        assert!(share.miss(possible) > 0.1);
        for size in [0.3, -0.3] {
            assert_eq!(share.worst_miss(size), share.miss(possible));
        }
    }
}

/// P(rejected) is as small as the level, and a miss as small as the law's tail: neither may be lost
/// beside 1.
#[test]
fn small_misses_and_small_levels_keep_their_digits() {
    let close = |found: f64, expected: f64, error: f64| {
        assert!((found / expected - 1.0).abs() < error, "{found:e} {expected:e}");
    };
    for effect in [-0.001, 0.0, 0.001] {
        let coin = Sensitivity::Binomial { n: 60, probability: 0.5 };
        let rejected = |k| binomial_two_sided(k, 60, 0.5) < ALPHA;
        close(1.0 - coin.miss(effect), added_up(60, binomial_law(60, 0.5 + effect), rejected), 1e-5);
    }
    for (probability, effect) in [(0.1, 0.89), (0.9, -0.89)] {
        let share = Sensitivity::Binomial { n: 60, probability };
        let accepted = |k| binomial_two_sided(k, 60, probability) >= ALPHA;
        let expected = added_up(60, binomial_law(60, probability + effect), accepted);
        assert!(expected < 1e-50);
        close(share.miss(effect), expected, 1e-9);
    }
    // Of two values both must be successes to be too many.
    let pair = Sensitivity::Binomial { n: 2, probability: 1e-5 };
    let effect = 1.0 - 1e-5 - 7.4e-9;
    let q = 1e-5 + effect;
    close(pair.miss(effect), (1.0 - q) * (1.0 + q), 1e-10);
}

#[test]
fn counts_at_the_ends_are_accepted_or_not() {
    let share = |n, probability| Sensitivity::Binomial { n, probability };
    // Ten values of 0.4 cannot be significant: 0.4¹⁰ is 1e-4.
    assert_eq!(share(10, 0.4).miss(0.55), 1.0);
    assert_eq!(share(10, 0.4).miss(-0.4), 1.0);
    // What is certain is contradicted by a single value.
    let even = 0.5_f64.powi(10);
    assert_relative_eq!(share(10, 1.0).miss(-0.5), even, max_relative = 1e-12);
    assert_relative_eq!(share(10, 0.0).miss(0.5), even, max_relative = 1e-12);
    let count = |mean| Sensitivity::Poisson { mean };
    // Nothing among 5 expected has probability exp(−5), among 30 too little; a mean below 0 is none.
    assert_eq!(count(5.0).miss(-5.0), 1.0);
    assert_eq!(count(30.0).miss(-30.0), 0.0);
    assert_eq!(count(5.0).miss(-5.1), 0.0);
    // Where nothing is expected, nothing is right, and one event is too many.
    assert_eq!(count(0.0).miss(0.0), 1.0);
    assert_relative_eq!(count(0.0).miss(2.0), (-2.0_f64).exp(), max_relative = 1e-12);
    // Means are searched as far as they go.
    let rejected = 1.0 - count(1e6).miss(0.0);
    assert!((0.9 * ALPHA..ALPHA).contains(&rejected), "{rejected:e}");
}

#[test]
fn few_degrees_of_freedom_widen_the_normal_law() {
    // One degree is Cauchy's law, and the quantile of two has a root.
    let p = 0.5 * ALPHA;
    let cauchy = 1.0 / (PI * p).tan();
    let root = (1.0 - 2.0 * p) / (2.0 * p * (1.0 - p)).sqrt();
    for (dof, c, bound, squared) in
        [(1.0, cauchy, 0.75 * cauchy, 1.0 + cauchy * cauchy / 2.0), (2.0, root, 0.875 * root, 1.0 + root * root / 4.0)]
    {
        let t = Sensitivity::Normal { standard_error: 0.5, dof, tests: 1 };
        let spread = squared.sqrt();
        for share in [0.0, 0.2, 0.6, 2.0] {
            let shift = share * c;
            let expected = normal_sf((shift - bound) / spread) - normal_sf((shift + bound) / spread);
            assert_relative_eq!(t.miss(0.5 * shift), expected, max_relative = 1e-7);
        }
    }
    // Without a standard error there is no doubt.
    let known = Sensitivity::Normal { standard_error: 0.0, dof: 2.0, tests: 1 };
    assert_eq!((known.miss(0.0), known.miss(1e-300)), (1.0, 0.0));
}

#[test]
fn misses_of_normal_statistics_are_normal_tails() {
    let known = |tests| Sensitivity::Normal { standard_error: 2.0, dof: f64::INFINITY, tests };
    let critical = normal_upper(0.5 * ALPHA);
    // Half of the effects at the critical value are missed, but for those beyond the other one.
    assert_relative_eq!(known(1).miss(2.0 * critical), 0.5, max_relative = 1e-9);
    assert_relative_eq!(known(1).miss(0.0), 1.0 - ALPHA, max_relative = 1e-12);
    assert_relative_eq!(known(1).smallest_effect(ALPHA), 2.0 * (critical + normal_upper(ALPHA)), max_relative = 1e-8);
    assert_relative_eq!(known(100).miss(2.0 * normal_upper(0.5 * ALPHA / 100.0)), 0.5, max_relative = 1e-9);
    // With a million degrees of freedom, t is z.
    let t = Sensitivity::Normal { standard_error: 2.0, dof: 1e6, tests: 1 };
    assert_relative_eq!(t.miss(16.0), known(1).miss(16.0), max_relative = 1e-3);
}

/// Cells of equal probability p under an effect δ on one of them: the noncentrality is n δ² p/(1 − p).
#[test]
fn misses_of_cells_and_distances_are_those_of_their_laws() {
    let cells = Sensitivity::Cells { dof: 1.0, n: 1e6, least: 0.5, tests: 1 };
    // Two cells are one share: the square of a z test of its relative error, standard error 1/1000.
    let share = Sensitivity::Normal { standard_error: 1e-3, dof: f64::INFINITY, tests: 1 };
    for effect in [0.001, 0.006, 0.012] {
        let found = cells.miss(effect);
        assert_relative_eq!(found, share.miss(effect), max_relative = 1e-8);
        assert_eq!(found, cells.miss(-effect));
    }
    let nothing = Sensitivity::Cells { dof: 0.0, n: 1e6, least: 1.0, tests: 1 };
    assert_eq!(nothing.smallest_effect(ALPHA), f64::INFINITY);
    // √(ln(2/α)/2n) to be rejected, √(ln(1/α)/2n) for certainty.
    let distance = Sensitivity::Distance { n: 5000 };
    let expected = ((2.0 / ALPHA).ln() / 1e4).sqrt() + ((1.0 / ALPHA).ln() / 1e4).sqrt();
    assert_relative_eq!(distance.smallest_effect(ALPHA), expected, max_relative = 1e-8);
    assert_eq!(distance.miss(0.04), 1.0);
}

/// At the level that is found the power is what was asked for; coarser than needed it is nowhere, finer than the
/// suite's own neither.
#[test]
fn levels_of_a_power_are_found() {
    let laws = [
        Sensitivity::Normal { standard_error: 1.0, dof: 200.0, tests: 1 },
        Sensitivity::Cells { dof: 5.0, n: 5.0, least: 0.5, tests: 2 },
        Sensitivity::Distance { n: 2 },
        Sensitivity::Bernstein { root: 0.4, range: 0.01 },
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
    // z of 2.2 beyond its critical value half of the time, and 1.28 below it.
    let known = Sensitivity::Normal { standard_error: 1.0, dof: f64::INFINITY, tests: 1 };
    for (power, critical) in [(0.5, 2.2), (0.9, 2.2 - normal_upper(0.1))] {
        let level = 2.0 * normal_sf(critical);
        assert_relative_eq!(known.level_with_power(2.2, power), level, max_relative = 1e-2);
    }
    // Counts jump: at the level the power is at least what was asked for, just below it is less.
    let coin = Sensitivity::Binomial { n: 400, probability: 0.5 };
    let level = coin.level_with_power(0.05, 0.9);
    assert!(coin.miss_at(0.05, level) <= 0.1 && coin.miss_at(0.05, 0.9999 * level) > 0.1);
    assert_eq!(Sensitivity::Poisson { mean: 1e-4 }.level_with_power(0.125, 0.5), 1.0);
}

/// The effect that is found by asking the statistic itself: of hypotheses further and further from the
/// data, the first that is rejected is as far off as an effect that is missed half of the time.
#[test]
fn outcomes_state_the_power_of_their_own_statistic() {
    let claim = Claim::Exact { delta: 0.1 };
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
        assert_relative_eq!(statistic(0.0).sensitivity.miss(at), 0.5, max_relative = 1e-3);
    }
    let ratio = |effect: f64| variance_ratio("r", &values, &values, 1.0 + effect, 0.1);
    let at = first_rejected(&ratio);
    // The hypothesis enters its own standard error, here 8 % at the critical value.
    let wanted = ratio(0.0).sensitivity.miss(at / 1.045);
    assert_relative_eq!(wanted, 0.5, max_relative = 0.1);
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
    // Nothing varies: nothing is known.
    let outcome = mean("c", &around(1.0, 0.0, 1000), 1.0, Claim::Exact { delta: 0.1 });
    assert!(outcome.miss() > 0.999);
    assert_eq!(outcome.minimum_detectable_effect(), f64::INFINITY);
    let weak = mean("t", &around(1.0, 1.0, 10_000), 1.0, Claim::Exact { delta: 0.06 });
    assert!(weak.power().starts_with("0."), "{}", weak.power());
    let rare = poisson("rare", 0, 1_000_000, 1e-4, 30.0);
    assert!(rare.miss() < 1e-9 && rare.verdict().word() == "holds");
    assert!(chi_square_sf(rare.minimum_detectable_effect(), 2.0) < 1e-5);
    let coin = binomial("coin", 500, 1000, 0.5, 0.2);
    let detected = coin.minimum_detectable_effect();
    // About 12 standard errors of 0.0158, less what the law's smaller spread out there saves.
    assert!(0.17 < detected && detected < 0.19, "{detected}");
}
