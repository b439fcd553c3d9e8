//! The path tracer: light found by shadow rays, by directions of the BRDF's cosine, or by both with
//! multiple importance sampling; Russian roulette, no bounce limit.

use glam::DVec3;

use super::vertex::{
    Scattered, Vertex, direct_light, emitted, emitter_pdf, onward, scatter, survive,
};
use super::{Estimator, LightRules, Parts, Standard};
use crate::bsdf::Bsdf;
use crate::sampler::Sampler;
use crate::scene::{Hit, Scene};
use crate::shape::Ray;

/// How light that reaches a diffuse surface straight from an emitter is found. Each counts it once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Strategy {
    /// By the directions in which paths go on, which hit emitters by chance.
    Bsdf,
    /// By shadow rays to points on emitters. In corners of emitting rooms its variance is infinite: the
    /// geometry term has no bound.
    Light,
    /// By both, weighted by [`Parts::mis_weight`].
    #[default]
    Mis,
}

/// An unbiased estimator of (8) on every scene.
#[derive(Clone, Copy, Debug, Default)]
pub struct Path<P = Standard> {
    /// Its parts.
    pub parts: P,
    /// How it finds direct light.
    pub strategy: Strategy,
}

impl<P: Parts> Path<P> {
    /// The weight of an emitter that the path hit, by a direction of pdf `pdf` (with respect to solid
    /// angle; `None` where no shadow ray could have found the same light).
    #[inline]
    fn weight_of_hit(&self, scene: &Scene, here: &Hit, ray: &Ray, pdf: Option<f64>) -> f64 {
        match (pdf, self.strategy, here.emitter) {
            (Some(_), Strategy::Light, _) => 0.0,
            (Some(pdf), Strategy::Mis, Some(index)) => {
                let cosine = self.parts.cosine(here.normal, -ray.direction);
                let emitter = &scene.emitters()[index as usize];
                let other = emitter_pdf(&self.parts, scene, emitter, cosine, here.t * here.t);
                self.parts.mis_weight(pdf, other)
            }
            _ => 1.0,
        }
    }

    /// Light by a shadow ray from a diffuse hit, weighted; zero for the strategy that sends none.
    #[inline]
    fn shadow_ray<R: Sampler>(&self, scene: &Scene, here: &Hit, ray: &Ray, rng: &mut R) -> DVec3 {
        let bsdf = &scene.surface(here).bsdf;
        let diffuse = matches!(bsdf, Bsdf::Lambert { .. } | Bsdf::OrenNayar { .. });
        if !diffuse || self.strategy == Strategy::Bsdf {
            return DVec3::ZERO;
        }
        let vertex = Vertex::new(here, ray);
        let rules = &LightRules::PHYSICAL;
        let Some(light) = direct_light(&self.parts, scene, bsdf, &vertex, rules, rng) else {
            return DVec3::ZERO;
        };
        let weight = if self.strategy == Strategy::Mis {
            let other = self.parts.cosine_hemisphere_pdf(light.wi.z);
            self.parts.mis_weight(light.pdf, other)
        } else {
            1.0
        };
        weight * light.reflected
    }
}

impl<P: Parts> Estimator for Path<P> {
    #[inline]
    fn radiance<R: Sampler>(
        &self,
        scene: &Scene,
        ray: &Ray,
        hit: Option<Hit>,
        rng: &mut R,
    ) -> DVec3 {
        let (mut ray, mut hit) = (*ray, hit);
        let mut radiance = DVec3::ZERO;
        // Without the radiance factors of refraction, whose product is kept beside it: they cancel when
        // the path leaves the glass, and roulette should not see them.
        let mut throughput = DVec3::ONE;
        let mut factor = 1.0;
        // Pdf of the last direction if a shadow ray could have found the same light.
        let mut shared_pdf = None;
        for vertex in 1.. {
            let Some(here) = hit else {
                return radiance + factor * throughput * scene.background();
            };
            rng.block(vertex);
            if here.emitter.is_some() {
                let weight = self.weight_of_hit(scene, &here, &ray, shared_pdf);
                radiance += factor * weight * throughput * emitted(scene, &here, &ray);
            }
            radiance += factor * throughput * self.shadow_ray(scene, &here, &ray, rng);
            let Some(Scattered {
                direction,
                throughput: share,
                factor: scale,
                pdf,
            }) = scatter(&self.parts, scene, &here, &ray, rng)
            else {
                return radiance;
            };
            throughput *= share;
            factor *= scale;
            shared_pdf = pdf;
            let Some(weight) = survive(&self.parts, throughput, rng) else {
                return radiance;
            };
            throughput *= weight;
            (ray, hit) = onward(scene, &here, direction);
        }
        radiance
    }
}
