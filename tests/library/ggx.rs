//! Tests of GGX: its formulas in slopes of facets, its sampling by the Jacobian of the map.

use whitefurnace::material::Model;
use whitefurnace::material::ggx::{
    Ggx, ndf, sample_visible_normal, smith_g2, smith_lambda, visible_normal_pdf,
};

use crate::prelude::*;

const REFLECTANCE: DVec3 = DVec3::new(0.9, 0.4, 0.0);

/// Evaluates Λ from the tangent of the inclination.
fn lambda(alpha: f64, w: DVec3) -> f64 {
    0.5 * ((alpha * w.truncate().length() / w.z).hypot(1.0) - 1.0)
}

/// Evaluates D from the slope of the facet.
fn density(alpha: f64, m: DVec3) -> f64 {
    let slope = m.truncate().length() / (alpha * m.z);
    FRAC_1_PI / (alpha * m.z * m.z * (1.0 + slope * slope)).powi(2)
}

#[test]
fn reflectance_is_that_of_the_slopes() {
    let strategy = (upper(0.01), upper(0.01), 0.05..1.5);
    property("ggx by slopes", 200, &strategy, |(wo, wi, alpha)| {
        let m = (wo + wi).normalize();
        let [o, i] = [wo, wi].map(|w| lambda(alpha, w));
        let (d, seen) = (density(alpha, m), 1.0 / (1.0 + o + i));
        let fresnel = REFLECTANCE + (DVec3::ONE - REFLECTANCE) * (1.0 - wo.dot(m)).powi(5);
        let ggx = Ggx {
            reflectance: REFLECTANCE,
            alpha,
        };
        let pairs = [
            (ndf(alpha, m), d),
            (smith_lambda(alpha, wo), o),
            (smith_g2(alpha, wo, wi), seen),
            (
                visible_normal_pdf(alpha, wo, m),
                d * wo.dot(m) / ((1.0 + o) * wo.z),
            ),
            (ggx.pdf(wo, wi), d / ((1.0 + o) * wo.z) / 4.0),
            (
                ggx.eval(wo, wi).x,
                fresnel.x * d * seen / (4.0 * wo.z * wi.z),
            ),
            (
                ggx.eval(wo, wi).z,
                fresnel.z * d * seen / (4.0 * wo.z * wi.z),
            ),
        ];
        for (found, expected) in pairs {
            assert_relative_eq!(found, expected, max_relative = 1e-9, epsilon = 1e-13);
        }
    });
    // No facet faces sideways or down.
    assert_eq!(
        [DVec3::X, DVec3::new(0.6, 0.0, -0.8)].map(|m| ndf(0.5, m)),
        [0.0; 2]
    );
    assert_eq!(
        visible_normal_pdf(0.5, DVec3::new(0.8, 0.0, 0.6), DVec3::new(-0.96, 0.0, 0.28)),
        0.0
    );
    let ggx = Ggx {
        reflectance: REFLECTANCE,
        alpha: 0.3,
    };
    assert_eq!(
        (ggx.fresnel(1.0), ggx.fresnel(0.0), ggx.albedo()),
        (REFLECTANCE, DVec3::ONE, REFLECTANCE)
    );
    assert_relative_eq!(ggx.fresnel(0.5).y, 0.4 + 0.6 / 32.0);
}

/// The density of visible normals is the reciprocal of the map's Jacobian determinant.
#[test]
fn visible_normals_have_their_density() {
    let strategy = (upper(0.02), 0.05..1.5, 0.01..0.99, 0.01..0.99);
    let check = |(wo, alpha, r1, r2): (DVec3, f64, f64, f64)| {
        let step = 1e-6;
        let at = |a: f64, b: f64| sample_visible_normal(alpha, wo, [r1 + step * a, r2 + step * b]);
        let across = (at(1.0, 0.0) - at(-1.0, 0.0)).cross(at(0.0, 1.0) - at(0.0, -1.0))
            / (4.0 * step * step);
        let m = at(0.0, 0.0);
        assert_relative_eq!(m.length(), 1.0, max_relative = 1e-12);
        assert!(wo.dot(m) > 0.0 && m.z > 0.0, "{m}");
        assert_relative_eq!(
            across.length() * visible_normal_pdf(alpha, wo, m),
            1.0,
            max_relative = 1e-4
        );

        let wi = Ggx {
            reflectance: REFLECTANCE,
            alpha,
        }
        .sample(wo, [r1, r2]);
        let expected = 2.0 * wo.dot(m) * m - wo;
        assert!(
            wi.map_or(expected.z <= 0.0, |wi| wi.z > 0.0
                && wi.distance(expected) < 1e-12),
            "{wi:?}"
        );
    };
    property("ggx by its Jacobian", 200, &strategy, check);
    check((DVec3::Z, 0.4, 0.3, 0.7));
}
