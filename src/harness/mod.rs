//! The harness: statistics that put a sampler, a BSDF, an estimator or an image on trial.
pub mod bsdf_checkup;
pub mod chi_square;
pub mod domain;
pub mod ks;
pub mod mean;
pub mod outcome;
pub mod quadrature;
pub mod tails;
pub mod trial;
