//! Rendering of pixel rows in lanes: assigns samples to lanes and adds their radiance to pixels.

use std::array::from_fn;

use glam::DVec3;

use super::PixelRun;
use super::silhouette::{MIRRORS, POINTS, Silhouettes, with_supersampled_emission};
use crate::error::Error;
use crate::film::check_radiance;
use crate::geometry::shape::Ray;
use crate::integrator::{
    Arrival, Integrator, Path, PathState, Report, SurfaceInteraction, Whitted,
};
use crate::math::real::{Mask, Vector};
use crate::math::simd::{Wide, lanes_of};
use crate::sampling::Sampling;
use crate::sampling::lanes::{LaneSampler, LaneSobol, LaneStreams, PixelSampler, SampleId};
use crate::sampling::pixel::PixelSampling;
use crate::sampling::sampler::SamplerKind;
use crate::scene::lanes::{IntersectionScratch, LaneScene};

/// An estimator that traces several paths at a time, with standard parts.
#[derive(Clone, Copy, Debug)]
pub enum LaneEstimator {
    /// The path tracer.
    Path(Path),
    /// The report's path tracer.
    Report(Report),
    /// Whitted ray tracing.
    Whitted(Whitted),
}

/// State of the replication that a lane computes.
#[derive(Clone, Copy, Default)]
struct Work {
    /// Column of its pixel in the row.
    column: usize,
    sample: SampleId,
    /// Sum of the radiances of its finished samples.
    sum: DVec3,
    /// Radiance of an emitter seen by the camera ray, directly or through mirrors.
    own: DVec3,
    /// Product of the reflectances of the mirrors that the camera ray has followed, and their
    /// number, as in [`MirroredRay`](crate::render::silhouette::MirroredRay).
    weight: DVec3,
    mirrors: u32,
}

impl Work {
    /// Adds this replication and its pixel to an error; the row starts at `corner` of the frame.
    fn place(&self, corner: [u32; 2], error: Error) -> Error {
        let (x, y) = (corner[0] + self.column as u32, corner[1]);
        error.at(|| {
            format!(
                " at pixel ({x}, {y}), replication {}",
                self.sample.replication
            )
        })
    }
}

/// Renders rows of pixels with an estimator in a scene.
pub(crate) struct RowRenderer<'a, R: Wide<N>, const N: usize> {
    pub scene: LaneScene<'a, R, N>,
    pub estimator: LaneEstimator,
    pub sampling: Sampling,
    pub frame: [u32; 2],
    pub silhouettes: Silhouettes,
}

impl<R: Wide<N>, const N: usize> RowRenderer<'_, R, N> {
    /// Adds the missing replications to the pixels of a piece.
    pub fn add(&self, piece: &mut PixelRun<'_>) -> Result<(), Error> {
        match &self.estimator {
            LaneEstimator::Path(path) => self.add_by(path, piece),
            LaneEstimator::Report(report) => self.add_by(report, piece),
            LaneEstimator::Whitted(whitted) => self.add_by(whitted, piece),
        }
    }

    fn add_by<E: Integrator>(&self, estimator: &E, piece: &mut PixelRun<'_>) -> Result<(), Error> {
        match self.sampling.numbers {
            SamplerKind::Independent => row::<E, R, LaneStreams<N>, N>(self, estimator, piece),
            SamplerKind::Sobol(_) => row::<E, R, LaneSobol<N>, N>(self, estimator, piece),
        }
    }
}

/// Adds the missing replications to the pixels of a piece with one kind of estimator and sampler.
fn row<E: Integrator, R: Wide<N>, S: PixelSampler<R>, const N: usize>(
    renderer: &RowRenderer<'_, R, N>,
    estimator: &E,
    PixelRun {
        corner,
        missing,
        pixels,
        counts,
    }: &mut PixelRun<'_>,
) -> Result<(), Error> {
    let (corner, columns) = (*corner, pixels.len());
    let RowRenderer {
        scene,
        sampling,
        frame,
        silhouettes,
        ..
    } = renderer;
    let (scene, frame) = (*scene, *frame);
    let mut next = (0..columns).flat_map(|column| {
        missing
            .clone()
            .map(move |replication| (column, replication))
    });
    let mut random = S::new(sampling.seed);
    let mut work = [Work::default(); N];
    let mut paths: PathState<R, N> = PathState::new();
    let mut scratch = IntersectionScratch::new();
    // Bits of the lanes that need a replication, that start a sample, and whose path is under way.
    let (mut idle, mut fresh, mut busy) = (u32::MAX >> (32 - N), 0_u32, 0_u32);
    loop {
        for lane in lanes_of(idle) {
            if let Some((column, replication)) = next.next() {
                let pixel = corner[1] * frame[0] + corner[0] + column as u32;
                let sample = SampleId {
                    pixel,
                    replication,
                    index: 0,
                };
                work[lane] = Work {
                    column,
                    sample,
                    ..Work::default()
                };
                idle &= !(1 << lane);
                fresh |= 1 << lane;
            }
        }
        if fresh != 0 {
            for lane in lanes_of(fresh) {
                let Work { column, sample, .. } = work[lane];
                random.start(lane, &sampling.with_samples(counts[column]), sample);
                (work[lane].own, work[lane].weight, work[lane].mirrors) =
                    (DVec3::ZERO, DVec3::ONE, 0);
            }
            let starting = R::Mask::from_bits(fresh);
            LaneSampler::<R>::start_blocks(&mut random, starting, &[0; N]);
            let ray = renderer.camera_rays(corner, &work, starting, &mut random);
            paths.start(&ray, starting);
            busy |= fresh;
            fresh = 0;
        }
        if busy == 0 {
            return Ok(());
        }
        let found = scene.closest(&paths.ray, R::Mask::from_bits(busy), &mut scratch);
        let hit_bits = found.hit_mask.bits();
        let mut ended = busy & !hit_bits;
        estimator.escape(scene.scene, &mut paths, R::Mask::from_bits(ended));
        if hit_bits != 0 {
            let surface = SurfaceInteraction::new(scene, &paths.ray, &found);
            let mirrors = if silhouettes.in_mirrors {
                surface.dark_mirror().bits()
            } else {
                0
            };
            let mut followed = 0;
            let (shining, backs) = (surface.shows_emitter().bits(), surface.backs());
            let first = hit_bits & R::Mask::from_fn(|i| paths.hits[i] == 0).bits();
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
                *hits += (hit_bits & !followed) >> lane & 1;
            }
            let follows = R::Mask::from_bits(followed);
            if followed != 0 {
                let throughput = paths.throughput;
                paths.continue_with(&surface, surface.mirrored(), throughput, follows);
            }
            let (paths, active) = (&mut paths, found.hit_mask & !follows);
            let (surface, random, scratch) = (&surface, &mut random, &mut scratch);
            let goes_on = estimator.interact(Arrival {
                scene,
                paths,
                surface,
                active,
                random,
                scratch,
            });
            ended = busy & !goes_on.bits() & !followed;
        }
        ended &= !paths.pop_branches(ended);
        busy &= !ended;
        let radiances = paths.radiance.components().map(R::lanes);
        for lane in lanes_of(ended) {
            let work = &mut work[lane];
            let mut radiance =
                work.weight * DVec3::from_array(radiances.map(|channel| channel[lane].into()));
            let SampleId {
                pixel,
                replication,
                index,
            } = work.sample;
            if let Some(points) = silhouettes.points(pixel, replication, index) {
                let first = [corner[0] + work.column as u32, corner[1]];
                let shown = renderer.shown(first, points, &mut scratch);
                radiance = with_supersampled_emission(radiance, work.own, shown);
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

impl<R: Wide<N>, const N: usize> RowRenderer<'_, R, N> {
    /// Returns the emitted radiance seen through these points of a pixel.
    fn shown(
        &self,
        pixel: [u32; 2],
        points: [[f64; 2]; POINTS],
        scratch: &mut IntersectionScratch<R, N>,
    ) -> [DVec3; POINTS] {
        let (scene, frame) = (self.scene, self.frame);
        let [x, y] =
            from_fn(|axis| R::from_lanes(|i| f64::from(pixel[axis]) + points[i % POINTS][axis]));
        let mut ray = scene.scene.camera().ray(frame, x, y);
        let (mut shown, mut weights) = ([DVec3::ZERO; POINTS], [DVec3::ONE; POINTS]);
        let mut looking = R::Mask::from_fn(|i| i < POINTS);
        for mirror in 0..=MIRRORS {
            let found = scene.closest(&ray, looking, scratch);
            if !found.hit_mask.any() {
                break;
            }
            let surface = SurfaceInteraction::new(scene, &ray, &found);
            let follows = self.silhouettes.in_mirrors && mirror < MIRRORS;
            looking = if follows {
                found.hit_mask & surface.dark_mirror()
            } else {
                R::Mask::splat(false)
            };
            let shining = surface.shows_emitter().bits();
            for lane in lanes_of(found.hit_mask.bits()) {
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

    /// Generates the camera rays of samples that start in the lanes of the mask.
    fn camera_rays<S: PixelSampler<R>>(
        &self,
        corner: [u32; 2],
        work: &[Work; N],
        starting: R::Mask,
        random: &mut S,
    ) -> Ray<R::Vector> {
        let sampling = &self.sampling;
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
        self.scene.scene.camera().ray(self.frame, x, y)
    }
}
