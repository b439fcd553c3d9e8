//! Light tracing: particles leave the emitters, and every diffuse surface that they meet is connected
//! to the eye.

use glam::DVec3;
use rayon::prelude::*;

use super::particle::{connect_to_eye, particle};
use super::{Bidirectional, ImageEstimator, Standard, Walking};
use crate::error::Error;
use crate::sampler::Pass;
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

impl<P: Walking + Bidirectional> ImageEstimator for LightTracer<P> {
    fn image(&self, scene: &Scene, frame: [u32; 2], pass: Pass) -> Result<Vec<DVec3>, Error> {
        let image = Splats::new(frame);
        let particles = frame[0] * frame[1];
        (0..particles).into_par_iter().try_for_each(|number| {
            let mut rng = pass.particle(number, particles);
            particle(&self.parts, scene, &mut rng, |place| match connect_to_eye(&self.parts, scene, frame, &place) {
                Some(splat) => image.add(splat.pixel, splat.value),
                None => Ok(()),
            })
            .map_err(|error| error.at(|| format!(" by particle {number} of pass {}", pass.index)))
        })?;
        Ok(image.into_values())
    }
}
