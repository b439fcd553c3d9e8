//! The experiment `trials` by itself.

experiments::alone!();
