//! Tests of EON: both lobes against reference values, closed forms against quadrature, limits,
//! symmetry.

use whitefurnace::material::eon::{
    AVERAGE_G_OVER_PI, MAX_G_OVER_PI, albedo, average_albedo, coefficient_a, g_over_pi,
    multiple_albedo, single_scattering,
};
use whitefurnace::material::oren_nayar;

use crate::bsdf::directional_albedo;
use crate::prelude::*;
use crate::reference;

/// Bound on the quadrature error: values of at most 2 in sums of 15 times 15, each term with some
/// 40 roundings.
const QUADRATURE: f64 = 256.0 * UNIT_ROUNDOFF;

/// Compares both lobes, in closed form and by quadrature, and the first alone with each reference
/// value: white EON reflects all light, where both forms of (14) fail to.
#[test]
fn directional_albedos_meet_the_reference() {
    let rows = reference::eon();
    assert_eq!(rows.len(), 60);
    for [roughness, rho, degrees, single, both] in rows {
        let theta = degrees.to_radians();
        let first = rho * albedo(roughness, theta.cos());
        assert_abs_diff_eq!(first, single, epsilon = 16.0 * UNIT_ROUNDOFF);
        let colour = DVec3::splat(rho);
        let second = multiple_albedo(colour, roughness).x * (1.0 - albedo(roughness, theta.cos()));
        assert_abs_diff_eq!(first + second, both, epsilon = 32.0 * UNIT_ROUNDOFF);
        let found = directional_albedo(
            &Bsdf::Eon {
                albedo: colour,
                roughness,
            },
            theta,
        );
        assert_abs_diff_eq!(found, both, epsilon = QUADRATURE);
    }
}

#[test]
fn averages_are_the_integrals_of_the_albedo() {
    let average =
        |f: &dyn Fn(f64) -> f64| integral(0.0, FRAC_PI_2, |t| 2.0 * f(t.cos()) * t.sin() * t.cos());
    assert_abs_diff_eq!(
        average(&g_over_pi),
        AVERAGE_G_OVER_PI,
        epsilon = 64.0 * UNIT_ROUNDOFF
    );
    for roughness in [0.0, 0.3, 1.0] {
        let found = average(&|cos| albedo(roughness, cos));
        assert_abs_diff_eq!(
            found,
            average_albedo(roughness),
            epsilon = 128.0 * UNIT_ROUNDOFF
        );
    }
    assert_abs_diff_eq!(g_over_pi(0.0), MAX_G_OVER_PI, epsilon = 2.0 * UNIT_ROUNDOFF);
    assert_eq!(g_over_pi(1.0), 0.0);
}

/// The paper's polynomial in 1 − cos θ for G/π, of degree 4, changes albedos by up to 6.03e-4 if
/// used instead of the exact form, so that a white surface reflects up to that much more or less.
#[test]
fn the_polynomial_of_the_paper_is_within_its_error() {
    let polynomial = |cos: f64| {
        [
            0.071_442_995_3,
            -0.332_181_442,
            0.491_881_867,
            0.057_108_528_9,
            0.0,
        ]
        .into_iter()
        .fold(0.0, |sum, coefficient| sum * (1.0 - cos) + coefficient)
    };
    let off = |cos: f64| (polynomial(cos) - g_over_pi(cos)).abs();
    let worst = (0..=10_000)
        .map(|i| off(f64::from(i) / 10_000.0))
        .fold(0.0, f64::max);
    assert!((6.02e-4..6.03e-4).contains(&worst), "{worst:e}");
    for roughness in [0.1, 0.5, 1.0] {
        let approximate = coefficient_a(roughness) * (1.0 + roughness * polynomial(0.954));
        let relative = (approximate / albedo(roughness, 0.954) - 1.0).abs();
        assert!(relative < 6.03e-4 * roughness, "{relative:e}");
    }
}

/// The roughness B/A makes Fujii's bracket proportional to (14) in the half-space of the light.
#[test]
fn the_roughness_of_the_same_shape() {
    let constants = OrenNayar::new(0.5);
    let roughness = constants.roughness();
    let wo = from_spherical(1.1, 0.3);
    for wi in [from_spherical(0.2, 0.1), from_spherical(1.4, -0.5)] {
        let ratio = single_scattering(roughness, wo, wi) / coefficient_a(roughness);
        let known = oren_nayar(constants, OrenNayarForm::Corrected, wo, wi) / constants.a;
        assert_relative_eq!(ratio, known, max_relative = 16.0 * UNIT_ROUNDOFF);
    }
    assert!(OrenNayar::new(FRAC_PI_2).roughness() < 0.9);
}
