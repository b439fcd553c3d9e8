//! The experiment `faults` by itself.

experiments::alone!();
