//! A run of an experiment: its options and output folder, and the numbers, figures and findings it
//! records.

pub mod accumulated;
pub mod cli;
pub mod default_run;
pub mod part_cache;
pub mod pictures;
mod processor;
pub mod progress;
pub mod record;
pub mod signals;
pub mod split_png;
pub mod suite;
pub mod summary;

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
pub use records::results::{ExperimentResult, Finding, Judgement};
use serde::Serialize;
use serde::de::DeserializeOwned;
use whitefurnace::equation::{self, Equation};
use whitefurnace::error::Error;
use whitefurnace::film::Film;
use whitefurnace::harness::trial::Trial;
use whitefurnace::image::{write_atomically, write_exr, write_png};

use crate::print_line;
use crate::render::{Job, name};
use crate::run::accumulated::Accumulated;
use crate::run::cli::integer;
use crate::run::part_cache::PartCache;
use crate::run::record::PROGRAM;

/// Amount of work of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Tier {
    /// Smaller pictures, fewer samples
    Quick,
    /// The report's sizes and sample counts
    Full,
}

/// Options that all experiments share.
#[derive(Clone, Debug, Args)]
pub struct Options {
    /// How much work to do
    #[arg(long, value_enum, default_value_t = Tier::Quick)]
    pub tier: Tier,
    /// Folder for all files
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
    /// Seed of all random numbers; from 0 to 18446744073709551615
    #[arg(long, default_value_t = 1, allow_hyphen_values = true, value_parser = integer::<u64>(0..=u64::MAX))]
    pub seed: u64,
    /// Threads; from 1 to 1024 [default: one per core]
    #[arg(long, allow_hyphen_values = true, value_parser = integer::<usize>(1..=1024))]
    pub threads: Option<usize>,
    /// Divide the pixels of every picture and all counts by this, from 1 to 4096, for a trial run;
    /// nothing is judged then
    #[arg(long, default_value_t = 1, allow_hyphen_values = true, value_parser = integer::<u32>(1..=4096))]
    pub shrink: u32,
    /// Show every line of the tables, not only the summary
    #[arg(long)]
    pub rows: bool,
}

/// An experiment: constant data and one function.
#[derive(Clone, Copy)]
pub struct Experiment {
    /// Name on the command line, and of the folder and binary.
    pub id: &'static str,
    /// Task or question, in one line.
    pub title: &'static str,
    /// Finding, in one line: `{KEY FORMAT}` stands for a number of the run in a format of
    /// [`records::number::format`], `{holds}`, `{fails}` and `{undecided}` for its counts of
    /// claims.
    pub headline: &'static str,
    /// Version, raised when numbers or figures change on purpose.
    pub version: u32,
    /// Equations that the experiment bears on; experiments that loop over the registry of trials
    /// add theirs by [`Run::add_equations_of`].
    pub equations: &'static [&'static Equation],
    /// Does the work.
    pub run: fn(&mut Run) -> Result<(), Error>,
}

/// One run of an experiment: its options and what it records.
pub struct Run {
    options: Options,
    folder: PathBuf,
    parts: PartCache,
    result: ExperimentResult,
}

impl Run {
    /// Begins a run, or continues one that was interrupted.
    pub(crate) fn new(
        experiment: &Experiment,
        options: &Options,
        folder: PathBuf,
        fingerprint: String,
    ) -> Result<Self, Error> {
        let (id, tier, seed) = (experiment.id, name(options.tier), options.seed);
        let divided = match options.shrink {
            1 => String::new(),
            shrink => format!(" --shrink {shrink}"),
        };
        Ok(Self {
            parts: PartCache::begin(folder.join("unfinished"), &fingerprint)?,
            options: options.clone(),
            result: ExperimentResult {
                id: id.to_owned(),
                title: experiment.title.to_owned(),
                version: experiment.version,
                command: format!(
                    "cargo run --release --bin {id} -- --tier {tier} --seed {seed}{divided}"
                ),
                tier,
                seed,
                shrink: options.shrink,
                equations: experiment
                    .equations
                    .iter()
                    .map(|equation| equation.id.to_owned())
                    .collect(),
                fingerprint,
                ..ExperimentResult::default()
            },
            folder,
        })
    }

    /// Returns a part of the work; a part that an interrupted run has finished is not repeated
    /// ([`PartCache::part`]).
    pub fn part<T: Serialize + DeserializeOwned>(
        &self,
        key: &str,
        make: impl FnOnce() -> Result<T, Error>,
    ) -> Result<T, Error> {
        self.parts.part(key, make)
    }

    /// Returns parts that several experiments use, in the folder `name` beside theirs: each is made
    /// once, by the first that asks. `key` states all that decides them besides the program.
    pub fn shared(&self, name: &str, key: &str) -> Result<PartCache, Error> {
        PartCache::begin(
            self.folder.with_file_name(name),
            &format!("{:016x} {key}", *PROGRAM),
        )
    }

    /// Returns the accumulated rows of `file` as earlier runs left them. A run writes them once,
    /// when all of its own are there.
    pub fn accumulated(&self, file: &str, key: &str, columns: &str) -> Result<Accumulated, Error> {
        let path = self.folder.join(file);
        Ok(Accumulated::continued(
            &self.parts.before(&path)?,
            path,
            key,
            columns,
        ))
    }

    /// Returns the tier.
    pub fn tier(&self) -> Tier {
        self.options.tier
    }

    /// Returns `quick` or `full` by the tier.
    pub fn by_tier<T>(&self, quick: T, full: T) -> T {
        match self.options.tier {
            Tier::Quick => quick,
            Tier::Full => full,
        }
    }

    /// Returns a count, divided as the options ask; at least 1.
    pub fn count(&self, count: u64) -> u64 {
        (count / u64::from(self.options.shrink)).max(1)
    }

    /// Returns the scale of the trials' sample sizes: `scale`, divided as the options ask, and at
    /// least 1/1024, below which some statistics are undefined.
    pub fn scale(&self, scale: f64) -> f64 {
        (scale / f64::from(self.options.shrink)).max(1.0 / 1024.0)
    }

    /// Adds the equations that trials bear on.
    pub fn add_equations_of(&mut self, trials: &[Trial]) {
        for equation in trials
            .iter()
            .filter_map(|trial| equation::by_id(trial.source))
        {
            if !self.result.equations.iter().any(|id| id == equation.id) {
                self.result.equations.push(equation.id.to_owned());
            }
        }
    }

    /// Returns the master seed.
    pub fn seed(&self) -> u64 {
        self.options.seed
    }

    /// Returns the job with the run's seed and, where asked for, fewer pixels or samples.
    pub fn with_run_options(&self, job: Job) -> Job {
        let shrink = self.options.shrink;
        let mut job = Job {
            seed: self.options.seed,
            ..job
        };
        if job.window.is_some() {
            // A window lies at fixed coordinates of the full frame.
            job.spp = (job.spp / shrink).max(2);
        } else {
            let side = f64::from(shrink).sqrt();
            job.size = job.size.map(|n| ((f64::from(n) / side) as u32).max(1));
        }
        job
    }

    /// Renders a job.
    pub fn render(&self, job: &Job, label: &str) -> Result<Film, Error> {
        // The experiment is already named.
        job.render(if label == self.result.id { "" } else { label })?
            .into_complete()
    }

    /// Renders a job and writes it as `stem.exr` and `stem.png`.
    pub fn picture(&mut self, job: Job, stem: &str) -> Result<(), Error> {
        let job = self.with_run_options(job);
        let film = self.render(&job, stem)?;
        let (exr, camera) = (self.folder.join(format!("{stem}.exr")), job.camera()?);
        write_exr(&exr, &film, &camera, &job.provenance(&camera, true))?;
        let file = format!("{stem}.png");
        let magnification = if job.window.is_some() {
            CROP_MAGNIFICATION
        } else {
            1
        };
        write_png(&self.figure(&file), &film, job.display(0.0), magnification)?;
        let ([width, height], mean, error) = (film.size(), film.mean(), film.relative_error());
        self.numbers(stem, [("mean", mean), ("relative_error", error)]);
        let (convention, estimator, percent) =
            (name(job.convention), name(job.estimator), 100.0 * error);
        let value = format!(
            "{width}x{height}, {} spp, convention {convention}, estimator {estimator}, mean radiance {mean:.4}, \
             mean relative error {percent:.2} %",
            job.spp
        );
        self.note(&file, value);
        Ok(())
    }

    /// Registers a file as a figure of the result; returns its path.
    pub fn figure(&mut self, file: &str) -> PathBuf {
        self.result.figures.push(file.to_owned());
        self.folder.join(file)
    }

    /// Copies a picture to the folder of the whole run, where a newcomer looks first, and prints
    /// its path.
    pub fn copy_to_run_folder(&self, file: &str) -> Result<(), Error> {
        let to = self.folder.with_file_name(file);
        std::fs::copy(self.folder.join(file), &to).map_err(Error::file("write", &to))?;
        print_line!("the first picture: {}", to.display());
        Ok(())
    }

    /// Records a number. JSON has finite numbers only; others are left out. The book's directives
    /// end names at blanks, so blanks become hyphens, and a colon before one a dot.
    pub fn number(&mut self, key: &str, value: f64) {
        if value.is_finite() {
            self.result
                .numbers
                .insert(key.replace(": ", ".").replace(' ', "-"), value);
        }
    }

    /// Records numbers about one thing, each as `of.what`.
    pub fn numbers<'a>(&mut self, of: &str, numbers: impl IntoIterator<Item = (&'a str, f64)>) {
        for (what, value) in numbers {
            self.number(&format!("{of}.{what}"), value);
        }
    }

    /// Adds a line to the table.
    pub fn note(&mut self, what: &str, value: String) {
        self.finding(what, value, None, false);
    }

    /// Adds a line about a claim to the table: whether it holds, or a verdict. A shrunk run claims
    /// nothing, since claims state the sizes at which they can be judged.
    pub fn claim(&mut self, what: &str, value: String, verdict: impl Into<Judgement>) {
        self.finding(what, value, Some(verdict.into()), false);
    }

    /// Adds a claim as a detail of the last line that is no detail.
    pub fn detail(&mut self, what: &str, value: String, verdict: impl Into<Judgement>) {
        self.finding(what, value, Some(verdict.into()), true);
    }

    fn finding(&mut self, what: &str, value: String, verdict: Option<Judgement>, detail: bool) {
        let value = if value.contains("inf") || value.contains("NaN") {
            replace_non_finite(&value)
        } else {
            value
        };
        self.result.findings.push(Finding {
            what: what.to_owned(),
            value,
            verdict: verdict.filter(|_| self.options.shrink == 1),
            detail,
        });
    }

    /// Writes rows of text as a CSV file.
    pub fn csv(&self, file: &str, header: &str, rows: &[String]) -> Result<(), Error> {
        write_text(
            &self.folder.join(file),
            &format!("{header}\n{}\n", rows.join("\n")),
        )
    }
}

/// Returns the text with "unknown" in place of numbers that are infinite or NaN.
fn replace_non_finite(text: &str) -> String {
    let word = |part: &str| {
        let number = part.trim_matches(|c: char| !c.is_alphanumeric());
        match number {
            "inf" | "NaN" => part.replace(['+', '-', '−'], "").replace(number, "unknown"),
            _ => part.to_owned(),
        }
    };
    text.split(' ').map(word).collect::<Vec<_>>().join(" ")
}

/// Magnification of crops.
const CROP_MAGNIFICATION: u32 = 3;

/// Creates an empty folder, in place of an older one and its contents.
fn recreate_folder(folder: &Path) -> Result<(), Error> {
    if folder.exists() {
        std::fs::remove_dir_all(folder).map_err(Error::file("remove", folder))?;
    }
    std::fs::create_dir_all(folder).map_err(Error::file("create", folder))
}

/// Reads a value from a JSON file.
pub fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T, Error> {
    let text = std::fs::read_to_string(path).map_err(Error::file("read", path))?;
    serde_json::from_str(&text)
        .map_err(|error| Error::Option(format!("{}: {error}", path.display())))
}

/// Writes a text file atomically: whole or not at all.
pub fn write_text(path: &Path, text: &str) -> Result<(), Error> {
    use std::io::Write as _;
    write_atomically(path, |file| {
        file.write_all(text.as_bytes())
            .map_err(Error::file("write", path))
    })
}
