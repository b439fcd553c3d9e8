//! The experiment `watertight` by itself.

experiments::alone!();
