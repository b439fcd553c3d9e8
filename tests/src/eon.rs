//! EON under check-ups by sampling and in furnaces by quadrature.

use whitefurnace::harness::bsdf_checkup::check_up;
use whitefurnace::harness::domain::MASS_TOLERANCE;
use whitefurnace::material::eon::{
    MAX_G_OVER_PI, albedo, average_albedo, coefficient_a, multiple_albedo, multiple_scattering,
    single_scattering,
};
use whitefurnace::math::frame::from_spherical;
use whitefurnace::sampling::warp::uniform_hemisphere;

use crate::bsdf::{Cases, as_rendered, at_every_angle, diffuse, integrals, squared};
use crate::prelude::*;
use crate::subject;

/// The functions of the model, so that each can be replaced; one channel.
#[derive(Clone, Copy)]
pub struct EonParts {
    /// f_r of both lobes, and its sampling.
    pub lobes: PartTable,
    /// π f_r/ρ of single scattering from r, wo and wi.
    pub single: fn(f64, DVec3, DVec3) -> f64,
    /// E(θ) from r and cos θ.
    pub albedo: fn(f64, f64) -> f64,
}

impl EonParts {
    /// Evaluates f_r from ρ, r, wo and wi.
    fn eval(self, rho: f64, roughness: f64, wo: DVec3, wi: DVec3) -> f64 {
        (self.lobes.brdf)(&material(rho, roughness), wo, wi).x
    }
}

fn material(rho: f64, roughness: f64) -> Bsdf {
    let albedo = DVec3::splat(rho);
    Bsdf::Eon { albedo, roughness }
}

/// The program's functions.
const CORRECT: EonParts = EonParts {
    lobes: subject::CORRECT,
    single: single_scattering,
    albedo,
};

/// f_r of both lobes, the second with another albedo.
fn coloured(rho: f64, r: f64, wo: DVec3, wi: DVec3, multiple: f64) -> f64 {
    if wo.z <= 0.0 || wi.z <= 0.0 {
        return 0.0;
    }
    FRAC_1_PI * (rho * single_scattering(r, wo, wi) + multiple * multiple_scattering(r, wo, wi))
}

const ROUGHNESS: [f64; 2] = [0.3, 1.0];
/// Symbol and values of the roughness, and inclinations of wo in degrees. The azimuth of wo is 0:
/// there s changes sign where the quadrature's parts meet.
const CASES: Cases = Cases {
    symbol: "r",
    parameters: ROUGHNESS,
    degrees: [0.0, 50.0, 85.0],
};

/// Albedo of the coloured furnace and of the check-up.
const RHO: f64 = 0.5;

/// Reflected radiance of both lobes under a white sky: ρ E + ρₘ (1 − E), where ρₘ is summed as a
/// series: the fraction 1 − Ē of the light that was reflected once stays and is reflected with ρ
/// again.
fn reflected(roughness: f64, wo: DVec3) -> f64 {
    let [e, average] = [albedo(roughness, wo.z), average_albedo(roughness)];
    let mut multiple = 0.0;
    let mut order = RHO * RHO * average;
    while order > 1e-17 {
        multiple += order;
        order *= RHO * (1.0 - average);
    }
    RHO * e + multiple * (1.0 - e)
}

fn trials() -> Vec<FamilyTrial<EonParts>> {
    let family_trial = |name: &str,
                        property: &str,
                        consequence: &str,
                        equation: &'static Equation,
                        subject,
                        on: TrialFn<EonParts>| {
        trial(
            format!("bsdf/{name}"),
            property,
            consequence,
            equation,
            subject,
            "exact",
            on,
        )
    };
    vec![
        trial(
            "bsdf/eon",
            "white EON passes the check-up and its directional albedo is 1",
            "rough plaster as the renderer samples it is too bright, too dark or noisy",
            &EON_MULTIPLE,
            "material::Scattering::sample_rough",
            "BSDF check-up",
            |context, parts: EonParts| {
                let subject = as_rendered(parts.lobes, material(1.0, 0.3))
                    .energy_bound(1.0)
                    .albedo(|_| 1.0);
                check_up(&subject, &diffuse(), context)
            },
        ),
        family_trial(
            "eon-white",
            "white EON reflects all light, at every angle and roughness",
            "white plaster turns grey as it gets rougher, or glows at some angles",
            &EON_MULTIPLE,
            "material::Bsdf::eval",
            |_, parts| {
                integrals(
                    "white furnace",
                    CASES,
                    |r, wo, wi| parts.eval(1.0, r, wo, wi) * wi.z,
                    |_, _| 1.0,
                )
            },
        ),
        family_trial(
            "eon-coloured",
            "EON of albedo 0.5 reflects the sum of all orders of scattering",
            "rough coloured clay is too pale or too saturated",
            &EON_MULTIPLE,
            "material::Bsdf::eval",
            |_, parts| {
                integrals(
                    "coloured furnace",
                    CASES,
                    |r, wo, wi| parts.eval(RHO, r, wo, wi) * wi.z,
                    reflected,
                )
            },
        ),
        family_trial(
            "eon-single",
            "single scattering loses nothing at grazing: its albedo at 89.9999° is 1 within 1e-5",
            "rough things have dark rims where they turn away from the eye",
            &EON_SINGLE,
            "material::eon::single_scattering",
            |_, parts| grazing(parts),
        ),
        family_trial(
            "eon-albedo",
            "the closed form of the directional albedo is the integral of single scattering",
            "rough things get too much or too little light back between their facets",
            &EON_ALBEDO,
            "material::eon::albedo",
            |_, parts| {
                let f = |r, wo, wi: DVec3| FRAC_1_PI * (parts.single)(r, wo, wi) * wi.z;
                integrals("single scattering", CASES, f, |r, wo| {
                    (parts.albedo)(r, wo.z)
                })
            },
        ),
    ]
}

/// Tests that 1 − E(θ) = A r (c − G/π) falls in proportion to cos θ: at 89.9999° it is below 2 ×
/// 10⁻⁶.
fn grazing(parts: EonParts) -> Vec<Outcome> {
    let wo = from_spherical(89.9999_f64.to_radians(), 0.0);
    let lost = ROUGHNESS.map(|r| {
        let f = |wi: DVec3| FRAC_1_PI * (parts.single)(r, wo, wi) * wi.z;
        (1.0 - Domain::Hemisphere.integrate_all(MASS_TOLERANCE, &f).value).abs()
    });
    let worst = lost.into_iter().fold(0.0, f64::max);
    let statement = format!("1 − E = {lost:?} for r = {ROUGHNESS:?}");
    vec![Outcome::identity("grazing", 3, worst, 1e-5, statement)]
}

/// Replaces the lobes by an f_r of ρ, r, wo and wi.
macro_rules! with {
    (|$rho:pat_param, $r:ident, $wo:ident, $wi:ident| $f:expr) => {
        EonParts {
            lobes: PartTable {
                brdf: |bsdf, $wo, $wi| {
                    let &Bsdf::Eon {
                        albedo: DVec3 { x: $rho, .. },
                        roughness: $r,
                    } = bsdf
                    else {
                        return DVec3::ZERO;
                    };
                    DVec3::splat($f)
                },
                ..subject::CORRECT
            },
            ..CORRECT
        }
    };
}

fn faults() -> Vec<Fault<EonParts>> {
    vec![
        fault!("uniform-sampler", COSINE_HEMISPHERE, "uniform directions, cosine pdf",
            EonParts: { lobes: PartTable { cosine_hemisphere: uniform_hemisphere, ..subject::CORRECT } },
            at_every_angle!("bsdf/eon", "chi-square of samples")),
        fault!("cosine-twice", COSINE, "the weight has the cosine twice",
            EonParts: { lobes: PartTable { cosine: squared, ..subject::CORRECT } },
            at_every_angle!("bsdf/eon", "furnace")),
        fault!("no-multiple-scattering", EON_MULTIPLE, "single scattering alone",
            = with!(|rho, r, wo, wi| coloured(rho, r, wo, wi, 0.0)),
            "bsdf/eon: directional albedo at 0 degrees", "bsdf/eon-white", "bsdf/eon-coloured"),
        fault!("colour-not-deepened", EON_MULTIPLE, "ρ in place of ρₘ: a white surface cannot show it",
            = with!(|rho, r, wo, wi| coloured(rho, r, wo, wi, rho)), "bsdf/eon-coloured"),
        fault!("average-forgotten", EON_MULTIPLE, "the second lobe is not divided by 1 − Ē",
            = with!(|rho, r, wo, wi| {
                let multiple = multiple_albedo(DVec3::splat(rho), r).x;
                coloured(rho, r, wo, wi, multiple * (1.0 - average_albedo(r)))
            }),
            "bsdf/eon: directional albedo at 0 degrees", "bsdf/eon-white", "bsdf/eon-coloured"),
        fault!("one-sided", EON_MULTIPLE,
            "the second lobe spreads as Lambert: white reflects all, but f_r is not reciprocal",
            = with!(|rho, r, wo, wi| {
                let single = coloured(rho, r, wo, wi, 0.0);
                let multiple = multiple_albedo(DVec3::splat(rho), r).x;
                let above = wo.z > 0.0 && wi.z > 0.0;
                let lost = if above { 1.0 - albedo(r, wo.z) } else { 0.0 };
                single + FRAC_1_PI * multiple * lost
            }),
            "bsdf/eon: reciprocity"),
        fault!("constant", EON_SINGLE, "A = 1/(1 + r/2 − 2/(3π)): r times the first term of c only",
            EonParts: { single: |r, wo, wi| {
                let a = 1.0 / (1.0 + 0.5 * r - (0.5 - MAX_G_OVER_PI));
                single_scattering(r, wo, wi) * a / coefficient_a(r)
            } },
            "bsdf/eon-single", "bsdf/eon-albedo"),
        fault!("negative-side-divided", EON_SINGLE, "t = max(cos, cos) where s < 0, too",
            EonParts: { single: |r, wo, wi| {
                let s = wo.x * wi.x + wo.y * wi.y;
                coefficient_a(r) * (1.0 + r * s / wo.z.max(wi.z))
            } },
            "bsdf/eon-single", "bsdf/eon-albedo"),
        fault!("albedo-of-oren-nayar", EON_ALBEDO,
            "G without its term −2/3 sin θ, as where s < 0 counts nothing",
            EonParts: { albedo: |r, cos| {
                let sin = (1.0 - cos * cos).sqrt();
                albedo(r, cos) + coefficient_a(r) * r * FRAC_1_PI * 2.0 / 3.0 * sin
            } },
            "bsdf/eon-albedo"),
    ]
}

/// Trials and faults of EON.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    vec![Box::new(Family {
        trials: trials(),
        faults: faults(),
        ..Family::new("eon", CORRECT)
    })]
}
