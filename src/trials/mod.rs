//! The registry: every property on trial, each with faulty subjects that must be rejected.
//!
//! The tests and the experiments only loop over [`all`].

pub mod bsdf;
pub mod convergence;
pub mod fresnel;
pub mod hemisphere;
pub mod roulette;
pub mod streams;

use crate::harness::trial::Trial;

/// Every trial of the suite.
pub fn all() -> Vec<Trial> {
    [
        hemisphere::trials(),
        fresnel::trials(),
        bsdf::trials(),
        roulette::trials(),
        streams::trials(),
        convergence::trials(),
    ]
    .into_iter()
    .flatten()
    .collect()
}
