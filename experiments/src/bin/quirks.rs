//! The experiment `quirks` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::regions::QUIRKS)
}
