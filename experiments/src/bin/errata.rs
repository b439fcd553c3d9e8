//! The experiment `errata` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::errata::ERRATA)
}
