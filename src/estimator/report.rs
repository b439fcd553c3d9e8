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

/// A ray on the way of light to the eye.
#[derive(Clone, Copy)]
struct Way {
    ray: Ray,
    hit: Option<Hit>,
    /// What the radiance along the ray is multiplied by.
    throughput: DVec3,
    /// How many segments remain; this ray is the first of them.
    segments: u32,
    /// Whether emitters that it hits are left to shadow rays.
    sampled: bool,
}

impl<P: Walking> Estimator for Report<P> {
    fn radiance<R: Sampler>(&self, scene: &Scene, ray: &Ray, hit: Option<Hit>, rng: &mut R) -> DVec3 {
        let mut radiance = DVec3::ZERO;
        let first = Way { ray: *ray, hit, throughput: DVec3::ONE, segments: self.segments, sampled: false };
        self.add(scene, &first, &mut radiance, rng);
        radiance
    }
}

impl<P: Walking> Report<P> {
    /// Adds the radiance that comes by this way.
    fn add<R: Sampler>(&self, scene: &Scene, way: &Way, radiance: &mut DVec3, rng: &mut R) {
        let parts = &self.parts;
        let Some(here) = way.hit else {
            *radiance += way.throughput * scene.background().radiance(way.ray.direction);
            return;
        };
        if parts.hit_counts(Strategy::Light, way.sampled) {
            *radiance += way.throughput * self.rules.seen(scene, &here, way.ray.direction);
        }
        let surface = scene.surface(&here);
        // The first segment is always followed, even of none.
        let is_last = way.segments <= 1;
        let onward = |direction, weight: DVec3, sampled| {
            let (ray, hit) = scene.onward(&here, direction);
            Way { ray, hit, throughput: way.throughput * weight, segments: way.segments - 1, sampled }
        };
        let bsdf = &surface.bsdf;
        let at = Vertex::new(&here, &way.ray);
        if !bsdf.is_rough() {
            let Some(next) = parts.sample(bsdf, &at, rng).filter(|_| !is_last) else {
                return;
            };
            // A shadow ray that passes through glass has looked behind it.
            let passed = self.rules.shadows_pass_glass && next.direction.dot(at.frame.z) < 0.0;
            let sampled = way.sampled && (passed || !self.rules.caustics);
            let factor = if self.rules.radiance_factor { next.radiance_factor } else { 1.0 };
            return self.add(scene, &onward(next.direction, factor * next.weight, sampled), radiance, rng);
        }
        if let Some(light) = direct_light(parts, scene, bsdf, &at, &self.rules, LightSampling::Area, rng) {
            *radiance += way.throughput * light.reflected;
        }
        let survival = parts.survival_by_absorption(surface.absorption);
        let share = parts.roulette_weight(survival) / f64::from(self.rays);
        for _ in 0..self.rays {
            if is_last || !parts.survives(uniform(rng), survival) {
                continue;
            }
            let sample = parts.sample_uniform(bsdf, at.wo, uniform2(rng));
            let direction = at.frame.world(sample.direction);
            self.add(scene, &onward(direction, share * sample.weight, true), radiance, rng);
        }
    }
}
