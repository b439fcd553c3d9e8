//! The path tracer: light found by shadow rays, by directions of the BRDF's cosine, or by both with
//! multiple importance sampling; Russian roulette, no bounce limit.

use glam::DVec3;

use super::next_event::{direct_light, emitter_pdf};
use super::steps::{emitted, onward};
use super::{Estimator, LONGEST_PATH, LightRules, Standard, Walking};
use crate::bsdf::{Bsdf, Vertex};
use crate::emitter::LightSampling;
use crate::rng::uniform;
use crate::sampler::Sampler;
use crate::scene::{Hit, Scene};
use crate::shape::Ray;

/// How light that reaches a diffuse surface straight from an emitter is found. Each counts it once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Strategy {
    /// By the directions in which paths go on, which hit emitters by chance.
    Bsdf,
    /// By shadow rays to points on emitters. With points uniform in area its variance is infinite in
    /// corners of emitting rooms: the geometry term has no bound.
    Light,
    /// By both, weighted by a [`Heuristic`].
    #[default]
    Mis,
}

/// How multiple importance sampling weights: any of them leaves the mean as it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Heuristic {
    /// [`NextEvent::mis_weight`](super::NextEvent::mis_weight).
    #[default]
    Balance,
    /// [`NextEvent::mis_power_weight`](super::NextEvent::mis_power_weight).
    Power,
}

/// An unbiased estimator of (8) on every scene.
#[derive(Clone, Copy, Debug, Default)]
pub struct Path<P = Standard> {
    /// Its parts.
    pub parts: P,
    /// How it finds direct light.
    pub strategy: Strategy,
    /// How its shadow rays pick points.
    pub lights: LightSampling,
    /// How [`Strategy::Mis`] weights.
    pub heuristic: Heuristic,
}

impl<P> Path<P> {
    /// With the default light sampling and heuristic.
    pub fn new(parts: P, strategy: Strategy) -> Self {
        Self { parts, strategy, lights: LightSampling::default(), heuristic: Heuristic::default() }
    }
}

impl<P: Walking> Path<P> {
    /// The weight of an emitter that the path hit, by a direction of pdf `pdf` (with respect to solid
    /// angle; `None` where no shadow ray could have found the same light).
    #[inline]
    fn weight_of_hit(&self, scene: &Scene, here: &Hit, ray: &Ray, pdf: Option<f64>) -> f64 {
        match (pdf, self.strategy, here.emitter) {
            (Some(pdf), Strategy::Mis, Some(index)) => {
                let emitter = &scene.emitters()[index as usize];
                let other = emitter_pdf(&self.parts, scene, emitter, self.lights, (ray, here));
                self.weight(pdf, other)
            }
            _ => f64::from(self.parts.hit_counts(self.strategy, pdf.is_some())),
        }
    }

    /// The weight of a sample of pdf `pdf` that the other strategy finds with pdf `other`.
    #[inline]
    fn weight(&self, pdf: f64, other: f64) -> f64 {
        match self.heuristic {
            Heuristic::Balance => self.parts.mis_weight(pdf, other),
            Heuristic::Power => self.parts.mis_power_weight(pdf, other),
        }
    }

    /// Light by a shadow ray from a vertex, weighted; zero for the strategy that sends none.
    #[inline]
    fn shadow_ray<R: Sampler>(&self, scene: &Scene, bsdf: &Bsdf, at: &Vertex, rng: &mut R) -> DVec3 {
        if !bsdf.is_rough() || self.strategy == Strategy::Bsdf {
            return DVec3::ZERO;
        }
        let (parts, rules) = (&self.parts, &LightRules::PHYSICAL);
        let light = direct_light(parts, scene, bsdf, at, rules, self.lights, rng);
        let Some(light) = light else {
            return DVec3::ZERO;
        };
        let weight = if self.strategy == Strategy::Mis {
            let other = self.parts.pdf(bsdf, at.wo, light.wi);
            self.weight(light.pdf, other)
        } else {
            1.0
        };
        weight * light.reflected
    }
}

impl<P: Walking> Estimator for Path<P> {
    #[inline]
    fn radiance<R: Sampler>(&self, scene: &Scene, ray: &Ray, hit: Option<Hit>, rng: &mut R) -> DVec3 {
        let (mut ray, mut hit) = (*ray, hit);
        let mut radiance = DVec3::ZERO;
        // Without the radiance factors of refraction, whose product is kept beside it: they cancel when
        // the path leaves the glass, and roulette should not see them.
        let mut throughput = DVec3::ONE;
        let mut factor = 1.0;
        // Pdf of the last direction if a shadow ray could have found the same light.
        let mut shared_pdf = None;
        for vertex in 1..=LONGEST_PATH {
            let Some(here) = hit else {
                return radiance + factor * throughput * scene.background();
            };
            rng.block(vertex);
            if here.emitter.is_some() {
                let weight = self.weight_of_hit(scene, &here, &ray, shared_pdf);
                radiance += factor * weight * throughput * emitted(scene, &here, &ray);
            }
            let bsdf = &scene.surface(&here).bsdf;
            if matches!(bsdf, Bsdf::Black) {
                return radiance;
            }
            let at = Vertex::new(&here, &ray);
            radiance += factor * throughput * self.shadow_ray(scene, bsdf, &at, rng);
            let Some(next) = self.parts.sample(bsdf, &at, rng) else {
                return radiance;
            };
            throughput *= next.weight;
            factor *= next.radiance_factor;
            shared_pdf = next.pdf;
            let Some(weight) = self.parts.survive(throughput, uniform(rng)) else {
                return radiance;
            };
            throughput *= weight;
            (ray, hit) = onward(scene, &here, next.direction);
        }
        DVec3::NAN
    }
}
