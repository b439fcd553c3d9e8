//! The experiment `power` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::power::POWER)
}
