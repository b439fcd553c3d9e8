//! Common parts of the programs' command lines.

use std::hint::black_box;
use std::ops::RangeInclusive;
use std::path::Path;
use std::process::ExitCode;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Args, FromArgMatches, Parser};
use whitefurnace::error::Error;
use whitefurnace::film::MAX_FILM_PIXELS;
use whitefurnace::suggest::did_you_mean;

use super::{processor, progress, record, signals, summary};
use crate::experiments::EXPERIMENTS;
use crate::run::{self, Experiment, ExperimentResult};

/// Prints a line. A closed pipe (`reproduce | head`) does not stop the program.
#[macro_export]
macro_rules! print_line {
    ($($words:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stdout(), $($words)*);
    }};
}

/// Runs the work of a program, unless this processor lacks a feature that the program is built for:
/// then exit code 2 after one line.
///
/// Nothing else may stand in `main`, since it could use an instruction that the processor lacks.
pub fn start(work: fn() -> ExitCode) -> ExitCode {
    if let Some(missing) = processor::missing_feature() {
        eprintln!(
            "error: this program is built for a processor with {missing}, which this one lacks: build it on this machine, \
             or for any with RUSTFLAGS=\"\""
        );
        return ExitCode::from(2);
    }
    // Hidden, so that it is not inlined into the check above.
    black_box(work)()
}

/// Returns the exit code of a program: 0; 1 if a claim fails; 2 after one line on standard error;
/// or that of the signal that ended the work ([`signals::exit_code`]).
pub fn exit(result: Result<Ending, Error>) -> ExitCode {
    let code = match result {
        Ok(Ending::Done) => 0,
        Ok(Ending::ClaimFails) => 1,
        Ok(Ending::Interrupted) => signals::exit_code().unwrap_or(2),
        Err(error) => {
            eprintln!("error: {error}");
            signals::exit_code()
                .filter(|_| matches!(error, Error::Interrupted))
                .unwrap_or(2)
        }
    };
    ExitCode::from(code)
}

/// Ending of a program's work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// All work is done.
    Done,
    /// All work is done, and a claim does not hold.
    ClaimFails,
    /// A signal came, and the results so far have been written.
    Interrupted,
}

/// Catches signals that end the work, and shows progress, from here on.
pub fn begin() {
    signals::install_handlers();
    progress::show();
}

/// Prints the overall result as [`print_verdicts`] does, after the numbers of experiments and
/// figures, and returns the ending.
pub fn print_summary(results: &[ExperimentResult], options: &run::Options) -> Ending {
    let figures: usize = results.iter().map(|result| result.figures.len()).sum();
    let file = options.out.join(record::RESULTS);
    print_line!(
        "\n{} experiments, {figures} figures; as JSON: {}",
        results.len(),
        file.display()
    );
    print_verdicts(results)
}

/// Prints failed claims by name and then the counts, and returns the ending.
pub fn print_verdicts(results: &[ExperimentResult]) -> Ending {
    let (text, none_fails) = summary::verdicts(results);
    print_line!("{text}");
    if none_fails {
        Ending::Done
    } else {
        Ending::ClaimFails
    }
}

/// Parses the command line; a wrong option gets one line on standard error and exit code 2.
pub fn parse<T: Parser>() -> T {
    unwrap_or_exit(T::from_arg_matches(&matches(T::command())))
}

/// Parses the command line into matches; a wrong option is handled as by [`parse`].
pub fn matches(command: clap::Command) -> clap::ArgMatches {
    matches_or_exit(command, 2)
}

/// Options of other programs, and those of this one that do the same. Words are in lower case
/// without `-` and `_`.
const OPTION_SYNONYMS: [(&str, &str); 7] = [
    ("samples n s numsamples samplesperpixel samplecount", "spp"),
    ("resolution res width height w h dimensions", "size"),
    ("o output outfile outputfile", "out"),
    (
        "depth maxdepth maxbounces pathlength maxpathlength",
        "bounces",
    ),
    ("integrator method algorithm renderer", "estimator"),
    ("j t jobs numthreads cores", "threads"),
    ("i f input file", "scene"),
];

/// Returns the option of this program that an unknown argument stands for in others, such as
/// `--spp` for `--samples`.
fn meant_option(error: &clap::Error, options: &[String]) -> Option<String> {
    let Some(ContextValue::String(unknown)) = error.get(ContextKind::InvalidArg) else {
        return None;
    };
    let is_option = |name: &str| options.iter().any(|option| option == name);
    if unknown.ends_with(".toml") && is_option("scene") {
        return Some(format!("--scene {unknown}"));
    }
    let word = unknown.split('=').next()?;
    let word: String = word.chars().filter(char::is_ascii_alphanumeric).collect();
    let word = word.to_lowercase();
    let (_, name) = OPTION_SYNONYMS
        .iter()
        .find(|(words, name)| is_option(name) && words.split(' ').any(|synonym| synonym == word))?;
    Some(format!("--{name}"))
}

/// Parses the command line into matches, or exits with this code after one line on standard error.
fn matches_or_exit(command: clap::Command, code: u8) -> clap::ArgMatches {
    let command = allow_negative_values(command);
    let options = command.get_arguments().filter_map(clap::Arg::get_long);
    let options: Vec<String> = options.map(str::to_owned).collect();
    let parsed = command.try_get_matches();
    if let Err(error) = &parsed
        && error.kind() == ErrorKind::UnknownArgument
        && let Some(meant) = meant_option(error, &options)
    {
        let unknown = error.get(ContextKind::InvalidArg);
        let unknown = unknown.map_or_else(String::new, ToString::to_string);
        eprintln!("error: unexpected argument '{unknown}': take {meant} (see --help)");
        std::process::exit(code.into());
    }
    unwrap_or_exit_with(parsed, code)
}

/// Runs a program whose verdict is its exit code: 0 to 2, and 3 after one line for bad input.
pub fn run_with_verdict<T: Parser>(run: fn(&T) -> Result<u8, Error>) -> ExitCode {
    const BAD_INPUT: u8 = 3;
    let matches = matches_or_exit(T::command(), BAD_INPUT);
    let options = unwrap_or_exit_with(T::from_arg_matches(&matches), BAD_INPUT);
    ExitCode::from(run(&options).unwrap_or_else(|error| {
        eprintln!("error: {error}");
        BAD_INPUT
    }))
}

/// Takes a number after an option with a list of values as its value, even "-1", so that the error
/// names the option. Another option is not taken: then the value is missing.
fn allow_negative_values(command: clap::Command) -> clap::Command {
    command.mut_args(|argument| {
        let listed = !argument.get_possible_values().is_empty();
        // A flag has the values true and false, and takes none.
        if listed && argument.get_action().takes_values() {
            argument.allow_negative_numbers(true)
        } else {
            argument
        }
    })
}

/// Returns the value, or exits with code 2 after one line on standard error.
pub fn unwrap_or_exit<T>(parsed: Result<T, clap::Error>) -> T {
    unwrap_or_exit_with(parsed, 2)
}

/// Returns the value, or exits with this code after one line on standard error.
fn unwrap_or_exit_with<T>(parsed: Result<T, clap::Error>, code: u8) -> T {
    match parsed {
        Ok(options) => options,
        Err(error) if error.use_stderr() => {
            let message = error.render().to_string();
            let lines: Vec<&str> = message
                .lines()
                .map(str::trim)
                .filter(|line| !line.is_empty() && !line.starts_with("Usage:"))
                .collect();
            eprintln!("{}", lines.join("; "));
            std::process::exit(code.into());
        }
        // Help and version.
        Err(error) => error.exit(),
    }
}

/// Refuses the name of an image file that does not end in `.exr`.
pub fn check_image_name(out: &Path) -> Result<(), Error> {
    if out.extension().is_some_and(|extension| extension == "exr") {
        return Ok(());
    }
    Err(Error::Option(format!(
        "--out {} must end in .exr; the PNG gets the same name",
        out.display()
    )))
}

/// Parses `WIDTHxHEIGHT`.
pub fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once('x').and_then(|(width, height)| {
        let number = |text: &str| text.parse::<u32>().ok();
        Some([number(width)?, number(height)?])
    });
    let pixels = |[width, height]: [u32; 2]| u64::from(width) * u64::from(height);
    sides.filter(|&sides| (1..=MAX_FILM_PIXELS).contains(&pixels(sides))).ok_or_else(|| {
        format!(
            "must be WIDTHxHEIGHT in pixels such as 1024x768, each at least 1, and at most {MAX_FILM_PIXELS} \
                 in all, which is what fits memory"
        )
    })
}

/// Returns a parser of integers in a range.
pub fn integer<T: TryFrom<u64>>(
    range: RangeInclusive<u64>,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static {
    move |text| {
        let number = text.parse().ok().filter(|number| range.contains(number));
        number
            .and_then(|number| T::try_from(number).ok())
            .ok_or_else(|| {
                format!(
                    "must be a whole number from {} to {}",
                    range.start(),
                    range.end()
                )
            })
    }
}

/// Returns a parser of numbers in a range.
pub fn number(
    range: RangeInclusive<f64>,
) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text| {
        let number = text.parse().ok().filter(|number| range.contains(number));
        number.ok_or_else(|| format!("must be a number from {} to {}", range.start(), range.end()))
    }
}

/// Prefix of the names of worker threads, if their number was chosen.
pub const WORKER: &str = "worker";

/// Sets the number of threads for the whole program; all cores if `None`.
pub fn use_threads(threads: Option<usize>) -> Result<(), Error> {
    let Some(threads) = threads else {
        return Ok(());
    };
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|i| format!("{WORKER} {i}"))
        .build_global()
        .map_err(|error| Error::Option(format!("--threads {threads} cannot be started: {error}")))
}

/// Defines the whole program of the experiment whose name the binary has.
#[macro_export]
macro_rules! experiment_main {
    () => {
        fn main() -> std::process::ExitCode {
            $crate::run::cli::start(|| $crate::run::cli::run_experiment(env!("CARGO_BIN_NAME")))
        }
    };
}

/// Runs the experiment of this name as the command line asks.
pub fn run_experiment(id: &'static str) -> ExitCode {
    exit(find_experiment(id).and_then(|experiment| {
        let command = run::Options::augment_args(clap::Command::new(id))
            .about(experiment.title)
            .version(env!("CARGO_PKG_VERSION"));
        let options = unwrap_or_exit(run::Options::from_arg_matches(&matches(command)));
        use_threads(options.threads)?;
        begin();
        let ran = record::run_all(&[experiment], &options, true)?;
        Ok(print_summary(&ran.results, &options))
    }))
}

/// Returns the experiment of this name.
pub fn find_experiment(id: &str) -> Result<&'static Experiment, Error> {
    let found = EXPERIMENTS
        .iter()
        .copied()
        .find(|experiment| experiment.id == id);
    found.ok_or_else(|| {
        let hint = did_you_mean(id, EXPERIMENTS.iter().map(|experiment| experiment.id));
        Error::Option(format!(
            "--only {id} is not an experiment{hint} (--list shows all)"
        ))
    })
}
