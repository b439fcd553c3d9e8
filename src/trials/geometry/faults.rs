//! Faults of (1)-(7).

use super::{Corners, RIGHT, Shapes, Solution};
use crate::equation::{
    RAY, SPHERE, SPHERE_DISTANCE, SPHERE_RAY, TRIANGLE_POINT, TRIANGLE_SOLUTION, TRIANGLE_SYSTEM,
};
use crate::shape::{
    Ray, moller_trumbore, sphere_distances, sphere_distances_printed, triangle_point,
    triangle_residual,
};
use crate::zoo::{Mutant, mutant};

/// The faults.
pub(super) fn faults() -> Vec<Mutant<Shapes>> {
    let mut faults = triangle_faults();
    faults.extend(sphere_faults());
    faults
}

/// (4) with its last conditions left to the caller.
fn plane(ray: &Ray, [v0, v1, v2]: Corners) -> Option<(f64, f64, f64)> {
    let (e1, e2, t) = (v1 - v0, v2 - v0, ray.origin - v0);
    let (p, q) = (ray.direction.cross(e2), t.cross(e1));
    let d = p.dot(e1);
    (d != 0.0).then(|| (q.dot(e2) / d, p.dot(t) / d, q.dot(ray.direction) / d))
}

/// (4) without the test of the sum.
fn parallelogram(ray: &Ray, v: Corners) -> Option<(f64, f64, f64)> {
    let unit = 0.0..=1.0;
    plane(ray, v).filter(|(t, u, w)| *t > 0.0 && unit.contains(u) && unit.contains(w))
}

/// (4) without the test of the sign of t.
fn behind(ray: &Ray, v: Corners) -> Option<(f64, f64, f64)> {
    plane(ray, v).filter(|&(_, u, w)| u >= 0.0 && w >= 0.0 && u + w <= 1.0)
}

/// (4) with an absolute threshold on the determinant.
fn threshold(ray: &Ray, v: Corners) -> Option<(f64, f64, f64)> {
    let determinant = ray.direction.cross(v[2] - v[0]).dot(v[1] - v[0]);
    moller_trumbore(ray, v).filter(|_| determinant.abs() > 1e-8)
}

fn triangle_faults() -> Vec<Mutant<Shapes>> {
    let solution = |name, wrong, triangle: Solution| {
        let subject = Shapes { triangle, ..RIGHT };
        let caught_by: &[&str] = &["geometry/triangle-solution"];
        mutant(name, &TRIANGLE_SOLUTION, wrong, subject, caught_by)
    };
    vec![
        mutant(
            "normalised",
            &RAY,
            "the direction is normalised on the way",
            Shapes {
                at: |ray, t| ray.origin + t * ray.direction.normalize(),
                ..RIGHT
            },
            &["geometry/ray"],
        ),
        mutant(
            "weights-turned",
            &TRIANGLE_POINT,
            "u and v exchanged",
            Shapes {
                point: |v, u, w| triangle_point(v, w, u),
                ..RIGHT
            },
            &["geometry/triangle-point"],
        ),
        mutant(
            "plus-direction",
            &TRIANGLE_SYSTEM,
            "D for −D",
            Shapes {
                residual: |ray, v, t, u, w| triangle_residual(ray, v, -t, u, w),
                ..RIGHT
            },
            &["geometry/triangle-system"],
        ),
        solution("parallelogram", "u + v ≤ 1 is not tested", parallelogram),
        solution("behind", "t > 0 is not tested", behind),
        solution(
            "threshold",
            "an absolute threshold on the determinant",
            threshold,
        ),
        solution("exchanged", "u and v exchanged", |ray, v| {
            moller_trumbore(ray, v).map(|(t, u, w)| (t, w, u))
        }),
        solution(
            "culled",
            "triangles seen from behind are left out",
            |ray, v| {
                let normal = (v[1] - v[0]).cross(v[2] - v[0]);
                moller_trumbore(ray, v).filter(|_| normal.dot(ray.direction) < 0.0)
            },
        ),
    ]
}

fn sphere_faults() -> Vec<Mutant<Shapes>> {
    vec![
        mutant(
            "radius-not-squared",
            &SPHERE,
            "r for r²",
            Shapes {
                sphere: |x, c, r| (x - c).length_squared() - r,
                ..RIGHT
            },
            &["geometry/sphere"],
        ),
        mutant(
            "minus-direction",
            &SPHERE_RAY,
            "x = o − dl",
            Shapes {
                at: |ray, t| ray.origin - t * ray.direction,
                ..RIGHT
            },
            &["geometry/sphere-ray"],
        ),
        mutant(
            "unit-direction",
            &SPHERE_DISTANCE,
            "as printed: the direction is taken to be a unit vector",
            Shapes {
                distances: sphere_distances_printed,
                ..RIGHT
            },
            &["geometry/sphere-distance: both roots"],
        ),
        mutant(
            "roots-exchanged",
            &SPHERE_DISTANCE,
            "the root with + first",
            Shapes {
                distances: |ray, c, r| sphere_distances(ray, c, r).map(|[a, b]| [b, a]),
                ..RIGHT
            },
            &["geometry/sphere-distance: both roots"],
        ),
        mutant(
            "far-root",
            &SPHERE_DISTANCE,
            "the far side of the sphere is seen",
            Shapes {
                nearest: |sphere, ray| {
                    let [_, far] = sphere_distances(ray, sphere.centre, sphere.radius)?;
                    (far > 0.0).then_some(far)
                },
                ..RIGHT
            },
            &["geometry/sphere-distance: the root that is seen"],
        ),
        mutant(
            "near-root-only",
            &SPHERE_DISTANCE,
            "the root with − alone: from within, the sphere is not seen",
            Shapes {
                nearest: |sphere, ray| {
                    let [near, _] = sphere_distances(ray, sphere.centre, sphere.radius)?;
                    (near > 0.0).then_some(near)
                },
                ..RIGHT
            },
            &["geometry/sphere-distance: the root that is seen"],
        ),
    ]
}
