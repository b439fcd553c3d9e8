//! EON, the energy-preserving Oren-Nayar model (Portsmouth, Kutz and Hill, JCGT 14(1), 2025):
//! Fujii's variant of the bracket (14), and a second lobe that returns the energy lost by single
//! scattering.
//!
//! The directional albedo is the exact integral, not the polynomial that the paper also offers. The
//! loss, 1 − E(θ) = A r (c − G(θ)/π), is computed as this product: nothing cancels, and nothing is
//! divided by zero where the roughness r is 0.

use std::f64::consts::FRAC_1_PI;

use super::Bsdf;
use super::named::{ALBEDO, NamedModel, number};
use glam::DVec3;

/// The entry of [`MODELS`](super::MODELS).
pub(super) const NAMED: NamedModel = NamedModel {
    name: "eon",
    about: "energy-preserving Oren-Nayar, whose albedo is that of single scattering",
    parameters: &[ALBEDO, number("roughness", [0.0, 1.0], "")],
    build: |values| {
        Ok(Bsdf::Eon {
            albedo: values.colour("albedo"),
            roughness: values.number("roughness"),
        })
    },
};

/// Largest value of G(θ)/π, at grazing: c = 1/2 − 2/(3π).
pub const MAX_G_OVER_PI: f64 = 0.5 - 2.0 / 3.0 * FRAC_1_PI;
/// Average of G(θ)/π over cos θ/π: 2/3 − 28/(15π).
pub const AVERAGE_G_OVER_PI: f64 = 2.0 / 3.0 - 28.0 / 15.0 * FRAC_1_PI;

/// Returns A of roughness r in [0, 1]: 1/(1 + cr), which makes the albedo at grazing 1.
#[inline]
pub fn coefficient_a(roughness: f64) -> f64 {
    1.0 / (1.0 + MAX_G_OVER_PI * roughness)
}

/// Returns π f_r/ρ of single scattering, [`crate::equation::EON_SINGLE`]: the bracket A + B s/t
/// with B = rA.
#[inline]
pub fn single_scattering(roughness: f64, wo: DVec3, wi: DVec3) -> f64 {
    let s = wo.x * wi.x + wo.y * wi.y;
    let t = if s > 0.0 { wo.z.max(wi.z) } else { 1.0 };
    coefficient_a(roughness) * (1.0 + roughness * s / t)
}

/// Returns G(θ)/π of [`crate::equation::EON_ALBEDO`], from cos θ in [0, 1]; in [0,
/// [`MAX_G_OVER_PI`]].
///
/// tan θ (1 − sin³ θ) is written as sin θ cos θ (1 + sin θ + sin² θ)/(1 + sin θ), which stays
/// finite.
#[inline]
pub fn g_over_pi(cos_theta: f64) -> f64 {
    let sin = ((1.0 - cos_theta) * (1.0 + cos_theta)).max(0.0).sqrt();
    let theta = sin.atan2(cos_theta);
    let product = sin * cos_theta;
    let tangent = product * (1.0 + sin + sin * sin) / (1.0 + sin);
    FRAC_1_PI * (sin * (theta - product - 2.0 / 3.0) + 2.0 / 3.0 * tangent)
}

/// Returns E(θ), the directional albedo of single scattering with ρ = 1,
/// [`crate::equation::EON_ALBEDO`].
#[inline]
pub fn albedo(roughness: f64, cos_theta: f64) -> f64 {
    coefficient_a(roughness) * (1.0 + roughness * g_over_pi(cos_theta))
}

/// Returns Ē, the average of E(θ) over cos θ/π.
#[inline]
pub fn average_albedo(roughness: f64) -> f64 {
    coefficient_a(roughness) * (1.0 + roughness * AVERAGE_G_OVER_PI)
}

/// Returns ρₘ, the albedo of all orders of scattering after the first, whose colour deepens with
/// each.
#[inline]
pub fn multiple_albedo(albedo: DVec3, roughness: f64) -> DVec3 {
    let average = average_albedo(roughness);
    albedo * albedo * average / (DVec3::ONE - albedo * (1.0 - average))
}

/// Returns π f_r/ρₘ of multiple scattering, [`crate::equation::EON_MULTIPLE`].
#[inline]
pub fn multiple_scattering(roughness: f64, wo: DVec3, wi: DVec3) -> f64 {
    let loss = |cos: f64| MAX_G_OVER_PI - g_over_pi(cos);
    coefficient_a(roughness) * roughness * (loss(wo.z) * loss(wi.z))
        / (MAX_G_OVER_PI - AVERAGE_G_OVER_PI)
}

/// Returns π f_r of the whole model: ρ and r in [0, 1], local directions above the horizon.
#[inline]
pub fn eon(albedo: DVec3, roughness: f64, wo: DVec3, wi: DVec3) -> DVec3 {
    albedo * single_scattering(roughness, wo, wi)
        + multiple_albedo(albedo, roughness) * multiple_scattering(roughness, wo, wi)
}
