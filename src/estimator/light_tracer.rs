//! Light tracing: particles leave the emitters, and every diffuse surface that they meet is connected
//! to the eye.

use glam::DVec3;
use rayon::prelude::*;

use super::vertex::{Vertex, onward, scatter, survive};
use super::{ImageEstimator, Parts, Standard};
use crate::error::Error;
use crate::frame::Frame;
use crate::rng::{stream, uniform, uniform2};
use crate::sampler::{LIGHT, Sampler};
use crate::scene::Scene;
use crate::splat::Splats;

/// Particles to the camera, one per pixel and pass. Unbiased for light that leaves an emitter, meets
/// any surfaces, and reaches the eye from an emitter or a diffuse one: the eye sees nothing in mirrors
/// and through glass, nor of the background's light.
#[derive(Clone, Copy, Debug, Default)]
pub struct LightTracer<P = Standard> {
    /// Its parts.
    pub parts: P,
}

impl<P: Parts> ImageEstimator for LightTracer<P> {
    fn pass(
        &self,
        scene: &Scene,
        frame: [u32; 2],
        seed: u64,
        index: u32,
    ) -> Result<Vec<DVec3>, Error> {
        let image = Splats::new(frame);
        let particles = frame[0] * frame[1];
        (0..particles).into_par_iter().try_for_each(|particle| {
            let mut rng = stream(seed, particle, index);
            self.particle(scene, &image, frame, &mut rng)
        })?;
        Ok(image.into_values())
    }
}

impl<P: Parts> LightTracer<P> {
    /// Follows one particle from an emitter to its end and connects what it meets to the eye.
    fn particle<R: Sampler>(
        &self,
        scene: &Scene,
        image: &Splats,
        frame: [u32; 2],
        rng: &mut R,
    ) -> Result<(), Error> {
        let parts = &self.parts;
        let emitters = scene.emitters();
        if emitters.is_empty() {
            return Ok(());
        }
        rng.block(LIGHT);
        let emitter = &emitters[parts.pick_emitter(uniform(rng), emitters.len())];
        let light = parts.sample_emitter(emitter, uniform2(rng));
        let pdf = parts.emitter_pdf_area(emitter) / emitters.len() as f64;
        let front = (light.point, light.normal);
        self.connect(scene, image, frame, front, |_| emitter.radiance / pdf)?;

        let wi = parts.cosine_hemisphere(uniform2(rng));
        let direction_pdf = parts.cosine_hemisphere_pdf(wi.z);
        if direction_pdf == 0.0 {
            return Ok(());
        }
        let flux = emitter.radiance * (parts.cosine(DVec3::Z, wi) / (pdf * direction_pdf));
        let direction = Frame::new(light.normal).world(wi);
        let mut ray = scene.leave(light.point, light.normal, direction);
        let mut throughput = DVec3::ONE;
        for vertex in 1.. {
            let Some(here) = scene.intersect(&ray) else {
                return Ok(());
            };
            rng.block(LIGHT + vertex);
            let bsdf = &scene.surface(&here).bsdf;
            let local = Vertex::new(&here, &ray);
            self.connect(scene, image, frame, (here.point, local.frame.z), |to_eye| {
                let brdf = parts.brdf(bsdf, local.frame.local(to_eye), local.wo);
                flux * throughput * brdf
            })?;
            let Some(next) = scatter(parts, scene, &here, &ray, rng) else {
                return Ok(());
            };
            throughput *= next.throughput;
            let Some(weight) = survive(parts, throughput, rng) else {
                return Ok(());
            };
            throughput *= weight;
            (ray, _) = onward(scene, &here, next.direction);
        }
        Ok(())
    }

    /// Adds to the image what a point with a unit normal sends to the eye: `leaving` is the radiance
    /// that leaves it in a unit direction, per particle density on its area.
    #[inline]
    fn connect(
        &self,
        scene: &Scene,
        image: &Splats,
        frame: [u32; 2],
        (point, normal): (DVec3, DVec3),
        leaving: impl Fn(DVec3) -> DVec3,
    ) -> Result<(), Error> {
        let Some(seen) = scene.camera().project(frame, point) else {
            return Ok(());
        };
        let cosine = self.parts.cosine(normal, seen.to_eye);
        let leaving = leaving(seen.to_eye);
        let eye = (scene.camera().eye, -seen.to_eye);
        if cosine <= 0.0
            || leaving == DVec3::ZERO
            || !self.parts.visible(scene, eye, (point, normal), false)
        {
            return Ok(());
        }
        let particles = f64::from(frame[0]) * f64::from(frame[1]);
        let scale = self
            .parts
            .solid_angle_per_area(cosine, seen.distance_squared);
        image.add(seen.pixel, leaving * (scale * seen.importance / particles))
    }
}
