//! The experiment `caustics` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::caustics::CAUSTICS)
}
