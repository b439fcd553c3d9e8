//! The registry: every trial of the suite, each with faulty subjects that it must reject.
//!
//! The tests and the experiments only loop over [`all`]; the faults are listed in
//! [`crate::faults`].

mod accumulators;
mod adaptive;
mod bdpt_densities;
mod bidirectional;
pub mod bsdf;
mod certain_paths;
pub mod cie;
pub mod convergence;
mod emitters;
mod environment_map;
mod eon;
mod estimator;
pub mod faults;
pub mod form_factors;
pub mod fresnel;
mod furnace;
mod geometry;
pub mod ggx;
mod glass;
mod glass_bodies;
pub mod hemisphere;
mod image_mean;
mod images;
mod infinite_variance;
mod irradiance;
pub mod manufactured;
mod mean_radiance;
pub mod metamorphic;
mod near_coincident;
mod path_weights;
pub mod photon;
mod prelude;
mod published;
pub mod radiosity;
mod rays_per_hit;
pub mod references;
mod render_streams;
pub mod rough_glass;
pub mod roulette;
pub mod scenes;
mod script;
mod silhouettes;
mod single_precision;
mod sobol;
mod solid_angle;
mod specular_chains;
mod specular_nee;
pub mod statistics;
pub mod strategies;
mod streams;
mod subject;
mod survival;
pub mod symptoms;

use std::sync::LazyLock;

use crate::faults::{AnyFamily, FaultData, Pair};
use whitefurnace::harness::trial::Trial;

/// The registry, made once: its expected values take seconds of quadrature.
static FAMILIES: LazyLock<Vec<Box<dyn AnyFamily>>> = LazyLock::new(|| {
    [
        hemisphere::families(),
        fresnel::families(),
        bsdf::families(),
        eon::families(),
        ggx::families(),
        rough_glass::families(),
        roulette::families(),
        survival::families(),
        streams::families(),
        render_streams::families(),
        sobol::families(),
        convergence::families(),
        adaptive::families(),
        silhouettes::families(),
        single_precision::families(),
        geometry::families(),
        emitters::families(),
        solid_angle::families(),
        accumulators::families(),
        estimator::families(),
        certain_paths::families(),
        path_weights::families(),
        published::families(),
        photon::families(),
        bidirectional::families(),
        bdpt_densities::families(),
        radiosity::families(),
        manufactured::families(),
        references::families(),
        metamorphic::trials::families(),
    ]
    .into_iter()
    .flatten()
    .collect()
});

/// All families: the trials and their faults, grouped by type of subject.
pub fn families() -> &'static [Box<dyn AnyFamily>] {
    &FAMILIES
}

/// Every trial of the suite.
pub fn all() -> Vec<Trial> {
    families()
        .iter()
        .flat_map(|family| family.trials())
        .collect()
}

/// Every fault and every equivalent mutant.
pub fn all_faults() -> Vec<FaultData> {
    families()
        .iter()
        .flat_map(|family| family.faults())
        .collect()
}

/// The full table: every fault and equivalent mutant under every trial of its family.
pub fn matrix() -> Vec<Pair> {
    families()
        .iter()
        .flat_map(|family| family.pairs())
        .collect()
}

/// The equivalent mutants under the trials that must accept them.
pub fn equivalents() -> Vec<Pair> {
    let mut pairs = matrix();
    pairs.retain(|pair| pair.fault.equivalent && pair.required);
    pairs
}
