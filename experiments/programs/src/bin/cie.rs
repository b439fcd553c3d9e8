//! The experiment `cie` by itself.

experiments::alone!();
