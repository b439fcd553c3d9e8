//! The experiment `fig2` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::diffuse::FIG2)
}
