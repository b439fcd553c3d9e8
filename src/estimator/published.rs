//! A hypothesis about the program that made the published figure 6: the report's estimator with the
//! quirks that explain the image, none of which a correct program should copy.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use super::vertex::{Vertex, direct_light, interface, onward, scatter_glass, seen};
use super::{Estimator, LightRules, Parts, Standard};
use crate::bsdf::Bsdf;
use crate::rng::{uniform, uniform2};
use crate::sampler::Sampler;
use crate::scene::{Hit, Scene};
use crate::shape::Ray;

/// The reconstruction, with three quirks:
///
/// 1. The random number of the roulette is the cosine of the sampled direction: with survival q the
///    path ends if cos θ > q, so directions near the normal are never sampled.
/// 2. A path that ends loses its direct light as well; the albedo of survivors is the colour, albedo/q.
/// 3. Oren-Nayar surfaces multiply everything by cos θ of the sampled direction once more.
///
/// A ray that meets an emitter returns 1 after any kind of path.
#[derive(Clone, Copy, Debug, Default)]
pub struct Published;

const SEGMENTS: u32 = 7;

impl Estimator for Published {
    fn radiance<R: Sampler>(
        &self,
        scene: &Scene,
        ray: &Ray,
        hit: Option<Hit>,
        rng: &mut R,
    ) -> DVec3 {
        let (parts, rules) = (Standard, LightRules::REPORT);
        let (mut ray, mut hit) = (*ray, hit);
        let mut radiance = DVec3::ZERO;
        let mut throughput = DVec3::ONE;
        for segment in 1..=SEGMENTS {
            let Some(here) = hit else {
                return radiance + throughput * scene.background();
            };
            radiance += throughput * seen(scene, &here, &ray, &rules);
            let surface = scene.surface(&here);
            let direction = match surface.bsdf {
                Bsdf::Black => return radiance,
                Bsdf::Mirror { reflectance } => {
                    throughput *= reflectance;
                    parts.mirror(ray.direction, here.normal)
                }
                Bsdf::Glass { index } => {
                    let sides = interface(&here, &ray, index);
                    scatter_glass(&parts, sides, ray.direction, uniform(rng)).0
                }
                bsdf @ (Bsdf::Lambert { .. } | Bsdf::OrenNayar { .. } | Bsdf::Eon { .. }) => {
                    let wi = parts.uniform_hemisphere(uniform2(rng));
                    let survival = 1.0 - surface.absorption;
                    if wi.z > survival {
                        return radiance;
                    }
                    let extra = if matches!(bsdf, Bsdf::OrenNayar { .. }) {
                        wi.z
                    } else {
                        1.0
                    };
                    let colour = bsdf.albedo() / survival;
                    let plain = Bsdf::Lambert { albedo: colour };
                    let vertex = Vertex::new(&here, &ray);
                    let light = direct_light(&parts, scene, &plain, &vertex, &rules, rng);
                    if let Some(light) = light {
                        radiance += throughput * extra * light.reflected;
                    }
                    let pdf = parts.uniform_hemisphere_pdf(wi.z);
                    throughput *= extra * colour * (FRAC_1_PI * wi.z / pdf / survival);
                    vertex.frame.world(wi)
                }
            };
            if segment < SEGMENTS {
                (ray, hit) = onward(scene, &here, direction);
            }
        }
        radiance
    }
}
