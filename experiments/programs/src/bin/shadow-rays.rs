//! The experiment `shadow-rays` by itself.

experiments::alone!();
