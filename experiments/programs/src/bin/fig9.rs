//! The experiment `fig9` by itself.

experiments::alone!();
