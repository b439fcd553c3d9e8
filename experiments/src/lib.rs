//! The programs of whitefurnace: `reproduce` runs every experiment, `render` renders one image,
//! `export` writes scenes for other renderers, `compare` judges whether two renderers agree by
//! their images, `judge` tests a sampler by its directions, `metamorphic` hunts for random scenes
//! that break a relation, and each experiment has a program of its own name.
//!
//! An error is one line that says which file, option or name is at fault and what to change. After
//! a signal to end, the running work returns
//! [`Error::Interrupted`](whitefurnace::error::Error::Interrupted).

pub mod compare;
pub mod experiments;
pub mod export;
pub mod judge;
pub mod metamorphic;
pub mod plot;
pub mod render;
pub mod run;
