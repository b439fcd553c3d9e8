//! The experiment `calibration` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::calibration::CALIBRATION)
}
