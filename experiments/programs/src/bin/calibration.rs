//! The experiment `calibration` by itself.

experiments::alone!();
