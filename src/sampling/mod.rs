//! Random numbers, low-discrepancy points, and the distributions drawn with them.

#[cfg(feature = "render")]
pub(crate) mod lanes;
pub mod mis;
pub mod pixel;
pub mod rng;
pub mod roulette;
#[cfg(feature = "render")]
pub mod sampler;
#[cfg(feature = "render")]
mod settings;
pub mod warp;

#[cfg(feature = "render")]
pub use settings::Sampling;
