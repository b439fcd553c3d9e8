//! A random walk from hit to hit, for paths from the eye and from lights alike.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::strategies::PathVertex;
use super::{LONGEST_PATH, Walking};
use crate::bsdf::{Bsdf, Vertex};
use crate::error::Error;
use crate::lanes::Walks;
use crate::rng::uniform;
use crate::sampler::Sampler;
use crate::scene::{Hit, Scene};
use crate::shape::Ray;

/// A walk: [`arrive`](Self::arrive) at a hit and [`scatter`](Self::scatter) there, in turn, until it is absorbed,
/// loses at roulette or leaves the scene.
pub(super) struct Walk<'a> {
    scene: &'a Scene,
    ray: Ray,
    hit: Option<Hit>,
    throughput: DVec3,
    /// To which throughput roulette raises faint survivors.
    raised: f64,
    /// How many hits are early for roulette.
    early: u32,
    factor: f64,
    pdf: Option<f64>,
    /// The block of random numbers before that of the first hit.
    block: u32,
    hits: u32,
    ended: bool,
}

/// A walk at one of its hits, before it scatters.
pub(crate) struct Step<'a> {
    /// The ray that arrived, and what it hit.
    pub ray: Ray,
    pub here: Hit,
    pub bsdf: &'a Bsdf,
    /// Product of the weights of all scattering on the way, without radiance factors: they cancel when the
    /// walk leaves the glass, and roulette should not see them. NaN in an endless walk.
    pub throughput: DVec3,
    /// Product of the radiance factors on the way.
    pub factor: f64,
    /// Whether this is the hit after [`LONGEST_PATH`], where a walk that will not end is given up.
    pub endless: bool,
}

/// A walk that is to be followed, for the sake of `item`.
pub(crate) struct Start<T, R> {
    pub item: T,
    /// Its first ray; without one it ends at once.
    pub ray: Option<Ray>,
    /// As of [`Walk::new`].
    pub block: u32,
    pub rng: R,
}

/// What becomes of a walk.
pub(crate) enum Met<'m, 'a, T, R> {
    /// It has met a surface, whose [`Step::vertex`] is there, too.
    Hit(&'m mut T, &'m Step<'a>, &'m Vertex, &'m mut R),
    /// It has ended, and what the background shows there as of [`Walk::background`].
    End(T, DVec3, R),
}

/// Follows walks, eight at a time in `lanes` if there are any. `met` is told of all their hits in order and then of
/// their end; at a hit it says whether the walk goes on.
pub(super) fn follow<'a, P: Walking, T, R: Sampler>(
    (parts, scene, lanes): (&P, &'a Scene, Option<&Walks<'a>>),
    starts: impl Iterator<Item = Start<T, R>>,
    mut met: impl FnMut(Met<'_, 'a, T, R>) -> Result<bool, Error>,
) -> Result<(), Error> {
    if let Some(lanes) = lanes {
        return lanes.follow(starts, met);
    }
    for Start { mut item, ray, block, mut rng } in starts {
        let mut background = DVec3::ZERO;
        if let Some(ray) = ray {
            let mut walk = Walk::new(scene, (ray, scene.intersect(&ray)), block);
            let left = loop {
                let Some(step) = walk.arrive(&mut rng) else { break true };
                let at = step.vertex();
                if !met(Met::Hit(&mut item, &step, &at, &mut rng))? {
                    break false;
                }
                walk.scatter(parts, &at, &mut rng);
            };
            if left {
                background = walk.background();
            }
        }
        met(Met::End(item, background, rng))?;
    }
    Ok(())
}

/// About how many walks one thread takes at a time: what bidirectional paths keep of them fits its caches.
const PORTION: u32 = 256;

/// The numbers below `count` in portions, in parallel.
pub(super) fn in_portions(count: u32) -> impl IndexedParallelIterator<Item = Range<u32>> {
    let portions = (0..count.div_ceil(PORTION)).into_par_iter();
    portions.map(move |portion| portion * PORTION..count.min((portion * PORTION).saturating_add(PORTION)))
}

/// Lanes for walks of these parts, if they may be followed there.
pub(super) fn lanes_for<'a, P: Walking>(parts: &P, scene: &'a Scene) -> Option<Walks<'a>> {
    if parts.scatters_in_lanes() { Walks::new(scene) } else { None }
}

impl<'a> Walk<'a> {
    /// A walk along a ray that meets `hit`. The k-th hit draws from block `block` + k.
    #[inline]
    pub fn new(scene: &'a Scene, (ray, hit): (Ray, Option<Hit>), block: u32) -> Self {
        let (throughput, factor) = (DVec3::ONE, 1.0);
        Self { scene, ray, hit, throughput, raised: 1.0, early: 0, factor, pdf: None, block, hits: 0, ended: false }
    }

    /// The same walk, whose faint survivors roulette raises to this throughput in place of 1, and whose first hits, as
    /// many as this, are early.
    #[inline]
    pub fn raising_to(self, raised: f64, early: u32) -> Self {
        Self { raised, early, ..self }
    }

    /// The next hit; `None` where the walk has come to its end.
    #[inline]
    pub fn arrive<R: Sampler>(&mut self, rng: &mut R) -> Option<Step<'a>> {
        let here = self.hit?;
        self.hits += 1;
        rng.block(self.block + self.hits);
        let endless = self.hits > LONGEST_PATH;
        let throughput = if endless { DVec3::NAN } else { self.throughput };
        let (ray, factor) = (self.ray, self.factor);
        let bsdf = &self.scene.surface(&here).bsdf;
        Some(Step { ray, here, bsdf, throughput, factor, endless })
    }

    /// Goes on from the hit at which it arrived, whose [`Step::vertex`] is `at`, or ends there.
    #[inline]
    pub fn scatter<P: Walking, R: Sampler>(&mut self, parts: &P, at: &Vertex, rng: &mut R) {
        if self.hits > LONGEST_PATH || self.onward(parts, at, rng).is_none() {
            (self.hit, self.ended) = (None, true);
        }
    }

    #[inline]
    fn onward<P: Walking, R: Sampler>(&mut self, parts: &P, at: &Vertex, rng: &mut R) -> Option<()> {
        let here = self.hit?;
        let next = parts.sample(&self.scene.surface(&here).bsdf, at, rng)?;
        self.throughput *= next.weight;
        self.factor *= next.radiance_factor;
        self.throughput *= parts.survive(self.throughput / self.raised, self.hits <= self.early, uniform(rng))?;
        self.pdf = next.pdf;
        (self.ray, self.hit) = self.scene.onward(&here, next.direction);
        Some(())
    }

    /// What the background shows at the end of a walk that left the scene, as the start sees it; else zero.
    #[inline]
    pub fn background(&self) -> DVec3 {
        let shown = || self.scene.background().radiance(self.ray.direction);
        if self.ended { DVec3::ZERO } else { self.factor * self.throughput * shown() }
    }

    /// How many hits it has come to.
    #[inline]
    pub fn hits(&self) -> u32 {
        self.hits
    }

    /// The direction of the last ray, and its pdf with respect to solid angle; `None` from the start and from mirrors and
    /// glass.
    #[inline]
    pub fn last(&self) -> (DVec3, Option<f64>) {
        (self.ray.direction, self.pdf)
    }
}

impl<'a> Step<'a> {
    /// The hit as light that scatters there sees it.
    #[inline]
    pub fn vertex(&self) -> Vertex {
        Vertex::new(&self.here, &self.ray)
    }

    /// What an emitter shows here; zero elsewhere.
    #[inline]
    pub fn emitted(&self, scene: &Scene) -> DVec3 {
        scene.emitted(&self.here, self.ray.direction)
    }

    /// The hit, whose [`vertex`](Self::vertex) is `at`, as a vertex of a path that does not start here.
    #[inline]
    pub(super) fn path_vertex(&self, at: Vertex, carried: DVec3) -> PathVertex<'a> {
        PathVertex::hit(at, self.bsdf, (carried, 1.0 / self.factor), self.here.emitter)
    }
}
