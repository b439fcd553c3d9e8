//! Reflection models: Lambert (13), Oren-Nayar (14)-(15) in two forms, [EON](eon), mirror, glass,
//! [rough glass](rough_glass), and user-defined models; sampling of scattered directions.
//!
//! Directions are local unit vectors that point away from the surface; the normal is z.

pub mod eon;
pub mod fresnel;
pub mod ggx;
pub mod named;
pub mod rough_glass;
mod scattering;

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;
use rand::Rng;

pub use scattering::{BsdfSample, DefaultParts, Model, Scattering, Vertex};

use crate::math::real::{Real, Vector};
use named::NamedModel;
use rough_glass::RoughGlass;

/// The models that scene files know, by name.
pub const MODELS: [NamedModel; 8] = [
    named::BLACK,
    named::LAMBERT,
    named::OREN_NAYAR,
    eon::NAMED,
    named::MIRROR,
    named::GLASS,
    rough_glass::NAMED,
    ggx::NAMED,
];

/// A reflection model. Albedos are per colour channel, in [0, 1].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bsdf {
    /// Reflects nothing.
    Black,
    /// Lambert's model (13).
    Lambert {
        /// ρ.
        albedo: DVec3,
    },
    /// Oren-Nayar, (14) and (15).
    OrenNayar {
        /// ρ.
        albedo: DVec3,
        /// A and B of (15).
        constants: OrenNayar,
        /// Form of (14).
        form: OrenNayarForm,
    },
    /// Energy-preserving Oren-Nayar, [`eon`].
    Eon {
        /// ρ, the albedo of single scattering on a facet.
        albedo: DVec3,
        /// r in [0, 1].
        roughness: f64,
    },
    /// A perfect mirror.
    Mirror {
        /// Fraction of radiance that is reflected.
        reflectance: DVec3,
    },
    /// Smooth glass in air (index 1), without absorption.
    Glass {
        /// Index of refraction on the inner side of the surface.
        index: f64,
    },
    /// Rough glass in air, without absorption: of all estimators only
    /// [`Path`](crate::integrator::Path) renders it.
    RoughGlass(RoughGlass),
    /// A user-defined model: [`Bsdf::model`].
    Model(&'static dyn Model),
}

/// The two forms of (14).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum OrenNayarForm {
    /// sin α tan β, Oren and Nayar 1994.
    #[default]
    Corrected,
    /// sin α sin β, as the report prints it: not Oren-Nayar.
    Printed,
}

/// A and B of (15), [`crate::equation::OREN_NAYAR_CONSTANTS`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrenNayar<R = f64> {
    /// A.
    pub a: R,
    /// B.
    pub b: R,
}

impl OrenNayar {
    /// Returns the constants of a surface whose facets' slope angle has standard deviation σ ≥ 0,
    /// radians.
    pub fn new(sigma: f64) -> Self {
        let s2 = sigma * sigma;
        Self {
            a: 1.0 - s2 / (2.0 * (s2 + 0.33)),
            b: 0.45 * s2 / (s2 + 0.09),
        }
    }

    /// Returns the roughness B/A, in [0, 0.9), of the EON model whose single scattering has the
    /// same shape: both are in proportion to 1 + (B/A) s/t where s > 0.
    pub fn roughness(self) -> f64 {
        self.b / self.a
    }
}

/// Returns f_r of (13), [`crate::equation::LAMBERT`], 1/sr.
#[inline]
pub fn lambert<V: Vector>(albedo: V) -> V {
    albedo * V::Real::splat(FRAC_1_PI)
}

/// Returns the bracket of (14), π f_r/ρ, in the angles in which it is printed;
/// [`crate::equation::OREN_NAYAR`].
///
/// Inclinations in [0, π/2), `azimuth` = φ_in − φ_out, radians.
pub fn oren_nayar_angles(
    constants: OrenNayar,
    form: OrenNayarForm,
    theta_in: f64,
    theta_out: f64,
    azimuth: f64,
) -> f64 {
    let alpha = theta_in.max(theta_out);
    let beta = theta_in.min(theta_out);
    let last = match form {
        OrenNayarForm::Corrected => beta.tan(),
        OrenNayarForm::Printed => beta.sin(),
    };
    constants.a + constants.b * azimuth.cos().max(0.0) * alpha.sin() * last
}

/// Returns the bracket of (14) without angles, as the renderer evaluates it: sin θ_in sin θ_out cos
/// Δφ is the scalar product of the tangential parts, and tan β = sin β / max(cos θ_in, cos θ_out).
#[inline]
pub fn oren_nayar<V: Vector>(
    constants: OrenNayar<V::Real>,
    form: OrenNayarForm,
    wo: V,
    wi: V,
) -> V::Real {
    let [[x1, y1, z1], [x2, y2, z2]] = [wo.components(), wi.components()];
    let tangential = (x1 * x2 + y1 * y2).maximum(V::Real::splat(0.0));
    let last = match form {
        OrenNayarForm::Corrected => tangential / z1.maximum(z2),
        OrenNayarForm::Printed => tangential,
    };
    constants.a + constants.b * last
}

impl Bsdf {
    /// Creates a user-defined model. It lives as long as the program.
    pub fn model(model: impl Model + 'static) -> Self {
        Self::Model(Box::leak(Box::new(model)))
    }

    /// Creates Oren-Nayar with the given albedo, σ in radians, and form.
    pub fn oren_nayar(albedo: DVec3, sigma: f64, form: OrenNayarForm) -> Self {
        Self::OrenNayar {
            albedo,
            constants: OrenNayar::new(sigma),
            form,
        }
    }

    /// Returns whether scattering is by Dirac distributions only: mirror and glass. Next-event
    /// estimation contributes nothing there.
    #[inline]
    pub(crate) fn is_specular(&self) -> bool {
        matches!(self, Self::Mirror { .. } | Self::Glass { .. })
    }

    /// Returns whether it is smooth glass, which some shadow rays pass.
    pub(crate) fn is_glass(&self) -> bool {
        matches!(self, Self::Glass { .. })
    }

    /// Returns whether the model has a density, so that shadow rays and connections contribute.
    #[inline]
    pub fn is_non_delta(&self) -> bool {
        !matches!(self, Self::Black | Self::Mirror { .. } | Self::Glass { .. })
    }

    /// Returns whether light is transmitted in all directions.
    #[inline]
    pub fn is_rough_glass(&self) -> bool {
        matches!(self, Self::RoughGlass(_))
    }

    /// Returns the model for directions relative to the side from which a ray came.
    #[inline]
    pub(crate) fn oriented(&self, outside: bool) -> Self {
        match *self {
            Self::RoughGlass(glass) => Self::RoughGlass(glass.oriented(outside)),
            other => other,
        }
    }

    /// Returns whether directions are sampled by their cosine, independently of the other
    /// direction.
    #[inline]
    pub(crate) fn is_sampled_by_cosine(&self) -> bool {
        matches!(
            self,
            Self::Lambert { .. } | Self::OrenNayar { .. } | Self::Eon { .. }
        )
    }

    /// Samples a local direction of a model that is not sampled by the cosine, from uniform
    /// numbers, of which the third counts for rough glass alone; `None` where the model has no
    /// density.
    #[inline]
    pub(crate) fn sample_direction(&self, wo: DVec3, random: [f64; 3]) -> Option<DVec3> {
        match self {
            Self::Model(model) => model.sample(wo, [random[0], random[1]]),
            Self::RoughGlass(glass) if wo.z > 0.0 => glass.sample(wo, random),
            _ => None,
        }
    }

    /// Returns f_r(wo, wi) in 1/sr; zero for mirror and glass, whose light is concentrated in
    /// single directions, and below the horizon except for rough glass, which must be
    /// [`oriented`](RoughGlass::oriented) wo.
    #[inline]
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        if wo.z <= 0.0 || (wi.z <= 0.0 && !self.is_rough_glass()) {
            return DVec3::ZERO;
        }
        match *self {
            Self::Lambert { albedo } => lambert(albedo),
            Self::OrenNayar {
                albedo,
                constants,
                form,
            } => lambert(albedo) * oren_nayar(constants, form, wo, wi),
            Self::Eon { albedo, roughness } => FRAC_1_PI * eon::eon(albedo, roughness, wo, wi),
            Self::Black | Self::Mirror { .. } | Self::Glass { .. } => DVec3::ZERO,
            Self::RoughGlass(glass) => DVec3::splat(glass.eval(wo, wi)),
            Self::Model(model) => model.eval(wo, wi),
        }
    }

    /// Samples a scattered direction at a vertex, in world space; `None` where light is absorbed.
    #[inline]
    pub fn sample(&self, at: &Vertex, rng: &mut dyn Rng) -> Option<BsdfSample> {
        DefaultParts.sample(self, at, rng)
    }

    /// Returns the pdf of [`sample`](Self::sample) with respect to solid angle, 1/sr, for local
    /// directions; 0 for mirror and glass.
    #[inline]
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        DefaultParts.pdf(self, wo, wi)
    }

    /// Returns the albedo for a denoiser: ρ of the models with a density, the reflectance of a
    /// mirror, 1 for glass.
    pub fn albedo(&self) -> DVec3 {
        match *self {
            Self::Black => DVec3::ZERO,
            Self::Lambert { albedo }
            | Self::OrenNayar { albedo, .. }
            | Self::Eon { albedo, .. } => albedo,
            Self::Mirror { reflectance } => reflectance,
            Self::Glass { .. } | Self::RoughGlass(_) => DVec3::ONE,
            Self::Model(model) => model.albedo(),
        }
    }
}
