//! Adaptive sampling: sample counts that a pilot decides leave the mean of an image unbiased.

use rand::Rng as _;
use whitefurnace::film::{Film, Pixel};
use whitefurnace::geometry::shape::Hit;
use whitefurnace::render::adaptive::{Pilot, counts};
use whitefurnace::render::{RayRenderer, Renderer as _};
use whitefurnace::sampling::Sampling;
use whitefurnace::sampling::pixel::PixelSampling;
use whitefurnace::sampling::sampler::{Sampler, SamplerKind};

use crate::prelude::*;
use crate::scenes::nothing;

/// Adaptive sampling of an image, so that each step can be replaced.
#[derive(Clone, Copy)]
pub struct Adaptation {
    /// Samples per replication of each pixel, from the pilot's values, the least and the mean number.
    pub counts: fn(&Film, u32, u32) -> Vec<u32>,
    /// Value of a pixel.
    pub value: fn(&Pixel) -> DVec3,
}

const CORRECT: Adaptation = Adaptation {
    counts,
    value: Pixel::mean,
};

/// Size of the image: one row of pixels.
const SIZE: [u32; 2] = [24, 1];
/// Least number of samples per replication, the pilot's, and mean number.
const LEAST: u32 = 1;
const SAMPLES: u32 = 4;
/// Replications of an image.
const REPLICATIONS: u32 = 4;

/// Returns the column of the pixel that a ray passes, from the left. The camera of [`nothing`]
/// looks along y at pixels of side 1 at distance 1.
fn column(ray: &Ray) -> f64 {
    (ray.direction.x / ray.direction.y + 0.5 * f64::from(SIZE[0])).floor()
}

/// An estimator that returns noise, stronger in brighter pixels: a rare value, which is nonzero in
/// one sample of sixteen, in the first channel, and a uniform one in the second.
struct Noise;

impl Estimator for Noise {
    fn radiance(&self, _: &Scene, ray: &Ray, _: Option<Hit>, rng: &mut dyn Sampler) -> DVec3 {
        let [rare, even] = uniform2(rng);
        brightness(column(ray))
            * DVec3::new(if rare < 0.0625 { 16.0 } else { 0.0 }, 2.0 * even, 0.0)
    }
}

/// Mean radiance of a pixel.
fn brightness(column: f64) -> f64 {
    1.0 + column / 4.0
}

/// Mean radiance of the row.
const MEAN: f64 = 1.0 + (24.0 - 1.0) / 2.0 / 4.0;

const IMAGES: u64 = 10_000;
const EFFECT: f64 = 0.025;

/// Compares the means of both channels over many images with [`MEAN`].
fn images(context: &Context, scene: &Scene, subject: Adaptation) -> Vec<Outcome> {
    let mut seeds = context.rng("images");
    let about = ["rare", "even"].map(|name| (name, MEAN, EFFECT * MEAN));
    means(about, context.n(IMAGES), || {
        let seed = seeds.next_u64();
        let numbers = SamplerKind::Sobol(SAMPLES);
        let sampling = Sampling {
            pixel: PixelSampling::Random,
            sampler: numbers,
            seed,
            silhouettes: false,
        };
        image(scene, sampling, subject).unwrap_or([f64::NAN; 2])
    })
}

/// Renders one image and returns the means of both channels.
fn image(scene: &Scene, sampling: Sampling, subject: Adaptation) -> Option<[f64; 2]> {
    let renderer = RayRenderer {
        estimator: Noise,
        sampling,
    };
    let renderer = renderer.prepare(scene, SIZE).ok()?;
    let mut film = Film::new(SIZE, None, SAMPLES).ok()?;
    let all = 0..REPLICATIONS;
    let pilot = Pilot::take(&*renderer, &film, REPLICATIONS, &all, &|_| true).ok()??;
    let counts = (subject.counts)(pilot.noise(), LEAST, SAMPLES);
    pilot.begin(&mut film, counts).ok()?;
    renderer.add(&mut film, all, &|_| true).ok()?;
    let mean = film.pixels().iter().map(subject.value).sum::<DVec3>() / f64::from(SIZE[0]);
    Some([mean.x, mean.y])
}

/// Returns counts that follow the noise of each pixel's own pilot.
fn by_own_noise(noise: &Film, least: u32, mean: u32) -> Vec<u32> {
    let noise = noise
        .pixels()
        .iter()
        .map(|pixel| pixel.standard_error().length());
    let noise: Vec<f64> = noise.collect();
    let average = noise.iter().sum::<f64>() / noise.len() as f64;
    let count = |noise: &f64| {
        let relative = if average > 0.0 { noise / average } else { 1.0 };
        least + (f64::from(mean - least) * relative).round() as u32
    };
    noise.iter().map(count).collect()
}

/// Trials and faults of adaptive sampling.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    let scene = nothing(SIZE);
    vec![Box::new(Family {
        trials: vec![trial(
            "convergence/adaptive",
            "sample counts that a pilot decides leave the mean of an image unbiased",
            "adaptive sampling makes rare highlights too dark: a bias, not only noise",
            &ADAPTIVE,
            "render::adaptive::counts",
            "t",
            move |context: &Context, subject| images(context, &scene, subject),
        )],
        faults: vec![
            fault!("own-pilot", ADAPTIVE, "the number of a pixel's samples follows its own pilot, which is part of its mean",
                = Adaptation { counts: by_own_noise, ..CORRECT },
                "convergence/adaptive: rare"),
            fault!("by-mean-number", ADAPTIVE, "the sum of a pixel's samples is divided by the mean number of all pixels",
                = Adaptation {
                    value: |own| own.mean() * (f64::from(own.samples()) / f64::from(REPLICATIONS * SAMPLES)),
                    ..CORRECT
                },
                "convergence/adaptive: rare | even"),
        ],
        ..Family::new("adaptation", CORRECT)
    })]
}
