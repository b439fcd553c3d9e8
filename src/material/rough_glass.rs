//! A rough dielectric: facets of smooth glass (Walter et al., EGSR 2007) with the normals and the
//! masking of [GGX](crate::material::ggx). Light that meets a second facet is lost.
//!
//! Directions are local unit vectors. wo is above the horizon, on the side whose index of
//! refraction is 1; a wi below it is transmitted. f is that of flux, or of radiance divided by the
//! square of the index, which refraction conserves: the factor of radiance itself is kept
//! separately, as [`BsdfSample::radiance_factor`](crate::material::BsdfSample).
//!
//! A facet at the quantile u of all heights is visible from above, along w, with probability
//! u^Λ(w), and from below with (1 − u)^Λ(w). Averaged over u, two directions above both see 1/(1 +
//! Λ + Λ) of the facets, but one above and one below see B(1 + Λ, 1 + Λ), Euler's beta function:
//! high facets are visible from above and hidden from below.

use glam::DVec3;
use statrs::function::beta::ln_beta;

use super::Bsdf;
use super::fresnel;
use super::ggx::{sample_visible_normal, smith_g2, smith_lambda, visible_normal_pdf};
use super::named::{ALPHA, INDEX, NamedModel};

/// The entry of [`MODELS`](super::MODELS).
pub(super) const NAMED: NamedModel = NamedModel {
    name: "rough-glass",
    about: "only path tracing supports it (`--estimator mis`, `bsdf` and `light`), and its index must \
            differ from 1",
    parameters: &[INDEX, ALPHA],
    build: |values| {
        let glass = RoughGlass {
            index: values.number("index"),
            alpha: values.number("alpha"),
        };
        if glass.is_valid() {
            Ok(Bsdf::RoughGlass(glass))
        } else {
            Err((
                "index",
                "must differ from 1 by 0.001 at least: no facet bends light there",
            ))
        }
    },
};

/// A rough surface of glass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughGlass {
    /// Index of refraction on the inner side of the surface relative to the outer; for wo and wi,
    /// on the far side of the surface.
    pub index: f64,
    /// α > 0, the width of the slopes' distribution: the square of the usual artistic roughness
    /// parameter.
    pub alpha: f64,
}

/// Returns G₂(wo, wi) of [`crate::equation::ROUGH_GLASS_MASKING`], in [0, 1]: the fraction of the
/// facets visible from both of two directions on opposite sides.
#[inline]
pub fn smith_g2_transmission(alpha: f64, wo: DVec3, wi: DVec3) -> f64 {
    let (o, i) = (smith_lambda(alpha, wo), smith_lambda(alpha, wi));
    if o.is_finite() && i.is_finite() {
        ln_beta(1.0 + o, 1.0 + i).exp()
    } else {
        0.0
    }
}

/// Returns the normal, on the side of wo, of the facets that refract wo into wi, and the solid
/// angle of such normals per solid angle of wi, of [`crate::equation::ROUGH_GLASS_REFRACTION`].
/// `None` if no facet does.
#[inline]
pub fn refracting(index: f64, wo: DVec3, wi: DVec3) -> Option<(DVec3, f64)> {
    let sum = wo + index * wi;
    let m = sum.normalize() * (1.0 - index).signum();
    let cosine = -wi.dot(m);
    (wo.dot(m) > 0.0 && cosine > 0.0).then(|| (m, index * index * cosine / sum.length_squared()))
}

impl RoughGlass {
    /// Returns the surface for directions relative to its outer or its inner side.
    #[inline]
    pub fn oriented(self, outside: bool) -> Self {
        if outside {
            self
        } else {
            Self {
                index: self.index.recip(),
                ..self
            }
        }
    }

    /// Returns whether its parameters are valid. Where the indices are equal no facet bends light.
    pub fn is_valid(&self) -> bool {
        let Self { index, alpha } = *self;
        index.is_finite()
            && index > 0.0
            && (index - 1.0).abs() >= LEAST_STEP
            && alpha.is_finite()
            && alpha > 0.0
    }

    /// Returns F of a facet from its cosine to wo.
    #[inline]
    fn fresnel(&self, cosine: f64) -> f64 {
        fresnel::reflectance(cosine, 1.0, self.index)
    }

    /// Returns f of [`crate::equation::ROUGH_GLASS`], 1/sr.
    #[inline]
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> f64 {
        let visible_from_both = if wi.z > 0.0 {
            smith_g2
        } else {
            smith_g2_transmission
        };
        // The pdf is f as if all sampled facets were visible from wi.
        let density = self.pdf(wo, wi);
        let seen = if density > 0.0 {
            visible_from_both(self.alpha, wo, wi)
        } else {
            0.0
        };
        if seen > 0.0 {
            density * seen * (1.0 + smith_lambda(self.alpha, wo)) / wi.z.abs()
        } else {
            0.0
        }
    }

    /// Samples a direction: a visible normal by two uniform numbers, reflection or refraction by
    /// the third. `None` for light that meets a second facet.
    #[inline]
    pub fn sample(&self, wo: DVec3, [r1, r2, r3]: [f64; 3]) -> Option<DVec3> {
        let m = sample_visible_normal(self.alpha, wo, [r1, r2]);
        if r3 < self.fresnel(wo.dot(m)) {
            Some(fresnel::reflect(-wo, m)).filter(|wi| wi.z > 0.0)
        } else {
            fresnel::refract(-wo, m, 1.0, self.index).filter(|wi| wi.z < 0.0)
        }
    }

    /// Returns the pdf of [`sample`](Self::sample) with respect to solid angle,
    /// [`crate::equation::ROUGH_GLASS_PDF`], 1/sr.
    #[inline]
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if wi.z > 0.0 {
            let m = (wo + wi).normalize();
            let cosine = wo.dot(m);
            return self.fresnel(cosine) * visible_normal_pdf(self.alpha, wo, m) / (4.0 * cosine);
        }
        refracting(self.index, wo, wi).map_or(0.0, |(m, normals_per_direction)| {
            (1.0 - self.fresnel(wo.dot(m)))
                * visible_normal_pdf(self.alpha, wo, m)
                * normals_per_direction
        })
    }
}

/// Least difference of the indices: below it half vectors lose too many digits.
const LEAST_STEP: f64 = 0.001;
