//! Random walks from hit to hit, for eye paths and light paths.

use std::array::from_fn;
use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::lanewise::Lanewise;
use super::strategies::PathVertex;
use super::{MAX_PATH_VERTICES, PathParts, SurfaceInteraction};
use crate::error::Error;
use crate::geometry::shape::{Hit, Ray};
use crate::material::{Bsdf, Vertex};
use crate::math::real::{Mask, Real, Vector};
use crate::math::simd::{LANES, LaneMask, Lanes, Lanes3, lanes_of};
use crate::sampling::lanes::{LaneSampler, Sources};
use crate::sampling::sampler::Sampler;
use crate::scene::Scene;
use crate::scene::lanes::{IntersectionScratch, LaneScene};

/// A random walk at one of its hits, before it scatters.
pub(super) struct WalkHit<'a> {
    /// Ray that arrived, and its hit.
    pub ray: Ray,
    pub here: Hit,
    pub bsdf: &'a Bsdf,
    /// Throughput without radiance factors: these cancel when the walk leaves the glass, and
    /// Russian roulette should not depend on them. NaN in an endless walk.
    pub throughput: DVec3,
    /// Product of the radiance factors along the walk.
    pub factor: f64,
    /// Whether the walk has exceeded [`MAX_PATH_VERTICES`] and is given up.
    pub endless: bool,
}

/// A random walk that has not started, with the caller's data `item`.
pub(super) struct PendingWalk<T, S> {
    pub item: T,
    /// First ray; without one the walk ends at once.
    pub ray: Option<Ray>,
    /// Block of random numbers before that of the first hit.
    pub block: u32,
    pub rng: S,
}

/// An event of a walk: a hit or its end.
pub(super) enum WalkEvent<'m, 'a, T, S> {
    /// The walk has hit a surface; the vertex is [`WalkHit::vertex`].
    Hit(&'m mut T, &'m WalkHit<'a>, &'m Vertex, &'m mut S),
    /// The walk has ended; the vector is the background radiance times throughput, zero if it has
    /// not left the scene.
    End(T, DVec3, S),
}

/// Number of walks per batch of a thread: the vertices that bidirectional paths store fit in its
/// caches.
const WALKS_PER_BATCH: u32 = 256;

/// Splits the range up to `count` into batches, in parallel.
pub(super) fn in_batches(count: u32) -> impl IndexedParallelIterator<Item = Range<u32>> {
    let batches = (0..count.div_ceil(WALKS_PER_BATCH)).into_par_iter();
    batches.map(move |batch| {
        batch * WALKS_PER_BATCH
            ..count.min((batch * WALKS_PER_BATCH).saturating_add(WALKS_PER_BATCH))
    })
}

/// A walk in a lane.
struct Walk<T> {
    item: T,
    block: u32,
    hits: u32,
}

/// Traces walks, several at a time and in any order. `event` receives all hits of a walk in order
/// and then its end; at a hit it returns whether the walk continues. Compiled once for any iterator.
pub(super) fn trace_walks<'a, P: PathParts + ?Sized, T, S: Sampler>(
    parts: &P,
    scene: &'a Scene,
    pending: &mut dyn Iterator<Item = PendingWalk<T, S>>,
    mut event: impl FnMut(WalkEvent<'_, 'a, T, S>) -> Result<bool, Error>,
) -> Result<(), Error> {
    let lanes: LaneScene<'a, Lanes, LANES> = LaneScene::new(scene);
    let zero = Lanes3::zero();
    let mut ray = Ray::new(zero, Lanes3::splat_vector(DVec3::Z));
    let (mut throughput, mut factor) = (zero, Lanes::splat(1.0));
    let mut random: Sources<S, LANES> = Sources(from_fn(|_| None));
    let mut walks: [Option<Walk<T>>; LANES] = from_fn(|_| None);
    let mut scratch = IntersectionScratch::new();
    loop {
        let mut started: [Option<Ray>; LANES] = [None; LANES];
        let idle = LaneMask::from_fn(|i| walks[i].is_none()).bits();
        for lane in lanes_of(idle) {
            for next in &mut *pending {
                if next.ray.is_some() {
                    let (item, block, hits) = (next.item, next.block, 0);
                    walks[lane] = Some(Walk { item, block, hits });
                    (random.0[lane], started[lane]) = (Some(next.rng), next.ray);
                    break;
                }
                event(WalkEvent::End(next.item, DVec3::ZERO, next.rng))?;
            }
        }
        let fresh = LaneMask::from_fn(|i| started[i].is_some());
        if fresh.any() {
            ray = Ray::from_fn(|i| started[i].unwrap_or_else(|| ray.lane(i)));
            throughput = Vector::select(fresh, Lanes3::splat_vector(DVec3::ONE), throughput);
            factor = <Lanes as Real>::select(fresh, Lanes::splat(1.0), factor);
        }
        let busy = LaneMask::from_fn(|i| walks[i].is_some());
        if !busy.any() {
            return Ok(());
        }
        let found = lanes.closest(&ray, busy, &mut scratch);
        let hit_bits = found.hit_mask.bits();
        let mut going = 0;
        if hit_bits != 0 {
            let surface = SurfaceInteraction::new(lanes, &ray, &found);
            let mut endless = 0;
            for lane in lanes_of(hit_bits) {
                let (Some(walk), Some(rng)) = (&mut walks[lane], &mut random.0[lane]) else {
                    continue;
                };
                walk.hits += 1;
                rng.block(walk.block + walk.hits);
                let is_endless = walk.hits > MAX_PATH_VERTICES;
                let here = surface.hit(lane, found.primitive[lane]);
                let hit = WalkHit {
                    ray: ray.lane(lane),
                    here,
                    bsdf: &scene.surface(&here).bsdf,
                    throughput: if is_endless {
                        DVec3::NAN
                    } else {
                        throughput.lane(lane)
                    },
                    factor: factor.lane(lane),
                    endless: is_endless,
                };
                let at = &hit.vertex();
                let goes_on = event(WalkEvent::Hit(&mut walk.item, &hit, at, rng))?;
                going |= u32::from(goes_on) << lane;
                endless |= u32::from(is_endless) << lane;
            }
            going &= !endless;
            // All may have ended, as those of photon maps at the first diffuse surfaces.
            if going != 0 {
                let next = surface.sample(parts, LaneMask::from_bits(going), &mut random);
                let scattered = throughput * next.weight;
                let random = random.uniform(next.exists);
                let game =
                    parts.lanes_survive(scattered, LaneMask::splat(false), random, next.exists);
                let (survives, weight) = (game.survives, game.weight);
                ray = Ray::select(survives, &surface.spawn_ray(next.direction), &ray);
                throughput = Vector::select(survives, scattered * weight, throughput);
                factor = <Lanes as Real>::select(survives, factor * next.radiance_factor, factor);
                going = survives.bits();
            }
        }
        for lane in lanes_of(busy.bits() & !going) {
            let left = hit_bits >> lane & 1 == 0;
            let shown = || scene.background().radiance(ray.direction.lane(lane));
            let background = if left {
                factor.lane(lane) * throughput.lane(lane) * shown()
            } else {
                DVec3::ZERO
            };
            if let (Some(walk), Some(rng)) = (walks[lane].take(), random.0[lane].take()) {
                event(WalkEvent::End(walk.item, background, rng))?;
            }
        }
    }
}

impl<T, S> PendingWalk<T, S> {
    pub fn new(item: T, ray: Option<Ray>, block: u32, rng: S) -> Self {
        Self {
            item,
            ray,
            block,
            rng,
        }
    }
}

impl<'a> WalkHit<'a> {
    /// Returns the shading vertex of the hit.
    #[inline]
    pub fn vertex(&self) -> Vertex {
        Vertex::new(&self.here, &self.ray)
    }

    /// Returns the radiance emitted towards the ray; zero without an emitter.
    #[inline]
    pub fn emitted(&self, scene: &Scene) -> DVec3 {
        scene.emitted(&self.here, self.ray.direction)
    }

    /// Returns the hit, whose [`vertex`](Self::vertex) is `at`, as a path vertex that is not the
    /// first.
    #[inline]
    pub fn path_vertex(&self, at: Vertex, throughput: DVec3) -> PathVertex<'a> {
        let (bsdf, eta_squared) = (Some(self.bsdf), 1.0 / self.factor);
        PathVertex::new(at, bsdf, throughput, eta_squared, self.here.emitter)
    }
}
