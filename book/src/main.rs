//! `cargo run --release -p book`: weaves the book and prints the path of its first page.

use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use book::{Options, build};

const HELP: &str = include_str!("help.txt");

/// Parses the command line; `None` for help.
fn parse(arguments: impl IntoIterator<Item = String>) -> Result<Option<Options>, String> {
    let mut options = Options::default();
    let mut arguments = arguments.into_iter();
    while let Some(argument) = arguments.next() {
        let (name, value) = match argument.split_once('=') {
            Some((name, value)) => (name, Some(value.to_owned())),
            None => (argument.as_str(), None),
        };
        let target = match name {
            "--help" | "-h" => return Ok(None),
            "--out" => &mut options.out,
            "--results" => &mut options.results,
            "--run" => options.run.insert(PathBuf::new()),
            _ => return Err(format!("unknown option {argument}; try --help")),
        };
        let value = value.or_else(|| arguments.next());
        let value = value.filter(|value| !value.is_empty());
        *target = PathBuf::from(value.ok_or_else(|| format!("{name} needs a folder"))?);
    }
    if !options.results.is_dir() {
        return Err(format!(
            "--results {} is not a folder",
            options.results.display()
        ));
    }
    Ok(Some(options))
}

fn main() -> ExitCode {
    let options = parse(std::env::args().skip(1)).map_err(|message| format!("error: {message}"));
    let outcome = options.and_then(|options| match options {
        Some(options) => build(&options)
            .map(|page| page.display().to_string())
            .map_err(|error| error.to_string()),
        None => Ok(HELP.trim_end().to_owned()),
    });
    match outcome {
        Ok(text) => {
            // A closed pipe (`book --help | head`) is no error.
            let _ = writeln!(std::io::stdout(), "{text}");
            ExitCode::SUCCESS
        }
        Err(text) => {
            eprintln!("{text}");
            ExitCode::from(2)
        }
    }
}
