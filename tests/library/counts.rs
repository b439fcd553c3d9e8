//! Chi-square, Kolmogorov-Smirnov and Welch maps against what the definitions say of small sets.

use std::cell::Cell;

use approx::assert_relative_eq;
use glam::DVec3;
use whitefurnace::harness::chi_square::{
    Counts, binomial, chi_square, count, poisson, pool, sampler_against_partition,
};
use whitefurnace::harness::domain::{Domain, Partition};
use whitefurnace::harness::ks::kolmogorov_smirnov;
use whitefurnace::harness::mean::welch_satterthwaite;
use whitefurnace::harness::outcome::{ALPHA, Claim, Outcome, Verdict};
use whitefurnace::harness::power::Sensitivity;
use whitefurnace::harness::tails::{
    binomial_cdf, binomial_interval, binomial_sf, binomial_two_sided, chi_square_sf, kolmogorov_sf,
    kolmogorov_upper, normal_upper, poisson_cdf, poisson_interval, poisson_sf, student_two_sided,
    student_upper,
};
use whitefurnace::harness::welch_map::{PValueMap, PixelStatistics, image_mean, map};

/// Three cells of probability 0.5, 0.3 and 0.2 of what is not lost.
fn partition(loss: f64, error: f64) -> Partition {
    let masses = [0.5, 0.3, 0.2].map(|m| m * (1.0 - loss)).to_vec();
    let places = ["a", "b", "c"].map(String::from).to_vec();
    let mut partition = Partition::of_masses(masses, places);
    (partition.loss, partition.error) = (loss, error);
    partition
}

/// Ten thousand samples in the three cells, and others.
fn counts(lost: u64, forbidden: u64) -> Counts {
    Counts {
        n: 10_000 + lost + forbidden,
        observed: vec![5100, 2950, 1950],
        lost,
        forbidden,
        example: (forbidden > 0).then_some(DVec3::X),
    }
}

/// The p-value of the three cells, 100²/5000 + 50²/3000 + 50²/2000 with two degrees of freedom.
fn cells_p() -> f64 {
    chi_square_sf(2.0 + 2500.0 / 3000.0 + 1.25, 2.0)
}

#[test]
fn every_sample_is_counted_once() {
    let cells = Partition::equal(Domain::Square, 2, 2);
    let at = |x, y| Some(DVec3::new(x, y, 0.0));
    let samples = [
        at(0.1, 0.1),
        None,
        at(0.1, 0.9),
        at(0.9, 0.1),
        at(0.9, 0.2),
        at(2.0, 0.0),
        at(0.5, 0.5),
        None,
        at(0.2, 0.2),
    ];
    let mut next = samples.into_iter();
    let found = count(&cells, 9, || next.next().expect("no more than asked for"), |p| p.x != 0.5);
    assert_eq!((found.n, found.lost, found.forbidden), (9, 2, 2));
    assert_eq!(found.observed, [2, 1, 2, 0]);
    assert_eq!(found.example, Some(DVec3::new(2.0, 0.0, 0.0)));
}

#[test]
fn cells_have_simultaneous_intervals() {
    let found = chi_square("cells", &partition(0.0, 0.0), &counts(0, 0), 0.5);
    assert_eq!((found.name.as_str(), found.n), ("cells", 10_000));
    assert_eq!(found.dof, Some(2.0));
    assert_relative_eq!(found.p, cells_p(), max_relative = 1e-12);
    let z = normal_upper(ALPHA / 6.0);
    let ends = [(0.5, 0.02), (0.3, -1.0 / 60.0), (0.2, -0.025)].map(|(mass, deviation)| {
        let half = z * f64::sqrt((1.0 - mass) / (mass * 10_000.0));
        [deviation - half, deviation + half]
    });
    let low = ends.iter().fold(0.0_f64, |low, end| low.min(end[0]));
    let high = ends.iter().fold(0.0_f64, |high, end| high.max(end[1]));
    assert_relative_eq!(found.interval[0], low, max_relative = 1e-9);
    assert_relative_eq!(found.interval[1], high, max_relative = 1e-9);
    let expected = [("a", 5000.0, 5100.0), ("b", 3000.0, 2950.0), ("c", 2000.0, 1950.0)];
    for (cell, (place, expected, observed)) in found.cells.iter().zip(expected) {
        assert_eq!((cell.place.as_str(), cell.observed), (place, observed));
        assert_relative_eq!(cell.expected, expected, max_relative = 1e-12);
        let sigmas = (observed - expected) / expected.sqrt();
        assert_relative_eq!(cell.sigmas, sigmas, max_relative = 1e-9);
    }
    assert_eq!(found.cells.len(), 3);
    assert_eq!(found.worst, "cell at a: 5100 samples, 5000.0 expected, +1.4 sigmas");
    let Sensitivity::Cells { dof, n, least, tests } = found.sensitivity else {
        panic!("{:?}", found.sensitivity);
    };
    assert_eq!((dof, n, tests), (2.0, 10_000.0, 1));
    assert_relative_eq!(least, 0.2, max_relative = 1e-12);
    // Half of the level is left where lost samples are tested, too.
    let halved = chi_square("cells", &partition(0.1, 0.0), &counts(1100, 0), 0.5);
    let expected = Sensitivity::Cells { dof, n, least, tests: 2 };
    let (halved, expected) = (halved.sensitivity, expected);
    assert_relative_eq!(halved.miss(0.1), expected.miss(0.1), max_relative = 1e-6);
    // Nothing where nothing is expected is right; a single cell has no shape to be wrong.
    let places = vec![String::from("all"), String::from("none")];
    let single = Partition::of_masses(vec![1.0, 0.0], places);
    let all = Counts { n: 5000, observed: vec![5000, 0], ..Counts::default() };
    let found = chi_square("single", &single, &all, 0.5);
    let undecided = matches!(found.verdict(), Verdict::Undecided { .. });
    assert_eq!((found.p, undecided), (1.0, true));
    assert!(found.cells.iter().all(|cell| cell.sigmas == 0.0));
    // Whatever the rounding of what the cell expects.
    for parts in 2..200 {
        let mass = 1.0 / f64::from(parts);
        let cell = Partition::of_masses(vec![mass], vec![String::from("all")]);
        let all = Counts { n: 5001, observed: vec![5001], ..Counts::default() };
        assert_eq!(chi_square("single", &cell, &all, 0.5).p, 1.0, "{parts}");
    }
}

#[test]
fn lost_samples_are_tested_beside_the_cells() {
    let p = |partition: &Partition, lost| chi_square("p", partition, &counts(lost, 0), 0.5).p;
    // Half of the level each where both are left to chance; the loss is known within its error.
    for (loss, error, lost) in [
        (0.1_f64, 0.0_f64, 1300_u64),
        (0.1, 0.0, 1120),
        (0.1, 0.0, 950),
        (0.1, 0.01, 1400),
        (0.1, 0.01, 850),
        (0.0, 1e-6, 0),
        (0.0, 0.01, 140),
    ] {
        let n = 10_000 + lost;
        let least = (loss - error).max(0.0);
        let [above, below] = [binomial_sf(lost, n, loss + error), binomial_cdf(lost, n, least)];
        let lost_p = (2.0 * above.min(below)).min(1.0);
        let expected = (2.0 * cells_p().min(lost_p)).min(1.0);
        let found = p(&partition(loss, error), lost);
        assert_relative_eq!(found, expected, max_relative = 1e-9);
    }
    // Where nothing may be lost, losing nothing costs nothing.
    assert_relative_eq!(p(&partition(0.0, 0.0), 0), cells_p(), max_relative = 1e-12);
}

#[test]
fn the_worst_is_named() {
    let worst =
        |partition: &Partition, counts: &Counts| chi_square("worst", partition, counts, 0.5).worst;
    assert_eq!(worst(&partition(0.0, 0.0), &counts(5, 0)), "5 samples lost, 0.0 expected");
    assert_eq!(worst(&partition(0.1, 0.0), &counts(0, 0)), "0 samples lost, 1000.0 expected");
    let forbidden = chi_square("forbidden", &partition(0.0, 0.0), &counts(0, 7), 0.5);
    assert_eq!(forbidden.p, 0.0);
    assert_eq!(
        worst(&partition(0.0, 0.0), &counts(0, 7)),
        "7 of 10007 samples where the pdf is zero, the first at [1, 0, 0]"
    );
}

#[test]
fn thin_cells_are_pooled_smallest_first() {
    // 900 + 900 outgrows the third, which then is the smallest and joins them.
    let expected = [900.0, 3000.0, 900.0, 900.0];
    assert_eq!(pool(&expected, &[1, 2, 4, 8]), [[3000.0, 2.0], [2700.0, 13.0]]);
    // Just enough is enough, and a last cell stays, however thin.
    assert_eq!(pool(&[1000.0, 1000.0], &[1, 2]).len(), 2);
    assert_eq!(pool(&[5.0], &[3]), [[5.0, 3.0]]);
    assert_eq!(pool(&[], &[]), [[0.0; 2]; 0]);
}

#[test]
fn a_share_has_its_exact_interval() {
    let found = binomial("share", 3, 10, 0.2, 0.5);
    assert_eq!((found.name.as_str(), found.n, found.value), ("share", 10, 3.0));
    assert_eq!((found.estimate, found.reference), (0.3, 0.2));
    assert_eq!(found.p, binomial_two_sided(3, 10, 0.2));
    assert_eq!(found.interval, binomial_interval(3, 10, ALPHA / 2.0));
    assert_eq!(found.claim, Claim::Exact { delta: 0.5 });
    // (3 − 2)/√(10 · 0.2 · 0.8).
    assert_eq!(found.worst, "3 of 10, 2.0 expected, +0.8 sigmas");
}

#[test]
fn rare_events_follow_the_poisson_law() {
    let found = poisson("rare", 30, 1000, 20.0, 5.0);
    assert_eq!((found.name.as_str(), found.n, found.value), ("rare", 1000, 30.0));
    assert_eq!((found.estimate, found.reference), (30.0, 20.0));
    assert_eq!(found.p, 2.0 * poisson_sf(30, 20.0));
    assert_eq!(found.interval, poisson_interval(30, ALPHA / 2.0));
    assert_eq!(found.claim, Claim::Exact { delta: 5.0 });
    assert_eq!(found.sensitivity, Sensitivity::Poisson { mean: 20.0 });
    assert_eq!(found.worst, "30 among 1000 values, 2.0e1 expected");
    let [cell] = &found.cells[..] else {
        panic!("{:?}", found.cells);
    };
    assert_eq!((cell.expected, cell.observed), (20.0, 30.0));
    assert_relative_eq!(cell.sigmas, 5_f64.sqrt(), max_relative = 1e-12);
    let few = poisson("few", 11, 1000, 20.0, 5.0);
    assert_eq!(few.p, 2.0 * poisson_cdf(11, 20.0));
    assert_eq!(poisson("even", 20, 1000, 20.0, 5.0).p, 1.0);
}

#[test]
fn a_sampler_is_compared_with_its_cells() {
    let cells = Partition::equal(Domain::Square, 2, 2);
    let i = Cell::new(0);
    let found = sampler_against_partition("corners", &cells, 800_000, || {
        i.set(i.get() + 1);
        let [x, y] = [i.get() & 1, i.get() >> 1 & 1].map(|bit| 0.25 + 0.5 * f64::from(bit));
        Some(DVec3::new(x, y, 0.0))
    });
    assert_eq!((found.n, found.p, i.get()), (800_000, 1.0, 800_000));
    assert_eq!(found.claim, Claim::Exact { delta: 0.02 });
    assert_eq!(found.verdict(), Verdict::Holds);
}

#[test]
fn distribution_functions_are_compared_at_every_value() {
    // Midpoints of 256 equal intervals, exact in binary: D = 1/512 everywhere, first at the first.
    let midpoint = |i: u32| (f64::from(i) + 0.5) / 256.0;
    let mut values: Vec<f64> = (0..256).rev().map(midpoint).collect();
    let found = kolmogorov_smirnov("grid", &mut values, |x| x, 0.5);
    assert_eq!((found.n, found.estimate), (256, 1.0 / 512.0));
    assert_relative_eq!(found.value, 16.0 / 512.0, max_relative = 1e-12);
    assert_eq!(found.p, kolmogorov_sf(256, 1.0 / 512.0));
    let radius = kolmogorov_upper(256, ALPHA);
    assert_eq!(found.interval, [0.0, 1.0 / 512.0 + radius]);
    assert_eq!(found.worst, "distribution functions differ by 0.00195 at 0.001953");
    // Every fourth of 256 points is kept, each with its own binomial spread.
    assert_eq!(found.cells.len(), 64);
    let mut values: Vec<f64> = (0..256).map(midpoint).collect();
    let squares = kolmogorov_smirnov("squares", &mut values, |x| x * x, 0.5);
    let x = midpoint(40);
    let cell = &squares.cells[10];
    assert_eq!((cell.expected, cell.observed), (x * x, x));
    let spread = (x * x * (1.0 - x * x) / 256.0).sqrt();
    assert_relative_eq!(cell.sigmas, (x - x * x) / spread, max_relative = 1e-12);
    // x − x² is largest at 1/2, where the last value has just been passed or is not yet met.
    assert_relative_eq!(squares.estimate, 0.25 + 1.0 / 512.0, max_relative = 1e-2);
    assert_eq!(squares.interval[0], (squares.estimate - radius).max(0.0));
    assert!(squares.estimate > radius);
    // And √x − x at 1/4, with the sides exchanged.
    let roots = kolmogorov_smirnov("roots", &mut values, f64::sqrt, 0.5);
    assert_relative_eq!(roots.estimate, 0.25 + 1.0 / 512.0, max_relative = 1e-2);
    let mut ten = [0.5; 10];
    assert_eq!(kolmogorov_smirnov("ten", &mut ten, |x| x, 0.5).cells.len(), 10);
}

#[test]
fn maps_leave_out_what_says_nothing() {
    let found = PValueMap {
        width: 3,
        height: 2,
        p: [0.5, -1.0, 0.2, 1.0, 0.001, 0.7].map(|p| (p >= 0.0).then_some(p)).to_vec(),
        sigmas: vec![0.7, f64::NAN, 1.3, 0.0, -3.3, 0.4],
        dof: vec![9.0, 8.0, 7.0, 6.0, 5.0, 4.0],
    };
    assert_eq!(found.histogram(4), [2, 0, 2, 1]);
    let mut known = vec![0.5, 0.2, 1.0, 0.001, 0.7];
    let flat = found.flatness("flat", 0.1);
    let expected = Outcome {
        claim: Claim::Approximate { margin: 0.1 },
        graded: Vec::new(),
        ..kolmogorov_smirnov("flat", &mut known, |p| p, 0.1)
    };
    assert_eq!(flat, expected);
    let smallest = found.smallest("smallest", 17);
    assert_eq!((smallest.name.as_str(), smallest.n), ("smallest", 17));
    assert_relative_eq!(smallest.p, 0.005, max_relative = 1e-12);
    assert_eq!((smallest.value, smallest.estimate), (-3.3, -3.3));
    assert_eq!(smallest.claim, Claim::Test);
    // The level is shared by the five tiles that say something.
    let sensitivity = Sensitivity::Normal { standard_error: 1.0, dof: 5.0, tests: 5 };
    assert_eq!(smallest.sensitivity, sensitivity);
    assert_eq!(smallest.worst, "(1, 1) of 3 × 2: -3.30 sigmas");
    assert_eq!(smallest.cells.len(), 6);
    let cell = &smallest.cells[5];
    assert_eq!((cell.place.as_str(), cell.observed, cell.sigmas), ("x 2 y 1", 0.4, 0.4));
    // What is no number is neither left out nor large: it fails, and is the worst.
    let mut broken = found;
    broken.p[3] = Some(f64::NAN);
    let smallest = broken.smallest("smallest", 17);
    assert!(smallest.p.is_nan() && smallest.verdict() == Verdict::Fails);
    assert!(smallest.worst.starts_with("(0, 1)"), "{}", smallest.worst);
    assert_eq!(broken.flatness("flat", 0.1).verdict(), Verdict::Fails);
    assert_eq!(broken.histogram(4), [3, 0, 2, 0]);
}

/// A mean or a variance that is no number is none that says nothing.
#[test]
fn a_pixel_that_is_no_number_fails() {
    let [means, variances] = [[1.0, 1.0, 2.0], [0.1, 0.0, 0.2]];
    for (mean, variance) in [(f64::NAN, 0.0), (1.0, f64::NAN), (f64::NAN, f64::NAN)] {
        let (mut mean_a, mut variance_a) = (means, variances);
        (mean_a[1], variance_a[1]) = (mean, variance);
        let [a, b] = [(&mean_a, &variance_a), (&means, &variances)]
            .map(|(mean, variance)| PixelStatistics { mean, variance, count: &[9; 3] });
        let found = map(&a, &b, 3, 1);
        assert_eq!(found.smallest("pixels", 9).verdict(), Verdict::Fails);
        assert_eq!(map(&b, &b, 3, 1).p[1], None);
    }
}

/// An image of 7 × 5 pixels in which no two are alike, and another.
fn image(shift: usize) -> [Vec<f64>; 2] {
    let pixel = |i: usize| ((i + shift) * 37 % 53) as f64;
    [
        (0..35).map(|i| 1.0 + 0.01 * pixel(i)).collect(),
        (0..35).map(|i| 0.04 + 0.001 * pixel(i * i)).collect(),
    ]
}

#[test]
fn tiles_hold_their_own_pixels() {
    let [[mean_a, variance_a], [mean_b, variance_b]] = [image(3), image(11)];
    let count_a: Vec<u64> = (0..35).map(|i| 50 + i).collect();
    let count_b: Vec<u64> = (0..35).map(|i| 90 - i).collect();
    let a = PixelStatistics { mean: &mean_a, variance: &variance_a, count: &count_a };
    let b = PixelStatistics { mean: &mean_b, variance: &variance_b, count: &count_b };
    // Sums instead of means: t and the degrees of freedom are the same.
    let expected = |inside: &dyn Fn(usize, usize) -> bool| {
        let pixels: Vec<usize> = (0..35).filter(|i| inside(i % 7, i / 7)).collect();
        let sum = |mean: &[f64]| pixels.iter().map(|&i| mean[i]).sum::<f64>();
        let difference = sum(&mean_a) - sum(&mean_b);
        let of =
            |variance: &[f64], count: &[u64], i: usize| (variance[i] / count[i] as f64, count[i]);
        let parts: Vec<(f64, u64)> = pixels
            .iter()
            .flat_map(|&i| [of(&variance_a, &count_a, i), of(&variance_b, &count_b, i)])
            .collect();
        let error = parts.iter().map(|part| part.0).sum::<f64>().sqrt();
        (difference / error, welch_satterthwaite(parts), error / pixels.len() as f64)
    };
    for side in [1, 2, 3, 4, 7] {
        let found = map(&a, &b, 7, side);
        assert_eq!((found.width, found.height), (7_usize.div_ceil(side), 5_usize.div_ceil(side)));
        assert_eq!(found.p.len(), found.width * found.height);
        for (i, (&p, &sigmas)) in found.p.iter().zip(&found.sigmas).enumerate() {
            let tile = [i % found.width, i / found.width];
            let (t, dof, _) = expected(&|x, y| [x / side, y / side] == tile);
            assert_relative_eq!(sigmas, t, max_relative = 1e-9);
            assert_relative_eq!(p.expect("judged"), student_two_sided(t, dof), max_relative = 1e-9);
        }
    }
    let even = vec![0.0; a.mean.len()];
    let whole = image_mean("whole", (&a, &even), (&b, &even), 0.01);
    let (t, dof, error) = expected(&|_, _| true);
    assert_eq!((whole.name.as_str(), whole.n), ("whole", 50));
    assert_relative_eq!(whole.value, t, max_relative = 1e-9);
    assert_relative_eq!(whole.p, student_two_sided(t, dof), max_relative = 1e-9);
    assert_relative_eq!(whole.estimate, t * error, max_relative = 1e-9);
    let half = student_upper(ALPHA / 2.0, dof) * error;
    assert_relative_eq!(whole.interval[0], t * error - half, max_relative = 1e-9);
    assert_relative_eq!(whole.interval[1], t * error + half, max_relative = 1e-9);
    let scale = mean_b.iter().sum::<f64>() / 35.0;
    assert_relative_eq!(whole.claim.size(), 0.01 * scale, max_relative = 1e-12);
    // Equal without variance: nothing is known.
    let none = vec![0.0; 35];
    let still = PixelStatistics { variance: &none, ..a };
    let same = image_mean("same", (&still, &even), (&still, &even), 0.01);
    let needed = u64::MAX;
    assert_eq!((same.value, same.p, same.verdict()), (0.0, 1.0, Verdict::Undecided { needed }));
    assert!(map(&still, &still, 7, 1).p.iter().all(Option::is_none));
}

#[test]
fn an_image_is_kept_in_stretches_of_its_rows() {
    // 149 pixels in at most 64 stretches: 49 of three pixels, and one of two.
    let mean_a: Vec<f64> = (0..149).map(|i| f64::from(i * i % 31)).collect();
    let mean_b: Vec<f64> = (0..149).map(|i| f64::from(i * 5 % 17)).collect();
    let [variance_a, variance_b] = [0.04, 0.21].map(|variance| vec![variance; 149]);
    let [count_a, count_b] = [[100; 149], [300; 149]];
    let a = PixelStatistics { mean: &mean_a, variance: &variance_a, count: &count_a };
    let b = PixelStatistics { mean: &mean_b, variance: &variance_b, count: &count_b };
    let even = vec![0.0; a.mean.len()];
    let cells = image_mean("stretches", (&a, &even), (&b, &even), 0.01).cells;
    assert_eq!(cells.len(), 50);
    for (i, cell) in cells.iter().enumerate() {
        let n = if i < 49 { 3 } else { 2 };
        assert_eq!(cell.place, format!("{n} pixels from {} on, row by row", 3 * i));
        let sum = |mean: &[f64]| mean[3 * i..3 * i + n].iter().sum::<f64>();
        let [sum_a, sum_b] = [sum(&mean_a), sum(&mean_b)];
        assert_relative_eq!(cell.expected, sum_b / n as f64, max_relative = 1e-12);
        assert_relative_eq!(cell.observed, sum_a / n as f64, max_relative = 1e-12);
        // Sums of n pixels with variances 0.0004 and 0.0007.
        let sigmas = (sum_a - sum_b) / (n as f64 * 0.0011).sqrt();
        assert_relative_eq!(cell.sigmas, sigmas, max_relative = 1e-9, epsilon = 1e-12);
    }
}
