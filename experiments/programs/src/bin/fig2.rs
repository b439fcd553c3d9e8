//! The experiment `fig2` by itself.

experiments::alone!();
