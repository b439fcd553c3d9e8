//! The experiment `furnace` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::furnace::FURNACE)
}
