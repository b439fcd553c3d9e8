//! Rows of pixels in lanes: which sample each lane follows, and what becomes of its radiance.

use std::array::from_fn;
use std::ops::Range;

use glam::DVec3;

use super::PixelsAndCounts;
use super::samples::{PixelSampler, SampleName};
use super::scene::{LaneScene, Seen};
use super::shading::Surfaces;
use super::specular::Trails;
use crate::error::Error;
use crate::film::check_radiance;
use crate::outline::{MIRRORS, Outlines, POINTS, replaced};
use crate::pixel::PixelSampling;
use crate::real::{Lanes3, Mask, Vector, Wide, WideMask, WideVector};
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

/// The paths of all lanes.
pub(super) struct Paths<R: Wide<N>, const N: usize> {
    pub ray: Ray<Lanes3<R>>,
    pub radiance: Lanes3<R>,
    pub throughput: Lanes3<R>,
    /// Product of the radiance factors on the way.
    pub factor: R,
    /// Where shadow rays have looked for the light that the ray hits.
    pub sampled: R::Mask,
    /// The pdf of the ray's direction with respect to solid angle, where shadow rays have looked.
    pub pdf: R,
    /// How often it has met something.
    pub hits: [u32; N],
    pub trails: Trails<R, N>,
    /// What each will follow when it has ended, the last first.
    waiting: [Vec<Branch>; N],
    /// The lanes in which something waits.
    waits: u32,
}

/// A way on that a path of more than one takes later.
struct Branch {
    origin: DVec3,
    direction: DVec3,
    throughput: DVec3,
    hits: u32,
}

/// How an estimator takes paths from what they have met onward.
pub(super) trait Scatter {
    /// Adds to the radiance of the paths that have `arrived` at these surfaces, sends those that go on, and returns
    /// their lanes.
    fn scatter<R: Wide<N>, S: PixelSampler<R, N>, const N: usize>(
        &self,
        scene: &LaneScene<'_, R, N>,
        paths: &mut Paths<R, N>,
        arrived: (&Surfaces<'_, R, N>, R::Mask),
        random: &mut S,
        seen: &mut Seen<R, N>,
    ) -> R::Mask;
}

/// A row of pixels: the replications `range` of each of them.
pub(super) fn row<E: Scatter, R: Wide<N>, S: PixelSampler<R, N>, const N: usize>(
    (scene, estimator): (&LaneScene<'_, R, N>, &E),
    (sampling, outlines): (&Sampling, &Outlines),
    (frame, corner): ([u32; 2], [u32; 2]),
    range: &Range<u32>,
    (pixels, counts): PixelsAndCounts<'_>,
) -> Result<(), Error> {
    let columns = pixels.len();
    let mut next = (0..columns).flat_map(|column| range.clone().map(move |replication| (column, replication)));
    let mut random = S::new(sampling.seed);
    let mut work = [Work::default(); N];
    let zero: Lanes3<R> = Lanes3::splat_vector(DVec3::ZERO);
    let mut paths: Paths<R, N> = Paths {
        ray: Ray::new(zero, Lanes3::splat_vector(DVec3::Z)),
        radiance: zero,
        throughput: zero,
        factor: R::splat(1.0),
        pdf: R::splat(0.0),
        sampled: R::Mask::splat(false),
        hits: [0; N],
        trails: Trails::new(),
        waiting: from_fn(|_| Vec::new()),
        waits: 0,
    };
    let mut seen = Seen::new();
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
                paths.hits[lane] = 0;
                paths.trails.start(lane);
                (work[lane].own, work[lane].weight, work[lane].mirrors) = (DVec3::ZERO, DVec3::ONE, 0);
            }
            let starting = R::Mask::from_bits(fresh);
            random.start_blocks(starting, &[0; N]);
            paths.start(scene.scene, sampling, (frame, corner), (&work, starting), &mut random);
            busy |= fresh;
            fresh = 0;
        }
        if busy == 0 {
            return Ok(());
        }
        let found = scene.closest(&paths.ray, R::Mask::from_bits(busy), &mut seen);
        let met = found.met.bits();
        let mut ended = busy & !met;
        paths.leave(scene.scene, R::Mask::from_bits(ended));
        if met != 0 {
            let surfaces = Surfaces::new(scene, &paths.ray, &found);
            let mirrors = if outlines.in_mirrors { surfaces.dark_mirror().bits() } else { 0 };
            let mut followed = 0;
            let (shining, backs) = (surfaces.shining(), surfaces.backs());
            let first = met & R::Mask::from_fn(|i| paths.hits[i] == 0).bits();
            for lane in lanes_of(first) {
                let work = &mut work[lane];
                if work.mirrors == 0 {
                    let pushed = surfaces.push_features(lane, backs, &mut pixels[work.column]);
                    pushed.map_err(|error| work.place(corner, error))?;
                }
                if mirrors >> lane & 1 == 1 && work.mirrors < MIRRORS {
                    work.weight *= surfaces.reflectance(lane);
                    work.mirrors += 1;
                    followed |= 1 << lane;
                } else if shining >> lane & 1 == 1 {
                    work.own = work.weight * surfaces.shown_in(scene, lane);
                }
            }
            for (lane, hits) in paths.hits.iter_mut().enumerate() {
                *hits += (met & !followed) >> lane & 1;
            }
            let follows = R::Mask::from_bits(followed);
            if followed != 0 {
                let throughput = paths.throughput;
                paths.send(follows, &surfaces, surfaces.mirrored(), throughput);
            }
            let goes_on =
                estimator.scatter(scene, &mut paths, (&surfaces, found.met & !follows), &mut random, &mut seen);
            ended = busy & !goes_on.bits() & !followed;
        }
        ended &= !paths.go_back(ended);
        busy &= !ended;
        let radiances = paths.radiance.components().map(R::lanes);
        for lane in lanes_of(ended) {
            let work = &mut work[lane];
            let mut radiance = work.weight * DVec3::from_array(radiances.map(|channel| channel[lane].into()));
            let SampleName { pixel, replication, index } = work.sample;
            if let Some(points) = outlines.points(pixel, replication, index) {
                let first = [corner[0] + work.column as u32, corner[1]];
                let shown = shown(scene, (frame, first), (points, outlines.in_mirrors), &mut seen);
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
    scene: &LaneScene<'_, R, N>,
    (frame, pixel): ([u32; 2], [u32; 2]),
    (points, in_mirrors): ([[f64; 2]; POINTS], bool),
    seen: &mut Seen<R, N>,
) -> [DVec3; POINTS] {
    let [x, y] = from_fn(|axis| R::from_lanes(|i| f64::from(pixel[axis]) + points[i % POINTS][axis]));
    let mut ray = scene.scene.camera().ray(frame, x, y);
    let (mut shown, mut weights) = ([DVec3::ZERO; POINTS], [DVec3::ONE; POINTS]);
    let mut looking = R::Mask::from_fn(|i| i < POINTS);
    for mirror in 0..=MIRRORS {
        let found = scene.closest(&ray, looking, seen);
        if !found.met.any() {
            break;
        }
        let surfaces = Surfaces::new(scene, &ray, &found);
        let follows = in_mirrors && mirror < MIRRORS;
        looking = if follows { found.met & surfaces.dark_mirror() } else { R::Mask::splat(false) };
        let shining = surfaces.shining();
        for lane in lanes_of(found.met.bits()) {
            if looking.bits() >> lane & 1 == 1 {
                weights[lane] *= surfaces.reflectance(lane);
            } else if shining >> lane & 1 == 1 {
                shown[lane] = weights[lane] * surfaces.shown_in(scene, lane);
            }
        }
        if !looking.any() {
            break;
        }
        ray = surfaces.leave(surfaces.mirrored());
    }
    shown
}

impl<R: Wide<N>, const N: usize> Paths<R, N> {
    /// Sends camera rays in the lanes of the mask.
    fn start<S: PixelSampler<R, N>>(
        &mut self,
        scene: &Scene,
        sampling: &Sampling,
        (frame, corner): ([u32; 2], [u32; 2]),
        (work, starting): (&[Work; N], R::Mask),
        random: &mut S,
    ) {
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
        let ray = scene.camera().ray(frame, x, y);
        let new = |value: Lanes3<R>, old: Lanes3<R>| Vector::choose(starting, value, old);
        self.ray = Ray::new(new(ray.origin, self.ray.origin), new(ray.direction, self.ray.direction));
        self.radiance = new(Lanes3::splat_vector(DVec3::ZERO), self.radiance);
        self.throughput = new(Lanes3::splat_vector(DVec3::ONE), self.throughput);
        self.factor = R::choose(starting, R::splat(1.0), self.factor);
        self.sampled = self.sampled & !starting;
    }

    /// Adds what the background shows to the paths of these lanes, which leave the scene.
    fn leave(&mut self, scene: &Scene, leaving: R::Mask) {
        if leaving.any() {
            let background = Lanes3::from_fn(|i| scene.background().radiance(self.ray.direction.lane(i)));
            let shown = self.throughput * self.factor * background;
            self.radiance = Vector::choose(leaving, self.radiance + shown, self.radiance);
        }
    }

    /// Adds what emitters show to the paths of these lanes.
    pub fn see(&mut self, shown: Lanes3<R>, counts: R::Mask) {
        if counts.any() {
            self.radiance = Vector::choose(counts, self.radiance + self.throughput * shown, self.radiance);
        }
    }

    /// Remembers another way on from surfaces for the paths of these lanes.
    pub fn put_off(&mut self, on: R::Mask, surfaces: &Surfaces<'_, R, N>, direction: Lanes3<R>, throughput: Lanes3<R>) {
        let ray = surfaces.leave(direction);
        self.waits |= on.bits();
        for lane in lanes_of(on.bits()) {
            let [origin, direction, throughput] = [ray.origin, ray.direction, throughput].map(|v| v.lane(lane));
            self.waiting[lane].push(Branch { origin, direction, throughput, hits: self.hits[lane] });
        }
    }

    /// Sends those of these paths that have ended onto what they have put off, and returns their lanes.
    fn go_back(&mut self, ended: u32) -> u32 {
        let back = ended & self.waits;
        if back == 0 {
            return 0;
        }
        let branches: [Option<Branch>; N] = from_fn(|i| if back >> i & 1 == 1 { self.waiting[i].pop() } else { None });
        self.waits = lanes_of(self.waits).filter(|&i| !self.waiting[i].is_empty()).fold(0, |bits, i| bits | 1 << i);
        let new = |old: Lanes3<R>, of: fn(&Branch) -> DVec3| {
            Lanes3::from_fn(|i| branches[i].as_ref().map_or(old.lane(i), of))
        };
        let Ray { origin, direction, .. } = self.ray;
        self.ray = Ray::new(new(origin, |branch| branch.origin), new(direction, |branch| branch.direction));
        self.throughput = new(self.throughput, |branch| branch.throughput);
        for (hits, branch) in self.hits.iter_mut().zip(&branches) {
            *hits = branch.as_ref().map_or(*hits, |branch| branch.hits);
        }
        back
    }

    /// Sends the paths of these lanes on from surfaces, with this throughput.
    pub fn send(&mut self, on: R::Mask, surfaces: &Surfaces<'_, R, N>, direction: Lanes3<R>, throughput: Lanes3<R>) {
        let ray = surfaces.leave(direction);
        let new = |value: Lanes3<R>, old: Lanes3<R>| Vector::choose(on, value, old);
        self.ray = Ray::new(new(ray.origin, self.ray.origin), new(ray.direction, self.ray.direction));
        self.throughput = new(throughput, self.throughput);
    }
}

/// The lanes whose bits are set.
#[inline]
pub(super) fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (lane < 32).then_some(lane)
    })
}
