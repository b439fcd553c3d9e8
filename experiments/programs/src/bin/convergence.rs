//! The experiment `convergence` by itself.

experiments::alone!();
