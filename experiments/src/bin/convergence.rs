//! The experiment `convergence` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::convergence::CONVERGENCE)
}
