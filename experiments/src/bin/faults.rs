//! The experiment `faults` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::faults::FAULTS)
}
