//! The experiment `photon-bias` by itself.

experiments::alone!();
