//! Random streams as [`whitefurnace::render::render`] hands them out. An estimator that returns the random numbers that
//! it receives is rendered, and the film is read as a table of random numbers.

use whitefurnace::geometry::shape::Hit;
use whitefurnace::sampling::pixel::PixelSampling;
use whitefurnace::sampling::sampler::Sampler;

use crate::images::{Frames, independent_film};
use crate::prelude::*;
use crate::scenes::nothing;
use crate::streams::{Pairs, collisions};

/// A wide frame, in which a stride by its height instead of its width would show.
const SIZE: [u32; 2] = [256, 64];
const WIDTH: usize = SIZE[0] as usize;
const PIXELS: usize = (SIZE[0] * SIZE[1]) as usize;

/// 2²¹, which makes a number of 53 random bits a multiple of 2⁻³², as a film holds it.
const BITS_TO_UNITS: f64 = 2_097_152.0;

/// An estimator that returns its first two random numbers, and the ray's position in its pixel from
/// left to right.
struct FirstNumbers;

impl Estimator for FirstNumbers {
    fn radiance(&self, _: &Scene, ray: &Ray, _: Option<Hit>, rng: &mut dyn Sampler) -> DVec3 {
        let [first, second] = uniform2(rng);
        // The camera of `nothing` looks along y and its pixels are squares of side 1 at distance 1.
        let x = ray.direction.x / ray.direction.y + 0.5 * f64::from(SIZE[0]);
        BITS_TO_UNITS * DVec3::new(first, second, x.rem_euclid(1.0))
    }
}

/// Returns the numbers of every pixel, row by row, from a master seed and the number of the sample:
/// first and second number of the estimator, and the number that placed the ray in its pixel.
pub type Numbers = fn(&Scene, u64, u32) -> Vec<DVec3>;

/// Returns the numbers that `render` hands out; where it fails, numbers that every trial rejects.
fn right(scene: &Scene, seed: u64, sample: u32) -> Vec<DVec3> {
    let frames = Frames {
        scene,
        size: SIZE,
        replications: sample..sample + 1,
    };
    match independent_film(&frames, &FirstNumbers, PixelSampling::Random, seed) {
        Ok(film) => film
            .pixels()
            .iter()
            .map(|p| p.mean() / BITS_TO_UNITS)
            .collect(),
        Err(_) => vec![DVec3::NAN; PIXELS],
    }
}

const FRAMES: u64 = 32;

/// Tests that first numbers over all pixels and samples are distinct.
fn distinct(context: &Context, scene: &Scene, numbers: Numbers) -> Vec<Outcome> {
    let seed = context.seed_of("distinct");
    let frames = context.n(FRAMES) as u32;
    let firsts = (0..frames).flat_map(|sample| numbers(scene, seed, sample));
    vec![collisions(firsts.map(|numbers| numbers.x))]
}

/// Pairs of frames; each gives as many pairs of numbers of every kind as a frame has pixels.
const FRAME_PAIRS: u64 = 460;

/// Kinds of neighbours.
const KINDS: [&str; 5] = ["columns", "rows", "samples", "draws", "positions and draws"];

/// Tests that neighbours of every kind are independent.
fn neighbours(context: &Context, scene: &Scene, numbers: Numbers) -> Vec<Outcome> {
    let seed = context.seed_of("neighbours");
    let mut pairs: [Pairs; KINDS.len()] = Default::default();
    let [columns, rows, samples, draws, positions] = &mut pairs;
    for i in 0..context.n(FRAME_PAIRS) as u32 {
        let frames = [2 * i, 2 * i + 1].map(|sample| numbers(scene, seed, sample));
        for frame in &frames {
            for two in frame.chunks_exact(2) {
                columns.push([two[0].x, two[1].x]);
            }
            for two in frame.chunks_exact(2 * WIDTH) {
                let (upper, lower) = two.split_at(WIDTH);
                upper
                    .iter()
                    .zip(lower)
                    .for_each(|(a, b)| rows.push([a.x, b.x]));
            }
        }
        for (a, b) in frames[0].iter().zip(&frames[1]) {
            samples.push([a.x, b.x]);
            draws.push([a.x, a.y]);
            positions.push([a.z, a.x]);
        }
    }
    let named = pairs.iter().zip(KINDS);
    named
        .flat_map(|(pairs, kind)| pairs.outcomes(kind))
        .collect()
}

// The faults: numbers of a careless `render` or estimator, made from the correct ones.

/// Returns `render`'s numbers, with those of another pixel in place of each.
fn moved(scene: &Scene, seed: u64, sample: u32, from: fn(usize, usize) -> usize) -> Vec<DVec3> {
    let frame = right(scene, seed, sample);
    (0..frame.len())
        .map(|k| frame[from(k % WIDTH, k / WIDTH)])
        .collect()
}

/// Returns `render`'s numbers, some of each pixel's changed.
fn changed(scene: &Scene, seed: u64, sample: u32, change: fn(&mut DVec3)) -> Vec<DVec3> {
    let mut frame = right(scene, seed, sample);
    frame.iter_mut().for_each(change);
    frame
}

/// Trials and faults of the streams of `render`.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    let scene = nothing(SIZE);
    let family_trial = |name: &str, property: &str, consequence: &str, statistic, on: On| {
        let (name, scene) = (format!("streams/render/{name}"), Arc::clone(&scene));
        let on = move |context: &Context, numbers| on(context, &scene, numbers);
        trial(
            name,
            property,
            consequence,
            &ESTIMATOR,
            "render::render",
            statistic,
            on,
        )
    };
    vec![Box::new(Family {
        trials: vec![
            family_trial(
                "distinct",
                "the first numbers of all pixels and samples are distinct",
                "pixels far apart show the same noise, as if a tile were copied",
                "Poisson",
                distinct,
            ),
            family_trial(
                "neighbours",
                "neighbouring columns, rows, samples and draws, and a ray's position and its first draw, are independent",
                "the noise of an image forms stripes and blocks, and its error bars are too narrow",
                "chi-square and t",
                neighbours,
            ),
        ],
        faults: vec![
            fault!("shared-columns", ESTIMATOR, "two columns share a stream",
                = |scene, seed, sample| moved(scene, seed, sample, |x, y| WIDTH * y + x / 2 * 2),
                "streams/render/neighbours: pairs of neighbouring columns | correlation of neighbouring columns",
                "streams/render/distinct"),
            fault!("shared-rows", ESTIMATOR, "two rows share a stream",
                = |scene, seed, sample| moved(scene, seed, sample, |x, y| WIDTH * (y / 2 * 2) + x),
                "streams/render/neighbours: pairs of neighbouring rows | correlation of neighbouring rows"),
            fault!("stride-of-height", ESTIMATOR,
                "a pixel's number is y times the height plus x: far pixels share a stream",
                = |scene, seed, sample| moved(scene, seed, sample, |x, y| SIZE[1] as usize * y + x),
                "streams/render/distinct"),
            fault!("shared-samples", ESTIMATOR, "every second sample repeats the one before",
                = |scene, seed, sample| right(scene, seed, sample / 2),
                "streams/render/neighbours: pairs of neighbouring samples | correlation of neighbouring samples"),
            fault!("same-draw", ESTIMATOR, "an estimator gets the same number twice",
                = |scene, seed, sample| changed(scene, seed, sample, |numbers| numbers.y = numbers.x),
                "streams/render/neighbours: pairs of neighbouring draws | correlation of neighbouring draws"),
            fault!("position-again", ESTIMATOR, "an estimator gets the numbers again that placed the ray in its pixel",
                = |scene, seed, sample| changed(scene, seed, sample, |numbers| numbers.x = numbers.z),
                "streams/render/neighbours: pairs of neighbouring positions and draws \
                 | correlation of neighbouring positions and draws"),
        ],
        ..Family::new("render streams", right as Numbers)
    })]
}

/// A trial's function, given the scene.
type On = fn(&Context, &Scene, Numbers) -> Vec<Outcome>;
