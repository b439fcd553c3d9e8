//! What of a job makes no sense.

use glam::DVec3;
use whitefurnace::error::Error;
use whitefurnace::estimator::radiosity::{Fineness, Mesh, check_memory};
use whitefurnace::film::Film;
use whitefurnace::sampler::LONGEST;

use super::{
    ConventionName, EstimatorName, HeuristicName, Job, LightSamplingName, PixelName, SamplerName,
    SceneName, name,
};
use crate::photons::Photons;

impl Job {
    /// Refuses what makes no sense, before any work is done.
    ///
    /// # Errors
    /// [`Error::Option`] with what to change.
    pub fn check(&self) -> Result<(), Error> {
        let refuse = |message: String| Err(Error::Option(message));
        let convention = name(self.convention);
        if self.scene != SceneName::Report && self.convention != ConventionName::Physical {
            return refuse(format!(
                "--scene {} is defined under --convention physical only; --convention {convention} \
                 belongs to --scene report",
                name(self.scene)
            ));
        }
        // Empty: any.
        let takes: &[EstimatorName] = match self.convention {
            ConventionName::Physical => &[],
            ConventionName::Report => &[EstimatorName::Report, EstimatorName::Whitted],
            ConventionName::Published => &[EstimatorName::Report],
        };
        if !takes.is_empty() && !takes.contains(&self.estimator) {
            let names: Vec<String> = takes.iter().copied().map(name).collect();
            return refuse(format!(
                "--estimator {} does not follow --convention {convention}, which takes --estimator {}",
                name(self.estimator),
                names.join(" or ")
            ));
        }
        if self.rays == 0 || self.rays > 64 {
            return refuse(format!("--rays {} must be between 1 and 64", self.rays));
        }
        if self.rays > 1 && !self.splits() {
            return refuse(
                "--rays is an option of --estimator report, and not of --convention published"
                    .to_owned(),
            );
        }
        let shadow_rays = matches!(self.estimator, EstimatorName::Light | EstimatorName::Mis);
        if self.light_sampling != LightSamplingName::default() && !shadow_rays {
            return refuse("--light-sampling is an option of --estimator light and mis".to_owned());
        }
        if self.heuristic != HeuristicName::default() && self.estimator != EstimatorName::Mis {
            return refuse("--heuristic is an option of --estimator mis".to_owned());
        }
        if self.uses_photons() {
            self.photons
                .check(self.estimator == EstimatorName::Photon)?;
        } else if self.photons != Photons::default() {
            return refuse(
                "--photons, --radius, --gather and their kind are options of --estimator photon and sppm"
                    .to_owned(),
            );
        }
        let patches = Self::default().patches;
        if self.patches != patches && self.estimator != EstimatorName::Radiosity {
            return refuse("--patches is an option of --estimator radiosity".to_owned());
        }
        if self.grid == 0 || self.grid > 1024 {
            return refuse(format!("--grid {} must be between 1 and 1024", self.grid));
        }
        if self.spp == 0 {
            return refuse("--spp 0 renders nothing: it must be at least 1".to_owned());
        }
        if self.sampler == SamplerName::Sobol {
            self.check_sobol()?;
        }
        let cells = self.sampling().pixel.samples_per_replication();
        if !self.spp.is_multiple_of(cells) {
            return refuse(format!(
                "--spp {} is not a multiple of the {cells} samples of a {}x{} grid: take {} or change --grid",
                self.spp,
                self.grid,
                self.grid,
                (self.spp / cells + 1) * cells
            ));
        }
        Film::checked_window(self.size, self.window)?;
        if self.renders_images() {
            let estimator = name(self.estimator);
            if self.window.is_some() {
                return refuse(format!(
                    "--estimator {estimator} renders whole images only: leave out the window"
                ));
            }
            if self.pixel != PixelName::Random {
                return refuse(format!(
                    "--estimator {estimator} takes random points of pixels: leave out --pixel {}",
                    name(self.pixel)
                ));
            }
        }
        if self.estimator == EstimatorName::LightTracer || self.uses_photons() {
            self.check_emitters()?;
        }
        if self.estimator == EstimatorName::Radiosity {
            check_memory(&Mesh::new(&self.build_scene()?, self.fineness())?)?;
        }
        Ok(())
    }

    /// How finely radiosity divides the surfaces.
    pub(super) fn fineness(&self) -> Fineness {
        Fineness {
            patches: self.patches,
            halvings: 0,
        }
    }

    /// Refuses scenes whose light no particle carries, and more photons than fit memory.
    fn check_emitters(&self) -> Result<(), Error> {
        let scene = self.build_scene()?;
        if scene.background() != DVec3::ZERO {
            return Err(Error::Option(format!(
                "--scene {} is lit by its background, where the particles of --estimator {} cannot start",
                name(self.scene),
                name(self.estimator)
            )));
        }
        if self.uses_photons() {
            self.photons
                .check_memory(self.keeps_one_map(), &scene, self.seed)?;
        }
        Ok(())
    }

    /// Whether the estimator makes whole images, from independent numbers and random points of pixels.
    fn renders_images(&self) -> bool {
        matches!(
            self.estimator,
            EstimatorName::LightTracer | EstimatorName::Bdpt | EstimatorName::Sppm
        )
    }

    /// Whether [`rays`](Self::rays) are followed from each diffuse hit.
    pub(super) fn splits(&self) -> bool {
        self.estimator == EstimatorName::Report && self.convention != ConventionName::Published
    }

    /// Whether all samples share their photons.
    pub(super) fn keeps_one_map(&self) -> bool {
        self.estimator == EstimatorName::Photon
    }

    /// Whether the estimator keeps photons.
    pub(super) fn uses_photons(&self) -> bool {
        matches!(self.estimator, EstimatorName::Photon | EstimatorName::Sppm)
    }

    fn check_sobol(&self) -> Result<(), Error> {
        let refuse = |message: String| Err(Error::Option(message));
        if self.renders_images() || !matches!(self.pixel, PixelName::Random | PixelName::Centre) {
            return refuse(
                "--sampler sobol goes with estimators of single rays and --pixel random or centre"
                    .to_owned(),
            );
        }
        if self.scrambles == 0 || !self.spp.is_multiple_of(self.scrambles) {
            return refuse(format!(
                "--spp {} is not a multiple of the {} scrambles: change one of them",
                self.spp, self.scrambles
            ));
        }
        if self.spp / self.scrambles > LONGEST {
            return refuse(format!(
                "--spp {} in {} scrambles is more than {LONGEST} points each: raise --scrambles",
                self.spp, self.scrambles
            ));
        }
        Ok(())
    }
}
