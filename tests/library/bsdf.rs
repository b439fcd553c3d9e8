//! Tests of equations (13)-(15): Lambert and Oren-Nayar in both forms.

use whitefurnace::harness::quadrature::{Rectangle, integrate};
use whitefurnace::material::{oren_nayar, oren_nayar_angles};

use crate::prelude::*;
use crate::reference;

const FORMS: [OrenNayarForm; 2] = [OrenNayarForm::Corrected, OrenNayarForm::Printed];

fn white(sigma: f64, form: OrenNayarForm) -> Bsdf {
    Bsdf::oren_nayar(DVec3::ONE, sigma, form)
}

/// Integrates f_r cos θ over the hemisphere of incident directions. The integrand has kinks where
/// the azimuths are a quarter turn apart and where the inclinations are equal; between them it is
/// smooth.
pub fn directional_albedo(bsdf: &Bsdf, theta_out: f64) -> f64 {
    let wo = from_spherical(theta_out, 0.0);
    let mut f = |theta: f64, phi: f64| {
        bsdf.eval(wo, from_spherical(theta, phi)).x * theta.sin() * theta.cos()
    };
    let inclinations = [[0.0, theta_out], [theta_out, FRAC_PI_2]];
    let azimuths = [[-FRAC_PI_2, FRAC_PI_2], [FRAC_PI_2, 3.0 * FRAC_PI_2]];
    let parts = inclinations
        .into_iter()
        .flat_map(|x| azimuths.map(|y| Rectangle { x, y }));
    parts
        .filter(|part| part.x[0] < part.x[1])
        .map(|part| integrate(part, 1e-10, &mut f).value)
        .sum()
}

/// Bound on the quadrature error: values of at most A + B/2 ≤ 1.2 in sums of 15 times 15, each term
/// with some 16 roundings.
const QUADRATURE: f64 = 128.0 * UNIT_ROUNDOFF;

#[test]
fn constants_are_those_of_the_1994_model() {
    for [sigma, a, b, ..] in reference::oren_nayar_average() {
        let constants = OrenNayar::new(sigma);
        // Five roundings of terms of at most 1.
        assert_abs_diff_eq!(constants.a, a, epsilon = 5.0 * UNIT_ROUNDOFF);
        assert_abs_diff_eq!(constants.b, b, epsilon = 5.0 * UNIT_ROUNDOFF);
    }
    assert_eq!(OrenNayar::new(0.0), OrenNayar { a: 1.0, b: 0.0 });
}

#[test]
fn angles_and_vectors_give_the_same() {
    let strategy = (
        0.0..FRAC_PI_2,
        0.0..FRAC_PI_2,
        0.0..TAU,
        0.0..TAU,
        0.0..FRAC_PI_2,
    );
    property(
        "angle form",
        4000,
        &strategy,
        |(theta_in, theta_out, phi_in, phi_out, sigma): (f64, f64, f64, f64, f64)| {
            let constants = OrenNayar::new(sigma);
            let (wi, wo) = (
                from_spherical(theta_in, phi_in),
                from_spherical(theta_out, phi_out),
            );
            for form in FORMS {
                let readable =
                    oren_nayar_angles(constants, form, theta_in, theta_out, phi_in - phi_out);
                let fast = oren_nayar(constants, form, wo, wi);
                // sin θᵢ sin θₒ cos Δφ is off by 8 U sin sin on either way, and by 7 U more through
                // the rounded difference of azimuths; the last factor and the sum by 4 U each.
                let alpha = theta_in.max(theta_out);
                let last = match form {
                    OrenNayarForm::Corrected => theta_in.min(theta_out).tan(),
                    OrenNayarForm::Printed => theta_in.min(theta_out).sin(),
                };
                let bound = 32.0 * UNIT_ROUNDOFF * constants.b * alpha.sin() * last
                    + 4.0 * UNIT_ROUNDOFF * readable;
                assert_abs_diff_eq!(readable, fast, epsilon = bound);
            }
        },
    );
}

#[test]
fn known_values() {
    // Retro-reflection at σ = 0.5 and 60°: A + B sin 60° tan 60° = A + 1.5 B, printed A + 0.75 B.
    let (a, b) = (0.784_482_758_620_689_7, 0.330_882_352_941_176_5);
    let w = from_spherical(PI / 3.0, 1.0);
    for (form, expected) in FORMS.into_iter().zip([a + 1.5 * b, a + 0.75 * b]) {
        assert_abs_diff_eq!(
            white(0.5, form).eval(w, w).x * PI,
            expected,
            epsilon = 32.0 * UNIT_ROUNDOFF
        );
        // On the other side of the normal only A remains.
        let across = from_spherical(PI / 3.0, 1.0 + PI);
        assert_abs_diff_eq!(
            white(0.5, form).eval(w, across).x * PI,
            a,
            epsilon = 8.0 * UNIT_ROUNDOFF
        );
        assert_abs_diff_eq!(
            white(0.5, form).eval(w, DVec3::Z).x * PI,
            a,
            epsilon = 8.0 * UNIT_ROUNDOFF
        );
    }
}

#[test]
fn nothing_is_reflected_below_the_horizon() {
    let up = from_spherical(0.5, 0.0);
    for below in [from_spherical(2.0, 1.0), DVec3::X, -DVec3::Z] {
        for bsdf in [
            Bsdf::Lambert {
                albedo: DVec3::splat(0.5),
            },
            white(0.5, OrenNayarForm::Corrected),
        ] {
            for (wo, wi) in [(up, below), (below, up), (below, below)] {
                assert_eq!(bsdf.eval(wo, wi), DVec3::ZERO);
            }
        }
    }
}

#[test]
fn albedo_scales_the_model() {
    let albedo = DVec3::new(0.25, 0.5, 0.75);
    let (wo, wi) = (from_spherical(0.7, 0.1), from_spherical(1.1, 0.4));
    for form in FORMS {
        let coloured = Bsdf::oren_nayar(albedo, 0.4, form).eval(wo, wi);
        assert!(
            (coloured - albedo * white(0.4, form).eval(wo, wi))
                .abs()
                .max_element()
                <= 4.0 * UNIT_ROUNDOFF
        );
    }
}

#[test]
fn directional_albedos_meet_the_reference() {
    let rows = reference::oren_nayar();
    assert_eq!(rows.len(), 99);
    for [sigma, degrees, corrected, printed] in rows {
        let theta = degrees.to_radians();
        for (form, expected) in FORMS.into_iter().zip([corrected, printed]) {
            let found = directional_albedo(&white(sigma, form), theta);
            let off = (found - expected).abs();
            assert!(
                off <= QUADRATURE,
                "{form:?} at sigma {sigma}, {degrees} deg: {found} is off by {off:e}"
            );
        }
    }
}

#[test]
fn diffuse_models_are_those_that_reflect_in_all_directions() {
    let albedo = DVec3::new(0.2, 0.5, 0.8);
    let reflectance = albedo;
    let roughness = 0.5;
    for (model, diffuse, expected) in [
        (Bsdf::Black, false, DVec3::ZERO),
        (Bsdf::Lambert { albedo }, true, albedo),
        (
            Bsdf::oren_nayar(albedo, 0.5, OrenNayarForm::Corrected),
            true,
            albedo,
        ),
        (Bsdf::Eon { albedo, roughness }, true, albedo),
        (Bsdf::Mirror { reflectance }, false, reflectance),
        (Bsdf::Glass { index: 1.5 }, false, DVec3::ONE),
    ] {
        assert_eq!(model.is_non_delta(), diffuse, "{model:?}");
        assert_eq!(model.albedo(), expected, "{model:?}");
        let [wo, wi] = [DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.0, 0.8, 0.6)];
        assert_eq!(model.eval(wo, wi).min_element() > 0.0, diffuse, "{model:?}");
    }
}
