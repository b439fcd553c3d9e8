//! The experiment `power` by itself.

experiments::alone!();
