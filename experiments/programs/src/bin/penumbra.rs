//! The experiment `penumbra` by itself.

experiments::alone!();
