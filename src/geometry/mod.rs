//! Rays, shapes, the hierarchy over them, solid angles, and how light goes from point to point.

pub mod bvh;
pub mod form_factor;
pub(crate) mod hull;
pub mod offsets;
pub mod radiometry;
pub mod shape;
pub mod solid_angle;
pub mod specular_connection;
pub mod watertight;
