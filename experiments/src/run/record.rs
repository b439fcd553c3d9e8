//! Runs experiments, keeps their results, and copies those of a full run into the book.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::time::Instant;

use records::readme::with_numbers;
use serde::Serialize;
use sha2::{Digest as _, Sha256};
use whitefurnace::error::Error;
use whitefurnace::image::check_writable;

use super::split_png;
use crate::experiments::EXPERIMENTS;
use crate::print_line;
use crate::render::name;
use crate::run::progress::{Bar, interrupted};
use crate::run::summary::summary;
use crate::run::{
    Experiment, ExperimentResult, Finding, Judgement, Options, Run, progress, read_json,
    recreate_folder, write_text,
};

/// Size of the largest file that the book keeps, in bytes.
pub const MAX_RECORDED_BYTES: u64 = 300 * 1024;

/// Outcomes of a run of experiments.
pub struct RunResults {
    /// Findings of each experiment.
    pub results: Vec<ExperimentResult>,
    /// Wall-clock seconds of each experiment; `None` if it was kept from an earlier run.
    pub seconds: Vec<Option<f64>>,
}

/// Runs experiments one after the other, as [`run_each`] does. After each, `results.json` is
/// written anew from all experiments that have a result in the folder, so that an error in a later
/// one loses none.
pub fn run_all(
    experiments: &[&Experiment],
    options: &Options,
    fresh: bool,
) -> Result<RunResults, Error> {
    let results = options.out.join(RESULTS);
    check_writable(&results)?;
    run_each(experiments, options, fresh, || {
        write_results(&results, options)
    })
}

/// Runs experiments one after the other, each in its own folder, and prints a line when one is
/// done. Results of an earlier run of the same program with the same options are kept unless
/// `fresh`.
pub fn run_each(
    experiments: &[&Experiment],
    options: &Options,
    fresh: bool,
    done: impl Fn() -> Result<(), Error>,
) -> Result<RunResults, Error> {
    let mut ran = RunResults {
        results: Vec::new(),
        seconds: Vec::new(),
    };
    for (i, experiment) in experiments.iter().enumerate() {
        let (Options { seed, shrink, .. }, tier) = (options, name(options.tier));
        let fingerprint = format!(
            "{:016x} {} {tier} {seed} {shrink}",
            *PROGRAM, experiment.version
        );
        let folder = options.out.join(experiment.id);
        let which = format!("[{} of {}] ", i + 1, experiments.len());
        let finished = if fresh {
            None
        } else {
            read_finished(&folder, &fingerprint)
        };
        let (result, seconds) = match finished {
            Some(result) => (result, None),
            None => {
                let start = Instant::now();
                let bar = Bar::new(&format!("{which}{}", experiment.id), 0, "");
                let result = run_one(experiment, options, &folder, fingerprint)?;
                drop(bar);
                (result, Some(start.elapsed().as_secs_f64()))
            }
        };
        let how = seconds.map_or("kept from an earlier run".to_owned(), |seconds| {
            format!("{seconds:.1} s")
        });
        print_line!(
            "{}",
            summary(
                experiment,
                &result,
                &format!("{which}{}, {how}", experiment.id),
                &options.out
            )
        );
        progress::postpone_output();
        // A single experiment prints its table.
        if options.rows || experiments.len() == 1 {
            print_line!("{}", table(&result, options.rows));
        }
        ran.results.push(result);
        ran.seconds.push(seconds);
        done()?;
    }
    Ok(ran)
}

/// File name of the results as JSON.
pub const RESULTS: &str = "results.json";

fn run_one(
    experiment: &Experiment,
    options: &Options,
    folder: &Path,
    fingerprint: String,
) -> Result<ExperimentResult, Error> {
    std::fs::create_dir_all(folder).map_err(Error::file("create", folder))?;
    let mut run = Run::new(experiment, options, folder.to_owned(), fingerprint)?;
    (experiment.run)(&mut run)?;
    if interrupted() {
        return Err(Error::Interrupted);
    }
    let Run {
        mut result, parts, ..
    } = run;
    result.digests = digests(folder)?;
    write_json(&folder.join("result.json"), &result)?;
    parts.end()?;
    Ok(result)
}

/// Returns the result in a folder if it has this fingerprint and its files are unchanged.
fn read_finished(folder: &Path, fingerprint: &str) -> Option<ExperimentResult> {
    let result = result(folder)?;
    let there = |file: &String| result.digests.contains_key(file);
    let whole = result.figures.iter().all(there) && digests(folder).ok()? == result.digests;
    (whole && result.fingerprint == fingerprint).then_some(result)
}

/// Returns the result in a folder, if there is one that can be read.
pub fn result(folder: &Path) -> Option<ExperimentResult> {
    read_json(&folder.join("result.json")).ok()
}

/// Returns the SHA-256 of each file of an experiment's folder except the result that lists them.
fn digests(folder: &Path) -> Result<BTreeMap<String, String>, Error> {
    let mut digests = BTreeMap::new();
    for entry in std::fs::read_dir(folder).map_err(Error::file("read", folder))? {
        let path = entry.map_err(Error::file("read", folder))?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if path.is_file() && name != "result.json" {
            let digest = Sha256::digest(&std::fs::read(&path).map_err(Error::file("read", &path))?);
            digests.insert(
                name.into_owned(),
                digest.iter().map(|byte| format!("{byte:02x}")).collect(),
            );
        }
    }
    Ok(digests)
}

/// Hash of the running program's file: any change of code makes earlier results stale.
pub static PROGRAM: LazyLock<u64> = LazyLock::new(|| {
    let mut hasher = DefaultHasher::new();
    std::env::current_exe()
        .and_then(std::fs::read)
        .unwrap_or_default()
        .hash(&mut hasher);
    hasher.finish()
});

#[derive(Serialize)]
struct Results<'a> {
    program: &'static str,
    version: &'static str,
    commit: &'static str,
    /// Tier of the last run; each experiment has its own.
    tier: String,
    seed: u64,
    shrink: u32,
    experiments: &'a [ExperimentResult],
}

/// Writes the results of all experiments in the folder.
fn write_results(path: &Path, options: &Options) -> Result<(), Error> {
    let found = EXPERIMENTS
        .iter()
        .filter_map(|experiment| result(&options.out.join(experiment.id)));
    let results: Vec<ExperimentResult> = found.collect();
    write_json(
        path,
        &Results {
            program: "whitefurnace",
            version: env!("CARGO_PKG_VERSION"),
            commit: env!("WHITEFURNACE_COMMIT"),
            tier: name(options.tier),
            seed: options.seed,
            shrink: options.shrink,
            experiments: &results,
        },
    )
}

/// Writes a value as JSON.
pub fn write_json<T: Serialize>(path: &Path, value: &T) -> Result<(), Error> {
    let text = serde_json::to_string_pretty(value).map_err(|error| Error::Image {
        action: "write",
        path: path.to_owned(),
        message: error.to_string(),
    })?;
    write_text(path, &(text + "\n"))
}

/// Length of the longest line of a table, in characters.
pub const MAX_LINE_LENGTH: usize = 160;

/// Formats an experiment's findings as text under its title, a line each; long values continue
/// below their beginning. Details are left out without `rows`, except those that fail.
pub fn table(result: &ExperimentResult, rows: bool) -> String {
    let mut text = format!("{}: {}", result.id, result.title);
    let shows = |row: &&Finding| rows || !row.detail || row.verdict == Some(Judgement::Fails);
    let shown: Vec<&Finding> = result.findings.iter().filter(shows).collect();
    let label = |row: &Finding| format!("{}{}", if row.detail { "  " } else { "" }, row.what);
    let width = shown
        .iter()
        .map(|row| label(row).chars().count())
        .max()
        .unwrap_or(0);
    for row in &shown {
        let verdict = row.verdict.map(|verdict| match verdict {
            // Upper case, to stand out among many lines.
            Judgement::Fails => "FAILS",
            other => other.word(),
        });
        let indent = width + 4;
        let mut column = indent;
        // Writing to a string cannot fail.
        let _ = write!(text, "\n  {:width$} ", label(row));
        for word in row.value.split(' ').chain(verdict) {
            let length = word.chars().count() + 1;
            if column + length > MAX_LINE_LENGTH && column > indent {
                let _ = write!(text, "\n{:1$}", "", indent - 1);
                column = indent;
            }
            let _ = write!(text, " {word}");
            column += length;
        }
    }
    let left_out = result.findings.len() - shown.len();
    if left_out > 0 {
        let _ = write!(text, "\n  and {left_out} more rows with --rows");
    }
    text
}

/// Returns the folder where the book keeps the results of the last full run.
pub fn recorded_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../book/recorded")
}

/// Copies an experiment's result and figures from `from` to `to` in place of older files; large
/// pictures in bands by [`split_png`]. Returns the plots that are too large and were left out.
pub fn record(from: &Path, to: &Path) -> Result<Vec<String>, Error> {
    let mut result: ExperimentResult = read_json(&from.join("result.json"))?;
    // They identify a build and files that are not all recorded, which means nothing to a reader.
    result.fingerprint.clear();
    result.digests.clear();
    recreate_folder(to)?;
    let mut too_large = Vec::new();
    for figure in std::mem::take(&mut result.figures) {
        let source = from.join(&figure);
        let size = std::fs::metadata(&source)
            .map_err(Error::file("read", &source))?
            .len();
        if size <= MAX_RECORDED_BYTES {
            std::fs::copy(&source, to.join(&figure)).map_err(Error::file("copy", &source))?;
        } else if source.extension().is_some_and(|e| e == "png") {
            split_png::split_png(&source, to, MAX_RECORDED_BYTES)?;
        } else {
            too_large.push(figure);
            continue;
        }
        result.figures.push(figure);
    }
    write_json(&to.join("result.json"), &result)?;
    Ok(too_large)
}

/// Records the results of these experiments in the book's folder and the README, and prints what
/// was left out.
pub fn update_book(experiments: &[&Experiment], options: &Options) -> Result<(), Error> {
    let folder = recorded_folder();
    for Experiment { id, .. } in experiments {
        for figure in record(&options.out.join(id), &folder.join(id))? {
            print_line!(
                "left out of the book: {id}/{figure}, larger than {} KiB",
                MAX_RECORDED_BYTES / 1024
            );
        }
    }
    update_readme()?;
    print_line!(
        "recorded {} experiments in {}",
        experiments.len(),
        folder.display()
    );
    Ok(())
}

/// Writes the recorded numbers into the README.
pub fn update_readme() -> Result<(), Error> {
    let folder = recorded_folder();
    let readme = folder.join("../../README.md");
    let text = std::fs::read_to_string(&readme).map_err(Error::file("read", &readme))?;
    let results = records::results::Results::load(&folder).map_err(|problems| {
        let lines: Vec<String> = problems.iter().map(ToString::to_string).collect();
        Error::Option(lines.join("\n"))
    })?;
    let text = with_numbers(&text, &results)
        .map_err(|why| Error::Option(format!("{}: {why}", readme.display())))?;
    write_text(&readme, &text)
}
