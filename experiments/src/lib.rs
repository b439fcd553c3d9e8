//! The programs of whitefurnace: `reproduce` runs every experiment, `render` makes one image, and each
//! experiment has a binary of its own name.

pub mod bleeding;
pub mod calibration;
pub mod cells;
pub mod cie;
pub mod cli;
pub mod false_alarms;
pub mod faults;
pub mod figures;
pub mod job;
pub mod lab;
pub mod ledger;
pub mod plot;
pub mod power;
pub mod progress;
pub mod radiosity;
pub mod record;
pub mod regions;
pub mod statistics;
pub mod suite;
pub mod trials;
pub mod watertight;

use lab::Experiment;

/// Every experiment, in the order in which `reproduce` runs them.
pub const EXPERIMENTS: &[&Experiment] = &[
    &figures::ROOM,
    &figures::FIG6,
    &figures::FIG7A,
    &figures::FIG7B,
    &figures::FIG8,
    &figures::FIG9,
    &regions::REGIONS,
    &bleeding::BLEEDING,
    &radiosity::RADIOSITY,
    &cie::CIE,
    &watertight::WATERTIGHT,
    &trials::TRIALS,
    &faults::FAULTS,
    &calibration::CALIBRATION,
    &power::POWER,
    &false_alarms::FALSE_ALARMS,
];
