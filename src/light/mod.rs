//! Emitters, environment maps, and how one light of many is picked.

pub mod emitter;
pub mod environment;
pub mod light_sampler;
pub mod light_tree;
