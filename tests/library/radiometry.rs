//! Tests of equations (8)-(9): cosine, geometry term, change of measure, MIS weights.

use whitefurnace::geometry::radiometry::{cosine, reflected, solid_angle_per_area};
use whitefurnace::sampling::mis::{balance, power};

use crate::prelude::*;

/// Computes G(x, y) between two points with unit normals, from the factors that the estimators use.
fn geometry_term(x: DVec3, normal_x: DVec3, y: DVec3, normal_y: DVec3) -> f64 {
    let to_y = y - x;
    let direction = to_y.normalize();
    cosine(normal_x, direction)
        * solid_angle_per_area(cosine(normal_y, -direction), to_y.length_squared())
}

#[test]
fn cosine_is_zero_below_the_surface() {
    property("cosine", 500, &(unit(), unit()), |(n, w)| {
        assert_abs_diff_eq!(
            cosine(n, w),
            (n.x * w.x + n.y * w.y + n.z * w.z).max(0.0),
            epsilon = 3.0 * UNIT_ROUNDOFF
        );
        assert!(cosine(n, w) >= 0.0);
        assert_eq!(cosine(n, w) * cosine(n, -w), 0.0);
    });
    assert_eq!(cosine(DVec3::Z, DVec3::new(0.6, 0.0, 0.8)), 0.8);
}

#[test]
fn geometry_term_is_symmetric() {
    property(
        "geometry",
        1000,
        &(point(2.0), unit(), point(2.0), unit()),
        |(x, nx, y, ny)| {
            let (there, back) = (geometry_term(x, nx, y, ny), geometry_term(y, ny, x, nx));
            // The differences are exactly opposite; four roundings of products differ in each
            // direction.
            assert_relative_eq!(there, back, max_relative = 8.0 * UNIT_ROUNDOFF);
            assert!(there >= 0.0);
            // By definition: cosines of unnormalised differences over the fourth power of distance.
            let d = y - x;
            let d2 = d.length_squared();
            let expected = nx.dot(d).max(0.0) * ny.dot(-d).max(0.0) / (d2 * d2);
            // A scalar product near zero is off by 3 U of its terms, on both sides.
            assert_abs_diff_eq!(there, expected, epsilon = 24.0 * UNIT_ROUNDOFF / d2);
        },
    );
}

#[test]
fn area_becomes_solid_angle() {
    // Exact values: (6, 3, 2) has length 7.
    assert_eq!(solid_angle_per_area(0.5, 4.0), 0.125);
    let [brdf, radiance] = [[0.25, 0.5, 1.0], [2.0, 4.0, 8.0]].map(DVec3::from_array);
    assert_eq!(
        reflected(brdf, radiance, 0.5, 0.25),
        DVec3::new(1.0, 4.0, 16.0)
    );
    let (x, y) = (DVec3::ZERO, DVec3::new(6.0, 3.0, 2.0));
    let g = geometry_term(x, DVec3::Z, y, -DVec3::Z);
    assert_abs_diff_eq!(
        g,
        (2.0 / 7.0) * (2.0 / 7.0) / 49.0,
        epsilon = 8.0 * UNIT_ROUNDOFF * g
    );
}

#[test]
fn weights_are_shares_of_densities_and_of_their_squares() {
    property(
        "weights",
        1000,
        &(1e-6..1e6, 1e-6..1e6),
        |(p, q): (f64, f64)| {
            // By definition; the squares do not overflow or underflow here.
            assert_relative_eq!(
                balance(p, q),
                p / (p + q),
                max_relative = 8.0 * UNIT_ROUNDOFF
            );
            assert_relative_eq!(
                power(p, q),
                p * p / (p * p + q * q),
                max_relative = 8.0 * UNIT_ROUNDOFF
            );
            assert_eq!((balance(p, 0.0), balance(0.0, q)), (1.0, 0.0));
        },
    );
    assert_eq!((balance(1.0, 3.0), power(1.0, 3.0)), (0.25, 0.1));
}

/// Any two densities of this list, zero, infinity and the limits of doubles included, get weights
/// in [0, 1] that sum to one; the larger density gets the larger weight, and a larger one by the
/// power heuristic.
#[test]
fn weights_sum_to_one_for_extreme_densities() {
    let mut densities = vec![0.0, f64::INFINITY, f64::MIN_POSITIVE, f64::MAX, 1.0];
    densities.extend((-300..=300).step_by(23).map(|e| 1.7 * 10f64.powi(e)));
    for &p in &densities {
        for &q in &densities {
            for weight in [balance, power] {
                let (a, b) = (weight(p, q), weight(q, p));
                assert!((0.0..=1.0).contains(&a), "{a} for {p} and {q}");
                assert_abs_diff_eq!(a + b, 1.0, epsilon = 4.0 * UNIT_ROUNDOFF);
            }
            if p > q {
                assert!(
                    power(p, q) >= balance(p, q) && balance(p, q) >= 0.5,
                    "{p}, {q}"
                );
            }
        }
    }
}
