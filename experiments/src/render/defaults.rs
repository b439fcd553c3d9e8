//! Defaults of `render`, in one place: the value of each option that is not given.
//!
//! [`BASE`] holds the value of every option by itself. The options of [`DEPENDENT`] then follow
//! from the others, in this order. `scrambles` and [`RR_DEPTH`] complete the table.
//!
//! - The command line of `render` takes all of it, and its help states it as `[default: ...]`.
//! - [`Job::default()`](Job) is [`BASE`] alone: an experiment states what it wants besides.
//! - The library's [`Path`](whitefurnace::integrator::Path) has textbook defaults of its own.

use whitefurnace::sampling::sampler::MAX_POINTS;

use super::photons::Photons;
use super::{
    AdaptiveName, ConventionName, DiffuseName, EstimatorName, HeuristicName, Job,
    LightSamplingName, PixelName, PrecisionName, SamplerName, SceneName, SceneSource,
    SilhouettesName, SpecularNeeName,
};

pub use whitefurnace::sampling::roulette::RR_DEPTH;

/// Value of each option where no other option matters: the report's figure 6 under the `physical`
/// convention, with independent random numbers, equal numbers of samples in all pixels, and no
/// supersampling of silhouettes.
pub const BASE: Job = Job {
    scene: SceneSource::Named(SceneName::Report),
    convention: ConventionName::Physical,
    estimator: EstimatorName::Mis,
    precision: PrecisionName::Double,
    light_sampler: LightSamplingName::Importance,
    heuristic: HeuristicName::Power,
    specular_nee: SpecularNeeName::Yes,
    bounces: None,
    diffuse: DiffuseName::Corrected,
    rays: 1,
    photons: Photons::DEFAULT,
    patches: 2000,
    pixel: PixelName::Random,
    grid: 4,
    silhouettes: SilhouettesName::No,
    sampler: SamplerName::Independent,
    scrambles: None,
    adaptive: AdaptiveName::No,
    size: [1024, 768],
    window: None,
    spp: 64,
    seed: 1,
};

/// Default that depends on other options.
pub struct DependentDefault {
    /// The option.
    pub option: &'static str,
    /// The default in words, as the help shows it.
    pub text: &'static str,
    /// Sets the option of a job that has its value of [`BASE`]; `None` if it stays unset there, and
    /// what reads it fills it in.
    set: Option<fn(&mut Job)>,
}

/// Defaults that depend on other options, each on those before it and on options of [`BASE`].
pub const DEPENDENT: &[DependentDefault] = &[
    DependentDefault {
        option: "convention",
        text: "physical, or report with --estimator report in the report's scene",
        set: Some(|job| {
            if job.scene == SceneName::Report && job.estimator == EstimatorName::Report {
                job.convention = ConventionName::Report;
            }
        }),
    },
    DependentDefault {
        option: "estimator",
        text: "mis, or report under --convention report and published",
        set: Some(|job| job.estimator = job.convention.estimator()),
    },
    // The report's own estimator gains nothing from Sobol' points and keeps the report's numbers.
    DependentDefault {
        option: "sampler",
        text: "sobol; independent with --estimator report and --pixel grid and jitter",
        set: Some(|job| {
            if job.estimator != EstimatorName::Report && !job.divides_pixels() {
                job.sampler = SamplerName::Sobol;
            }
        }),
    },
    DependentDefault {
        option: "silhouettes",
        text: "yes with these",
        set: Some(|job| {
            if job.supersamples_silhouettes() {
                job.silhouettes = SilhouettesName::Yes;
            }
        }),
    },
    DependentDefault {
        option: "adaptive",
        text: "yes with these from 32 samples on",
        set: Some(|job| job.adaptive = adaptive(job)),
    },
    DependentDefault {
        option: "bounces",
        text: "no limit",
        set: None,
    },
    DependentDefault {
        option: "scrambles",
        text: "the fewest from 4 on that divide --spp into at most 1024 points each",
        set: None,
    },
    DependentDefault {
        option: "caustic-photons",
        text: "as --photons",
        set: None,
    },
    DependentDefault {
        option: "caustic-radius",
        text: "as --radius",
        set: None,
    },
];

/// Smallest number of samples per pixel with which sampling is adaptive by default: with fewer, a
/// pilot is a quarter of them or more, and its own passes can cost more than it gains.
pub const MIN_ADAPTIVE_SPP: u32 = 32;

/// Least default number of scrambles per pixel. With more scrambles each has fewer points, which
/// gain less; but Student's intervals from two or three are several times as wide (experiment
/// `scrambles`).
pub const MIN_SCRAMBLES: u32 = 4;

/// Largest default number of points per scramble: a signal or a checkpoint waits until a pixel has
/// finished its scramble.
pub const MAX_POINTS_PER_SCRAMBLE: u32 = 1024;

/// Fills in the defaults that depend on other options, except of options that are given.
pub(super) fn apply(job: &mut Job, is_given: impl Fn(&str) -> bool) {
    for DependentDefault { option, set, .. } in DEPENDENT {
        if let Some(set) = set
            && !is_given(option)
        {
            set(job);
        }
    }
}

/// Returns whether sampling is adaptive by default.
pub(super) fn adaptive(job: &Job) -> AdaptiveName {
    if job.adapts() && job.spp >= MIN_ADAPTIVE_SPP {
        AdaptiveName::Yes
    } else {
        AdaptiveName::No
    }
}

/// Returns the default number of scrambles per pixel: the fewest that give each the same number of
/// points. A number of samples without a suitable divisor, such as a large prime, gets one scramble
/// per sample.
pub(super) fn scrambles(spp: u32) -> u32 {
    let divides = |n: &u32| spp.is_multiple_of(*n) && spp / n <= MAX_POINTS_PER_SCRAMBLE;
    (MIN_SCRAMBLES..=MAX_POINTS).find(divides).unwrap_or(spp)
}

/// Adds the default in words to the help of an option that depends on others.
pub(super) fn in_help(argument: clap::Arg) -> clap::Arg {
    let default = DEPENDENT
        .iter()
        .find(|default| argument.get_long() == Some(default.option));
    match (default, argument.get_help()) {
        (Some(DependentDefault { text, .. }), Some(help)) => {
            let help = format!("{help} [default: {text}]");
            argument.help(help)
        }
        _ => argument,
    }
}
