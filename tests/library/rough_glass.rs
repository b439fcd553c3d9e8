//! Tests of rough glass: its formulas in the notation of Walter et al., its sampling by the
//! Jacobian of the map, and the estimators that accept it.

use whitefurnace::material::fresnel::{radiance_factor, reflectance, refract};
use whitefurnace::material::ggx::{ndf, smith_g2, smith_lambda};
use whitefurnace::material::rough_glass::{RoughGlass, refracting, smith_g2_transmission};

use crate::prelude::*;

/// Generates relative indices of refraction, away from 1.
fn index() -> impl Strategy<Value = f64> {
    prop_oneof![0.4..0.95, 1.05..2.5]
}

/// (16), (20) and (21) of Walter et al., with n₁ above and n₂ below; (21) is for radiance.
#[test]
fn formulas_are_those_of_walter() {
    let strategy = (upper(0.01), upper(0.01), 0.05..1.0, 1.0..2.0, index());
    property(
        "rough glass by Walter",
        300,
        &strategy,
        |(o, m, alpha, n1, index)| {
            let (glass, n2) = (RoughGlass { index, alpha }, n1 * index);
            if o.dot(m) < 0.01 {
                return;
            }
            let fresnel = reflectance(o.dot(m), n1, n2);
            let i = 2.0 * o.dot(m) * m - o;
            if i.z > 0.01 {
                let facets = ndf(alpha, m) * smith_g2(alpha, o, i);
                assert_relative_eq!(
                    glass.eval(o, i),
                    fresnel * facets / (4.0 * i.z * o.z),
                    max_relative = 1e-8
                );
            }
            let Some(i) = refract(-o, m, n1, n2).filter(|i| i.z < -0.01 && i.dot(m) < -0.01) else {
                return;
            };
            assert!(refracting(index, o, i).is_some_and(|(found, _)| found.distance(m) < 1e-10));
            let facets = ndf(alpha, m) * smith_g2_transmission(alpha, o, i);
            let cosines = (i.dot(m) * o.dot(m) / (i.z * o.z)).abs();
            let radiance = cosines * n1 * n1 * (1.0 - fresnel) * facets
                / (n2 * i.dot(m) + n1 * o.dot(m)).powi(2);
            assert_relative_eq!(
                glass.eval(o, i) * radiance_factor(n1, n2),
                radiance,
                max_relative = 1e-8
            );
            // No facet refracts straight back, or to directions behind itself.
            assert_eq!(
                [glass.eval(o, -m.with_z(-m.z)) >= 0.0, glass.pdf(o, i) > 0.0],
                [true; 2]
            );
        },
    );
}

/// Λ is 0 along the normal, and 1 and 2 where α tan θ is √8 and √24; masking of opposite sides is
/// Euler's beta function, here of integers.
#[test]
fn masking_of_opposite_sides_is_eulers_function() {
    let alpha = 0.5;
    let inclined = |square: f64| DVec3::new(square.sqrt(), 0.0, alpha).normalize();
    let [none, one, two] = [0.0, 8.0, 24.0].map(inclined);
    for (w, lambda) in [(none, 0.0), (one, 1.0), (two, 2.0)] {
        assert_relative_eq!(smith_lambda(alpha, w), lambda, max_relative = 1e-12);
    }
    for (o, i, expected) in [
        (none, none, 1.0),
        (none, two, 1.0 / 3.0),
        (one, one, 1.0 / 6.0),
        (one, two, 1.0 / 12.0),
        (two, two, 1.0 / 30.0),
    ] {
        let below = i.with_z(-i.z);
        assert_relative_eq!(
            smith_g2_transmission(alpha, o, below),
            expected,
            max_relative = 1e-12
        );
        assert_relative_eq!(
            smith_g2_transmission(alpha, i, o.with_z(-o.z)),
            expected,
            max_relative = 1e-12
        );
    }
    assert_eq!(smith_g2_transmission(alpha, DVec3::Z, DVec3::X), 0.0);
    let glass = RoughGlass { index: 1.5, alpha };
    for grazing in [
        DVec3::X,
        DVec3::new(1.0, 0.0, 1e-200),
        DVec3::new(1.0, 0.0, -1e-200),
    ] {
        assert_eq!(glass.eval(DVec3::Z, grazing), 0.0);
    }
}

/// The pdf is the reciprocal of the map's Jacobian determinant, times the probability of the
/// branch.
#[test]
fn directions_have_their_density() {
    let strategy = (upper(0.02), 0.05..1.0, index(), 0.01..0.99, 0.01..0.99);
    property(
        "rough glass by its Jacobian",
        300,
        &strategy,
        |(wo, alpha, index, r1, r2)| {
            let glass = RoughGlass { index, alpha };
            let step = 1e-6;
            // Reflection always, and refraction wherever it is possible.
            for r3 in [0.0, 1.0 - f64::EPSILON] {
                let at = |a: f64, b: f64| glass.sample(wo, [r1 + step * a, r2 + step * b, r3]);
                let corners = [
                    at(1.0, 0.0),
                    at(-1.0, 0.0),
                    at(0.0, 1.0),
                    at(0.0, -1.0),
                    at(0.0, 0.0),
                ];
                let [Some(a), Some(b), Some(c), Some(d), Some(wi)] = corners else {
                    continue;
                };
                let is_reflected = wi.z > 0.0;
                let m = if is_reflected {
                    wo + wi
                } else {
                    (wo + index * wi) * (1.0 - index).signum()
                }
                .normalize();
                let fresnel = reflectance(wo.dot(m), 1.0, index);
                let share = if is_reflected { fresnel } else { 1.0 - fresnel };
                // Beyond the critical angle the branch probability has a kink.
                if share < 1e-3
                    || corners
                        .iter()
                        .flatten()
                        .any(|w| (w.z > 0.0) != is_reflected)
                {
                    continue;
                }
                let stretched = (a - b).cross(c - d).length() / (4.0 * step * step);
                // Where a facet is seen at grazing angles, the map is too curved for finite
                // differences.
                if wi.dot(m).abs() > 0.1 {
                    assert_relative_eq!(stretched * glass.pdf(wo, wi), share, max_relative = 1e-3);
                }
            }
        },
    );
}

#[test]
fn sides_and_numbers() {
    let glass = RoughGlass {
        index: 1.6,
        alpha: 0.3,
    };
    assert_eq!(
        (glass.oriented(true), glass.oriented(false)),
        (
            glass,
            RoughGlass {
                index: 0.625,
                alpha: 0.3
            }
        )
    );
    let nan = f64::NAN;
    for (index, alpha, valid) in [
        (1.5, 0.3, true),
        (0.999, 2.0, true),
        (1.0, 0.3, false),
        (1.0005, 0.3, false),
        (0.0, 0.3, false),
        (-1.5, 0.3, false),
        (nan, 0.3, false),
        (f64::INFINITY, 0.3, false),
        (1.5, 0.0, false),
        (1.5, nan, false),
    ] {
        assert_eq!(
            RoughGlass { index, alpha }.is_valid(),
            valid,
            "{index} {alpha}"
        );
    }
    // The model is defined in all directions, on both sides; directions from below the horizon are
    // not passed to it.
    let bsdf = Bsdf::RoughGlass(glass);
    assert!(bsdf.is_non_delta() && bsdf.albedo() == DVec3::ONE);
    let [wo, wi] = [DVec3::new(0.6, 0.0, 0.8), DVec3::new(-0.28, 0.0, -0.96)];
    assert_eq!(bsdf.eval(wo, wi), DVec3::splat(glass.eval(wo, wi)));
    assert!(bsdf.eval(wo, wi).x > 0.0 && bsdf.pdf(wo, wi) > 0.0);
    assert_eq!((bsdf.eval(wi, wo), bsdf.pdf(wi, wo)), (DVec3::ZERO, 0.0));
    assert!(DefaultParts.sample_non_delta(&bsdf, wi, [0.5; 3]).is_none());
}
