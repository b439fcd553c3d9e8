//! Stochastic progressive photon mapping: passes with shrinking radii, each with its own photons.

use glam::DVec3;
use rayon::prelude::*;

use super::photon_map::check_radius;
use super::{Lookup, PhotonMapping};
use crate::error::Error;
use crate::film::check_radiance;
use crate::integrator::{Estimator, ImageEstimator, Parts, Sample};
use crate::sampling::rng::uniform2;
use crate::sampling::sampler::ImagePass;
use crate::scene::Scene;

/// The method of Hachisuka and Jensen (2009) in the form of Knaus and Zwicker (2011), whose passes
/// are independent.
///
/// All light that a diffuse surface reflects is estimated from photons, including direct light;
/// only emitters seen directly or through mirrors and glass are evaluated exactly. Light of the
/// background is missing. The bias of the mean of n passes falls as n^(−1/3), its variance as
/// n^(−2/3).
#[derive(Clone, Copy, Debug)]
pub struct Sppm<'a> {
    /// Replaceable parts.
    pub parts: Parts<'a>,
    /// Particles emitted in each pass, at least 1.
    pub particles: u32,
    /// Lookup radius of pass 0, in the scene's units, above 0.
    pub radius: f64,
}

impl ImageEstimator for Sppm<'_> {
    fn image(
        &self,
        scene: &Scene,
        resolution: [u32; 2],
        pass: ImagePass,
    ) -> Result<Vec<DVec3>, Error> {
        check_radius(self.radius)?;
        let first = self.radius * self.radius;
        let radius = self.parts.pass_radius_squared(first, pass.index).sqrt();
        let (parts, particles) = (self.parts, self.particles);
        let photons = PhotonMapping::new(
            parts,
            scene,
            Lookup::DirectVisualization,
            particles,
            radius,
            pass.for_part("pass"),
        )?;
        let rows = (0..resolution[1]).into_par_iter().map(|y| {
            let sample = |x: u32| {
                let mut rng = pass.pixel_stream(y * resolution[0] + x);
                let [u, v] = uniform2(&mut rng);
                let ray = scene
                    .camera()
                    .ray(resolution, f64::from(x) + u, f64::from(y) + v);
                Sample {
                    ray,
                    hit: None,
                    rng,
                }
            };
            let row = photons.radiances(scene, &mut (0..resolution[0]).map(sample));
            for (x, radiance) in row.iter().enumerate() {
                let place = || format!(" at pixel ({x}, {y}), pass {}", pass.index);
                check_radiance(*radiance).map_err(|error| error.at(place))?;
            }
            Ok(row)
        });
        let rows = rows.collect::<Result<Vec<_>, Error>>()?;
        Ok(rows.concat())
    }
}
