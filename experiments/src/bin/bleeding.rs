//! The experiment `bleeding` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::bleeding::BLEEDING)
}
