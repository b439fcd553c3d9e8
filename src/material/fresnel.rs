//! Smooth interfaces: Fresnel reflectance (10)-(12), mirror direction, refraction, radiance factor.
//!
//! Angles enter as cos θ₁ ≥ 0 between the ray and the normal on its side; n₁ is the index on the
//! ray's side, n₂ on the other.

use glam::DVec3;

use crate::math::real::{MaskOf, Real, Vector};

/// Returns cos² θ₂ by Snell's law; not above 0 past the critical angle, where reflection is total.
#[inline]
pub fn squared_cos_refracted<R: Real>(cos_1: R, n1: R, n2: R) -> R {
    let ratio = n1 / n2;
    R::splat(1.0) - ratio * ratio * (R::splat(1.0) - cos_1 * cos_1)
}

/// Returns R_s of (10), [`crate::equation::FRESNEL_S`]; 1 in total reflection.
#[inline]
pub fn reflectance_s<R: Real>(cos_1: R, n1: R, n2: R) -> R {
    let squared = squared_cos_refracted(cos_1, n1, n2);
    let cos_2 = squared.sqrt();
    let r = (n1 * cos_1 - n2 * cos_2) / (n1 * cos_1 + n2 * cos_2);
    R::select(squared.cmpgt(R::splat(0.0)), r * r, R::splat(1.0))
}

/// Returns R_p of (11), [`crate::equation::FRESNEL_P`]; 1 in total reflection.
#[inline]
pub fn reflectance_p<R: Real>(cos_1: R, n1: R, n2: R) -> R {
    let squared = squared_cos_refracted(cos_1, n1, n2);
    let cos_2 = squared.sqrt();
    let r = (n1 * cos_2 - n2 * cos_1) / (n1 * cos_2 + n2 * cos_1);
    R::select(squared.cmpgt(R::splat(0.0)), r * r, R::splat(1.0))
}

/// Returns R of (12) for unpolarised light, [`crate::equation::FRESNEL`]: the reflected fraction of
/// flux, in [0, 1].
#[inline]
pub fn reflectance<R: Real>(cos_1: R, n1: R, n2: R) -> R {
    (reflectance_s(cos_1, n1, n2) + reflectance_p(cos_1, n1, n2)) * 0.5
}

/// Returns the mirror direction of a unit direction `d` that arrives at a surface with unit normal
/// `n`.
#[inline]
pub fn reflect<V: Vector>(d: V, n: V) -> V {
    d - n * (d.dot(n) * 2.0)
}

/// Returns the refracted unit direction of `d` arriving with −d·n = cos θ₁ ≥ 0,
/// [`crate::equation::REFRACTION`], and whether there is one: not in total reflection.
#[inline]
pub fn refracted<V: Vector>(d: V, n: V, n1: V::Real, n2: V::Real) -> (V, MaskOf<V>) {
    let cos_1 = -d.dot(n);
    let squared = squared_cos_refracted(cos_1, n1, n2);
    let ratio = n1 / n2;
    let direction = d * ratio + n * (ratio * cos_1 - squared.sqrt());
    (direction.normalize(), squared.cmpgt(V::Real::splat(0.0)))
}

/// Returns the refracted unit direction of one ray; `None` in total reflection.
#[inline]
pub fn refract(d: DVec3, n: DVec3, n1: f64, n2: f64) -> Option<DVec3> {
    let (direction, passes) = refracted(d, n, n1, n2);
    passes.then_some(direction)
}

/// Returns the factor of a camera path's throughput on refraction from index `n1` into `n2`:
/// (n₁/n₂)², [`crate::equation::REFRACTION`]. Refraction conserves radiance divided by n²; flux,
/// which particles carry, is not changed.
#[inline]
pub fn radiance_factor<R: Real>(n1: R, n2: R) -> R {
    (n1 / n2) * (n1 / n2)
}
