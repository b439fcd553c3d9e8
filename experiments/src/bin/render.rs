//! Renders one image: linear EXR with error bars, and a PNG beside it.

use experiments::say;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use experiments::cli::{self, parse_size};
use experiments::diffuse::DiffuseName;
use experiments::job::{
    ConventionName, EstimatorName, HeuristicName, Job, LightSamplingName, PixelName, SamplerName,
    SceneName,
};
use experiments::photons::Photons;
use experiments::progress::{Progress, catch_interrupt};
use whitefurnace::error::Error;
use whitefurnace::image::{check_writable, write_exr, write_png};

/// Render one image of a scene to an EXR file (linear radiance with its standard error) and a PNG.
///
/// Examples:
///   render                                            the report's room, physically consistent
///   render --convention report --out out/fig6.exr     what the report's text describes
///   render --scene cornell --size 512x512 --spp 64    another scene, smaller and noisier
///
/// The same options give the same bytes, whatever the number of threads. Ctrl-C writes what is done.
#[derive(Parser)]
#[command(name = "render", version, verbatim_doc_comment)]
struct Render {
    /// What to render
    #[arg(long, value_enum, default_value_t = SceneName::Report)]
    scene: SceneName,
    /// How light travels and is shown [default: physical, or report with --estimator report in the report's scene]
    #[arg(long, value_enum)]
    convention: Option<ConventionName>,
    /// How to compute it [default: mis, or report under --convention report and published]
    #[arg(long, value_enum)]
    estimator: Option<EstimatorName>,
    /// How shadow rays pick points on lights, for --estimator light and mis
    #[arg(long, value_enum, default_value_t)]
    light_sampling: LightSamplingName,
    /// How --estimator mis weights light that is both hit and sampled
    #[arg(long, value_enum, default_value_t)]
    heuristic: HeuristicName,
    /// Diffuse model of the report's white sphere
    #[arg(long, alias = "oren-nayar", value_enum, default_value_t = DiffuseName::Corrected)]
    diffuse: DiffuseName,
    /// Sample rays per diffuse hit, N of equation (16), for --estimator report
    #[arg(long, default_value_t = 1)]
    rays: u32,
    #[command(flatten)]
    photons: Photons,
    /// About how many patches all surfaces are divided into, for --estimator radiosity
    #[arg(long, default_value_t = 2000)]
    patches: u32,
    /// Where in a pixel the rays go
    #[arg(long, value_enum, default_value_t = PixelName::Random)]
    pixel: PixelName,
    /// Sub-pixels along each side for --pixel grid and jitter
    #[arg(long, default_value_t = 4)]
    grid: u32,
    /// Where random numbers come from
    #[arg(long, value_enum, default_value_t = SamplerName::Independent)]
    sampler: SamplerName,
    /// Independent scrambles per pixel for --sampler sobol; they give the error bars
    #[arg(long, default_value_t = 8)]
    scrambles: u32,
    /// Width x height in pixels
    #[arg(long, value_parser = parse_size, default_value = "1024x768")]
    size: [u32; 2],
    /// Samples per pixel
    #[arg(long, default_value_t = 64)]
    spp: u32,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 1, allow_negative_numbers = true)]
    seed: u64,
    /// Threads [default: one per core]
    #[arg(long)]
    threads: Option<usize>,
    /// Exposure of the PNG in stops, under --convention physical
    #[arg(long, default_value_t = 0.0, allow_hyphen_values = true)]
    exposure: f64,
    /// The EXR file; the PNG has the same name
    #[arg(long, default_value = "out/render.exr")]
    out: PathBuf,
}

fn main() -> ExitCode {
    cli::exit(run(&cli::parse()))
}

fn run(options: &Render) -> Result<(), Error> {
    let default = match (options.scene, options.estimator) {
        (SceneName::Report, Some(EstimatorName::Report)) => ConventionName::Report,
        _ => ConventionName::Physical,
    };
    let convention = options.convention.unwrap_or(default);
    let estimator = options
        .estimator
        .unwrap_or(Job::report(convention).estimator);
    let job = Job {
        scene: options.scene,
        convention,
        estimator,
        light_sampling: options.light_sampling,
        heuristic: options.heuristic,
        diffuse: options.diffuse,
        rays: options.rays,
        photons: options.photons,
        patches: options.patches,
        pixel: options.pixel,
        grid: options.grid,
        sampler: options.sampler,
        scrambles: options.scrambles,
        size: options.size,
        window: None,
        spp: options.spp,
        seed: options.seed,
    };
    job.check()?;
    if !options.exposure.is_finite() {
        return Err(Error::Option(format!(
            "--exposure {} must be a finite number",
            options.exposure
        )));
    }
    if options
        .out
        .extension()
        .is_none_or(|extension| extension != "exr")
    {
        return Err(Error::Option(format!(
            "--out {} must end in .exr; the PNG gets the same name",
            options.out.display()
        )));
    }
    let png = options.out.with_extension("png");
    cli::use_threads(options.threads)?;
    check_writable(&options.out)?;
    check_writable(&png)?;
    catch_interrupt();

    let start = Instant::now();
    let rendered = job.render(&Progress::new("render"))?;
    let seconds = start.elapsed().as_secs_f64();
    write_exr(
        &options.out,
        &rendered.film,
        &job.provenance(rendered.complete),
    )?;
    write_png(&png, &rendered.film, job.display(options.exposure), 1)?;
    let samples: u64 = rendered
        .film
        .pixels()
        .iter()
        .map(|p| u64::from(p.replications()))
        .sum::<u64>()
        * u64::from(rendered.film.samples_per_replication());
    say!(
        "{} and {}: {samples} samples in {seconds:.1} s, {:.2} million/s, mean relative standard error {:.2} %",
        options.out.display(),
        png.display(),
        samples as f64 / seconds / 1e6,
        100.0 * rendered.film.relative_error()
    );
    if !rendered.complete {
        say!("interrupted: the files hold the samples done so far (channel samples.Y)");
    }
    Ok(())
}
