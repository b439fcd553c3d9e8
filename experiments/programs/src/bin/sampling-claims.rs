//! The experiment `sampling-claims` by itself.

experiments::alone!();
