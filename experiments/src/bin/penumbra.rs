//! The experiment `penumbra` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::penumbra::PENUMBRA)
}
