//! Stochastic progressive photon mapping: passes with ever smaller radii, each with photons of its
//! own.

use glam::DVec3;
use rayon::prelude::*;

use super::photon_map::check_radius;
use super::{Lookup, PhotonMapping};
use crate::error::Error;
use crate::film::check_radiance;
use crate::integrator::{Estimator, ImageEstimator, Photons, Sample, Standard, Walking};
use crate::sampling::rng::uniform2;
use crate::sampling::sampler::Pass;
use crate::scene::Scene;

/// The method of Hachisuka and Jensen (2009) in the form of Knaus and Zwicker (2011), in which a
/// pass knows nothing of the others.
///
/// All light that a diffuse surface reflects comes by photons, direct light as well; only emitters
/// that the eye sees straight or by mirrors and glass are seen as such. Light of the background is
/// left out. The bias of the mean of n passes falls as n^(−1/3), its variance as n^(−2/3).
#[derive(Clone, Copy, Debug)]
pub struct Sppm<P = Standard> {
    /// Its parts.
    pub parts: P,
    /// Particles emitted in each pass, at least 1.
    pub particles: u32,
    /// Radius of the lookups of pass 0, in the scene's units, above 0.
    pub radius: f64,
}

impl<P: Photons + Walking + Copy> ImageEstimator for Sppm<P> {
    fn image(&self, scene: &Scene, frame: [u32; 2], pass: Pass) -> Result<Vec<DVec3>, Error> {
        check_radius(self.radius)?;
        let first = self.radius * self.radius;
        let radius = self.parts.pass_radius_squared(first, pass.index).sqrt();
        let map = (self.particles, radius);
        let photons = PhotonMapping::new(self.parts, scene, Lookup::Direct, map, pass.of("pass"))?;
        let rows = (0..frame[1]).into_par_iter().map(|y| {
            let sample = |x: u32| {
                let mut rng = pass.pixel(y * frame[0] + x);
                let [u, v] = uniform2(&mut rng);
                let ray = scene
                    .camera()
                    .ray(frame, f64::from(x) + u, f64::from(y) + v);
                Sample {
                    ray,
                    hit: None,
                    rng,
                }
            };
            let row = photons.radiances(scene, (0..frame[0]).map(sample));
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
