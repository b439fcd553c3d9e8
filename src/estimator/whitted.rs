//! Whitted ray tracing, section 2.1: [`crate::equation::WHITTED`].

use glam::DVec3;

use super::vertex::{Vertex, direct_light, interface, onward, seen};
use super::{Estimator, LightRules, Parts, Standard};
use crate::bsdf::Bsdf;
use crate::sampler::Sampler;
use crate::scene::{Hit, Scene};
use crate::shape::Ray;

/// Shadow rays at diffuse surfaces, and a tree of mirror and glass rays, both branches of glass
/// weighted by R and 1 − R. Light that meets two diffuse surfaces is left out.
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
        Self {
            parts: Standard,
            segments: 7,
            rules,
        }
    }
}

impl<P: Parts> Estimator for Whitted<P> {
    fn radiance<R: Sampler>(
        &self,
        scene: &Scene,
        ray: &Ray,
        hit: Option<Hit>,
        rng: &mut R,
    ) -> DVec3 {
        self.arriving(scene, ray, hit, self.segments, rng)
    }
}

impl<P: Parts> Whitted<P> {
    fn arriving<R: Sampler>(
        &self,
        scene: &Scene,
        ray: &Ray,
        hit: Option<Hit>,
        segments: u32,
        rng: &mut R,
    ) -> DVec3 {
        let parts = &self.parts;
        let Some(here) = hit else {
            return scene.background();
        };
        let emitted = seen(scene, &here, ray, &self.rules);
        let scattered = match scene.surface(&here).bsdf {
            Bsdf::Black => DVec3::ZERO,
            ref bsdf @ (Bsdf::Lambert { .. } | Bsdf::OrenNayar { .. }) => {
                let vertex = Vertex::new(&here, ray);
                direct_light(parts, scene, bsdf, &vertex, &self.rules, rng)
                    .map_or(DVec3::ZERO, |light| light.reflected)
            }
            Bsdf::Mirror { reflectance } => {
                let direction = parts.mirror(ray.direction, here.normal);
                reflectance * self.next(scene, &here, direction, segments, rng)
            }
            Bsdf::Glass { index } => {
                let (n1, n2, normal) = interface(&here, ray, index);
                let share = parts.fresnel(-ray.direction.dot(normal), n1, n2);
                let mirrored = parts.mirror(ray.direction, normal);
                let reflected = share * self.next(scene, &here, mirrored, segments, rng);
                let Some(refracted) = parts.refract(ray.direction, normal, n1, n2) else {
                    return emitted + reflected;
                };
                let factor = if self.rules.radiance_factor {
                    parts.radiance_factor(n1, n2)
                } else {
                    1.0
                };
                let transmitted = self.next(scene, &here, refracted, segments, rng);
                reflected + (1.0 - share) * factor * transmitted
            }
        };
        emitted + scattered
    }

    /// Radiance that arrives at a hit from a direction; zero where the segments are used up.
    fn next<R: Sampler>(
        &self,
        scene: &Scene,
        here: &Hit,
        direction: DVec3,
        segments: u32,
        rng: &mut R,
    ) -> DVec3 {
        if segments == 1 {
            return DVec3::ZERO;
        }
        let (ray, hit) = onward(scene, here, direction);
        self.arriving(scene, &ray, hit, segments - 1, rng)
    }
}
