//! A triangle test without gaps: Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection",
//! JCGT 2(1), 2013, in double precision. The readable twin is
//! [`moller_trumbore`](crate::shape::moller_trumbore), equation
//! [`crate::equation::TRIANGLE_SOLUTION`].
//!
//! Why nothing leaks: each vertex is sheared and projected to two dimensions by the same rounded
//! operations, whatever triangle it belongs to, so a closed mesh stays a closed polygonal map around
//! the ray. An edge value is the difference of two rounded products. Rounding is monotone, so its sign
//! is the true sign or it is exactly zero, and zero counts as inside. Neighbours that share an edge get
//! exactly opposite values. Hence every ray that crosses the map is inside some triangle.

use crate::shape::Ray;

/// Vertices padded to four numbers, so that an axis index masked with 3 needs no bounds check.
pub type Vertices = [[f64; 4]; 3];

/// What is computed once per ray: the axis order and the shear that turns the direction to +z.
#[derive(Clone, Copy, Debug)]
pub struct Shear {
    origin: [f64; 3],
    axes: [usize; 3],
    shear: [f64; 3],
}

/// A hit of the watertight test: distance in units of the direction's length, and the barycentric
/// weights of the three vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// t of (1).
    pub t: f64,
    /// Weights of V₀, V₁, V₂; they sum to one up to rounding.
    pub weights: [f64; 3],
}

impl Shear {
    /// Prepares a ray. The direction must not be zero.
    #[inline]
    pub fn new(ray: &Ray) -> Self {
        let d = ray.direction.to_array();
        let magnitude = d.map(f64::abs);
        let z = if magnitude[0] > magnitude[1] && magnitude[0] > magnitude[2] {
            0
        } else if magnitude[1] > magnitude[2] {
            1
        } else {
            2
        };
        let x = if z == 2 { 0 } else { z + 1 };
        let y = if x == 2 { 0 } else { x + 1 };
        let o = ray.origin.to_array();
        let inverse = 1.0 / d[z];
        Self { origin: [o[x], o[y], o[z]], axes: [x, y, z], shear: [d[x] * inverse, d[y] * inverse, inverse] }
    }

    /// The hit with 0 < t < `t_max`, from either side, edges and vertices included.
    #[inline]
    pub fn intersect(&self, vertices: &Vertices, t_max: f64) -> Option<TriangleHit> {
        let [kx, ky, kz] = self.axes.map(|k| k & 3);
        let [ox, oy, oz] = self.origin;
        let [sx, sy, sz] = self.shear;
        let project = |v: &[f64; 4]| {
            let z = v[kz] - oz;
            [(v[kx] - ox) - sx * z, (v[ky] - oy) - sy * z, z]
        };
        let [a, b, c] = [project(&vertices[0]), project(&vertices[1]), project(&vertices[2])];
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let determinant = u + v + w;
        if determinant == 0.0 {
            return None;
        }
        let inverse = 1.0 / determinant;
        let weights = [u * inverse, v * inverse, w * inverse];
        let t = (weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2]) * sz;
        (t > 0.0 && t < t_max).then_some(TriangleHit { t, weights })
    }
}
