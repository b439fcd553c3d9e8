//! Records the results of cargo-mutants in the book's folder.

use experiments::print_line;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use experiments::run::cli::{self, Ending};
use experiments::run::read_json;
use experiments::run::record;
use records::mutants::{Counts, FILE, Record};
use serde::Deserialize;
use whitefurnace::error::Error;

/// Record the results of cargo-mutants, file by file: later outcomes of a mutant replace earlier
/// ones.
#[derive(Parser)]
#[command(name = "record-mutants", version)]
struct RecordMutants {
    /// `outcomes.json` of one or more runs; every source file in them must be complete
    #[arg(value_name = "OUTCOMES.json", required = true)]
    outcomes: Vec<PathBuf>,
    /// The folder of recorded results [default: the book's]
    #[arg(long, value_name = "DIR")]
    folder: Option<PathBuf>,
}

/// The part of `outcomes.json` that is used.
#[derive(Deserialize)]
struct Run {
    cargo_mutants_version: String,
    outcomes: Vec<Outcome>,
}

#[derive(Deserialize)]
struct Outcome {
    scenario: Scenario,
    summary: String,
}

#[derive(Deserialize)]
enum Scenario {
    Baseline,
    Mutant { name: String, file: String },
}

fn main() -> ExitCode {
    cli::start(|| cli::exit(run(&cli::parse())))
}

fn run(options: &RecordMutants) -> Result<Ending, Error> {
    let folder = options
        .folder
        .clone()
        .unwrap_or_else(record::recorded_folder);
    let mut known = if folder.join(FILE).exists() {
        Record::read(&folder).map_err(Error::Option)?
    } else {
        Record::default()
    };
    // By file and name. Names sort by line only among numbers with equally many digits, so the
    // order is kept separately.
    let mut found: BTreeMap<String, Vec<(String, String)>> = BTreeMap::new();
    for path in &options.outcomes {
        let run: Run = read_json(path)?;
        known.tool = format!("cargo-mutants {}", run.cargo_mutants_version);
        for Outcome { scenario, summary } in run.outcomes {
            let Scenario::Mutant { name, file } = scenario else {
                continue;
            };
            let mutants = found.entry(file).or_default();
            match mutants.iter_mut().find(|(known, _)| *known == name) {
                Some((_, known)) => *known = summary,
                None => mutants.push((name, summary)),
            }
        }
    }
    for (file, mutants) in &found {
        let (counts, missed) = count(mutants)?;
        known.replace(file, counts, &missed);
    }
    record::write_json(&folder.join(FILE), &known)?;
    report(&known, &folder);
    Ok(Ending::Done)
}

/// Counts the mutants by outcome, and lists those that survive.
fn count(mutants: &[(String, String)]) -> Result<(Counts, Vec<String>), Error> {
    let mut counts = Counts::default();
    let mut missed = Vec::new();
    for (name, summary) in mutants {
        match summary.as_str() {
            "CaughtMutant" => counts.caught += 1,
            "Timeout" => counts.timeout += 1,
            "Unviable" => counts.unviable += 1,
            "MissedMutant" => {
                counts.missed += 1;
                missed.push(name.clone());
            }
            other => {
                return Err(Error::Option(format!(
                    "{name} ended with {other}: run it again"
                )));
            }
        }
    }
    Ok((counts, missed))
}

fn report(known: &Record, folder: &Path) {
    for (file, counts) in &known.files {
        print_line!("{file}: {} of {} killed", counts.killed(), counts.viable());
    }
    let total = known.total();
    print_line!("all: {} of {} killed", total.killed(), total.viable());
    for survivor in known.survivors.iter().filter(|s| s.reason.is_empty()) {
        print_line!("no reason yet: {}", survivor.mutant);
    }
    print_line!("{}", folder.join(FILE).display());
}
