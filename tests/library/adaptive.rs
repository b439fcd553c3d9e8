//! Tests of adaptive sampling: sample counts from a pilot, and films with them.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use whitefurnace::render::CHUNK_SAMPLES;
use whitefurnace::render::adaptive::{counts, pilot};
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

/// Returns the expected number of samples of each pixel, by the definition: noise is averaged twice
/// over a square of 7 × 7 pixels.
fn expected(width: usize, noise: &[f64], mean: u32) -> Vec<f64> {
    let height = noise.len() / width;
    let averaged = |noise: &[f64]| -> Vec<f64> {
        let square = |at: usize| {
            let near = |i: usize, n: usize| (0..n).filter(move |j| i.abs_diff(*j) <= 3);
            let of = near(at / width, height)
                .flat_map(|y| near(at % width, width).map(move |x| noise[y * width + x]));
            let all: Vec<f64> = of.collect();
            all.iter().sum::<f64>() / all.len() as f64
        };
        (0..noise.len()).map(square).collect()
    };
    let of_all = |noise: &[f64]| noise.iter().sum::<f64>() / noise.len() as f64;
    let twice = averaged(&averaged(noise));
    let all = of_all(&twice);
    let cut: Vec<f64> = twice
        .iter()
        .map(|noise| {
            if all == 0.0 {
                1.0
            } else {
                (noise / all).min(8.0)
            }
        })
        .collect();
    // The samples beyond the clamp are divided evenly, as is a fifth of all samples.
    let even = 1.0 - 0.8 * of_all(&cut);
    cut.iter()
        .map(|noise| 1.0 + f64::from(mean - 1) * (even + 0.8 * noise))
        .collect()
}

/// Asserts that counts are as expected, with rounding errors carried to the next pixel: no sum over
/// the first pixels is off by more than one half.
fn assert_counts(width: usize, noise: &[f64], mean: u32) {
    let found = counts(&noisy(width as u32, noise), mean);
    assert_eq!(found.len(), noise.len());
    assert!(found.iter().all(|&count| count >= 1));
    let mut off = 0.0_f64;
    for (count, expected) in found.iter().zip(expected(width, noise, mean)) {
        off += f64::from(*count) - expected;
        assert!(off.abs() < 0.5 + 1e-3, "{off}: {found:?}");
    }
}

#[test]
fn counts_follow_noise() {
    let noise = prop_oneof![Just(0.0), 0.0..1.0, 0.0..1e4];
    let strategy = (
        1_usize..20,
        prop::collection::vec(noise, 1..200),
        1_u32..200,
    );
    property("counts", 300, &strategy, |(width, noise, mean)| {
        let whole = noise.len() / width * width;
        if whole > 0 {
            assert_counts(width, &noise[..whole], mean);
        }
    });
    // No pixel gets more than eight times the mean.
    let mut one = vec![0.0; 60 * 60];
    one[30 * 60 + 30] = 1e-7;
    assert_counts(60, &one, 100);
    let most = |mean| {
        counts(&noisy(60, &one), mean)
            .into_iter()
            .max()
            .expect("pixels")
    };
    assert!((600..800).contains(&most(100)), "{}", most(100));
    // Nor more points than a scramble has.
    assert!(
        (60_000..=MAX_POINTS).contains(&most(20_000)),
        "{}",
        most(20_000)
    );
    assert_eq!(counts(&noisy(60, &one), MAX_POINTS), [MAX_POINTS; 60 * 60]);
    // Where no noise or the same noise is measured everywhere, all pixels get the mean.
    for alike in [0.0, 0.25] {
        assert_eq!(counts(&noisy(9, &[alike; 81]), 16), [16; 81]);
    }
    assert_eq!(counts(&noisy(3, &[0.0, 1.0, 5.0]), 1), [1; 3]);
}

#[test]
fn pilots_are_small_and_have_numbers_of_their_own() {
    let sampling = |numbers| Sampling {
        silhouettes: true,
        ..sampling(Random, numbers, master())
    };
    // The pilot has as many samples per pixel, in one scramble or in several.
    for (points, replications, expected) in [
        (1, 4, 1),
        (16, 4, 1),
        (63, 4, 1),
        (64, 4, 2),
        (256, 1, 2),
        (1, 512, 4),
        (256, 4, 8),
        (MAX_POINTS, u32::MAX, 8),
    ] {
        let own = sampling(SamplerKind::Sobol(points));
        let found = pilot(own, replications);
        assert_eq!(
            found,
            Sampling {
                sampler: SamplerKind::Sobol(expected),
                seed: found.seed,
                ..own
            }
        );
        assert_ne!(found.seed, own.seed);
    }
    assert_eq!(
        pilot(sampling(SamplerKind::Independent), 9).sampler,
        SamplerKind::Independent
    );
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
    let given = counts(&noisy(40, &noise), samples);
    let variance = |given: &[u32]| {
        noise
            .iter()
            .zip(given)
            .map(|(s, n)| s * s / f64::from(*n))
            .sum::<f64>()
    };
    let gain = variance(&vec![samples; 1600]) / variance(&given);
    // Half the samples of one half go to the other: at most 1.8 times as many there.
    assert!((1.5..1.8).contains(&gain), "{gain}");
}
