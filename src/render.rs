//! The loop over pixels, replications and samples.

mod by_lanes;

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Error;
use crate::estimator::{Estimator, ImageEstimator};
use crate::film::{Begun, Features, Film, Pixel, check_radiance};
use crate::lanes::Walks;
use crate::outline::{Outlines, POINTS, replaced};
use crate::pixel::PixelSampling;
use crate::rng::{stream, uniform2};
use crate::sampler::{LONGEST, Pass, Sampler, Source};
use crate::scene::{Hit, Scene};
use crate::shape::Ray;

pub use crate::sampler::Numbers;
pub use by_lanes::{
    ByLanes, LaneEstimator, OneRayPerHit, Precision, SINGLE_DETAIL, SINGLE_EXTENTS, check_singles, lanes_serve,
    render_lanes,
};

/// What, besides scene and estimator, decides every sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampling {
    /// Where in a pixel the rays go.
    pub pixel: PixelSampling,
    /// Where the random numbers come from.
    pub numbers: Numbers,
    /// The master seed.
    pub seed: u64,
    /// Whether more points tell what emitters show directly or in mirrors where their outlines cross a pixel, as
    /// [`outline`](crate::outline) says; for samples anywhere in a pixel.
    pub outlines: bool,
}

/// Called, from any thread, with a number of samples that are done; false to stop. What was stopped goes on by the same
/// call: pixels that have more replications than others got them by it.
pub type Progress<'a> = &'a (dyn Fn(u64) -> bool + Sync);

impl Sampling {
    /// How many samples one replication has: the smallest number that is independent of the next.
    pub fn samples_per_replication(&self) -> u32 {
        self.pixel.samples_per_replication().saturating_mul(self.numbers.samples())
    }

    /// The same with another number of samples in a replication; of independent numbers it is always one.
    pub(crate) fn with_samples(self, samples: u32) -> Self {
        match self.numbers {
            Numbers::Independent => self,
            Numbers::Sobol(_) => {
                Self { numbers: Numbers::Sobol(samples / self.pixel.samples_per_replication()), ..self }
            }
        }
    }

    /// What sample `index` of a replication of a pixel draws from.
    #[inline]
    pub(crate) fn source(&self, pixel: u32, replication: u32, index: u32) -> Source {
        let samples = self.samples_per_replication();
        let numbers = match self.numbers {
            Numbers::Independent => Numbers::Independent,
            // One sequence for all positions of the pixel.
            Numbers::Sobol(_) => Numbers::Sobol(samples),
        };
        Pass { numbers, seed: self.seed, index: replication * samples + index }.pixel(pixel)
    }

    /// Refuses what the numbers of samples cannot name, and films of others.
    ///
    /// # Errors
    /// [`Error::Option`] for replications without samples, with more than [`LONGEST`] Sobol' points, or so
    /// many up to `replications` that their samples have no 32-bit numbers, or not as many as the film says; for numbers
    /// of each pixel's own, but by Sobol' points without sub-pixels.
    fn check(&self, replications: u32, film: &Film) -> Result<(), Error> {
        let own = self.samples_per_replication();
        let counts = film.sample_counts().unwrap_or(&[]).iter().copied().chain([own]);
        let (fewest, samples) = counts.fold((own, own), |(low, high), n| (low.min(n), high.max(n)));
        let refuse = |why: String| Err(Error::Option(format!("{samples} samples in a replication: {why}")));
        if film.sample_counts().is_some()
            && (self.numbers == Numbers::Independent || self.pixel.samples_per_replication() != 1)
        {
            return refuse("pixels may differ in them only by Sobol' points without sub-pixels".to_owned());
        }
        if fewest == 0 {
            return refuse("at least 1 is needed".to_owned());
        }
        if matches!(self.numbers, Numbers::Sobol(_)) && samples > LONGEST {
            return refuse(format!("a scramble has at most {LONGEST} points"));
        }
        if samples.checked_mul(replications).is_none() {
            return refuse(format!("with {replications} replications they are more than {}", u32::MAX));
        }
        if self.outlines && matches!(self.pixel, PixelSampling::Centre | PixelSampling::Grid(_)) {
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
}

/// Adds the replications `range` to every pixel of the film.
///
/// Sample k of pixel (x, y) of the full frame draws from the stream (seed, pixel, k) and sums are
/// exact, so neither threads nor the order or division of the ranges change the result.
///
/// `done` is called after each row, or each [`UNINTERRUPTED`] samples of it, with their number, from any thread; when it
/// returns false, the rest is left out and `Ok(false)` is returned: see [`Progress`].
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
    let frame = film.frame();
    let outlines = Outlines::new(scene, frame, sampling, estimator.sees_in_mirrors());
    each_row(sampling, film, range, done, |[first, y], range, row, counts| {
        for ((pixel, x), &samples) in row.iter_mut().zip(first..).zip(counts) {
            let sampling = sampling.with_samples(samples);
            for replication in range.clone() {
                let position = PixelPosition { frame, x, y, replication };
                add_replication((scene, estimator), (sampling, &outlines), position, pixel)
                    .map_err(|error| error.at(|| format!(" at pixel ({x}, {y}), replication {replication}")))?;
            }
        }
        Ok(())
    })
}

/// About the most samples that a thread takes between two calls of [`Progress`], but never less than a replication of a
/// pixel.
pub const UNINTERRUPTED: u32 = 1 << 14;

/// Calls `add` with pieces of the rows of the film's window: where the first pixel is, which replications are missing,
/// the pixels, and how many samples a replication of each has.
fn each_row(
    sampling: Sampling,
    film: &mut Film,
    range: &Range<u32>,
    done: Progress<'_>,
    add: impl Fn([u32; 2], &Range<u32>, &mut [Pixel], &[u32]) -> Result<(), Error> + Sync,
) -> Result<bool, Error> {
    sampling.check(range.end, film)?;
    let window = film.window();
    let width = window.size[0] as usize;
    let least = film.replications();
    let per_replication = sampling.samples_per_replication();
    let of_pixel = u64::from(range.end - range.start) * u64::from(per_replication);
    let at_once = (u64::from(UNINTERRUPTED) / of_pixel.max(1)).max(1) as usize;
    let stopped = AtomicBool::new(false);
    let (pixels, counts) = film.pixels_and_counts_mut();
    let alike = vec![per_replication; width];
    pixels.par_chunks_mut(width).enumerate().try_for_each(|(at, row)| {
        let mut counts = counts.map_or(&*alike, |counts| &counts[at * width..(at + 1) * width]);
        let (mut x, y) = (window.corner[0], window.corner[1] + at as u32);
        let same = |a: &Pixel, b: &Pixel| a.replications() == b.replications();
        for piece in row.chunks_mut(at_once).flat_map(|piece| piece.chunk_by_mut(same)) {
            let had = range.start.saturating_add(piece[0].replications() - least);
            let missing = had.min(range.end)..range.end;
            let (own, others) = counts.split_at(piece.len());
            if !missing.is_empty() && !stopped.load(Ordering::Relaxed) {
                add([x, y], &missing, piece, own)?;
                let samples: u64 = own.iter().copied().map(u64::from).sum();
                if !done(samples * u64::from(missing.end - missing.start)) {
                    stopped.store(true, Ordering::Relaxed);
                }
            }
            counts = others;
            x += piece.len() as u32;
        }
        Ok(())
    })?;
    Ok(!stopped.into_inner())
}

/// Which replication of which pixel.
#[derive(Clone, Copy)]
struct PixelPosition {
    frame: [u32; 2],
    x: u32,
    y: u32,
    replication: u32,
}

#[inline]
fn add_replication<E: Estimator>(
    of: (&Scene, &E),
    (sampling, outlines): (Sampling, &Outlines),
    PixelPosition { frame, x, y, replication }: PixelPosition,
    pixel: &mut Pixel,
) -> Result<(), Error> {
    let samples = sampling.samples_per_replication();
    let here = y * frame[0] + x;
    let mut sum = DVec3::ZERO;
    for index in 0..samples {
        let mut rng = sampling.source(here, replication, index);
        let cell = index % sampling.pixel.samples_per_replication();
        let offset = sampling.pixel.position(cell, uniform2(&mut rng));
        let more = outlines.points(here, replication, index);
        sum += sample(of, (frame, [x, y].map(f64::from), offset), (outlines, more), pixel, &mut rng)?;
    }
    pixel.push(sum / f64::from(samples), samples)
}

/// One estimate of the radiance that arrives through a point of a pixel, and through `more` of them if an outline
/// crosses it.
#[inline]
fn sample<E: Estimator, R: Sampler>(
    (scene, estimator): (&Scene, &E),
    (frame, corner, offset): ([u32; 2], [f64; 2], [f64; 2]),
    (outlines, more): (&Outlines, Option<[[f64; 2]; POINTS]>),
    pixel: &mut Pixel,
    rng: &mut R,
) -> Result<DVec3, Error> {
    let (ray, hit) = look(scene, (frame, corner, offset), pixel)?;
    let view = outlines.view(scene, ray, hit);
    let mut radiance = view.weight * estimator.radiance(scene, &view.ray, view.hit, rng);
    if let Some(points) = more {
        let others = points.map(|[x, y]| {
            let ray = scene.camera().ray(frame, corner[0] + x, corner[1] + y);
            outlines.view(scene, ray, scene.intersect(&ray)).emitted(scene)
        });
        radiance = replaced(radiance, view.emitted(scene), others);
    }
    // Here, for the mean of several can hide one.
    check_radiance(radiance)?;
    Ok(radiance)
}

/// The ray through a point of a pixel and what it meets, whose features the pixel takes.
#[inline]
fn look(
    scene: &Scene,
    (frame, corner, offset): ([u32; 2], [f64; 2], [f64; 2]),
    pixel: &mut Pixel,
) -> Result<(Ray, Option<Hit>), Error> {
    let ray = scene.camera().ray(frame, corner[0] + offset[0], corner[1] + offset[1]);
    let hit = scene.intersect(&ray);
    if let Some(hit) = &hit {
        pixel.push_features(&features_of(scene, &ray, hit))?;
    }
    Ok((ray, hit))
}

/// The features of what a camera ray has hit.
fn features_of(scene: &Scene, ray: &Ray, hit: &Hit) -> Features {
    features(scene.surface(hit).bsdf.albedo(), hit.normal, hit.t, ray.direction)
}

/// The features of what is seen through these points of the frame, eight at a time in `lanes` if there are any.
fn features_at(
    (scene, lanes): (&Scene, Option<&Walks<'_>>),
    frame: [u32; 2],
    points: &[[f64; 2]],
) -> Vec<Option<Features>> {
    if let Some(lanes) = lanes {
        return lanes.features(frame, points);
    }
    let camera_ray = |&[x, y]: &[f64; 2]| scene.camera().ray(frame, x, y);
    points.iter().map(camera_ray).map(|ray| Some(features_of(scene, &ray, &scene.intersect(&ray)?))).collect()
}

/// Adds the replications `range` of an image estimator to a film of the full frame. A replication is one pass, or the
/// mean of as many as a scramble has points. Albedo, normal and depth are those of one camera ray per pixel and pass,
/// the one that [`render`] sends for [`PixelSampling::Random`] and [`Numbers::Independent`], whatever rays the estimator
/// sends itself. `pass_done` is called after each pass with its number of pixels; when it returns false, the
/// remaining passes are left out and `Ok(false)` is returned: the film keeps those of a replication that is begun, with
/// which the next call goes on.
///
/// # Errors
/// [`Error::Option`] for a film that is a part of its frame, and as for [`render`]; what the estimator refuses;
/// [`Error::Radiance`] with the pixel and the pass for what no film can hold.
pub fn render_passes<E: ImageEstimator>(
    scene: &Scene,
    estimator: &E,
    (numbers, seed): (Numbers, u64),
    film: &mut Film,
    range: Range<u32>,
    pass_done: &dyn Fn(u64) -> bool,
) -> Result<bool, Error> {
    let frame = film.frame();
    if film.size() != frame {
        return Err(Error::Option(
            "an estimator of whole images cannot render a window: take the full frame".to_owned(),
        ));
    }
    let sampling = Sampling { pixel: PixelSampling::Random, numbers, seed, outlines: false };
    sampling.check(range.end, film)?;
    let samples = sampling.samples_per_replication();
    let lanes = Walks::new(scene);
    let width = frame[0] as usize;
    for replication in range {
        let begun = film.begun.take();
        let Begun { passes: done, mut sums } =
            begun.unwrap_or_else(|| Begun { passes: 0, sums: vec![DVec3::ZERO; film.pixels().len()] });
        let passes = replication * samples..(replication + 1) * samples;
        for index in passes.clone().skip(done as usize) {
            let image = estimator.image(scene, frame, Pass { numbers, seed, index })?;
            let sums_and_values = sums.par_chunks_mut(width).zip_eq(image.par_chunks(width));
            let rows = film.pixels_mut().par_chunks_mut(width).zip_eq(sums_and_values).enumerate();
            rows.try_for_each(|(y, (pixels, (sums, values)))| {
                let point = |x: u32| {
                    let random = uniform2(&mut stream(seed, y as u32 * frame[0] + x, index));
                    let offset = PixelSampling::Random.position(0, random);
                    [f64::from(x) + offset[0], y as f64 + offset[1]]
                };
                let points: Vec<_> = (0..frame[0]).map(point).collect();
                let seen = features_at((scene, lanes.as_ref()), frame, &points);
                for (x, (((pixel, sum), value), seen)) in pixels.iter_mut().zip(sums).zip(values).zip(seen).enumerate()
                {
                    if let Some(features) = &seen {
                        pixel.push_features(features)?;
                    }
                    *sum += value;
                    check_radiance(*value)
                        .map_err(|error| error.at(|| format!(" at pixel ({x}, {y}), pass {index}")))?;
                    if index + 1 == passes.end {
                        pixel.push(*sum / f64::from(samples), samples)?;
                    }
                }
                Ok(())
            })?;
            if !pass_done(image.len() as u64) {
                if index + 1 < passes.end {
                    film.begun = Some(Begun { passes: index + 1 - passes.start, sums });
                }
                return Ok(false);
            }
        }
    }
    Ok(true)
}

/// What adds replications to films, whichever kind of estimator makes them.
pub trait Renderer {
    /// How many samples one replication has.
    fn samples_per_replication(&self) -> u32;
    /// Adds the replications `range` to every pixel of the film, as [`render`] and [`render_passes`] do.
    ///
    /// # Errors
    /// Those of [`render`] or [`render_passes`].
    fn add(&self, scene: &Scene, film: &mut Film, range: Range<u32>, done: Progress<'_>) -> Result<bool, Error>;
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
    fn add(&self, scene: &Scene, film: &mut Film, range: Range<u32>, done: Progress<'_>) -> Result<bool, Error> {
        render(scene, &self.estimator, self.sampling, film, &range, done)
    }
}

/// Renders by whole images.
#[derive(Clone, Copy, Debug)]
pub struct ByPasses<E> {
    /// What a pass brings.
    pub estimator: E,
    /// Where the random numbers come from.
    pub numbers: Numbers,
    /// The master seed.
    pub seed: u64,
}

impl<E: ImageEstimator> Renderer for ByPasses<E> {
    fn samples_per_replication(&self) -> u32 {
        self.numbers.samples()
    }
    fn add(&self, scene: &Scene, film: &mut Film, range: Range<u32>, done: Progress<'_>) -> Result<bool, Error> {
        render_passes(scene, &self.estimator, (self.numbers, self.seed), film, range, done)
    }
}

/// The features of a hit whose surface has this albedo and this normal of its front, along a ray of this direction.
#[inline]
pub(crate) fn features(albedo: DVec3, normal: DVec3, depth: f64, direction: DVec3) -> Features {
    Features { albedo, normal: normal * -normal.dot(direction).signum(), depth }
}
