//! Reproduces the report and says what it found.

use experiments::print_line;
use std::process::ExitCode;
use std::str::FromStr as _;

use clap::Parser;
use experiments::experiments::suite_seeds::SHARED_BY;
use experiments::experiments::{EXPERIMENTS, NOT_BY_DEFAULT};
use experiments::run::cli::Ending;
use experiments::run::default_run::{self, RecordComparison};
use experiments::run::{self, Experiment, ExperimentResult, Tier};
use experiments::run::{cli, record};
use whitefurnace::error::Error;
use whitefurnace::shard::Shard;

/// Reproduce the report: render its figures, measure its claims, say what was found.
///
/// Takes about a minute on two cores. All files go to one folder, with results.json for other
/// programs. An interrupted run continues where it stopped. Experiments on the test suite itself
/// are left out unless --tier full or --only asks for them; --list shows which.
///
/// Exit codes: 0 if no claim fails, 1 if one does, 2 for a wrong option or a file that cannot be
/// written, 130 after Ctrl-C, 143 after SIGTERM, 129 after SIGHUP.
#[derive(Parser)]
#[command(name = "reproduce", version)]
struct Reproduce {
    #[command(flatten)]
    shared: run::Options,
    /// Run these experiments only, divided by commas; may be repeated
    #[arg(long, value_name = "ID", value_delimiter = ',')]
    only: Vec<String>,
    /// Run part i of n of them, in one folder --out with the others; then the same command without
    /// --shard joins them
    #[arg(long, value_name = "i/n", allow_hyphen_values = true, conflicts_with = "update_book", value_parser = Shard::from_str)]
    shard: Option<Shard>,
    /// List the experiments and end
    #[arg(long)]
    list: bool,
    /// Do everything again, even what an earlier run of this program has done; images and p-values
    /// that accumulate from run to run are added to those of earlier runs
    #[arg(long)]
    fresh: bool,
    /// Fail where a number differs from the record beyond the noise of both
    #[arg(long, conflicts_with_all = ["shard", "shrink", "only", "update_book"])]
    against_record: bool,
    /// Record the results and figures of a full run in book/recorded; of the default run its time
    /// (with --fresh) and numbers, which runs of other seeds add to
    #[arg(long)]
    update_book: bool,
}

fn main() -> ExitCode {
    cli::start(|| cli::exit(run(&cli::parse())))
}

fn run(options: &Reproduce) -> Result<Ending, Error> {
    let mut chosen = choose(options)?;
    if let Some(shard) = options.shard {
        chosen = share(&chosen, shard)?;
    }
    if options.list {
        for experiment in chosen {
            print_line!("{:16} {}", experiment.id, experiment.title);
        }
        return Ok(Ending::Done);
    }
    let is_default =
        options.only.is_empty() && options.shared.tier == Tier::Quick && options.shared.shrink == 1;
    if options.against_record && !is_default {
        return Err(Error::Option(
            "--against-record compares the default run: leave out --only and --tier".to_owned(),
        ));
    }
    let results = options.shared.out.join(record::RESULTS);
    if options.against_record && options.fresh && results.exists() {
        return Err(Error::Option(format!(
            "{} is of an earlier run, to whose images a fresh run adds: compare with the record from another --out, or \
             remove {}",
            results.display(),
            options.shared.out.display()
        )));
    }
    if options.update_book
        && !is_default
        && (options.shared.tier, options.shared.shrink) != (Tier::Full, 1)
    {
        let refusal = "--update-book records a full run or the default run: add --tier full, or leave out --only; no --shrink";
        return Err(Error::Option(refusal.to_owned()));
    }
    cli::use_threads(options.shared.threads)?;
    cli::begin();
    if let Some(Shard { index, count }) = options.shard {
        let results = record::run_each(&chosen, &options.shared, options.fresh, || Ok(()))?.results;
        print_line!(
            "\nshard {index}/{count} is done: when all are, the same command without --shard joins them"
        );
        return Ok(cli::print_verdicts(&results));
    }
    let ran = record::run_all(&chosen, &options.shared, options.fresh)?;
    if options.update_book && is_default {
        default_run::record(&ran, &options.shared)?;
    } else if options.update_book {
        record::update_book(&chosen, &options.shared)?;
    }
    let mut ending = cli::print_summary(&ran.results, &options.shared);
    if options.against_record && differs_from_record(&ran.results)? {
        ending = Ending::ClaimFails;
    }
    if options.only.is_empty() && options.shared.tier == Tier::Quick {
        print_line!("not in this run: {}", NOT_BY_DEFAULT.join(", "));
        print_line!(
            "(the test suite on trial, differences of variance, timings: --only ID, or --tier full for all)"
        );
    }
    if options.only.is_empty() {
        build_book(&options.shared)?;
    }
    Ok(ending)
}

/// Returns the experiments of this shard, dealt out in turn; experiments that write to the same
/// folder stay together.
fn share(chosen: &[&'static Experiment], shard: Shard) -> Result<Vec<&'static Experiment>, Error> {
    let name = |experiment: &Experiment| {
        if SHARED_BY.contains(&experiment.id) {
            SHARED_BY[0]
        } else {
            experiment.id
        }
    };
    let mut names: Vec<&str> = chosen.iter().map(|experiment| name(experiment)).collect();
    names.sort_by_key(|name| {
        EXPERIMENTS
            .iter()
            .position(|experiment| experiment.id == *name)
    });
    names.dedup();
    if shard.count as usize > names.len() {
        let (Shard { index, count }, parts) = (shard, names.len());
        let refusal = format!(
            "--shard {index}/{count}: the experiments are {parts} parts: use at most that many shards"
        );
        return Err(Error::Option(refusal));
    }
    let number =
        |experiment: &&Experiment| names.iter().position(|other| *other == name(experiment));
    Ok(chosen
        .iter()
        .copied()
        .filter(|experiment| number(experiment).is_some_and(|at| shard.contains(at)))
        .collect())
}

/// Prints the numbers that differ from the record beyond noise; returns true if there are any.
fn differs_from_record(results: &[ExperimentResult]) -> Result<bool, Error> {
    let RecordComparison { compared, beyond } = default_run::compare_with_record(results)?;
    beyond
        .iter()
        .for_each(|line| print_line!("DIFFERS FROM THE RECORD: {line}"));
    print_line!(
        "{} of {compared} numbers differ from the record beyond noise",
        beyond.len()
    );
    Ok(!beyond.is_empty())
}

/// Weaves the book from the recorded results, with a page that compares this run with them, and
/// prints where it begins.
fn build_book(options: &run::Options) -> Result<(), Error> {
    let book = book::Options {
        out: options.out.join("book"),
        run: Some(options.out.clone()),
        ..book::Options::default()
    };
    let page = book::build(&book).map_err(|error| Error::Option(error.to_string()))?;
    print_line!(
        "the book begins at {}; your run beside the record: {}",
        page.display(),
        page.with_file_name(book::run::PAGE).display()
    );
    Ok(())
}

/// Returns the named experiments, each once; by default all, at the quick tier except
/// [`NOT_BY_DEFAULT`].
fn choose(options: &Reproduce) -> Result<Vec<&'static Experiment>, Error> {
    if options.only.is_empty() {
        let all = options.list || options.shared.tier == Tier::Full;
        let chosen = EXPERIMENTS
            .iter()
            .filter(|experiment| all || !NOT_BY_DEFAULT.contains(&experiment.id));
        return Ok(chosen.copied().collect());
    }
    let mut chosen: Vec<&Experiment> = Vec::new();
    for id in &options.only {
        let experiment = cli::find_experiment(id)?;
        if chosen.iter().all(|other| other.id != experiment.id) {
            chosen.push(experiment);
        }
    }
    Ok(chosen)
}
