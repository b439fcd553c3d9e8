//! The path tracer of [`crate::estimator::Path`] in lanes.

use std::array::from_fn;
use std::ops::Range;

use glam::DVec3;

use super::samples::{LaneSampler, SampleName};
use super::scene::{LaneScene, Seen, gather3, lane3};
use super::shading::Surfaces;
use crate::emitter::{Emitter, LightSampling};
use crate::error::Error;
use crate::estimator::{Heuristic, LONGEST_PATH, Path, Strategy};
use crate::film::{Features, Pixel, check_radiance};
use crate::real::{LANES, LaneMask, Lanes, Lanes3, Mask, Real, Vector};
use crate::render::{Sampling, features};
use crate::scene::Scene;
use crate::shape::Ray;
use crate::{radiometry, roulette};

/// A replication in a lane.
#[derive(Clone, Copy, Default)]
struct Work {
    /// Its pixel in the row.
    column: usize,
    sample: SampleName,
    /// The radiance of the samples that are done.
    sum: DVec3,
}

impl Work {
    /// An error of this replication, with its place in a row that starts at `corner` of the frame.
    fn place(&self, corner: [u32; 2], error: Error) -> Error {
        let (x, y) = (corner[0] + self.column as u32, corner[1]);
        error.at(|| format!(" at pixel ({x}, {y}), replication {}", self.sample.replication))
    }
}

/// The paths of all lanes.
struct Paths {
    ray: Ray<Lanes3>,
    radiance: Lanes3,
    throughput: Lanes3,
    factor: Lanes,
    /// The pdf of the ray's direction with respect to solid angle, where it has one.
    pdf: Lanes,
    has_pdf: LaneMask,
    hits: [u32; LANES],
}

/// A row of pixels: the replications `range` of each of them.
pub(super) fn row<S: LaneSampler>(
    (scene, path): (&LaneScene<'_>, &Path),
    sampling: &Sampling,
    (frame, corner): ([u32; 2], [u32; 2]),
    range: &Range<u32>,
    pixels: &mut [Pixel],
) -> Result<(), Error> {
    let samples = sampling.samples_per_replication();
    let columns = pixels.len();
    let mut next = (0..columns).flat_map(|column| range.clone().map(move |replication| (column, replication)));
    let mut random = S::new();
    let mut work = [Work::default(); LANES];
    let zero = Lanes3::splat_vector(DVec3::ZERO);
    let mut paths = Paths {
        ray: Ray::new(zero, Lanes3::splat_vector(DVec3::Z)),
        radiance: zero,
        throughput: zero,
        factor: Lanes::splat(1.0),
        pdf: Lanes::splat(0.0),
        has_pdf: LaneMask::from_bits(0),
        hits: [0; LANES],
    };
    let mut seen = Seen::new();
    // A bit for each lane: those that need a replication, that start a sample, and that are on their way.
    let (mut idle, mut fresh, mut busy) = (u32::MAX >> (32 - LANES), 0_u32, 0_u32);
    loop {
        for (lane, work) in work.iter_mut().enumerate() {
            if idle >> lane & 1 == 1
                && let Some((column, replication)) = next.next()
            {
                let pixel = corner[1] * frame[0] + corner[0] + column as u32;
                *work = Work { column, sample: SampleName { pixel, replication, index: 0 }, sum: DVec3::ZERO };
                idle &= !(1 << lane);
                fresh |= 1 << lane;
            }
        }
        if fresh != 0 {
            for (lane, work) in work.iter().enumerate().filter(|(lane, _)| fresh >> lane & 1 == 1) {
                random.start(lane, sampling, work.sample);
                paths.hits[lane] = 0;
            }
            let starting = LaneMask::from_bits(fresh);
            paths.start(scene.scene, sampling, (frame, corner), (&work, starting), &mut random);
            busy |= fresh;
            fresh = 0;
        }
        if busy == 0 {
            return Ok(());
        }
        let ended =
            paths.step((scene, path), (LaneMask::from_bits(busy), &mut random), &mut seen, |lane, features| {
                let work = &work[lane];
                pixels[work.column].push_features(features).map_err(|error| work.place(corner, error))
            })?;
        busy &= !ended;
        for (lane, work) in work.iter_mut().enumerate().filter(|(lane, _)| ended >> lane & 1 == 1) {
            let radiance = lane3(paths.radiance, lane);
            check_radiance(radiance).map_err(|error| work.place(corner, error))?;
            work.sum += radiance;
            work.sample.index += 1;
            if work.sample.index < samples {
                fresh |= 1 << lane;
            } else {
                let pushed = pixels[work.column].push(work.sum / f64::from(samples));
                pushed.map_err(|error| work.place(corner, error))?;
                idle |= 1 << lane;
            }
        }
    }
}

impl Paths {
    /// Sends camera rays in the lanes of the mask.
    fn start<S: LaneSampler>(
        &mut self,
        scene: &Scene,
        sampling: &Sampling,
        (frame, corner): ([u32; 2], [u32; 2]),
        (work, starting): (&[Work; LANES], LaneMask),
        random: &mut S,
    ) {
        let numbers = [random.uniform(starting), random.uniform(starting)];
        let positions: [[f64; 2]; LANES] = from_fn(|i| {
            let cell = work[i].sample.index % sampling.pixel.samples_per_replication();
            sampling.pixel.position(cell, numbers.map(|r| r.as_array()[i]))
        });
        let x = Lanes::new(from_fn(|i| f64::from(corner[0] + work[i].column as u32) + positions[i][0]));
        let y = Lanes::new(from_fn(|i| f64::from(corner[1]) + positions[i][1]));
        let ray = scene.camera().ray(frame, x, y);
        let new = |value: Lanes3, old: Lanes3| Vector::choose(starting, value, old);
        self.ray = Ray::new(new(ray.origin, self.ray.origin), new(ray.direction, self.ray.direction));
        self.radiance = new(Lanes3::splat_vector(DVec3::ZERO), self.radiance);
        self.throughput = new(Lanes3::splat_vector(DVec3::ONE), self.throughput);
        self.factor = Lanes::choose(starting, Lanes::splat(1.0), self.factor);
        self.has_pdf = self.has_pdf & !starting;
    }

    /// Takes every busy path to its next hit and onward, and returns the lanes whose paths have ended.
    fn step<S: LaneSampler>(
        &mut self,
        (scene, path): (&LaneScene<'_>, &Path),
        (busy, random): (LaneMask, &mut S),
        seen: &mut Seen,
        mut first_hit: impl FnMut(usize, &Features) -> Result<(), Error>,
    ) -> Result<u32, Error> {
        let found = scene.closest(&self.ray, busy, seen);
        let lost = busy & !found.met;
        if lost.any() {
            let background = Lanes3::splat_vector(scene.scene.background());
            let seen = self.throughput * self.factor * background;
            self.radiance = Vector::choose(lost, self.radiance + seen, self.radiance);
            if !found.met.any() {
                return Ok(lost.bits());
            }
        }
        let arrived = found.met;
        let surfaces = Surfaces::new(scene, &self.ray, &found);
        for i in lanes_of(arrived.bits()) {
            if self.hits[i] == 0 {
                let [albedo, normal, direction] =
                    [surfaces.colour, surfaces.normal, self.ray.direction].map(|v| lane3(v, i));
                first_hit(i, &features(albedo, normal, surfaces.t.as_array()[i], direction))?;
            }
            self.hits[i] += 1;
            random.block(i, self.hits[i]);
        }
        let endless = arrived & LaneMask::from_fn(|i| self.hits[i] > LONGEST_PATH);
        let throughput = Vector::choose(endless, Lanes3::splat_vector(DVec3::NAN), self.throughput);
        self.add_emission(scene.scene, path, (&surfaces, arrived), throughput);
        let black = arrived & surfaces.black();
        let asking = arrived & surfaces.rough;
        let scattering = arrived & !black;
        if path.strategy != Strategy::Bsdf {
            let light = surfaces.direct_light(scene, path.lights, false, (asking, random), seen);
            let weight = match path.strategy {
                Strategy::Mis => weight(path.heuristic, light.pdf, surfaces.pdf(light.wi)),
                _ => Lanes::splat(1.0),
            };
            let reflected = Vector::choose(light.arrives, light.reflected * weight, Lanes3::splat_vector(DVec3::ZERO));
            let added = self.radiance + throughput * self.factor * reflected;
            self.radiance = Vector::choose(scattering, added, self.radiance);
        }
        let onward = surfaces.sample(scattering & !endless, random);
        let throughput = self.throughput * onward.weight;
        let factor = self.factor * onward.radiance_factor;
        let survival = roulette::by_throughput(throughput);
        let survives = onward.goes_on & roulette::survives(random.uniform(onward.goes_on), survival);
        let weight = roulette::weight(survival);
        self.throughput = Vector::choose(survives, throughput * weight, self.throughput);
        self.factor = Lanes::choose(survives, factor, self.factor);
        self.pdf = Lanes::choose(survives, onward.pdf, self.pdf);
        self.has_pdf = onward.has_pdf;
        let ray = scene.scene.leave(surfaces.vertex.point, surfaces.normal, onward.direction);
        self.ray = Ray::new(
            Vector::choose(survives, ray.origin, self.ray.origin),
            Vector::choose(survives, ray.direction, self.ray.direction),
        );
        Ok((busy & !survives).bits())
    }

    /// Adds what emitters show that the paths have hit.
    #[inline]
    fn add_emission(
        &mut self,
        scene: &Scene,
        path: &Path,
        (surfaces, arrived): (&Surfaces<'_>, LaneMask),
        throughput: Lanes3,
    ) {
        let emitter = |i: usize| surfaces.emitter(i).map(|emitter| &scene.emitters()[emitter as usize]);
        let emits = arrived & LaneMask::from_fn(|i| emitter(i).is_some());
        if !emits.any() {
            return;
        }
        let weighted = self.has_pdf & LaneMask::from_fn(|_| path.strategy == Strategy::Mis);
        let cosine = radiometry::cosine(surfaces.normal, -self.ray.direction);
        let per_area = radiometry::solid_angle_per_area(cosine, surfaces.t * surfaces.t);
        let by_area = Lanes::new(from_fn(|i| emitter(i).map_or(1.0, Emitter::pdf_area))) / per_area;
        let on_emitter = match path.lights {
            LightSampling::Area => by_area,
            LightSampling::SolidAngle => Lanes::new(from_fn(|i| {
                let seen = emitter(i).and_then(|emitter| emitter.pdf_solid_angle(lane3(self.ray.origin, i)));
                seen.unwrap_or(by_area.as_array()[i])
            })),
        };
        let other = on_emitter / scene.emitters().len() as f64;
        // Light that shadow rays find is not counted when it is hit.
        let counts = if path.strategy == Strategy::Light { !self.has_pdf } else { emits };
        let alone = Lanes::choose(counts, Lanes::splat(1.0), Lanes::splat(0.0));
        let weight = Lanes::choose(weighted, weight(path.heuristic, self.pdf, other), alone);
        let zero = Lanes3::splat_vector(DVec3::ZERO);
        let front = surfaces.normal.dot(self.ray.direction).below(Lanes::splat(0.0));
        let shown = Vector::choose(front, gather3(|i| emitter(i).map_or(DVec3::ZERO, |e| e.radiance)), zero);
        let added = self.radiance + throughput * (self.factor * weight) * shown;
        self.radiance = Vector::choose(emits, added, self.radiance);
    }
}

/// The lanes whose bits are set.
#[inline]
fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (lane < LANES).then_some(lane)
    })
}

/// The weight of multiple importance sampling.
#[inline]
fn weight(heuristic: Heuristic, pdf: Lanes, other: Lanes) -> Lanes {
    match heuristic {
        Heuristic::Balance => radiometry::balance(pdf, other),
        Heuristic::Power => radiometry::power(pdf, other),
    }
}
