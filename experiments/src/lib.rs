//! The programs of whitefurnace: `reproduce` runs every experiment, `render` makes one image,
//! `export` writes scenes for other renderers, `compare` puts two renderers on trial by their
//! images, `judge` a sampler by its directions, and each experiment has a program of its own name.
//!
//! An error is one line that says which file, option or name is at fault and what to change; after
//! a signal to end whatever is at work returns
//! [`Error::Interrupted`](whitefurnace::error::Error::Interrupted).

pub mod compare;
pub mod experiments;
pub mod export;
pub mod judge;
pub mod plot;
pub mod render;
pub mod run;
