//! The frame that every experiment hangs into: options, output folder, results, the table.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};
use whitefurnace::equation::Equation;
use whitefurnace::error::Error;
use whitefurnace::film::Film;
use whitefurnace::image::{check_writable, write_exr, write_png, write_whole};

use crate::job::{Job, Rendered, name};
use crate::progress::{Progress, interrupted};

/// How much work a run does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Tier {
    /// About three minutes in all on two cores: smaller pictures, fewer samples
    Quick,
    /// The report's sizes and sample counts
    Full,
}

/// The options that all experiments share.
#[derive(Clone, Debug, Args)]
pub struct Options {
    /// How much work to do
    #[arg(long, value_enum, default_value_t = Tier::Quick)]
    pub tier: Tier,
    /// Folder for everything that is made
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 1, allow_negative_numbers = true)]
    pub seed: u64,
    /// Threads [default: one per core]
    #[arg(long)]
    pub threads: Option<usize>,
    /// Divide the number of pixels of every picture and all counts by this, for a trial run
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub shrink: u32,
}

/// An experiment: a constant of data and one function.
#[derive(Clone, Copy)]
pub struct Experiment {
    /// Its name on the command line, its folder and its binary.
    pub id: &'static str,
    /// What it makes or asks, in a line.
    pub title: &'static str,
    /// Raised when its numbers or figures change on purpose.
    pub version: u32,
    /// The equations that it bears on.
    pub equations: &'static [&'static Equation],
    /// Does the work.
    pub run: fn(&mut Lab) -> Result<(), Error>,
}

/// One line of an experiment's table.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Finding {
    /// What was measured.
    pub what: String,
    /// The number with its unit and error.
    pub value: String,
    /// Whether a claim about it holds; `None` where nothing is claimed.
    pub holds: Option<bool>,
}

/// What an experiment leaves behind, on disk as `result.json`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Outcome {
    /// The experiment.
    pub id: String,
    /// Its title.
    pub title: String,
    /// Its declared version.
    pub version: u32,
    /// The tier of the run.
    pub tier: Tier,
    /// The master seed.
    pub seed: u64,
    /// The command that repeats it.
    pub command: String,
    /// Ids of the equations that it bears on.
    pub equations: Vec<String>,
    /// Every number, by name.
    pub numbers: BTreeMap<String, f64>,
    /// Files for a person, in the experiment's folder.
    pub figures: Vec<String>,
    /// The table.
    pub findings: Vec<Finding>,
    /// Identifies program and options, so that only results of this very program are kept.
    pub fingerprint: String,
}

/// What an experiment works with.
pub struct Lab {
    options: Options,
    folder: PathBuf,
    outcome: Outcome,
}

impl Lab {
    /// The tier.
    pub fn tier(&self) -> Tier {
        self.options.tier
    }

    /// `quick` or `full` by the tier.
    pub fn by_tier<T>(&self, quick: T, full: T) -> T {
        match self.options.tier {
            Tier::Quick => quick,
            Tier::Full => full,
        }
    }

    /// A count, divided as the options ask; at least 1.
    pub fn count(&self, count: u64) -> u64 {
        (count / u64::from(self.options.shrink)).max(1)
    }

    /// The master seed.
    pub fn seed(&self) -> u64 {
        self.options.seed
    }

    /// The job with the run's seed and, where asked for, fewer pixels or samples.
    pub fn prepared(&self, job: Job) -> Job {
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
    ///
    /// # Errors
    /// What [`Job::render`] refuses; [`Error::Interrupted`] after Ctrl-C.
    pub fn render(&self, job: &Job, label: &str) -> Result<Film, Error> {
        let progress = Progress::new(&format!("{} {label}", self.outcome.id));
        let Rendered { film, complete } = job.render(&progress)?;
        if complete {
            Ok(film)
        } else {
            Err(Error::Interrupted)
        }
    }

    /// Renders a job and writes it as `stem.exr` and `stem.png`.
    ///
    /// # Errors
    /// As [`render`](Self::render), or the files cannot be written.
    pub fn picture(&mut self, job: Job, stem: &str) -> Result<Film, Error> {
        let job = self.prepared(job);
        let film = self.render(&job, stem)?;
        write_exr(
            &self.folder.join(format!("{stem}.exr")),
            &film,
            &job.provenance(true),
        )?;
        let png = self.figure(&format!("{stem}.png"));
        let magnification = if job.window.is_some() {
            CROP_MAGNIFICATION
        } else {
            1
        };
        write_png(&png, &film, job.display(0.0), magnification)?;
        let [width, height] = film.size();
        self.number(&format!("{stem}.mean"), film.mean());
        self.number(&format!("{stem}.relative_error"), film.relative_error());
        self.note(
            &format!("{stem}.png"),
            format!(
                "{width}x{height}, {} spp, {} {}, mean radiance {:.4}, mean relative error {:.2} %",
                job.spp,
                name(job.convention),
                name(job.estimator),
                film.mean(),
                100.0 * film.relative_error()
            ),
        );
        Ok(film)
    }

    /// Registers a file for a person; returns its path.
    pub fn figure(&mut self, file: &str) -> PathBuf {
        self.outcome.figures.push(file.to_owned());
        self.folder.join(file)
    }

    /// Records a number.
    pub fn number(&mut self, key: &str, value: f64) {
        self.outcome.numbers.insert(key.to_owned(), value);
    }

    /// Adds a line to the table.
    pub fn note(&mut self, what: &str, value: String) {
        self.finding(what, value, None);
    }

    /// Adds a line about a claim to the table.
    pub fn claim(&mut self, what: &str, value: String, holds: bool) {
        self.finding(what, value, Some(holds));
    }

    fn finding(&mut self, what: &str, value: String, holds: Option<bool>) {
        self.outcome.findings.push(Finding {
            what: what.to_owned(),
            value,
            holds,
        });
    }

    /// Writes rows of text as a CSV file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn csv(&self, file: &str, header: &str, rows: &[String]) -> Result<(), Error> {
        write_text(
            &self.folder.join(file),
            &format!("{header}\n{}\n", rows.join("\n")),
        )
    }
}

/// Crops are shown this many times larger than their pixels.
const CROP_MAGNIFICATION: u32 = 3;

/// Runs experiments one after the other and writes `results.json`; results of an earlier run of this
/// very program with the same options are kept unless `fresh`.
///
/// # Errors
/// The first error of an experiment; results so far are kept.
pub fn run_all(experiments: &[&Experiment], options: &Options, fresh: bool) -> Result<(), Error> {
    let results = options.out.join("results.json");
    check_writable(&results)?;
    let program = fingerprint_of_program();
    let mut outcomes = Vec::new();
    for experiment in experiments {
        let fingerprint = format!(
            "{program:016x} {} {} {} {}",
            experiment.version,
            name(options.tier),
            options.seed,
            options.shrink
        );
        let folder = options.out.join(experiment.id);
        let kept = if fresh {
            None
        } else {
            kept(&folder, &fingerprint)
        };
        let outcome = match kept {
            Some(outcome) => {
                println!("{}", table(&outcome, "kept from an earlier run"));
                outcome
            }
            None => {
                let start = Instant::now();
                let outcome = run_one(experiment, options, folder, fingerprint)?;
                println!(
                    "{}",
                    table(&outcome, &format!("{:.1} s", start.elapsed().as_secs_f64()))
                );
                outcome
            }
        };
        outcomes.push(outcome);
    }
    write_results(&results, &outcomes, options)?;
    summary(&outcomes, &results);
    Ok(())
}

fn run_one(
    experiment: &Experiment,
    options: &Options,
    folder: PathBuf,
    fingerprint: String,
) -> Result<Outcome, Error> {
    std::fs::create_dir_all(&folder).map_err(Error::file("create", &folder))?;
    let mut lab = Lab {
        options: options.clone(),
        outcome: Outcome {
            id: experiment.id.to_owned(),
            title: experiment.title.to_owned(),
            version: experiment.version,
            tier: options.tier,
            seed: options.seed,
            command: format!(
                "cargo run --release --bin {} -- --tier {} --seed {}",
                experiment.id,
                name(options.tier),
                options.seed
            ),
            equations: experiment
                .equations
                .iter()
                .map(|equation| equation.id.to_owned())
                .collect(),
            numbers: BTreeMap::new(),
            figures: Vec::new(),
            findings: Vec::new(),
            fingerprint,
        },
        folder,
    };
    (experiment.run)(&mut lab)?;
    if interrupted() {
        return Err(Error::Interrupted);
    }
    write_json(&lab.folder.join("result.json"), &lab.outcome)?;
    Ok(lab.outcome)
}

/// The result in a folder if it has this fingerprint and its figures are still there.
fn kept(folder: &Path, fingerprint: &str) -> Option<Outcome> {
    let text = std::fs::read_to_string(folder.join("result.json")).ok()?;
    let outcome: Outcome = serde_json::from_str(&text).ok()?;
    let there = outcome
        .figures
        .iter()
        .all(|figure| folder.join(figure).is_file());
    (there && outcome.fingerprint == fingerprint).then_some(outcome)
}

/// A hash of the running program's file: any change of code makes earlier results stale.
fn fingerprint_of_program() -> u64 {
    let mut hasher = DefaultHasher::new();
    let bytes = std::env::current_exe().and_then(std::fs::read);
    bytes.unwrap_or_default().hash(&mut hasher);
    hasher.finish()
}

#[derive(Serialize)]
struct Results<'a> {
    program: &'static str,
    version: &'static str,
    commit: &'static str,
    tier: Tier,
    seed: u64,
    experiments: &'a [Outcome],
}

fn write_results(path: &Path, outcomes: &[Outcome], options: &Options) -> Result<(), Error> {
    write_json(
        path,
        &Results {
            program: "whitefurnace",
            version: env!("CARGO_PKG_VERSION"),
            commit: env!("WHITEFURNACE_COMMIT"),
            tier: options.tier,
            seed: options.seed,
            experiments: outcomes,
        },
    )
}

fn write_json<T: Serialize>(path: &Path, value: &T) -> Result<(), Error> {
    let text = serde_json::to_string_pretty(value).map_err(|error| Error::Image {
        action: "write",
        path: path.to_owned(),
        message: error.to_string(),
    })?;
    write_text(path, &(text + "\n"))
}

/// Writes a text file whole or not at all.
///
/// # Errors
/// The file cannot be written.
pub fn write_text(path: &Path, text: &str) -> Result<(), Error> {
    use std::io::Write as _;
    write_whole(path, |file| {
        file.write_all(text.as_bytes())
            .map_err(Error::file("write", path))
    })
}

/// An experiment's findings as text.
fn table(outcome: &Outcome, how: &str) -> String {
    let mut text = format!("{}: {} ({how})", outcome.id, outcome.title);
    let width = outcome
        .findings
        .iter()
        .map(|row| row.what.chars().count())
        .max()
        .unwrap_or(0);
    for row in &outcome.findings {
        let verdict = match row.holds {
            None => "",
            Some(true) => "  holds",
            Some(false) => "  FAILS",
        };
        // Writing to a string cannot fail.
        let _ = write!(text, "\n  {:width$}  {}{verdict}", row.what, row.value);
    }
    text
}

fn summary(outcomes: &[Outcome], results: &Path) {
    let verdicts: Vec<bool> = outcomes
        .iter()
        .flat_map(|outcome| &outcome.findings)
        .filter_map(|row| row.holds)
        .collect();
    let holding = verdicts.iter().filter(|&&holds| holds).count();
    let figures: usize = outcomes.iter().map(|outcome| outcome.figures.len()).sum();
    println!(
        "\n{} experiments, {figures} figures, {holding} of {} claims hold; for machines: {}",
        outcomes.len(),
        verdicts.len(),
        results.display()
    );
}
