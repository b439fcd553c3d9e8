//! The experiment `fig8` by itself.

experiments::alone!();
