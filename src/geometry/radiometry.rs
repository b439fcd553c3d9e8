//! Measures and factors of the rendering equation, each defined once.

use crate::math::real::{Real, Vector};

/// Returns the cosine of (9), [`crate::equation::COSINE`]: n·ω for unit vectors, 0 below the
/// surface.
#[inline]
pub fn cosine<V: Vector>(normal: V, direction: V) -> V::Real {
    normal.dot(direction).maximum(V::Real::splat(0.0))
}

/// Returns the integrand of (8) divided by the pdf of its direction, f_r L cos θ / p:
/// [`crate::equation::RENDERING`]. `pdf` is with respect to solid angle.
#[inline]
pub fn reflected<V: Vector>(brdf: V, radiance: V, cosine: V::Real, pdf: V::Real) -> V {
    brdf * radiance * (cosine / pdf)
}

/// Returns the solid angle per area dω/dA = cos θ_y / ‖x − y‖² (1/m² if lengths are metres) of a
/// surface at y seen from x. [`crate::equation::GEOMETRY`] is the product of this and [`cosine`] at
/// x.
#[inline]
pub fn solid_angle_per_area<R: Real>(cosine_at_y: R, distance_squared: R) -> R {
    cosine_at_y / distance_squared
}
