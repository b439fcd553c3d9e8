//! Runs experiments, keeps their results, and copies those of a full run into the book.

use std::fmt::Write as _;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::time::Instant;

use serde::Serialize;
use whitefurnace::error::Error;
use whitefurnace::image::check_writable;

use crate::bands;
use crate::job::name;
use crate::lab::{Experiment, Lab, Options, Outcome, Tier, write_text};
use crate::progress::interrupted;
use crate::say;

/// The largest file that the book keeps, in bytes.
pub const LARGEST_RECORDED: u64 = 300 * 1024;

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
                say!("{}", table(&outcome, "kept from an earlier run"));
                outcome
            }
            None => {
                let start = Instant::now();
                let outcome = run_one(experiment, options, &folder, fingerprint)?;
                say!(
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
    folder: &Path,
    fingerprint: String,
) -> Result<Outcome, Error> {
    std::fs::create_dir_all(folder).map_err(Error::file("create", folder))?;
    let mut lab = Lab::new(experiment, options, folder.to_owned(), fingerprint);
    (experiment.run)(&mut lab)?;
    if interrupted() {
        return Err(Error::Interrupted);
    }
    let outcome = lab.into_outcome();
    write_json(&folder.join("result.json"), &outcome)?;
    Ok(outcome)
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

/// Writes a value as JSON.
fn write_json<T: Serialize>(path: &Path, value: &T) -> Result<(), Error> {
    let text = serde_json::to_string_pretty(value).map_err(|error| Error::Image {
        action: "write",
        path: path.to_owned(),
        message: error.to_string(),
    })?;
    write_text(path, &(text + "\n"))
}

/// No line of a table is longer, in characters.
pub const LONGEST_LINE: usize = 160;

/// An experiment's findings as text, a line each; long values go on below their beginning.
pub fn table(outcome: &Outcome, how: &str) -> String {
    let mut text = format!("{}: {} ({how})", outcome.id, outcome.title);
    let width = outcome
        .findings
        .iter()
        .map(|row| row.what.chars().count())
        .max()
        .unwrap_or(0);
    for row in &outcome.findings {
        let verdict = match row.holds {
            None => None,
            Some(true) => Some(" holds"),
            Some(false) => Some(" FAILS"),
        };
        let indent = width + 4;
        let mut column = indent;
        // Writing to a string cannot fail.
        let _ = write!(text, "\n  {:width$} ", row.what);
        for word in row.value.split(' ').chain(verdict) {
            let length = word.chars().count() + 1;
            if column + length > LONGEST_LINE && column > indent {
                let _ = write!(text, "\n{:1$}", "", indent - 1);
                column = indent;
            }
            let _ = write!(text, " {word}");
            column += length;
        }
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
    say!(
        "\n{} experiments, {figures} figures, {holding} of {} claims hold; for machines: {}",
        outcomes.len(),
        verdicts.len(),
        results.display()
    );
}

/// Where the book keeps the results of the last full run.
pub fn recorded_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../book/recorded")
}

/// The recorded result of an experiment, if there is one that can be read.
pub fn recorded(folder: &Path, id: &str) -> Option<Outcome> {
    let text = std::fs::read_to_string(folder.join(id).join("result.json")).ok()?;
    serde_json::from_str(&text).ok()
}

/// Refuses to record anything but full runs.
///
/// # Errors
/// [`Error::Option`] with what to change.
pub fn check_recordable(options: &Options) -> Result<(), Error> {
    if options.tier == Tier::Full && options.shrink == 1 {
        return Ok(());
    }
    Err(Error::Option(
        "--update-book records full runs only: add --tier full and leave out --shrink".to_owned(),
    ))
}

/// Copies an experiment's result and figures from `from` to `to`, where older files go; large pictures
/// as [`bands`]. Returns the plots that are too large and were left out.
///
/// # Errors
/// A file cannot be read or written.
pub fn record(from: &Path, to: &Path) -> Result<Vec<String>, Error> {
    let file = from.join("result.json");
    let text = std::fs::read_to_string(&file).map_err(Error::file("read", &file))?;
    let mut outcome: Outcome = serde_json::from_str(&text)
        .map_err(|error| Error::Option(format!("{}: {error}", file.display())))?;
    // It names a build, which says nothing to a reader.
    outcome.fingerprint.clear();
    if to.exists() {
        std::fs::remove_dir_all(to).map_err(Error::file("remove", to))?;
    }
    std::fs::create_dir_all(to).map_err(Error::file("create", to))?;
    let mut too_large = Vec::new();
    for figure in std::mem::take(&mut outcome.figures) {
        let source = from.join(&figure);
        let size = std::fs::metadata(&source)
            .map_err(Error::file("read", &source))?
            .len();
        if size <= LARGEST_RECORDED {
            std::fs::copy(&source, to.join(&figure)).map_err(Error::file("copy", &source))?;
        } else if source.extension().is_some_and(|e| e == "png") {
            bands::split(&source, to, LARGEST_RECORDED)?;
        } else {
            too_large.push(figure);
            continue;
        }
        outcome.figures.push(figure);
    }
    write_json(&to.join("result.json"), &outcome)?;
    Ok(too_large)
}

/// Records the results of these experiments in the book's folder and says what was left out.
///
/// # Errors
/// As [`record`].
pub fn update_book(experiments: &[&Experiment], options: &Options) -> Result<(), Error> {
    let book = recorded_folder();
    for experiment in experiments {
        for figure in record(&options.out.join(experiment.id), &book.join(experiment.id))? {
            say!(
                "left out of the book: {}/{figure}, larger than {} KiB",
                experiment.id,
                LARGEST_RECORDED / 1024
            );
        }
    }
    say!(
        "recorded {} experiments in {}",
        experiments.len(),
        book.display()
    );
    Ok(())
}
