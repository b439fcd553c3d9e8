//! Judges whether the images of two renderers agree.

use std::process::ExitCode;

use experiments::compare;
use experiments::run::cli;

fn main() -> ExitCode {
    cli::start(compare::main)
}
