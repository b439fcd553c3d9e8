//! The experiment `sampling-claims` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::claims::SAMPLING_CLAIMS)
}
