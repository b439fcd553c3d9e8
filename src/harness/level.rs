//! The level of every assertion and the false-alarm budget of a suite.

/// Each assertion's share of the chance that a correct build goes red.
pub const ALPHA: f64 = 1e-9;
/// How many assertions that chance can turn red a suite may hold: the Bonferroni factor, fixed, so
/// that adding a trial changes no other.
pub const CAPACITY: usize = 1000;
/// The chance that a correct build goes red anywhere, under a fresh master seed: at most this.
pub const SUITE_BUDGET: f64 = ALPHA * CAPACITY as f64;
