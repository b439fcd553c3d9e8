//! A render job: what the command line and the experiments ask the library to render.

mod provenance;

use clap::ValueEnum;
use glam::DVec3;
use whitefurnace::bsdf::OrenNayarForm;
use whitefurnace::emitter::LightSampling;
use whitefurnace::error::Error;
use whitefurnace::estimator::radiosity::{Fineness, Mesh, check_memory};
use whitefurnace::estimator::{
    Bdpt, Estimator, Heuristic, ImageEstimator, LightRules, LightTracer, Path, PhotonMapping,
    Published, Radiosity, Report, Sppm, Standard, Strategy, Whitted,
};
use whitefurnace::film::{Film, Window};
use whitefurnace::image::Display;
use whitefurnace::pixel::PixelSampling;
use whitefurnace::render::{Numbers, Sampling, render, render_passes};
use whitefurnace::sampler::LONGEST;
use whitefurnace::scene::room::{self, Convention, Walls};
use whitefurnace::scene::{Scene, simple};

use crate::diffuse::DiffuseName;
use crate::photons::Photons;
use crate::progress::Progress;

/// The scenes that programs can name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SceneName {
    /// The report's final scene
    Report,
    /// The same room with Lambert surfaces only
    DiffuseRoom,
    /// White sphere, mirror and glass in a uniform environment: every pixel is 1
    Environment,
    /// Closed cube of albedo 0.75 whose walls emit: every pixel is 4
    FurnaceBox,
    /// Spherical cavity of albedo 0.75 with an emitting cap: off the cap every pixel is 0.75
    CavityCap,
    /// Glass cube in a uniform environment: every pixel is 1
    GlassCube,
    /// The Cornell box
    Cornell,
}

/// The estimators that programs can name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EstimatorName {
    /// Path tracing that finds lights by the directions of its paths alone
    Bsdf,
    /// Path tracing that finds lights by shadow rays alone
    Light,
    /// Path tracing by both, combined by multiple importance sampling
    Mis,
    /// Particles from the lights, each hit connected to the camera
    LightTracer,
    /// Photon mapping with a kd-tree; its error bars leave out the noise of the photons that all pixels share
    Photon,
    /// Stochastic progressive photon mapping: each sample is a pass with photons of its own and a smaller radius
    Sppm,
    /// Bidirectional path tracing: a camera path and a particle, connected in every way
    Bdpt,
    /// The report's: shadow rays, uniform hemisphere, roulette, at most 7 segments
    Report,
    /// Finite elements for Lambert surfaces: no noise, but the error of a mesh
    Radiosity,
    /// Whitted ray tracing: shadow rays, mirror and glass tree, no indirect light
    Whitted,
}

/// The light-transport conventions, as programs name them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ConventionName {
    /// Energy-consistent light transport
    Physical,
    /// What the report's text describes
    Report,
    /// A hypothesis about the program that made the published figure 6
    Published,
}

/// The strategies of section 2.7, as programs name them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PixelName {
    /// Every ray through the pixel's centre
    Centre,
    /// The centres of n × n sub-pixels
    Grid,
    /// Random points
    Random,
    /// A random point in each of n × n sub-pixels
    Jitter,
}

/// Where random numbers come from, as programs name it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SamplerName {
    /// A stream of its own for each sample
    Independent,
    /// Owen-scrambled Sobol' points, several scrambles per pixel
    Sobol,
}

/// How shadow rays of path tracing pick points on lights, as programs name it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum LightSamplingName {
    /// Uniform in area
    #[default]
    Area,
    /// Uniform in the solid angle under which the light is seen
    SolidAngle,
}

/// The heuristics of multiple importance sampling, as programs name them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum HeuristicName {
    /// In proportion to the densities
    #[default]
    Balance,
    /// In proportion to their squares
    Power,
}

/// The name that the command line uses for a value.
pub fn name<T: ValueEnum + Copy>(value: T) -> String {
    value
        .to_possible_value()
        .map_or_else(String::new, |value| value.get_name().to_owned())
}

/// Everything that decides the pixels of an image.
#[derive(Clone, Copy, Debug)]
pub struct Job {
    /// The scene.
    pub scene: SceneName,
    /// How light travels and is shown.
    pub convention: ConventionName,
    /// The estimator.
    pub estimator: EstimatorName,
    /// How shadow rays of path tracing pick points on lights.
    pub light_sampling: LightSamplingName,
    /// How [`EstimatorName::Mis`] weights.
    pub heuristic: HeuristicName,
    /// The model of the report's white sphere.
    pub diffuse: DiffuseName,
    /// N of (16) for the report's estimator.
    pub rays: u32,
    /// What photon mapping is told.
    pub photons: Photons,
    /// About how many patches radiosity divides the surfaces into.
    pub patches: u32,
    /// Where in a pixel the rays go.
    pub pixel: PixelName,
    /// n of the n × n sub-pixels of a grid.
    pub grid: u32,
    /// Where random numbers come from.
    pub sampler: SamplerName,
    /// Independent scrambles per pixel of `SamplerName::Sobol`: they give the error bars.
    pub scrambles: u32,
    /// Width and height of the full frame in pixels.
    pub size: [u32; 2],
    /// The part of the frame to render.
    pub window: Option<Window>,
    /// Samples per pixel.
    pub spp: u32,
    /// Master seed.
    pub seed: u64,
}

impl Default for Job {
    /// The report's figure 6 under the `physical` convention.
    fn default() -> Self {
        Self {
            scene: SceneName::Report,
            convention: ConventionName::Physical,
            estimator: EstimatorName::Mis,
            light_sampling: LightSamplingName::default(),
            heuristic: HeuristicName::default(),
            diffuse: DiffuseName::Corrected,
            rays: 1,
            photons: Photons::default(),
            patches: Fineness::default().patches,
            pixel: PixelName::Random,
            grid: 4,
            sampler: SamplerName::Independent,
            scrambles: 8,
            size: [1024, 768],
            window: None,
            spp: 512,
            seed: 1,
        }
    }
}

/// A film and whether all the samples that were asked for are on it.
pub struct Rendered {
    /// The film.
    pub film: Film,
    /// False after Ctrl-C.
    pub complete: bool,
}

impl Job {
    /// The report's scene under a convention, with the estimator that belongs to it.
    pub fn report(convention: ConventionName) -> Self {
        let estimator = match convention {
            ConventionName::Physical => EstimatorName::Mis,
            ConventionName::Report | ConventionName::Published => EstimatorName::Report,
        };
        Self {
            convention,
            estimator,
            ..Self::default()
        }
    }

    /// How the convention shows radiance; `exposure` in stops, for `physical`.
    pub fn display(&self, exposure: f64) -> Display {
        match self.convention {
            ConventionName::Physical => Display::Srgb { exposure },
            ConventionName::Report | ConventionName::Published => Display::Truncated,
        }
    }

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
        let legal = match self.convention {
            ConventionName::Physical => self.estimator != EstimatorName::Report,
            ConventionName::Report => {
                matches!(
                    self.estimator,
                    EstimatorName::Report | EstimatorName::Whitted
                )
            }
            ConventionName::Published => self.estimator == EstimatorName::Report,
        };
        if !legal {
            let takes = match self.convention {
                ConventionName::Physical => "any but report",
                ConventionName::Report => "report or whitted",
                ConventionName::Published => "report",
            };
            return refuse(format!(
                "--estimator {} does not follow --convention {convention}, which takes --estimator {takes}",
                name(self.estimator)
            ));
        }
        if self.rays == 0 || self.rays > 64 {
            return refuse(format!("--rays {} must be between 1 and 64", self.rays));
        }
        if self.rays > 1
            && (self.estimator, self.convention) != (EstimatorName::Report, ConventionName::Report)
        {
            return refuse(
                "--rays is an option of --estimator report under --convention report".to_owned(),
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
    fn fineness(&self) -> Fineness {
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

    /// Whether all samples share their photons.
    fn keeps_one_map(&self) -> bool {
        self.estimator == EstimatorName::Photon
    }

    /// Whether the estimator keeps photons.
    fn uses_photons(&self) -> bool {
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

    /// Renders the job.
    ///
    /// # Errors
    /// What [`check`](Self::check), [`Film::new`] and [`render`] refuse.
    pub fn render(&self, progress: &Progress) -> Result<Rendered, Error> {
        self.check()?;
        let scene = self.build_scene()?;
        let rules = match self.convention {
            ConventionName::Physical => LightRules::PHYSICAL,
            ConventionName::Report | ConventionName::Published => LightRules::REPORT,
        };
        match (self.estimator, self.convention) {
            (EstimatorName::Bsdf, _) => self.paths(&scene, Strategy::Bsdf, progress),
            (EstimatorName::Light, _) => self.paths(&scene, Strategy::Light, progress),
            (EstimatorName::Mis, _) => self.paths(&scene, Strategy::Mis, progress),
            (EstimatorName::LightTracer, _) => {
                self.render_images(&scene, &LightTracer::<Standard>::default(), progress)
            }
            (EstimatorName::Photon, _) => {
                let (map, lookup) = (self.photons.map(), self.photons.lookup(true));
                let photons = PhotonMapping::new(Standard, &scene, lookup, map, (self.seed, 0))?;
                self.render_with(&scene, &photons, progress)
            }
            (EstimatorName::Sppm, _) => {
                let (particles, radius) = self.photons.map();
                let sppm = Sppm {
                    parts: Standard,
                    particles,
                    radius,
                };
                self.render_images(&scene, &sppm, progress)
            }
            (EstimatorName::Bdpt, _) => {
                self.render_images(&scene, &Bdpt::<Standard>::default(), progress)
            }
            (EstimatorName::Radiosity, _) => {
                let fineness = self.fineness();
                let nodes = Mesh::new(&scene, fineness)?.nodes() as u64;
                let bar = progress.bar(nodes);
                let node_done = |nodes| bar.advance(nodes);
                let solved = Radiosity::new(Standard, &scene, fineness, &node_done)?;
                bar.finish();
                self.render_with(&scene, &solved, progress)
            }
            (EstimatorName::Whitted, _) => self.render_with(&scene, &Whitted::new(rules), progress),
            (EstimatorName::Report, ConventionName::Published) => {
                self.render_with(&scene, &Published::default(), progress)
            }
            (EstimatorName::Report, _) => {
                let report = Report {
                    rays: self.rays,
                    rules,
                    ..Report::default()
                };
                self.render_with(&scene, &report, progress)
            }
        }
    }

    fn sampling(&self) -> Sampling {
        let pixel = match self.pixel {
            PixelName::Centre => PixelSampling::Centre,
            PixelName::Grid => PixelSampling::Grid(self.grid),
            PixelName::Random => PixelSampling::Random,
            PixelName::Jitter => PixelSampling::Jitter(self.grid),
        };
        let numbers = match self.sampler {
            SamplerName::Independent => Numbers::Independent,
            SamplerName::Sobol => Numbers::Sobol(self.spp / self.scrambles),
        };
        Sampling {
            pixel,
            numbers,
            seed: self.seed,
        }
    }

    /// The scene of the job.
    ///
    /// # Errors
    /// None for the scenes that programs can name.
    pub fn build_scene(&self) -> Result<Scene, Error> {
        match self.scene {
            SceneName::Report => match self.convention {
                ConventionName::Physical | ConventionName::Report => {
                    let albedo = DVec3::splat(room::WHITE);
                    room::with_white_sphere(
                        self.diffuse.bsdf(albedo, room::SIGMA),
                        Walls::default(),
                    )
                }
                ConventionName::Published => {
                    room::report(Convention::Published, OrenNayarForm::Corrected)
                }
            },
            SceneName::DiffuseRoom => room::diffuse(),
            SceneName::Environment => simple::environment(),
            SceneName::FurnaceBox => simple::furnace_box(0.75),
            SceneName::CavityCap => simple::cavity_cap(0.75, simple::Cap::Reflecting),
            SceneName::GlassCube => simple::glass_cube(false),
            SceneName::Cornell => simple::cornell(),
        }
    }

    fn paths(
        &self,
        scene: &Scene,
        strategy: Strategy,
        progress: &Progress,
    ) -> Result<Rendered, Error> {
        let path = Path {
            parts: Standard,
            strategy,
            lights: match self.light_sampling {
                LightSamplingName::Area => LightSampling::Area,
                LightSamplingName::SolidAngle => LightSampling::SolidAngle,
            },
            heuristic: match self.heuristic {
                HeuristicName::Balance => Heuristic::Balance,
                HeuristicName::Power => Heuristic::Power,
            },
        };
        self.render_with(scene, &path, progress)
    }

    /// Renders whole images, each a replication.
    fn render_images<E: ImageEstimator>(
        &self,
        scene: &Scene,
        estimator: &E,
        progress: &Progress,
    ) -> Result<Rendered, Error> {
        let mut film = Film::new(self.size, self.window, 1)?;
        let [width, height] = film.size().map(u64::from);
        let mut bar = progress.bar(width * height * u64::from(self.spp));
        let pass_done = |samples| bar.advance(samples);
        let range = 0..self.spp;
        let complete = render_passes(scene, estimator, self.seed, &mut film, range, &pass_done)?;
        bar.error(|| film.relative_error());
        bar.finish();
        Ok(Rendered { film, complete })
    }

    /// Renders in passes that double up to [`LARGEST_PASS`] replications, so that error and image are
    /// known early.
    ///
    /// # Errors
    /// As [`render`](Self::render).
    pub fn render_with<E: Estimator>(
        &self,
        scene: &Scene,
        estimator: &E,
        progress: &Progress,
    ) -> Result<Rendered, Error> {
        let sampling = self.sampling();
        let per_replication = sampling.samples_per_replication();
        let mut film = Film::new(self.size, self.window, per_replication)?;
        let replications = self.spp / per_replication;
        let [width, height] = film.size().map(u64::from);
        let mut bar = progress.bar(width * height * u64::from(self.spp));
        let mut done = 0;
        while done < replications {
            let end = replications.min(done + done.clamp(1, LARGEST_PASS));
            let row_done = |samples| bar.advance(samples);
            if !render(
                scene,
                estimator,
                sampling,
                &mut film,
                &(done..end),
                &row_done,
            )? {
                break;
            }
            done = end;
            bar.error(|| film.relative_error());
        }
        bar.finish();
        Ok(Rendered {
            film,
            complete: done == replications,
        })
    }
}

const LARGEST_PASS: u32 = 16;
