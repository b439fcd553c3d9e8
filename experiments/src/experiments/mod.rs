//! The experiments, a module each; several use the results of `suite_seeds`.

mod adaptive;
pub mod agreement;
pub mod answers;
mod bleeding;
mod calibration;
mod caustics;
mod comparisons;
mod convergence;
mod diffuse;
mod drawing;
mod embree;
mod errata;
mod false_alarms;
mod faults;
mod figures;
mod furnace;
mod lights;
mod mitsuba;
mod peers;
mod penumbra;
mod photon_bias;
mod planes;
pub mod power;
mod prelude;
mod radiosity;
mod random_scenes;
mod regions;
mod renderers;
mod sampling_claims;
mod scrambles;
mod shadow_rays;
mod single;
mod specular;
mod speed;
pub mod suite_seeds;
mod symptoms;
mod trials;
mod variants;
mod watertight;

use crate::run::Experiment;

/// All experiments, in the order in which `reproduce` runs them.
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
    &watertight::WATERTIGHT,
    &errata::ERRATA,
    &lights::LIGHTS,
    &penumbra::PENUMBRA,
    &diffuse::ALBEDO,
    &furnace::FURNACE,
    &convergence::CONVERGENCE,
    &scrambles::SCRAMBLES,
    &adaptive::ADAPTIVE,
    &sampling_claims::SAMPLING_CLAIMS,
    &photon_bias::PHOTON_BIAS,
    &caustics::CAUSTICS,
    &shadow_rays::SHADOW_RAYS,
    &specular::SPECULAR,
    &agreement::AGREEMENT,
    &peers::PEERS,
    &mitsuba::MITSUBA,
    &renderers::RENDERERS,
    &symptoms::SYMPTOMS,
    &answers::ANSWERS,
    &single::SINGLE,
    &comparisons::COMPARISONS,
    &speed::SPEED,
    &random_scenes::RANDOM_SCENES,
    &trials::TRIALS,
    &faults::FAULTS,
    &calibration::CALIBRATION,
    &power::POWER,
    &false_alarms::FALSE_ALARMS,
];

/// Experiments that the default run leaves out: they test the test suite, render mistakes, answer
/// exercises, measure differences of variance that need many samples, show other renderers'
/// records, or time this machine. `--only ID` runs one, `--tier full` all.
pub const NOT_BY_DEFAULT: [&str; 15] = [
    "peers",
    "scrambles",
    "adaptive",
    "renderers",
    "symptoms",
    "answers",
    "single",
    "comparisons",
    "speed",
    "random-scenes",
    "trials",
    "faults",
    "calibration",
    "power",
    "false-alarms",
];
