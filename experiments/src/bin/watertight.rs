//! The experiment `watertight` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::watertight::WATERTIGHT)
}
