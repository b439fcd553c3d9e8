//! The experiment `lights` by itself.

experiments::alone!();
