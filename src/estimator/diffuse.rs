//! How a path goes on at a diffuse surface.

use glam::DVec3;

use super::Parts;
use crate::bsdf::Bsdf;
use crate::radiometry::reflected;

/// A direction in which a path goes on, local, z the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffuseSample {
    /// Away from the surface, unit.
    pub wi: DVec3,
    /// f_r cos θ / p per colour channel.
    pub weight: DVec3,
    /// p with respect to solid angle, 1/sr.
    pub pdf: f64,
}

/// A direction weighted by the cosine; `None` where that has no density.
#[inline]
pub fn sample_cosine<P: Parts>(
    parts: &P,
    bsdf: &Bsdf,
    wo: DVec3,
    random: [f64; 2],
) -> Option<DiffuseSample> {
    let wi = parts.cosine_hemisphere(random);
    let pdf = parts.cosine_hemisphere_pdf(wi.z);
    (pdf != 0.0).then(|| weighted(parts, bsdf, wo, wi, pdf))
}

/// A direction uniform over the hemisphere.
#[inline]
pub fn sample_uniform<P: Parts>(
    parts: &P,
    bsdf: &Bsdf,
    wo: DVec3,
    random: [f64; 2],
) -> DiffuseSample {
    let wi = parts.uniform_hemisphere(random);
    weighted(parts, bsdf, wo, wi, parts.uniform_hemisphere_pdf(wi.z))
}

#[inline]
fn weighted<P: Parts>(parts: &P, bsdf: &Bsdf, wo: DVec3, wi: DVec3, pdf: f64) -> DiffuseSample {
    let brdf = parts.brdf(bsdf, wo, wi);
    let weight = reflected(brdf, DVec3::ONE, parts.cosine(DVec3::Z, wi), pdf);
    DiffuseSample { wi, weight, pdf }
}
