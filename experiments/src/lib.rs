//! The programs of whitefurnace.

pub mod cli;
pub mod job;
pub mod progress;
