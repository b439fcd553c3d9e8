//! Reference estimator: a path tracer without shadow rays, weights or specular next-event
//! estimation, which uses the scene and its BSDFs alone.

use crate::prelude::*;
use whitefurnace::material::Vertex;

/// Paths that the reference counts.
#[derive(Clone, Copy, Debug)]
pub enum Light {
    /// All paths with at most this many scattering events.
    All(u32),
    /// Paths of the light tracer: none that reach the camera through mirrors or glass.
    StraightToTheEye,
    /// Paths of Whitted's method, of at most this many segments: with at most one diffuse
    /// scattering event, of light that comes straight from an emitter.
    Whitted(u32),
    /// Paths of the report's estimator, of at most this many segments, and of its shadow rays, which
    /// add one after a diffuse surface.
    Report(u32),
}

/// Radiance estimated by a path tracer that adds the emission of the surfaces it hits.
#[derive(Clone, Copy, Debug)]
pub struct ReferencePathTracer(pub Light);

impl Estimator for ReferencePathTracer {
    fn radiance(&self, scene: &Scene, ray: &Ray, hit: Option<Hit>, rng: &mut dyn Sampler) -> DVec3 {
        let (mut ray, mut hit, mut throughput, mut radiance) = (*ray, hit, DVec3::ONE, DVec3::ZERO);
        let (mut scattered, mut diffusely) = (0_u32, false);
        loop {
            let Some(here) = hit else {
                let shows = match self.0 {
                    Light::All(_) => true,
                    Light::StraightToTheEye => false,
                    Light::Whitted(_) => !diffusely,
                    // Shadow rays do not find the background.
                    Light::Report(segments) => scattered < segments,
                };
                let background = scene.background().radiance(ray.direction);
                return if shows {
                    radiance + throughput * background
                } else {
                    radiance
                };
            };
            rng.block(scattered + 1);
            radiance += throughput * scene.emitted(&here, ray.direction);
            let bsdf = &scene.surface(&here).bsdf;
            let is_specular = matches!(bsdf, Bsdf::Mirror { .. } | Bsdf::Glass { .. });
            let ends = match self.0 {
                Light::All(most) => scattered == most,
                Light::StraightToTheEye => scattered == 0 && is_specular,
                Light::Whitted(segments) => diffusely || (is_specular && scattered + 1 >= segments),
                Light::Report(segments) => scattered + u32::from(is_specular) >= segments,
            };
            let at = Vertex::new(&here, &ray);
            let Some(next) = bsdf.sample(&at, rng).filter(|_| !ends) else {
                return radiance;
            };
            diffusely |= next.pdf.is_some();
            throughput *= next.weight * next.radiance_factor;
            if throughput.max_element() < 0.2 {
                if uniform(rng) < 0.5 {
                    return radiance;
                }
                throughput *= 2.0;
            }
            scattered += 1;
            (ray, hit) = scene.spawn_and_trace(&here, next.direction);
        }
    }
}
