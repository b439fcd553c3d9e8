//! The loop over pixels, replications and samples.

pub mod adaptive;
mod by_lanes;
mod by_passes;
pub mod checkpoint;
mod row;
pub mod silhouette;

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Error;
use crate::film::{Features, Film, Pixel, check_radiance, features};
use crate::geometry::shape::{Hit, Ray};
use crate::integrator::{Estimator, PhotonMapping, Sample, Standard};
use crate::sampling::Sampling;
use crate::sampling::pixel::PixelSampling;
use crate::sampling::rng::uniform2;
use crate::sampling::sampler::{LONGEST, Numbers};
use crate::scene::Scene;
use silhouette::{Outlines, replaced};

pub use by_lanes::{
    ByLanes, Precision, SINGLE_DETAIL, SINGLE_EXTENTS, check_singles, render_lanes,
};
pub use by_passes::{ByPasses, PassEstimator, render_passes};
pub use row::LaneEstimator;

/// Called, from any thread, with a number of samples that are done; false to stop. What was stopped
/// goes on by the same call: pixels that have more replications than others got them by it.
pub type Progress<'a> = &'a (dyn Fn(u64) -> bool + Sync);

/// Refuses what the numbers of samples cannot name, and films of others.
///
/// # Errors
/// [`Error::Option`] for replications without samples, with more than [`LONGEST`] Sobol'
/// points, or so many up to `replications` that their samples have no 32-bit numbers, or not as
/// many as the film says; for numbers of each pixel's own, but by Sobol' points without
/// sub-pixels.
fn check(sampling: &Sampling, replications: u32, film: &Film) -> Result<(), Error> {
    let own = sampling.samples_per_replication();
    let counts = film
        .sample_counts()
        .unwrap_or(&[])
        .iter()
        .copied()
        .chain([own]);
    let (fewest, samples) = counts.fold((own, own), |(low, high), n| (low.min(n), high.max(n)));
    let refuse = |why: String| {
        Err(Error::Option(format!(
            "{samples} samples in a replication: {why}"
        )))
    };
    if film.sample_counts().is_some()
        && (sampling.numbers == Numbers::Independent
            || sampling.pixel.samples_per_replication() != 1)
    {
        return refuse(
            "pixels may differ in them only by Sobol' points without sub-pixels".to_owned(),
        );
    }
    if fewest == 0 {
        return refuse("at least 1 is needed".to_owned());
    }
    if matches!(sampling.numbers, Numbers::Sobol(_)) && samples > LONGEST {
        return refuse(format!("a scramble has at most {LONGEST} points"));
    }
    if samples.checked_mul(replications).is_none() {
        return refuse(format!(
            "with {replications} replications they are more than {}",
            u32::MAX
        ));
    }
    if sampling.outlines
        && matches!(
            sampling.pixel,
            PixelSampling::Centre | PixelSampling::Grid(_)
        )
    {
        return Err(Error::Option(
            "points of outlines are anywhere in a pixel, and samples must be too".to_owned(),
        ));
    }
    if film.samples_per_replication() != own {
        return Err(Error::Option(format!(
            "a film of {} samples per replication cannot take {own}",
            film.samples_per_replication()
        )));
    }
    Ok(())
}

/// Adds the replications `range` to every pixel of the film.
///
/// Sample k of pixel (x, y) of the full frame draws from the stream (seed, pixel, k) and sums are
/// exact, so neither threads nor the order or division of the ranges change the result.
///
/// `done` is called after each part of the film, of about [`Estimator::TOGETHER`] samples or less,
/// with their number, from any thread; when it returns false, the rest is left out and `Ok(false)`
/// is returned: see [`Progress`].
///
/// # Errors
/// [`Error::Radiance`] with pixel and replication if the estimator returns what no film can hold;
/// [`Error::Option`] for replications with no sample, more than 2³² in all, more Sobol' points than
/// [`LONGEST`], or not as many samples as the film says.
pub fn render<E: Estimator>(
    scene: &Scene,
    estimator: &E,
    sampling: Sampling,
    film: &mut Film,
    range: &Range<u32>,
    done: Progress<'_>,
) -> Result<bool, Error> {
    PreparedRays::new(scene, estimator, sampling, film.frame()).add(film, range.clone(), done)
}

/// About the most samples that a thread takes in lanes between two calls of [`Progress`], but never
/// less than a replication of a pixel.
pub const UNINTERRUPTED: u32 = 1 << 14;

/// Neighbouring pixels of a row which lack the same replications.
pub(crate) struct Piece<'a> {
    /// Where the first is in the frame.
    pub corner: [u32; 2],
    /// The replications.
    pub missing: Range<u32>,
    pub pixels: &'a mut [Pixel],
    /// How many samples a replication of each has.
    pub counts: &'a [u32],
}

/// Calls `add` with parts of the film's window: pieces of its rows, of about so many samples
/// `together` or less.
fn each_part(
    sampling: Sampling,
    together: u32,
    film: &mut Film,
    range: &Range<u32>,
    done: Progress<'_>,
    add: impl Fn(&mut [Piece<'_>]) -> Result<(), Error> + Sync,
) -> Result<bool, Error> {
    check(&sampling, range.end, film)?;
    let window = film.window();
    let [width, height] = window.size.map(|n| n as usize);
    let least = film.replications();
    let per_replication = sampling.samples_per_replication();
    let of_pixel = u64::from(range.end - range.start) * u64::from(per_replication);
    let at_once = (u64::from(together) / of_pixel.max(1)).max(1) as usize;
    // Some rows at once where more samples than theirs gain by it, but enough parts for all
    // threads.
    let most = height / (PARTS_PER_THREAD * rayon::current_num_threads());
    let rows = if together > UNINTERRUPTED {
        (at_once / width).min(most).max(1)
    } else {
        1
    };
    let stopped = AtomicBool::new(false);
    let (pixels, counts) = film.pixels_and_counts_mut();
    let alike = vec![per_replication; width];
    pixels
        .par_chunks_mut(width * rows)
        .enumerate()
        .try_for_each(|(band, pixels)| {
            let mut pieces = Vec::new();
            for (row, at) in pixels.chunks_mut(width).zip(band * rows..) {
                let mut counts =
                    counts.map_or(&*alike, |counts| &counts[at * width..(at + 1) * width]);
                let [mut x, y] = [window.corner[0], window.corner[1] + at as u32];
                let same = |a: &Pixel, b: &Pixel| a.replications() == b.replications();
                for pixels in row
                    .chunks_mut(at_once)
                    .flat_map(|pixels| pixels.chunk_by_mut(same))
                {
                    let had = range.start.saturating_add(pixels[0].replications() - least);
                    let missing = had.min(range.end)..range.end;
                    let (own, others) = counts.split_at(pixels.len());
                    counts = others;
                    let corner = [x, y];
                    x += pixels.len() as u32;
                    if !missing.is_empty() {
                        pieces.push(Piece {
                            corner,
                            missing,
                            pixels,
                            counts: own,
                        });
                    }
                }
            }
            let together = if rows > 1 { pieces.len() } else { 1 };
            for pieces in pieces.chunks_mut(together.max(1)) {
                if stopped.load(Ordering::Relaxed) {
                    break;
                }
                add(pieces)?;
                let of = |piece: &Piece<'_>| {
                    let samples: u64 = piece.counts.iter().copied().map(u64::from).sum();
                    samples * u64::from(piece.missing.end - piece.missing.start)
                };
                if !done(pieces.iter().map(of).sum()) {
                    stopped.store(true, Ordering::Relaxed);
                }
            }
            Ok(())
        })?;
    Ok(!stopped.into_inner())
}

/// So many parts or more are there for each thread where a part could be of several rows.
const PARTS_PER_THREAD: usize = 8;

/// Which sample: the place of its pixel in a list, the replication, and its number there.
type SampleName = (usize, u32, u32);

/// Adds the missing replications of some pixels: first the radiance along all camera rays, and with
/// it the points of outlines.
fn add_samples<E: Estimator>(
    (scene, estimator): (&Scene, &E),
    (sampling, outlines): (Sampling, &Outlines),
    frame: [u32; 2],
    pieces: &mut [Piece<'_>],
) -> Result<(), Error> {
    let camera_ray = |[x, y]: [u32; 2], [u, v]: [f64; 2]| {
        let ray = scene
            .camera()
            .ray(frame, f64::from(x) + u, f64::from(y) + v);
        (ray, scene.intersect(&ray))
    };
    let (mut places, mut pixels) = (Vec::new(), Vec::new());
    for Piece {
        corner: [x, y],
        missing,
        pixels: own,
        counts,
    } in pieces
    {
        places.extend(
            (*x..)
                .zip(*counts)
                .map(|(x, &samples)| ([x, *y], &*missing, sampling.with_samples(samples))),
        );
        pixels.extend(own.iter_mut());
    }
    let samples_of = |(i, &(_, missing, sampling)): (usize, &([u32; 2], &Range<u32>, Sampling))| {
        let samples = sampling.samples_per_replication();
        missing
            .clone()
            .flat_map(move |replication| (0..samples).map(move |index| (i, replication, index)))
    };
    let names: Vec<SampleName> = places.iter().enumerate().flat_map(samples_of).collect();
    let error_of = |(i, replication, _): SampleName, error: Error| {
        let [x, y] = places[i].0;
        error.at(|| format!(" at pixel ({x}, {y}), replication {replication}"))
    };
    let points_of = |(i, replication, index): SampleName| {
        let [x, y] = places[i].0;
        outlines.points(y * frame[0] + x, replication, index)
    };
    let mut refused = None;
    // Of each sample, what its radiance is multiplied by, and what emitters show along its ray.
    let mut views = Vec::new();
    let samples = names.iter().map(|&name| {
        let (i, replication, index) = name;
        let ([x, y], _, sampling) = places[i];
        let mut rng = sampling.source(y * frame[0] + x, replication, index);
        let cell = index % sampling.pixel.samples_per_replication();
        let (ray, hit) = camera_ray([x, y], sampling.pixel.position(cell, uniform2(&mut rng)));
        if let Some(hit) = &hit
            && let Err(error) = pixels[i].push_features(&features_of(scene, &ray, hit))
        {
            refused = refused.take().or(Some(error_of(name, error)));
        }
        let view = outlines.view(scene, ray, hit);
        views.push((view.weight, view.emitted(scene)));
        Sample {
            ray: view.ray,
            hit: view.hit,
            rng,
        }
    });
    let radiances = estimator.radiances(scene, samples);
    if let Some(error) = refused {
        return Err(error);
    }
    let mut sum = DVec3::ZERO;
    for (name, ((weight, own), radiance)) in
        names.iter().copied().zip(views.into_iter().zip(radiances))
    {
        let mut radiance = weight * radiance;
        let (i, _, index) = name;
        let (at, _, sampling) = places[i];
        if let Some(points) = points_of(name) {
            let shown = points.map(|point| {
                let (ray, hit) = camera_ray(at, point);
                outlines.view(scene, ray, hit).emitted(scene)
            });
            radiance = replaced(radiance, own, shown);
        }
        // Here, for the mean of several can hide one.
        check_radiance(radiance).map_err(|error| error_of(name, error))?;
        sum += radiance;
        let samples = sampling.samples_per_replication();
        if index + 1 == samples {
            pixels[i]
                .push(sum / f64::from(samples), samples)
                .map_err(|error| error_of(name, error))?;
            sum = DVec3::ZERO;
        }
    }
    Ok(())
}

/// The features of what a camera ray has hit.
fn features_of(scene: &Scene, ray: &Ray, hit: &Hit) -> Features {
    features(
        scene.surface(hit).bsdf.albedo(),
        hit.normal,
        hit.t,
        ray.direction,
    )
}

/// What adds replications to films, whichever kind of estimator makes them.
pub trait Renderer: Sync {
    /// How many samples one replication has.
    fn samples_per_replication(&self) -> u32;
    /// Makes what depends on the scene and on the size of the full frame (width, height) alone,
    /// once for all ranges.
    ///
    /// # Errors
    /// [`Error::Option`] for a scene that the renderer does not take.
    fn prepare<'a>(
        &'a self,
        scene: &'a Scene,
        frame: [u32; 2],
    ) -> Result<Box<dyn Prepared + 'a>, Error>;

    /// Adds the replications `range` to every pixel of the film, as [`render`] and
    /// [`render_passes`] do.
    ///
    /// # Errors
    /// Those of [`prepare`](Self::prepare) and of [`Prepared::add`].
    fn add(
        &self,
        scene: &Scene,
        film: &mut Film,
        range: Range<u32>,
        done: Progress<'_>,
    ) -> Result<bool, Error> {
        self.prepare(scene, film.frame())?.add(film, range, done)
    }
}

/// A renderer in its scene, for films of one frame.
pub trait Prepared: Sync {
    /// Adds the replications `range` to every pixel of the film, as [`render`] and
    /// [`render_passes`] do.
    ///
    /// # Errors
    /// Those of [`render`] or [`render_passes`].
    fn add(&self, film: &mut Film, range: Range<u32>, done: Progress<'_>) -> Result<bool, Error>;
}

/// Renders by single rays.
#[derive(Clone, Copy, Debug)]
pub struct ByRays<E> {
    /// What a ray brings.
    pub estimator: E,
    /// Which rays, by which random numbers.
    pub sampling: Sampling,
}

impl<E: Estimator> Renderer for ByRays<E> {
    fn samples_per_replication(&self) -> u32 {
        self.sampling.samples_per_replication()
    }
    fn prepare<'a>(
        &'a self,
        scene: &'a Scene,
        frame: [u32; 2],
    ) -> Result<Box<dyn Prepared + 'a>, Error> {
        Ok(Box::new(PreparedRays::new(
            scene,
            &self.estimator,
            self.sampling,
            frame,
        )))
    }
}

/// An estimator of single rays in its scene.
struct PreparedRays<'a, E> {
    scene: &'a Scene,
    estimator: &'a E,
    sampling: Sampling,
    outlines: Outlines,
}

impl<'a, E: Estimator> PreparedRays<'a, E> {
    fn new(scene: &'a Scene, estimator: &'a E, sampling: Sampling, frame: [u32; 2]) -> Self {
        let outlines = Outlines::new(scene, frame, sampling, estimator.sees_in_mirrors());
        Self {
            scene,
            estimator,
            sampling,
            outlines,
        }
    }
}

impl<E: Estimator> Prepared for PreparedRays<'_, E> {
    fn add(&self, film: &mut Film, range: Range<u32>, done: Progress<'_>) -> Result<bool, Error> {
        let Self {
            scene,
            estimator,
            sampling,
            outlines,
        } = self;
        let frame = film.frame();
        each_part(*sampling, E::TOGETHER, film, &range, done, |pieces| {
            add_samples((scene, *estimator), (*sampling, outlines), frame, pieces)
        })
    }
}

/// Renders by photons, looked up along single rays. Its photons are those of one map.
#[derive(Debug)]
pub struct ByPhotons {
    /// The photons.
    pub photons: PhotonMapping<Standard>,
    /// Which rays, by which random numbers.
    pub sampling: Sampling,
}

// Not [`ByRays`], whose code is compiled where it is used, and not as fast there.
impl Renderer for ByPhotons {
    fn samples_per_replication(&self) -> u32 {
        self.sampling.samples_per_replication()
    }
    fn prepare<'a>(
        &'a self,
        scene: &'a Scene,
        frame: [u32; 2],
    ) -> Result<Box<dyn Prepared + 'a>, Error> {
        Ok(Box::new(PreparedRays::new(
            scene,
            &self.photons,
            self.sampling,
            frame,
        )))
    }
}
