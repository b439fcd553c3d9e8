//! Rendering of pixel rows in lanes: assigns samples to lanes and adds their radiance to pixels.

use std::array::from_fn;

use glam::DVec3;

use super::PixelRun;
use super::silhouette::{MAX_MIRRORS, POINTS_PER_SAMPLE, Silhouettes, with_supersampled_emission};
use crate::error::Error;
use crate::film::check_radiance;
use crate::geometry::shape::Ray;
use crate::integrator::{
    Arrival, DefaultParts, Estimator, Integrator, Parts, Path, PathState, Report,
    SurfaceInteraction, Whitted,
};
use crate::math::real::{Mask, Vector};
use crate::math::simd::{Wide, lanes_of};
use crate::sampling::Sampling;
use crate::sampling::lanes::{LaneSampler, LaneSobol, LaneStreams, PixelSampler, SampleId};
use crate::sampling::pixel::PixelSampling;
use crate::sampling::sampler::SamplerKind;
use crate::scene::lanes::{IntersectionScratch, LaneScene};

/// An estimator that traces several paths at a time.
#[derive(Clone, Copy, Debug)]
pub enum LaneEstimator<'a> {
    /// The path tracer.
    Path(Path<'a>),
    /// The report's path tracer.
    Report(Report<'a>),
    /// Whitted ray tracing.
    Whitted(Whitted<'a>),
}

impl<'a> LaneEstimator<'a> {
    /// Returns the estimator of radiance along single rays.
    pub(super) fn along_rays(&self) -> &(dyn Estimator + 'a) {
        match self {
            Self::Path(path) => path,
            Self::Report(report) => report,
            Self::Whitted(whitted) => whitted,
        }
    }

    /// Returns the parts.
    pub(super) fn parts(&self) -> Parts<'a> {
        match self {
            Self::Path(path) => path.parts,
            Self::Report(report) => report.parts,
            Self::Whitted(whitted) => whitted.parts,
        }
    }
}

/// State of the replication that a lane computes.
#[derive(Clone, Copy, Default)]
struct LaneReplication {
    /// Column of its pixel in the row.
    column: usize,
    sample: SampleId,
    /// Sum of the radiances of its finished samples.
    sum: DVec3,
    /// Radiance of an emitter seen by the camera ray, directly or through mirrors.
    emitter_radiance: DVec3,
    /// Product of the reflectances of the mirrors that the camera ray has followed, and their
    /// number, as in [`PrimaryRay`](crate::render::silhouette::PrimaryRay).
    weight: DVec3,
    mirrors: u32,
}

impl LaneReplication {
    /// Adds the mean of its samples to its pixel.
    fn finish(&self, run: &mut PixelRun<'_>) -> Result<(), Error> {
        let samples = run.counts[self.column];
        run.pixels[self.column]
            .push(self.sum / f64::from(samples), samples)
            .map_err(|error| self.locate(run.corner, error))
    }

    /// Adds this replication and its pixel to an error; the row starts at `corner` of the image.
    fn locate(&self, corner: [u32; 2], error: Error) -> Error {
        let (x, y) = (corner[0] + self.column as u32, corner[1]);
        error.at(|| {
            format!(
                " at pixel ({x}, {y}), replication {}",
                self.sample.replication
            )
        })
    }
}

/// Renders rows of pixels with an estimator, by default parts, in a scene.
pub(crate) struct RowRenderer<'a, R: Wide<N>, const N: usize> {
    pub scene: LaneScene<'a, R, N>,
    pub estimator: LaneEstimator<'a>,
    pub sampling: Sampling,
    pub resolution: [u32; 2],
    pub silhouettes: Silhouettes,
}

impl<R: Wide<N>, const N: usize> RowRenderer<'_, R, N> {
    /// Adds the missing replications to the pixels of a run.
    pub fn add_run(&self, run: &mut PixelRun<'_>) -> Result<(), Error> {
        match &self.estimator {
            LaneEstimator::Path(path) => self.add_with(path, run),
            LaneEstimator::Report(report) => self.add_with(report, run),
            LaneEstimator::Whitted(whitted) => self.add_with(whitted, run),
        }
    }

    fn add_with<E: Integrator>(&self, estimator: &E, run: &mut PixelRun<'_>) -> Result<(), Error> {
        match self.sampling.sampler {
            SamplerKind::Independent => self.add_with_sampler::<E, LaneStreams<N>>(estimator, run),
            SamplerKind::Sobol(_) => self.add_with_sampler::<E, LaneSobol<N>>(estimator, run),
        }
    }

    /// Adds the missing replications to the pixels of a run with one kind of estimator and sampler.
    fn add_with_sampler<E: Integrator, S: PixelSampler<R>>(
        &self,
        estimator: &E,
        run: &mut PixelRun<'_>,
    ) -> Result<(), Error> {
        let (scene, resolution, corner) = (self.scene, self.resolution, run.corner);
        let all_replications = run.replications.clone();
        let mut next = (0..run.pixels.len()).flat_map(|column| {
            let replications = all_replications.clone();
            replications.map(move |replication| (column, replication))
        });
        let mut random = S::new(self.sampling.seed);
        let mut states = [LaneReplication::default(); N];
        let mut paths: PathState<R, N> = PathState::new();
        let mut scratch = IntersectionScratch::new();
        // Bits of the lanes that need a replication, that start a sample, and whose path is under way.
        let (mut idle, mut fresh, mut busy) = (u32::MAX >> (32 - N), 0_u32, 0_u32);
        loop {
            for lane in lanes_of(idle) {
                for (column, replication) in &mut next {
                    let pixel = corner[1] * resolution[0] + corner[0] + column as u32;
                    let (index, sum) = run.begun(column, replication);
                    let sample = SampleId {
                        pixel,
                        replication,
                        index,
                    };
                    states[lane] = LaneReplication {
                        column,
                        sample,
                        sum,
                        ..LaneReplication::default()
                    };
                    if index < run.counts[column] {
                        idle &= !(1 << lane);
                        fresh |= 1 << lane;
                        break;
                    }
                    states[lane].finish(run)?;
                }
            }
            if fresh != 0 {
                for lane in lanes_of(fresh) {
                    let LaneReplication { column, sample, .. } = states[lane];
                    random.start(lane, &run.sampling(column, self.sampling), sample);
                    (
                        states[lane].emitter_radiance,
                        states[lane].weight,
                        states[lane].mirrors,
                    ) = (DVec3::ZERO, DVec3::ONE, 0);
                }
                let starting = R::Mask::from_bits(fresh);
                LaneSampler::<R>::start_blocks(&mut random, starting, &[0; N]);
                let ray = self.camera_rays(corner, &states, starting, &mut random);
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
            let leaving = R::Mask::from_bits(ended);
            estimator.escape(&DefaultParts, scene.scene, &mut paths, leaving);
            if hit_bits != 0 {
                let surface = SurfaceInteraction::new(scene, &paths.ray, &found);
                let mirrors = if self.silhouettes.follows_mirrors {
                    surface.dark_mirror().bits()
                } else {
                    0
                };
                let mut followed = 0;
                let (shining, backs) = (surface.shows_emitter().bits(), surface.backs());
                let first = hit_bits & R::Mask::from_fn(|i| paths.hits[i] == 0).bits();
                for lane in lanes_of(first) {
                    let state = &mut states[lane];
                    if state.mirrors == 0 {
                        let pushed =
                            surface.push_features(lane, backs, &mut run.pixels[state.column]);
                        pushed.map_err(|error| state.locate(corner, error))?;
                    }
                    if mirrors >> lane & 1 == 1 && state.mirrors < MAX_MIRRORS {
                        state.weight *= surface.reflectance(lane);
                        state.mirrors += 1;
                        followed |= 1 << lane;
                    } else if shining >> lane & 1 == 1 {
                        state.emitter_radiance = state.weight * surface.emitter_radiance(lane);
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
                let goes_on = estimator.interact(
                    &DefaultParts,
                    Arrival {
                        scene,
                        paths,
                        surface,
                        active,
                        random,
                        scratch,
                    },
                );
                ended = busy & !goes_on.bits() & !followed;
            }
            ended &= !paths.pop_branches(ended);
            busy &= !ended;
            let radiances = paths.radiance.components().map(R::lanes);
            let radiance = |lane: usize| {
                let [red, green, blue] = &radiances;
                DVec3::new(red[lane].into(), green[lane].into(), blue[lane].into())
            };
            for lane in lanes_of(ended) {
                let state = &mut states[lane];
                let mut radiance = state.weight * radiance(lane);
                let id = state.sample;
                let points = self.silhouettes.points(id.pixel, id.replication, id.index);
                if let Some(points) = points {
                    let first = [corner[0] + state.column as u32, corner[1]];
                    let visible_emission = self.visible_emission(first, points, &mut scratch);
                    radiance = with_supersampled_emission(
                        radiance,
                        state.emitter_radiance,
                        visible_emission,
                    );
                }
                check_radiance(radiance).map_err(|error| state.locate(corner, error))?;
                state.sum += radiance;
                state.sample.index += 1;
                if state.sample.index < run.counts[state.column] {
                    fresh |= 1 << lane;
                } else {
                    state.finish(run)?;
                    idle |= 1 << lane;
                }
            }
        }
    }

    /// Returns the emitted radiance seen through these points of a pixel.
    fn visible_emission(
        &self,
        pixel: [u32; 2],
        points: [[f64; 2]; POINTS_PER_SAMPLE],
        scratch: &mut IntersectionScratch<R, N>,
    ) -> [DVec3; POINTS_PER_SAMPLE] {
        let (scene, resolution) = (self.scene, self.resolution);
        let [x, y] = from_fn(|axis| {
            R::from_lanes(|i| f64::from(pixel[axis]) + points[i % POINTS_PER_SAMPLE][axis])
        });
        let mut ray = scene.scene.camera().ray(resolution, x, y);
        let (mut visible_emission, mut weights) = (
            [DVec3::ZERO; POINTS_PER_SAMPLE],
            [DVec3::ONE; POINTS_PER_SAMPLE],
        );
        let mut active = R::Mask::from_fn(|i| i < POINTS_PER_SAMPLE);
        for mirror in 0..=MAX_MIRRORS {
            let found = scene.closest(&ray, active, scratch);
            if !found.hit_mask.any() {
                break;
            }
            let surface = SurfaceInteraction::new(scene, &ray, &found);
            let follows = self.silhouettes.follows_mirrors && mirror < MAX_MIRRORS;
            active = if follows {
                found.hit_mask & surface.dark_mirror()
            } else {
                R::Mask::splat(false)
            };
            let shining = surface.shows_emitter().bits();
            for lane in lanes_of(found.hit_mask.bits()) {
                if active.bits() >> lane & 1 == 1 {
                    weights[lane] *= surface.reflectance(lane);
                } else if shining >> lane & 1 == 1 {
                    visible_emission[lane] = weights[lane] * surface.emitter_radiance(lane);
                }
            }
            if !active.any() {
                break;
            }
            ray = surface.spawn_ray(surface.mirrored());
        }
        visible_emission
    }

    /// Generates the camera rays of samples that start in the lanes of the mask.
    #[inline(always)]
    fn camera_rays<S: PixelSampler<R>>(
        &self,
        corner: [u32; 2],
        states: &[LaneReplication; N],
        starting: R::Mask,
        random: &mut S,
    ) -> Ray<R::Vector> {
        let sampling = &self.sampling;
        let numbers = [random.uniform(starting), random.uniform(starting)];
        let positions = if sampling.pixel == PixelSampling::Random {
            numbers
        } else {
            let positions: [[f64; 2]; N] = from_fn(|i| {
                let cell = states[i].sample.index % sampling.pixel.samples_per_replication();
                sampling.pixel.position(cell, numbers.map(|r| r.lane(i)))
            });
            [0, 1].map(|axis| R::from_lanes(|i| positions[i][axis]))
        };
        let x = R::from_lanes(|i| f64::from(corner[0] + states[i].column as u32)) + positions[0];
        let y = R::splat(f64::from(corner[1])) + positions[1];
        self.scene.scene.camera().ray(self.resolution, x, y)
    }
}
