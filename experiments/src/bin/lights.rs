//! The experiment `lights` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::lights::LIGHTS)
}
