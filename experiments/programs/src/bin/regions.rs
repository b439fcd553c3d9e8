//! The experiment `regions` by itself.

experiments::alone!();
