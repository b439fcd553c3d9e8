//! The experiment `furnace` by itself.

experiments::alone!();
