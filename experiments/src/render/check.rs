//! Checks of a render job's options, and the provenance that a file records of it.

use std::path::Path;

use clap::ArgMatches;
use whitefurnace::camera::Camera;
use whitefurnace::error::Error;
use whitefurnace::film::{Film, Window};
use whitefurnace::integrator::radiosity::{Mesh, MeshResolution, check_memory};
use whitefurnace::sampling::sampler::MAX_POINTS;

use super::command::{Render, given};
use super::names::SINGLE_RAY_ESTIMATORS;
use super::{
    ConventionName, EstimatorName, Job, PixelName, PrecisionName, SamplerName, SceneName,
    SceneSource, name,
};
use crate::render::photons::Gather;
use crate::run::cli::check_image_name;

/// An option of a job: the options it requires, and the value that a file records.
struct Setting {
    option: &'static str,
    /// Requirement on other options, in words; empty if there is none.
    requires: &'static str,
    /// Returns true if the option has an effect together with the job's other options.
    applies: fn(&Job) -> bool,
    /// Returns the recorded value; empty if it is not recorded.
    value: fn(&Job) -> String,
}

const fn always(option: &'static str, value: fn(&Job) -> String) -> Setting {
    Setting {
        option,
        requires: "",
        applies: |_| true,
        value,
    }
}

const fn conditional(
    option: &'static str,
    requires: &'static str,
    applies: fn(&Job) -> bool,
    value: fn(&Job) -> String,
) -> Setting {
    Setting {
        option,
        requires,
        applies,
        value,
    }
}

/// All options that decide the pixels, in the order in which files record them.
const SETTINGS: &[Setting] = &[
    always("scene", |job| job.scene.name()),
    always("scene-sha256", |job| match job.scene {
        SceneSource::Named(_) => String::new(),
        SceneSource::File(file) => file.digest.clone(),
    }),
    always("convention", |job| name(job.convention)),
    always("estimator", |job| name(job.estimator)),
    conditional(
        "precision",
        "--estimator mis, bsdf, light, whitted and report",
        Job::has_precisions,
        |job| {
            // The default is not recorded.
            if job.precision == PrecisionName::Single {
                name(job.precision)
            } else {
                String::new()
            }
        },
    ),
    conditional(
        "light-sampler",
        "--estimator light and mis",
        Job::samples_lights,
        |job| name(job.light_sampler),
    ),
    conditional(
        "heuristic",
        "--estimator mis",
        |job| job.estimator == EstimatorName::Mis,
        |job| name(job.heuristic),
    ),
    conditional(
        "specular-nee",
        "--estimator mis",
        |job| job.estimator == EstimatorName::Mis,
        |job| name(job.specular_nee),
    ),
    conditional("bounces", PATHS, Job::traces_paths, |job| {
        job.bounces
            .map_or_else(String::new, |most| most.to_string())
    }),
    conditional(
        "diffuse",
        "--scene report, and not --convention published",
        Job::has_white_sphere,
        |job| name(job.diffuse),
    ),
    conditional(
        "rays",
        "--estimator report, and not --convention published",
        Job::splits_paths,
        |job| job.rays.to_string(),
    ),
    conditional("photons", PHOTONS, Job::uses_photons, |job| {
        job.photons.photons.to_string()
    }),
    conditional("radius", PHOTONS, Job::uses_photons, |job| {
        job.photons.radius.to_string()
    }),
    conditional(
        "gather",
        "--estimator photon",
        Job::uses_one_photon_map,
        |job| name(job.photons.gather),
    ),
    conditional("caustic-photons", CAUSTICS, Job::uses_final_gather, |job| {
        job.photons.caustic().0.to_string()
    }),
    conditional("caustic-radius", CAUSTICS, Job::uses_final_gather, |job| {
        job.photons.caustic().1.to_string()
    }),
    conditional(
        "patches",
        RADIOSITY,
        |job| job.estimator == EstimatorName::Radiosity,
        |job| job.patches.to_string(),
    ),
    conditional(
        "pixel",
        SINGLE_RAY_ESTIMATORS,
        |job| !job.estimator.is_image_estimator(),
        |job| name(job.pixel),
    ),
    conditional(
        "grid",
        "--pixel grid and jitter",
        Job::divides_pixels,
        |job| job.grid.to_string(),
    ),
    conditional(
        "silhouettes",
        SILHOUETTES,
        Job::supersamples_silhouettes,
        |job| name(job.silhouettes),
    ),
    always("sampler", |job| name(job.sampler)),
    conditional(
        "scrambles",
        "--sampler sobol",
        |job| job.sampler == SamplerName::Sobol,
        |job| job.scrambles().to_string(),
    ),
    conditional("adaptive", ADAPTIVE, Job::adapts, |job| name(job.adaptive)),
    always(
        "size",
        |Job {
             size: [width, height],
             ..
         }| format!("{width}x{height}"),
    ),
    always("window", |job| {
        let text = |Window {
                        corner: [x, y],
                        size: [w, h],
                    }| format!("{w}x{h}+{x}+{y}");
        job.window.map_or_else(String::new, text)
    }),
    always("spp", |job| job.spp.to_string()),
    always("seed", |job| job.seed.to_string()),
    conditional(
        "exposure",
        "--convention physical",
        |job| job.convention == ConventionName::Physical,
        |_| String::new(),
    ),
];
const SILHOUETTES: &str =
    "--convention physical, --pixel random and jitter, and estimators of single rays";
const ADAPTIVE: &str = "--estimator mis, bsdf and light, and --sampler sobol";
const PATHS: &str = "--estimator mis, bsdf and light";
const RADIOSITY: &str = "--estimator radiosity";
const PHOTONS: &str = "--estimator photon and sppm";
const CAUSTICS: &str = "--estimator photon and --gather yes";

/// Returns the text as one line for an EXR file, with characters outside Latin-1 escaped.
fn latin_1(text: &str) -> String {
    let fits = |c: &char| *c <= 'ÿ' && !c.is_control();
    text.chars()
        .map(|c| {
            if fits(&c) {
                c.to_string()
            } else {
                c.escape_default().to_string()
            }
        })
        .collect()
}

impl Job {
    /// Refuses contradictory options before any work is done.
    pub fn check(&self) -> Result<(), Error> {
        let refuse = |message: String| Err(Error::Option(message));
        let (scene, convention, estimator) = (
            self.scene.name(),
            name(self.convention),
            name(self.estimator),
        );
        if self.scene != SceneName::Report && self.convention != ConventionName::Physical {
            return refuse(format!(
                "--scene {scene} is defined under --convention physical only; --convention {convention} belongs to --scene \
                 report"
            ));
        }
        // Empty: any estimator.
        let takes: &[EstimatorName] = match self.convention {
            ConventionName::Physical => &[],
            ConventionName::Report => &[EstimatorName::Report, EstimatorName::Whitted],
            ConventionName::Published => &[EstimatorName::Report],
        };
        if !takes.is_empty() && !takes.contains(&self.estimator) {
            let names = takes
                .iter()
                .copied()
                .map(name)
                .collect::<Vec<_>>()
                .join(" or ");
            return refuse(format!(
                "--estimator {estimator} does not follow --convention {convention}, which takes --estimator {names}"
            ));
        }
        if self.sampler == SamplerName::Sobol {
            self.check_sobol()?;
        }
        let cells = self.sampling().pixel.samples_per_replication();
        let Self { spp, grid, .. } = self;
        if !spp.is_multiple_of(cells) {
            let next = (u64::from(spp / cells) + 1) * u64::from(cells);
            return refuse(format!(
                "--spp {spp} is not a multiple of the {cells} samples of a {grid}x{grid} grid: take {next} or change \
                 --grid"
            ));
        }
        Film::checked_window(self.size, self.window)?;
        if self.estimator.is_image_estimator() && self.window.is_some() {
            return refuse(format!(
                "--estimator {estimator} renders whole images only: leave out the window"
            ));
        }
        if let SceneSource::File(file) = self.scene
            && !self.traces_paths()
            && let Some((material, _)) = file
                .description
                .materials
                .iter()
                .find(|(_, s)| s.bsdf.is_rough_glass())
            && self
                .build_scene()?
                .primitives()
                .any(|(_, surface)| surface.bsdf.is_rough_glass())
        {
            return refuse(format!(
                "--estimator {estimator} does not take rough glass, of which the material \"{material}\" of {scene} is: take \
                 --estimator mis, bsdf or light"
            ));
        }
        if self.estimator == EstimatorName::LightTracer || self.uses_photons() {
            self.check_emitters()?;
        }
        if self.estimator == EstimatorName::Radiosity {
            check_memory(&Mesh::new(&self.build_scene()?, self.resolution())?)?;
        }
        Ok(())
    }

    /// Refuses an option that is `given` and has no effect together with the others.
    pub fn check_effect(&self, given: impl Fn(&str) -> bool) -> Result<(), Error> {
        // An option without a requirement always has an effect.
        let mut conditional = SETTINGS
            .iter()
            .filter(|setting| !setting.requires.is_empty());
        let idle = conditional
            .find(|setting| !(setting.applies)(self) && given(&setting.option.replace('-', "_")));
        idle.map_or(
            Ok(()),
            |Setting {
                 option, requires, ..
             }| {
                Err(Error::Option(format!(
                    "--{option} has no effect here: it needs {requires}"
                )))
            },
        )
    }

    /// Returns `key=value` lines of all that decides the pixels, and of the camera, for the EXR's
    /// attribute. Characters that do not fit such lines or Latin-1 are escaped.
    pub fn provenance(&self, camera: &Camera, complete: bool) -> String {
        let mut text = format!(
            "program=whitefurnace\nversion={}\ncommit={}\n",
            env!("CARGO_PKG_VERSION"),
            env!("WHITEFURNACE_COMMIT")
        );
        for Setting {
            option,
            applies,
            value,
            ..
        } in SETTINGS
        {
            let value = value(self);
            // Estimators of whole images take random points, which is the default.
            let is_said = applies(self) || *option == "pixel";
            if is_said && !value.is_empty() {
                text += &format!("{option}={}\n", latin_1(&value));
            }
        }
        text + &camera.text() + "complete=" + if complete { "yes" } else { "no" } + "\n"
    }

    /// Returns the camera of the job's scene.
    pub fn camera(&self) -> Result<Camera, Error> {
        match self.scene {
            SceneSource::File(file) => Ok(file.description.camera),
            SceneSource::Named(_) => self.build_scene().map(|scene| *scene.camera()),
        }
    }

    pub(super) fn resolution(&self) -> MeshResolution {
        MeshResolution {
            patches: self.patches,
            halvings: 0,
        }
    }

    /// Refuses scenes whose light no particle carries, and more photons than fit in memory.
    fn check_emitters(&self) -> Result<(), Error> {
        let scene = self.build_scene()?;
        if !scene.background().is_black() {
            return Err(Error::Option(format!(
                "--scene {} is lit by its background, where the particles of --estimator {} cannot start",
                self.scene.name(),
                name(self.estimator)
            )));
        }
        if self.uses_photons() {
            self.photons
                .check_memory(self.uses_one_photon_map(), &scene, self.seed)?;
        }
        Ok(())
    }

    /// Returns true if silhouettes of lights can be supersampled.
    pub(super) fn supersamples_silhouettes(&self) -> bool {
        self.convention == ConventionName::Physical
            && matches!(self.pixel, PixelName::Random | PixelName::Jitter)
            && !self.estimator.is_image_estimator()
    }

    /// Returns true if the number of samples can vary from pixel to pixel.
    pub(super) fn adapts(&self) -> bool {
        self.traces_paths() && self.sampler == SamplerName::Sobol
    }

    fn traces_paths(&self) -> bool {
        matches!(
            self.estimator,
            EstimatorName::Bsdf | EstimatorName::Light | EstimatorName::Mis
        )
    }

    /// Returns true if the estimator traces paths in either precision.
    pub(super) fn has_precisions(&self) -> bool {
        match self.estimator {
            EstimatorName::Bsdf
            | EstimatorName::Light
            | EstimatorName::Mis
            | EstimatorName::Whitted => true,
            EstimatorName::Report => self.convention != ConventionName::Published,
            _ => false,
        }
    }

    fn samples_lights(&self) -> bool {
        matches!(self.estimator, EstimatorName::Light | EstimatorName::Mis)
    }

    fn has_white_sphere(&self) -> bool {
        self.scene == SceneName::Report && self.convention != ConventionName::Published
    }

    pub(super) fn divides_pixels(&self) -> bool {
        matches!(self.pixel, PixelName::Grid | PixelName::Jitter)
    }

    /// Returns true if the estimator sends [`rays`](Self::rays) from each diffuse hit.
    fn splits_paths(&self) -> bool {
        self.estimator == EstimatorName::Report && self.convention != ConventionName::Published
    }

    /// Returns true if all samples share one photon map.
    pub(super) fn uses_one_photon_map(&self) -> bool {
        self.estimator == EstimatorName::Photon
    }

    /// Returns true if photons are gathered at the second diffuse surface, with a separate caustic
    /// map.
    fn uses_final_gather(&self) -> bool {
        self.uses_one_photon_map() && self.photons.gather == Gather::Yes
    }

    pub(super) fn uses_photons(&self) -> bool {
        matches!(self.estimator, EstimatorName::Photon | EstimatorName::Sppm)
    }

    fn check_sobol(&self) -> Result<(), Error> {
        let refuse = |message: String| Err(Error::Option(message));
        if !matches!(self.pixel, PixelName::Random | PixelName::Centre) {
            return refuse("--sampler sobol goes with --pixel random and centre".to_owned());
        }
        let (spp, scrambles) = (self.spp, self.scrambles());
        if !spp.is_multiple_of(scrambles) {
            return refuse(format!(
                "--spp {spp} is not a multiple of the {scrambles} scrambles: change one of them"
            ));
        }
        if spp / scrambles > MAX_POINTS {
            return refuse(format!(
                "--spp {spp} in {scrambles} scrambles is more than {MAX_POINTS} points each: raise --scrambles"
            ));
        }
        Ok(())
    }
}

impl Render {
    /// Refuses options that contradict each other or have no effect.
    pub fn check(&self, matches: &ArgMatches) -> Result<(), Error> {
        self.job.check()?;
        self.job.check_effect(|id| given(matches, id))?;
        self.replication_range()?;
        check_image_name(&self.out)?;
        let Some(preview) = &self.preview else {
            return Ok(());
        };
        let absolute = |path: &Path| std::path::absolute(path).map_err(Error::file("write", path));
        let taken = ["png", "partial.png"].map(|end| absolute(&self.out.with_extension(end)));
        let free = !taken
            .into_iter()
            .collect::<Result<Vec<_>, _>>()?
            .contains(&absolute(preview)?);
        if preview
            .extension()
            .is_none_or(|extension| extension != "png")
            || !free
        {
            let preview = preview.display();
            return Err(Error::Option(format!(
                "--preview {preview} must end in .png, and be no file of --out"
            )));
        }
        Ok(())
    }
}
