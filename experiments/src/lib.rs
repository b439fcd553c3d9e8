//! The programs of whitefurnace: `reproduce` runs every experiment, `render` makes one image, and each
//! experiment has a program of its own name.

pub mod experiments;
pub mod plot;
pub mod render;
pub mod run;
