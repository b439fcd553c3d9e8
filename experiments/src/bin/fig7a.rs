//! The experiment `fig7a` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::figures::FIG7A)
}
