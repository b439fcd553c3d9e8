//! The values that trials of photons average: of independent maps and of series of passes.

use whitefurnace::integrator::photon::photon_map::{PhotonMap, PhotonMapKind};
use whitefurnace::integrator::{ImageEstimator, Lookup, PhotonMapping, Sppm};
use whitefurnace::sampling::sampler::{ImagePass, SamplerKind};

use crate::mean_radiance::points;
use crate::prelude::*;
use crate::scenes::mean_channel;
use crate::subject::sample;

/// Computes one value of a trial from the stream (seed, index).
pub(super) trait Replication: Send + Sync + 'static {
    /// Path of the code on trial.
    const SUBJECT: &'static str;

    fn value(&self, parts: Parts<'_>, seed: u64, index: u32) -> f64;
}

/// Compares the mean of replications with its closed form.
pub(super) struct Mean<T> {
    pub replication: T,
    pub reference: f64,
    /// Largest error allowed, relative to the reference.
    pub delta: f64,
    /// Number of replications at scale 1.
    pub values: u64,
}

impl<T: Replication> Property for Mean<T> {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let seed = context.seed_of("replication");
        let mut index = 0;
        vec![mean_of(
            "mean of replications",
            self.reference,
            self.delta,
            context.n(self.values),
            || {
                index += 1;
                self.replication.value(setup.parts, seed, index - 1)
            },
        )]
    }
}

/// Returns a trial of the mean of replications.
pub(super) fn family_trial<T: Replication>(
    name: &str,
    property: String,
    consequence: &str,
    equation: &'static Equation,
    mean: Mean<T>,
) -> FamilyTrial<EstimatorSubject> {
    trial(
        name,
        property,
        consequence,
        equation,
        T::SUBJECT,
        "t over independent maps",
        with_parts(mean),
    )
}

/// Returns a pass whose particles are the points of one scrambled Sobol' sequence.
pub(super) fn sobol_pass(seed: u64, index: u32) -> ImagePass {
    let sampler = SamplerKind::Sobol(1);
    ImagePass {
        sampler,
        seed,
        index,
    }
}

/// First channel of the mean radiance along some rays, by a map of its own.
pub(super) struct Mapping {
    pub scene: Arc<Scene>,
    pub lookup: Lookup,
    pub particles: u32,
    pub radius: f64,
    pub rays: Vec<Ray>,
}

impl Replication for Mapping {
    const SUBJECT: &'static str = "estimator::PhotonMapping";

    fn value(&self, parts: Parts<'_>, seed: u64, index: u32) -> f64 {
        let Ok(photons) = PhotonMapping::new(
            parts,
            &self.scene,
            self.lookup,
            self.particles,
            self.radius,
            sobol_pass(seed, index),
        ) else {
            return f64::NAN;
        };
        let count = self.rays.len() as u16;
        let rays = self.rays.iter().zip(points(seed, 1, index, count));
        let mut samples = rays.map(|(&ray, point)| sample(ray, point));
        let seen = photons.radiances(&self.scene, &mut samples);
        let sum: f64 = seen
            .into_iter()
            .map(|radiance| mean_channel(&self.scene, radiance))
            .sum();
        sum / self.rays.len() as f64
    }
}

/// The [`mean_channel`] of the flux of all photons of a map.
pub(super) struct Flux {
    pub scene: Arc<Scene>,
    pub kept: PhotonMapKind,
    pub particles: u32,
}

impl Replication for Flux {
    const SUBJECT: &'static str = "estimator::photon_map::PhotonMap";

    fn value(&self, parts: Parts<'_>, seed: u64, index: u32) -> f64 {
        let pass = sobol_pass(seed, index);
        let map = PhotonMap::new(parts, &self.scene, self.kept, self.particles, pass);
        map.map_or(f64::NAN, |map| {
            mean_channel(&self.scene, map.photons().map(|photon| photon.flux).sum())
        })
    }
}

/// Mean of the first passes over an image of one pixel.
pub(super) struct Passes {
    pub scene: Arc<Scene>,
    pub passes: u32,
    pub particles: u32,
    pub radius: f64,
    pub sampler: SamplerKind,
}

impl Replication for Passes {
    const SUBJECT: &'static str = "estimator::Sppm";

    fn value(&self, parts: Parts<'_>, seed: u64, index: u32) -> f64 {
        let sppm = Sppm {
            parts,
            particles: self.particles,
            radius: self.radius,
        };
        // The pass's index determines its radius, so replications differ by the seed.
        let seed = seed.wrapping_add(u64::from(index) << 32);
        let pass = |index| {
            sppm.image(
                &self.scene,
                [1, 1],
                ImagePass {
                    sampler: self.sampler,
                    seed,
                    index,
                },
            )
        };
        let value =
            |index| pass(index).map_or(f64::NAN, |image| mean_channel(&self.scene, image[0]));
        (0..self.passes).map(value).sum::<f64>() / f64::from(self.passes)
    }
}
