//! Equations (1)-(7): rays, triangles and spheres.

use approx::assert_abs_diff_eq;
use glam::DVec3;
use proptest::prelude::*;
use whitefurnace::accel::Primitive;
use whitefurnace::shape::{
    Ray, Sphere, moller_trumbore, sphere_distances, sphere_distances_printed, sphere_residual,
    triangle_point, triangle_residual,
};
use whitefurnace::watertight::{Shear, TriangleHit, Vertices};

use crate::helpers::{U, between, in_cube, point, unit};
use crate::seed::{property, rng};

const STANDARD: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];

fn vertices(triangle: [DVec3; 3]) -> Vertices {
    match Primitive::triangle(triangle) {
        Primitive::Triangle(vertices) => vertices,
        Primitive::Sphere(_) => unreachable!("a triangle was asked for"),
    }
}

fn watertight(ray: &Ray, triangle: [DVec3; 3], t_max: f64) -> Option<TriangleHit> {
    Shear::new(ray).intersect(&vertices(triangle), t_max)
}

fn down(x: f64, y: f64) -> Ray {
    Ray::new(DVec3::new(x, y, 2.0), -DVec3::Z)
}

/// A random triangle of size `scale`, a point well inside it, and a ray to it; not nearly parallel.
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
                let ray = Ray::new(origin, (target - origin).normalize());
                (ray, triangle, [u, v])
            },
        )
        .prop_filter("well conditioned", |(ray, [a, b, c], _)| {
            let (e1, e2) = (*b - *a, *c - *a);
            let det = ray.direction.dot(e1.cross(e2)).abs();
            det > 1e-3 * e1.length() * e2.length()
        })
}

/// Bounds on the errors of t, u, v of (4), to first order in `U` with the constant rounded up from
/// 10 to 12 for the rest: a cross product of differences is off by 4√2 U, its scalar product by 4 U
/// more, relative to the product of the lengths.
fn cramer_error(ray: &Ray, [a, b, c]: [DVec3; 3], [t, u, v]: [f64; 3]) -> [f64; 3] {
    let (e1, e2, to) = (b - a, c - a, ray.origin - a);
    let [l1, l2, lt, ld] = [e1, e2, to, ray.direction].map(DVec3::length);
    let det = ray.direction.cross(e2).dot(e1).abs();
    let relative = 12.0 * U * ld * l1 * l2 / det + U;
    [
        12.0 * U * lt * l1 * l2 / det + relative * t.abs(),
        12.0 * U * ld * l2 * lt / det + relative * u.abs(),
        12.0 * U * ld * l1 * lt / det + relative * v.abs(),
    ]
}

/// Bound on the error of the weights of the watertight test: projected vertices are at most 2L away
/// and off by 6 U L, so an edge value is off by 4·2·6 U L² + 2 U (2L)², the determinant by thrice that.
fn shear_error(ray: &Ray, triangle: [DVec3; 3]) -> (f64, f64) {
    let length = triangle.map(|v| (v - ray.origin).length());
    let length = length.into_iter().fold(0.0, f64::max);
    let [a, b, c] = triangle;
    let depth = ray.direction.abs().max_element();
    let det = ray.direction.dot((b - a).cross(c - a)).abs() / depth;
    let weight = 4.0 * 56.0 * U * length * length / det + 4.0 * U;
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
fn triangle_point_meets_the_vertices_and_edges() {
    property(
        "triangle_point",
        200,
        &prop::array::uniform3(point(10.0)),
        |[a, b, c]| {
            assert_eq!(triangle_point([a, b, c], 0.0, 0.0), a);
            assert_eq!(triangle_point([a, b, c], 1.0, 0.0), b);
            assert_eq!(triangle_point([a, b, c], 0.0, 1.0), c);
            // Halves are exact: only the one addition rounds, in the same way on both sides.
            assert_eq!(triangle_point([a, b, c], 0.5, 0.0), 0.5 * a + 0.5 * b);
            assert_eq!(triangle_point([a, b, c], 0.5, 0.5), 0.5 * b + 0.5 * c);
        },
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
        let bound = et + eu * l1 + ev * l2 + 6.0 * U * terms;
        let residual = triangle_residual(&ray, triangle, t, found_u, found_v).length();
        assert!(
            residual <= bound,
            "residual of (3): {residual:e} > {bound:e}"
        );
        // (2) meets (1): the same error, and rounding of the coordinates themselves.
        let apart = (triangle_point(triangle, found_u, found_v) - ray.at(t)).length();
        assert!(
            apart <= bound + 6.0 * U * (size + t),
            "(1) and (2) are {apart:e} apart"
        );
        // The aim itself is off by the rounding of the target and of the direction.
        let aim = 6.0 * U * (size + t) / ray.direction.dot((b - a).cross(c - a)).abs();
        assert_abs_diff_eq!(found_u, u, epsilon = eu + aim * l2);
        assert_abs_diff_eq!(found_v, v, epsilon = ev + aim * l1);
    });
}

#[test]
fn solution_scales_exactly() {
    // Powers of two scale every intermediate value without rounding: no threshold may depend on size.
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
            let t = hit.t * scale;
            assert_eq!(found, Some(TriangleHit { t, ..hit }));
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
fn both_tests_agree_on_misses() {
    let mut rng = rng("misses");
    let mut hits = 0;
    for _ in 0..20_000 {
        let triangle = [0; 3].map(|_| in_cube(&mut rng, 1.0));
        let [a, b, c] = triangle;
        let [u, v] = [0; 2].map(|_| between(&mut rng, -0.5, 1.5));
        let origin = in_cube(&mut rng, 2.0);
        let ray = Ray::new(
            origin,
            (triangle_point(triangle, u, v) - origin).normalize(),
        );
        let det = ray.direction.dot((b - a).cross(c - a));
        let (weight, _) = shear_error(&ray, triangle);
        let reference = moller_trumbore(&ray, triangle);
        let hit = watertight(&ray, triangle, f64::INFINITY);
        // Barycentrics by volumes: only rays that pass an edge within the bound may differ.
        let volume = |p: DVec3, q: DVec3| {
            let (p, q) = (p - ray.origin, q - ray.origin);
            ray.direction.dot(p.cross(q)) / det
        };
        let nearest = [volume(b, c), volume(c, a), volume(a, b)];
        let nearest = nearest.into_iter().fold(f64::INFINITY, f64::min);
        if nearest.abs() > 4.0 * weight {
            assert_eq!(reference.is_some(), hit.is_some(), "{ray:?} {triangle:?}");
        }
        hits += u32::from(hit.is_some());
    }
    assert!(hits > 500, "only {hits} hits: nothing was compared");
}

#[test]
fn known_solution() {
    assert_eq!(
        moller_trumbore(&down(0.25, 0.5), STANDARD),
        Some((2.0, 0.25, 0.5))
    );
    let hit = watertight(&down(0.25, 0.5), STANDARD, 3.0).expect("a hit");
    assert_eq!((hit.t, hit.weights), (2.0, [0.25, 0.25, 0.5]));
    // From below, and with a direction of length 2.
    let up = Ray::new(DVec3::new(0.25, 0.5, -2.0), 2.0 * DVec3::Z);
    assert_eq!(moller_trumbore(&up, STANDARD), Some((1.0, 0.25, 0.5)));
    assert_eq!(watertight(&up, STANDARD, 3.0).map(|hit| hit.t), Some(1.0));
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

#[test]
fn every_axis_order_of_the_shear_is_right() {
    for direction in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE] {
        for sign in [1.0, -1.0] {
            let d = sign * direction;
            let (x, y) = d.normalize().any_orthonormal_pair();
            let triangle = [-1.0 * x - y, 2.0 * x - y, 2.0 * y];
            let ray = Ray::new(-3.0 * d, d);
            let hit = watertight(&ray, triangle, 10.0).expect("aimed inside");
            assert_abs_diff_eq!(hit.t, 3.0, epsilon = shear_error(&ray, triangle).1);
        }
    }
}

/// A sphere and a ray whose line passes it at `miss` radii from the centre, from distances around the
/// radius to far away.
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
                let origin = centre + radius * (miss * side - along * direction);
                (Ray::new(origin, direction), centre, radius, miss)
            },
        )
}

/// Bound on |‖x − c‖² − r²| at a computed root: the radicand is off by 16 U r d, each root by that
/// over twice the half chord and by 8 U d more, and the point by 4 U of its coordinates. The residual
/// changes by twice the half chord per distance, which cancels the first denominator.
fn sphere_bound(ray: &Ray, centre: DVec3, radius: f64) -> f64 {
    let distance = (ray.origin - centre).length() + radius;
    let coordinates = ray.origin.length() + centre.length() + distance;
    64.0 * U * radius * (distance + coordinates) + 16.0 * U * radius * radius
}

#[test]
fn sphere_roots_lie_on_the_sphere() {
    let misses = prop_oneof![0.0..0.999, 0.999..1.0];
    property("roots", 3000, &ray_and_sphere(misses), |(ray, c, r, _)| {
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
    });
}

#[test]
fn lines_that_pass_the_sphere_have_no_roots() {
    property(
        "passing",
        1000,
        &ray_and_sphere(1.001..3.0),
        |(ray, c, r, miss)| {
            // Far away the offset itself drowns in the coordinates' rounding.
            if (miss - 1.0) * r > 8.0 * U * (ray.origin.length() + c.length()) * 1e3 {
                assert_eq!(sphere_distances(&ray, c, r), None);
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
            assert_abs_diff_eq!(t, expected, epsilon = 4.0 * U * 15.0);
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
    let strategy = (ray_and_sphere(0.0..0.99), -40i32..40);
    property("units", 500, &strategy, |((ray, c, r, _), k)| {
        let longer = Ray::new(ray.origin, ray.direction * 2f64.powi(k));
        let expected = sphere_distances(&ray, c, r).map(|roots| roots.map(|t| t * 2f64.powi(-k)));
        // Powers of four are exact throughout; odd powers meet a square root of 2^k, which is not.
        if k % 2 == 0 {
            assert_eq!(sphere_distances(&longer, c, r), expected);
        }
        for t in sphere_distances(&longer, c, r).into_iter().flatten() {
            let residual = sphere_residual(longer.at(t), c, r).abs();
            assert!(residual <= sphere_bound(&ray, c, r));
        }
    });
}

#[test]
fn printed_and_stable_roots_agree_nearby() {
    let nearby = ray_and_sphere(0.0..0.9).prop_filter("near", |(ray, c, r, _)| {
        (ray.origin - c).length() < 10.0 * r
    });
    property("printed nearby", 500, &nearby, |(ray, c, r, _)| {
        let stable = sphere_distances(&ray, c, r).expect("a hit");
        let printed = sphere_distances_printed(&ray, c, r).expect("a hit");
        // At most 10 radii away and a half chord of 0.43 radii: the printed radicand is off by
        // 8 U d², the coordinates of the origin by U of their length.
        let d = (ray.origin - c).length() + r;
        let bound = (8.0 * U * d * d + sphere_bound(&ray, c, r)) / (0.4 * r);
        for i in 0..2 {
            assert_abs_diff_eq!(stable[i], printed[i], epsilon = bound);
        }
    });
}

#[test]
fn far_spheres_are_stable() {
    // Integer origins, directions and radii: half · half − a (d² − r²) = a r² − ‖o × D‖² is an exact
    // integer, so its root gives the near distance with a relative error of 2 U.
    let mut rng = rng("far spheres");
    let mut worst = [0f64; 2];
    let mut hits = 0;
    for _ in 0..3000 {
        let integer = |rng: &mut _, half: f64| in_cube(rng, half).round();
        let (d, w) = (integer(&mut rng, 1000.0), integer(&mut rng, 30.0));
        let origin = -between(&mut rng, 100.0, 5000.0).round() * d + w;
        let radius = 50.0;
        let i = |v: DVec3| v.to_array().map(|x| x as i128);
        let ([ox, oy, oz], [dx, dy, dz]) = (i(origin), i(d));
        let a = dx * dx + dy * dy + dz * dz;
        let half = ox * dx + oy * dy + oz * dz;
        let cross = [oy * dz - oz * dy, oz * dx - ox * dz, ox * dy - oy * dx];
        let q = a * 2500 - cross.iter().map(|x| x * x).sum::<i128>();
        if a == 0 || q <= 0 {
            continue;
        }
        hits += 1;
        let chord = (q as f64).sqrt();
        let exact = (-half as f64 - chord) / a as f64;
        let ray = Ray::new(origin, d);
        let stable = sphere_distances(&ray, DVec3::ZERO, radius).expect("a hit")[0];
        // As `sphere_bound`, divided by twice the half chord, in units of ‖D‖.
        let length = d.length();
        let bound = sphere_bound(&ray, DVec3::ZERO, radius) * (a as f64) / (2.0 * chord * length);
        let error = (stable - exact).abs() * length;
        assert!(error <= bound, "near root off by {error:e} > {bound:e}");
        let unit = Ray::new(origin, d / length);
        let printed = sphere_distances_printed(&unit, DVec3::ZERO, radius);
        let printed = printed.map_or(radius, |t| (t[0] - exact * length).abs());
        worst = [worst[0].max(error), worst[1].max(printed)];
    }
    assert!(hits > 1000, "only {hits} hits");
    assert!(
        worst[1] > 1000.0 * worst[0],
        "the printed form should cancel: worst errors stable {:e}, printed {:e}",
        worst[0],
        worst[1]
    );
}

#[test]
fn zones_divide_the_sphere() {
    let strategy = (ray_and_sphere(0.0..1.5), -1.0..1.0);
    property(
        "zones",
        2000,
        &strategy,
        |((ray, c, r, _), cut): (_, f64)| {
            let whole = Sphere::new(c, r);
            let height = cut * r;
            let zone = |zone| Sphere { zone, ..whole };
            let lower = zone([f64::NEG_INFINITY, height]).intersect(&ray, f64::INFINITY);
            let upper = zone([height, f64::INFINITY]).intersect(&ray, f64::INFINITY);
            let first = match (lower, upper) {
                (Some(a), Some(b)) => Some(a.min(b)),
                (a, b) => a.or(b),
            };
            assert_eq!(first, whole.intersect(&ray, f64::INFINITY));
        },
    );
    let cap = Sphere {
        zone: [0.5, f64::INFINITY],
        ..Sphere::new(DVec3::ZERO, 1.0)
    };
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
    let below = Sphere {
        zone: [f64::NEG_INFINITY, 0.5],
        ..cap
    };
    assert!(cap.intersect(&level, 10.0).is_some());
    assert_eq!(below.intersect(&level, 10.0), None);
    assert_eq!(cap.heights(), [0.5, 1.0]);
    assert_abs_diff_eq!(cap.area(), std::f64::consts::PI, epsilon = 4.0 * U * 4.0);
}

#[test]
fn sphere_normals_are_unit_and_on_their_side() {
    let strategy = (point(10.0), unit(), -3.0..3.0);
    property("normals", 500, &strategy, |(c, n, size): (_, _, f64)| {
        let r = 10f64.powf(size);
        let outward = Sphere::new(c, r).normal(c + r * n);
        let inward = Sphere {
            inward: true,
            ..Sphere::new(c, r)
        };
        assert_eq!(inward.normal(c + r * n), -outward);
        assert_abs_diff_eq!(outward.length(), 1.0, epsilon = 6.0 * U);
        // The point is rounded relative to its coordinates, the normal relative to the radius.
        let bound = 4.0 * U * (c.length() + r) / r + 8.0 * U;
        assert!((outward - n).length() <= bound);
    });
}
