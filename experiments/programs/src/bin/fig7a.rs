//! The experiment `fig7a` by itself.

experiments::alone!();
