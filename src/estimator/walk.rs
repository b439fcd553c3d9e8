//! A random walk from hit to hit, for paths from the eye and from lights alike.

use glam::DVec3;

use super::strategies::PathVertex;
use super::{LONGEST_PATH, Walking};
use crate::bsdf::{Bsdf, Vertex};
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
pub(super) struct Step<'a> {
    /// The ray that arrived, and what it hit.
    pub ray: Ray,
    pub here: Hit,
    pub bsdf: &'a Bsdf,
    /// Product of the weights of all scattering on the way, without radiance factors: they cancel when the
    /// walk leaves the glass, and roulette should not see them. NaN in an endless walk.
    pub throughput: DVec3,
    /// Product of the radiance factors on the way.
    pub factor: f64,
    /// The pdf of the ray's direction with respect to solid angle; `None` from the start and from mirrors and glass.
    pub pdf: Option<f64>,
    /// Whether this is the hit after [`LONGEST_PATH`], where a walk that will not end is given up.
    pub endless: bool,
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
        let (ray, factor, pdf) = (self.ray, self.factor, self.pdf);
        let bsdf = &self.scene.surface(&here).bsdf;
        Some(Step { ray, here, bsdf, throughput, factor, pdf, endless })
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

    /// The direction of the last ray, and its pdf with respect to solid angle as in [`Step::pdf`].
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
    pub fn path_vertex(&self, at: Vertex, carried: DVec3) -> PathVertex<'a> {
        let (squared_index, emitter) = (1.0 / self.factor, self.here.emitter);
        PathVertex { at, bsdf: Some(self.bsdf), carried, squared_index, emitter, picked: None }
    }
}
