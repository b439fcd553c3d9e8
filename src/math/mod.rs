//! Numbers, vectors and frames of one ray or of several, exact moments, a kd-tree.

pub mod frame;
#[cfg(feature = "render")]
pub mod kd_tree;
#[cfg(feature = "render")]
mod lanes3;
pub mod moments;
pub mod real;
#[cfg(feature = "render")]
pub mod simd;

/// Half a unit in the last place of a 16-bit float.
pub(crate) const HALF_ROUNDING: f64 = 1.0 / 2048.0;
