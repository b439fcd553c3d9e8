//! The registry: every property on trial, each with faulty subjects that must be rejected.
//!
//! The tests and the experiments only loop over [`all`]; the faults are listed in [`crate::zoo`].

pub mod accumulators;
pub mod bsdf;
pub mod cie;
pub mod convergence;
pub mod emitters;
pub mod estimator;
pub mod fresnel;
pub mod furnace;
pub mod geometry;
pub mod glass;
pub mod hemisphere;
pub mod images;
pub mod irradiance;
pub mod panes;
pub mod probes;
pub mod radiosity;
pub mod roulette;
pub mod scenes;
pub mod streams;
pub mod subject;

use crate::harness::trial::Trial;
use crate::zoo::AnyFamily;

/// Every trial with its faults, by the type of subject.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    [
        hemisphere::families(),
        fresnel::families(),
        bsdf::families(),
        roulette::families(),
        streams::families(),
        convergence::families(),
        geometry::families(),
        emitters::families(),
        accumulators::families(),
        estimator::families(),
        radiosity::families(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Every trial of the suite.
pub fn all() -> Vec<Trial> {
    families()
        .iter()
        .flat_map(|family| family.trials())
        .collect()
}
