//! Tests of equations (5)-(7): rays and spheres.

use whitefurnace::geometry::shape::{sphere_distances, sphere_distances_printed, sphere_residual};

use crate::prelude::*;

/// Generates a sphere and a ray whose line passes it at `miss` radii from the centre, from
/// distances around the radius to far away.
fn ray_and_sphere(
    misses: impl Strategy<Value = f64>,
) -> impl Strategy<Value = (Ray, DVec3, f64, f64)> {
    (
        point(10.0),
        unit(),
        misses,
        -2.0..6.0,
        -2.0..2.0,
        any::<bool>(),
    )
        .prop_map(
            |(centre, direction, miss, along, size, behind): (_, DVec3, f64, f64, f64, bool)| {
                let radius = 10f64.powf(size);
                let side = direction.any_orthonormal_vector();
                let along = 10f64.powf(along) * if behind { -1.0 } else { 1.0 };
                (
                    Ray::new(
                        centre + radius * (miss * side - along * direction),
                        direction,
                    ),
                    centre,
                    radius,
                    miss,
                )
            },
        )
}

/// Bound on |‖x − c‖² − r²| at a computed root: the radicand is off by 16 U r d, each root by that
/// over twice the half chord and by 8 U d more, and the point by 4 U of its coordinates. The
/// residual changes by twice the half chord per distance, which cancels the first denominator.
fn sphere_bound(ray: &Ray, centre: DVec3, radius: f64) -> f64 {
    let distance = (ray.origin - centre).length() + radius;
    let coordinates = ray.origin.length() + centre.length() + distance;
    64.0 * UNIT_ROUNDOFF * radius * (distance + coordinates)
        + 16.0 * UNIT_ROUNDOFF * radius * radius
}

#[test]
fn the_residual_is_negative_inside_and_positive_outside() {
    let centre = DVec3::new(1.0, -2.0, 3.0);
    // (2, 6, 3) from the centre: distance 7.
    let x = centre + DVec3::new(2.0, -6.0, 3.0);
    for (radius, expected) in [(5.0, 24.0), (7.0, 0.0), (9.0, -32.0)] {
        assert_eq!(sphere_residual(x, centre, radius), expected);
    }
}

#[test]
fn sphere_roots_lie_on_the_sphere() {
    property(
        "roots",
        3000,
        &ray_and_sphere(prop_oneof![0.0..0.999, 0.999..1.0]),
        |(ray, c, r, _)| {
            // Within rounding of the tangent the line may pass outside.
            let Some(roots) = sphere_distances(&ray, c, r) else {
                let tangential = (c - ray.origin).cross(ray.direction).length();
                assert!(
                    r - tangential <= sphere_bound(&ray, c, r) / r,
                    "lost a root"
                );
                return;
            };
            assert!(roots[0] <= roots[1]);
            for t in roots {
                let residual = sphere_residual(ray.at(t), c, r).abs();
                let bound = sphere_bound(&ray, c, r);
                assert!(
                    residual <= bound,
                    "residual of (5): {residual:e} > {bound:e}"
                );
            }
        },
    );
}

#[test]
fn known_sphere_roots() {
    let along_x = |x: f64, y: f64| Ray::new(DVec3::new(x, y, 0.0), DVec3::X);
    let roots = |ray: &Ray| sphere_distances(ray, DVec3::ZERO, 5.0);
    for (ray, expected) in [
        (along_x(-10.0, 3.0), Some([6.0, 14.0])),
        (along_x(0.0, 3.0), Some([-4.0, 4.0])),
        (along_x(10.0, 3.0), Some([-14.0, -6.0])),
        (along_x(-10.0, 5.0), Some([10.0, 10.0])),
        (along_x(-10.0, 6.0), None),
        (along_x(-5.0, 0.0), Some([0.0, 10.0])),
        (along_x(0.0, 0.0), Some([-5.0, 5.0])),
        (along_x(0.0, 5.0), Some([0.0, 0.0])),
    ] {
        assert_eq!(sphere_distances_printed(&ray, DVec3::ZERO, 5.0), expected);
        let found = roots(&ray);
        assert_eq!(found.is_some(), expected.is_some(), "{ray:?}");
        // The stable form takes the square root of the distance: four roundings of at most 15.
        for (t, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
            assert_abs_diff_eq!(t, expected, epsilon = 4.0 * UNIT_ROUNDOFF * 15.0);
        }
    }
    let nearest = |ray: &Ray| Sphere::new(DVec3::ZERO, 5.0).intersect(ray, f64::INFINITY);
    assert_eq!(nearest(&along_x(-9.0, 0.0)), Some(4.0), "from outside");
    assert_eq!(nearest(&along_x(0.0, 0.0)), Some(5.0), "from inside");
    assert_eq!(nearest(&along_x(9.0, 0.0)), None, "behind");
    assert_eq!(nearest(&along_x(-5.0, 0.0)), Some(10.0), "from the surface");
}

#[test]
fn sphere_distance_is_in_units_of_the_direction() {
    property(
        "units",
        500,
        &(ray_and_sphere(0.0..0.99), -40i32..40),
        |((ray, c, r, _), k)| {
            let longer = Ray::new(ray.origin, ray.direction * 2f64.powi(k));
            let expected =
                sphere_distances(&ray, c, r).map(|roots| roots.map(|t| t * 2f64.powi(-k)));
            // Powers of four are exact throughout; odd powers involve a square root of 2^k, which
            // is not.
            if k % 2 == 0 {
                assert_eq!(sphere_distances(&longer, c, r), expected);
            }
            for t in sphere_distances(&longer, c, r).into_iter().flatten() {
                assert!(sphere_residual(longer.at(t), c, r).abs() <= sphere_bound(&ray, c, r));
            }
        },
    );
}

#[test]
fn zones_divide_the_sphere() {
    property(
        "zones",
        2000,
        &(ray_and_sphere(0.0..1.5), -1.0..1.0),
        |((ray, c, r, _), cut): (_, f64)| {
            let whole = Sphere::new(c, r);
            let height = cut * r;
            let zone = |zone| between_heights(whole, zone);
            let lower = zone([f64::NEG_INFINITY, height]).intersect(&ray, f64::INFINITY);
            let upper = zone([height, f64::INFINITY]).intersect(&ray, f64::INFINITY);
            let first = match (lower, upper) {
                (Some(a), Some(b)) => Some(a.min(b)),
                (a, b) => a.or(b),
            };
            assert_eq!(first, whole.intersect(&ray, f64::INFINITY));
            // Each zone has its own side: a point's height has three roundings of its terms.
            let above = |t: Option<f64>| t.map(|t| ray.at(t).z - c.z - height);
            let distance = (ray.origin - c).length() + r;
            let rounding = 8.0 * UNIT_ROUNDOFF * (ray.origin.length() + c.length() + distance);
            assert!(above(lower).is_none_or(|z| z < rounding));
            assert!(above(upper).is_none_or(|z| z > -rounding));
        },
    );
    let cap = between_heights(Sphere::new(DVec3::ZERO, 1.0), [0.5, f64::INFINITY]);
    let down = Ray::new(DVec3::new(0.0, 0.0, 3.0), -DVec3::Z);
    let up = Ray::new(DVec3::new(0.0, 0.0, -3.0), DVec3::Z);
    assert_eq!(cap.intersect(&down, 10.0), Some(2.0));
    assert_eq!(
        cap.intersect(&up, 10.0),
        Some(4.0),
        "through the open bottom"
    );
    assert_eq!(cap.intersect(&up, 4.0), None, "t_max is exclusive");
    // A level ray at the very border belongs to the upper zone only.
    let level = Ray::new(DVec3::new(-3.0, 0.0, 0.5), DVec3::X);
    let below = between_heights(cap, [f64::NEG_INFINITY, 0.5]);
    assert!(cap.intersect(&level, 10.0).is_some());
    assert_eq!(below.intersect(&level, 10.0), None);
    assert_eq!(cap.heights(), [0.5, 1.0]);
    assert_abs_diff_eq!(cap.area(), PI, epsilon = 4.0 * UNIT_ROUNDOFF * 4.0);
    let larger = Sphere { radius: 3.0, ..cap };
    let area = 15.0 * PI;
    assert_abs_diff_eq!(larger.area(), area, epsilon = 4.0 * UNIT_ROUNDOFF * area);
}

#[test]
fn sphere_normals_are_unit_and_on_their_side() {
    property(
        "normals",
        500,
        &(point(10.0), unit(), -3.0..3.0),
        |(c, n, size): (_, _, f64)| {
            let r = 10f64.powf(size);
            let outward = Sphere::new(c, r).normal(c + r * n);
            assert_eq!(inward(Sphere::new(c, r)).normal(c + r * n), -outward);
            assert_abs_diff_eq!(outward.length(), 1.0, epsilon = 6.0 * UNIT_ROUNDOFF);
            // The point is rounded relative to its coordinates, the normal relative to the radius.
            assert!(
                (outward - n).length()
                    <= 4.0 * UNIT_ROUNDOFF * (c.length() + r) / r + 8.0 * UNIT_ROUNDOFF
            );
        },
    );
}
