//! The experiment `photon-bias` by itself.

fn main() -> std::process::ExitCode {
    experiments::cli::run_experiment(&experiments::photon_bias::PHOTON_BIAS)
}
