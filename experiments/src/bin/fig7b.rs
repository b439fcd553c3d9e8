//! The experiment `fig7b` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::figures::FIG7B)
}
