//! The experiment `quirks` by itself.

experiments::alone!();
