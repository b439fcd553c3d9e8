//! The report's Monte Carlo estimator: at each diffuse hit a shadow ray and N sample rays over the
//! uniform hemisphere, each ended by Russian roulette, at most seven segments from the eye.

use glam::DVec3;

use super::vertex::{Vertex, direct_light, interface, onward, scatter_glass, seen};
use super::{Estimator, LightRules, Parts, Standard};
use crate::bsdf::Bsdf;
use crate::radiometry::reflected;
use crate::rng::{uniform, uniform2};
use crate::sampler::Sampler;
use crate::scene::{Hit, Scene};
use crate::shape::Ray;

/// The report's estimator. Its limit on segments is a bias, [`crate::equation::PATH_LENGTH`].
#[derive(Clone, Copy, Debug)]
pub struct Report<P = Standard> {
    /// Its parts.
    pub parts: P,
    /// N of (16): sample rays per diffuse hit.
    pub rays: u32,
    /// Ray segments from the eye at most, whatever the kind of bounce.
    pub segments: u32,
    /// What is seen of emitters, and what shadow rays pass.
    pub rules: LightRules,
}

impl Default for Report {
    fn default() -> Self {
        Self {
            parts: Standard,
            rays: 1,
            segments: 7,
            rules: LightRules::REPORT,
        }
    }
}

impl<P: Parts> Estimator for Report<P> {
    fn radiance<R: Sampler>(
        &self,
        scene: &Scene,
        ray: &Ray,
        hit: Option<Hit>,
        rng: &mut R,
    ) -> DVec3 {
        self.arriving(scene, ray, hit, self.segments, true, rng)
    }
}

impl<P: Parts> Report<P> {
    /// Radiance along a ray, which is the first of `segments` that remain; `direct` says whether only
    /// mirrors and glass came before, so that no shadow ray has counted the emitters.
    fn arriving<R: Sampler>(
        &self,
        scene: &Scene,
        ray: &Ray,
        hit: Option<Hit>,
        segments: u32,
        direct: bool,
        rng: &mut R,
    ) -> DVec3 {
        let parts = &self.parts;
        let Some(here) = hit else {
            return scene.background();
        };
        let mut radiance = if direct {
            seen(scene, &here, ray, &self.rules)
        } else {
            DVec3::ZERO
        };
        let surface = scene.surface(&here);
        match surface.bsdf {
            Bsdf::Black => {}
            Bsdf::Mirror { reflectance } => {
                let direction = parts.mirror(ray.direction, here.normal);
                radiance += reflectance * self.next(scene, &here, direction, segments, direct, rng);
            }
            Bsdf::Glass { index } => {
                let sides = interface(&here, ray, index);
                let (direction, factor) = scatter_glass(parts, sides, ray.direction, uniform(rng));
                let factor = if self.rules.radiance_factor {
                    factor
                } else {
                    1.0
                };
                radiance += factor * self.next(scene, &here, direction, segments, direct, rng);
            }
            ref bsdf @ (Bsdf::Lambert { .. } | Bsdf::OrenNayar { .. }) => {
                let vertex = Vertex::new(&here, ray);
                if let Some(light) = direct_light(parts, scene, bsdf, &vertex, &self.rules, rng) {
                    radiance += light.reflected;
                }
                let survival = parts.survival_by_absorption(surface.absorption);
                let share = parts.roulette_weight(survival) / f64::from(self.rays);
                for _ in 0..self.rays {
                    if segments == 1 || !parts.survives(uniform(rng), survival) {
                        continue;
                    }
                    let wi = parts.uniform_hemisphere(uniform2(rng));
                    let direction = vertex.frame.world(wi);
                    let arriving = self.next(scene, &here, direction, segments, false, rng);
                    let brdf = parts.brdf(bsdf, vertex.wo, wi);
                    let cosine = parts.cosine(DVec3::Z, wi);
                    let pdf = parts.uniform_hemisphere_pdf(wi.z);
                    radiance += share * reflected(brdf, arriving, cosine, pdf);
                }
            }
        }
        radiance
    }

    /// Radiance that arrives at a hit from a direction; zero where the segments are used up.
    fn next<R: Sampler>(
        &self,
        scene: &Scene,
        here: &Hit,
        direction: DVec3,
        segments: u32,
        direct: bool,
        rng: &mut R,
    ) -> DVec3 {
        if segments == 1 {
            return DVec3::ZERO;
        }
        let (ray, hit) = onward(scene, here, direction);
        self.arriving(scene, &ray, hit, segments - 1, direct, rng)
    }
}
