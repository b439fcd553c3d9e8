//! The experiment `errata` by itself.

experiments::alone!();
