//! Tests of adaptive sampling: sample counts from a pilot, and films with them.

use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use approx::relative_eq;
use whitefurnace::render::adaptive::{Pilot, counts};
use whitefurnace::render::{CHUNK_SAMPLES, PreparedRenderer};
use whitefurnace::sampling::sampler::MAX_POINTS;

use crate::prelude::*;

/// Returns a film whose pixels have these standard errors, row by row, in all channels.
fn noisy(width: u32, noise: &[f64]) -> Film {
    let mut film = Film::new([width, noise.len() as u32 / width], None, 1).expect("a film");
    for (pixel, noise) in film.pixels_mut().iter_mut().zip(noise) {
        // Two values differ by twice the standard error of their mean.
        for value in [0.0, 2.0 * noise] {
            pixel.push(DVec3::splat(value), 1).expect("legal");
        }
    }
    film
}

/// Returns the pixels of each sublattice of an image, which lie an even number of columns and rows
/// apart.
fn sublattices(width: usize, pixels: usize) -> impl Iterator<Item = Vec<usize>> {
    [[0, 0], [1, 0], [0, 1], [1, 1]]
        .into_iter()
        .map(move |[x, y]| {
            let is_own = |at: &usize| at % width % 2 == x && at / width % 2 == y;
            (0..pixels).filter(is_own).collect()
        })
}

fn average(of: &[f64]) -> f64 {
    of.iter().sum::<f64>() / of.len() as f64
}

/// Returns the expected number of samples of some pixels, by the definition: the noise of all others
/// is averaged over a square of 7 x 7 pixels, and this once more over all pixels.
fn expected(width: usize, noise: &[f64], own: &[usize], [least, mean]: [u32; 2]) -> Vec<f64> {
    let height = noise.len() / width;
    let averaged = |noise: &[f64], counts: &dyn Fn(usize) -> bool| -> Vec<f64> {
        let square = |at: usize| {
            let near = |i: usize, n: usize| (0..n).filter(move |j| i.abs_diff(*j) <= 3);
            let of = near(at / width, height)
                .flat_map(|y| near(at % width, width).map(move |x| y * width + x));
            let all: Vec<f64> = of.filter(|&at| counts(at)).map(|at| noise[at]).collect();
            if all.is_empty() { 0.0 } else { average(&all) }
        };
        (0..noise.len()).map(square).collect()
    };
    let once = averaged(noise, &|at| !own.contains(&at));
    let twice = averaged(&once, &|_| true);
    let weights: Vec<f64> = own.iter().map(|&at| twice[at].powf(0.75)).collect();
    let all = average(&weights);
    let cut = |weight: &f64| {
        if all == 0.0 {
            1.0
        } else {
            (weight / all).min(8.0)
        }
    };
    let cut: Vec<f64> = weights.iter().map(cut).collect();
    // The samples beyond the clamp are divided evenly.
    let even = 1.0 - average(&cut);
    let [least, extra] = [f64::from(least), f64::from(mean - least)];
    cut.iter()
        .map(|weight| least + extra * (even + weight))
        .collect()
}

/// Asserts that counts are as expected, and have three binary digits: what they lack is carried to
/// the next pixel, so that no sum over the first pixels lacks more than a pixel is rounded by.
fn assert_counts(width: usize, noise: &[f64], [least, mean]: [u32; 2]) {
    let found = counts(&noisy(width as u32, noise), least, mean);
    assert_eq!(found.len(), noise.len());
    for count in &found {
        let digits = u32::BITS - count.leading_zeros() - count.trailing_zeros();
        assert!(
            *count == least || *count > least && digits <= 3,
            "{found:?}"
        );
    }
    for own in sublattices(width, noise.len()).filter(|own| !own.is_empty()) {
        let (mut lacking, mut largest) = (0.5, 0.0_f64);
        for (&at, expected) in own.iter().zip(expected(width, noise, &own, [least, mean])) {
            lacking += expected - f64::from(found[at]);
            largest = largest.max(expected);
            let range = -1e-3..1.0 + 1e-3 + largest / 3.0;
            assert!(
                range.contains(&lacking),
                "{lacking} of {largest}: {found:?}"
            );
        }
    }
}

#[test]
fn counts_follow_noise() {
    let noise = prop_oneof![Just(0.0), 0.0..1.0, 0.0..1e4];
    let strategy = (
        1_usize..20,
        prop::collection::vec(noise, 1..200),
        1_u32..200,
        1_u32..200,
    );
    property("counts", 300, &strategy, |(width, noise, a, b)| {
        let whole = noise.len() / width * width;
        if whole > 0 {
            assert_counts(width, &noise[..whole], [a.min(b), a.max(b)]);
        }
    });
    // No pixel gets more than about eight times the mean.
    let mut one = vec![0.0; 60 * 60];
    one[30 * 60 + 30] = 1e-7;
    assert_counts(60, &one, [1, 100]);
    let most = |mean| {
        counts(&noisy(60, &one), 1, mean)
            .into_iter()
            .max()
            .expect("pixels")
    };
    assert!((700..900).contains(&most(100)), "{}", most(100));
    // Nor more points than a scramble has.
    assert!(
        (50_000..=MAX_POINTS).contains(&most(20_000)),
        "{}",
        most(20_000)
    );
    assert_eq!(
        counts(&noisy(60, &one), 1, MAX_POINTS),
        [MAX_POINTS; 60 * 60]
    );
    // Where no noise or the same noise is measured everywhere, all pixels get the mean.
    for alike in [0.0, 0.25] {
        assert_eq!(counts(&noisy(9, &[alike; 81]), 2, 16), [16; 81]);
    }
    assert_eq!(counts(&noisy(3, &[0.0, 1.0, 5.0]), 1, 1), [1; 3]);
    assert_eq!(counts(&noisy(1, &[1.0]), 1, 16), [16]);
}

/// Otherwise the mean of a pixel would depend on how bright its pilot happens to be.
#[test]
fn a_pixel_has_no_say_in_its_own_samples() {
    let mut rng = rng("own pilot");
    let noise: Vec<f64> = (0..13 * 9).map(|_| uniform(&mut rng)).collect();
    let before = counts(&noisy(13, &noise), 1, 40);
    for own in sublattices(13, noise.len()) {
        let mut other = noise.clone();
        own.iter().for_each(|&at| other[at] = uniform(&mut rng));
        let after = counts(&noisy(13, &other), 1, 40);
        assert!(own.iter().all(|&at| after[at] == before[at]));
        assert_ne!(after, before);
    }
}

/// The scene of the tests with pilots, its size, and a renderer of as many samples per replication.
const FRAME: [u32; 2] = [9, 6];

fn renderer(samples: u32) -> LaneRenderer<'static> {
    LaneRenderer {
        estimator: LaneEstimator::Path(Path::new(PathStrategy::Mis)),
        sampling: Sampling {
            silhouettes: true,
            ..sampling(Random, SamplerKind::Sobol(samples), master())
        },
        precision: Precision::Double,
    }
}

/// Begins a film with a pilot of all `replications`, of which it is for the range.
fn begin(renderer: &dyn PreparedRenderer, film: &mut Film, replications: u32, range: &Range<u32>) {
    let pilot = Pilot::take(renderer, film, replications, range, &|_| true);
    let pilot = pilot.expect("rendered").expect("all samples");
    let counts = pilot.counts();
    pilot.begin(film, counts).expect("room for features");
}

#[test]
fn pilots_take_an_eighth_of_the_samples() {
    let scene = simple::cornell().expect("a scene");
    // Samples of a replication, replications; values for a pixel's noise, and samples of each.
    for ([samples, replications], expected) in [
        ([1, 4], [4, 1]),
        ([2, 1], [2, 1]),
        ([15, 4], [4, 1]),
        ([16, 4], [4, 2]),
        ([16, 2], [4, 1]),
        ([32, 3], [6, 2]),
        ([64, 1], [4, 2]),
        ([64, 9], [4, 8]),
        ([300, 4], [4, 8]),
    ] {
        let renderer = renderer(samples);
        let renderer = renderer.prepare(&scene, FRAME).expect("a renderer");
        let film = Film::new(FRAME, None, samples).expect("a film");
        let range = 0..replications;
        let pilot = Pilot::take(&*renderer, &film, replications, &range, &|_| true);
        let pilot = pilot.expect("rendered").expect("all samples");
        for pixel in pilot.noise().pixels() {
            let found = [pixel.replications(), pixel.samples() / pixel.replications()];
            assert_eq!(found, expected, "{samples} x {replications}");
        }
        let counts = pilot.counts();
        let all: u32 = counts.iter().sum();
        let step = samples.div_ceil(2) as f64;
        let mean = f64::from(all) / counts.len() as f64;
        assert!(
            (mean - f64::from(samples)).abs() <= step,
            "{mean} of {samples}"
        );
        assert!(counts.iter().all(|&count| count >= samples / 8));
        // Whoever stops a pilot gets none.
        let stopped = Pilot::take(&*renderer, &film, replications, &range, &|_| false);
        assert_eq!(stopped.expect("no error"), None);
    }
}

/// The pilot may overlook noise.
#[test]
fn no_pixel_takes_less_than_an_eighth() {
    // Left and right of the box there is nothing.
    let (scene, frame) = (simple::cornell().expect("a scene"), [60, 4]);
    let renderer = renderer(300);
    let renderer = renderer.prepare(&scene, frame).expect("a renderer");
    let film = Film::new(frame, None, 300).expect("a film");
    let pilot = Pilot::take(&*renderer, &film, 4, &(0..4), &|_| true);
    let counts = pilot.expect("rendered").expect("all samples").counts();
    assert_eq!(counts.iter().min(), Some(&37));
}

/// An estimator that records the bits of a number beyond those of the sequence.
struct LowBits(Mutex<Vec<u64>>);

impl Estimator for LowBits {
    fn radiance(&self, _: &Scene, _: &Ray, _: Option<Hit>, rng: &mut dyn Sampler) -> DVec3 {
        let bits = rng.next_u64() & (u64::MAX >> 24);
        self.0.lock().expect("no panic").push(bits);
        DVec3::ONE
    }
}

/// Samples of the pilot and all others have streams of their own.
#[test]
fn no_two_samples_share_a_stream() {
    let scene = simple::cornell().expect("a scene");
    let renderer = RayRenderer {
        estimator: LowBits(Mutex::default()),
        sampling: sampling(Random, SamplerKind::Sobol(64), master()),
    };
    let prepared = renderer.prepare(&scene, [1, 1]).expect("a renderer");
    let mut film = Film::new([1, 1], None, 64).expect("a film");
    begin(&*prepared, &mut film, 4, &(0..4));
    assert!(prepared.add(&mut film, 0..4, &|_| true).expect("rendered"));
    let mut bits = renderer.estimator.0.lock().expect("no panic").clone();
    bits.sort_unstable();
    bits.dedup();
    assert_eq!(bits.len(), 256);
}

/// A film that a pilot has begun equals one with the same counts that is rendered from nothing, up to
/// the rounding of sums, and bits of its numbers beyond those of the sequence, by which a path may
/// pass an edge on the other side.
#[test]
fn pilots_are_the_first_samples() {
    let scene = simple::cornell().expect("a scene");
    for (samples, replications) in [(3, 4), (40, 1), (40, 2), (24, 3), (8, 6)] {
        let lanes = renderer(samples);
        let rays = RayRenderer {
            estimator: Path::new(PathStrategy::Mis),
            sampling: lanes.sampling,
        };
        let render = |renderer: &dyn Renderer, pilot: bool, counts: &[u32]| {
            let renderer = renderer.prepare(&scene, FRAME).expect("a renderer");
            let mut film = Film::new(FRAME, None, samples).expect("a film");
            if pilot {
                begin(&*renderer, &mut film, replications, &(0..replications));
            }
            film.set_sample_counts(counts.to_vec());
            let all = renderer.add(&mut film, 0..replications, &|_| true);
            assert!(all.expect("rendered"));
            film
        };
        let counts: Vec<u32> = (0..54).map(|at| 4 + at % 9).collect();
        let begun = render(&lanes, true, &counts);
        assert_eq!(render(&rays, true, &counts).pixels(), begun.pixels());
        let whole = render(&lanes, false, &counts);
        let mut unlike = 0;
        for (a, b) in begun.pixels().iter().zip(whole.pixels()) {
            assert_eq!(
                [a.samples(), a.replications()],
                [b.samples(), b.replications()]
            );
            assert_abs_diff_eq!(a.features().depth, b.features().depth, epsilon = 1e-5);
            assert_abs_diff_eq!(a.features().albedo, b.features().albedo, epsilon = 1e-5);
            let is_like = relative_eq!(a.mean(), b.mean(), max_relative = 1e-4, epsilon = 1e-6);
            unlike += u32::from(!is_like);
        }
        assert!(unlike < 6, "{unlike}");
        // The pilot may have taken all samples of a pixel.
        let ended = render(&lanes, true, &[4; 54]);
        let all = 4 * replications;
        assert!(ended.pixels().iter().all(|pixel| pixel.samples() == all));
    }
}

/// Also a film that is stopped and continued, and the parts of two machines, are the whole film.
#[test]
fn pilots_of_parts_are_those_of_the_whole() {
    let scene = simple::cornell().expect("a scene");
    for replications in [2, 6] {
        let renderer = renderer(24);
        let renderer = renderer.prepare(&scene, FRAME).expect("a renderer");
        let film = || Film::new(FRAME, None, 24).expect("a film");
        let render = |film: &mut Film, range: Range<u32>, stop_after: u64| {
            begin(&*renderer, film, replications, &range);
            let done = AtomicU64::new(0);
            let go_on = |samples| done.fetch_add(samples, Ordering::Relaxed) < stop_after;
            renderer.add(film, range, &go_on).expect("rendered")
        };
        let mut whole = film();
        assert!(render(&mut whole, 0..replications, u64::MAX));
        let mut resumed = film();
        assert!(!render(&mut resumed, 0..replications, 500));
        assert!(render(&mut resumed, 0..replications, u64::MAX));
        assert_eq!(resumed.pixels(), whole.pixels());
        let [mut first, mut second] = [film(), film()];
        assert!(render(&mut first, 0..1, u64::MAX));
        assert!(render(&mut second, 1..replications, u64::MAX));
        first.merge(&second).expect("parts of one film");
        assert_eq!(first.pixels(), whole.pixels());
    }
}

#[test]
#[should_panic(expected = "fewer samples than the pilot's")]
fn no_pixel_takes_less_than_its_pilot() {
    let scene = simple::cornell().expect("a scene");
    let renderer = renderer(16);
    let renderer = renderer.prepare(&scene, FRAME).expect("a renderer");
    let mut film = Film::new(FRAME, None, 16).expect("a film");
    let pilot = Pilot::take(&*renderer, &film, 4, &(0..4), &|_| true);
    let pilot = pilot.expect("rendered").expect("all samples");
    let _ = pilot.begin(&mut film, vec![1; 54]);
}

/// Each pixel equals that of an image whose pixels all have its number of samples, also where rows
/// are rendered in pieces.
#[test]
fn pixels_have_the_samples_that_they_are_given() {
    let scene = simple::cornell().expect("a scene");
    let path = Path::new(PathStrategy::Mis);
    let sampling = |points| Sampling {
        silhouettes: true,
        ..sampling(Random, SamplerKind::Sobol(points), master())
    };
    let frame = [6, 4];
    for scale in [1, CHUNK_SAMPLES / 8] {
        let given: Vec<u32> = (0..24).map(|i| scale * (1 + i % 5)).collect();
        let all = u64::from(given.iter().sum::<u32>());
        let mut film = Film::new(frame, None, 3 * scale).expect("a film");
        film.set_sample_counts(given.clone());
        assert_eq!(
            (film.sample_counts(), film.missing_samples(2)),
            (Some(&*given), 2 * all)
        );
        let done = AtomicU64::new(0);
        let count = |samples| done.fetch_add(samples, Ordering::Relaxed) < u64::MAX;
        for range in [0..1, 1..2] {
            assert!(
                render(
                    &scene,
                    &path,
                    sampling(3 * scale),
                    &mut film,
                    &range,
                    &count
                )
                .expect("rendered")
            );
        }
        assert_eq!(
            (
                film.missing_samples(2),
                film.missing_samples(3),
                done.into_inner()
            ),
            (0, all, 2 * all)
        );
        for points in (1..=5).map(|i| i * scale) {
            let alike =
                rendered(&scene, &path, frame, sampling(points), &[0..2]).expect("rendered");
            for (i, pixel) in film
                .pixels()
                .iter()
                .enumerate()
                .filter(|(i, _)| given[*i] == points)
            {
                assert_eq!(*pixel, alike.pixels()[i], "pixel {i}");
                assert_eq!((pixel.samples(), pixel.replications()), (2 * points, 2));
            }
        }
        let mut copy = Film::new([1, 1], None, 1).expect("a film");
        copy.assign(&film);
        assert!(copy == film);
    }
}

#[test]
fn numbers_of_samples_that_cannot_be_are_refused() {
    let scene = simple::cornell().expect("a scene");
    let refused =
        |pixel: PixelSampling, numbers, counts: [u32; 2], range: Range<u32>, hint: &str| {
            let sampling = sampling(pixel, numbers, 1);
            let mut film =
                Film::new([2, 1], None, sampling.samples_per_replication()).expect("a film");
            film.set_sample_counts(counts.to_vec());
            let path = Path::new(PathStrategy::Mis);
            assert_option_refused(
                render(&scene, &path, sampling, &mut film, &range, &|_| true),
                hint,
            );
            let lanes = LaneEstimator::Path(path);
            assert_option_refused(
                render_lanes(&scene, lanes, sampling, &mut film, &range, &|_| true),
                hint,
            );
        };
    refused(
        Random,
        SamplerKind::Independent,
        [1, 1],
        0..1,
        "need Sobol' points",
    );
    refused(
        Jitter(2),
        SamplerKind::Sobol(2),
        [8, 8],
        0..1,
        "without sub-pixels",
    );
    refused(Random, SamplerKind::Sobol(2), [0, 4], 0..1, "at least 1");
    refused(
        Random,
        SamplerKind::Sobol(2),
        [4, MAX_POINTS + 1],
        0..1,
        "points",
    );
    refused(
        Random,
        SamplerKind::Sobol(2),
        [4, MAX_POINTS],
        0..1 << 16,
        "replications",
    );
}

#[test]
#[should_panic(expected = "counts of samples for each pixel")]
fn each_pixel_needs_a_number() {
    Film::new([2, 2], None, 1)
        .expect("a film")
        .set_sample_counts(vec![1; 3]);
}

/// Checks that, in an image that is half smooth and half noisy, the variance falls as the sample
/// counts predict.
#[test]
fn noise_gets_the_samples() {
    let samples = 64;
    let mut noise = vec![0.0; 40 * 40];
    noise
        .iter_mut()
        .enumerate()
        .filter(|(at, _)| at % 40 >= 20)
        .for_each(|(_, noise)| *noise = 1.0);
    let given = counts(&noisy(40, &noise), samples / 8, samples);
    let variance = |given: &[u32]| {
        noise
            .iter()
            .zip(given)
            .map(|(s, n)| s * s / f64::from(*n))
            .sum::<f64>()
    };
    let gain = variance(&vec![samples; 1600]) / variance(&given);
    // At most fifteen eighths of the mean go to the noisy half.
    assert!((1.6..1.875).contains(&gain), "{gain}");
}
