//! The experiment `radiosity` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::radiosity::RADIOSITY)
}
