//! What the report claims of its sampling, with numbers and figures.

mod pictures;
mod residuals;
mod samples;
mod walks;

use whitefurnace::equation;
use whitefurnace::error::Error;
use whitefurnace::harness::tails::normal_upper;

use crate::lab::{Experiment, Lab};
use crate::suite::FAMILY;

/// Importance sampling, roulette, path length, supersampling, noise.
pub const SAMPLING_CLAIMS: Experiment = Experiment {
    id: "sampling-claims",
    title: "what the report says of sampling, roulette, path length, supersampling and noise",
    version: 2,
    equations: &[
        &equation::HEMISPHERE_THETA,
        &equation::HEMISPHERE_PHI,
        &equation::COSINE_HEMISPHERE,
        &equation::ROULETTE,
        &equation::PATH_LENGTH,
        &equation::SUPERSAMPLING,
        &equation::RANDOMISATION,
        &equation::ESTIMATOR,
        &equation::FRESNEL,
    ],
    run,
};

fn run(lab: &mut Lab) -> Result<(), Error> {
    samples::hemispheres(lab, "hemispheres.svg")?;
    residuals::residuals(lab, "residuals.svg")?;
    samples::importance(lab, "importance.svg")?;
    samples::fresnel(lab, "fresnel.svg")?;
    walks::roulette(lab, "roulette.svg")?;
    walks::truncation(lab, "truncation.svg")?;
    samples::edges(lab, "edges.svg")?;
    pictures::antialiasing(lab, ["antialiasing.png", "centre.png", "jittered.png"])?;
    pictures::noise(lab, ["noise.png", "noise.svg", "noise-8.png", "noise-512.png"])
}

/// How many intervals this experiment draws and judges, at most.
const INTERVALS: f64 = 200.0;

/// Half the width of each interval in standard errors: the family-wise level over all of them.
fn critical() -> f64 {
    normal_upper(FAMILY / 2.0 / INTERVALS)
}
