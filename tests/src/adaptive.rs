//! Adaptive sampling: sample counts that a pilot decides leave the mean of an image unbiased.

use rand::Rng as _;
use whitefurnace::film::{Film, Pixel};
use whitefurnace::geometry::shape::Hit;
use whitefurnace::render::adaptive::REPLICATIONS;
use whitefurnace::render::{adaptive, render};
use whitefurnace::sampling::Sampling;
use whitefurnace::sampling::pixel::PixelSampling;
use whitefurnace::sampling::sampler::{Sampler, SamplerKind};

use crate::prelude::*;
use crate::scenes::nothing;

/// Adaptive sampling of an image, so that each step can be replaced.
#[derive(Clone, Copy)]
pub struct Adaptation {
    /// Sampling of the pilot, from that of the image and the number of replications.
    pub pilot: fn(Sampling, u32) -> Sampling,
    /// Samples per replication of each pixel, from the pilot's film and their mean.
    pub counts: fn(&Film, u32) -> Vec<u32>,
    /// Value of a pixel, from the pilot's pixel and its own.
    pub value: fn(&Pixel, &Pixel) -> DVec3,
}

const CORRECT: Adaptation = Adaptation {
    pilot: adaptive::pilot,
    counts: adaptive::counts,
    value: |_, pixel| pixel.mean(),
};

/// Size of the image: one row of pixels.
const SIZE: [u32; 2] = [24, 1];
/// Mean samples per replication.
const SAMPLES: u32 = 4;

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
    let rendered = |sampling: Sampling, counts: Option<Vec<u32>>| {
        let mut film = Film::new(SIZE, None, sampling.samples_per_replication()).ok()?;
        if let Some(counts) = counts {
            film.set_sample_counts(counts);
        }
        render(
            scene,
            &Noise,
            sampling,
            &mut film,
            &(0..REPLICATIONS),
            &|_| true,
        )
        .ok()?;
        Some(film)
    };
    let pilot = rendered((subject.pilot)(sampling, REPLICATIONS), None)?;
    let film = rendered(sampling, Some((subject.counts)(&pilot, SAMPLES)))?;
    let values = pilot
        .pixels()
        .iter()
        .zip(film.pixels())
        .map(|(pilot, own)| (subject.value)(pilot, own));
    let mean = values.sum::<DVec3>() / f64::from(SIZE[0]);
    Some([mean.x, mean.y])
}

/// Returns the mean of the samples of both, weighted by their numbers.
fn together(pilot: &Pixel, own: &Pixel) -> DVec3 {
    let [a, b] = [pilot, own].map(|pixel| f64::from(pixel.samples()));
    (a * pilot.mean() + b * own.mean()) / (a + b)
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
            fault!("pilot-kept", ADAPTIVE, "the pilot's samples enter the mean, weighted by their number",
                = Adaptation { value: together, ..CORRECT },
                "convergence/adaptive: rare"),
            fault!("pilot-of-the-same-samples", ADAPTIVE, "the pilot's samples are the first of the image",
                = Adaptation { pilot: |own, n| Sampling { seed: own.seed, ..adaptive::pilot(own, n) }, ..CORRECT },
                "convergence/adaptive: rare"),
            fault!("by-mean-number", ADAPTIVE, "the sum of a pixel's samples is divided by the mean number of all pixels",
                = Adaptation {
                    value: |_, own| own.mean() * (f64::from(own.samples()) / f64::from(REPLICATIONS * SAMPLES)),
                    ..CORRECT
                },
                "convergence/adaptive: rare | even"),
        ],
        ..Family::new("adaptation", CORRECT)
    })]
}
