//! The reference: a walk that sends no shadow rays, weights nothing and knows nothing of bodies,
//! from the scene and its reflection models alone.

use crate::prelude::*;
use whitefurnace::material::Vertex;

/// Which part of the light it counts.
#[derive(Clone, Copy, Debug)]
pub enum Light {
    /// All that is scattered at most so often.
    All(u32),
    /// The light that the light tracer shows: nothing in mirrors or through glass.
    StraightToTheEye,
    /// The light that Whitted's method shows: what is scattered at one diffuse surface and comes
    /// straight from an emitter there, or none: by so many segments at most.
    Whitted(u32),
}

/// Radiance by a walk that emitters are hit by.
#[derive(Clone, Copy, Debug)]
pub struct Naive(pub Light);

impl Estimator for Naive {
    fn radiance<R: Sampler>(
        &self,
        scene: &Scene,
        ray: &Ray,
        hit: Option<Hit>,
        rng: &mut R,
    ) -> DVec3 {
        let (mut ray, mut hit, mut throughput, mut radiance) = (*ray, hit, DVec3::ONE, DVec3::ZERO);
        let (mut scattered, mut diffusely) = (0_u32, false);
        loop {
            let Some(here) = hit else {
                let shows = match self.0 {
                    Light::All(_) => true,
                    Light::StraightToTheEye => false,
                    Light::Whitted(_) => !diffusely,
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
            (ray, hit) = scene.onward(&here, next.direction);
        }
    }
}
