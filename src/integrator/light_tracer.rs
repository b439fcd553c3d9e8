//! Light tracing: particles leave the emitters, and each of their vertices on diffuse surfaces is
//! connected to the eye.

use glam::DVec3;
use rayon::prelude::*;

use super::particle::{ParticleEvent, connect_to_eye, particles};
use super::walk::in_batches;
use super::{ImageEstimator, Parts, with_parts};
use crate::error::Error;
use crate::film::splat::Splats;
use crate::sampling::sampler::ImagePass;
use crate::scene::Scene;

/// Light tracer: one particle per pixel and pass. Unbiased for light that leaves an emitter and
/// reaches the eye directly or after any scattering whose last surface is diffuse; light that the
/// eye sees in mirrors or through glass and light of the background are missing.
#[derive(Clone, Copy, Debug, Default)]
pub struct LightTracer<'a> {
    /// Replaceable parts.
    pub parts: Parts<'a>,
}

impl ImageEstimator for LightTracer<'_> {
    fn image(
        &self,
        scene: &Scene,
        resolution: [u32; 2],
        pass: ImagePass,
    ) -> Result<Vec<DVec3>, Error> {
        let image = Splats::new(resolution);
        let count = resolution[0] * resolution[1];
        in_batches(count).try_for_each_init(
            || image.buffer(),
            |splats, numbers| {
                let mut items = numbers.map(|number| (number, pass.particle_stream(number, count)));
                let named = |error: Error, number: &u32| {
                    error.at(|| format!(" by particle {number} of pass {}", pass.index))
                };
                with_parts!(self.parts, |parts| {
                    particles(parts, scene, &mut items, named, |event| match event {
                        ParticleEvent::Vertex(_, vertex) => {
                            match connect_to_eye(parts, scene, resolution, vertex) {
                                Some(splat) => splats.add(splat.pixel, splat.value),
                                None => Ok(()),
                            }
                        }
                        ParticleEvent::End(..) => Ok(()),
                    })
                })?;
                splats.flush()
            },
        )?;
        Ok(image.into_values())
    }
}
