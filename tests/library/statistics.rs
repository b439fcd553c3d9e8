//! The statistics' own code, tested exactly: statistics against hand-made data, verdicts against the rules.

use approx::assert_relative_eq;
use glam::DVec3;
use whitefurnace::harness::chi_square::{Counts, binomial, chi_square, count, pool};
use whitefurnace::harness::convergence::{f_test, log_slope, slope, variance_ratio};
use whitefurnace::harness::domain::{Domain, Partition};
use whitefurnace::harness::ks::kolmogorov_smirnov;
use whitefurnace::harness::mean::{
    Values, bounded_mean, mean, mean_known_sigma, welch, welch_satterthwaite,
};
use whitefurnace::harness::outcome::{
    ALPHA, Claim, Outcome, Verdict, approximate_verdict, exact_verdict,
};
use whitefurnace::harness::quadrature::{Rectangle, integrate};
use whitefurnace::harness::sequential::{ConfidenceSequence, Decision, Sprt};
use whitefurnace::harness::tails;
use whitefurnace::harness::welch_map::{PixelStatistics, image_mean, map};

#[test]
fn exact_verdicts_follow_the_rule() {
    let verdict = |p, interval| exact_verdict(p, interval, 1.0, 0.1, 100);
    assert_eq!(verdict(0.9 * ALPHA, [0.95, 1.05]), Verdict::Fails);
    assert_eq!(verdict(f64::NAN, [0.95, 1.05]), Verdict::Fails);
    assert_eq!(verdict(1.1 * ALPHA, [0.95, 1.05]), Verdict::Holds);
    // n (width/δ)², here 2.56 n and 6.25 n, up to rounding.
    let needed = |interval| match verdict(1.0, interval) {
        Verdict::Undecided { needed } => needed,
        decided => panic!("{decided:?}"),
    };
    assert!(needed([0.89, 1.05]).abs_diff(256) <= 1);
    assert!(needed([0.95, 1.2]).abs_diff(625) <= 1);
}

#[test]
fn approximate_verdicts_follow_the_rule() {
    let verdict = |interval| approximate_verdict(interval, 1.0, 0.1, 100);
    assert_eq!(verdict([0.91, 1.09]), Verdict::Holds);
    assert_eq!(verdict([1.11, 1.2]), Verdict::Fails);
    assert_eq!(verdict([0.7, 0.89]), Verdict::Fails);
    assert_eq!(verdict([f64::NAN, f64::NAN]), Verdict::Fails);
    assert!(matches!(verdict([1.05, 1.15]), Verdict::Undecided { .. }));
}

#[test]
fn nan_and_infinity_never_hold() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut values = Values::new(1.0);
        (0..1000).for_each(|i| values.push(if i == 500 { bad } else { 1.0 }));
        let claim = Claim::Exact { delta: 10.0 };
        assert_eq!(mean("t", &values, 1.0, claim).verdict(), Verdict::Fails);
        assert_eq!(welch("w", &values, &values, claim).verdict(), Verdict::Fails);
        assert_eq!(mean_known_sigma("z", &values, 1.0, 1.0, claim).verdict(), Verdict::Fails);
        assert_ne!(bounded_mean("b", &values, 1.0, [0.0, 2.0], claim).verdict(), Verdict::Holds);
        assert_eq!(Outcome::exact("e", 1, bad, 1.0, "").verdict(), Verdict::Fails);
    }
    let mut values = vec![f64::NAN; 200];
    let outcome = kolmogorov_smirnov("ks", &mut values, |x| x, 1.0);
    assert_eq!(outcome.verdict(), Verdict::Fails);
}

#[test]
fn a_claim_without_tolerance_is_of_every_value() {
    let every = Claim::Exact { delta: 0.0 };
    let verdict = |last: f64, reference: f64| {
        let mut values = Values::new(2.0);
        (0..99).for_each(|_| values.push(2.0));
        values.push(last);
        mean("every", &values, reference, every).verdict()
    };
    assert_eq!(verdict(2.0, 2.0), Verdict::Holds);
    assert_eq!(verdict(2.0 + 4.0 * f64::EPSILON, 2.0), Verdict::Holds);
    // One value that is off by 2e-8 is seen though the mean is off by 2e-10; and so is the reference.
    assert_eq!(verdict(2.0 + 2e-8, 2.0), Verdict::Fails);
    assert_eq!(verdict(2.0, 2.0 + 3e-9), Verdict::Fails);
    assert_eq!(verdict(f64::NAN, 2.0), Verdict::Fails);
}

/// 1, 2, 3, 4, 10: mean 4, variance 12.5, third central moment 36 (all by hand).
fn five() -> Values {
    let mut values = Values::new(3.7);
    for x in [1.0, 2.0, 3.0, 4.0, 10.0] {
        values.push(x);
    }
    values
}

#[test]
fn t_z_and_welch_values_are_those_of_the_textbook() {
    let claim = Claim::Exact { delta: 1.0 };
    let t = mean("t", &five(), 3.0, claim);
    assert_relative_eq!(t.value, 1.0 / 2.5_f64.sqrt(), max_relative = 1e-14);
    assert_eq!(t.dof, Some(4.0));
    let z = mean_known_sigma("z", &five(), 3.0, 2.0, claim);
    assert_relative_eq!(z.value, 5_f64.sqrt() / 2.0, max_relative = 1e-14);
    // Third moment about the mean, 180/5; the variance used is the unbiased one.
    assert_relative_eq!(five().skewness(), 36.0 / 12.5_f64.powf(1.5), max_relative = 0.3);
    // NIST handbook, 1.3.5.3, form: equal variances and counts give 2(n − 1) degrees of freedom.
    assert_relative_eq!(welch_satterthwaite([(2.5, 5), (2.5, 5)]), 8.0);
    assert_relative_eq!(welch_satterthwaite([(1.0, 5), (2.0, 9)]), 9.0 / (0.25 + 0.5));
    let w = welch("w", &five(), &five(), claim);
    assert_eq!((w.value, w.p), (0.0, 1.0));
}

#[test]
fn skewed_values_need_more_samples() {
    // 1 in 1000 values is 1: skewness about 31.5, so (31.5 z³/0.9)² = 6.4e7 values.
    let mut values = Values::new(0.001);
    (0..100_000).for_each(|i| values.push(if i % 1000 == 0 { 1.0 } else { 0.0 }));
    let outcome = mean("rare", &values, 0.001, Claim::Exact { delta: 1.0 });
    assert!(matches!(outcome.verdict(), Verdict::Undecided { needed } if needed > 40_000_000));
    let z = tails::normal_upper(ALPHA / 2.0);
    let expected = (values.skewness() * z.powi(3) / 0.9).powi(2).ceil();
    assert_eq!(values.valid_from() as f64, expected);
    assert_relative_eq!(values.skewness(), 0.998 / (0.000_999_f64).sqrt(), max_relative = 1e-3);
}

#[test]
fn empirical_bernstein_p_and_interval_agree() {
    let values = Values::collect(0.5, 1000, {
        let mut i = 0;
        move || {
            i += 1;
            f64::from(i % 2)
        }
    });
    let claim = Claim::Exact { delta: 1.0 };
    let outcome = bounded_mean("b", &values, 0.5, [0.0, 1.0], claim);
    assert_eq!(outcome.p, 1.0);
    // At the interval's end the p-value is the level.
    let at_end = bounded_mean("b", &values, outcome.interval[1], [0.0, 1.0], claim);
    assert_relative_eq!(at_end.p, ALPHA, max_relative = 1e-6);
    // √(2VL/n) + 7L/(3(n − 1)) with V = 1000/3996, L = ln 4e9.
    let l = 4e9_f64.ln();
    let half = (2.0 * (1000.0 / 3996.0) * l / 1000.0).sqrt() + 7.0 * l / (3.0 * 999.0);
    assert_relative_eq!(outcome.interval[1], 0.5 + half, max_relative = 1e-12);
}

#[test]
fn kolmogorov_distance_is_exact_on_a_grid() {
    // Midpoints of n equal intervals: D = 1/(2n).
    let mut values: Vec<f64> = (0..1000).rev().map(|i| (f64::from(i) + 0.5) / 1000.0).collect();
    let outcome = kolmogorov_smirnov("grid", &mut values, |x| x, 0.5);
    assert_relative_eq!(outcome.estimate, 0.0005, max_relative = 1e-9);
    let moved = kolmogorov_smirnov("moved", &mut values, |x| x + 0.1, 0.5);
    assert_relative_eq!(moved.estimate, 0.1005, max_relative = 1e-9);
    // Massart's bound 2 exp(−2 · 1000 · 0.1005²) is 3e-9: not quite rejected.
    assert_relative_eq!(moved.p, 2.0 * (-2000.0 * 0.1005_f64.powi(2)).exp(), max_relative = 1e-6);
    assert_eq!(moved.verdict(), Verdict::Holds);
    let further = kolmogorov_smirnov("further", &mut values, |x| x + 0.12, 0.5);
    assert_eq!(further.verdict(), Verdict::Fails);
}

#[test]
fn pearson_statistic_and_pooling_by_hand() {
    let places = || ["a", "b", "c"].map(String::from).to_vec();
    let partition = Partition::of_masses(vec![0.5, 0.3, 0.2], places());
    let counts = |observed: [u64; 3]| Counts {
        n: observed.iter().sum(),
        observed: observed.to_vec(),
        ..Counts::default()
    };
    let outcome = chi_square("hand", &partition, &counts([5100, 2950, 1950]), 0.5);
    // 100²/5000 + 50²/3000 + 50²/2000.
    assert_relative_eq!(outcome.value, 2.0 + 2500.0 / 3000.0 + 1.25, max_relative = 1e-12);
    assert_relative_eq!(outcome.p, tails::chi_square_sf(outcome.value, 2.0));
    assert_relative_eq!(outcome.estimate, -0.025, max_relative = 1e-12);
    // Fewer than 32 cells: each expects at least 1000.
    assert_eq!(pool(&[5000.0, 999.0, 600.0], &[1, 2, 3]), [[5000.0, 1.0], [1599.0, 5.0]]);
    assert_eq!(pool(&[5000.0, 100.0], &[7, 8]), [[5100.0, 15.0]]);
    // From 32 on, 300 is enough.
    assert_eq!(pool(&[300.0; 32], &[0; 32]).len(), 32);
    assert_eq!(pool(&[299.0; 32], &[0; 32]).len(), 8);
    assert_eq!(pool(&[999.0; 31], &[0; 31]).len(), 15);
}

#[test]
fn lost_and_forbidden_samples_are_seen() {
    let partition = Partition::equal(Domain::Square, 2, 2);
    let counts = |lost, forbidden| Counts {
        n: 40_000 + lost + forbidden,
        observed: vec![10_000; 4],
        lost,
        forbidden,
        example: (forbidden > 0).then_some(DVec3::ZERO),
    };
    assert_eq!(chi_square("right", &partition, &counts(0, 0), 0.5).p, 1.0);
    assert_eq!(chi_square("lost", &partition, &counts(1, 0), 0.5).p, 0.0);
    assert_eq!(chi_square("forbidden", &partition, &counts(0, 1), 0.5).p, 0.0);
    // A pdf with mass 0.9: 10 % must be lost, neither none nor 20 %.
    let partition = Partition::of_pdf(Domain::Square, 4, &|_| 0.9);
    assert_relative_eq!(partition.loss, 0.1, max_relative = 1e-9);
    let p = |lost| chi_square("loss", &partition, &counts(lost, 0), 0.5).p;
    assert!(p(4444) > 0.5 && p(0) < ALPHA && p(10_000) < ALPHA);
    // Points outside the domain, and where the pdf is zero, are forbidden.
    let outside = count(&partition, 1, || Some(DVec3::new(1.5, 0.0, 0.0)), |_| true);
    let zero = count(&partition, 1, || Some(DVec3::new(0.5, 0.5, 0.0)), |_| false);
    assert_eq!((outside.forbidden, zero.forbidden), (1, 1));
}

#[test]
fn binomial_outcomes_are_exact() {
    let outcome = binomial("coin", 3, 10, 0.2, 0.5);
    assert_relative_eq!(outcome.p, 2.0 * 0.322_200_473_6, max_relative = 1e-6);
    assert_eq!(binomial("mirror", 0, 1_000_000, 0.04, 0.01).verdict(), Verdict::Fails);
}

#[test]
fn quadrature_is_exact_for_polynomials_and_adapts_to_kinks() {
    let unit = Rectangle { x: [-1.0, 2.0], y: [0.0, 3.0] };
    let power =
        |p: i32, [a, b]: [f64; 2]| (f64::powi(b, p + 1) - f64::powi(a, p + 1)) / f64::from(p + 1);
    for (i, j) in [(0, 0), (3, 12), (22, 0), (7, 20)] {
        let found = integrate(unit, 1e300, &mut |x, y| x.powi(i) * y.powi(j));
        assert_relative_eq!(found.value, power(i, unit.x) * power(j, unit.y), max_relative = 1e-12);
    }
    let kink = integrate(unit, 1e-9, &mut |x, _| (x - 0.3).abs());
    assert_relative_eq!(kink.value, 3.0 * (1.3 * 1.3 + 1.7 * 1.7) / 2.0, epsilon = 1e-8);
    assert!(integrate(unit, 1e-9, &mut |_, _| f64::NAN).value.is_nan());
}

#[test]
fn quadrature_ends_where_nothing_is_left_to_refine_and_at_its_limit() {
    let unit = Rectangle { x: [0.0, 1.0], y: [0.0, 1.0] };
    let evaluations = |f: &dyn Fn(f64) -> f64| {
        let mut n = 0;
        let found = integrate(unit, 0.0, &mut |x, _| {
            n += 1;
            f(x)
        });
        (n, found.error > 0.0)
    };
    assert_eq!(evaluations(&|_| 0.0), (225, false));
    // A kink is surrounded until rounding is left.
    let (n, inexact) = evaluations(&|x| (x - 0.3).abs());
    assert!(inexact && n < 225 * 2 * 1024, "{n}");
    // A step across the square leaves half of its error to twice as many: each of 20 000 rectangles but
    // the first is one half of another.
    let mut n = 0;
    let step = integrate(unit, 0.0, &mut |x, y| {
        n += 1;
        f64::from(x + y < 0.7)
    });
    assert!(step.error > 0.0);
    assert_eq!(n, 225 * (2 * 20_000 - 1));
}

/// However rough a density is, its partition ends, and nothing holds with it. (A pair of rules that
/// disagree does the same everywhere.)
#[test]
fn partitions_of_rough_densities_end_undecided() {
    let noise = |p: DVec3| f64::from((1e8 * (p.x + 1.7 * p.y)).sin() > 0.0);
    let evaluations = std::cell::Cell::new(0_u64);
    let rough = |p: DVec3| {
        evaluations.set(evaluations.get() + 1);
        1.0 + noise(p) - 0.5
    };
    let partition = Partition::of_pdf(Domain::Square, 4, &rough);
    // 2048 fields and 20 000 halvings, 225 values each.
    assert!(evaluations.get() <= 225 * (2048 + 2 * 20_000));
    assert!(partition.error > 1e-4, "{}", partition.error);
    let counts = Counts { n: 40_000_000, observed: vec![10_000_000; 4], ..Counts::default() };
    let verdict = chi_square("rough", &partition, &counts, 0.5).verdict();
    assert!(matches!(verdict, Verdict::Undecided { .. }), "{verdict:?}");
    let nan = Partition::of_pdf(Domain::Square, 4, &|_| f64::NAN);
    assert!(nan.error.is_nan());
    assert_eq!(chi_square("NaN", &nan, &counts, 0.5).verdict(), Verdict::Fails);
}

#[test]
fn domains_have_their_measures_and_equal_cells() {
    use std::f64::consts::PI;
    let domains = [
        (Domain::Sphere, 4.0 * PI),
        (Domain::Hemisphere, 2.0 * PI),
        (Domain::CosineHemisphere, 2.0 * PI),
        (Domain::Disk, PI),
        (Domain::Square, 1.0),
        (Domain::Triangle, 0.5),
    ];
    for (domain, measure) in domains {
        assert_relative_eq!(
            domain.integrate_all(1e-9, &|_| 1.0).value,
            measure,
            max_relative = 1e-9
        );
        let law = |p: DVec3| {
            if domain == Domain::CosineHemisphere { p.z / PI } else { 1.0 / measure }
        };
        // Gathering the law by quadrature finds its cells equally probable, whatever the cut.
        let partition = Partition::of_pdf(domain, 8, &law);
        assert_eq!(partition.masses.len(), 8);
        for mass in &partition.masses {
            assert_relative_eq!(*mass, 0.125, max_relative = 1e-6);
        }
    }
}

#[test]
fn the_slope_of_a_power_is_its_exponent() {
    let sizes = [1.0, 10.0, 100.0, 1000.0];
    let errors: Vec<f64> = sizes.iter().map(|n: &f64| 3.0 * n.powf(-1.5)).collect();
    assert_relative_eq!(log_slope(&sizes, &errors), -1.5, max_relative = 1e-12);
    let groups = |errors: &[f64]| -> Vec<Vec<f64>> {
        let tilted = |tilt: f64| errors.iter().zip(sizes).map(move |(e, n)| e * n.powf(tilt));
        let signs = (0..10).map(|i| if i % 2 == 0 { 1e-3 } else { -1e-3 });
        signs.map(|tilt| tilted(tilt).collect()).collect()
    };
    let outcome = slope("power", &sizes, &groups(&errors), -1.5, 0.1);
    assert_eq!(outcome.verdict(), Verdict::Holds);
    let outcome = slope("power", &sizes, &groups(&[1.0; 4]), -1.5, 0.1);
    assert_eq!(outcome.verdict(), Verdict::Fails);
}

#[test]
fn variance_ratios_are_ratios_of_means() {
    let values = |scale: f64| {
        let mut i = 0;
        Values::collect(scale, 1_000_000, move || {
            i += 1;
            scale * (1.0 + 0.1 * f64::from(i % 3 - 1))
        })
    };
    let right = variance_ratio("ratio", &values(4.0), &values(2.0), 2.0, 0.01);
    assert_relative_eq!(right.estimate, 2.0, max_relative = 1e-6);
    assert_eq!(right.verdict(), Verdict::Holds);
    let wrong = variance_ratio("ratio", &values(4.0), &values(2.0), 2.1, 0.01);
    assert_eq!(wrong.verdict(), Verdict::Fails);
    assert_relative_eq!(f_test((1.0, 10), (1.0, 10), 1.0), 1.0, max_relative = 1e-9);
    assert_relative_eq!(
        f_test((2.0, 8), (1.0, 10), 1.0),
        f_test((1.0, 10), (2.0, 8), 1.0),
        max_relative = 1e-9
    );
}

#[test]
fn images_are_compared_as_a_whole_by_tile_and_by_pixel() {
    let (width, height) = (5, 4);
    let n = width * height;
    let (variance, count) = (vec![0.04; n], vec![100; n]);
    let mean_a = vec![1.0; n];
    let mut mean_b = mean_a.clone();
    mean_b[7] += 1.0;
    let [a, b] =
        [&mean_a, &mean_b].map(|mean| PixelStatistics { mean, variance: &variance, count: &count });
    // One pixel of variance 2 · 0.04/100: 1/0.0283 = 35.36 sigmas, and degrees of freedom 198.
    let pixels = map(&a, &b, width, 1);
    assert_relative_eq!(pixels.sigmas[7], -1.0 / 0.0008_f64.sqrt(), max_relative = 1e-12);
    assert_relative_eq!(
        pixels.p[7].expect("judged"),
        tails::student_two_sided(pixels.sigmas[7], 198.0),
        max_relative = 1e-9
    );
    assert_eq!(pixels.smallest("pixels", 100).verdict(), Verdict::Fails);
    assert_eq!(pixels.histogram(4), [1, 0, 0, 19]);
    // Tiles of 3: two across, two down; pixel (2, 1) lies in the first, of nine pixels.
    let tiles = map(&a, &b, width, 3);
    assert_eq!((tiles.width, tiles.height), (2, 2));
    assert_relative_eq!(tiles.sigmas[0], -1.0 / (9.0 * 0.0008_f64).sqrt(), max_relative = 1e-12);
    let even = vec![0.0; a.mean.len()];
    let whole = image_mean("image", (&a, &even), (&b, &even), 0.01);
    assert_relative_eq!(whole.estimate, -0.05, max_relative = 1e-12);
    assert_relative_eq!(whole.value, -1.0 / (20.0 * 0.0008_f64).sqrt(), max_relative = 1e-9);
    let same = image_mean("same", (&a, &even), (&a, &even), 0.05);
    assert_eq!(same.verdict(), Verdict::Holds);
}

#[test]
fn sequential_tests_stop_at_their_thresholds() {
    // Each success multiplies the ratio by 2: 1/α = 1024 is reached at the tenth.
    let mut sprt = Sprt::new(1.0 / 1024.0, 1e-3);
    let decisions: Vec<_> = (0..12).map(|_| sprt.bernoulli(true, 0.25, 0.5)).collect();
    assert_eq!(decisions[8], Decision::Continue);
    assert_eq!(decisions[9], Decision::Alternative);
    assert_eq!(sprt.count(), 10);
    let mut sprt = Sprt::new(1e-3, 1e-3);
    // A normal value at the null's mean lowers the log ratio by 1/2 (effect one sigma).
    let steps =
        (0..100).take_while(|_| sprt.normal(0.0, 0.0, 1.0, 1.0) == Decision::Continue).count();
    assert_eq!((steps, sprt.decision()), (13, Decision::Null));
    let mut sequence = ConfidenceSequence::new(ALPHA, [0.0, 2.0]);
    (0..20_000).for_each(|i| sequence.push(f64::from(i % 2) + 0.5));
    let [low, high] = sequence.interval();
    assert!(low < 1.0 && high > 1.0 && high - low < 0.1, "{low} {high}");
    assert_eq!(sequence.decide(1.0, 0.1), Decision::Null);
    let detected = sequence.minimum_detectable_effect();
    assert_eq!(sequence.decide(high + 1e-9, 0.1), Decision::Alternative);
    assert_relative_eq!(detected, high - low, max_relative = 1e-12);
    assert_eq!(sequence.decide(1.2, 0.1), Decision::Alternative);
}
