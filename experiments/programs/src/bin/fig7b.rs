//! The experiment `fig7b` by itself.

experiments::alone!();
