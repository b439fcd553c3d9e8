//! Random walks and what camera rays see, eight at a time, with the same bits as each of them alone.

use std::array::from_fn;

use glam::DVec3;

use super::row::lanes_of;
use super::samples::{LaneSampler, Sources};
use super::scene::{LaneScene, Seen};
use super::shading::Surfaces;
use crate::error::Error;
use crate::estimator::{Met, Start, Step};
use crate::film::Features;
use crate::real::{LANES, LaneMask, Lanes, Lanes3, Mask, Real, Vector, WideMask, WideVector};
use crate::roulette;
use crate::sampler::Sampler;
use crate::scene::Scene;
use crate::shape::Ray;

/// A scene for rays in lanes.
pub(crate) struct Walks<'a>(LaneScene<'a, Lanes, LANES>);

impl<'a> Walks<'a> {
    /// None where there is rough glass.
    pub fn new(scene: &'a Scene) -> Option<Self> {
        let rough_glass = scene.surfaces().iter().any(|surface| surface.bsdf.is_rough_glass());
        (!rough_glass).then(|| Self(LaneScene::new(scene)))
    }

    /// The features of what is seen through these points of a frame.
    pub fn features(&self, frame: [u32; 2], points: &[[f64; 2]]) -> Vec<Option<Features>> {
        let mut seen = Seen::new();
        let eight = points.chunks(LANES).flat_map(|points| {
            let [x, y] = [0, 1].map(|axis| Lanes::new(from_fn(|i| points.get(i).unwrap_or(&points[0])[axis])));
            let ray = self.0.scene.camera().ray(frame, x, y);
            let found = self.0.closest(&ray, LaneMask::from_fn(|i| i < points.len()), &mut seen);
            let met = found.met.bits();
            let surfaces = (met != 0).then(|| Surfaces::new(&self.0, &ray, &found));
            let of = move |i: usize| surfaces.as_ref().filter(|_| met >> i & 1 == 1).map(|s| s.features(i));
            (0..points.len()).map(of).collect::<Vec<_>>()
        });
        eight.collect()
    }

    /// [`crate::estimator::follow`] with standard parts: the same steps in the same order for each walk, and walks in
    /// any order.
    pub fn follow<T, R: Sampler>(
        &self,
        mut starts: impl Iterator<Item = Start<T, R>>,
        mut met: impl FnMut(Met<'_, 'a, T, R>) -> Result<bool, Error>,
    ) -> Result<(), Error> {
        let scene = self.0.scene;
        let zero = Lanes3::splat_vector(DVec3::ZERO);
        let mut ray = Ray::new(zero, Lanes3::splat_vector(DVec3::Z));
        let (mut throughput, mut factor) = (zero, Lanes::splat(1.0));
        let mut random: Sources<R> = Sources(from_fn(|_| None));
        // What walks in each lane, the block of its numbers and how often it has met something.
        let mut walks: [Option<(T, u32, u32)>; LANES] = from_fn(|_| None);
        let mut seen = Seen::new();
        loop {
            let mut started: [Option<Ray>; LANES] = [None; LANES];
            let idle = LaneMask::from_fn(|i| walks[i].is_none()).bits();
            for lane in lanes_of(idle) {
                for Start { item, ray, block, rng } in starts.by_ref() {
                    if ray.is_some() {
                        (walks[lane], random.0[lane], started[lane]) = (Some((item, block, 0)), Some(rng), ray);
                        break;
                    }
                    met(Met::End(item, DVec3::ZERO, rng))?;
                }
            }
            let fresh = LaneMask::from_fn(|i| started[i].is_some());
            if fresh.any() {
                let new = |old: Lanes3, of: fn(&Ray) -> DVec3| {
                    Lanes3::from_fn(|i| started[i].as_ref().map_or(old.lane(i), of))
                };
                ray = Ray::new(new(ray.origin, |ray| ray.origin), new(ray.direction, |ray| ray.direction));
                throughput = Vector::choose(fresh, Lanes3::splat_vector(DVec3::ONE), throughput);
                factor = Lanes::choose(fresh, Lanes::splat(1.0), factor);
            }
            let busy = LaneMask::from_fn(|i| walks[i].is_some());
            if !busy.any() {
                return Ok(());
            }
            let found = self.0.closest(&ray, busy, &mut seen);
            let here = found.met.bits();
            let mut going = 0;
            let surfaces = (here != 0).then(|| Surfaces::new(&self.0, &ray, &found));
            if let Some(surfaces) = &surfaces {
                for lane in lanes_of(here) {
                    let Some((item, block, hits)) = &mut walks[lane] else { continue };
                    *hits += 1;
                    random.block(lane, *block + *hits);
                    let Some(rng) = &mut random.0[lane] else { continue };
                    let ray = Ray::new(ray.origin.lane(lane), ray.direction.lane(lane));
                    let here = surfaces.hit(lane, found.primitive[lane]);
                    let step = Step {
                        ray,
                        here,
                        bsdf: &scene.surface(&here).bsdf,
                        throughput: throughput.lane(lane),
                        factor: factor.as_array()[lane],
                        // Standard roulette has ended every walk long before.
                        endless: false,
                    };
                    going |= u32::from(met(Met::Hit(item, &step, &step.vertex(), rng))?) << lane;
                }
                let next = surfaces.sample(LaneMask::from_bits(going), &mut random);
                let scattered = throughput * next.weight;
                let survival = roulette::by_throughput(scattered, LaneMask::splat(false));
                let survives = next.goes_on & roulette::survives(random.uniform(next.goes_on), survival);
                let onward = surfaces.leave(next.direction);
                let new = |value: Lanes3, old: Lanes3| Vector::choose(survives, value, old);
                ray = Ray::new(new(onward.origin, ray.origin), new(onward.direction, ray.direction));
                throughput = new(scattered * roulette::weight(survival), throughput);
                factor = Lanes::choose(survives, factor * next.radiance_factor, factor);
                going = survives.bits();
            }
            for lane in lanes_of(busy.bits() & !going) {
                let left = here >> lane & 1 == 0;
                let shown = || scene.background().radiance(ray.direction.lane(lane));
                let background =
                    if left { factor.as_array()[lane] * throughput.lane(lane) * shown() } else { DVec3::ZERO };
                if let (Some((item, ..)), Some(rng)) = (walks[lane].take(), random.0[lane].take()) {
                    met(Met::End(item, background, rng))?;
                }
            }
        }
    }
}
