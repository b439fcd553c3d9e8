//! Tests of frame sizes that are wide, tall, odd, one, and one beyond each threshold of the code.

use std::ops::Range;

use whitefurnace::harness::images::{Rules, Side, compare};
use whitefurnace::harness::outcome::Verdict;
use whitefurnace::sampling::sampler::MAX_POINTS;

use crate::prelude::*;

/// Sizes around lanes (8 and 16), batches of walks (256) and pixels of a tile.
const FRAMES: [[u32; 2]; 12] = [
    [1, 1],
    [1, 2],
    [2, 1],
    [7, 1],
    [9, 2],
    [1, 17],
    [15, 17],
    [16, 16],
    [257, 1],
    [1, 257],
    [3, 86],
    [129, 2],
];

fn add(scene: &Scene, by: &dyn Renderer, film: &mut Film, range: Range<u32>) {
    assert!(by.add(scene, film, range, &|_| true).expect("legal values"));
}

/// Returns a room seen by a tilted camera, so that no two pixels of a frame are alike.
fn tilted() -> Scene {
    let camera = Camera::new(
        DVec3::new(1.0, 2.0, 2.5),
        DVec3::new(4.0, 4.5, 2.0),
        DVec3::new(0.2, 0.1, 1.0),
        1.3,
    );
    simple::cornell()
        .expect("a scene")
        .with_camera(camera)
        .expect("a camera")
}

/// An image equals its pixels, each rendered as a window of its own or in another order of
/// replications, in lanes or singly; films of separate replications merge to it.
#[test]
fn every_shape_is_its_pixels() {
    let scene = tilted();
    let path = Path::new(PathStrategy::Mis);
    for frame in FRAMES {
        for numbers in [SamplerKind::Independent, SamplerKind::Sobol(3)] {
            let sampling = sampling(Random, numbers, master());
            let lanes = lanes(LaneEstimator::Path(path), sampling, Precision::Double);
            let alone = RayRenderer {
                estimator: Path::new(PathStrategy::Mis).with_parts(Parts::replaced(&ScalarParts)),
                sampling,
            };
            let film = |window| Film::new(frame, window, numbers.samples()).expect("a legal size");
            let mut whole = film(None);
            add(&scene, &lanes, &mut whole, 0..3);
            let mut scalar = film(None);
            add(&scene, &alone, &mut scalar, 0..3);
            assert!(whole == scalar, "{frame:?}");
            let [mut first, mut rest] = [film(None), film(None)];
            add(&scene, &alone, &mut first, 0..1);
            add(&scene, &lanes, &mut rest, 1..3);
            first.merge(&rest).expect("alike");
            assert!(whole == first, "{frame:?}");
            let [width, height] = frame;
            for [x, y] in [
                [0, 0],
                [width - 1, 0],
                [0, height - 1],
                [width - 1, height - 1],
                [width / 2, height / 3],
            ] {
                let mut part = film(Some(Window {
                    corner: [x, y],
                    size: [1, 1],
                }));
                add(&scene, &lanes, &mut part, 0..3);
                assert!(
                    part.pixels()[0] == *whole.pixel(x, y),
                    "{frame:?}: ({x}, {y})"
                );
                // The position in the frame matters, too: samples are rays of the camera through
                // that pixel.
                let mut rng = stream(master(), y * width + x, 0);
                let [u, v] = Random.position(0, uniform2(&mut rng));
                let ray = scene
                    .camera()
                    .ray(frame, f64::from(x) + u, f64::from(y) + v);
                let mut one =
                    Film::new(frame, Some(part.window()), numbers.samples()).expect("a legal size");
                add(&scene, &alone, &mut one, 0..1);
                if numbers.samples() == 1 {
                    let light = path.radiance(&scene, &ray, scene.intersect(&ray), &mut rng);
                    assert_abs_diff_eq!(
                        light,
                        one.pixels()[0].mean(),
                        epsilon = 1e-6 * (1.0 + light.max_element())
                    );
                }
            }
        }
    }
}

/// Passes over frames of any shape are the same on any number of threads, and the camera sees a
/// lamp in the pixels whose rays hit it.
#[test]
fn particles_reach_their_pixels_in_every_shape() {
    // A lamp in the upper right of an otherwise dark frame.
    let scene = scene_from(Camera::new(DVec3::ZERO, DVec3::Y, DVec3::Z, 1.0), |s| {
        ball(s, Sphere::new(DVec3::new(0.3, 1.0, 0.35), 0.08), lamp(2.0));
    });
    for frame in FRAMES {
        let tracer = LightTracer::default();
        let passes = |threads| {
            on_threads(threads, || {
                passes(&scene, &tracer, frame, &[0..16]).expect("legal values")
            })
        };
        let film = passes(1);
        assert!(film == passes(3), "{frame:?}");
        let [width, _] = frame;
        for (i, pixel) in film.pixels().iter().enumerate() {
            let [x, y] = [i as u32 % width, i as u32 / width];
            if pixel.mean().x > 0.0 {
                let meets = |k: u32| {
                    let [u, v] = [k % 64, k / 64].map(|k| (f64::from(k) + 0.5) / 64.0);
                    scene
                        .intersect(
                            &scene
                                .camera()
                                .ray(frame, f64::from(x) + u, f64::from(y) + v),
                        )
                        .is_some()
                };
                assert!((0..64 * 64).any(meets), "{frame:?}: ({x}, {y})");
            }
        }
        // In other frames it is not in view, or on few pixels.
        if [[15, 17], [16, 16]].contains(&frame) {
            assert!(film.mean() > 0.0, "{frame:?}");
        }
    }
}

/// More samples than 2¹⁶, and as many points of a scramble as are allowed: in one piece, in shards,
/// and merged.
#[test]
fn many_samples_are_the_sum_of_their_parts() {
    let scene = scene(|s| s.background(DVec3::new(1.0, 0.5, 0.25)));
    let path = Path::new(PathStrategy::Mis);
    for (numbers, replications) in [
        (SamplerKind::Independent, (1 << 16) + 3),
        (SamplerKind::Sobol(MAX_POINTS), 2),
    ] {
        let sampling = sampling(Random, numbers, master());
        let by = lanes(LaneEstimator::Path(path), sampling, Precision::Double);
        let film = |ranges: &[Range<u32>]| {
            let mut film = Film::new([2, 1], None, numbers.samples()).expect("a legal size");
            ranges
                .iter()
                .for_each(|range| add(&scene, &by, &mut film, range.clone()));
            film
        };
        let whole = film(&[0..replications]);
        let cut = (replications - 1).min(1 << 15);
        assert!(whole == film(&[0..1, 1..cut.max(1), cut.max(1)..replications]));
        let mut merged = film(&[cut..replications]);
        merged.merge(&film(&[0..cut])).expect("alike");
        assert!(whole == merged);
        for pixel in whole.pixels() {
            assert_eq!(
                u64::from(pixel.samples()),
                u64::from(replications) * u64::from(numbers.samples())
            );
            assert_abs_diff_eq!(pixel.mean(), DVec3::new(1.0, 0.5, 0.25), epsilon = 1e-9);
            assert_abs_diff_eq!(pixel.standard_error(), DVec3::ZERO, epsilon = 1e-9);
        }
    }
}

/// In images of any shape, regions of every kind tile the frame, each has the mean of its pixels,
/// and a brighter rectangle is found in its pixels and in no region that it does not touch.
#[test]
fn differences_are_found_where_they_are() {
    for [width, height] in [
        [1, 40],
        [40, 1],
        [5, 33],
        [33, 5],
        [16, 17],
        [17, 16],
        [31, 32],
        [49, 3],
    ] {
        let count = width * height;
        // Noise of a pixel is ±1 % in equally many images; skewness leaves all pixels testable.
        let sign = |k: u32, i: usize| {
            if (k & (1 + (5 * i as u32 + 1) % 7))
                .count_ones()
                .is_multiple_of(2)
            {
                1.0
            } else {
                -1.0
            }
        };
        let images = || {
            (0..8)
                .map(|k| (0..count).map(|i| 1.0 + 0.01 * sign(k, i)).collect())
                .collect()
        };
        let [mut a, b]: [Vec<Vec<f64>>; 2] = [(); 2].map(|()| images());
        // Three columns and two rows, in the upper right.
        let corner = [width - 1 - width / 4, height / 3];
        let [[left, top], [right, bottom]] = [
            corner,
            [(corner[0] + 3).min(width), (corner[1] + 2).min(height)],
        ];
        for image in &mut a {
            (top..bottom).for_each(|y| (left..right).for_each(|x| image[y * width + x] += 5.0));
        }
        let sides = [&a, &b].map(|images| Side::Images(images.iter().map(Vec::as_slice).collect()));
        let found = compare(width, &[sides], &Rules::default());
        assert_eq!(found.verdict, Verdict::Fails, "{width} × {height}");
        let [_, _, tiles, pixels] = &found.kinds;
        assert_eq!(tiles.grid, [width.div_ceil(16), height.div_ceil(16)]);
        assert_eq!(pixels.grid, [width, height]);
        for kind in &found.kinds {
            let mut covered = vec![0; count];
            for place in &kind.tests {
                let [x0, y0, x1, y1] = place.area;
                let inside = || (y0..y1).flat_map(|y| (x0..x1).map(move |x| y * width + x));
                inside().for_each(|i| covered[i] += 1);
                let sum = |images: &[Vec<f64>]| -> f64 {
                    inside()
                        .flat_map(|i| images.iter().map(move |a| a[i]))
                        .sum()
                };
                let means = [&a, &b].map(|images| sum(images) / (8 * inside().count()) as f64);
                assert_relative_eq!(place.means[..], means[..], max_relative = 1e-12);
                let touches = x0 < right && left < x1 && y0 < bottom && top < y1;
                // A difference of larger regions that is in one pixel alone is not reported.
                let found = kind.rejects(place);
                assert!(
                    found == touches || (touches && kind.name != "pixel"),
                    "{width} × {height}: {:?}",
                    place.area
                );
            }
            assert!(
                covered.iter().all(|times| *times == 1),
                "{width} × {height}: {}",
                kind.name
            );
        }
    }
}
