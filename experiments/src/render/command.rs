//! The command line of `render`.

use std::path::PathBuf;
use std::str::FromStr as _;
use std::time::Duration;

use clap::parser::ValueSource;
use clap::{ArgMatches, FromArgMatches as _, Parser};
use whitefurnace::error::Error;
use whitefurnace::shard::Shard;

use super::checkpoint::ReplicationRange;
use super::pilot::{parse_percentage, parse_time};
use super::preview::{Preview, TEV, parse_address};
use super::{Job, defaults};
use crate::run::cli::{integer, number};

/// Render one image of a scene to an EXR file (linear radiance with its standard error) and a PNG.
///
/// Examples:
///   render                                           the report's room, physically consistent
///   render --convention report --out out/fig6.exr    the room as the report's text describes it
///   render --scene cornell --size 512x512 --spp 64   another scene, smaller and noisier
///   render --scene room.toml                         a scene file: the book's page Scene files
///
/// The same options give the same bytes, whatever the number of threads. An option that has no
/// effect together with the others is refused.
///
/// The image is saved in NAME.partial.exr every few seconds; --resume continues from there and ends
/// with the bytes of an uninterrupted run. A kill or a power cut costs at most 10 s of work, or the
/// current pass of bdpt, bdpt-ends, light-tracer and sppm. Photon maps, radiosity and the pilot of
/// --adaptive are computed anew, also by each shard. Without --resume a run starts from zero and
/// replaces the file. If saving fails, rendering continues, and saving is tried again. With --shard
/// several machines share the work; the program merge joins the parts.
///
/// Ctrl-C, SIGTERM and SIGHUP save the samples done so far, and an image in NAME.partial.png; a
/// second Ctrl-C saves nothing. Exit codes: 0 if all is done, 2 for a wrong option or a file that
/// cannot be written, 130 after Ctrl-C, 143 after SIGTERM, 129 after SIGHUP.
#[derive(Parser)]
#[command(
    name = "render",
    version,
    verbatim_doc_comment,
    mut_args(defaults::in_help)
)]
pub struct Render {
    #[command(flatten)]
    /// The image to render.
    pub job: Job,
    /// True if `--adaptive` is not given, so that the number of samples decides.
    #[arg(skip)]
    adaptive_unset: bool,
    /// Threads; from 1 to 1024 [default: one per core]
    #[arg(long, allow_hyphen_values = true, value_parser = integer::<usize>(1..=1024))]
    pub threads: Option<usize>,
    /// Exposure of the PNG in stops, under --convention physical; from -100 to 100
    #[arg(long, default_value_t = 0.0, allow_hyphen_values = true, value_parser = number(-100.0..=100.0))]
    pub exposure: f64,
    /// Take as many samples as fit in this time, such as 90s, 10m or 1.5h. A pilot run, whose
    /// samples are thrown away, decides the number; the image is that of --spp with the printed
    /// number; from 1s to 10000h
    #[arg(long, value_name = "TIME", conflicts_with_all = ["spp", "target_error", "shard"], allow_hyphen_values = true, value_parser = parse_time)]
    pub time: Option<Duration>,
    /// Take as many samples as should leave the pixels this mean relative standard error, such as
    /// 1%; a pilot run decides, as for --time; from 0.0001% to 100%
    #[arg(long, value_name = "PERCENT", conflicts_with_all = ["spp", "shard"], allow_hyphen_values = true, value_parser = parse_percentage)]
    pub target_error: Option<f64>,
    /// Continue from NAME.partial.exr if it exists
    #[arg(long)]
    pub resume: bool,
    /// Render part i of n of the samples to a file of sums, which the program merge joins with the
    /// others
    #[arg(long, value_name = "i/n", allow_hyphen_values = true, value_parser = Shard::from_str)]
    pub shard: Option<Shard>,
    /// Write the unfinished image to this PNG about every second
    #[arg(long, value_name = "FILE.png")]
    pub preview: Option<PathBuf>,
    /// Show the unfinished image in the viewer tev, which listens at 127.0.0.1:14158 unless another
    /// address is given
    #[arg(long, value_name = "HOST:PORT", num_args = 0..=1, default_missing_value = TEV, value_parser = parse_address)]
    pub tev: Option<String>,
    /// The EXR file; the PNG has the same name
    #[arg(long, default_value = "out/render.exr")]
    pub out: PathBuf,
}

/// Returns whether the command line gives an option.
pub(super) fn given(matches: &ArgMatches, id: &str) -> bool {
    matches.value_source(id) == Some(ValueSource::CommandLine)
}

impl Render {
    /// Reads the options of a command line and fills in the defaults that depend on other options.
    pub fn from_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut render = Self::from_arg_matches(matches)?;
        defaults::apply(&mut render.job, |option| given(matches, option));
        render.adaptive_unset = !given(matches, "adaptive");
        if render.time.is_some() || render.target_error.is_some() {
            // Placeholder until the pilot decides.
            render.job.spp = render.job.round_to_valid(1.0, f64::ceil);
        }
        Ok(render)
    }

    /// Sets the number of samples, and the options that depend on it.
    pub fn set_spp(&mut self, spp: u32) {
        self.job.spp = spp;
        if self.adaptive_unset {
            self.job.adaptive = defaults::adaptive(&self.job);
        }
    }

    /// Returns the replications that this run renders.
    pub fn replication_range(&self) -> Result<ReplicationRange, Error> {
        let total = self.job.all_replications();
        let Shard { index, count } = self.shard.unwrap_or(Shard::WHOLE);
        if count > total {
            return Err(Error::Option(format!(
                "--shard {index}/{count}: the samples of a pixel are {total} independent parts: use at most that many shards, \
                 or more samples or --scrambles"
            )));
        }
        let until = |index: u32| (u64::from(total) * u64::from(index) / u64::from(count)) as u32;
        Ok(ReplicationRange {
            range: until(index - 1)..until(index),
            total,
        })
    }

    /// Returns the previews that show the image while it is made.
    pub fn previews(&self) -> Result<Vec<Preview>, Error> {
        let (size, display) = (self.job.size, self.job.display(self.exposure));
        let tev = self
            .tev
            .as_deref()
            .map(|address| Preview::tev(address, &self.out.display().to_string(), size));
        let png = self
            .preview
            .clone()
            .map(|path| Ok(Preview::png(path, size, display)));
        tev.into_iter().chain(png).collect()
    }
}
