//! The report's claims about its sampling, with numbers and figures.

mod pictures;
mod residuals;
mod samples;
mod walks;

use crate::experiments::prelude::*;

pub(super) const SAMPLING_CLAIMS: Experiment = Experiment {
    id: "sampling-claims",
    title: "what the report says of sampling, roulette, path length, supersampling and noise",
    headline: "paths cut after seven bounces lose {cut.0.9.7 %.0%} of a furnace of albedo 0.9; Brewster's angle {fresnel.brewster %.1f}°",
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

fn run(run: &mut Run) -> Result<(), Error> {
    samples::hemispheres(run, "hemispheres.svg")?;
    residuals::residuals(run, "residuals.svg")?;
    samples::importance(run, "importance.svg")?;
    samples::fresnel(run, "fresnel.svg")?;
    walks::roulette(run, "roulette.svg")?;
    walks::truncation(run, "truncation.svg")?;
    samples::edges(run, "edges.svg")?;
    pictures::antialiasing(run, ["antialiasing.png", "centre.png", "jittered.png"])?;
    pictures::noise(
        run,
        ["noise.png", "noise.svg", "noise-8.png", "noise-512.png"],
    )
}

/// Upper bound on the number of intervals that this experiment draws and judges.
const INTERVALS: f64 = 200.0;

/// Returns the half width of each interval in standard errors: the family-wise level over all of
/// them.
fn critical() -> f64 {
    normal_upper(FAMILYWISE_LEVEL / 2.0 / INTERVALS)
}
