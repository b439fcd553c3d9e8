//! The level of every assertion and the false-alarm budget of a suite.

/// Each assertion's share of the probability that a correct build goes red.
pub const ALPHA: f64 = 1e-9;
/// Largest number of assertions in a suite that chance can turn red: the Bonferroni factor, fixed,
/// so that adding a trial changes no other.
pub const CAPACITY: usize = 1000;
/// Largest probability that a correct build goes red anywhere, under a fresh master seed.
pub const SUITE_BUDGET: f64 = ALPHA * CAPACITY as f64;
