//! The experiment `speed` by itself.

experiments::alone!();
