//! Smooth interfaces: Fresnel reflectance (10)-(12), mirror direction, refraction, radiance factor.
//!
//! Angles enter as cos θ₁ ≥ 0 between the ray and the normal on its side; n₁ is the index on the ray's
//! side, n₂ on the other.

use glam::DVec3;

/// cos θ₂ by Snell's law; `None` past the critical angle, where reflection is total.
#[inline]
pub fn cos_refracted(cos_1: f64, n1: f64, n2: f64) -> Option<f64> {
    let ratio = n1 / n2;
    let radicand = 1.0 - ratio * ratio * (1.0 - cos_1 * cos_1);
    (radicand > 0.0).then(|| radicand.sqrt())
}

/// R_s of (10), [`crate::equation::FRESNEL_S`]; 1 in total reflection.
pub fn reflectance_s(cos_1: f64, n1: f64, n2: f64) -> f64 {
    cos_refracted(cos_1, n1, n2).map_or(1.0, |cos_2| {
        let r = (n1 * cos_1 - n2 * cos_2) / (n1 * cos_1 + n2 * cos_2);
        r * r
    })
}

/// R_p of (11), [`crate::equation::FRESNEL_P`]; 1 in total reflection.
pub fn reflectance_p(cos_1: f64, n1: f64, n2: f64) -> f64 {
    cos_refracted(cos_1, n1, n2).map_or(1.0, |cos_2| {
        let r = (n1 * cos_2 - n2 * cos_1) / (n1 * cos_2 + n2 * cos_1);
        r * r
    })
}

/// R of (12) for unpolarised light, [`crate::equation::FRESNEL`]: the share of flux that is reflected,
/// in [0, 1].
#[inline]
pub fn reflectance(cos_1: f64, n1: f64, n2: f64) -> f64 {
    0.5 * (reflectance_s(cos_1, n1, n2) + reflectance_p(cos_1, n1, n2))
}

/// The mirror direction of a unit direction `d` that arrives at a surface with unit normal `n`.
#[inline]
pub fn mirror(d: DVec3, n: DVec3) -> DVec3 {
    d - 2.0 * d.dot(n) * n
}

/// The refracted unit direction of `d` arriving with −d·n = cos θ₁ ≥ 0, [`crate::equation::REFRACTION`];
/// `None` in total reflection.
#[inline]
pub fn refract(d: DVec3, n: DVec3, n1: f64, n2: f64) -> Option<DVec3> {
    let cos_1 = -d.dot(n);
    let cos_2 = cos_refracted(cos_1, n1, n2)?;
    let ratio = n1 / n2;
    Some((ratio * d + (ratio * cos_1 - cos_2) * n).normalize())
}

/// What a camera path's throughput is multiplied by when it goes from index `n1` into `n2`: (n₁/n₂)²,
/// [`crate::equation::REFRACTION`]. Radiance divided by n² is what refraction conserves; flux, which
/// particles carry, is not changed.
#[inline]
pub fn radiance_factor(n1: f64, n2: f64) -> f64 {
    (n1 / n2) * (n1 / n2)
}
