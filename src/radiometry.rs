//! The rendering equation's measures and factors, each written once.

use glam::DVec3;

/// The cosine of (9), [`crate::equation::COSINE`]: n·ω for unit vectors, 0 below the surface.
#[inline]
pub fn cosine(normal: DVec3, direction: DVec3) -> f64 {
    normal.dot(direction).max(0.0)
}

/// The integrand of (8) divided by the pdf of its direction, f_r L cos θ / p:
/// [`crate::equation::RENDERING`]. `pdf` with respect to solid angle.
#[inline]
pub fn reflected(brdf: DVec3, radiance: DVec3, cosine: f64, pdf: f64) -> DVec3 {
    brdf * radiance * (cosine / pdf)
}

/// Solid angle per area dω/dA = cos θ_y / ‖x − y‖² (1/m² if lengths are metres) of a surface at y
/// seen from x. [`crate::equation::GEOMETRY`] is the product of this and [`cosine`] at x.
#[inline]
pub fn solid_angle_per_area(cosine_at_y: f64, distance_squared: f64) -> f64 {
    cosine_at_y / distance_squared
}

/// The balance heuristic of [`crate::equation::MIS`]: the weight of a sample drawn with `pdf` that
/// another strategy would draw with `other`, both with respect to the same measure.
#[inline]
pub fn balance(pdf: f64, other: f64) -> f64 {
    1.0 / (1.0 + ratio(other, pdf))
}

/// The power heuristic with exponent 2 of [`crate::equation::MIS_POWER`], arguments as [`balance`]. The
/// ratio is squared, not the pdfs, so that none overflows.
#[inline]
pub fn power(pdf: f64, other: f64) -> f64 {
    let ratio = ratio(other, pdf);
    1.0 / (1.0 + ratio * ratio)
}

/// a/b in [0, ∞] for a, b in [0, ∞], where 0/0 and ∞/∞ are 1, so that weights sum to one there, too.
#[inline]
fn ratio(a: f64, b: f64) -> f64 {
    if a == b { 1.0 } else { a / b }
}
