//! The experiment `albedo` by itself.

experiments::alone!();
