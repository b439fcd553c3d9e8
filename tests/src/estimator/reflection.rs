//! Faults of reflection: BSDF models and the cosine, (8), (9), (13)-(15), EON.

use glam::Vec3Swizzles;
use whitefurnace::material::eon::{multiple_albedo, multiple_scattering, single_scattering};
use whitefurnace::material::{OrenNayar, OrenNayarForm};

use crate::prelude::*;

/// (14) in another form, or with another function of A.
fn oren_nayar(bsdf: &Bsdf, wo: DVec3, wi: DVec3, form: OrenNayarForm, a: fn(f64) -> f64) -> DVec3 {
    match *bsdf {
        Bsdf::OrenNayar {
            albedo, constants, ..
        } => {
            let constants = OrenNayar {
                a: a(constants.a),
                ..constants
            };
            Bsdf::OrenNayar {
                albedo,
                constants,
                form,
            }
            .eval(wo, wi)
        }
        _ => bsdf.eval(wo, wi),
    }
}

/// EON with the roughness of its first lobe and the value of its second scaled.
fn eon(bsdf: &Bsdf, wo: DVec3, wi: DVec3, [first, second]: [f64; 2]) -> DVec3 {
    match *bsdf {
        Bsdf::Eon { albedo, roughness } if wo.z > 0.0 && wi.z > 0.0 => {
            let single = albedo * single_scattering(first * roughness, wo, wi);
            let all = multiple_albedo(albedo, roughness);
            FRAC_1_PI * (single + second * all * multiple_scattering(roughness, wo, wi))
        }
        _ => bsdf.eval(wo, wi),
    }
}

pub(super) fn faults() -> Vec<Fault<EstimatorSubject>> {
    vec![
        fault!("no-pi", LAMBERT, "the BRDF misses 1/π",
            { brdf: |bsdf, wo, wi| PI * bsdf.eval(wo, wi) }, "irradiance/rectangle-whitted",
            "images/convex-object"),
        fault!("channels-exchanged", LAMBERT, "red and blue of the albedo are exchanged",
            { brdf: |bsdf, wo, wi| bsdf.eval(wo, wi).zyx() },
            "images/convex-object", "images/diffuse-room: image mean | p-values of pixels"),
        fault!("channels-mixed", LAMBERT, "every channel has the mean albedo",
            { brdf: |bsdf, wo, wi| DVec3::splat(bsdf.eval(wo, wi).element_sum() / 3.0) },
            "images/convex-object"),
        fault!("albedo-squared", LAMBERT, "the albedo enters twice",
            { brdf: |bsdf, wo, wi| bsdf.eval(wo, wi) * bsdf.albedo() }, "furnace/path/albedo-0.75"),
        fault!("printed-oren-nayar", OREN_NAYAR, "sin β for tan β, as printed",
            { brdf: |bsdf, wo, wi| oren_nayar(bsdf, wo, wi, OrenNayarForm::Printed, |a| a) },
            "furnace/sky/oren-nayar"),
        fault!("oren-nayar-constant", OREN_NAYAR_CONSTANTS, "0.57 for 0.33 in A",
            { brdf: |bsdf, wo, wi| oren_nayar(bsdf, wo, wi, OrenNayarForm::Corrected, |a| {
                // A = 1 − σ²/2(σ² + 0.33), solved for σ².
                let s2 = 0.66 * (1.0 - a) / (2.0 * a - 1.0);
                1.0 - s2 / (2.0 * (s2 + 0.57))
            }) },
            "furnace/sky/oren-nayar"),
        fault!("eon-single-scattering-only", EON_MULTIPLE,
            "EON without its second lobe: rough white surfaces darken",
            { brdf: |bsdf, wo, wi| eon(bsdf, wo, wi, [1.0, 0.0]) }, "furnace/sky/eon"),
        fault!("eon-half-roughness", EON_SINGLE,
            "r/2 in single scattering, r in what the second lobe gives back",
            { brdf: |bsdf, wo, wi| eon(bsdf, wo, wi, [0.5, 1.0]) }, "furnace/sky/eon"),
        fault!("cosine-dropped", COSINE, "f* = f_r: no cosine",
            { cosine: |n, w| if n.dot(w) > 0.0 { 1.0 } else { 0.0 } }, "irradiance/rectangle",
            "irradiance/shadow-rays-alone"),
        fault!("cosine-doubled", COSINE, "the cosine enters twice",
            { cosine: |n, w| n.dot(w).max(0.0).powi(2) }, "irradiance/rectangle", "furnace/sky/path",
            "images/convex-object", "cie/panel-floor", "cie/panel-wall", "cie/roof-opening",
            "cie/obstruction"),
        fault!("reflection-lost", RENDERING, "a twentieth of the integral in (8) is lost at each bounce",
            { brdf: |bsdf, wo, wi| 0.95 * bsdf.eval(wo, wi) }, "furnace/cavity/reflecting",
            "furnace/cavity/black"),
    ]
}
