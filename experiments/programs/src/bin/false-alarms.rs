//! The experiment `false-alarms` by itself.

experiments::alone!();
