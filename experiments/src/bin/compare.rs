//! Decides whether two renderers' images agree.

use std::process::ExitCode;

use experiments::compare;
use experiments::run::cli;

fn main() -> ExitCode {
    cli::start(compare::main)
}
