//! The command line of `render`.

use std::path::PathBuf;

use clap::Parser;
use whitefurnace::error::Error;

use crate::render::photons::Photons;
use crate::render::{
    ConventionName, DiffuseName, EstimatorName, HeuristicName, Job, LightSamplingName, PixelName,
    SamplerName, SceneName,
};
use crate::run::cli::{parse_size, real, whole};

/// Render one image of a scene to an EXR file (linear radiance with its standard error) and a PNG.
///
/// Examples:
///   render                                            the report's room, physically consistent
///   render --convention report --out out/fig6.exr     what the report's text describes
///   render --scene cornell --size 512x512 --spp 64    another scene, smaller and noisier
///
/// The same options give the same bytes, whatever the number of threads. An option that changes nothing
/// together with the others is refused.
///
/// Ctrl-C, SIGTERM and SIGHUP write what is done to NAME.partial.exr and NAME.partial.png; a second
/// Ctrl-C writes nothing. Exit codes: 0 if all is done, 2 for a wrong option or a file that cannot be
/// written, 130 after Ctrl-C, 143 after SIGTERM, 129 after SIGHUP.
#[derive(Parser)]
#[command(name = "render", version, verbatim_doc_comment)]
pub struct Render {
    /// What to render
    #[arg(long, value_enum, default_value_t = SceneName::Report)]
    pub scene: SceneName,
    /// How light travels and is shown [default: physical, or report with --estimator report in the report's scene]
    #[arg(long, value_enum)]
    pub convention: Option<ConventionName>,
    /// How to compute it [default: mis, or report under --convention report and published]
    #[arg(long, value_enum)]
    pub estimator: Option<EstimatorName>,
    /// How shadow rays pick points on lights, for --estimator light and mis
    #[arg(long, value_enum, default_value_t)]
    pub light_sampling: LightSamplingName,
    /// How --estimator mis weights light that is both hit and sampled
    #[arg(long, value_enum, default_value_t)]
    pub heuristic: HeuristicName,
    /// Diffuse model of the report's white sphere
    #[arg(long, value_enum, default_value_t = DiffuseName::Corrected)]
    pub diffuse: DiffuseName,
    /// Sample rays per diffuse hit, N of equation (16), for --estimator report; from 1 to 64
    #[arg(long, default_value_t = 1, allow_hyphen_values = true, value_parser = whole::<u32>(1..=64))]
    pub rays: u32,
    /// How photon mapping works.
    #[command(flatten)]
    pub photons: Photons,
    /// About how many patches all surfaces are divided into, for --estimator radiosity; from 1 to 4294967295
    #[arg(long, default_value_t = 2000, allow_hyphen_values = true, value_parser = whole::<u32>(1..=ANY))]
    pub patches: u32,
    /// Where in a pixel the rays go
    #[arg(long, value_enum, default_value_t = PixelName::Random)]
    pub pixel: PixelName,
    /// Sub-pixels along each side for --pixel grid and jitter; from 1 to 1024
    #[arg(long, default_value_t = 4, allow_hyphen_values = true, value_parser = whole::<u32>(1..=1024))]
    pub grid: u32,
    /// Where random numbers come from
    #[arg(long, value_enum, default_value_t = SamplerName::Independent)]
    pub sampler: SamplerName,
    /// Independent scrambles per pixel for --sampler sobol, which give the error bars; from 1 to 4294967295
    #[arg(long, default_value_t = 8, allow_hyphen_values = true, value_parser = whole::<u32>(1..=ANY))]
    pub scrambles: u32,
    /// Width x height in pixels; from 1x1 to 100000000 pixels in all
    #[arg(long, allow_hyphen_values = true, value_parser = parse_size, default_value = "1024x768")]
    pub size: [u32; 2],
    /// Samples per pixel; from 1 to 4294967295
    #[arg(long, default_value_t = 64, allow_hyphen_values = true, value_parser = whole::<u32>(1..=ANY))]
    pub spp: u32,
    /// Seed of all random numbers; from 0 to 18446744073709551615
    #[arg(long, default_value_t = 1, allow_hyphen_values = true, value_parser = whole::<u64>(0..=u64::MAX))]
    pub seed: u64,
    /// Threads; from 1 to 1024 [default: one per core]
    #[arg(long, allow_hyphen_values = true, value_parser = whole::<usize>(1..=1024))]
    pub threads: Option<usize>,
    /// Exposure of the PNG in stops, under --convention physical; from -100 to 100
    #[arg(long, default_value_t = 0.0, allow_hyphen_values = true, value_parser = real(-100.0..=100.0))]
    pub exposure: f64,
    /// The EXR file; the PNG has the same name
    #[arg(long, default_value = "out/render.exr")]
    pub out: PathBuf,
}

/// The largest count.
const ANY: u64 = u32::MAX as u64;

impl Render {
    /// The job that the options describe.
    pub fn job(&self) -> Job {
        let default = match (self.scene, self.estimator) {
            (SceneName::Report, Some(EstimatorName::Report)) => ConventionName::Report,
            _ => ConventionName::Physical,
        };
        let convention = self.convention.unwrap_or(default);
        Job {
            scene: self.scene,
            convention,
            estimator: self.estimator.unwrap_or(Job::report(convention).estimator),
            light_sampling: self.light_sampling,
            heuristic: self.heuristic,
            diffuse: self.diffuse,
            rays: self.rays,
            photons: self.photons,
            patches: self.patches,
            pixel: self.pixel,
            grid: self.grid,
            sampler: self.sampler,
            scrambles: self.scrambles,
            size: self.size,
            window: None,
            spp: self.spp,
            seed: self.seed,
        }
    }

    /// The job, unless the options make no sense together; `given` says which of them stand on the command
    /// line.
    ///
    /// # Errors
    /// [`Error::Option`] with what to change.
    pub fn checked_job(&self, given: impl Fn(&str) -> bool) -> Result<Job, Error> {
        let job = self.job();
        job.check()?;
        job.check_effect(given)?;
        if self.out.extension().is_none_or(|extension| extension != "exr") {
            return Err(Error::Option(format!(
                "--out {} must end in .exr; the PNG gets the same name",
                self.out.display()
            )));
        }
        Ok(job)
    }
}
