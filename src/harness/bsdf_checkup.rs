//! Complete check of one BSDF in one call, for any BSDF with a density, given as closures. For
//! mirrors and glass, whose light goes into single directions, see [`check_up_lobes`].
//!
//! # Example: a microfacet conductor that is not ours
//!
//! Trowbridge-Reitz (GGX) with visible-normal sampling (Heitz, JCGT 7(4), 2018), perfectly
//! reflecting facets. Samples that leave below the horizon are lost, so the pdf integrates to less
//! than one.
//!
//! ```
//! use whitefurnace::glam::DVec3;
//! use std::f64::consts::{PI, TAU};
//! use whitefurnace::harness::bsdf_checkup::{SampledDirection, BsdfSubject, CheckUp, Loss,
//! check_up}; use whitefurnace::harness::outcome::Verdict; use
//! whitefurnace::harness::trial::Context;
//!
//! const ALPHA: f64 = 0.5;
//! fn lambda(w: DVec3) -> f64 {
//!     let tan2 = (w.x * w.x + w.y * w.y) / (w.z * w.z);
//!     0.5 * ((1.0 + ALPHA * ALPHA * tan2).sqrt() - 1.0)
//! }
//! fn distribution(h: DVec3) -> f64 {
//!     let d = (h.x * h.x + h.y * h.y) / (ALPHA * ALPHA) + h.z * h.z;
//!     1.0 / (PI * ALPHA * ALPHA * d * d)
//! }
//! fn eval(wo: DVec3, wi: DVec3) -> f64 {
//!     if wo.z <= 0.0 || wi.z <= 0.0 { return 0.0; }
//!     let g2 = 1.0 / (1.0 + lambda(wo) + lambda(wi));
//!     distribution((wo + wi).normalize()) * g2 / (4.0 * wo.z * wi.z)
//! }
//! fn pdf(wo: DVec3, wi: DVec3) -> f64 {
//!     if wo.z <= 0.0 || wi.z <= 0.0 { return 0.0; }
//!     distribution((wo + wi).normalize()) / (1.0 + lambda(wo)) / (4.0 * wo.z)
//! }
//! fn sample(wo: DVec3, [r1, r2, _]: [f64; 3]) -> Option<SampledDirection> {
//!     let v = DVec3::new(ALPHA * wo.x, ALPHA * wo.y, wo.z).normalize();
//!     let across = v.x.hypot(v.y);
//!     let t1 = if across > 0.0 { DVec3::new(-v.y, v.x, 0.0) / across } else { DVec3::X };
//!     let t2 = v.cross(t1);
//!     let (radius, (sin, cos)) = (r1.sqrt(), (TAU * r2).sin_cos());
//!     let s = 0.5 * (1.0 + v.z);
//!     let a = radius * cos;
//!     let b = (1.0 - s) * (1.0 - a * a).sqrt() + s * radius * sin;
//!     let n = a * t1 + b * t2 + (1.0 - a * a - b * b).max(0.0).sqrt() * v;
//!     let h = DVec3::new(ALPHA * n.x, ALPHA * n.y, n.z).normalize();
//!     let wi = 2.0 * wo.dot(h) * h - wo;
//!     (wi.z > 0.0).then(|| SampledDirection {
//!         wi,
//!         // f cos/pdf = G₂/G₁, derived on its own.
//!         weight: (1.0 + lambda(wo)) / (1.0 + lambda(wo) + lambda(wi)),
//!         pdf: pdf(wo, wi),
//!     })
//! }
//!
//! let subject = BsdfSubject::new(eval, sample, pdf).loss(Loss::Allowed).energy_bound(1.0);
//! let context = Context::new(2019, 1.0).unwrap().named("my GGX");
//! for outcome in check_up(&subject, &CheckUp::default(), &context) {
//!     assert_eq!(outcome.verdict(), Verdict::Holds, "{}: {}", outcome.name, outcome.worst);
//! }
//! ```
//!
//! # Example: single precision, own vector type
//!
//! Lambert in `f32`. The check-up finds from its values that it computes in single precision;
//! [`CheckUp::roundoff`] states it explicitly. Bounds then follow from the conditioning of the
//! functions, up to half a percent, so that an error of one percent is detected.
//!
//! ```
//! use whitefurnace::glam::DVec3;
//! use std::f32::consts::{FRAC_1_PI, TAU};
//! use whitefurnace::harness::bsdf_checkup::{BsdfSubject, CheckUp, SampledDirection, check_up};
//! use whitefurnace::harness::trial::{Context, assert_holds};
//!
//! struct Vec3 { x: f32, y: f32, z: f32 }
//! fn mine(w: DVec3) -> Vec3 {
//!     Vec3 { x: w.x as f32, y: w.y as f32, z: w.z as f32 }
//! }
//! fn theirs(w: Vec3) -> DVec3 {
//!     DVec3::new(w.x.into(), w.y.into(), w.z.into())
//! }
//!
//! const ALBEDO: f32 = 0.7;
//! fn eval(_: Vec3, wi: Vec3) -> f32 {
//!     if wi.z > 0.0 { ALBEDO * FRAC_1_PI } else { 0.0 }
//! }
//! fn pdf(_: Vec3, wi: Vec3) -> f32 {
//!     wi.z.max(0.0) * FRAC_1_PI
//! }
//! fn sample(_: Vec3, [u, v]: [f32; 2]) -> (Vec3, f32, f32) {
//!     let (r, phi, z) = (u.sqrt(), TAU * v, (1.0 - u).sqrt());
//!     (Vec3 { x: r * phi.cos(), y: r * phi.sin(), z }, ALBEDO, z * FRAC_1_PI)
//! }
//!
//! let subject = BsdfSubject::new(
//!     |wo, wi| eval(mine(wo), mine(wi)).into(),
//!     |wo, [u, v, _]| {
//!         let (wi, weight, pdf) = sample(mine(wo), [u as f32, v as f32]);
//!         Some(SampledDirection { wi: theirs(wi), weight: weight.into(), pdf: pdf.into() })
//!     },
//!     |wo, wi| pdf(mine(wo), mine(wi)).into(),
//! );
//! let context = Context::new(2019, 1.0).unwrap().named("my Lambert");
//! assert_holds(&check_up(&subject, &CheckUp::default(), &context));
//! ```

mod lobes;
mod sampled;
mod values;

use glam::DVec3;

use super::copied;
use super::domain::Domain;
use super::outcome::Outcome;
use super::pointwise::{
    LargestError, MIN_COSINE, ONE_MINUS_EPSILON, fuzzed_direction, fuzzed_number, inner_direction,
    uniform3,
};
use super::roundoff::{ARGUMENT_STEP, RoundoffBounds, unit_roundoff};
use super::trial::Context;
use crate::material::{Bsdf, DefaultParts, Scattering};
use crate::math::frame::from_spherical;
use crate::sampling::rng::Stream;
pub use lobes::{Lobe, LobeSample, LobeSubject, check_up_lobes};
pub use sampled::at_direction;
use values::{FINITE, RECIPROCITY, WEIGHTS, check_finite, check_reciprocity, check_weights};

/// A direction drawn by a BSDF's sampler.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampledDirection {
    /// The sampled direction, unit, pointing away from the surface.
    pub wi: DVec3,
    /// Factor of the path's throughput: f |cos θᵢ| / pdf.
    pub weight: f64,
    /// The pdf of `wi` with respect to solid angle, 1/sr.
    pub pdf: f64,
}

/// How many samples a sampler may lose (return `None`).
pub enum Loss {
    /// None: the pdf integrates to one.
    None,
    /// This fraction, for each wo, known independently of the pdf.
    Declared(Box<dyn Fn(DVec3) -> f64 + Send + Sync>),
    /// As many as the pdf's integral, at most one, implies.
    Allowed,
}

impl Loss {
    /// Returns how far the integral of the pdf for wo is from an allowed value.
    pub(super) fn error(&self, integral: f64, wo: DVec3) -> f64 {
        match self {
            Self::None => (integral - 1.0).abs(),
            Self::Declared(loss) => (integral - (1.0 - loss(copied(wo)))).abs(),
            Self::Allowed => (integral - 1.0).max(0.0),
        }
    }
}

type Eval = Box<dyn Fn(DVec3, DVec3) -> f64 + Send + Sync>;
type Sample = Box<dyn Fn(DVec3, [f64; 3]) -> Option<SampledDirection> + Send + Sync>;

/// A BSDF under trial, one colour channel. Directions are local unit vectors that point away from
/// the surface; the normal is z.
pub struct BsdfSubject {
    /// f(wo, wi), 1/sr, without the cosine.
    pub eval: Eval,
    /// Draws wi for wo from three uniform numbers in [0, 1).
    pub sample: Sample,
    /// The pdf of wi given wo, with respect to solid angle, 1/sr.
    pub pdf: Eval,
    /// Whether f(wo, wi) = f(wi, wo) must hold. Refraction does not.
    pub reciprocal: bool,
    /// Whether light may leave through the other side, so that the domain is the sphere.
    pub transmits: bool,
    /// How many samples the sampler may lose.
    pub loss: Loss,
    /// Bound of every directional albedo. Correct Oren-Nayar exceeds 1 by up to 1.52 %.
    pub energy_bound: f64,
    /// The directional albedo, where it is known in closed form.
    pub albedo: Option<Box<dyn Fn(DVec3) -> f64 + Send + Sync>>,
}

impl BsdfSubject {
    /// Creates a reciprocal BSDF of the upper hemisphere whose sampler loses nothing, with energy
    /// bound 1; the methods below change that.
    pub fn new(
        eval: impl Fn(DVec3, DVec3) -> f64 + Send + Sync + 'static,
        sample: impl Fn(DVec3, [f64; 3]) -> Option<SampledDirection> + Send + Sync + 'static,
        pdf: impl Fn(DVec3, DVec3) -> f64 + Send + Sync + 'static,
    ) -> Self {
        Self {
            eval: Box::new(eval),
            sample: Box::new(sample),
            pdf: Box::new(pdf),
            reciprocal: true,
            transmits: false,
            loss: Loss::None,
            energy_bound: 1.0,
            albedo: None,
        }
    }

    /// Wraps a renderer's model, with the sampler and pdf that every estimator calls; first colour
    /// channel.
    pub fn of(bsdf: Bsdf) -> Self {
        Self::new(
            move |wo, wi| bsdf.eval(wo, wi).x,
            move |wo, random| {
                let sample = DefaultParts.sample_non_delta(&bsdf, wo, random)?;
                Some(SampledDirection {
                    wi: sample.direction,
                    weight: sample.weight.x,
                    pdf: sample.pdf?,
                })
            },
            move |wo, wi| bsdf.pdf(wo, wi),
        )
    }

    /// Sets whether f(wo, wi) = f(wi, wo) must hold.
    pub fn reciprocal(self, reciprocal: bool) -> Self {
        Self { reciprocal, ..self }
    }

    /// Sets whether light may leave through the other side.
    pub fn transmits(self, transmits: bool) -> Self {
        Self { transmits, ..self }
    }

    /// Sets how many samples the sampler may lose.
    pub fn loss(self, loss: Loss) -> Self {
        Self { loss, ..self }
    }

    /// Sets the bound of all directional albedos.
    pub fn energy_bound(self, energy_bound: f64) -> Self {
        Self {
            energy_bound,
            ..self
        }
    }

    /// Sets the closed form of the directional albedo.
    pub fn albedo(self, albedo: impl Fn(DVec3) -> f64 + Send + Sync + 'static) -> Self {
        Self {
            albedo: Some(Box::new(albedo)),
            ..self
        }
    }

    fn eval(&self, wo: DVec3, wi: DVec3) -> f64 {
        (self.eval)(copied(wo), copied(wi))
    }

    fn sample(&self, wo: DVec3, random: [f64; 3]) -> Option<SampledDirection> {
        (self.sample)(copied(wo), copied(random))
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        (self.pdf)(copied(wo), copied(wi))
    }

    /// Returns f(wo, wi) |cos θᵢ|.
    fn f_cos(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.eval(wo, wi) * wi.z.abs()
    }

    fn domain(&self) -> Domain {
        if self.transmits {
            Domain::Sphere
        } else {
            Domain::Hemisphere
        }
    }
}

/// The size of a check-up at scale 1.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckUp {
    /// Inclinations of wo, degrees from the normal, for chi-square, albedo and furnace; above 90,
    /// for a BSDF that transmits, wo is on the other side.
    pub inclinations: Vec<f64>,
    /// Samples of each chi-square test and furnace.
    pub samples: u64,
    /// Number of cells of each chi-square test.
    pub cells: usize,
    /// Number of random pairs of directions of the pointwise checks.
    pub pairs: u64,
    /// δ of the furnace means, relative to the albedo.
    pub delta: f64,
    /// Unit roundoff of the arithmetic in which the subject computes:
    /// [`SINGLE`](super::roundoff::SINGLE) or [`DOUBLE`](super::roundoff::DOUBLE). `None`: single
    /// precision if its values show it, else double. Bounds of single precision follow from the
    /// conditioning of the subject.
    pub roundoff: Option<f64>,
}

impl Default for CheckUp {
    fn default() -> Self {
        Self {
            // Normal incidence, the middle, and as near grazing as the skewness of a furnace's
            // values allows.
            inclinations: vec![0.0, 40.0, 75.0, 85.0],
            samples: 4_000_000,
            cells: 6,
            pairs: 20_000,
            delta: 0.003,
            roundoff: None,
        }
    }
}

impl CheckUp {
    /// Returns the bounds for the precision that is stated, or else found.
    fn rounding(&self, find_roundoff: impl FnOnce() -> f64) -> RoundoffBounds {
        RoundoffBounds::new(self.roundoff.unwrap_or_else(find_roundoff))
    }
}

/// Returns the largest number of [`check_up`]'s outcomes that are random.
pub fn assertions(size: &CheckUp) -> usize {
    2 * size.inclinations.len()
}

/// Checks all that can be asked of a BSDF without a scene: no NaN, negative or infinite values on a
/// fuzzed domain; reciprocity; pointwise, the sampler's weight = f cos/pdf and reported pdf = pdf;
/// and for each inclination the pdf's integral, chi-square of the sampler, the directional albedo
/// against its closed form and bound, and the furnace (mean weight) against the albedo by
/// quadrature.
pub fn check_up(subject: &BsdfSubject, size: &CheckUp, context: &Context) -> Vec<Outcome> {
    let rounding = size.rounding(|| find_roundoff(subject, context));
    let size = &CheckUp {
        roundoff: Some(rounding.unit()),
        ..size.clone()
    };
    let mut outcomes = Vec::new();
    if context.asks_for(FINITE) {
        let rng = &mut context.rng("sane");
        outcomes.push(check_finite(subject, size, rounding, rng));
    }
    if context.asks_for(WEIGHTS) {
        let rng = &mut context.rng("weights");
        outcomes.push(check_weights(subject, size, rounding, rng));
    }
    if subject.reciprocal && context.asks_for(RECIPROCITY) {
        let rng = &mut context.rng("reciprocity");
        outcomes.push(check_reciprocity(subject, size, rounding, rng));
    }
    for (i, &degrees) in size.inclinations.iter().enumerate() {
        if !context.asks_for(&format!(" at {degrees} degrees")) {
            continue;
        }
        // An azimuth that favours no axis and is not the same twice.
        let wo = from_spherical(degrees.to_radians(), 0.7 + i as f64);
        outcomes.extend(at_direction(subject, size, context, wo, degrees));
    }
    outcomes
}

/// Largest number of pairs of directions from which a subject's precision is found.
const PRECISION_PAIRS: u64 = 400;

/// Returns the unit roundoff found from the subject's values.
fn find_roundoff(subject: &BsdfSubject, context: &Context) -> f64 {
    let rng = &mut context.rng("precision");
    let mut quantities = [(); 7].map(|()| Vec::new());
    for _ in 0..PRECISION_PAIRS {
        let [wo, wi] = [(); 2].map(|()| inner_direction(rng, subject.transmits));
        let stepped = wi + DVec3::splat(ARGUMENT_STEP);
        quantities[0].push([subject.eval(wo, wi), subject.eval(wo, stepped)]);
        quantities[1].push([subject.pdf(wo, wi), subject.pdf(wo, stepped)]);
        let random = uniform3(rng);
        let samples =
            [random, random.map(|u| u + ARGUMENT_STEP)].map(|random| subject.sample(wo, random));
        if let [Some(a), Some(b)] = samples {
            let values = |s: SampledDirection| [s.wi.x, s.wi.y, s.wi.z, s.weight, s.pdf];
            for ((quantity, a), b) in quantities[2..].iter_mut().zip(values(a)).zip(values(b)) {
                quantity.push([a, b]);
            }
        }
    }
    unit_roundoff(&quantities)
}
