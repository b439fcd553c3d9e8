//! The main job: reproduces the report and says what it found.

use experiments::say;
use std::process::ExitCode;
use std::str::FromStr as _;

use clap::Parser;
use experiments::experiments::EXPERIMENTS;
use experiments::experiments::suite_seeds::TOGETHER;
use experiments::run::cli::Ending;
use experiments::run::{self, Experiment, Tier};
use experiments::run::{cli, record};
use whitefurnace::error::Error;
use whitefurnace::shard::Shard;

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
    /// Run part i of n of them, in one folder --out with the others; then the same command without --shard joins them
    #[arg(long, value_name = "i/n", allow_hyphen_values = true, conflicts_with = "update_book", value_parser = Shard::from_str)]
    shard: Option<Shard>,
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
    let mut chosen = choose(&options.only)?;
    if let Some(shard) = options.shard {
        chosen = share(&chosen, shard)?;
    }
    if options.list {
        for experiment in chosen {
            say!("{:12} {}", experiment.id, experiment.title);
        }
        return Ok(Ending::Done);
    }
    if options.update_book && (options.shared.tier, options.shared.shrink) != (Tier::Full, 1) {
        let refusal = "--update-book records full runs only: add --tier full and leave out --shrink";
        return Err(Error::Option(refusal.to_owned()));
    }
    cli::use_threads(options.shared.threads)?;
    cli::begin();
    if let Some(Shard { index, count }) = options.shard {
        let outcomes = record::run_each(&chosen, &options.shared, options.fresh, || Ok(()))?;
        say!("\nshard {index}/{count} is done: when all are, the same command without --shard joins them");
        let (text, none_fails) = record::verdicts(&outcomes);
        say!("{text}");
        return Ok(if none_fails { Ending::Done } else { Ending::ClaimFails });
    }
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

/// Those of this part: in turn, but experiments that write to the same folder go together.
fn share(chosen: &[&'static Experiment], shard: Shard) -> Result<Vec<&'static Experiment>, Error> {
    let name = |experiment: &Experiment| if TOGETHER.contains(&experiment.id) { TOGETHER[0] } else { experiment.id };
    let mut names: Vec<&str> = chosen.iter().map(|experiment| name(experiment)).collect();
    names.sort_by_key(|name| EXPERIMENTS.iter().position(|experiment| experiment.id == *name));
    names.dedup();
    if shard.count as usize > names.len() {
        let (Shard { index, count }, parts) = (shard, names.len());
        let refusal =
            format!("--shard {index}/{count}: the experiments are {parts} parts: take as many shards at most");
        return Err(Error::Option(refusal));
    }
    let number = |experiment: &&Experiment| names.iter().position(|other| *other == name(experiment));
    Ok(chosen.iter().copied().filter(|experiment| number(experiment).is_some_and(|at| shard.has(at))).collect())
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
