//! Whitted ray tracing, section 2.1: [`crate::equation::WHITTED`].

use glam::DVec3;

use super::next_event::{NextEvent, direct_light};
use super::{Estimator, LightRules, Standard};
use crate::bsdf::{Bsdf, Scattering, Vertex};
use crate::emitter::LightSampling;
use crate::sampler::Sampler;
use crate::scene::{Hit, Scene};
use crate::shape::Ray;

/// Shadow rays at diffuse surfaces, and a tree of mirror and glass rays, both branches of glass
/// weighted by R and 1 − R: emission and direct light of the first diffuse surface, seen through mirrors and
/// glass alone. Left out is what arrives there in any other way: from a further diffuse surface, or from an
/// emitter by way of mirrors and glass (caustics), or from the background.
#[derive(Clone, Copy, Debug)]
pub struct Whitted<P = Standard> {
    /// Its parts.
    pub parts: P,
    /// Ray segments from the eye at most: the tree doubles at each glass surface. A bias.
    pub segments: u32,
    /// What is seen of emitters, and what shadow rays pass.
    pub rules: LightRules,
}

impl Whitted {
    /// With the report's limit of seven segments.
    pub fn new(rules: LightRules) -> Self {
        Self { parts: Standard, segments: 7, rules }
    }
}

impl<P: Scattering + NextEvent> Estimator for Whitted<P> {
    fn radiance<R: Sampler>(&self, scene: &Scene, ray: &Ray, hit: Option<Hit>, rng: &mut R) -> DVec3 {
        self.arriving(scene, ray, hit, self.segments, rng)
    }
}

impl<P: Scattering + NextEvent> Whitted<P> {
    fn arriving<R: Sampler>(&self, scene: &Scene, ray: &Ray, hit: Option<Hit>, segments: u32, rng: &mut R) -> DVec3 {
        let parts = &self.parts;
        let Some(here) = hit else {
            return scene.background().radiance(ray.direction);
        };
        let next = |direction, rng: &mut R| {
            // The first segment is always followed, even of none.
            if segments <= 1 {
                return DVec3::ZERO;
            }
            let (ray, hit) = scene.onward(&here, direction);
            self.arriving(scene, &ray, hit, segments - 1, rng)
        };
        let emitted = self.rules.seen(scene, &here, ray.direction);
        let at = Vertex::new(&here, ray);
        let (direction, normal) = (at.direction, at.frame.z);
        let scattered = match scene.surface(&here).bsdf {
            Bsdf::Mirror { reflectance } => reflectance * next(parts.mirror(direction, normal), rng),
            Bsdf::Glass { index } => {
                let (n1, n2) = at.indices(index);
                let share = parts.fresnel(-direction.dot(normal), n1, n2);
                let reflected = share * next(parts.mirror(direction, normal), rng);
                let Some(refracted) = parts.refract(direction, normal, n1, n2) else {
                    // From within, where no surface emits.
                    return reflected;
                };
                let factor = if self.rules.radiance_factor { parts.radiance_factor(n1, n2) } else { 1.0 };
                let transmitted = next(refracted, rng);
                reflected + (1.0 - share) * factor * transmitted
            }
            ref bsdf if bsdf.is_rough() => direct_light(parts, scene, bsdf, &at, &self.rules, LightSampling::Area, rng)
                .map_or(DVec3::ZERO, |light| light.reflected),
            _ => DVec3::ZERO,
        };
        emitted + scattered
    }
}
