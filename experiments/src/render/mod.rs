//! A render job: the options with which the command line and the experiments call the library.

mod check;
pub mod checkpoint;
pub mod command;
pub mod defaults;
mod names;
pub mod photons;
pub mod pilot;
pub mod preview;
mod work;

use clap::Args;
use glam::DVec3;
use whitefurnace::error::Error;
use whitefurnace::film::Window;
use whitefurnace::image::Display;
use whitefurnace::integrator::MAX_PATH_VERTICES;
use whitefurnace::material::OrenNayarForm;
use whitefurnace::sampling::Sampling;
use whitefurnace::sampling::pixel::PixelSampling;
use whitefurnace::sampling::sampler::SamplerKind;
use whitefurnace::scene::room::{Convention, Walls};
use whitefurnace::scene::{Scene, room, simple};

pub use names::{
    AdaptiveName, ConventionName, DiffuseName, EstimatorName, HeuristicName, LightSamplingName,
    PixelName, PrecisionName, SamplerName, SceneName, SceneSource, SilhouettesName,
    SpecularNeeName, name,
};
pub use work::{Observer, Rendered};

use crate::run::cli::{integer, parse_size};
use defaults::BASE;
use photons::Photons;

/// All options of the command line that decide the pixels of an image.
#[derive(Clone, Copy, Debug, Args)]
pub struct Job {
    /// The scene: a built-in one, or a scene file that ends in .toml
    #[arg(long, default_value = "report", value_name = "NAME|FILE.toml")]
    pub scene: SceneSource,
    /// Rules of light transport and display
    #[arg(long, value_enum, default_value_t = BASE.convention, hide_default_value = true)]
    pub convention: ConventionName,
    /// Estimator
    #[arg(long, value_enum, default_value_t = BASE.estimator, hide_default_value = true)]
    pub estimator: EstimatorName,
    /// Precision in which paths are traced, for --estimator mis, bsdf, light, whitted and report
    #[arg(long, alias = "engine", value_enum, default_value_t = BASE.precision)]
    pub precision: PrecisionName,
    /// How shadow rays pick points on lights, for --estimator light and mis
    #[arg(long, alias = "light-sampling", value_enum, default_value_t = BASE.light_sampler)]
    pub light_sampler: LightSamplingName,
    /// How --estimator mis weights light that is both hit and sampled
    #[arg(long, value_enum, default_value_t = BASE.heuristic)]
    pub heuristic: HeuristicName,
    /// Whether shadow rays of --estimator mis also reach lights through specular chains: flat
    /// mirrors, and spheres of mirror or glass
    #[arg(long, alias = "specular-shadow-rays", value_enum, default_value_t = BASE.specular_nee)]
    pub specular_nee: SpecularNeeName,
    /// Most scattering events between a light and the camera, for --estimator mis, bsdf and light;
    /// 0 leaves directly visible light; from 0 to 8192
    #[arg(long, allow_hyphen_values = true, value_parser = integer::<u32>(0..=u64::from(MAX_PATH_VERTICES)))]
    pub bounces: Option<u32>,
    /// Diffuse model of the report's white sphere
    #[arg(long, value_enum, default_value_t = BASE.diffuse)]
    pub diffuse: DiffuseName,
    /// Sample rays per diffuse hit, N of equation (16), for --estimator report; from 1 to 64
    #[arg(long, default_value_t = BASE.rays, allow_hyphen_values = true, value_parser = integer::<u32>(1..=64))]
    pub rays: u32,
    /// Options of photon mapping.
    #[command(flatten)]
    pub photons: Photons,
    /// Approximate number of patches of all surfaces, for --estimator radiosity; from 1 to
    /// 4294967295
    #[arg(long, default_value_t = BASE.patches, allow_hyphen_values = true, value_parser = integer::<u32>(1..=MAX_COUNT))]
    pub patches: u32,
    /// Positions of the rays in a pixel
    #[arg(long, value_enum, default_value_t = BASE.pixel)]
    pub pixel: PixelName,
    /// Sub-pixels along each side for --pixel grid and jitter; from 1 to 1024
    #[arg(long, default_value_t = BASE.grid, allow_hyphen_values = true, value_parser = integer::<u32>(1..=1024))]
    pub grid: u32,
    /// Whether the outlines of directly visible lights are supersampled with eight more points per
    /// sample (for mis, bsdf and light also in mirrors), for --convention physical, --pixel random
    /// and jitter, and all estimators but bdpt, bdpt-ends, light-tracer and sppm
    #[arg(
        long,
        alias = "outlines",
        value_enum,
        default_value_t = BASE.silhouettes,
        hide_default_value = true
    )]
    pub silhouettes: SilhouettesName,
    /// Where random numbers come from
    #[arg(long, value_enum, default_value_t = BASE.sampler, hide_default_value = true)]
    pub sampler: SamplerName,
    /// Independent scrambles per pixel for --sampler sobol, whose spread gives the error bars; from
    /// 1 to 4294967295
    #[arg(long, allow_hyphen_values = true, value_parser = integer::<u32>(1..=MAX_COUNT))]
    pub scrambles: Option<u32>,
    /// Whether noisier pixels, as measured by their neighbours' first samples, take more samples, for
    /// --estimator mis, bsdf and light, and --sampler sobol
    #[arg(long, value_enum, default_value_t = BASE.adaptive, hide_default_value = true)]
    pub adaptive: AdaptiveName,
    /// Width x height in pixels; from 1x1 to 100000000 pixels in all
    #[arg(long, allow_hyphen_values = true, value_parser = parse_size, default_value = "1024x768")]
    pub size: [u32; 2],
    /// The part of the frame to render
    #[arg(skip)]
    pub window: Option<Window>,
    /// Samples per pixel, on average with --adaptive yes; from 1 to 4294967295
    #[arg(long, default_value_t = BASE.spp, allow_hyphen_values = true, value_parser = integer::<u32>(1..=MAX_COUNT))]
    pub spp: u32,
    /// Seed of all random numbers; from 0 to 18446744073709551615
    #[arg(long, default_value_t = BASE.seed, allow_hyphen_values = true, value_parser = integer::<u64>(0..=u64::MAX))]
    pub seed: u64,
}

/// Upper limit of counts without another limit.
const MAX_COUNT: u64 = u32::MAX as u64;

impl Default for Job {
    /// Returns [`BASE`].
    fn default() -> Self {
        BASE
    }
}

impl Job {
    /// Returns the report's scene under a convention, with that convention's estimator.
    pub fn report(convention: ConventionName) -> Self {
        Self {
            convention,
            estimator: convention.estimator(),
            ..Self::default()
        }
    }

    /// Returns the display transform of the convention; `exposure` is in stops, for `physical`.
    pub fn display(&self, exposure: f64) -> Display {
        match self.convention {
            ConventionName::Physical => Display::Srgb { exposure },
            ConventionName::Report | ConventionName::Published => Display::Truncated,
        }
    }

    /// Returns the number of scrambles per pixel: as asked, or the default.
    fn scrambles(&self) -> u32 {
        self.scrambles
            .unwrap_or_else(|| defaults::scrambles(self.spp))
    }

    fn sampling(&self) -> Sampling {
        let pixel = match self.pixel {
            PixelName::Centre => PixelSampling::Centre,
            PixelName::Grid => PixelSampling::Grid(self.grid),
            PixelName::Random => PixelSampling::Random,
            PixelName::Jitter => PixelSampling::Jitter(self.grid),
        };
        let numbers = match self.sampler {
            SamplerName::Independent => SamplerKind::Independent,
            SamplerName::Sobol => SamplerKind::Sobol(self.spp / self.scrambles()),
        };
        let silhouettes =
            self.silhouettes == SilhouettesName::Yes && self.supersamples_silhouettes();
        Sampling {
            pixel,
            sampler: numbers,
            seed: self.seed,
            silhouettes,
        }
    }

    /// Builds the scene of the job.
    pub fn build_scene(&self) -> Result<Scene, Error> {
        let scene = match self.scene {
            SceneSource::Named(scene) => scene,
            SceneSource::File(file) => return file.description.build(),
        };
        match scene {
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
