//! Rays, shapes, the hierarchy over them, solid angles, and how light goes from point to point.

#[cfg(feature = "render")]
pub mod bvh;
pub mod form_factor;
#[cfg(feature = "render")]
pub(crate) mod hull;
pub mod offsets;
pub mod radiometry;
pub mod shape;
pub mod solid_angle;
pub mod specular_connection;
#[cfg(feature = "render")]
pub mod watertight;
