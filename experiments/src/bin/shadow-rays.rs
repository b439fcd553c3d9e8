//! The experiment `shadow-rays` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::shadow_rays::SHADOW_RAYS)
}
