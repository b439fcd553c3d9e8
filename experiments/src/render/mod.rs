//! A render job: what the command line and the experiments ask the library to render.

mod check;
pub mod command;
mod names;
pub mod photons;
mod provenance;
mod work;

use glam::DVec3;
use whitefurnace::bsdf::OrenNayarForm;
use whitefurnace::error::Error;
use whitefurnace::estimator::radiosity::Fineness;
use whitefurnace::film::Window;
use whitefurnace::image::Display;
use whitefurnace::pixel::PixelSampling;
use whitefurnace::render::{Numbers, Sampling};
use whitefurnace::scene::room::{self, Convention, Walls};
use whitefurnace::scene::{Scene, simple};

pub use names::{
    ConventionName, DiffuseName, EstimatorName, HeuristicName, LightSamplingName, PixelName,
    SamplerName, SceneName, name,
};
pub use work::{Rendered, Whole, Work};

use crate::render::photons::Photons;

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
    /// How photon mapping works.
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

impl Job {
    /// The report's scene under a convention, with the estimator that belongs to it.
    pub fn report(convention: ConventionName) -> Self {
        let estimator = match convention {
            ConventionName::Physical => EstimatorName::Mis,
            ConventionName::Report | ConventionName::Published => EstimatorName::Report,
        };
        Self { convention, estimator, ..Self::default() }
    }

    /// How the convention shows radiance; `exposure` in stops, for `physical`.
    pub fn display(&self, exposure: f64) -> Display {
        match self.convention {
            ConventionName::Physical => Display::Srgb { exposure },
            ConventionName::Report | ConventionName::Published => Display::Truncated,
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
        Sampling { pixel, numbers, seed: self.seed }
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
}
