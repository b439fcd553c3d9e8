//! Faults of the geometry, (1)-(7).

use whitefurnace::geometry::shape::{
    sphere_distances, sphere_distances_printed, triangle_point, triangle_residual,
};

use crate::geometry::{CORRECT, Corners, Shapes, Tuv, readable, watertight};
use crate::prelude::*;

/// Counts hits behind the ray's start as well.
fn behind(ray: &Ray, v: Corners, limit: f64) -> Tuv {
    let back = Ray::new(ray.origin, -ray.direction);
    let seen = watertight(&back, v, f64::INFINITY).map(|(t, u, w)| (-t, u, w));
    watertight(ray, v, limit).or(seen)
}

/// Leaves out the test of the edge opposite V₀, so that the whole parallelogram is hit.
fn parallelogram(ray: &Ray, v: Corners, limit: f64) -> Tuv {
    let beyond = [v[1] + v[2] - v[0], v[2], v[1]];
    watertight(ray, v, limit).or_else(|| {
        let (t, u, w) = watertight(ray, beyond, limit)?;
        Some((t, 1.0 - u, 1.0 - w))
    })
}

/// Takes t from the depth of V₀ alone.
fn depth_of_corner(ray: &Ray, v: Corners, limit: f64) -> Tuv {
    let (_, u, w) = watertight(ray, v, limit)?;
    let t = (v[0] - ray.origin).dot(ray.direction) / ray.direction.length_squared();
    Some((t, u, w))
}

/// Returns whether the ray comes from the side of V₀V₁V₂ from which they run counter-clockwise.
fn front(ray: &Ray, v: Corners) -> bool {
    (v[1] - v[0]).cross(v[2] - v[0]).dot(ray.direction) < 0.0
}

/// Returns one root of (7), if it is ahead.
fn root(sphere: &Sphere, ray: &Ray, which: usize) -> Option<f64> {
    let root = sphere_distances(ray, sphere.centre, sphere.radius)?[which];
    (root > 0.0).then_some(root)
}

/// Faults of rays, triangles and spheres.
pub(super) fn faults() -> Vec<Fault<Shapes>> {
    vec![
        // Rays and triangles.
        fault!("normalised", RAY, "the direction is normalised on the way",
            Shapes: { at: |ray, t| ray.origin + t * ray.direction.normalize() }, "geometry/ray"),
        fault!("corners-exchanged", TRIANGLE_POINT, "u and v exchanged",
            Shapes: { point: |v, u, w| triangle_point(v, w, u) }, "geometry/triangle-point"),
        fault!("plus-direction", TRIANGLE_SYSTEM, "D for −D",
            Shapes: { residual: |ray, v, t, u, w| triangle_residual(ray, v, -t, u, w) },
            "geometry/triangle-system"),
        fault!("parallelogram", TRIANGLE_SOLUTION, "the edge opposite the first vertex is not tested",
            Shapes: { triangle: parallelogram }, "geometry/triangle-solution"),
        fault!("behind", TRIANGLE_SOLUTION, "t > 0 is not tested",
            Shapes: { triangle: behind }, "geometry/triangle-solution"),
        fault!("beyond", TRIANGLE_SOLUTION, "the limit of t is not tested",
            Shapes: { triangle: |ray, v, _| watertight(ray, v, f64::INFINITY) }, "geometry/triangle-solution"),
        fault!("threshold", TRIANGLE_SOLUTION, "an absolute threshold on the determinant",
            Shapes: { triangle: |ray, v, limit| {
                let determinant = ray.direction.cross(v[2] - v[0]).dot(v[1] - v[0]);
                watertight(ray, v, limit).filter(|_| determinant.abs() > 1e-8)
            } },
            "geometry/triangle-solution"),
        fault!("weights-exchanged", TRIANGLE_SOLUTION, "the weights of the second and third vertex exchanged",
            Shapes: { triangle: |ray, v, limit| watertight(ray, v, limit).map(|(t, u, w)| (t, w, u)) },
            "geometry/triangle-solution"),
        fault!("weights-turned", TRIANGLE_SOLUTION, "each weight belongs to the next vertex",
            Shapes: { triangle: |ray, v, limit| watertight(ray, v, limit).map(|(t, u, w)| (t, w, 1.0 - u - w)) },
            "geometry/triangle-solution"),
        fault!("culled", TRIANGLE_SOLUTION, "triangles seen from behind are left out",
            Shapes: { triangle: |ray, v, limit| watertight(ray, v, limit).filter(|_| front(ray, v)) },
            "geometry/triangle-solution"),
        fault!("wound-the-other-way", TRIANGLE_SOLUTION, "triangles seen from the front are left out",
            Shapes: { triangle: |ray, v, limit| watertight(ray, v, limit).filter(|_| !front(ray, v)) },
            "geometry/triangle-solution"),
        fault!("distance-for-t", TRIANGLE_SOLUTION, "the distance, for t in units of the direction's length",
            Shapes: { triangle: |ray, v, limit| {
                let (t, u, w) = watertight(ray, v, limit)?;
                Some((t * ray.direction.length(), u, w))
            } },
            "geometry/triangle-solution"),
        fault!("depth-of-corner", TRIANGLE_SOLUTION, "t of the first vertex, not of all three by their weights",
            Shapes: { triangle: depth_of_corner }, "geometry/triangle-solution"),
        fault!("open-edges", TRIANGLE_SOLUTION, "zero counts as outside: a ray through an edge meets neither side",
            Shapes: { triangle: |ray, v, limit| {
                watertight(ray, v, limit).filter(|(_, u, w)| *u > 0.0 && *w > 0.0 && 1.0 - u - w > 0.0)
            } },
            "geometry/triangle-edges"),
        fault!("not-watertight", TRIANGLE_SOLUTION,
            "the readable form, whose neighbours round an edge each in its own way",
            Shapes: { triangle: readable }, "geometry/triangle-edges"),
        // Spheres.
        fault!("radius-not-squared", SPHERE, "r for r²",
            Shapes: { sphere: |x, c, r| (x - c).length_squared() - r }, "geometry/sphere"),
        fault!("minus-direction", SPHERE_RAY, "x = o − dl",
            Shapes: { at: |ray, t| ray.origin - t * ray.direction }, "geometry/sphere-ray"),
        fault!("unit-direction", SPHERE_DISTANCE, "as printed: the direction is taken to be a unit vector",
            Shapes: { distances: sphere_distances_printed }, "geometry/sphere-distance: both roots"),
        fault!("roots-exchanged", SPHERE_DISTANCE, "the root with + first",
            Shapes: { distances: |ray, c, r| sphere_distances(ray, c, r).map(|[a, b]| [b, a]) },
            "geometry/sphere-distance: both roots"),
        fault!("far-root", SPHERE_DISTANCE, "the far side of the sphere is seen",
            Shapes: { nearest: |sphere, ray| root(sphere, ray, 1) }, "geometry/sphere-distance: the root that is seen"),
        fault!("near-root-only", SPHERE_DISTANCE,
            "the root with − alone: from within, the sphere is not seen",
            Shapes: { nearest: |sphere, ray| root(sphere, ray, 0) }, "geometry/sphere-distance: the root that is seen"),
    ]
}
