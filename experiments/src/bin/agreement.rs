//! The experiment `agreement` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::agreement::AGREEMENT)
}
