//! Numbers, vectors and frames of one ray or of several, exact moments, a kd-tree.

pub mod frame;
pub mod kd_tree;
pub mod moments;
pub mod real;
pub mod simd;
