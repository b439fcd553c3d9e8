//! The experiment `radiosity` by itself.

experiments::alone!();
