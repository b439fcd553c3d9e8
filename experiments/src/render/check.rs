//! What of a job makes no sense.

use glam::DVec3;
use whitefurnace::error::Error;
use whitefurnace::estimator::radiosity::{Fineness, Mesh, check_memory};
use whitefurnace::film::Film;
use whitefurnace::sampler::LONGEST;

use super::{ConventionName, EstimatorName, Job, PixelName, SamplerName, SceneName, name};
use crate::render::photons::Gather;

/// Under which others an option changes anything.
struct Condition {
    option: &'static str,
    /// What it goes with.
    with: &'static str,
    applies: fn(&Job) -> bool,
}

const fn goes(option: &'static str, with: &'static str, applies: fn(&Job) -> bool) -> Condition {
    Condition { option, with, applies }
}

/// The options that do not always change something.
const CONDITIONS: &[Condition] = &[
    goes("light-sampling", "--estimator light and mis", |job| {
        matches!(job.estimator, EstimatorName::Light | EstimatorName::Mis)
    }),
    goes("heuristic", "--estimator mis", |job| job.estimator == EstimatorName::Mis),
    goes("diffuse", "--scene report, and not --convention published", |job| {
        job.scene == SceneName::Report && job.convention != ConventionName::Published
    }),
    goes("rays", "--estimator report, and not --convention published", Job::splits),
    goes("photons", PHOTONS, Job::uses_photons),
    goes("radius", PHOTONS, Job::uses_photons),
    goes("gather", "--estimator photon", Job::keeps_one_map),
    goes("caustic-photons", CAUSTICS, Job::gathers),
    goes("caustic-radius", CAUSTICS, Job::gathers),
    goes("patches", "--estimator radiosity", |job| job.estimator == EstimatorName::Radiosity),
    goes("pixel", SINGLE_RAYS, |job| !job.renders_images()),
    goes("sampler", SINGLE_RAYS, |job| !job.renders_images()),
    goes("grid", "--pixel grid and jitter", |job| {
        matches!(job.pixel, PixelName::Grid | PixelName::Jitter)
    }),
    goes("scrambles", "--sampler sobol", |job| job.sampler == SamplerName::Sobol),
    goes("exposure", "--convention physical", |job| job.convention == ConventionName::Physical),
];
const PHOTONS: &str = "--estimator photon and sppm";
const CAUSTICS: &str = "--estimator photon and --gather yes";
const SINGLE_RAYS: &str = "estimators of single rays, not light-tracer, bdpt and sppm";

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
                (u64::from(self.spp / cells) + 1) * u64::from(cells)
            ));
        }
        Film::checked_window(self.size, self.window)?;
        if self.renders_images() && self.window.is_some() {
            return refuse(format!(
                "--estimator {} renders whole images only: leave out the window",
                name(self.estimator)
            ));
        }
        if self.estimator == EstimatorName::LightTracer || self.uses_photons() {
            self.check_emitters()?;
        }
        if self.estimator == EstimatorName::Radiosity {
            check_memory(&Mesh::new(&self.build_scene()?, self.fineness())?)?;
        }
        Ok(())
    }

    /// Refuses options of which one is `given` and does nothing together with the others.
    ///
    /// # Errors
    /// [`Error::Option`] with what it goes with.
    pub fn check_effect(&self, given: impl Fn(&str) -> bool) -> Result<(), Error> {
        let idle = CONDITIONS.iter().find(|condition| {
            given(&condition.option.replace('-', "_")) && !(condition.applies)(self)
        });
        idle.map_or(Ok(()), |Condition { option, with, .. }| {
            Err(Error::Option(format!("--{option} changes nothing here: it goes with {with}")))
        })
    }

    /// Whether an option changes anything together with the others.
    pub(super) fn takes(&self, option: &str) -> bool {
        CONDITIONS
            .iter()
            .filter(|condition| condition.option == option)
            .all(|condition| (condition.applies)(self))
    }

    /// How finely radiosity divides the surfaces.
    pub(super) fn fineness(&self) -> Fineness {
        Fineness { patches: self.patches, halvings: 0 }
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
            self.photons.check_memory(self.keeps_one_map(), &scene, self.seed)?;
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

    /// Whether photons are looked up at the second diffuse surface, and caustics apart.
    fn gathers(&self) -> bool {
        self.keeps_one_map() && self.photons.gather == Gather::Yes
    }

    /// Whether the estimator keeps photons.
    pub(super) fn uses_photons(&self) -> bool {
        matches!(self.estimator, EstimatorName::Photon | EstimatorName::Sppm)
    }

    fn check_sobol(&self) -> Result<(), Error> {
        let refuse = |message: String| Err(Error::Option(message));
        if !matches!(self.pixel, PixelName::Random | PixelName::Centre) {
            return refuse("--sampler sobol goes with --pixel random and centre".to_owned());
        }
        if !self.spp.is_multiple_of(self.scrambles) {
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
