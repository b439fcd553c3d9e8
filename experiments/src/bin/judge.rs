//! Judges whether sampled directions follow a density.

use std::process::ExitCode;

use experiments::judge;
use experiments::run::cli;

fn main() -> ExitCode {
    cli::start(judge::main)
}
