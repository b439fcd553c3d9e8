//! The experiment `cie` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::cie::CIE)
}
