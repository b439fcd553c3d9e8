//! Options of photon mapping.

use clap::{Args, ValueEnum};
use whitefurnace::error::Error;
use whitefurnace::integrator::photon::photon_map::{PhotonMap, PhotonMapKind};
use whitefurnace::integrator::{Lookup, Parts};
use whitefurnace::sampling::sampler::ImagePass;
use whitefurnace::scene::Scene;

use crate::run::cli::{integer, number};

/// Where photons are looked up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Gather {
    /// At the second diffuse surface (final gathering); the first gets shadow rays and caustic
    /// photons
    Yes,
    /// At the first diffuse surface, all of whose light is estimated from photons
    No,
}

/// Options of the estimators `photon` and `sppm`.
#[derive(Clone, Copy, Debug, PartialEq, Args)]
pub struct Photons {
    /// Particles from the lights for --estimator photon, and in each pass of sppm; from 1 to
    /// 4294967295
    #[arg(long, default_value_t = Photons::DEFAULT.photons, allow_hyphen_values = true, value_parser = count())]
    pub photons: u32,
    /// Lookup radius in the scene's units, that of the first pass of sppm; from 0.000001 to 1000000
    #[arg(long, default_value_t = Photons::DEFAULT.radius, allow_hyphen_values = true, value_parser = radius())]
    pub radius: f64,
    /// Whether --estimator photon does a final gather
    #[arg(long, value_enum, default_value_t = Photons::DEFAULT.gather)]
    pub gather: Gather,
    /// Particles for the caustic map of --gather yes; from 1 to 4294967295
    #[arg(long, allow_hyphen_values = true, value_parser = count())]
    pub caustic_photons: Option<u32>,
    /// Lookup radius of the caustic map; from 0.000001 to 1000000
    #[arg(long, allow_hyphen_values = true, value_parser = radius())]
    pub caustic_radius: Option<f64>,
}

fn count() -> impl Fn(&str) -> Result<u32, String> + Clone + Send + Sync + 'static {
    integer(1..=u64::from(u32::MAX))
}

fn radius() -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    number(1e-6..=1e6)
}

impl Photons {
    /// Options for the report's room, where a lookup finds some tens of photons.
    pub const DEFAULT: Self = Self {
        photons: 200_000,
        radius: 0.1,
        gather: Gather::Yes,
        caustic_photons: None,
        caustic_radius: None,
    };

    /// Returns particles and radius of the global map.
    pub fn map(&self) -> (u32, f64) {
        (self.photons, self.radius)
    }

    /// Returns particles and radius of the caustic map.
    pub fn caustic(&self) -> (u32, f64) {
        (
            self.caustic_photons.unwrap_or(self.photons),
            self.caustic_radius.unwrap_or(self.radius),
        )
    }

    /// Returns how photons are looked up; `one_map` is true for `--estimator photon`, false for
    /// `sppm`.
    pub fn lookup(&self, one_map: bool) -> Lookup {
        match self.gather {
            Gather::Yes if one_map => {
                let (caustic_particles, caustic_radius) = self.caustic();
                Lookup::FinalGather {
                    caustic_particles,
                    caustic_radius,
                }
            }
            _ => Lookup::DirectVisualization,
        }
    }

    /// Refuses more photons than fit in memory.
    pub fn check_memory(&self, one_map: bool, scene: &Scene, seed: u64) -> Result<(), Error> {
        PhotonMap::check(
            Parts::default(),
            scene,
            PhotonMapKind::All,
            self.photons,
            ImagePass::independent(seed, 0),
        )?;
        match self.lookup(one_map) {
            Lookup::DirectVisualization => Ok(()),
            Lookup::FinalGather {
                caustic_particles, ..
            } => PhotonMap::check(
                Parts::default(),
                scene,
                PhotonMapKind::Caustic,
                caustic_particles,
                ImagePass::independent(seed, 0),
            ),
        }
    }
}
