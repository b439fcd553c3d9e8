//! Estimators as they look at a small image, one path to a pixel.

use whitefurnace::emitter::LightSampling;
use whitefurnace::error::Error;
use whitefurnace::estimator::{
    Bdpt, Heuristic, ImageEstimator, LightTracer, Lookup, PhotonMapping, Report, Sppm, Whitted,
};

use crate::prelude::*;
use crate::scenes::level;

/// Width and height of the images.
pub(super) const FRAME: [u32; 2] = [3, 2];

/// Who looks.
#[derive(Clone, Copy)]
pub(super) enum Eye {
    Path,
    Report(u32),
    Whitted(u32),
    Photons(Lookup),
    Sppm,
    Bdpt,
    LightTracer,
}

/// Looks up all photons that there are.
pub(super) const EVERYWHERE: f64 = 100.0;
/// Particles of a map.
pub(super) const PARTICLES: u32 = 5;

impl Eye {
    /// The [`level`] of every pixel, one path each.
    pub(super) fn image<P: EstimatorParts + Copy>(
        self,
        setup: Configuration<P>,
        scene: &Scene,
        (rng, seed): (&mut Stream, u64),
    ) -> Result<Vec<f64>, Error> {
        let Configuration { parts, segments, rules } = setup;
        let levels = |image: Vec<DVec3>| image.into_iter().map(|pixel| level(scene, pixel)).collect();
        let pass = |estimator: &dyn Fn() -> Result<Vec<DVec3>, Error>| estimator().map(levels);
        match self {
            Self::Path => {
                let path = Path {
                    parts,
                    strategy: Strategy::Bsdf,
                    lights: LightSampling::Area,
                    heuristic: Heuristic::Balance,
                };
                Ok(rays(&path, scene, rng))
            }
            Self::Report(limit) => {
                let report = Report { parts, rays: 1, segments: segments.unwrap_or(limit), rules };
                Ok(rays(&report, scene, rng))
            }
            Self::Whitted(limit) => {
                let whitted = Whitted { parts, segments: segments.unwrap_or(limit), rules };
                Ok(rays(&whitted, scene, rng))
            }
            Self::Photons(lookup) => {
                let size = (PARTICLES, EVERYWHERE);
                let map = PhotonMapping::new(parts, scene, lookup, size, (seed, 0))?;
                Ok(rays(&map, scene, rng))
            }
            Self::Sppm => {
                let sppm = Sppm { parts, particles: PARTICLES, radius: EVERYWHERE };
                pass(&|| sppm.pass(scene, FRAME, seed, 0))
            }
            Self::Bdpt => pass(&|| Bdpt::new(parts).pass(scene, FRAME, seed, 0)),
            Self::LightTracer => pass(&|| LightTracer { parts }.pass(scene, FRAME, seed, 0)),
        }
    }
}

/// A ray through a random point of each pixel.
fn rays<E: Estimator>(estimator: &E, scene: &Scene, rng: &mut Stream) -> Vec<f64> {
    let [width, height] = FRAME;
    (0..width * height)
        .map(|pixel| {
            let [u, v] = uniform2(rng);
            let [x, y] = [pixel % width, pixel / width].map(f64::from);
            let ray = scene.camera().ray(FRAME, x + u, y + v);
            level(scene, estimator.radiance(scene, &ray, scene.intersect(&ray), rng))
        })
        .collect()
}
