//! GGX, a rough conductor: microfacets of Trowbridge and Reitz's distribution (Walter et al., EGSR
//! 2007) with height-correlated masking and shadowing (Heitz, JCGT 3(2), 2014), sampled by visible
//! normals (Heitz, JCGT 7(4), 2018). Light that meets a second facet is lost.
//!
//! Local unit directions, the normal is z. m is the facet's normal, the half vector of wo and wi.

use std::f64::consts::{FRAC_1_PI, TAU};

use glam::DVec3;

use super::Bsdf;
use super::Model;
use super::named::{ALPHA, NamedModel, colour};

/// The entry of [`MODELS`](super::MODELS).
pub(super) const NAMED: NamedModel = NamedModel {
    name: "ggx",
    about: "a rough conductor",
    parameters: &[
        colour("reflectance", "of its facets at normal incidence"),
        ALPHA,
    ],
    build: |values| {
        Ok(Bsdf::model(Ggx {
            reflectance: values.colour("reflectance"),
            alpha: values.number("alpha"),
        }))
    },
};

/// A rough conductor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    /// F₀, the reflectance of a facet at normal incidence, per colour channel in [0, 1].
    pub reflectance: DVec3,
    /// α > 0, the width of the slopes' distribution: the square of the usual artistic roughness
    /// parameter.
    pub alpha: f64,
}

/// Returns D(m) of [`crate::equation::GGX_NORMALS`], 1/sr: facets' area per area of the surface and
/// solid angle.
#[inline]
pub fn ndf(alpha: f64, m: DVec3) -> f64 {
    let a2 = alpha * alpha;
    let t = m.z * m.z * (a2 - 1.0) + 1.0;
    if m.z > 0.0 {
        FRAC_1_PI * a2 / (t * t)
    } else {
        0.0
    }
}

/// Returns Smith's Λ(w) of [`crate::equation::GGX_MASKING`]: the facet area hidden by other facets
/// per visible area.
#[inline]
pub fn smith_lambda(alpha: f64, w: DVec3) -> f64 {
    let tan2 = (w.x * w.x + w.y * w.y) / (w.z * w.z);
    0.5 * ((1.0 + alpha * alpha * tan2).sqrt() - 1.0)
}

/// Returns G₂(wo, wi) of [`crate::equation::GGX_MASKING`], in [0, 1]: the fraction of the facets
/// visible from both directions.
#[inline]
pub fn smith_g2(alpha: f64, wo: DVec3, wi: DVec3) -> f64 {
    1.0 / (1.0 + smith_lambda(alpha, wo) + smith_lambda(alpha, wi))
}

/// Returns D_o(m) of [`crate::equation::GGX_VISIBLE`], 1/sr: the density of the facet normals
/// visible from `wo`.
#[inline]
pub fn visible_normal_pdf(alpha: f64, wo: DVec3, m: DVec3) -> f64 {
    ndf(alpha, m) * wo.dot(m).max(0.0) / ((1.0 + smith_lambda(alpha, wo)) * wo.z)
}

/// Samples a facet's normal with the density [`visible_normal_pdf`], from two uniform numbers: the
/// surface is stretched until its facets form a hemisphere, and a point of its visible part is
/// chosen.
#[inline]
pub fn sample_visible_normal(alpha: f64, wo: DVec3, [r1, r2]: [f64; 2]) -> DVec3 {
    let v = DVec3::new(alpha * wo.x, alpha * wo.y, wo.z).normalize();
    let x = DVec3::new(-v.y, v.x, 0.0)
        .try_normalize()
        .unwrap_or(DVec3::X);
    let y = v.cross(x);
    let (sin, cos) = (TAU * r2).sin_cos();
    let radius = r1.sqrt();
    let a = radius * cos;
    // The lower half of the disc is foreshortened.
    let share = 0.5 * (1.0 + v.z);
    let b = (1.0 - share) * (1.0 - a * a).sqrt() + share * radius * sin;
    let n = a * x + b * y + (1.0 - a * a - b * b).max(0.0).sqrt() * v;
    DVec3::new(alpha * n.x, alpha * n.y, n.z.max(0.0)).normalize()
}

impl Ggx {
    /// Returns F of a facet by Schlick's approximation (Computer Graphics Forum 13(3), 1994), from
    /// the cosine at it.
    #[inline]
    pub fn fresnel(&self, cosine: f64) -> DVec3 {
        self.reflectance + (1.0 - self.reflectance) * (1.0 - cosine).powi(5)
    }
}

impl Model for Ggx {
    fn eval(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        let m = (wo + wi).normalize();
        let facets = ndf(self.alpha, m) * smith_g2(self.alpha, wo, wi);
        self.fresnel(wo.dot(m)) * (facets / (4.0 * wo.z * wi.z))
    }

    fn sample(&self, wo: DVec3, random: [f64; 2]) -> Option<DVec3> {
        let m = sample_visible_normal(self.alpha, wo, random);
        let wi = 2.0 * wo.dot(m) * m - wo;
        (wi.z > 0.0).then_some(wi)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let m = (wo + wi).normalize();
        visible_normal_pdf(self.alpha, wo, m) / (4.0 * wo.dot(m))
    }

    fn albedo(&self) -> DVec3 {
        self.reflectance
    }
}
