//! Estimators that render a small image with one path per pixel, or a few particles.

use whitefurnace::error::Error;
use whitefurnace::integrator::{
    Bdpt, Heuristic, ImageEstimator, LightTracer, Lookup, PhotonMapping, Sppm,
};
use whitefurnace::light::emitter::LightSampling;

use crate::prelude::*;
use crate::scenes::mean_channel;

/// Width and height of the images.
pub(super) const FRAME: [u32; 2] = [3, 2];

/// An estimator that renders the small image.
#[derive(Clone, Copy)]
pub(super) enum Eye {
    Rays(EstimatorKind),
    Photons(Lookup),
    Sppm,
    Bdpt,
    LightTracer,
}

/// The path tracer by BSDF sampling alone.
pub(super) const HITS: Eye = Eye::Rays(EstimatorKind::PathWith(
    Strategy::Bsdf,
    LightSampling::Area,
    Heuristic::Balance,
));

/// Lookup radius that covers all photons.
pub(super) const UNBOUNDED_RADIUS: f64 = 100.0;
/// Number of particles in a photon map or pass.
pub(super) const PARTICLES: u32 = 5;

impl Eye {
    /// Returns the [`mean_channel`] of every pixel, one path each: rays draw from `rng`, passes and
    /// maps are seeded by `seed`.
    pub(super) fn image(
        self,
        setup: Configuration<'_>,
        scene: &Scene,
        rng: &mut Stream,
        seed: u64,
    ) -> Result<Vec<f64>, Error> {
        let parts = setup.parts;
        let mean_channels = |image: Vec<DVec3>| {
            image
                .into_iter()
                .map(|pixel| mean_channel(scene, pixel))
                .collect()
        };
        let pass =
            |estimator: &dyn Fn() -> Result<Vec<DVec3>, Error>| estimator().map(mean_channels);
        match self {
            Self::Rays(kind) => Ok(mean_channels(rays(scene, rng, |ray, rng| {
                kind.radiance(setup, scene, ray, rng)
            }))),
            Self::Photons(lookup) => {
                let map = PhotonMapping::new(
                    parts,
                    scene,
                    lookup,
                    PARTICLES,
                    UNBOUNDED_RADIUS,
                    (seed, 0),
                )?;
                let radiance = |ray: &Ray, rng: &mut Stream| {
                    map.radiance(scene, ray, scene.intersect(ray), rng)
                };
                Ok(mean_channels(rays(scene, rng, radiance)))
            }
            Self::Sppm => {
                let sppm = Sppm {
                    parts,
                    particles: PARTICLES,
                    radius: UNBOUNDED_RADIUS,
                };
                pass(&|| sppm.pass(scene, FRAME, seed, 0))
            }
            Self::Bdpt => pass(&|| Bdpt::new(parts).pass(scene, FRAME, seed, 0)),
            Self::LightTracer => pass(&|| LightTracer { parts }.pass(scene, FRAME, seed, 0)),
        }
    }
}

/// Returns the radiance along a ray through a random point of each pixel.
fn rays(
    scene: &Scene,
    rng: &mut Stream,
    radiance: impl Fn(&Ray, &mut Stream) -> DVec3,
) -> Vec<DVec3> {
    let [width, height] = FRAME;
    (0..width * height)
        .map(|pixel| {
            let [u, v] = uniform2(rng);
            let [x, y] = [pixel % width, pixel / width].map(f64::from);
            radiance(&scene.camera().ray(FRAME, x + u, y + v), rng)
        })
        .collect()
}
