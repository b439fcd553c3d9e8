//! The loop over passes of estimators of whole images.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::{PreparedRenderer, Progress, Renderer};
use crate::error::Error;
use crate::film::{Features, Film, PartialReplication, check_radiance};
use crate::integrator::{ImageEstimator, SurfaceInteraction};
use crate::math::real::{Mask, Real};
use crate::math::simd::{LANES, Lanes};
use crate::sampling::Sampling;
use crate::sampling::pixel::PixelSampling;
use crate::sampling::rng::{stream, uniform2};
use crate::sampling::sampler::{ImagePass, SamplerKind};
use crate::scene::Scene;
use crate::scene::lanes::{IntersectionScratch, LaneScene};

/// Returns the features seen through these points of the image.
fn features_at(scene: &Scene, resolution: [u32; 2], points: &[[f64; 2]]) -> Vec<Option<Features>> {
    let lanes: LaneScene<'_, Lanes, LANES> = LaneScene::new(scene);
    let mut scratch = IntersectionScratch::new();
    let features = points.chunks(LANES).flat_map(|points| {
        let [x, y] =
            [0, 1].map(|axis| Lanes::from_lanes(|i| points.get(i).unwrap_or(&points[0])[axis]));
        let ray = scene.camera().ray(resolution, x, y);
        let found = lanes.closest(&ray, Mask::from_fn(|i| i < points.len()), &mut scratch);
        let hit_bits = found.hit_mask.bits();
        let surface = (hit_bits != 0).then(|| SurfaceInteraction::new(lanes, &ray, &found));
        let features_of_lane = move |i: usize| {
            surface
                .as_ref()
                .filter(|_| hit_bits >> i & 1 == 1)
                .map(|surface| surface.features(i))
        };
        (0..points.len()).map(features_of_lane).collect::<Vec<_>>()
    });
    features.collect()
}

/// Adds the replications `range` of an image estimator to a film of the full image. A replication
/// is one pass, or the mean of as many as a scramble has points. Albedo, normal and depth are those
/// of one camera ray per pixel and pass, the one that [`render`](super::render()) traces for
/// [`PixelSampling::Random`] and [`SamplerKind::Independent`], whatever rays the estimator itself
/// traces. `pass_done` is called after each pass with its number of pixels; when it returns false,
/// the remaining passes are left out and `Ok(false)` is returned: the film keeps the passes of an
/// unfinished replication, which the next call continues.
///
/// # Errors
/// [`Error::Option`] for a film that is a part of its image, and as for
/// [`render`](super::render()); errors of the estimator; [`Error::Radiance`] with the pixel and the
/// pass for an invalid radiance.
pub fn render_passes(
    scene: &Scene,
    estimator: &dyn ImageEstimator,
    sampler: SamplerKind,
    seed: u64,
    film: &mut Film,
    range: Range<u32>,
    pass_done: &dyn Fn(u64) -> bool,
) -> Result<bool, Error> {
    let resolution = film.resolution();
    if film.size() != resolution {
        return Err(Error::Option(
            "an estimator of whole images cannot render a window: take the full frame".to_owned(),
        ));
    }
    let sampling = Sampling {
        pixel: PixelSampling::Random,
        sampler,
        seed,
        silhouettes: false,
    };
    super::check(&sampling, range.end, film)?;
    let samples = sampling.samples_per_replication();
    let width = resolution[0] as usize;
    for replication in range {
        let partial = film.partial.take();
        let mut partial = partial.unwrap_or_else(|| PartialReplication {
            passes: 0,
            sums: vec![DVec3::ZERO; film.pixels().len()],
        });
        let passes = replication * samples..(replication + 1) * samples;
        for index in passes.clone().skip(partial.passes as usize) {
            let pass = ImagePass {
                sampler,
                seed,
                index,
            };
            let image = estimator.image(scene, resolution, pass)?;
            let sums = partial.sums.par_chunks_mut(width);
            let sums_and_values = sums.zip_eq(image.par_chunks(width));
            let rows = film
                .pixels_mut()
                .par_chunks_mut(width)
                .zip_eq(sums_and_values)
                .enumerate();
            rows.try_for_each(|(y, (pixels, (sums, values)))| {
                let point = |x: u32| {
                    let random = uniform2(&mut stream(seed, y as u32 * resolution[0] + x, index));
                    let offset = PixelSampling::Random.position(0, random);
                    [f64::from(x) + offset[0], y as f64 + offset[1]]
                };
                let points: Vec<_> = (0..resolution[0]).map(point).collect();
                let features = features_at(scene, resolution, &points);
                for (x, (((pixel, sum), value), features)) in pixels
                    .iter_mut()
                    .zip(sums)
                    .zip(values)
                    .zip(features)
                    .enumerate()
                {
                    if let Some(features) = &features {
                        pixel.push_features(features)?;
                    }
                    *sum += value;
                    check_radiance(*value).map_err(|error| {
                        error.at(|| format!(" at pixel ({x}, {y}), pass {index}"))
                    })?;
                    if index + 1 == passes.end {
                        pixel.push(*sum / f64::from(samples), samples)?;
                    }
                }
                Ok(())
            })?;
            if !pass_done(image.len() as u64) {
                partial.passes = index + 1 - passes.start;
                film.partial = (index + 1 < passes.end).then_some(partial);
                return Ok(false);
            }
        }
    }
    Ok(true)
}

/// Renderer by whole images.
#[derive(Clone, Copy, Debug)]
pub struct ImageRenderer<E> {
    /// Estimator of an image.
    pub estimator: E,
    /// Source of the random numbers.
    pub sampler: SamplerKind,
    /// Master seed.
    pub seed: u64,
}

impl<E: ImageEstimator> Renderer for ImageRenderer<E> {
    fn samples_per_replication(&self) -> u32 {
        self.sampler.samples()
    }
    fn prepare<'a>(
        &'a self,
        scene: &'a Scene,
        _: [u32; 2],
    ) -> Result<Box<dyn PreparedRenderer + 'a>, Error> {
        Ok(Box::new(PreparedImageRenderer {
            scene,
            passes: self,
        }))
    }
}

/// An image renderer prepared for a scene.
struct PreparedImageRenderer<'a, E> {
    scene: &'a Scene,
    passes: &'a ImageRenderer<E>,
}

impl<E: ImageEstimator> PreparedRenderer for PreparedImageRenderer<'_, E> {
    fn add(
        &self,
        film: &mut Film,
        range: Range<u32>,
        progress: Progress<'_>,
    ) -> Result<bool, Error> {
        let (scene, passes) = (self.scene, self.passes);
        let (estimator, sampler, seed) = (&passes.estimator, passes.sampler, passes.seed);
        render_passes(scene, estimator, sampler, seed, film, range, progress)
    }
}
