//! The experiment `fig6` by itself.

experiments::alone!();
