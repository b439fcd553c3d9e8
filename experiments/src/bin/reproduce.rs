//! The main job: reproduces the report and says what it found.

use experiments::say;
use std::process::ExitCode;

use clap::Parser;
use experiments::experiments::EXPERIMENTS;
use experiments::run::cli::Ending;
use experiments::run::{self, Experiment, Tier};
use experiments::run::{cli, record};
use whitefurnace::error::Error;

/// Reproduce the report: render its figures, measure its claims, print a table of what was found.
///
/// Everything goes to one folder, with results.json for machines. A run that was interrupted goes on
/// where it stopped.
///
/// Exit codes: 0 if no claim fails, 1 if one does, 2 for a wrong option or a file that cannot be written,
/// 130 after Ctrl-C, 143 after SIGTERM, 129 after SIGHUP.
#[derive(Parser)]
#[command(name = "reproduce", version)]
struct Reproduce {
    #[command(flatten)]
    shared: run::Options,
    /// Run this experiment only; may be repeated
    #[arg(long, value_name = "ID")]
    only: Vec<String>,
    /// List the experiments and end
    #[arg(long)]
    list: bool,
    /// Do everything again, even what an earlier run of this program has done
    #[arg(long)]
    fresh: bool,
    /// Record the results and figures of a full run in book/recorded
    #[arg(long)]
    update_book: bool,
}

fn main() -> ExitCode {
    cli::start(|| cli::exit(run(&cli::parse())))
}

fn run(options: &Reproduce) -> Result<Ending, Error> {
    if options.list {
        for experiment in EXPERIMENTS {
            say!("{:12} {}", experiment.id, experiment.title);
        }
        return Ok(Ending::Done);
    }
    let chosen = choose(&options.only)?;
    if options.update_book && (options.shared.tier, options.shared.shrink) != (Tier::Full, 1) {
        let refusal = "--update-book records full runs only: add --tier full and leave out --shrink";
        return Err(Error::Option(refusal.to_owned()));
    }
    cli::use_threads(options.shared.threads)?;
    cli::begin();
    let outcomes = record::run_all(&chosen, &options.shared, options.fresh)?;
    if options.update_book {
        record::update_book(&chosen, &options.shared)?;
    }
    let ending = cli::conclude(&outcomes, &options.shared);
    if options.only.is_empty() {
        weave_book(&options.shared)?;
    }
    Ok(ending)
}

/// Weaves the book from the recorded results, with a page that sets this run beside them, and says where it
/// begins.
fn weave_book(options: &run::Options) -> Result<(), Error> {
    let book =
        book::Options { out: options.out.join("book"), run: Some(options.out.clone()), ..book::Options::default() };
    let page = book::weave(&book).map_err(|error| Error::Option(error.to_string()))?;
    say!(
        "the book begins at {}; your run beside the record: {}",
        page.display(),
        page.with_file_name(book::run::PAGE).display()
    );
    Ok(())
}

/// All experiments, or those that are named: each once.
fn choose(only: &[String]) -> Result<Vec<&'static Experiment>, Error> {
    if only.is_empty() {
        return Ok(EXPERIMENTS.to_vec());
    }
    let mut chosen: Vec<&Experiment> = Vec::new();
    for id in only {
        let experiment = cli::find(id)?;
        if chosen.iter().all(|other| other.id != experiment.id) {
            chosen.push(experiment);
        }
    }
    Ok(chosen)
}
