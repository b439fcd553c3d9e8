//! Check-ups of the diffuse BSDFs (9), (13)-(15) with cosine sampling.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::DVec3;

use crate::bsdf::{Bsdf, OrenNayar, OrenNayarForm};
use crate::equation::{COSINE, LAMBERT, OREN_NAYAR, OREN_NAYAR_CONSTANTS};
use crate::harness::bsdf_checkup::{BsdfSample, BsdfSubject, CheckUp, assertions, check_up};
use crate::harness::chi_square::CELL_DELTA;
use crate::harness::outcome::Outcome;
use crate::harness::trial::Context;
use crate::sampling::{
    cosine_hemisphere, cosine_hemisphere_pdf, uniform_hemisphere, uniform_hemisphere_pdf,
};
use crate::zoo::{AnyFamily, Bench, Family, Mutant, data, mutant};

/// f(wo, wi) in 1/sr.
type Eval = fn(DVec3, DVec3) -> f64;

const RHO: f64 = 0.75;
const SIGMA: f64 = 0.5;
/// The largest directional albedo of correct Oren-Nayar with ρ = 1 (at σ = 0.1985, grazing) is 1.01518.
const OREN_NAYAR_BOUND: f64 = 1.0152;

fn lambert(wo: DVec3, wi: DVec3) -> f64 {
    Bsdf::Lambert {
        albedo: DVec3::splat(RHO),
    }
    .eval(wo, wi)
    .x
}

fn oren_nayar(wo: DVec3, wi: DVec3) -> f64 {
    Bsdf::oren_nayar(DVec3::splat(RHO), SIGMA, OrenNayarForm::Corrected)
        .eval(wo, wi)
        .x
}

fn oren_nayar_printed(wo: DVec3, wi: DVec3) -> f64 {
    Bsdf::oren_nayar(DVec3::splat(RHO), SIGMA, OrenNayarForm::Printed)
        .eval(wo, wi)
        .x
}

/// A BSDF with cosine sampling, weight π f.
pub(super) fn with_cosine_sampling(
    eval: impl Fn(DVec3, DVec3) -> f64 + Copy + Send + Sync + 'static,
) -> BsdfSubject {
    BsdfSubject::new(
        eval,
        move |wo, [r1, r2, _]| {
            let wi = cosine_hemisphere([r1, r2]);
            // r₁ so near 1 that the cosine underflows to 0 has no density: that sample is lost.
            (wi.z > 0.0).then(|| BsdfSample {
                wi,
                weight: PI * eval(wo, wi),
                pdf: cosine_hemisphere_pdf(wi.z),
            })
        },
        |_, wi| cosine_hemisphere_pdf(wi.z),
    )
    .energy_bound(OREN_NAYAR_BOUND)
}

/// A BSDF whose sampler draws uniform directions but claims the cosine pdf.
fn with_wrong_sampling(eval: Eval) -> BsdfSubject {
    BsdfSubject {
        sample: Box::new(move |wo, [r1, r2, _]| {
            let wi = uniform_hemisphere([r1, r2]);
            Some(BsdfSample {
                wi,
                weight: PI * eval(wo, wi),
                pdf: cosine_hemisphere_pdf(wi.z).max(f64::MIN_POSITIVE),
            })
        }),
        ..with_cosine_sampling(eval)
    }
}

/// Directional albedo of correct Oren-Nayar, ρ = 1: A + (2B/π)[sin t (t − sin t cos t)/2 +
/// tan t (1 − sin³ t)/3], t the inclination; radians.
pub fn oren_nayar_albedo(constants: OrenNayar, t: f64) -> f64 {
    let (sin, cos) = t.sin_cos();
    let bracket = sin * (t - sin * cos) / 2.0 + t.tan() * (1.0 - sin.powi(3)) / 3.0;
    constants.a + 2.0 * constants.b * FRAC_1_PI * bracket
}

/// Directional albedo of the printed form, ρ = 1: A + 2B sin t/(3π).
pub fn oren_nayar_printed_albedo(constants: OrenNayar, t: f64) -> f64 {
    constants.a + 2.0 * constants.b * t.sin() / (3.0 * PI)
}

fn inclination(wo: DVec3) -> f64 {
    wo.x.hypot(wo.y).atan2(wo.z)
}

fn lambert_check(context: &Context, subject: BsdfSubject) -> Vec<Outcome> {
    // Twice the usual size, for uniform sampling of Lambert: relative standard deviation 1/√3.
    let size = CheckUp {
        samples: 2 * CheckUp::default().samples,
        ..CheckUp::default()
    };
    check_up(&subject.albedo(|_| RHO), &size, context)
}

fn oren_nayar_check(context: &Context, eval: Eval) -> Vec<Outcome> {
    let subject = with_cosine_sampling(eval)
        .albedo(|wo| RHO * oren_nayar_albedo(OrenNayar::new(SIGMA), inclination(wo)));
    check_up(&subject, &CheckUp::default(), context)
}

fn printed_check(context: &Context, eval: Eval) -> Vec<Outcome> {
    let subject = with_cosine_sampling(eval)
        .albedo(|wo| RHO * oren_nayar_printed_albedo(OrenNayar::new(SIGMA), inclination(wo)));
    check_up(&subject, &CheckUp::default(), context)
}

fn wrong_weight(eval: Eval) -> BsdfSubject {
    BsdfSubject {
        sample: Box::new(move |wo, [r1, r2, _]| {
            let wi = cosine_hemisphere([r1, r2]);
            (wi.z > 0.0).then(|| BsdfSample {
                wi,
                weight: eval(wo, wi),
                pdf: cosine_hemisphere_pdf(wi.z),
            })
        }),
        ..with_cosine_sampling(eval)
    }
}

/// A BSDF with uniform sampling, weight 2π f cos θ.
fn uniform_sampling(eval: Eval) -> BsdfSubject {
    BsdfSubject::new(
        eval,
        move |wo, [r1, r2, _]| {
            let wi = uniform_hemisphere([r1, r2]);
            Some(BsdfSample {
                wi,
                weight: 2.0 * PI * eval(wo, wi) * wi.z,
                pdf: uniform_hemisphere_pdf(wi.z),
            })
        },
        |_, wi| uniform_hemisphere_pdf(wi.z),
    )
}

/// The diffuse models, each replaceable.
#[derive(Clone, Copy)]
pub struct Models {
    /// (13) with cosine sampling.
    pub lambert: fn() -> BsdfSubject,
    /// (13) with uniform sampling.
    pub lambert_uniform: fn() -> BsdfSubject,
    /// (14) with sin α tan β.
    pub oren_nayar: fn(DVec3, DVec3) -> f64,
    /// (14) as printed.
    pub printed: fn(DVec3, DVec3) -> f64,
}

const RIGHT: Models = Models {
    lambert: || with_cosine_sampling(lambert),
    lambert_uniform: || uniform_sampling(lambert),
    oren_nayar,
    printed: oren_nayar_printed,
};

/// (14) as printed with 0.57 for 0.33 in A.
fn printed_with_other_constant(wo: DVec3, wi: DVec3) -> f64 {
    let s2 = SIGMA * SIGMA;
    let constants = OrenNayar {
        a: 1.0 - s2 / (2.0 * (s2 + 0.57)),
        ..OrenNayar::new(SIGMA)
    };
    RHO * FRAC_1_PI * crate::bsdf::oren_nayar(constants, OrenNayarForm::Printed, wo, wi)
}

fn benches() -> Vec<Bench<Models>> {
    let size = CheckUp::default();
    // At so many inclinations all weights are the same, and no chance is in the furnace.
    let trial = |name: &str, property: &str, equation, constant: usize| {
        let subject = "bsdf::Bsdf::eval, sampling::cosine_hemisphere";
        let size = (size.samples, CELL_DELTA, assertions(&size) - constant);
        data(
            format!("bsdf/{name}"),
            property,
            equation,
            subject,
            "BSDF check-up",
            size,
        )
    };
    vec![
        Bench::new(
            trial(
                "lambert",
                "Lambert passes the check-up and its directional albedo is ρ",
                &LAMBERT,
                size.inclinations.len(),
            ),
            |c, models: Models| lambert_check(c, (models.lambert)()),
        ),
        Bench::new(
            trial(
                "cosine",
                "f_r, not f_r cos θ, is what eval returns and what is reciprocal",
                &COSINE,
                0,
            ),
            |c, models: Models| lambert_check(c, (models.lambert_uniform)()),
        ),
        Bench::new(
            trial(
                "oren-nayar",
                "Oren-Nayar passes the check-up and has the directional albedo of sin α tan β",
                &OREN_NAYAR,
                1,
            ),
            |c, models: Models| oren_nayar_check(c, models.oren_nayar),
        ),
        Bench::new(
            trial(
                "oren-nayar-printed",
                "the printed form has its own closed-form albedo: it is not Oren-Nayar",
                &OREN_NAYAR_CONSTANTS,
                1,
            ),
            |c, models: Models| printed_check(c, models.printed),
        ),
    ]
}

fn faults() -> Vec<Mutant<Models>> {
    vec![
        mutant(
            "no-pi",
            &LAMBERT,
            "f = ρ",
            Models {
                lambert: || with_cosine_sampling(|wo, wi| PI * lambert(wo, wi)),
                ..RIGHT
            },
            &["bsdf/lambert"],
        ),
        mutant(
            "uniform-sampler",
            &LAMBERT,
            "uniform directions, cosine pdf",
            Models {
                lambert: || with_wrong_sampling(lambert),
                ..RIGHT
            },
            &["bsdf/lambert"],
        ),
        mutant(
            "weight",
            &LAMBERT,
            "the weight misses π",
            Models {
                lambert: || wrong_weight(lambert),
                ..RIGHT
            },
            &["bsdf/lambert"],
        ),
        mutant(
            "cosine-in-f",
            &COSINE,
            "eval returns f_r cos θ",
            Models {
                lambert_uniform: || uniform_sampling(|wo, wi| lambert(wo, wi) * wi.z),
                ..RIGHT
            },
            &["bsdf/cosine"],
        ),
        mutant(
            "printed",
            &OREN_NAYAR,
            "sin β for tan β, as the report prints",
            Models {
                oren_nayar: oren_nayar_printed,
                ..RIGHT
            },
            &["bsdf/oren-nayar"],
        ),
        mutant(
            "correct-for-printed",
            &OREN_NAYAR,
            "tan β where the printed form is meant",
            Models {
                printed: oren_nayar,
                ..RIGHT
            },
            &["bsdf/oren-nayar-printed"],
        ),
        mutant(
            "constant",
            &OREN_NAYAR_CONSTANTS,
            "0.57 for 0.33 in A",
            Models {
                printed: printed_with_other_constant,
                ..RIGHT
            },
            &["bsdf/oren-nayar-printed"],
        ),
    ]
}

/// The diffuse models.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    vec![Box::new(Family {
        benches: benches(),
        faults: faults(),
        share: 1.0 / 16.0,
        ..Family::new("bsdf", RIGHT)
    })]
}
