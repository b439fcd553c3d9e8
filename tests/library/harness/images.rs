//! Sets of images against each other: by hand where they are few and small, and how often chance and a bias are seen.

use rayon::prelude::*;
use whitefurnace::harness::images::{Comparison, MISS, Rules, Side, compare};

use whitefurnace::rng::Stream;

use super::*;

fn side(images: &[[f64; 4]]) -> Side<'_> {
    Side::Images(images.iter().map(|image| &image[..]).collect())
}

/// Noise that is too skewed to judge a difference of ten standard errors does not hide one of thousands.
#[test]
fn a_far_difference_stands_whatever_the_noise() {
    let rare = |brighter: f64| -> Vec<[f64; 4]> {
        let noise = [[0.0, 0.1, 0.0, 0.1], [0.1, 0.0, 0.1, 0.0], [8.0, 0.1, 0.1, 0.0]];
        noise.map(|image| image.map(|value| 1.0 + value + brighter)).to_vec()
    };
    let calm = [[1.0; 4], [1.01; 4], [1.02; 4]];
    for (brighter, far) in [(7.0, false), (200.0, true)] {
        let found = compare(2, &[[side(&rare(brighter)), side(&calm)]], &Rules { tile: 2, ..Rules::default() });
        let [means, ..] = &found.kinds;
        let place = &means.places[0];
        assert!(place.skewness[0] > 0.5 && place.sigmas > 10.0, "{place:?}");
        assert_eq!((place.judged, found.verdict == Verdict::Fails), (far, far), "{place:?}");
    }
}

/// Four pixels, of which the last is the same in all; three images against four.
#[test]
fn places_are_judged_by_welch() {
    let a = [[1.0, 2.0, 6.0, 7.0], [2.0, 2.5, 5.0, 7.0], [1.5, 4.5, 7.0, 7.0]];
    let b = [[1.0, 3.0, 5.5, 7.0], [2.0, 1.0, 5.0, 7.0], [1.5, 2.0, 7.5, 7.0], [2.5, 2.0, 4.0, 7.0]];
    let rules = Rules { tile: 2, rounding: 0.0, regions: vec![[0, 0, 2, 1]], ..Rules::default() };
    let found = compare(2, &[[side(&a), side(&b)]], &rules);
    let welch = |pixels: &[usize]| {
        let means = |images: &[[f64; 4]]| -> Vec<f64> {
            images.iter().map(|image| pixels.iter().map(|&i| image[i]).sum::<f64>() / pixels.len() as f64).collect()
        };
        let [a, b] = [means(&a), means(&b)].map(|means| values(0.0, &means));
        let test = welch("", &a, &b, Claim::Test);
        (test.value, test.p, (a.moments.mean() - b.moments.mean()) / b.moments.mean())
    };
    let [means, regions, tiles, pixels] = &found.kinds;
    assert_eq!(found.kinds.each_ref().map(|kind| kind.places.len()), [1, 5, 1, 4]);
    for (kind, k, of) in
        [(means, 0, &[0, 1, 2, 3][..]), (regions, 4, &[0, 1]), (tiles, 0, &[0, 1, 2, 3]), (pixels, 1, &[1])]
    {
        let place = &kind.places[k];
        let (t, p, relative) = welch(of);
        assert_relative_eq!([place.sigmas, place.p, place.difference()][..], [t, p, relative][..], max_relative = 1e-9);
        let half = student_upper(kind.level / 2.0, place.dof) * place.standard_error / place.means[1];
        let interval = [relative - half, relative + half];
        assert_relative_eq!(place.interval(kind.level)[..], interval[..], max_relative = 1e-9);
    }
    assert!(!pixels.places[3].varies() && !pixels.places[3].judged && pixels.places[3].p == 1.0);
    assert_relative_eq!(regions.level, 1e-3 / 4.0 / 5.0);
    // A pixel is as skewed as its tile's are on the average. By hand: variances 3/4 and 13/16, third cumulants 27/32
    // and 3/4, of three and four images.
    let (third, second) = ([27.0 / 32.0 / 9.0, 0.75 / 16.0], 0.25 + 0.203_125_f64);
    let skewness = [third[0] - third[1], third[0] + third[1]].map(|third| third / second.powf(1.5));
    assert_relative_eq!(pixels.places[0].skewness[..], skewness[..], max_relative = 1e-9);
    // Two images say nothing of skewness; an exact side and standard errors do.
    let two = compare(2, &[[side(&a[..2]), side(&b)]], &rules);
    assert!(two.kinds[0].places[0].skewness[0].is_nan() && !two.kinds[0].counts);
    let [cancelled, alike] = means.places[0].skewness;
    assert!(cancelled < alike, "the noise of one side takes that of the other away");
    let errors = [0.1, 0.2, 0.2, 0.0];
    let one = compare(2, &[[Side::Errors(&a[0], &errors), Side::Exact(&b[0])]], &rules);
    let place = &one.kinds[0].places[0];
    assert_relative_eq!(place.standard_error, 0.3 / 4.0, max_relative = 1e-12);
    assert_relative_eq!(place.skewness[..], [0.017 / 0.027; 2][..], max_relative = 1e-12);
    assert_relative_eq!(place.dof, 0.0081 / 0.0033, max_relative = 1e-12);
}

/// The verdict on two images each of 100 pixels across.
fn verdict_of(a: [&[f64]; 2], b: [&[f64]; 2], channels: usize) -> Verdict {
    let sides = [Side::Images(a.to_vec()), Side::Images(b.to_vec())];
    compare(100, &vec![sides; channels], &Rules::default()).verdict
}

/// Without noise, values are compared as they stand; by the side of noise two constants differ only if there are enough
/// of them.
#[test]
fn values_without_noise_are_compared_as_they_stand() {
    // 0.1 is the mean of no number of its likes when these are added up and divided.
    let plain = |pixels: usize| (0..pixels).map(|i| [0.1, 0.7, 3.0][i % 3]).collect::<Vec<f64>>();
    let changed = |at: usize, factor: f64| {
        let mut image = plain(5_000);
        image[at] *= factor;
        image
    };
    let (image, dark) = (plain(5_000), vec![0.0; 5_000]);
    for (other, expected) in [
        (&image, Verdict::Holds),
        (&changed(7, 1.0 + 1e-6), Verdict::Holds),
        (&changed(7, 1.0 + 1e-4), Verdict::Fails),
        (&dark, Verdict::Fails),
    ] {
        assert_eq!(verdict_of([&image; 2], [other; 2], 1), expected);
        let three = [[Side::Images(vec![&image; 3]), Side::Exact(other)]];
        assert_eq!(compare(100, &three, &Rules::default()).verdict, expected);
        let errors = [[Side::Errors(&image, &dark), Side::Errors(other, &dark)]];
        assert_eq!(compare(100, &errors, &Rules::default()).verdict, expected);
    }
    assert_eq!(verdict_of([&dark; 2], [&dark; 2], 3), Verdict::Holds);
    // Too few to take them for no noise.
    let few = [0.1; 31];
    let side = Side::Images(vec![&few; 2]);
    let unknown = Verdict::Undecided { needed: u64::MAX };
    assert_eq!(compare(31, &[[side, Side::Exact(&[0.2; 31])]], &Rules::default()).verdict, unknown);
}

/// Beside pixels that vary, constants differ if there are enough of them, else nothing is said.
#[test]
fn constants_beside_noise_need_many_values() {
    let rejected = |pixels: usize| {
        let images = |constant: f64, first: f64| {
            [1.0, 1.3].map(|factor| {
                let mut image = vec![constant; pixels];
                image[0] = first * factor;
                image
            })
        };
        let (a, b) = (images(0.98, 1.0), images(1.0, 1.1));
        let sides = [&a, &b].map(|images| Side::Images(images.iter().map(Vec::as_slice).collect()));
        let rules = Rules { tile: 100, regions: vec![[0, 1, 100, pixels / 100]], ..Rules::default() };
        let found = compare(100, &[sides], &rules);
        assert!(found.kinds[0].places[0].standard_error > 0.0 && !found.kinds[0].places[0].noiseless);
        found.kinds[1].places.last().is_some_and(|place| place.p == 0.0)
    };
    assert_eq!([rejected(5_100), rejected(5_000)], [true, false]);
}

/// What chance can turn: false alarms, whether all is judged, what is stated, and what is seen.
pub const ASSERTIONS: usize = 4;

/// Images of 48 × 48 pixels, each the mean of four exponential values times `factor`.
fn exponential(rng: &mut Stream, factor: f64) -> Vec<Vec<f64>> {
    let mut value = || -0.25 * factor * (0..4).map(|_| (1.0 - uniform(rng)).ln()).sum::<f64>();
    (0..8).map(|_| (0..48 * 48).map(|_| value()).collect()).collect()
}

/// Means of four exponential values have a skewness of 1; pixels are too few values to judge, all else is judged.
/// False alarms are no more than the level says, and a bias that would be seen is.
#[test]
fn false_alarms_are_rare_and_biases_seen() {
    const RUNS: u32 = 400;
    let rules = Rules { level: 0.05, margin: 0.1, ..Rules::default() };
    let found = |name: &str, factor: f64| -> Vec<Comparison> {
        let seed = context("harness::images").seed_of(name);
        let run = |i: u32| {
            let mut rng = stream(seed, i, 0);
            let images = [exponential(&mut rng, factor), exponential(&mut rng, 1.0)];
            let [a, b] = images.each_ref().map(|side| Side::Images(side.iter().map(Vec::as_slice).collect()));
            compare(48, &[[a, b]], &rules)
        };
        (0..RUNS).into_par_iter().map(run).collect()
    };
    let right = found("right", 1.0);
    let alarms = right.iter().filter(|found| found.verdict == Verdict::Fails).count() as u64;
    assert!(binomial_sf(alarms, RUNS.into(), rules.level) >= ALPHA, "{alarms} false alarms of {RUNS}");
    assert!(right.iter().all(|found| found.kinds.each_ref().map(|kind| kind.counts) == [true, true, true, false]));
    // The variance of a pixel is 1/4; the factor that is seen but for a chance of 10 % moves it little.
    let level = right[0].kinds[0].level;
    let standard_error = (2.0 * 0.25 / (8.0 * 48.0 * 48.0_f64)).sqrt();
    let bias = Sensitivity::Normal { standard_error, dof: 14.0, tests: 1 }.smallest_effect_at(MISS, level);
    let stated = right.iter().map(|found| found.kinds[0].places[0].seen(level)).sum::<f64>() / f64::from(RUNS);
    assert_relative_eq!(stated, bias, max_relative = 0.1);
    let wrong = found("wrong", 1.0 + bias);
    let seen = wrong.iter().filter(|found| found.kinds[0].rejected().next().is_some()).count() as u64;
    assert!(binomial_cdf(seen, RUNS.into(), 1.0 - MISS) >= ALPHA, "{seen} of {RUNS} seen");
}
