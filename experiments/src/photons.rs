//! What photon mapping is told on the command line.

use clap::{Args, ValueEnum};
use whitefurnace::error::Error;
use whitefurnace::estimator::photon_map::{Kept, PhotonMap};
use whitefurnace::estimator::{Lookup, Standard};
use whitefurnace::scene::Scene;

use crate::job::name;

/// Where photons are looked up, as programs name it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Gather {
    /// At the second diffuse surface; the first gets shadow rays and caustic photons
    #[default]
    Yes,
    /// At the first diffuse surface, all of whose light comes by photons
    No,
}

/// The options of the estimators `photon` and `sppm`.
#[derive(Clone, Copy, Debug, PartialEq, Args)]
pub struct Photons {
    /// Particles from the lights for --estimator photon, and in each pass of sppm
    #[arg(long, default_value_t = Photons::default().photons)]
    pub photons: u32,
    /// Radius of lookups in the scene's units; that of the first pass of sppm
    #[arg(long, default_value_t = Photons::default().radius, allow_negative_numbers = true)]
    pub radius: f64,
    /// Whether --estimator photon gathers the light of a second diffuse surface
    #[arg(long, value_enum, default_value_t = Gather::Yes)]
    pub gather: Gather,
    /// Particles for the caustics of --gather yes [default: as --photons]
    #[arg(long)]
    pub caustic_photons: Option<u32>,
    /// Radius of their lookups [default: as --radius]
    #[arg(long, allow_negative_numbers = true)]
    pub caustic_radius: Option<f64>,
}

impl Default for Photons {
    /// For the report's room: a lookup finds some tens of photons.
    fn default() -> Self {
        Self {
            photons: 200_000,
            radius: 0.1,
            gather: Gather::Yes,
            caustic_photons: None,
            caustic_radius: None,
        }
    }
}

impl Photons {
    /// Particles and radius.
    pub fn map(&self) -> (u32, f64) {
        (self.photons, self.radius)
    }

    /// How photons are looked up: `one_map` for `--estimator photon` rather than `sppm`.
    pub fn lookup(&self, one_map: bool) -> Lookup {
        match self.gather {
            Gather::Yes if one_map => Lookup::Gather {
                caustic_particles: self.caustic_photons.unwrap_or(self.photons),
                caustic_radius: self.caustic_radius.unwrap_or(self.radius),
            },
            _ => Lookup::Direct,
        }
    }

    /// Refuses what makes no sense, with what to change.
    ///
    /// # Errors
    /// [`Error::Option`].
    pub fn check(&self, one_map: bool) -> Result<(), Error> {
        let refuse = |message: String| Err(Error::Option(message));
        let counts = [
            ("--photons", Some(self.photons)),
            ("--caustic-photons", self.caustic_photons),
        ];
        for (option, count) in counts {
            if count == Some(0) {
                return refuse(format!("{option} 0 must be at least 1"));
            }
        }
        let radii = [
            ("--radius", Some(self.radius)),
            ("--caustic-radius", self.caustic_radius),
        ];
        for (option, radius) in radii {
            if let Some(radius) = radius
                && !(radius.is_finite() && radius > 0.0)
            {
                return refuse(format!("{option} {radius} must be finite and above 0"));
            }
        }
        let caustics = self.caustic_photons.is_some() || self.caustic_radius.is_some();
        let gathers = one_map && self.gather == Gather::Yes;
        if caustics && !gathers {
            return refuse(
                "--caustic-photons and --caustic-radius go with --estimator photon and --gather yes"
                    .to_owned(),
            );
        }
        if !one_map && self.gather != Gather::Yes {
            return refuse("--gather is an option of --estimator photon".to_owned());
        }
        Ok(())
    }

    /// Refuses more photons than fit memory.
    ///
    /// # Errors
    /// Those of [`PhotonMap::check`].
    pub fn check_memory(&self, one_map: bool, scene: &Scene, seed: u64) -> Result<(), Error> {
        PhotonMap::check(&Standard, scene, Kept::All, self.photons, (seed, 0))?;
        match self.lookup(one_map) {
            Lookup::Direct => Ok(()),
            Lookup::Gather {
                caustic_particles, ..
            } => PhotonMap::check(
                &Standard,
                scene,
                Kept::Caustic,
                caustic_particles,
                (seed, 0),
            ),
        }
    }

    /// What decides the pixels, line by line.
    pub fn provenance(&self, one_map: bool, line: &mut impl FnMut(&str, &str)) {
        line("photons", &self.photons.to_string());
        line("radius", &self.radius.to_string());
        if one_map {
            line("gather", &name(self.gather));
        }
        if let Lookup::Gather {
            caustic_particles,
            caustic_radius,
        } = self.lookup(one_map)
        {
            line("caustic-photons", &caustic_particles.to_string());
            line("caustic-radius", &caustic_radius.to_string());
        }
    }
}
