//! Rays, triangles and spheres: equations (1)-(7) as readable functions, and the stable forms that
//! the renderer uses.

use glam::DVec3;

/// A ray R(t) = O + tD, equation [`crate::equation::RAY`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// O, where the ray starts.
    pub origin: DVec3,
    /// D; a unit vector wherever t is meant as a distance.
    pub direction: DVec3,
}

impl Ray {
    /// A ray from `origin` along `direction`.
    #[inline]
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        Self { origin, direction }
    }

    /// R(t) of (1), which is also x of (6): [`crate::equation::RAY`],
    /// [`crate::equation::SPHERE_RAY`].
    #[inline]
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }
}

/// T(u, v) of (2), [`crate::equation::TRIANGLE_POINT`]; inside for u, v ≥ 0 and u + v ≤ 1.
#[inline]
pub fn triangle_point([v0, v1, v2]: [DVec3; 3], u: f64, v: f64) -> DVec3 {
    (1.0 - u - v) * v0 + u * v1 + v * v2
}

/// Left side minus right side of (3), [`crate::equation::TRIANGLE_SYSTEM`]: zero where the ray at t
/// meets the triangle's plane at (u, v).
pub fn triangle_residual(ray: &Ray, [v0, v1, v2]: [DVec3; 3], t: f64, u: f64, v: f64) -> DVec3 {
    -t * ray.direction + u * (v1 - v0) + v * (v2 - v0) - (ray.origin - v0)
}

/// (t, u, v) of (4), [`crate::equation::TRIANGLE_SOLUTION`], for t > 0 inside the triangle.
///
/// `None` for a ray that misses, lies in the plane (determinant exactly 0) or points away. There is
/// no absolute threshold on the determinant, which scales with the square of the triangle's size.
/// Readable, not watertight: the renderer uses [`crate::watertight`].
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

/// ‖x − c‖² − r² of (5), [`crate::equation::SPHERE`]: zero on the sphere, negative inside.
pub fn sphere_residual(x: DVec3, centre: DVec3, radius: f64) -> f64 {
    (x - centre).length_squared() - radius * radius
}

/// Both roots of (7) as the report prints it, [`crate::equation::SPHERE_DISTANCE`]: for a unit
/// direction, smaller root first; `None` if the line misses. Cancels badly for far spheres.
pub fn sphere_distances_printed(ray: &Ray, centre: DVec3, radius: f64) -> Option<[f64; 2]> {
    let (o_c, l) = (ray.origin - centre, ray.direction);
    let half = 2.0 * l.dot(o_c) / 2.0;
    let radicand = half * half - (o_c.length_squared() - radius * radius);
    (radicand >= 0.0).then(|| [-half - radicand.sqrt(), -half + radicand.sqrt()])
}

/// Both roots of (7), [`crate::equation::SPHERE_DISTANCE`], smaller first, for a direction of any
/// length; `None` if the line misses.
///
/// Stable form: the radicand is r² minus the squared distance of the centre from the line, and the
/// root that would cancel is the quotient of the product of the roots and the other root (Haines,
/// Günther and Akenine-Möller 2019).
#[inline]
pub fn sphere_distances(ray: &Ray, centre: DVec3, radius: f64) -> Option<[f64; 2]> {
    let o_c = ray.origin - centre;
    let a = ray.direction.length_squared();
    let half = ray.direction.dot(o_c);
    // Both times a, so that a miss costs no division.
    let to_line = a * o_c - half * ray.direction;
    let radicand = (a * radius) * (a * radius) - to_line.length_squared();
    if radicand < 0.0 {
        return None;
    }
    let far = -half - (radicand / a).sqrt().copysign(half);
    // The product of the roots is (‖o − c‖² − r²)/a.
    let product = o_c.length_squared() - radius * radius;
    let roots = if far == 0.0 { [0.0, 0.0] } else { [product / far, far / a] };
    Some(if roots[0] <= roots[1] { roots } else { [roots[1], roots[0]] })
}

/// A sphere, or the zone of it between two planes z = const, as the renderer sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// c of (5).
    pub centre: DVec3,
    /// r of (5).
    pub radius: f64,
    /// The part that exists: lower ≤ z − c_z < upper. (−∞, ∞) is the whole sphere.
    pub zone: [f64; 2],
    /// Whether the normal points to the centre, as in a cavity.
    pub inward: bool,
}

impl Sphere {
    /// The whole sphere with its normal outward.
    pub fn new(centre: DVec3, radius: f64) -> Self {
        Self { centre, radius, zone: [f64::NEG_INFINITY, f64::INFINITY], inward: false }
    }

    /// The nearest distance in (0, `t_max`) at which the ray meets the zone.
    #[inline]
    pub fn intersect(&self, ray: &Ray, t_max: f64) -> Option<f64> {
        sphere_distances(ray, self.centre, self.radius)?.into_iter().find(|&t| {
            let z = ray.origin.z + t * ray.direction.z - self.centre.z;
            t > 0.0 && t < t_max && z >= self.zone[0] && z < self.zone[1]
        })
    }

    /// The unit normal at a point of the sphere, on the side given by `inward`.
    #[inline]
    pub fn normal(&self, point: DVec3) -> DVec3 {
        let outward = (point - self.centre).normalize();
        if self.inward { -outward } else { outward }
    }

    /// Heights of the zone's ends relative to the centre, cut to [−r, r].
    pub fn heights(&self) -> [f64; 2] {
        self.zone.map(|z| z.clamp(-self.radius, self.radius))
    }

    /// Area of the zone: 2πr times its height (Archimedes).
    pub fn area(&self) -> f64 {
        let [low, high] = self.heights();
        std::f64::consts::TAU * self.radius * (high - low)
    }
}
