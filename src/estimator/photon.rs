//! Photon mapping (Jensen 1996): light carried by particles, looked up by paths from the eye.

use glam::DVec3;

use super::next_event::{SHADOW_RAYS, direct_light};
use super::photon_map::{Kept, PhotonMap, Photons, check_radius};
use super::walk::Walk;
use super::{Estimator, LightRules, Sample, Walking};
use crate::bsdf::Vertex;
use crate::error::Error;
use crate::sampler::{Pass, Sampler};
use crate::scene::{Hit, Scene};
use crate::shape::Ray;

/// Where the photons are looked up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lookup {
    /// At the first diffuse surface that the eye sees: all of its light by photons.
    Direct,
    /// At the second: the first gets direct light by a shadow ray, caustics by photons of their own, and all
    /// other light by one ray in a cosine-weighted direction (final gathering).
    Gather {
        /// Particles emitted for the caustic map.
        caustic_particles: u32,
        /// Radius of its lookups.
        caustic_radius: f64,
    },
}

/// An estimator with the bias of [`crate::equation::PHOTON_DENSITY`], for light that leaves an emitter: none
/// starts from the background.
///
/// Its estimates share the photons: their mean tends to what this map says, and their standard error
/// knows nothing of the map's own. Maps of different seeds are independent replications.
#[derive(Clone, Debug)]
pub struct PhotonMapping<P> {
    parts: P,
    all: PhotonMap,
    radius: f64,
    /// The caustic photons and their radius, for final gathering.
    caustics: Option<(PhotonMap, f64)>,
}

/// The first diffuse surface that a path meets by mirrors and glass alone.
struct Arrival {
    hit: Hit,
    at: Vertex,
    /// What radiance that leaves it along the path is multiplied by.
    throughput: DVec3,
    /// Its block of random numbers.
    block: u32,
}

/// An arrival as photons will be looked up there for a sample.
struct Query {
    sample: u32,
    surface: u32,
    point: DVec3,
    /// Of the surface, and the direction of the ray that arrived.
    normal: DVec3,
    direction: DVec3,
    throughput: DVec3,
}

impl Query {
    fn new(sample: usize, &Arrival { hit, at, throughput, .. }: &Arrival) -> Self {
        let Hit { point, normal, surface, .. } = hit;
        Self { sample: sample as u32, surface, point, normal, direction: at.direction, throughput }
    }
}

impl<P: Photons + Walking> PhotonMapping<P> {
    /// Sends `particles` ≥ 1 from the emitters and keeps their photons, to be looked up within `radius` > 0,
    /// in the scene's units. The photons are functions of the pass.
    ///
    /// # Errors
    /// Those of [`PhotonMap::new`].
    pub fn new(
        parts: P,
        scene: &Scene,
        lookup: Lookup,
        (particles, radius): (u32, f64),
        pass: impl Into<Pass>,
    ) -> Result<Self, Error> {
        let pass = pass.into();
        check_radius(radius)?;
        if let Lookup::Gather { caustic_radius, .. } = lookup {
            check_radius(caustic_radius)?;
        }
        let map = |kept, particles, name| PhotonMap::new(&parts, scene, kept, particles, pass.of(name));
        let all = map(Kept::All, particles, "photons")?;
        let caustics = match lookup {
            Lookup::Direct => None,
            Lookup::Gather { caustic_particles, caustic_radius } => {
                let map = map(Kept::Caustic, caustic_particles, "caustics")?;
                Some((map, caustic_radius))
            }
        };
        Ok(Self { all, radius, caustics, parts })
    }

    /// Follows mirrors and glass to the first diffuse surface, the k-th hit by block `block` + k, and calls `see` with
    /// what emitters on the way show along the path.
    fn arrive<R: Sampler>(
        &self,
        scene: &Scene,
        start: (Ray, Option<Hit>),
        block: u32,
        rng: &mut R,
        mut see: impl FnMut(DVec3),
    ) -> Option<Arrival> {
        let mut walk = Walk::new(scene, start, block);
        for hits in 1.. {
            let step = walk.arrive(rng)?;
            if step.here.emitter.is_some() {
                see(step.factor * step.throughput * step.emitted(scene));
            }
            if step.endless || step.bsdf.is_rough() {
                let throughput = step.factor * step.throughput;
                return Some(Arrival { hit: step.here, at: step.vertex(), throughput, block: block + hits });
            }
            walk.scatter(&self.parts, &step.vertex(), rng);
        }
        None
    }

    /// The first diffuse surface that light has met before it is scattered at this one, to be looked up there.
    fn gather<R: Sampler>(
        &self,
        scene: &Scene,
        at: &Arrival,
        rng: &mut R,
        mut see: impl FnMut(DVec3),
    ) -> Option<Arrival> {
        let next = self.parts.sample(&scene.surface(&at.hit).bsdf, &at.at, rng)?;
        let weight = at.throughput * next.weight;
        let way = scene.onward(&at.hit, next.direction);
        let see = |emission| {
            if self.parts.gathers_emission() {
                see(weight * emission);
            }
        };
        let there = self.arrive(scene, way, at.block, rng, see)?;
        Some(Arrival { throughput: weight * there.throughput, ..there })
    }

    /// Adds what surfaces reflect by the photons of a map: neighbours one after the other, for they share photons, which
    /// are in the caches then.
    fn look_up(
        &self,
        scene: &Scene,
        (map, radius): (&PhotonMap, f64),
        mut queries: Vec<Query>,
        radiances: &mut [DVec3],
    ) {
        queries.sort_by_cached_key(|at| map.place(at.point));
        for Query { sample, surface, point, normal, direction, throughput } in queries {
            let bsdf = &scene.surfaces()[surface as usize].bsdf;
            let vertex = Vertex::of(point, normal, direction);
            radiances[sample as usize] += throughput * map.reflected(&self.parts, bsdf, &vertex, radius);
        }
    }
}

impl<P: Photons + Walking> Estimator for PhotonMapping<P> {
    const TOGETHER: u32 = 1 << 16;

    fn radiance<R: Sampler>(&self, scene: &Scene, ray: &Ray, hit: Option<Hit>, rng: &mut R) -> DVec3 {
        self.radiances(scene, std::iter::once(Sample { ray: *ray, hit, rng }))[0]
    }

    fn radiances<R: Sampler>(&self, scene: &Scene, samples: impl Iterator<Item = Sample<R>>) -> Vec<DVec3> {
        let (count, _) = samples.size_hint();
        let mut radiances = Vec::with_capacity(count);
        let [mut of_all, mut of_caustics] = [(); 2].map(|()| Vec::with_capacity(count));
        for (i, Sample { ray, hit, mut rng }) in samples.enumerate() {
            radiances.push(DVec3::ZERO);
            let mut see = |emission| radiances[i] += emission;
            let Some(here) = self.arrive(scene, (ray, hit), 0, &mut rng, &mut see) else {
                continue;
            };
            if self.caustics.is_none() {
                of_all.push(Query::new(i, &here));
                continue;
            }
            let bsdf = &scene.surface(&here.hit).bsdf;
            let rules = &LightRules::PHYSICAL;
            if let Some(light) = direct_light(&self.parts, scene, bsdf, &here.at, rules, SHADOW_RAYS, &mut rng) {
                see(here.throughput * light.reflected);
            }
            of_all.extend(self.gather(scene, &here, &mut rng, see).map(|there| Query::new(i, &there)));
            of_caustics.push(Query::new(i, &here));
        }
        self.look_up(scene, (&self.all, self.radius), of_all, &mut radiances);
        if let Some((caustics, radius)) = &self.caustics {
            self.look_up(scene, (caustics, *radius), of_caustics, &mut radiances);
        }
        radiances
    }
}
