//! The experiments, a module each; `statistics` and `suite_seeds` are what several of them examine.

pub mod agreement;
pub mod bleeding;
pub mod calibration;
pub mod caustics;
pub mod cie;
pub mod convergence;
pub mod diffuse;
pub mod errata;
pub mod false_alarms;
pub mod faults;
pub mod figures;
pub mod furnace;
pub mod lights;
pub mod penumbra;
pub mod photon_bias;
pub mod power;
pub mod radiosity;
pub mod regions;
pub mod sampling_claims;
pub mod shadow_rays;
pub mod speed;
pub mod statistics;
pub mod suite_seeds;
pub mod trials;
pub mod watertight;

use crate::run::Experiment;

/// Every experiment, in the order in which `reproduce` runs them.
pub const EXPERIMENTS: &[&Experiment] = &[
    &figures::ROOM,
    &diffuse::FIG2,
    &figures::FIG6,
    &figures::FIG7A,
    &figures::FIG7B,
    &figures::FIG8,
    &figures::FIG9,
    &regions::REGIONS,
    &regions::QUIRKS,
    &bleeding::BLEEDING,
    &radiosity::RADIOSITY,
    &cie::CIE,
    &watertight::WATERTIGHT,
    &errata::ERRATA,
    &lights::LIGHTS,
    &penumbra::PENUMBRA,
    &diffuse::ALBEDO,
    &furnace::FURNACE,
    &convergence::CONVERGENCE,
    &sampling_claims::SAMPLING_CLAIMS,
    &photon_bias::PHOTON_BIAS,
    &caustics::CAUSTICS,
    &shadow_rays::SHADOW_RAYS,
    &agreement::AGREEMENT,
    &speed::SPEED,
    &trials::TRIALS,
    &faults::FAULTS,
    &calibration::CALIBRATION,
    &power::POWER,
    &false_alarms::FALSE_ALARMS,
];
