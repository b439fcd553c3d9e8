//! Rays, triangles and spheres (1)-(7), constructed backwards from known answers: exact trials,
//! without chance in their verdicts.

mod faults;

use whitefurnace::geometry::shape::{
    moller_trumbore, sphere_distances, sphere_residual, triangle_point, triangle_residual,
};
use whitefurnace::geometry::watertight::Shear;

use crate::mean_radiance::{any_direction, largest};
use crate::prelude::*;

/// The corners of a triangle.
type Corners = [DVec3; 3];
/// Finds t, u, v of a ray and a triangle, for t below a limit.
type Solution = fn(&Ray, Corners, f64) -> Tuv;
type Tuv = Option<(f64, f64, f64)>;

/// The functions of (1)-(7), each replaceable.
#[derive(Clone, Copy)]
pub struct Shapes {
    /// (1) and (6).
    pub at: fn(&Ray, f64) -> DVec3,
    /// (2).
    pub point: fn(Corners, f64, f64) -> DVec3,
    /// (3).
    pub residual: fn(&Ray, Corners, f64, f64, f64) -> DVec3,
    /// (4) as the BVH calls it.
    pub triangle: Solution,
    /// (5).
    pub sphere: fn(DVec3, DVec3, f64) -> f64,
    /// (7).
    pub distances: fn(&Ray, DVec3, f64) -> Option<[f64; 2]>,
    /// The root of (7) that a ray hits.
    pub nearest: fn(&Sphere, &Ray) -> Option<f64>,
}

const CORRECT: Shapes = Shapes {
    at: Ray::at,
    point: triangle_point,
    residual: triangle_residual,
    triangle: watertight,
    sphere: sphere_residual,
    distances: sphere_distances,
    nearest: |sphere, ray| sphere.intersect(ray, f64::INFINITY),
};

const ARGUMENTS: u64 = 10_000;
/// A few thousand roundings of numbers near 1.
const TOLERANCE: f64 = 1e-11;
/// The error of a hit that should be a miss, or a miss that should be a hit.
const HIT_OR_MISS_ERROR: f64 = 1.0;
/// Sizes of triangles and spheres.
const SIZES: [f64; 5] = [1e-4, 1e-2, 1.0, 1e2, 1e4];

/// Returns the largest error over random arguments.
fn worst(context: &Context, name: &str, mut error: impl FnMut(&mut Stream) -> f64) -> Outcome {
    let mut rng = context.rng(name);
    let worst = largest((0..context.arguments(ARGUMENTS)).map(|_| error(&mut rng)));
    Outcome::identity(
        name,
        ARGUMENTS,
        worst,
        TOLERANCE,
        "the worst of random arguments",
    )
}

fn between(rng: &mut Stream, low: f64, high: f64) -> f64 {
    low + (high - low) * uniform(rng)
}

/// Samples a triangle near the origin whose sides are about 1 and whose angles are not small.
fn corners(rng: &mut Stream) -> Corners {
    let first = any_direction(rng);
    let tilt = any_direction(rng);
    let a = first.any_orthonormal_vector();
    let b = (first.cross(a) + 0.3 * a * tilt.x).normalize();
    [first, first + a, first + b]
}

fn ray(context: &Context, shapes: Shapes) -> Vec<Outcome> {
    vec![worst(context, "R(t) − O = tD", |rng| {
        let ray = Ray::new(
            any_direction(rng),
            between(rng, 0.5, 2.0) * any_direction(rng),
        );
        let t = between(rng, -3.0, 3.0);
        let moved = (shapes.at)(&ray, t) - ray.origin;
        (moved - DVec3::from_array(ray.direction.to_array().map(|d| t * d))).length()
    })]
}

/// Tests that T is V₀, V₁, V₂ at the corners and affine in u and v.
fn point(context: &Context, shapes: Shapes) -> Vec<Outcome> {
    vec![worst(context, "T(u, v)", |rng| {
        let v = corners(rng);
        let [a, b] = [uniform(rng), uniform(rng)];
        let along = v[0] + a * (v[1] - v[0]) + b * (v[2] - v[0]);
        let at = |u, w| (shapes.point)(v, u, w);
        let ends = [
            at(0.0, 0.0) - v[0],
            at(1.0, 0.0) - v[1],
            at(0.0, 1.0) - v[2],
        ];
        ends.iter().map(|e| e.length()).sum::<f64>() + (at(a, b) - along).length()
    })]
}

/// Samples a ray that meets the triangle's plane at T(u, v) after t.
fn ray_through(rng: &mut Stream, v: Corners, [u, w]: [f64; 2], t: f64) -> Ray {
    let target = (1.0 - u - w) * v[0] + u * v[1] + w * v[2];
    let normal = (v[1] - v[0]).cross(v[2] - v[0]).normalize();
    // Not too grazing, from either side.
    let mut direction = any_direction(rng);
    while direction.dot(normal).abs() < 0.2 {
        direction = any_direction(rng);
    }
    Ray::new(target - t * direction, direction)
}

/// Tests that the residual is zero at the solution, and changes by −D, E₁, E₂ per unit of t, u, v
/// away from it.
fn system(context: &Context, shapes: Shapes) -> Vec<Outcome> {
    vec![worst(context, "left minus right of (3)", |rng| {
        let v = corners(rng);
        let [u, w, t] = [uniform(rng), uniform(rng), between(rng, 0.1, 3.0)];
        let ray = ray_through(rng, v, [u, w], t);
        let r = |t, u, w| (shapes.residual)(&ray, v, t, u, w);
        let by_t = r(t + 1.0, u, w) + ray.direction;
        let by_u = r(t, u + 1.0, w) - (v[1] - v[0]);
        let by_v = r(t, u, w + 1.0) - (v[2] - v[0]);
        [r(t, u, w), by_t, by_u, by_v]
            .iter()
            .map(|e| e.length())
            .sum()
    })]
}

/// Compares t, u, v with those from which the ray was made, for triangles of every size and
/// directions of any length. Rays beside, behind and in the plane miss, and so do those that end
/// before it.
fn solution(context: &Context, shapes: Shapes) -> Vec<Outcome> {
    vec![worst(context, "t, u, v", |rng| {
        let unit = corners(rng);
        let size = SIZES[(uniform(rng) * 5.0) as usize];
        let v = unit.map(|corner| size * corner);
        let [u, w, t] = [
            between(rng, -0.5, 1.5),
            between(rng, -0.5, 1.5),
            between(rng, -2.0, 2.0),
        ];
        let [length, limit] = [between(rng, 0.5, 2.0), between(rng, 0.0, 3.0)];
        let ray = ray_through(rng, v, [u, w], size * t);
        let ray = Ray::new(ray.origin, length * ray.direction);
        let margin = u.min(w).min(1.0 - u - w).min(t).min(limit - t);
        let found = (shapes.triangle)(&ray, v, size * limit / length);
        let in_plane = Ray::new(v[0] - (v[1] - v[0]), (v[1] - v[0]).normalize());
        let parallel = Ray::new(in_plane.origin + size * unit[0], in_plane.direction);
        if (shapes.triangle)(&parallel, v, f64::INFINITY).is_some() {
            return HIT_OR_MISS_ERROR;
        }
        match found {
            // Within rounding of a border either answer will do.
            _ if margin.abs() < 1e-6 => 0.0,
            Some((ft, fu, fv)) if margin > 0.0 => {
                (ft * length / size - t).abs() + (fu - u).abs() + (fv - w).abs()
            }
            None if margin < 0.0 => 0.0,
            _ => HIT_OR_MISS_ERROR,
        }
    })]
}

/// Tests that every ray into a closed fan of triangles meets one of them, also rays aimed at the
/// common vertex and at points of the edges as exactly as numbers allow.
fn fan(context: &Context, shapes: Shapes) -> Vec<Outcome> {
    vec![worst(context, "rays lost at edges", |rng| {
        let pick = (uniform(rng) * f64::from(SPOKES)) as usize;
        let on_grid = uniform(rng) < 0.5;
        let hub = if on_grid {
            DVec3::AXES[pick % 3]
        } else {
            any_direction(rng)
        };
        let (a, b) = hub.any_orthonormal_pair();
        let rim: Vec<DVec3> = (0..SPOKES)
            .map(|i| {
                let (sin, cos) = (TAU * f64::from(i) / f64::from(SPOKES)).sin_cos();
                if on_grid {
                    hub + cos.round() * a + sin.round() * b
                } else {
                    hub + cos * a + sin * b + 0.2 * any_direction(rng)
                }
            })
            .collect();
        // The hub, and points of a spoke.
        let along = (between(rng, -0.5, 1.0).max(0.0) * 8.0).floor() / 8.0;
        let target = hub + along * (rim[pick] - hub);
        let origin = if on_grid {
            target - hub
        } else {
            -0.5 * any_direction(rng)
        };
        // On this grid nothing is rounded, and edge values are zero.
        let ray = Ray::new(origin, target - origin);
        let met = (0..rim.len()).any(|i| {
            let corners = [hub, rim[i], rim[(i + 1) % rim.len()]];
            (shapes.triangle)(&ray, corners, f64::INFINITY).is_some()
        });
        if met { 0.0 } else { HIT_OR_MISS_ERROR }
    })]
}

/// Number of triangles of a fan.
const SPOKES: u32 = 8;

fn sphere(context: &Context, shapes: Shapes) -> Vec<Outcome> {
    vec![worst(context, "‖x − c‖² − r²", |rng| {
        let [centre, w] = [any_direction(rng), any_direction(rng)];
        let [r, s] = [between(rng, 0.2, 3.0), between(rng, 0.0, 3.0)];
        ((shapes.sphere)(centre + s * w, centre, r) - (s - r) * (s + r)).abs()
    })]
}

/// Samples a sphere and a ray that meets it at known distances: a chord between two of its points.
fn chord(rng: &mut Stream) -> (Ray, DVec3, f64, [f64; 2]) {
    let r = SIZES[(uniform(rng) * 5.0) as usize];
    let centre = 2.0 * r * any_direction(rng);
    let first = any_direction(rng);
    let mut second = any_direction(rng);
    while (second - first).length() < 0.1 {
        second = any_direction(rng);
    }
    let length = r * (second - first).length();
    let direction = (second - first).normalize();
    // From before the sphere, from within, or from beyond.
    let before = length * between(rng, -1.5, 1.5);
    let ray = Ray::new(centre + r * first - before * direction, direction);
    (ray, centre, r, [before, before + length])
}

/// Tests that x of (6) at the roots of (7) is on the sphere of (5).
fn on_sphere(context: &Context, shapes: Shapes) -> Vec<Outcome> {
    vec![worst(context, "‖o + dl − c‖ − r", |rng| {
        let (ray, centre, r, roots) = chord(rng);
        roots
            .iter()
            .map(|&d| (((shapes.at)(&ray, d) - centre).length() / r - 1.0).abs())
            .sum()
    })]
}

/// Tests both roots, for directions of any length, misses, and the root that a ray hits.
fn distances(context: &Context, shapes: Shapes) -> Vec<Outcome> {
    let roots = worst(context, "both roots", |rng| {
        let (ray, centre, r, roots) = chord(rng);
        let length = between(rng, 0.5, 2.0);
        let scaled = Ray::new(ray.origin, length * ray.direction);
        let beside = Ray::new(
            centre + 1.1 * r * ray.direction.any_orthonormal_vector(),
            ray.direction,
        );
        if (shapes.distances)(&beside, centre, r).is_some() {
            return HIT_OR_MISS_ERROR;
        }
        let error = |found: f64, root: f64| (found * length - root).abs() / r;
        (shapes.distances)(&scaled, centre, r).map_or(HIT_OR_MISS_ERROR, |[a, b]| {
            error(a, roots[0]) + error(b, roots[1])
        })
    });
    let seen = worst(context, "the root that is seen", |rng| {
        let (ray, centre, r, roots) = chord(rng);
        let expected = roots.into_iter().find(|&d| d > 0.0);
        if roots.iter().any(|d| d.abs() < 1e-6 * r) {
            return 0.0;
        }
        match ((shapes.nearest)(&Sphere::new(centre, r), &ray), expected) {
            (Some(found), Some(expected)) => (found - expected).abs() / r,
            (None, None) => 0.0,
            _ => HIT_OR_MISS_ERROR,
        }
    });
    vec![roots, seen]
}

/// The watertight test, as a solution of (4).
fn watertight(ray: &Ray, v: Corners, limit: f64) -> Tuv {
    let hit = Shear::new(ray).intersect(v, limit)?;
    Some((hit.t, hit.weights[1], hit.weights[2]))
}

/// The readable form of (4).
fn readable(ray: &Ray, v: Corners, limit: f64) -> Tuv {
    moller_trumbore(ray, v).filter(|(t, ..)| *t < limit)
}

fn trials() -> Vec<FamilyTrial<Shapes>> {
    let family_trial = |name: &str,
                        property: &str,
                        consequence: &str,
                        equation: &'static Equation,
                        on: TrialFn<Shapes>| {
        let subject = if equation == &TRIANGLE_SOLUTION {
            "geometry::watertight::Shear::intersect"
        } else {
            "shape"
        };
        trial(
            format!("geometry/{name}"),
            property,
            consequence,
            equation,
            subject,
            "exact",
            on,
        )
    };
    vec![
        family_trial(
            "ray",
            "the ray's point at t is O + tD",
            "hits lie beside surfaces, and shadows and reflections start in the wrong place",
            &RAY,
            ray,
        ),
        family_trial(
            "triangle-point",
            "T is affine and meets the corners",
            "triangles of a mesh are bent, or tied to the wrong corners",
            &TRIANGLE_POINT,
            point,
        ),
        family_trial(
            "triangle-system",
            "(3) vanishes at the solution and changes by −D, E₁, E₂",
            "meshes look sheared or mirrored: rays meet the wrong points of triangles",
            &TRIANGLE_SYSTEM,
            system,
        ),
        family_trial(
            "triangle-solution",
            "(4) recovers t, u, v at every size, and misses what it must",
            "small triangles vanish from meshes, as in jbikker/tinybvh#283",
            &TRIANGLE_SOLUTION,
            solution,
        ),
        family_trial(
            "triangle-edges",
            "a ray into a closed fan of triangles meets one, at edges and vertices, too",
            "light leaks through the seams of a mesh, as in mrdoob/three.js#33661",
            &TRIANGLE_SOLUTION,
            fan,
        ),
        family_trial(
            "sphere",
            "(5) is the difference of two squares",
            "spheres have the wrong size or position",
            &SPHERE,
            sphere,
        ),
        family_trial(
            "sphere-ray",
            "(6) is on the sphere at the ends of a chord",
            "shading and shadows on spheres are off: hits do not lie on them",
            &SPHERE_RAY,
            on_sphere,
        ),
        family_trial(
            "sphere-distance",
            "(7) recovers both ends of a chord, and the nearer one ahead is seen",
            "balls show their far side, or vanish when seen from within",
            &SPHERE_DISTANCE,
            distances,
        ),
    ]
}

/// Trials and faults of the geometry.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    vec![Box::new(Family {
        trials: trials(),
        faults: faults::faults(),
        equivalents: vec![
            fault!("readable", TRIANGLE_SOLUTION, "the readable form of (4): the same hits to rounding, away from edges",
            Shapes: { triangle: readable }, "geometry/triangle-solution"),
        ],
        ..Family::new("geometry", CORRECT)
    })]
}
