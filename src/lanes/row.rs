//! Rows of pixels in lanes: which sample each lane follows, and what becomes of its radiance.

use std::array::from_fn;
use std::ops::Range;

use glam::DVec3;

use super::PixelsAndCounts;
use super::interaction::SurfaceInteraction;
use super::lanes_of;
use super::samples::{LaneSampler, PixelSampler, SampleName};
use super::scene::{IntersectionScratch, LaneScene};
use super::state::{Integrator, PathState};
use crate::error::Error;
use crate::film::check_radiance;
use crate::outline::{MIRRORS, Outlines, POINTS, replaced};
use crate::pixel::PixelSampling;
use crate::real::{Mask, Vector, Wide};
use crate::render::Sampling;
use crate::scene::Scene;
use crate::shape::Ray;

/// A replication in a lane.
#[derive(Clone, Copy, Default)]
struct Work {
    /// Its pixel in the row.
    column: usize,
    sample: SampleName,
    /// The radiance of the samples that are done.
    sum: DVec3,
    /// What an emitter has shown to the camera ray, directly or in mirrors.
    own: DVec3,
    /// Of [`View`](crate::outline::View), as the next.
    weight: DVec3,
    mirrors: u32,
}

impl Work {
    /// An error of this replication, with its place in a row that starts at `corner` of the frame.
    fn place(&self, corner: [u32; 2], error: Error) -> Error {
        let (x, y) = (corner[0] + self.column as u32, corner[1]);
        error.at(|| format!(" at pixel ({x}, {y}), replication {}", self.sample.replication))
    }
}

/// A row of pixels: the replications `range` of each of them.
pub(super) fn row<E: Integrator, R: Wide<N>, S: PixelSampler<R>, const N: usize>(
    (scene, estimator): (LaneScene<'_, R, N>, &E),
    (sampling, outlines): (&Sampling, &Outlines),
    (frame, corner): ([u32; 2], [u32; 2]),
    range: &Range<u32>,
    (pixels, counts): PixelsAndCounts<'_>,
) -> Result<(), Error> {
    let columns = pixels.len();
    let mut next = (0..columns).flat_map(|column| range.clone().map(move |replication| (column, replication)));
    let mut random = S::new(sampling.seed);
    let mut work = [Work::default(); N];
    let mut paths: PathState<R, N> = PathState::new();
    let mut scratch = IntersectionScratch::new();
    // A bit for each lane: those that need a replication, that start a sample, and that are on their way.
    let (mut idle, mut fresh, mut busy) = (u32::MAX >> (32 - N), 0_u32, 0_u32);
    loop {
        for lane in lanes_of(idle) {
            if let Some((column, replication)) = next.next() {
                let pixel = corner[1] * frame[0] + corner[0] + column as u32;
                let sample = SampleName { pixel, replication, index: 0 };
                work[lane] = Work { column, sample, ..Work::default() };
                idle &= !(1 << lane);
                fresh |= 1 << lane;
            }
        }
        if fresh != 0 {
            for lane in lanes_of(fresh) {
                let Work { column, sample, .. } = work[lane];
                random.start(lane, &sampling.with_samples(counts[column]), sample);
                (work[lane].own, work[lane].weight, work[lane].mirrors) = (DVec3::ZERO, DVec3::ONE, 0);
            }
            let starting = R::Mask::from_bits(fresh);
            LaneSampler::<R>::start_blocks(&mut random, starting, &[0; N]);
            let ray = camera_rays(scene.scene, sampling, (frame, corner), &work, starting, &mut random);
            paths.start(&ray, starting);
            busy |= fresh;
            fresh = 0;
        }
        if busy == 0 {
            return Ok(());
        }
        let found = scene.closest(&paths.ray, R::Mask::from_bits(busy), &mut scratch);
        let met = found.met.bits();
        let mut ended = busy & !met;
        estimator.escape(scene.scene, &mut paths, R::Mask::from_bits(ended));
        if met != 0 {
            let surface = SurfaceInteraction::new(scene, &paths.ray, &found);
            let mirrors = if outlines.in_mirrors { surface.dark_mirror().bits() } else { 0 };
            let mut followed = 0;
            let (shining, backs) = (surface.shows_emitter().bits(), surface.backs());
            let first = met & R::Mask::from_fn(|i| paths.hits[i] == 0).bits();
            for lane in lanes_of(first) {
                let work = &mut work[lane];
                if work.mirrors == 0 {
                    let pushed = surface.push_features(lane, backs, &mut pixels[work.column]);
                    pushed.map_err(|error| work.place(corner, error))?;
                }
                if mirrors >> lane & 1 == 1 && work.mirrors < MIRRORS {
                    work.weight *= surface.reflectance(lane);
                    work.mirrors += 1;
                    followed |= 1 << lane;
                } else if shining >> lane & 1 == 1 {
                    work.own = work.weight * surface.emitter_radiance(lane);
                }
            }
            for (lane, hits) in paths.hits.iter_mut().enumerate() {
                *hits += (met & !followed) >> lane & 1;
            }
            let follows = R::Mask::from_bits(followed);
            if followed != 0 {
                let throughput = paths.throughput;
                paths.send(&surface, (surface.mirrored(), throughput), follows);
            }
            let active = found.met & !follows;
            let goes_on = estimator.interact(scene, &mut paths, &surface, active, &mut random, &mut scratch);
            ended = busy & !goes_on.bits() & !followed;
        }
        ended &= !paths.pop_branches(ended);
        busy &= !ended;
        let radiances = paths.radiance.components().map(R::lanes);
        for lane in lanes_of(ended) {
            let work = &mut work[lane];
            let mut radiance = work.weight * DVec3::from_array(radiances.map(|channel| channel[lane].into()));
            let SampleName { pixel, replication, index } = work.sample;
            if let Some(points) = outlines.points(pixel, replication, index) {
                let first = [corner[0] + work.column as u32, corner[1]];
                let shown = shown(scene, (frame, first), (points, outlines.in_mirrors), &mut scratch);
                radiance = replaced(radiance, work.own, shown);
            }
            check_radiance(radiance).map_err(|error| work.place(corner, error))?;
            work.sum += radiance;
            work.sample.index += 1;
            let samples = counts[work.column];
            if work.sample.index < samples {
                fresh |= 1 << lane;
            } else {
                let pushed = pixels[work.column].push(work.sum / f64::from(samples), samples);
                pushed.map_err(|error| work.place(corner, error))?;
                idle |= 1 << lane;
            }
        }
    }
}

/// What emitters show through these points of a pixel.
fn shown<R: Wide<N>, const N: usize>(
    scene: LaneScene<'_, R, N>,
    (frame, pixel): ([u32; 2], [u32; 2]),
    (points, in_mirrors): ([[f64; 2]; POINTS], bool),
    scratch: &mut IntersectionScratch<R, N>,
) -> [DVec3; POINTS] {
    let [x, y] = from_fn(|axis| R::from_lanes(|i| f64::from(pixel[axis]) + points[i % POINTS][axis]));
    let mut ray = scene.scene.camera().ray(frame, x, y);
    let (mut shown, mut weights) = ([DVec3::ZERO; POINTS], [DVec3::ONE; POINTS]);
    let mut looking = R::Mask::from_fn(|i| i < POINTS);
    for mirror in 0..=MIRRORS {
        let found = scene.closest(&ray, looking, scratch);
        if !found.met.any() {
            break;
        }
        let surface = SurfaceInteraction::new(scene, &ray, &found);
        let follows = in_mirrors && mirror < MIRRORS;
        looking = if follows { found.met & surface.dark_mirror() } else { R::Mask::splat(false) };
        let shining = surface.shows_emitter().bits();
        for lane in lanes_of(found.met.bits()) {
            if looking.bits() >> lane & 1 == 1 {
                weights[lane] *= surface.reflectance(lane);
            } else if shining >> lane & 1 == 1 {
                shown[lane] = weights[lane] * surface.emitter_radiance(lane);
            }
        }
        if !looking.any() {
            break;
        }
        ray = surface.spawn_ray(surface.mirrored());
    }
    shown
}

/// The camera rays of the samples that start, in the lanes of the mask.
fn camera_rays<R: Wide<N>, S: PixelSampler<R>, const N: usize>(
    scene: &Scene,
    sampling: &Sampling,
    (frame, corner): ([u32; 2], [u32; 2]),
    work: &[Work; N],
    starting: R::Mask,
    random: &mut S,
) -> Ray<R::Vector> {
    let numbers = [random.uniform(starting), random.uniform(starting)];
    let positions = if sampling.pixel == PixelSampling::Random {
        numbers
    } else {
        let positions: [[f64; 2]; N] = from_fn(|i| {
            let cell = work[i].sample.index % sampling.pixel.samples_per_replication();
            sampling.pixel.position(cell, numbers.map(|r| r.lane(i)))
        });
        [0, 1].map(|axis| R::from_lanes(|i| positions[i][axis]))
    };
    let x = R::from_lanes(|i| f64::from(corner[0] + work[i].column as u32)) + positions[0];
    let y = R::splat(f64::from(corner[1])) + positions[1];
    scene.camera().ray(frame, x, y)
}
