//! Rays, triangles and spheres: equations (1)-(7) as readable functions, and the stable forms that
//! the renderer uses.

use glam::DVec3;

use crate::math::real::{Mask, MaskOf, Real, Vector};

/// A ray R(t) = O + tD, equation [`crate::equation::RAY`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray<V = DVec3> {
    /// Origin O.
    pub origin: V,
    /// Direction D; a unit vector wherever t is a distance.
    pub direction: V,
}

impl<V: Vector> Ray<V> {
    /// Creates a ray from `origin` along `direction`.
    #[inline]
    pub fn new(origin: V, direction: V) -> Self {
        Self { origin, direction }
    }

    /// Creates a ray from a function of the lane.
    #[inline]
    pub(crate) fn from_fn(lane: impl Fn(usize) -> Ray) -> Self {
        Self::new(
            V::from_fn(|i| lane(i).origin),
            V::from_fn(|i| lane(i).direction),
        )
    }

    /// Returns the ray of a lane.
    #[inline]
    pub(crate) fn lane(&self, lane: usize) -> Ray {
        Ray::new(self.origin.lane(lane), self.direction.lane(lane))
    }

    /// Returns `yes` in the lanes of the mask, and `no` elsewhere.
    #[inline]
    pub(crate) fn select(mask: MaskOf<V>, yes: &Self, no: &Self) -> Self {
        Self::new(
            V::select(mask, yes.origin, no.origin),
            V::select(mask, yes.direction, no.direction),
        )
    }

    /// Returns R(t) of (1), which is also x of (6): [`crate::equation::RAY`],
    /// [`crate::equation::SPHERE_RAY`].
    #[inline]
    pub fn at(&self, t: V::Real) -> V {
        self.origin + self.direction * t
    }
}

/// Returns T(u, v) of (2), [`crate::equation::TRIANGLE_POINT`]; inside for u, v ≥ 0 and u + v ≤ 1.
#[inline]
pub fn triangle_point<R: Real>(vertices: [DVec3; 3], u: R, v: R) -> R::Vector {
    let [v0, v1, v2] = vertices.map(R::Vector::splat_vector);
    v0 * (R::splat(1.0) - u - v) + v1 * u + v2 * v
}

/// Returns the left side minus the right side of (3), [`crate::equation::TRIANGLE_SYSTEM`]: zero
/// where the ray at t meets the triangle's plane at (u, v).
pub fn triangle_residual(ray: &Ray, [v0, v1, v2]: [DVec3; 3], t: f64, u: f64, v: f64) -> DVec3 {
    -t * ray.direction + u * (v1 - v0) + v * (v2 - v0) - (ray.origin - v0)
}

/// Returns (t, u, v) of (4), [`crate::equation::TRIANGLE_SOLUTION`], for t > 0 inside the triangle.
///
/// `None` for a ray that misses, lies in the plane (determinant exactly 0) or points away. There is
/// no absolute threshold on the determinant, which scales with the square of the triangle's size.
/// Readable, not watertight: the renderer uses [`crate::geometry::watertight`].
pub fn moller_trumbore(ray: &Ray, [v0, v1, v2]: [DVec3; 3]) -> Option<(f64, f64, f64)> {
    let (e1, e2) = (v1 - v0, v2 - v0);
    let t_vector = ray.origin - v0;
    let p = ray.direction.cross(e2);
    let q = t_vector.cross(e1);
    let determinant = p.dot(e1);
    if determinant == 0.0 {
        return None;
    }
    let [t, u, v] = [q.dot(e2), p.dot(t_vector), q.dot(ray.direction)].map(|x| x / determinant);
    (t > 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0).then_some((t, u, v))
}

/// Returns ‖x − c‖² − r² of (5), [`crate::equation::SPHERE`]: zero on the sphere, negative inside.
pub fn sphere_residual(x: DVec3, centre: DVec3, radius: f64) -> f64 {
    (x - centre).length_squared() - radius * radius
}

/// Returns both roots of (7) as the report prints it, [`crate::equation::SPHERE_DISTANCE`]: for a
/// unit direction, smaller root first; `None` if the line misses. Cancels badly for far spheres.
pub fn sphere_distances_printed(ray: &Ray, centre: DVec3, radius: f64) -> Option<[f64; 2]> {
    let (o_c, l) = (ray.origin - centre, ray.direction);
    let half = 2.0 * l.dot(o_c) / 2.0;
    let radicand = half * half - (o_c.length_squared() - radius * radius);
    (radicand >= 0.0).then(|| [-half - radicand.sqrt(), -half + radicand.sqrt()])
}

/// Returns both roots of (7), [`crate::equation::SPHERE_DISTANCE`], smaller first, for a direction
/// of any length; `None` if the line misses.
///
/// Stable form: the radicand is r² minus the squared distance of the centre from the line, and the
/// root that would cancel is the quotient of the product of the roots and the other root (Haines,
/// Günther and Akenine-Möller 2019).
#[inline]
pub fn sphere_distances(ray: &Ray, centre: DVec3, radius: f64) -> Option<[f64; 2]> {
    let (roots, meets) = sphere_roots(ray, centre, radius);
    meets.then_some(roots)
}

/// Returns both roots of (7) for one ray or several, and whether the line meets the sphere: if not,
/// the roots are NaN.
#[inline]
pub fn sphere_roots<V: Vector>(
    ray: &Ray<V>,
    centre: DVec3,
    radius: f64,
) -> ([V::Real; 2], MaskOf<V>) {
    let zero = V::Real::splat(0.0);
    let o_c = ray.origin - V::splat_vector(centre);
    let a = ray.direction.length_squared();
    let half = ray.direction.dot(o_c);
    // Both times a, so that a miss costs no division.
    let to_line = o_c * a - ray.direction * half;
    let radicand = (a * radius) * (a * radius) - to_line.length_squared();
    let meets = !radicand.cmplt(zero);
    if !meets.any() {
        return ([V::Real::splat(f64::NAN); 2], meets);
    }
    let inverse = a.recip();
    let far = -half - (radicand * inverse).sqrt().copysign(half);
    // The product of the roots is (‖o − c‖² − r²)/a.
    let product = o_c.length_squared() - radius * radius;
    let at_origin = far.cmpeq(zero);
    let [p, q] = [product / far, far * inverse].map(|root| V::Real::select(at_origin, zero, root));
    let in_order = !q.cmplt(p);
    (
        [
            V::Real::select(in_order, p, q),
            V::Real::select(in_order, q, p),
        ],
        meets,
    )
}

/// Returns the unit normal of a sphere at one of its points, away from the centre.
#[inline]
pub fn outward<V: Vector>(point: V, centre: V) -> V {
    (point - centre).normalize()
}

/// Zone that is the whole sphere.
const WHOLE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

/// A sphere, or the zone of it between two planes z = const, as the renderer uses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre c of (5).
    pub centre: DVec3,
    /// Radius r of (5).
    pub radius: f64,
    /// Part that exists: lower ≤ z − c_z < upper. (−∞, ∞) is the whole sphere.
    pub zone: [f64; 2],
    /// Whether the normal points to the centre, as in a cavity.
    pub inward: bool,
}

impl Sphere {
    /// Creates the whole sphere with its normal outward.
    pub fn new(centre: DVec3, radius: f64) -> Self {
        Self {
            centre,
            radius,
            zone: WHOLE,
            inward: false,
        }
    }

    /// Returns whether the zone is the whole sphere.
    pub fn is_whole(&self) -> bool {
        self.heights() == [-self.radius, self.radius]
    }

    /// Returns the nearest distance above 0 at which the ray meets the zone; infinite if there is
    /// none.
    #[inline]
    pub fn distance<V: Vector>(&self, ray: &Ray<V>) -> V::Real {
        let none = V::Real::splat(f64::INFINITY);
        let (roots, meets) = sphere_roots(ray, self.centre, self.radius);
        if !meets.any() {
            return none;
        }
        let [[.., o], [.., d]] = [ray.origin.components(), ray.direction.components()];
        let [near, far] = roots.map(|t| {
            let ahead = t.cmpgt(V::Real::splat(0.0)) & meets;
            if self.zone == WHOLE {
                return V::Real::select(ahead, t, none);
            }
            let z = o + t * d - self.centre.z;
            let in_zone =
                !z.cmplt(V::Real::splat(self.zone[0])) & z.cmplt(V::Real::splat(self.zone[1]));
            V::Real::select(ahead & in_zone, t, none)
        });
        near.minimum(far)
    }

    /// Returns the nearest distance in (0, `t_max`) at which the ray meets the zone.
    #[inline]
    pub fn intersect(&self, ray: &Ray, t_max: f64) -> Option<f64> {
        let t = self.distance(ray);
        (t < t_max).then_some(t)
    }

    /// Returns the unit normal at a point of the sphere, on the side given by `inward`.
    #[inline]
    pub fn normal<V: Vector>(&self, point: V) -> V {
        let outward = outward(point, V::splat_vector(self.centre));
        if self.inward { -outward } else { outward }
    }

    /// Returns the heights of the zone's ends relative to the centre, clamped to [−r, r].
    pub fn heights(&self) -> [f64; 2] {
        let r = self.radius;
        // `clamp` panics for a radius that a scene refuses later.
        self.zone.map(|z| {
            if z < -r {
                -r
            } else if z > r {
                r
            } else {
                z
            }
        })
    }

    /// Returns the area of the zone: 2πr times its height (Archimedes).
    pub fn area(&self) -> f64 {
        let [low, high] = self.heights();
        std::f64::consts::TAU * self.radius * (high - low)
    }
}

/// A point on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint<V = DVec3> {
    /// Position of the point.
    pub point: V,
    /// Unit normal.
    pub normal: V,
}

impl<V> SurfacePoint<V> {
    /// Creates a surface point with its unit normal.
    #[inline]
    pub fn new(point: V, normal: V) -> Self {
        Self { point, normal }
    }
}

impl<V: Vector> SurfacePoint<V> {
    /// Creates a surface point from a function of the lane.
    #[inline]
    pub(crate) fn from_fn(lane: impl Fn(usize) -> SurfacePoint) -> Self {
        Self::new(
            V::from_fn(|i| lane(i).point),
            V::from_fn(|i| lane(i).normal),
        )
    }

    /// Returns the surface point of a lane.
    #[inline]
    pub(crate) fn lane(&self, lane: usize) -> SurfacePoint {
        SurfacePoint::new(self.point.lane(lane), self.normal.lane(lane))
    }

    /// Returns `yes` in the lanes of the mask, and `no` elsewhere.
    #[inline]
    pub(crate) fn select(mask: MaskOf<V>, yes: Self, no: Self) -> Self {
        Self::new(
            V::select(mask, yes.point, no.point),
            V::select(mask, yes.normal, no.normal),
        )
    }
}

/// A hit of a ray on the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance from the ray's origin.
    pub t: f64,
    /// Hit point, on the surface to rounding and inside it by
    /// [`EDGE_MARGIN`](super::offsets::EDGE_MARGIN).
    pub point: DVec3,
    /// Unit geometric normal of the surface's front, whatever side was hit.
    pub normal: DVec3,
    /// Index of the primitive among [`Scene::primitives`](crate::scene::Scene::primitives).
    pub primitive: u32,
    /// Index of the [`Surface`](crate::scene::Surface).
    pub surface: u32,
    /// Index of the [`Emitter`](crate::light::emitter::Emitter), if the surface emits.
    pub emitter: Option<u32>,
}
