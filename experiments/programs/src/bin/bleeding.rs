//! The experiment `bleeding` by itself.

experiments::alone!();
