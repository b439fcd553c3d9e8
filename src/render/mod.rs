//! The loop over pixels, replications and samples.

pub mod adaptive;
mod by_lanes;
mod by_passes;
#[cfg(feature = "files")]
pub mod checkpoint;
mod row;
pub mod silhouette;

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Error;
use crate::film::{BegunReplications, Features, Film, Pixel, check_radiance, features};
use crate::geometry::shape::{Hit, Ray};
use crate::integrator::{Estimator, Sample};
use crate::sampling::Sampling;
use crate::sampling::pixel::PixelSampling;
use crate::sampling::rng::uniform2;
use crate::sampling::sampler::{MAX_POINTS, SamplerKind};
use crate::scene::Scene;
use silhouette::{Silhouettes, with_supersampled_emission};

pub use by_lanes::{
    LaneRenderer, Precision, SINGLE_EXTENTS, SINGLE_MAX_EXTENT_RATIO, check_single_precision,
    render_lanes,
};
pub use by_passes::{ImageRenderer, render_passes};
pub use row::LaneEstimator;

/// Callback, from any thread, with a number of samples that are done; it returns false to stop.
/// After a stop pixels may have different numbers of replications, and the same call again adds the
/// missing ones.
pub type Progress<'a> = &'a (dyn Fn(u64) -> bool + Sync);

/// Refuses numbers of samples that the generators cannot index, and films of other numbers.
///
/// # Errors
/// [`Error::Option`] for replications without samples, with more than [`MAX_POINTS`] Sobol'
/// points, or so many up to `replications` that 32 bits do not number their samples, or not as
/// many as the film has; for different numbers per pixel, except with Sobol' points without
/// sub-pixels.
fn check(sampling: &Sampling, replications: u32, film: &Film) -> Result<(), Error> {
    let per_replication = sampling.samples_per_replication();
    let counts = film
        .sample_counts()
        .unwrap_or(&[])
        .iter()
        .copied()
        .chain([per_replication]);
    let (fewest, samples) = counts.fold((per_replication, per_replication), |(low, high), n| {
        (low.min(n), high.max(n))
    });
    let refuse = |why: String| {
        Err(Error::Option(format!(
            "{samples} samples in a replication: {why}"
        )))
    };
    if film.sample_counts().is_some()
        && (sampling.sampler == SamplerKind::Independent
            || sampling.pixel.samples_per_replication() != 1)
    {
        return refuse(
            "different numbers per pixel need Sobol' points without sub-pixels".to_owned(),
        );
    }
    if fewest == 0 {
        return refuse("at least 1 is needed".to_owned());
    }
    if matches!(sampling.sampler, SamplerKind::Sobol(_)) && samples > MAX_POINTS {
        return refuse(format!("a scramble has at most {MAX_POINTS} points"));
    }
    if samples.checked_mul(replications).is_none() {
        return refuse(format!(
            "with {replications} replications they are more than {}",
            u32::MAX
        ));
    }
    if sampling.silhouettes
        && matches!(
            sampling.pixel,
            PixelSampling::Centre | PixelSampling::Grid(_)
        )
    {
        return Err(Error::Option(
            "silhouettes need samples anywhere in a pixel, not at its centre or on a grid"
                .to_owned(),
        ));
    }
    if film.samples_per_replication() != per_replication {
        return Err(Error::Option(format!(
            "a film of {} samples per replication cannot take {per_replication}",
            film.samples_per_replication()
        )));
    }
    Ok(())
}

/// Adds the replications `range` to every pixel of the film.
///
/// Sample k of pixel (x, y) of the full image draws from the stream (seed, pixel, k) and sums are
/// exact, so neither threads nor the order or division of the ranges change the result.
///
/// `progress` is called after each part of the film, of about [`Estimator::batch_size`] samples or
/// less, with their number, from any thread; when it returns false, the rest is left out and
/// `Ok(false)` is returned: see [`Progress`].
///
/// # Errors
/// [`Error::Radiance`] with pixel and replication if the estimator returns an invalid radiance;
/// [`Error::Option`] for replications with no sample, more than 2³² in all, more Sobol' points than
/// [`MAX_POINTS`], or not as many samples as the film has.
pub fn render(
    scene: &Scene,
    estimator: &dyn Estimator,
    sampling: Sampling,
    film: &mut Film,
    range: &Range<u32>,
    progress: Progress<'_>,
) -> Result<bool, Error> {
    PreparedRayRenderer::new(scene, estimator, sampling, film.resolution()).add(
        film,
        range.clone(),
        progress,
    )
}

/// Approximate largest number of samples that a thread takes in lanes between two calls of
/// [`Progress`], but never less than a replication of a pixel.
pub const CHUNK_SAMPLES: u32 = 1 << 14;

/// Neighbouring pixels of a row that lack the same replications.
pub(crate) struct PixelRun<'a> {
    /// Position of the first pixel in the full image.
    pub corner: [u32; 2],
    /// Replications to add.
    pub replications: Range<u32>,
    pub pixels: &'a mut [Pixel],
    /// Number of samples in a replication of each pixel.
    pub counts: &'a [u32],
    /// Samples that replications have begun with.
    begun: Option<&'a BegunReplications>,
    /// Index of the first pixel in the film.
    first: usize,
}

impl PixelRun<'_> {
    /// Returns the settings of the samples of the pixel in this column.
    fn sampling(&self, column: usize, sampling: Sampling) -> Sampling {
        sampling.with_samples(self.begun.map_or(self.counts[column], |begun| begun.stride))
    }

    /// Returns how many samples a replication of the pixel in this column has begun with, and the sum
    /// of their radiances.
    fn begun(&self, column: usize, replication: u32) -> (u32, DVec3) {
        self.begun.map_or((0, DVec3::ZERO), |begun| {
            begun.samples_of(self.first + column, replication)
        })
    }
}

/// Calls `add` with runs of pixels that together cover the film's window, of about `batch_size`
/// samples or less.
fn for_each_run(
    sampling: Sampling,
    batch_size: u32,
    film: &mut Film,
    range: &Range<u32>,
    progress: Progress<'_>,
    add: impl Fn(&mut [PixelRun<'_>]) -> Result<(), Error> + Sync,
) -> Result<bool, Error> {
    check(&sampling, range.end, film)?;
    let window = film.window();
    let [width, height] = window.size.map(|n| n as usize);
    let min_replications = film.replications();
    let per_replication = sampling.samples_per_replication();
    let samples_per_pixel = u64::from(range.end - range.start) * u64::from(per_replication);
    let pixels_per_run = (u64::from(batch_size) / samples_per_pixel.max(1)).max(1) as usize;
    // Several rows at once for estimators that gain by it, but enough groups for all threads.
    let max_rows = height / (GROUPS_PER_THREAD * rayon::current_num_threads());
    let rows = if batch_size > CHUNK_SAMPLES {
        (pixels_per_run / width).min(max_rows).max(1)
    } else {
        1
    };
    let stopped = AtomicBool::new(false);
    let (pixels, counts, begun) = film.parts_mut();
    let uniform_counts = vec![per_replication; width];
    let samples_per_group = samples_per_pixel
        .saturating_mul((width * rows) as u64)
        .max(1);
    pixels
        .par_chunks_mut(width * rows)
        .with_min_len(MIN_SAMPLES.div_ceil(samples_per_group) as usize)
        .enumerate()
        .try_for_each(|(group, pixels)| {
            let mut runs = Vec::new();
            for (row, at) in pixels.chunks_mut(width).zip(group * rows..) {
                let mut counts = counts.map_or(&*uniform_counts, |counts| {
                    &counts[at * width..(at + 1) * width]
                });
                let (mut first, y) = (at * width, window.corner[1] + at as u32);
                let same = |a: &Pixel, b: &Pixel| a.replications() == b.replications();
                for pixels in row
                    .chunks_mut(pixels_per_run)
                    .flat_map(|pixels| pixels.chunk_by_mut(same))
                {
                    let start = range
                        .start
                        .saturating_add(pixels[0].replications() - min_replications);
                    let replications = start.min(range.end)..range.end;
                    let (run_counts, rest) = counts.split_at(pixels.len());
                    counts = rest;
                    let corner = [window.corner[0] + (first - at * width) as u32, y];
                    let here = first;
                    first += pixels.len();
                    if !replications.is_empty() {
                        runs.push(PixelRun {
                            corner,
                            replications,
                            pixels,
                            counts: run_counts,
                            begun,
                            first: here,
                        });
                    }
                }
            }
            let runs_per_call = if rows > 1 { runs.len() } else { 1 };
            for runs in runs.chunks_mut(runs_per_call.max(1)) {
                if stopped.load(Ordering::Relaxed) {
                    break;
                }
                add(runs)?;
                let of = |run: &PixelRun<'_>| {
                    let samples: u64 = run.counts.iter().copied().map(u64::from).sum();
                    samples * u64::from(run.replications.end - run.replications.start)
                };
                if !progress(runs.iter().map(of).sum()) {
                    stopped.store(true, Ordering::Relaxed);
                }
            }
            Ok(())
        })?;
    Ok(!stopped.into_inner())
}

/// Least number of samples for which another thread is woken.
const MIN_SAMPLES: u64 = 256;

/// Least number of groups of rows per thread where a group could have several rows.
const GROUPS_PER_THREAD: usize = 8;

/// Index of a sample: that of its pixel in a list, of the replication, and of the sample there.
type SampleIndex = (usize, u32, u32);

/// Returns the features of a camera ray's hit.
fn features_of(scene: &Scene, ray: &Ray, hit: &Hit) -> Features {
    let albedo = scene.surface(hit).bsdf.albedo();
    features(albedo, hit.normal, hit.t, ray.direction)
}

/// Renderer: adds replications to films, with any kind of estimator.
pub trait Renderer: Sync {
    /// Returns the number of samples of one replication.
    fn samples_per_replication(&self) -> u32;
    /// Prepares all that depends on the scene and on the size of the full image (width, height)
    /// alone, once for all ranges.
    ///
    /// # Errors
    /// [`Error::Option`] for a scene that the renderer does not support.
    fn prepare<'a>(
        &'a self,
        scene: &'a Scene,
        resolution: [u32; 2],
    ) -> Result<Box<dyn PreparedRenderer + 'a>, Error>;

    /// Adds the replications `range` to every pixel of the film, as [`render`] and
    /// [`render_passes`] do.
    ///
    /// # Errors
    /// Those of [`prepare`](Self::prepare) and of [`PreparedRenderer::add`].
    fn add(
        &self,
        scene: &Scene,
        film: &mut Film,
        range: Range<u32>,
        progress: Progress<'_>,
    ) -> Result<bool, Error> {
        self.prepare(scene, film.resolution())?
            .add(film, range, progress)
    }
}

/// A renderer prepared for a scene and an image size.
pub trait PreparedRenderer: Sync {
    /// Adds the replications `range` to every pixel of the film, as [`render`] and
    /// [`render_passes`] do.
    ///
    /// # Errors
    /// Those of [`render`] or [`render_passes`].
    fn add(
        &self,
        film: &mut Film,
        range: Range<u32>,
        progress: Progress<'_>,
    ) -> Result<bool, Error>;
}

/// Renderer by single rays.
#[derive(Clone, Copy, Debug)]
pub struct RayRenderer<E> {
    /// Estimator of the radiance along a ray.
    pub estimator: E,
    /// Sampling settings.
    pub sampling: Sampling,
}

impl<E: Estimator> Renderer for RayRenderer<E> {
    fn samples_per_replication(&self) -> u32 {
        self.sampling.samples_per_replication()
    }
    fn prepare<'a>(
        &'a self,
        scene: &'a Scene,
        resolution: [u32; 2],
    ) -> Result<Box<dyn PreparedRenderer + 'a>, Error> {
        let (estimator, sampling) = (&self.estimator, self.sampling);
        let prepared = PreparedRayRenderer::new(scene, estimator, sampling, resolution);
        Ok(Box::new(prepared))
    }
}

/// A ray renderer prepared for a scene.
struct PreparedRayRenderer<'a> {
    scene: &'a Scene,
    estimator: &'a dyn Estimator,
    sampling: Sampling,
    silhouettes: Silhouettes,
}

impl<'a> PreparedRayRenderer<'a> {
    fn new(
        scene: &'a Scene,
        estimator: &'a dyn Estimator,
        sampling: Sampling,
        resolution: [u32; 2],
    ) -> Self {
        let silhouettes =
            Silhouettes::new(scene, resolution, sampling, estimator.sees_in_mirrors());
        Self {
            scene,
            estimator,
            sampling,
            silhouettes,
        }
    }

    /// Adds the missing replications of some pixels: first the radiance along all camera rays, then
    /// the points of silhouettes.
    fn add_samples(&self, resolution: [u32; 2], runs: &mut [PixelRun<'_>]) -> Result<(), Error> {
        let (scene, sampling, silhouettes) = (self.scene, self.sampling, &self.silhouettes);
        let camera_ray = |[x, y]: [u32; 2], [u, v]: [f64; 2]| {
            let ray = scene
                .camera()
                .ray(resolution, f64::from(x) + u, f64::from(y) + v);
            (ray, scene.intersect(&ray))
        };
        let located = |[x, y]: [u32; 2], replication: u32, error: Error| {
            error.at(|| format!(" at pixel ({x}, {y}), replication {replication}"))
        };
        let (mut places, mut pixels, mut names) = (Vec::new(), Vec::new(), Vec::new());
        // For each replication that lacks samples, the sum of those that it has begun with.
        let mut sums = Vec::new();
        for run in runs {
            let [x, y] = run.corner;
            for (column, &samples) in run.counts.iter().enumerate() {
                let place = [x + column as u32, y];
                for replication in run.replications.clone() {
                    let (begun, sum) = run.begun(column, replication);
                    if begun == samples {
                        run.pixels[column]
                            .push(sum / f64::from(samples), samples)
                            .map_err(|error| located(place, replication, error))?;
                        continue;
                    }
                    let name = |index| -> SampleIndex { (places.len(), replication, index) };
                    names.extend((begun..samples).map(name));
                    sums.push(sum);
                }
                places.push((place, run.sampling(column, sampling), samples));
            }
            pixels.extend(run.pixels.iter_mut());
        }
        let error_of = |(i, replication, _): SampleIndex, error: Error| {
            located(places[i].0, replication, error)
        };
        let points_of = |(i, replication, index): SampleIndex| {
            let [x, y] = places[i].0;
            silhouettes.points(y * resolution[0] + x, replication, index)
        };
        let mut refused = None;
        // For each sample, the weight of its radiance, and the emission seen along its ray.
        let mut views = Vec::new();
        let mut samples = names.iter().map(|&name| {
            let (i, replication, index) = name;
            let ([x, y], sampling, _) = places[i];
            let mut rng = sampling.source(y * resolution[0] + x, replication, index);
            let cell = index % sampling.pixel.samples_per_replication();
            let (ray, hit) = camera_ray([x, y], sampling.pixel.position(cell, uniform2(&mut rng)));
            if let Some(hit) = &hit
                && let Err(error) = pixels[i].push_features(&features_of(scene, &ray, hit))
            {
                refused = refused.take().or(Some(error_of(name, error)));
            }
            let view = silhouettes.view(scene, ray, hit);
            views.push((view.weight, view.emitted(scene)));
            Sample {
                ray: view.ray,
                hit: view.hit,
                rng,
            }
        });
        let radiances = self.estimator.radiances(scene, &mut samples);
        if let Some(error) = refused {
            return Err(error);
        }
        let mut sums = sums.into_iter();
        let mut sum = sums.next().unwrap_or_default();
        for (name, ((weight, emission), radiance)) in
            names.iter().copied().zip(views.into_iter().zip(radiances))
        {
            let mut radiance = weight * radiance;
            let (i, _, index) = name;
            let (at, _, samples) = places[i];
            if let Some(points) = points_of(name) {
                let visible = points.map(|point| {
                    let (ray, hit) = camera_ray(at, point);
                    silhouettes.view(scene, ray, hit).emitted(scene)
                });
                radiance = with_supersampled_emission(radiance, emission, visible);
            }
            // Checked here, as the mean of several could hide an invalid one.
            check_radiance(radiance).map_err(|error| error_of(name, error))?;
            sum += radiance;
            if index + 1 == samples {
                pixels[i]
                    .push(sum / f64::from(samples), samples)
                    .map_err(|error| error_of(name, error))?;
                sum = sums.next().unwrap_or_default();
            }
        }
        Ok(())
    }
}

impl PreparedRenderer for PreparedRayRenderer<'_> {
    fn add(
        &self,
        film: &mut Film,
        range: Range<u32>,
        progress: Progress<'_>,
    ) -> Result<bool, Error> {
        let (resolution, batch_size) = (film.resolution(), self.estimator.batch_size());
        let add = |runs: &mut [PixelRun<'_>]| self.add_samples(resolution, runs);
        for_each_run(self.sampling, batch_size, film, &range, progress, add)
    }
}
