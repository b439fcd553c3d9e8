//! The experiment `caustics` by itself.

experiments::alone!();
