//! Writes scenes for other renderers.

use std::process::ExitCode;

use experiments::export;
use experiments::run::cli;

fn main() -> ExitCode {
    cli::start(export::main)
}
