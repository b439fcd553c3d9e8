//! Tests of comparisons of sets of images: by hand for a few small ones, and the rates of false
//! alarms and of detected biases.

use rayon::prelude::*;
use whitefurnace::harness::images::{Comparison, MISS_PROBABILITY, Rules, Side, compare};

use whitefurnace::sampling::rng::Stream;

use super::*;

fn side(images: &[[f64; 4]]) -> Side<'_> {
    Side::Images(images.iter().map(|image| &image[..]).collect())
}

/// Four pixels, of which the last is equal in all images; three images against four.
#[test]
fn places_are_judged_by_welch() {
    let a = [
        [1.0, 2.0, 6.0, 7.0],
        [2.0, 2.5, 5.0, 7.0],
        [1.5, 4.5, 7.0, 7.0],
    ];
    let b = [
        [1.0, 3.0, 5.5, 7.0],
        [2.0, 1.0, 5.0, 7.0],
        [1.5, 2.0, 7.5, 7.0],
        [2.5, 2.0, 4.0, 7.0],
    ];
    let rules = Rules {
        tile: 2,
        rounding: 0.0,
        regions: vec![[0, 0, 2, 1]],
        ..Rules::default()
    };
    let found = compare(2, &[[side(&a), side(&b)]], &rules);
    let welch = |pixels: &[usize]| {
        let means = |images: &[[f64; 4]]| -> Vec<f64> {
            images
                .iter()
                .map(|image| pixels.iter().map(|&i| image[i]).sum::<f64>() / pixels.len() as f64)
                .collect()
        };
        let [a, b] = [means(&a), means(&b)].map(|means| values(0.0, &means));
        let test = welch("", &a, &b, Claim::Test);
        // A few pixels do not show how the sides share the variance: the degrees of freedom are
        // those of three images.
        (
            test.value,
            student_two_sided(test.value, 2.0),
            (a.moments.mean() - b.moments.mean()) / b.moments.mean(),
        )
    };
    let [means, regions, tiles, pixels] = &found.kinds;
    assert_eq!(
        found.kinds.each_ref().map(|kind| kind.tests.len()),
        [1, 5, 1, 4]
    );
    for (kind, k, of) in [
        (means, 0, &[0, 1, 2, 3][..]),
        (regions, 4, &[0, 1]),
        (tiles, 0, &[0, 1, 2, 3]),
        (pixels, 1, &[1]),
    ] {
        let place = &kind.tests[k];
        let (t, p, relative) = welch(of);
        assert_relative_eq!(
            [place.sigmas, place.p, place.difference()][..],
            [t, p, relative][..],
            max_relative = 1e-9
        );
        let half =
            student_upper(kind.level / 2.0, place.dof) * place.standard_error / place.means[1];
        let interval = [relative - half, relative + half];
        assert_relative_eq!(
            place.interval(kind.level)[..],
            interval[..],
            max_relative = 1e-9
        );
    }
    assert!(!pixels.tests[3].varies() && !pixels.tests[3].judged && pixels.tests[3].p == 1.0);
    assert_relative_eq!(regions.level, 1e-3 / 4.0 / 5.0);
    // Pixels get the mean skewness of their tile. By hand: variances 3/4 and 13/16, third cumulants
    // 27/32 and 3/4, of three and four images.
    let (third, second) = ([27.0 / 32.0 / 9.0, 0.75 / 16.0], 0.25 + 0.203_125_f64);
    let skewness = [third[0] - third[1], third[0] + third[1]].map(|third| third / second.powf(1.5));
    assert_relative_eq!(
        pixels.tests[0].skewness[..],
        skewness[..],
        max_relative = 1e-9
    );
    // Two images give no skewness; an exact side and standard errors do.
    let two = compare(2, &[[side(&a[..2]), side(&b)]], &rules);
    assert!(two.kinds[0].tests[0].skewness[0].is_nan() && !two.kinds[0].is_counted);
    let [cancelled, alike] = means.tests[0].skewness;
    assert!(
        cancelled < alike,
        "the noise of one side takes that of the other away"
    );
    let errors = [0.1, 0.2, 0.2, 0.0];
    let one = compare(
        2,
        &[[Side::Errors(&a[0], &errors), Side::Exact(&b[0])]],
        &rules,
    );
    let place = &one.kinds[0].tests[0];
    assert_relative_eq!(place.standard_error, 0.3 / 4.0, max_relative = 1e-12);
    assert_relative_eq!(
        place.skewness[..],
        [0.017 / 0.027; 2][..],
        max_relative = 1e-12
    );
    assert_relative_eq!(place.dof, 0.0081 / 0.0033, max_relative = 1e-12);
}

/// Returns the verdict on two images on each side, 100 pixels wide.
fn verdict_of(a: [&[f64]; 2], b: [&[f64]; 2], channels: usize) -> Verdict {
    let sides = [Side::Images(a.to_vec()), Side::Images(b.to_vec())];
    compare(100, &vec![sides; channels], &Rules::default()).verdict
}

/// Values without noise are compared exactly; next to noise two constants differ only if there are
/// enough of them.
#[test]
fn values_without_noise_are_compared_as_they_stand() {
    // The mean of values 0.1, added up and divided, is never exactly 0.1.
    let plain = |pixels: usize| {
        (0..pixels)
            .map(|i| [0.1, 0.7, 3.0][i % 3])
            .collect::<Vec<f64>>()
    };
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
    // Too few values to count as noiseless.
    let few = [0.1; 7];
    let side = Side::Images(vec![&few; 2]);
    let unknown = Verdict::Undecided { needed: u64::MAX };
    assert_eq!(
        compare(7, &[[side, Side::Exact(&[0.2; 7])]], &Rules::default()).verdict,
        unknown
    );
    let [one, other, none] = [[0.1; 16], [0.1001; 16], [0.0; 16]];
    let small = |b| {
        let sides = [Side::Errors(&one, &none), Side::Errors(b, &none)];
        compare(4, &[sides], &Rules::default()).verdict
    };
    assert_eq!(
        [small(&one), small(&other)],
        [Verdict::Holds, Verdict::Fails]
    );
}

/// Next to pixels that vary, constants differ if they are 16 values or more and no side is black or
/// without error, else if they are 10 000; otherwise they are no evidence.
#[test]
fn constants_beside_noise_differ_if_they_are_enough() {
    let rejected = |constants: [f64; 2], pixels: usize, is_exact: bool| {
        let images = |constant: f64, first: f64| {
            [1.0, 1.3].map(|factor| {
                let mut image = vec![constant; pixels];
                image[0] = first * factor;
                image
            })
        };
        let (a, b) = (images(constants[0], 1.0), images(constants[1], 1.1));
        let mut sides =
            [&a, &b].map(|images| Side::Images(images.iter().map(Vec::as_slice).collect()));
        if is_exact {
            sides[1] = Side::Exact(&b[0]);
        }
        let rules = Rules {
            tile: pixels,
            regions: vec![[1, 0, pixels, 1]],
            ..Rules::default()
        };
        let found = compare(pixels, &[sides], &rules);
        assert!(found.kinds[0].tests[0].standard_error > 0.0 && !found.kinds[0].tests[0].noiseless);
        found.kinds[1]
            .tests
            .last()
            .is_some_and(|place| found.kinds[1].rejects(place))
    };
    for (constants, is_exact, least) in [
        ([0.98, 1.0], false, 8),
        ([1.0, 0.98], false, 8),
        ([0.0, 1.0], false, 5_000),
        ([0.98, 0.0], false, 5_000),
        ([0.98, 1.0], true, 5_000),
    ] {
        let found = [least, least + 1].map(|pixels| rejected(constants, pixels, is_exact));
        assert_eq!(found, [false, true], "{constants:?}, exact: {is_exact}");
    }
    assert!(!rejected([0.7; 2], 20_000, false));
}

/// Number of random assertions: false alarms of each distribution and number of images, detected
/// differences, and stated effects.
pub const ASSERTIONS: usize = LAWS.len() * NUMBERS.len() + 2 + 4;

/// Distribution of a pixel's value, from its index and random numbers.
type Law = fn(usize, &mut Stream) -> f64;

fn exponential(rng: &mut Stream) -> f64 {
    -(1.0 - uniform(rng)).ln()
}

/// Means of four exponential values: a skewness of 1.
fn sum_of_four(_: usize, rng: &mut Stream) -> f64 {
    (0..4).map(|_| 0.25 * exponential(rng)).sum()
}

/// Bright values, ten per image.
fn rare(_: usize, rng: &mut Stream) -> f64 {
    let bright = uniform(rng) < 10.0 / (SIDE * SIDE) as f64;
    1.0 + 0.1 * exponential(rng) + if bright { 10.0 } else { 0.0 }
}

/// Close to two values, in every pixel.
fn few(_: usize, rng: &mut Stream) -> f64 {
    0.001 * uniform(rng) + f64::from(u8::from(uniform(rng) < 0.3))
}

/// One pixel with a few values among pixels with little noise.
fn lone(pixel: usize, rng: &mut Stream) -> f64 {
    1.0 + 0.01 * uniform(rng)
        + if pixel == 100 && uniform(rng) < 0.3 {
            20.0
        } else {
            0.0
        }
}

/// Pareto's distribution of index 2.5: its variance is finite, its skewness is not.
fn heavy(_: usize, rng: &mut Stream) -> f64 {
    (1.0 - uniform(rng)).powf(-0.4)
}

const SIDE: usize = 24;
const LAWS: [(&str, Law); 5] = [
    ("sum of four", sum_of_four),
    ("rare", rare),
    ("few", few),
    ("lone", lone),
    ("heavy", heavy),
];
/// Numbers of images on the two sides.
const NUMBERS: [[u32; 2]; 5] = [[2, 2], [3, 3], [4, 4], [3, 12], [8, 8]];

/// Compares sets of images of a distribution, whose values are changed on the first side.
fn found(
    law: Law,
    numbers: [u32; 2],
    change: impl Fn(f64) -> f64,
    rng: &mut Stream,
    rules: &Rules,
) -> Comparison {
    let mut images = |count: u32, change: &dyn Fn(f64) -> f64| -> Vec<Vec<f64>> {
        (0..count)
            .map(|_| {
                (0..SIDE * SIDE)
                    .map(|pixel| change(law(pixel, rng)))
                    .collect()
            })
            .collect()
    };
    let [a, b] = [
        images(numbers[0], &change),
        images(numbers[1], &|value| value),
    ];
    let [a, b] = [&a, &b].map(|side| Side::Images(side.iter().map(Vec::as_slice).collect()));
    compare(SIDE, &[[a, b]], rules)
}

/// Returns the results of this many runs, each with random numbers of its own.
fn repeated<T: Send>(name: &str, runs: u32, run: impl Fn(&mut Stream) -> T + Sync) -> Vec<T> {
    let seed = context("harness::images").seed_of(name);
    (0..runs)
        .into_par_iter()
        .map(|i| run(&mut stream(seed, i, 0)))
        .collect()
}

/// False alarms are no more frequent than the level for few images, few or rare values, or
/// different numbers of images on the sides.
#[test]
fn false_alarms_are_rare() {
    const RUNS: u32 = 60;
    let rules = Rules {
        level: 0.01,
        ..Rules::default()
    };
    for (name, law) in LAWS {
        for numbers in NUMBERS {
            let fails = |rng: &mut Stream| {
                found(law, numbers, |value| value, rng, &rules).verdict == Verdict::Fails
            };
            let alarms = repeated(&format!("{name} {numbers:?}"), RUNS, fails)
                .into_iter()
                .filter(|fails| *fails)
                .count();
            let p = binomial_sf(alarms as u64, RUNS.into(), rules.level);
            assert!(
                p >= ALPHA,
                "{name}, {numbers:?} images: {alarms} false alarms of {RUNS}"
            );
        }
    }
}

/// Twice the brightness is detected, even with rare values; two images on each side are not enough.
#[test]
fn a_large_difference_is_found() {
    const RUNS: u32 = 40;
    for (name, law) in [("sum of four", sum_of_four as Law), ("rare", rare)] {
        let fails = |rng: &mut Stream| {
            found(law, [8, 8], |value| 2.0 * value, rng, &Rules::default()).verdict
                == Verdict::Fails
        };
        let count = repeated(&format!("{name} twice as bright"), RUNS, fails)
            .into_iter()
            .filter(|fails| *fails)
            .count();
        assert!(
            binomial_cdf(count as u64, RUNS.into(), 0.9) >= ALPHA,
            "{name}: {count} of {RUNS}"
        );
    }
    let two = repeated("two", 1, |rng| {
        found(
            sum_of_four,
            [2, 2],
            |value| 2.0 * value,
            rng,
            &Rules::default(),
        )
    });
    assert!(
        matches!(two[0].verdict, Verdict::Undecided { .. }),
        "{:?}",
        two[0].verdict
    );
}

/// An effect that is stated to be detected with probability 90 % is detected that often in other
/// images, although the statement relies on an estimated standard error.
#[test]
fn what_would_be_seen_is_seen() {
    const RUNS: u32 = 200;
    let rules = Rules::default();
    for numbers in [[2, 2], [3, 3], [4, 4], [8, 8]] {
        let seen = |rng: &mut Stream| {
            let [means, ..] = found(sum_of_four, numbers, |value| value, rng, &rules).kinds;
            let stated =
                means.tests[0].minimum_detectable_effect(means.level) * means.tests[0].scale;
            let wrong = found(sum_of_four, numbers, |value| value + stated, rng, &rules).kinds;
            wrong[0].tests[0].p < wrong[0].level
        };
        let count = repeated(&format!("seen {numbers:?}"), RUNS, seen)
            .into_iter()
            .filter(|seen| *seen)
            .count();
        let p = binomial_cdf(count as u64, RUNS.into(), 1.0 - MISS_PROBABILITY);
        assert!(p >= ALPHA, "{numbers:?} images: {count} of {RUNS} seen");
    }
}
