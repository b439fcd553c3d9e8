//! Hypothesis about the program that made the published figure 6: the report's estimator with the
//! defects that explain the image, none of which a correct program should copy.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use super::direct_light::direct_light;
use super::{DefaultParts, Estimator, TransportRules};
use crate::geometry::shape::{Hit, Ray};
use crate::material::{Bsdf, Scattering, Vertex};
use crate::sampling::rng::{uniform, uniform2};
use crate::sampling::sampler::Sampler;
use crate::scene::Scene;

/// Reconstructed estimator. A ray that meets an emitter returns 1 after any kind of path: too much
/// where next-event estimation has counted it, and a loss of nearly all caustics.
#[derive(Clone, Copy, Debug, Default)]
pub struct Published {
    /// Defects that are active.
    pub quirks: Quirks,
}

/// Defects, each of which can be disabled to see its effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quirks {
    /// The random number of the roulette is the cosine of the sampled direction: with survival q
    /// the path ends if cos θ ≥ q, so directions near the normal are never sampled.
    pub roulette_by_cosine: bool,
    /// A path that ends loses its direct light as well; the albedo of survivors is the colour,
    /// albedo/q.
    pub end_loses_direct: bool,
    /// Oren-Nayar surfaces multiply everything by cos θ of the sampled direction once more.
    pub extra_cosine: bool,
}

impl Default for Quirks {
    /// Enables all three defects.
    fn default() -> Self {
        Self {
            roulette_by_cosine: true,
            end_loses_direct: true,
            extra_cosine: true,
        }
    }
}

const SEGMENTS: u32 = 7;

impl Estimator for Published {
    fn radiance(&self, scene: &Scene, ray: &Ray, hit: Option<Hit>, rng: &mut dyn Sampler) -> DVec3 {
        let parts = DefaultParts;
        let shadow_rays = TransportRules::REPORT.shadow_rays();
        let quirks = self.quirks;
        let (mut ray, mut hit) = (*ray, hit);
        let mut radiance = DVec3::ZERO;
        let mut throughput = DVec3::ONE;
        for segment in 1..=SEGMENTS {
            let Some(here) = hit else {
                return radiance + throughput * scene.background().radiance(ray.direction);
            };
            if scene.emitted(&here, ray.direction) != DVec3::ZERO {
                radiance += throughput;
            }
            let surface = scene.surface(&here);
            let bsdf = &surface.bsdf;
            let vertex = Vertex::new(&here, &ray);
            let direction = if !bsdf.is_non_delta() {
                let Some(way) = parts.sample(bsdf, &vertex, rng) else {
                    return radiance;
                };
                throughput *= way.weight;
                way.direction
            } else {
                let wi = parts.uniform_hemisphere(uniform2(rng));
                let survival = 1.0 - surface.absorption;
                let number = if quirks.roulette_by_cosine {
                    wi.z
                } else {
                    uniform(rng)
                };
                // A path of survival 0 ends, too: nothing continues that would be divided by it.
                let ends = number >= survival;
                if ends && quirks.end_loses_direct {
                    return radiance;
                }
                let rough = matches!(bsdf, Bsdf::OrenNayar { .. });
                let extra = if rough && quirks.extra_cosine {
                    wi.z
                } else {
                    1.0
                };
                let colour = bsdf.albedo() / survival;
                let albedo = if quirks.end_loses_direct {
                    colour
                } else {
                    bsdf.albedo()
                };
                let plain = Bsdf::Lambert { albedo };
                if let Some(light) = direct_light(&parts, scene, &plain, &vertex, shadow_rays, rng)
                {
                    radiance += throughput * extra * light.reflected;
                }
                if ends {
                    return radiance;
                }
                let pdf = parts.uniform_hemisphere_pdf(wi.z);
                // Without the directions that the roulette ends, survivors would be too dim.
                let albedo = if quirks.roulette_by_cosine {
                    colour
                } else {
                    bsdf.albedo()
                };
                throughput *= extra * albedo * (FRAC_1_PI * wi.z / pdf / survival);
                vertex.frame.world(wi)
            };
            if segment < SEGMENTS {
                (ray, hit) = scene.spawn_and_trace(&here, direction);
            }
        }
        radiance
    }
}
