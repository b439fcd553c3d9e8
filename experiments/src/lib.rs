//! The programs of whitefurnace: `reproduce` runs every experiment, `render` makes one image, and each
//! experiment has a binary of its own name.

pub mod agreement;
pub mod bands;
pub mod bleeding;
pub mod calibration;
pub mod caustics;
pub mod cells;
pub mod cie;
pub mod claims;
pub mod cli;
pub mod command;
pub mod convergence;
pub mod diffuse;
pub mod errata;
pub mod false_alarms;
pub mod faults;
pub mod figures;
pub mod furnace;
pub mod job;
pub mod lab;
pub mod ledger;
pub mod lights;
pub mod penumbra;
pub mod photon_bias;
pub mod photons;
pub mod pictures;
pub mod plot;
pub mod power;
pub mod progress;
pub mod radiosity;
pub mod record;
pub mod regions;
pub mod seeds;
pub mod shadow_rays;
pub mod signals;
pub mod speed;
pub mod statistics;
pub mod suite;
pub mod trials;
pub mod unfinished;
pub mod watertight;

use lab::Experiment;

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
    &claims::SAMPLING_CLAIMS,
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
