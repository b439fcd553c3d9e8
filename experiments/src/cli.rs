//! What all programs do alike at the command line.

use std::process::ExitCode;

use whitefurnace::error::Error;

/// Exit code 0, or 2 with one line on standard error.
pub fn exit(result: Result<(), Error>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
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
