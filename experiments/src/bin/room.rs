//! The experiment `room` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::figures::ROOM)
}
