//! Hunts for random scenes whose renders break a relation.

use std::process::ExitCode;

use experiments::metamorphic;
use experiments::run::cli;

fn main() -> ExitCode {
    cli::start(metamorphic::main)
}
