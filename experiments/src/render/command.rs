//! The command line of `render`.

use std::path::PathBuf;

use clap::parser::ValueSource;
use clap::{ArgMatches, FromArgMatches as _, Parser};
use whitefurnace::error::Error;

use super::{ConventionName, EstimatorName, Job, OutlinesName, SamplerName, SceneName};
use crate::run::cli::{real, whole};

/// Render one image of a scene to an EXR file (linear radiance with its standard error) and a PNG.
///
/// Examples:
///   render                                            the report's room, physically consistent
///   render --convention report --out out/fig6.exr     what the report's text describes
///   render --scene cornell --size 512x512 --spp 64    another scene, smaller and noisier
///   render --scene room.toml                          a scene of your own: the book's page Scene files
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
    #[command(flatten)]
    /// What to render, and how.
    pub job: Job,
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

fn given(matches: &ArgMatches, id: &str) -> bool {
    matches.value_source(id) == Some(ValueSource::CommandLine)
}

impl Render {
    /// The options of a command line, with what they imply where it says nothing.
    pub fn of(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut render = Self::from_arg_matches(matches)?;
        let job = &mut render.job;
        let is_reports = job.scene == SceneName::Report && job.estimator == EstimatorName::Report;
        if is_reports && !given(matches, "convention") {
            job.convention = ConventionName::Report;
        }
        if !given(matches, "estimator") {
            job.estimator = job.convention.estimator();
        }
        // The report's own estimator gains nothing: it keeps the report's numbers.
        if job.estimator != EstimatorName::Report && !job.divides_pixels() && !given(matches, "sampler") {
            job.sampler = SamplerName::Sobol;
        }
        if job.shows_outlines() && !given(matches, "outlines") {
            job.outlines = OutlinesName::Yes;
        }
        Ok(render)
    }

    /// Refuses options that make no sense together, or do nothing.
    pub fn check(&self, matches: &ArgMatches) -> Result<(), Error> {
        self.job.check()?;
        self.job.check_effect(|id| given(matches, id))?;
        if self.out.extension().is_none_or(|extension| extension != "exr") {
            return Err(Error::Option(format!(
                "--out {} must end in .exr; the PNG gets the same name",
                self.out.display()
            )));
        }
        Ok(())
    }
}
