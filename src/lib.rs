//! whitefurnace: a global-illumination testbed in which every equation is on trial.
pub mod bsdf;
pub mod camera;
pub mod equation;
pub mod error;
pub mod frame;
pub mod fresnel;
pub mod harness;
pub mod moments;
pub mod pixel;
pub mod radiometry;
pub mod rng;
pub mod roulette;
pub mod sampling;
pub mod shape;
pub mod trials;
pub mod watertight;
