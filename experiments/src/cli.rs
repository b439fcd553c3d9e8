//! What all programs do alike at the command line.

use std::process::ExitCode;

use clap::{Args, FromArgMatches, Parser};
use whitefurnace::error::Error;

use crate::lab::{self, Experiment};
use crate::progress::catch_interrupt;
use crate::record;

/// Prints a line. That nobody reads it any more (`reproduce | head`) is no reason to stop.
#[macro_export]
macro_rules! say {
    ($($words:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stdout(), $($words)*);
    }};
}

/// Exit code 0; else one line on standard error and 2, or 130 after Ctrl-C.
pub fn exit(result: Result<(), Error>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(if matches!(error, Error::Interrupted) {
                130
            } else {
                2
            })
        }
    }
}

/// Parses the command line; a wrong option gets one line on standard error and exit code 2.
pub fn parse<T: Parser>() -> T {
    or_one_line(T::try_parse())
}

fn or_one_line<T>(parsed: Result<T, clap::Error>) -> T {
    match parsed {
        Ok(options) => options,
        Err(error) if error.use_stderr() => {
            let message = error.render().to_string();
            let lines: Vec<&str> = message
                .lines()
                .map(str::trim)
                .filter(|line| !line.is_empty() && !line.starts_with("Usage:"))
                .collect();
            eprintln!("{}", lines.join(" "));
            std::process::exit(2);
        }
        // Help and version.
        Err(error) => error.exit(),
    }
}

/// Parses `WIDTHxHEIGHT`.
///
/// # Errors
/// A line that says what is expected.
pub fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let expected =
        || format!("'{text}' is not a size: write WIDTHxHEIGHT in pixels, such as 1024x768");
    let (width, height) = text.split_once('x').ok_or_else(expected)?;
    let number = |text: &str| text.parse::<u32>().map_err(|_| expected());
    Ok([number(width)?, number(height)?])
}

/// Sets the number of threads for the whole program; all cores if `None`.
///
/// # Errors
/// [`Error::Option`] for 0 or more than 1024.
pub fn use_threads(threads: Option<usize>) -> Result<(), Error> {
    let Some(threads) = threads else {
        return Ok(());
    };
    if !(1..=1024).contains(&threads) {
        return Err(Error::Option(format!(
            "--threads {threads} must be between 1 and 1024"
        )));
    }
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build_global()
        .map_err(|error| Error::Option(format!("--threads {threads} cannot be started: {error}")))
}

/// The whole program of an experiment's own binary.
pub fn run_experiment(experiment: &'static Experiment) -> ExitCode {
    let command = lab::Options::augment_args(clap::Command::new(experiment.id))
        .about(experiment.title)
        .version(env!("CARGO_PKG_VERSION"));
    let matches = or_one_line(command.try_get_matches());
    let options = or_one_line(lab::Options::from_arg_matches(&matches));
    catch_interrupt();
    exit(use_threads(options.threads).and_then(|()| record::run_all(&[experiment], &options, true)))
}
