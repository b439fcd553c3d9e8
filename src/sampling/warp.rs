//! Maps from the unit square to directions and points, each with its pdf and inverse.
//!
//! Directions are local (z is the normal). Pdfs of directions are with respect to solid angle, pdfs
//! of points with respect to area.

use std::f64::consts::{FRAC_1_PI, PI, TAU};

use glam::DVec3;

use crate::math::frame::{azimuth, from_spherical};
use crate::math::real::{Real, Vector, sin_cos_of_turn};

/// Returns θ of (18), [`crate::equation::HEMISPHERE_THETA`], from r in [0, 1].
pub fn uniform_theta(r: f64) -> f64 {
    (1.0 - r).acos()
}

/// Returns φ of (19), [`crate::equation::HEMISPHERE_PHI`], from r in [0, 1].
pub fn uniform_phi(r: f64) -> f64 {
    r * 2.0 * PI
}

/// Samples a direction of the hemisphere by (18) and (19) with two independent numbers.
///
/// Equals `from_spherical(uniform_theta(r₁), uniform_phi(r₂))` to a few roundings, without the
/// inverse cosine: cos θ = 1 − r₁ and sin θ = √(r₁(2 − r₁)).
#[inline]
pub fn uniform_hemisphere<R: Real>([r1, r2]: [R; 2]) -> R::Vector {
    let sin_theta = (r1 * (R::splat(2.0) - r1)).sqrt();
    let (sin_phi, cos_phi) = sin_cos_of_turn(r2);
    R::Vector::of([sin_theta * cos_phi, sin_theta * sin_phi, R::splat(1.0) - r1])
}

/// Returns the pdf 1/2π of [`uniform_hemisphere`], (17), [`crate::equation::HEMISPHERE_PDF`]; 0
/// below the horizon.
#[inline]
pub fn uniform_hemisphere_pdf<R: Real>(cos_theta: R) -> R {
    R::select(
        cos_theta.cmplt(R::splat(0.0)),
        R::splat(0.0),
        R::splat(0.5 * FRAC_1_PI),
    )
}

/// Returns the numbers that [`uniform_hemisphere`] maps to a direction; azimuth in [0, 1).
pub fn uniform_hemisphere_inverse(w: DVec3) -> [f64; 2] {
    [1.0 - w.z, turns(w)]
}

/// Samples by (18) and (19) as printed, with one number r for both angles: a spiral, not a
/// hemisphere. Kept to be shown and rejected.
pub fn hemisphere_printed(r: f64) -> DVec3 {
    from_spherical(uniform_theta(r), uniform_phi(r))
}

/// Samples a cosine-weighted direction, [`crate::equation::COSINE_HEMISPHERE`].
#[inline]
pub fn cosine_hemisphere<R: Real>([r1, r2]: [R; 2]) -> R::Vector {
    let sin_theta = r1.sqrt();
    let (sin_phi, cos_phi) = sin_cos_of_turn(r2);
    R::Vector::of([
        sin_theta * cos_phi,
        sin_theta * sin_phi,
        (R::splat(1.0) - r1).sqrt(),
    ])
}

/// Returns the pdf cos θ/π of [`cosine_hemisphere`]; 0 below the horizon.
#[inline]
pub fn cosine_hemisphere_pdf<R: Real>(cos_theta: R) -> R {
    cos_theta.maximum(R::splat(0.0)) * FRAC_1_PI
}

/// Returns the numbers that [`cosine_hemisphere`] maps to a direction; azimuth in [0, 1).
pub fn cosine_hemisphere_inverse(w: DVec3) -> [f64; 2] {
    [w.x * w.x + w.y * w.y, turns(w)]
}

/// Samples a point of the zone `heights` of the sphere of radius `radius` around the origin,
/// uniform in area (Archimedes' hat box).
#[inline]
pub fn sphere_zone<R: Real>([r1, r2]: [R; 2], radius: f64, heights: [f64; 2]) -> R::Vector {
    let z = r1 * (heights[1] - heights[0]) + heights[0];
    let rho = (R::splat(radius * radius) - z * z)
        .maximum(R::splat(0.0))
        .sqrt();
    let (sin_phi, cos_phi) = sin_cos_of_turn(r2);
    R::Vector::of([rho * cos_phi, rho * sin_phi, z])
}

/// Samples barycentric (u, v) of (2), uniform in area, by folding the unit square along its
/// diagonal.
#[inline]
pub fn triangle<R: Real>(random: [R; 2]) -> [R; 2] {
    let beyond = (random[0] + random[1]).cmpgt(R::splat(1.0));
    random.map(|r| R::select(beyond, R::splat(1.0) - r, r))
}

/// Returns the azimuth as a fraction of the full turn, [0, 1).
fn turns(w: DVec3) -> f64 {
    azimuth(w) / TAU
}
