//! The experiment `agreement` by itself.

experiments::alone!();
