//! The harness: statistics that put a sampler, a BSDF, an estimator or an image on trial.
pub mod outcome;
pub mod tails;
