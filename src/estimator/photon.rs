//! Photon mapping (Jensen 1996): light carried by particles, looked up by paths from the eye.

use glam::DVec3;

use super::next_event::{SHADOW_RAYS, direct_light};
use super::photon_map::{Kept, PhotonMap, Photons, check_radius};
use super::walk::Walk;
use super::{Estimator, LightRules, Walking};
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

    /// What a surface reflects by the photons of a map.
    fn looked_up(&self, scene: &Scene, at: &Arrival, map: &PhotonMap, radius: f64) -> DVec3 {
        let bsdf = &scene.surface(&at.hit).bsdf;
        map.reflected(&self.parts, bsdf, &at.at, radius)
    }

    /// Light that a surface reflects after at least one other diffuse surface.
    fn gathered<R: Sampler>(&self, scene: &Scene, at: &Arrival, rng: &mut R) -> DVec3 {
        let bsdf = &scene.surface(&at.hit).bsdf;
        let Some(next) = self.parts.sample(bsdf, &at.at, rng) else {
            return DVec3::ZERO;
        };
        let way = scene.onward(&at.hit, next.direction);
        let mut radiance = DVec3::ZERO;
        let see = |emission| {
            if self.parts.gathers_emission() {
                radiance += emission;
            }
        };
        if let Some(there) = self.arrive(scene, way, at.block, rng, see) {
            radiance += there.throughput * self.looked_up(scene, &there, &self.all, self.radius);
        }
        next.weight * radiance
    }
}

impl<P: Photons + Walking> Estimator for PhotonMapping<P> {
    fn radiance<R: Sampler>(&self, scene: &Scene, ray: &Ray, hit: Option<Hit>, rng: &mut R) -> DVec3 {
        let mut radiance = DVec3::ZERO;
        let see = |emission| radiance += emission;
        let Some(here) = self.arrive(scene, (*ray, hit), 0, rng, see) else {
            return radiance;
        };
        let reflected = match &self.caustics {
            None => self.looked_up(scene, &here, &self.all, self.radius),
            Some((caustics, caustic_radius)) => {
                let bsdf = &scene.surface(&here.hit).bsdf;
                let rules = &LightRules::PHYSICAL;
                let light = direct_light(&self.parts, scene, bsdf, &here.at, rules, SHADOW_RAYS, rng);
                light.map_or(DVec3::ZERO, |light| light.reflected)
                    + self.looked_up(scene, &here, caustics, *caustic_radius)
                    + self.gathered(scene, &here, rng)
            }
        };
        radiance + here.throughput * reflected
    }
}
