//! The experiment `room` by itself.

experiments::alone!();
