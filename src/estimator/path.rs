//! The path tracer: next-event estimation and cosine-weighted directions, combined by multiple
//! importance sampling, Russian roulette, no bounce limit.

use glam::DVec3;
use rand::Rng;

use super::{
    Estimator, LightRules, Parts, Standard, Vertex, direct_light, emitted, emitter_pdf, interface,
    onward, scatter_glass,
};
use crate::bsdf::Bsdf;
use crate::radiometry::reflected;
use crate::rng::{uniform, uniform2};
use crate::scene::{Hit, Scene};
use crate::shape::Ray;

/// An unbiased estimator of (8) on every scene.
#[derive(Clone, Copy, Debug, Default)]
pub struct Path<P = Standard> {
    /// Its parts.
    pub parts: P,
}

impl<P: Parts> Estimator for Path<P> {
    #[inline]
    fn radiance<R: Rng>(&self, scene: &Scene, ray: &Ray, hit: Option<Hit>, rng: &mut R) -> DVec3 {
        let parts = &self.parts;
        let (mut ray, mut hit) = (*ray, hit);
        let mut radiance = DVec3::ZERO;
        // Without the radiance factors of refraction, whose product is kept beside it: they cancel when
        // the path leaves the glass, and roulette should not see them.
        let mut throughput = DVec3::ONE;
        let mut factor = 1.0;
        // Pdf of the last direction if a shadow ray could have found the same light.
        let mut shared_pdf = None;
        loop {
            let Some(here) = hit else {
                return radiance + factor * throughput * scene.background();
            };
            if let Some(index) = here.emitter {
                let weight = shared_pdf.map_or(1.0, |pdf| {
                    let cosine = parts.cosine(here.normal, -ray.direction);
                    let emitter = &scene.emitters()[index as usize];
                    let other = emitter_pdf(parts, scene, emitter, cosine, here.t * here.t);
                    parts.mis_weight(pdf, other)
                });
                radiance += factor * weight * throughput * emitted(scene, &here, &ray);
            }
            let direction = match scene.surface(&here).bsdf {
                Bsdf::Black => return radiance,
                Bsdf::Mirror { reflectance } => {
                    throughput *= reflectance;
                    shared_pdf = None;
                    parts.mirror(ray.direction, here.normal)
                }
                Bsdf::Glass { index } => {
                    let sides = interface(&here, &ray, index);
                    let (direction, scale) =
                        scatter_glass(parts, sides, ray.direction, uniform(rng));
                    factor *= scale;
                    shared_pdf = None;
                    direction
                }
                ref bsdf @ (Bsdf::Lambert { .. } | Bsdf::OrenNayar { .. }) => {
                    let vertex = Vertex::new(&here, &ray);
                    let light =
                        direct_light(parts, scene, bsdf, &vertex, &LightRules::PHYSICAL, rng);
                    if let Some(light) = light {
                        let other = parts.cosine_hemisphere_pdf(light.wi.z);
                        radiance += factor
                            * parts.mis_weight(light.pdf, other)
                            * throughput
                            * light.reflected;
                    }
                    let wi = parts.cosine_hemisphere(uniform2(rng));
                    let pdf = parts.cosine_hemisphere_pdf(wi.z);
                    if pdf == 0.0 {
                        return radiance;
                    }
                    let brdf = parts.brdf(bsdf, vertex.wo, wi);
                    let cosine = parts.cosine(DVec3::Z, wi);
                    throughput *= reflected(brdf, DVec3::ONE, cosine, pdf);
                    shared_pdf = Some(pdf);
                    vertex.frame.world(wi)
                }
            };
            let survival = parts.survival_by_throughput(throughput);
            if !parts.survives(uniform(rng), survival) {
                return radiance;
            }
            throughput *= parts.roulette_weight(survival);
            (ray, hit) = onward(scene, &here, direction);
        }
    }
}
