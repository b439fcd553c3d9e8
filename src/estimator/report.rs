//! The report's Monte Carlo estimator: at each diffuse hit a shadow ray and N sample rays over the
//! uniform hemisphere, each ended by Russian roulette, at most seven segments from the eye.
//!
//! The text does not say what a ray shows that hits an emitter. By (8) all that arrives counts, once: a
//! hit counts where no shadow ray has looked for the same light, which is before the first diffuse surface
//! and, from a diffuse surface on, by way of mirrors and glass. The text leaves that second kind, caustics,
//! to later work (3.3), and [`LightRules::REPORT`] leaves it out.

use glam::DVec3;

use super::next_event::direct_light;
use super::{Estimator, LightRules, Standard, Strategy, Walking};
use crate::bsdf::Vertex;
use crate::emitter::LightSampling;
use crate::rng::{uniform, uniform2};
use crate::sampler::Sampler;
use crate::scene::{Hit, Scene};
use crate::shape::Ray;

/// The report's estimator. Its limit on segments is a bias, [`crate::equation::PATH_LENGTH`].
#[derive(Clone, Copy, Debug)]
pub struct Report<P = Standard> {
    /// Its parts.
    pub parts: P,
    /// N of (16): sample rays per diffuse hit; of none there is direct light alone.
    pub rays: u32,
    /// Ray segments from the eye at most, whatever the kind of bounce.
    pub segments: u32,
    /// What is seen of emitters, and what shadow rays pass.
    pub rules: LightRules,
}

impl Default for Report {
    fn default() -> Self {
        Self { parts: Standard, rays: 1, segments: 7, rules: LightRules::REPORT }
    }
}

impl<P: Walking> Estimator for Report<P> {
    fn radiance<R: Sampler>(&self, scene: &Scene, ray: &Ray, hit: Option<Hit>, rng: &mut R) -> DVec3 {
        self.arriving(scene, ray, hit, self.segments, false, rng)
    }
}

impl<P: Walking> Report<P> {
    /// Radiance along a ray, which is the first of `segments` that remain; `sampled` says whether emitters
    /// that it hits are left to shadow rays.
    fn arriving<R: Sampler>(
        &self,
        scene: &Scene,
        ray: &Ray,
        hit: Option<Hit>,
        segments: u32,
        sampled: bool,
        rng: &mut R,
    ) -> DVec3 {
        let parts = &self.parts;
        let Some(here) = hit else {
            return scene.background();
        };
        let mut radiance = if parts.hit_counts(Strategy::Light, sampled) {
            self.rules.seen(scene, &here, ray.direction)
        } else {
            DVec3::ZERO
        };
        let surface = scene.surface(&here);
        let next = |direction, sampled, rng: &mut R| {
            // The first segment is always followed, even of none.
            if segments <= 1 {
                return DVec3::ZERO;
            }
            let (ray, hit) = scene.onward(&here, direction);
            self.arriving(scene, &ray, hit, segments - 1, sampled, rng)
        };
        let bsdf = &surface.bsdf;
        let at = Vertex::new(&here, ray);
        if !bsdf.is_rough() {
            let Some(way) = parts.sample(bsdf, &at, rng) else {
                return radiance;
            };
            // A shadow ray that passes through glass has looked behind it.
            let passed = self.rules.shadows_pass_glass && way.direction.dot(at.frame.z) < 0.0;
            let sampled = sampled && (passed || !self.rules.caustics);
            let factor = if self.rules.radiance_factor { way.radiance_factor } else { 1.0 };
            return radiance + factor * way.weight * next(way.direction, sampled, rng);
        }
        if let Some(light) = direct_light(parts, scene, bsdf, &at, &self.rules, LightSampling::Area, rng) {
            radiance += light.reflected;
        }
        let survival = parts.survival_by_absorption(surface.absorption);
        let share = parts.roulette_weight(survival) / f64::from(self.rays);
        for _ in 0..self.rays {
            if segments <= 1 || !parts.survives(uniform(rng), survival) {
                continue;
            }
            let sample = parts.sample_uniform(bsdf, at.wo, uniform2(rng));
            let direction = at.frame.world(sample.direction);
            radiance += share * sample.weight * next(direction, true, rng);
        }
        radiance
    }
}
