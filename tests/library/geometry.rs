//! Tests of equations (1)-(4): rays and triangles.

use whitefurnace::geometry::shape::{moller_trumbore, triangle_point, triangle_residual};
use whitefurnace::geometry::watertight::{Shear, TriangleHit};

use crate::prelude::*;

const STANDARD: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];

fn watertight(ray: &Ray, triangle: [DVec3; 3], t_max: f64) -> Option<TriangleHit> {
    Shear::new(ray).intersect(triangle, t_max)
}

fn down(x: f64, y: f64) -> Ray {
    Ray::new(DVec3::new(x, y, 2.0), -DVec3::Z)
}

/// Generates a random triangle of size `scale`, a point well inside it, and a ray to that point
/// that is not nearly parallel to it.
fn aimed() -> impl Strategy<Value = (Ray, [DVec3; 3], [f64; 2])> {
    let triangle = prop::array::uniform3(point(1.0));
    (triangle, point(1.0), 0.05..0.9, 0.05..0.9, -4i32..=4)
        .prop_map(
            |(triangle, origin, u, v, exponent): (_, DVec3, f64, f64, _)| {
                let scale = 10f64.powi(exponent);
                let triangle = triangle.map(|vertex: DVec3| vertex * scale);
                let (u, v) = if u + v < 0.95 {
                    (u, v)
                } else {
                    (u * 0.5, v * 0.5)
                };
                let target = triangle_point(triangle, u, v);
                // Origins at distances from a hundredth to a hundred times the triangle's size.
                let origin = target + origin * scale.powf(0.5);
                (
                    Ray::new(origin, (target - origin).normalize()),
                    triangle,
                    [u, v],
                )
            },
        )
        .prop_filter("well conditioned", |(ray, [a, b, c], _)| {
            let (e1, e2) = (*b - *a, *c - *a);
            ray.direction.dot(e1.cross(e2)).abs() > 1e-3 * e1.length() * e2.length()
        })
}

/// Bounds on the errors of t, u, v of (4), to first order in `UNIT_ROUNDOFF` with the constant
/// rounded up from 10 to 12 for the rest: a cross product of differences is off by 4√2 U, its
/// scalar product by 4 U more, relative to the product of the lengths.
fn cramer_error(ray: &Ray, [a, b, c]: [DVec3; 3], [t, u, v]: [f64; 3]) -> [f64; 3] {
    let (e1, e2, to) = (b - a, c - a, ray.origin - a);
    let [l1, l2, lt, ld] = [e1, e2, to, ray.direction].map(DVec3::length);
    let det = ray.direction.cross(e2).dot(e1).abs();
    let relative = 12.0 * UNIT_ROUNDOFF * ld * l1 * l2 / det + UNIT_ROUNDOFF;
    [
        12.0 * UNIT_ROUNDOFF * lt * l1 * l2 / det + relative * t.abs(),
        12.0 * UNIT_ROUNDOFF * ld * l2 * lt / det + relative * u.abs(),
        12.0 * UNIT_ROUNDOFF * ld * l1 * lt / det + relative * v.abs(),
    ]
}

/// Bound on the error of the weights of the watertight test: projected vertices are at most 2L away
/// and off by 6 U L, so an edge value is off by 4·2·6 U L² + 2 U (2L)², the determinant by three
/// times that.
fn shear_error(ray: &Ray, triangle: [DVec3; 3]) -> (f64, f64) {
    let length = triangle.map(|v| (v - ray.origin).length());
    let length = length.into_iter().fold(0.0, f64::max);
    let [a, b, c] = triangle;
    let depth = ray.direction.abs().max_element();
    let det = ray.direction.dot((b - a).cross(c - a)).abs() / depth;
    let weight = 4.0 * 56.0 * UNIT_ROUNDOFF * length * length / det + 4.0 * UNIT_ROUNDOFF;
    (weight, 3.0 * weight * length / depth)
}

#[test]
fn ray_point() {
    let ray = Ray::new(DVec3::new(1.0, -2.0, 0.5), DVec3::new(0.25, 0.0, -1.0));
    assert_eq!(ray.at(0.0), ray.origin);
    assert_eq!(ray.at(4.0), DVec3::new(2.0, -2.0, -3.5));
    assert_eq!(ray.at(-2.0), DVec3::new(0.5, -2.0, 2.5));
}

#[test]
fn residuals_are_distances_from_the_solution() {
    let triangle = [DVec3::new(1.0, 0.0, 0.0), DVec3::Y, DVec3::Z];
    let ray = Ray::new(DVec3::new(2.0, 4.0, 8.0), DVec3::new(0.0, -1.0, 0.5));
    // T(u, v) − R(t) at t = 2, u = 1/4, v = 1/2: (1/4, 1/4, 1/2) − (2, 2, 9).
    assert_eq!(
        triangle_residual(&ray, triangle, 2.0, 0.25, 0.5),
        DVec3::new(-1.75, -1.75, -8.5)
    );
}

#[test]
fn solution_has_no_residual() {
    property("solution", 2000, &aimed(), |(ray, triangle, [u, v])| {
        let (t, found_u, found_v) = moller_trumbore(&ray, triangle).expect("aimed inside");
        let [et, eu, ev] = cramer_error(&ray, triangle, [t, found_u, found_v]);
        let [a, b, c] = triangle;
        let (l1, l2) = ((b - a).length(), (c - a).length());
        let size = triangle
            .iter()
            .fold(ray.origin.length(), |s, v| s + v.length());
        // Errors of the solution, then rounding of the residual: six operations on each term.
        let terms = t + l1 + l2 + (ray.origin - a).length();
        let bound = et + eu * l1 + ev * l2 + 6.0 * UNIT_ROUNDOFF * terms;
        let residual = triangle_residual(&ray, triangle, t, found_u, found_v).length();
        assert!(
            residual <= bound,
            "residual of (3): {residual:e} > {bound:e}"
        );
        // (2) meets (1): the same error, and rounding of the coordinates themselves.
        let apart = (triangle_point(triangle, found_u, found_v) - ray.at(t)).length();
        assert!(
            apart <= bound + 6.0 * UNIT_ROUNDOFF * (size + t),
            "(1) and (2) are {apart:e} apart"
        );
        // The target and the direction are themselves rounded.
        let aim = 6.0 * UNIT_ROUNDOFF * (size + t) / ray.direction.dot((b - a).cross(c - a)).abs();
        assert_abs_diff_eq!(found_u, u, epsilon = eu + aim * l2);
        assert_abs_diff_eq!(found_v, v, epsilon = ev + aim * l1);
    });
}

#[test]
fn solution_scales_exactly() {
    // Powers of two scale every intermediate value without rounding: no threshold may depend on
    // size.
    property(
        "scales",
        500,
        &(aimed(), -150i32..150),
        |((ray, triangle, _), k)| {
            let scale = 2f64.powi(k);
            let scaled = Ray::new(ray.origin * scale, ray.direction);
            let (t, u, v) = moller_trumbore(&ray, triangle).expect("aimed inside");
            let found = moller_trumbore(&scaled, triangle.map(|x| x * scale));
            assert_eq!(found, Some((t * scale, u, v)));
            let hit = watertight(&ray, triangle, f64::INFINITY).expect("aimed inside");
            let found = watertight(&scaled, triangle.map(|x| x * scale), f64::INFINITY);
            assert_eq!(
                found,
                Some(TriangleHit {
                    t: hit.t * scale,
                    ..hit
                })
            );
        },
    );
}

#[test]
fn watertight_agrees_with_the_solution() {
    property("watertight", 2000, &aimed(), |(ray, triangle, _)| {
        let (t, u, v) = moller_trumbore(&ray, triangle).expect("aimed inside");
        let hit = watertight(&ray, triangle, f64::INFINITY).expect("aimed inside");
        let [et, eu, ev] = cramer_error(&ray, triangle, [t, u, v]);
        let (weight, distance) = shear_error(&ray, triangle);
        assert_abs_diff_eq!(hit.weights[0], 1.0 - u - v, epsilon = eu + ev + weight);
        assert_abs_diff_eq!(hit.weights[1], u, epsilon = eu + weight);
        assert_abs_diff_eq!(hit.weights[2], v, epsilon = ev + weight);
        assert_abs_diff_eq!(hit.t, t, epsilon = et + distance);
        // The interval (0, t_max) is open.
        assert_eq!(watertight(&ray, triangle, hit.t), None);
        assert_eq!(watertight(&ray, triangle, hit.t.next_up()), Some(hit));
    });
}

#[test]
fn distances_are_in_units_of_the_direction_from_either_side() {
    let up = Ray::new(DVec3::new(0.25, 0.5, -2.0), 2.0 * DVec3::Z);
    assert_eq!(moller_trumbore(&up, STANDARD), Some((1.0, 0.25, 0.5)));
    let hit = watertight(&up, STANDARD, 3.0).expect("a hit");
    assert_eq!((hit.t, hit.weights), (1.0, [0.25, 0.25, 0.5]));
}

#[test]
fn borders_belong_to_the_triangle() {
    for (x, y) in [
        (0.0, 0.0),
        (1.0, 0.0),
        (0.0, 1.0),
        (0.5, 0.0),
        (0.0, 0.5),
        (0.5, 0.5),
    ] {
        assert_eq!(moller_trumbore(&down(x, y), STANDARD), Some((2.0, x, y)));
        let hit = watertight(&down(x, y), STANDARD, 3.0).expect("a border hit");
        assert_eq!(hit.weights, [1.0 - x - y, x, y]);
    }
    let e = f64::EPSILON;
    for (x, y) in [
        (-e, 0.5),
        (0.5, -e),
        (0.5, 0.5 + e),
        (2.0, 2.0),
        (-1.0, 2.0),
    ] {
        assert_eq!(moller_trumbore(&down(x, y), STANDARD), None, "({x}, {y})");
        assert_eq!(watertight(&down(x, y), STANDARD, 3.0), None, "({x}, {y})");
    }
}

#[test]
fn no_hit_behind_parallel_or_on_a_triangle_without_area() {
    let away = Ray::new(DVec3::new(0.25, 0.25, 2.0), DVec3::Z);
    let parallel = Ray::new(DVec3::new(-1.0, 0.25, 1.0), DVec3::X);
    let in_plane = Ray::new(DVec3::new(-1.0, 0.25, 0.0), DVec3::X);
    let on_plane = Ray::new(DVec3::new(0.25, 0.25, 0.0), DVec3::Z);
    for ray in [away, parallel, in_plane, on_plane] {
        assert_eq!(moller_trumbore(&ray, STANDARD), None, "{ray:?}");
        assert_eq!(watertight(&ray, STANDARD, f64::INFINITY), None, "{ray:?}");
    }
    for degenerate in [[DVec3::ZERO, DVec3::X, 2.0 * DVec3::X], [DVec3::ZERO; 3]] {
        assert_eq!(moller_trumbore(&down(0.5, 0.0), degenerate), None);
        assert_eq!(watertight(&down(0.5, 0.0), degenerate, 3.0), None);
    }
}

/// Edge values that are rounded to zero make no hit on a triangle that the ray passes far away.
#[test]
fn no_hit_beside_a_triangle_that_is_tiny_or_seen_edge_on() {
    let up = Ray::new(DVec3::ZERO, DVec3::Z);
    for triangle in slivers_beside_z(f64::EPSILON) {
        let hit = watertight(&up, triangle, f64::INFINITY);
        assert_eq!(hit, None, "{triangle:?}");
    }
}
