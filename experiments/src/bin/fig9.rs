//! The experiment `fig9` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::figures::FIG9)
}
