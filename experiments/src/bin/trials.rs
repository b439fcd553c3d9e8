//! The experiment `trials` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::trials::TRIALS)
}
