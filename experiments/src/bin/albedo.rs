//! The experiment `albedo` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::diffuse::ALBEDO)
}
