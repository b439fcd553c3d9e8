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

/// A ray on the way of light to the eye.
#[derive(Clone, Copy)]
struct Way {
    ray: Ray,
    hit: Option<Hit>,
    /// What the radiance along the ray is multiplied by.
    throughput: DVec3,
    /// How many segments remain; this ray is the first of them.
    segments: u32,
}

impl<P: Scattering + NextEvent> Estimator for Whitted<P> {
    fn radiance<R: Sampler>(&self, scene: &Scene, ray: &Ray, hit: Option<Hit>, rng: &mut R) -> DVec3 {
        let mut radiance = DVec3::ZERO;
        let first = Way { ray: *ray, hit, throughput: DVec3::ONE, segments: self.segments };
        self.add(scene, &first, &mut radiance, rng);
        radiance
    }
}

impl<P: Scattering + NextEvent> Whitted<P> {
    /// Adds the radiance that comes by this way: of glass first what is reflected, then what is refracted.
    fn add<R: Sampler>(&self, scene: &Scene, way: &Way, radiance: &mut DVec3, rng: &mut R) {
        let parts = &self.parts;
        let Some(here) = way.hit else {
            *radiance += way.throughput * scene.background().radiance(way.ray.direction);
            return;
        };
        *radiance += way.throughput * self.rules.seen(scene, &here, way.ray.direction);
        let at = Vertex::new(&here, &way.ray);
        let (direction, normal) = (at.direction, at.frame.z);
        let mut follow = |direction, weight: DVec3, rng: &mut R| {
            // The first segment is always followed, even of none.
            if way.segments > 1 {
                let (ray, hit) = scene.onward(&here, direction);
                let next = Way { ray, hit, throughput: way.throughput * weight, segments: way.segments - 1 };
                self.add(scene, &next, radiance, rng);
            }
        };
        match scene.surface(&here).bsdf {
            Bsdf::Mirror { reflectance } => follow(parts.mirror(direction, normal), reflectance, rng),
            Bsdf::Glass { index } => {
                let (n1, n2) = at.indices(index);
                let share = parts.fresnel(-direction.dot(normal), n1, n2);
                follow(parts.mirror(direction, normal), DVec3::splat(share), rng);
                if let Some(refracted) = parts.refract(direction, normal, n1, n2) {
                    let factor = if self.rules.radiance_factor { parts.radiance_factor(n1, n2) } else { 1.0 };
                    follow(refracted, DVec3::splat((1.0 - share) * factor), rng);
                }
            }
            ref bsdf if bsdf.is_rough() => {
                let light = direct_light(parts, scene, bsdf, &at, &self.rules, LightSampling::Area, rng);
                *radiance += way.throughput * light.map_or(DVec3::ZERO, |light| light.reflected);
            }
            _ => {}
        }
    }
}
