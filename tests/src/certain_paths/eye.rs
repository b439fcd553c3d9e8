//! Estimators that render a small image with one path per pixel, or a few particles.

use whitefurnace::error::Error;
use whitefurnace::integrator::{Bdpt, ImageEstimator, LightTracer, Lookup, PhotonMapping, Sppm};
use whitefurnace::light::emitter::LightSampling;
use whitefurnace::sampling::sampler::ImagePass;

use crate::mean_radiance::path;
use crate::prelude::*;
use crate::scenes::mean_channel;
use crate::strategies::path_with;

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
pub(super) const HITS: Eye = Eye::Rays(path_with(Strategy::Bsdf, LightSampling::Area));

/// Lookup radius that covers all photons.
pub(super) const UNBOUNDED_RADIUS: f64 = 100.0;
/// Number of particles in a photon map or pass.
pub(super) const PARTICLES: u32 = 5;

impl Eye {
    /// Returns every estimator but the light tracer. Those with a limit, which are the last two,
    /// have this one on segments.
    pub(super) fn all(segments: u32) -> [Self; 6] {
        [
            HITS,
            Self::Photons(Lookup::DirectVisualization),
            Self::Sppm,
            Self::Bdpt,
            Self::Rays(EstimatorKind::Report(segments)),
            Self::Rays(EstimatorKind::Whitted(segments)),
        ]
    }

    /// Returns the path in the library of the estimator.
    pub(super) fn path(self) -> &'static str {
        match self {
            Self::Rays(kind) => path(kind),
            Self::Photons(_) => "integrator::PhotonMapping",
            Self::Sppm => "integrator::Sppm",
            Self::Bdpt => "integrator::Bdpt",
            Self::LightTracer => "integrator::LightTracer",
        }
    }

    /// Returns the estimator in words.
    pub(super) fn method(self) -> &'static str {
        match self {
            Self::Rays(EstimatorKind::Report(_)) => "the report's method",
            Self::Rays(EstimatorKind::Whitted(_)) => "Whitted's ray tracing",
            Self::Rays(_) => "path tracing",
            Self::Photons(_) => "photon mapping",
            Self::Sppm => "progressive photon mapping",
            Self::Bdpt => "bidirectional path tracing",
            Self::LightTracer => "light tracing",
        }
    }

    /// Returns whether the estimator has a limit on segments.
    pub(super) fn is_limited(self) -> bool {
        use EstimatorKind::{Report, Whitted};
        matches!(self, Self::Rays(Report(_) | Whitted(_)))
    }

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
        let image = match self {
            Self::Rays(kind) => rays(scene, rng, |ray, rng| kind.radiance(setup, scene, ray, rng)),
            Self::Photons(lookup) => {
                let map = PhotonMapping::new(
                    parts,
                    scene,
                    lookup,
                    PARTICLES,
                    UNBOUNDED_RADIUS,
                    ImagePass::independent(seed, 0),
                )?;
                let radiance = |ray: &Ray, rng: &mut Stream| {
                    map.radiance(scene, ray, scene.intersect(ray), rng)
                };
                rays(scene, rng, radiance)
            }
            Self::Sppm => {
                let sppm = Sppm {
                    parts,
                    particles: PARTICLES,
                    radius: UNBOUNDED_RADIUS,
                };
                sppm.pass(scene, FRAME, seed, 0)?
            }
            Self::Bdpt => Bdpt::new(parts).pass(scene, FRAME, seed, 0)?,
            Self::LightTracer => LightTracer { parts }.pass(scene, FRAME, seed, 0)?,
        };
        let mean_channels = image.into_iter().map(|pixel| mean_channel(scene, pixel));
        Ok(mean_channels.collect())
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
