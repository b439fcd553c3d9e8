//! Check-ups of the diffuse BSDFs (9), (13)-(15) with cosine sampling.

use whitefurnace::geometry::radiometry::cosine;
use whitefurnace::harness::bsdf_checkup::{
    BsdfSubject, CheckUp, SampledDirection, at_direction, check_up,
};
use whitefurnace::harness::domain::MASS_TOLERANCE;
use whitefurnace::material;
use whitefurnace::material::{OrenNayar, OrenNayarForm};
use whitefurnace::math::frame::from_spherical;
use whitefurnace::sampling::warp::{cosine_hemisphere, uniform_hemisphere};

use crate::prelude::*;
use crate::scenes::lambert;

/// Names an outcome of the check-up at some inclinations, degrees.
macro_rules! at_angles {
    ($trial:literal, $name:literal, $first:literal $(, $more:literal)*) => {
        concat!(
            $trial, ": ", $name, " at ", $first, " degrees"
            $(, " | ", $name, " at ", $more, " degrees")*
        )
    };
}
pub(super) use at_angles;

/// Names an outcome of the check-up at each of its inclinations.
macro_rules! at_every_angle {
    ($trial:literal, $name:literal) => {
        $crate::bsdf::at_angles!($trial, $name, 0, 40, 75, 85)
    };
}
pub(super) use at_every_angle;

/// Names an outcome of the check-up at both of [`two_inclinations`].
macro_rules! at_both_angles {
    ($trial:literal, $name:literal) => {
        $crate::bsdf::at_angles!($trial, $name, 0, 75)
    };
}

const RHO: f64 = 0.75;
const SIGMA: f64 = 0.5;
/// The largest directional albedo of correct Oren-Nayar with ρ = 1 (at σ = 0.1985, grazing) is
/// 1.01518.
const OREN_NAYAR_BOUND: f64 = 1.0152;

fn oren_nayar(form: OrenNayarForm) -> Bsdf {
    Bsdf::oren_nayar(DVec3::splat(RHO), SIGMA, form)
}

/// Wraps a BSDF as paths evaluate and sample it.
pub(super) fn as_rendered(parts: PartTable, bsdf: Bsdf) -> BsdfSubject {
    BsdfSubject::new(
        move |wo, wi| Scattering::brdf(&parts, &bsdf, wo, wi).x,
        move |wo, random| parts.sample_non_delta(&bsdf, wo, random).map(first_channel),
        move |wo, wi| parts.pdf(&bsdf, wo, wi),
    )
    .energy_bound(OREN_NAYAR_BOUND)
}

/// Wraps a BSDF as sampled by uniform directions.
fn uniform_sampled(parts: PartTable, bsdf: Bsdf) -> BsdfSubject {
    BsdfSubject::new(
        move |wo, wi| Scattering::brdf(&parts, &bsdf, wo, wi).x,
        move |wo, [r1, r2, _]| Some(first_channel(parts.sample_uniform(&bsdf, wo, [r1, r2]))),
        move |_, wi| Scattering::uniform_hemisphere_pdf(&parts, wi.z),
    )
}

fn first_channel(sample: material::BsdfSample) -> SampledDirection {
    let pdf = sample.pdf.unwrap_or(f64::NAN);
    SampledDirection {
        wi: sample.direction,
        weight: sample.weight.x,
        pdf,
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

/// Values of a model's parameter and inclinations of wo for which [`integrals`] are computed.
#[derive(Clone, Copy)]
pub(super) struct Cases {
    /// Symbol of the parameter.
    pub symbol: &'static str,
    /// Values of the parameter.
    pub parameters: [f64; 2],
    /// Inclinations of wo.
    pub degrees: [f64; 3],
}

/// Compares an integral over the hemisphere with its known value, over two values of a parameter of
/// a model and three inclinations of wo. The outcome is the largest error.
pub(super) fn integrals(
    name: &str,
    cases: Cases,
    f: impl Fn(f64, DVec3, DVec3) -> f64,
    known: impl Fn(f64, DVec3) -> f64,
) -> Vec<Outcome> {
    let Cases {
        symbol,
        parameters,
        degrees,
    } = cases;
    let pairs = parameters
        .into_iter()
        .flat_map(|parameter| degrees.map(|degrees| (parameter, degrees)));
    let errors = pairs.map(|(parameter, degrees)| {
        let wo = from_spherical(degrees.to_radians(), 0.0);
        let found = Domain::Hemisphere
            .integrate_all(MASS_TOLERANCE, &|w| f(parameter, wo, w))
            .value;
        let error = (found - known(parameter, wo)).abs();
        let error = if error.is_nan() { f64::INFINITY } else { error };
        (
            error,
            format!("{found:.9} at {symbol} = {parameter}, {degrees} degrees"),
        )
    });
    let worst = errors.max_by(|a, b| a.0.total_cmp(&b.0));
    let (error, place) = worst.unwrap_or((f64::NAN, String::new()));
    let n = (parameters.len() * degrees.len()) as u64;
    vec![Outcome::identity(
        name,
        n,
        error,
        2.0 * MASS_TOLERANCE,
        place,
    )]
}

/// The check-up of a diffuse BSDF: its weights vary so little that fewer samples are enough.
pub(super) fn diffuse() -> CheckUp {
    CheckUp {
        samples: 2_250_000,
        ..CheckUp::default()
    }
}

/// The check-up at two inclinations: directions are sampled independently of wo.
fn two_inclinations() -> CheckUp {
    CheckUp {
        inclinations: vec![0.0, 75.0],
        ..diffuse()
    }
}

/// Runs the check-up with an inclination, degrees, and a number of samples of each of these pairs:
/// noise differs between inclinations.
pub(super) fn check_up_sized(
    subject: &BsdfSubject,
    sizes: &[(f64, u64)],
    context: &Context,
) -> Vec<Outcome> {
    let pointwise = CheckUp {
        inclinations: Vec::new(),
        ..CheckUp::default()
    };
    let mut outcomes = check_up(subject, &pointwise, context);
    for (i, &(degrees, samples)) in sizes.iter().enumerate() {
        if context.asks_for(&format!(" at {degrees} degrees")) {
            let wo = from_spherical(degrees.to_radians(), 0.7 + i as f64);
            let size = CheckUp {
                samples,
                ..CheckUp::default()
            };
            outcomes.extend(at_direction(subject, &size, context, wo, degrees));
        }
    }
    outcomes
}

fn lambert_check(context: &Context, subject: BsdfSubject, size: &CheckUp) -> Vec<Outcome> {
    check_up(&subject.albedo(|_| RHO), size, context)
}

fn oren_nayar_check(
    context: &Context,
    parts: PartTable,
    form: OrenNayarForm,
    albedo: fn(OrenNayar, f64) -> f64,
    size: &CheckUp,
) -> Vec<Outcome> {
    let subject = as_rendered(parts, oren_nayar(form))
        .albedo(move |wo| RHO * albedo(OrenNayar::new(SIGMA), inclination(wo)));
    check_up(&subject, size, context)
}

/// cos² in place of cos.
pub(super) fn squared(normal: DVec3, direction: DVec3) -> f64 {
    cosine(normal, direction).powi(2)
}

/// (14) as printed with 0.57 for 0.33 in A.
fn other_constant(wo: DVec3, wi: DVec3) -> f64 {
    let s2 = SIGMA * SIGMA;
    let constants = OrenNayar {
        a: 1.0 - s2 / (2.0 * (s2 + 0.57)),
        ..OrenNayar::new(SIGMA)
    };
    RHO * FRAC_1_PI * material::oren_nayar(constants, OrenNayarForm::Printed, wo, wi)
}

fn trials() -> Vec<FamilyTrial<PartTable>> {
    // Weights are constant at these inclinations, so the furnace is exact, without chance.
    let family_trial =
        |name: &str, property: &str, consequence: &str, equation, on: TrialFn<PartTable>| {
            let subject = "material::Scattering::sample_rough, sample_uniform";
            trial(
                format!("bsdf/{name}"),
                property,
                consequence,
                equation,
                subject,
                "BSDF check-up",
                on,
            )
        };
    vec![
        family_trial(
            "lambert",
            "Lambert passes the check-up and its directional albedo is ρ",
            "matte walls are too bright by π, or their light comes from the wrong directions",
            &LAMBERT,
            |c, parts| lambert_check(c, as_rendered(parts, lambert(RHO)), &two_inclinations()),
        ),
        family_trial(
            "cosine",
            "f_r, not f_r cos θ, is what eval returns and what is reciprocal",
            "matte things are shaded by a cosine too many or too few",
            &COSINE,
            |c, parts| {
                // More than others: relative standard deviation 1/√3.
                let size = CheckUp {
                    samples: 5_750_000,
                    ..two_inclinations()
                };
                lambert_check(c, uniform_sampled(parts, lambert(RHO)), &size)
            },
        ),
        family_trial(
            "oren-nayar",
            "Oren-Nayar passes the check-up and has the directional albedo of sin α tan β",
            "clay and plaster have a wrong shading, as in glslify/glsl-diffuse-oren-nayar#1",
            &OREN_NAYAR,
            |c, parts| {
                let form = OrenNayarForm::Corrected;
                oren_nayar_check(c, parts, form, oren_nayar_albedo, &diffuse())
            },
        ),
        family_trial(
            "oren-nayar-printed",
            "the printed form has its own closed-form albedo: it is not Oren-Nayar",
            "pictures of the report's Oren-Nayar do not show the formula that it prints",
            &OREN_NAYAR_CONSTANTS,
            |c, parts| {
                let form = OrenNayarForm::Printed;
                oren_nayar_check(
                    c,
                    parts,
                    form,
                    oren_nayar_printed_albedo,
                    &two_inclinations(),
                )
            },
        ),
    ]
}

fn faults() -> Vec<Fault<PartTable>> {
    vec![
        fault!("no-pi", LAMBERT, "f = ρ",
            PartTable: { brdf: |bsdf, wo, wi| PI * bsdf.eval(wo, wi) },
            "bsdf/lambert: directional albedo at 0 degrees"),
        fault!("uniform-sampler", COSINE_HEMISPHERE, "uniform directions, cosine pdf",
            PartTable: { cosine_hemisphere: uniform_hemisphere },
            at_both_angles!("bsdf/lambert", "chi-square of samples"),
            at_every_angle!("bsdf/oren-nayar", "chi-square of samples"),
            at_both_angles!("bsdf/oren-nayar-printed", "chi-square of samples")),
        fault!("cosine-sampler", HEMISPHERE_THETA, "cosine directions, uniform pdf",
            PartTable: { uniform_hemisphere: cosine_hemisphere },
            at_both_angles!("bsdf/cosine", "chi-square of samples")),
        fault!("cosine-twice", COSINE, "the weight has the cosine twice",
            PartTable: { cosine: squared },
            at_both_angles!("bsdf/lambert", "furnace"), at_both_angles!("bsdf/cosine", "furnace"),
            at_every_angle!("bsdf/oren-nayar", "furnace"), at_both_angles!("bsdf/oren-nayar-printed", "furnace")),
        fault!("cosine-in-f", COSINE, "eval returns f_r cos θ",
            PartTable: { brdf: |bsdf, wo, wi| bsdf.eval(wo, wi) * wi.z },
            "bsdf/cosine: reciprocity | directional albedo at 0 degrees"),
        fault!("printed", OREN_NAYAR, "sin β for tan β, as the report prints",
            PartTable: { brdf: |_, wo, wi| oren_nayar(OrenNayarForm::Printed).eval(wo, wi) },
            "bsdf/oren-nayar: directional albedo at 75 degrees"),
        fault!("correct-for-printed", OREN_NAYAR, "tan β where the printed form is meant",
            PartTable: { brdf: |_, wo, wi| oren_nayar(OrenNayarForm::Corrected).eval(wo, wi) },
            "bsdf/oren-nayar-printed: directional albedo at 75 degrees"),
        fault!("constant", OREN_NAYAR_CONSTANTS, "0.57 for 0.33 in A",
            PartTable: { brdf: |_, wo, wi| DVec3::splat(other_constant(wo, wi)) },
            "bsdf/oren-nayar-printed: directional albedo at 0 degrees"),
    ]
}

/// Trials and faults of the diffuse models.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    vec![Box::new(Family {
        trials: trials(),
        faults: faults(),
        ..Family::new("bsdf", CORRECT)
    })]
}
