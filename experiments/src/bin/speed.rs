//! The experiment `speed` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::speed::SPEED)
}
