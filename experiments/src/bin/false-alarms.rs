//! The experiment `false-alarms` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::false_alarms::FALSE_ALARMS)
}
