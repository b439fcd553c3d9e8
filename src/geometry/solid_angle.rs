//! Shapes seen from a point: their solid angle in closed form, and points whose directions are
//! uniform in it. The pdf of such a direction is 1/solid angle.
//!
//! Lengths are in scene units, solid angles in steradians. Every constructor returns `None` where
//! the shape cannot be sampled this way: seen from behind, from within, or smaller than
//! [`MIN_SOLID_ANGLE`].

use std::f64::consts::TAU;

use glam::DVec3;

use super::shape::Sphere;
use crate::math::frame::Frame;
use crate::math::real::{MaskOf, Real, Vector, sin_cos_of_turn};

/// Solid angle, sr, below which a shape is not sampled by solid angle: sums of angles lose digits
/// there (at most 1e-9 of the solid angle above it), and the density of points uniform in area
/// hardly varies.
pub const MIN_SOLID_ANGLE: f64 = 1e-6;

/// Largest cosine between the edges of a parallelogram that counts as a rectangle.
const MAX_CORNER_COSINE: f64 = 1e-12;

fn if_large_enough(solid_angle: f64) -> Option<f64> {
    (solid_angle > MIN_SOLID_ANGLE).then_some(solid_angle)
}

/// A rectangle seen from a point, [`crate::equation::LIGHT_RECTANGLE`].
#[derive(Clone, Copy, Debug)]
pub struct SphericalRectangle {
    corner: DVec3,
    edges: [DVec3; 2],
    /// Ends of the rectangle along its edges, and the height of the point above its plane.
    x: [f64; 2],
    y: [f64; 2],
    height: f64,
    /// Sines of the inclinations of the planes through the point and the edges y₀ and y₁.
    planes: [f64; 2],
    /// Excess over π of the angles at the two corners at x₀, radians.
    left: f64,
    /// Solid angle of the rectangle.
    pub solid_angle: f64,
}

impl SphericalRectangle {
    /// Creates the rectangle from `corner` along perpendicular `edges`, seen from a point on the
    /// side to which `edges[0] × edges[1]` points. `None` for other parallelograms, too.
    #[inline]
    pub fn new(from: DVec3, corner: DVec3, edges: [DVec3; 2]) -> Option<Self> {
        let lengths = edges.map(DVec3::length);
        let [ex, ey] = [edges[0] / lengths[0], edges[1] / lengths[1]];
        let to_corner = corner - from;
        let height = -ex.cross(ey).dot(to_corner);
        if ex.dot(ey).abs() > MAX_CORNER_COSINE || height <= 0.0 {
            return None;
        }
        let span = |axis: DVec3, length: f64| {
            let start = axis.dot(to_corner);
            [start, start + length]
        };
        let (x, y) = (span(ex, lengths[0]), span(ey, lengths[1]));
        // The z components of the inward unit normals of the planes through the point and each
        // edge.
        let z = |at: f64| at / (at * at + height * height).sqrt();
        let [left, right, below, above] = [-z(x[0]), z(x[1]), -z(y[0]), z(y[1])];
        // A corner's angle exceeds π/2 by the arc sine of the product of its two planes'
        // components.
        let corners_left = (above * left).asin() + (left * below).asin();
        let corners_right = (below * right).asin() + (right * above).asin();
        Some(Self {
            corner,
            edges,
            x,
            y,
            height,
            planes: [below, above],
            left: corners_left,
            solid_angle: if_large_enough(corners_left + corners_right)?,
        })
    }

    /// Maps two uniform numbers to a point of the rectangle, uniform in solid angle.
    #[inline]
    pub fn sample(&self, [r1, r2]: [f64; 2]) -> DVec3 {
        // The arc at x that leaves the fraction r₁ of the solid angle to its left.
        let (sin, cos) = (self.left - r1 * self.solid_angle).sin_cos();
        let [below, above] = self.planes;
        let slope = cos * below + above;
        let radicand = slope * slope - (1.0 - below * below) * sin * sin;
        let x = -self.height * sin * slope.signum() / radicand.max(f64::MIN_POSITIVE).sqrt();
        let x = x.clamp(self.x[0], self.x[1]);
        // Along the arc the measure is that of the sine of the elevation.
        let distance = (x * x + self.height * self.height).sqrt();
        let [start, end] = self.y.map(|y| y / (distance * distance + y * y).sqrt());
        let sine = start + r2 * (end - start);
        let cosine = (1.0 - sine * sine).max(f64::MIN_POSITIVE).sqrt();
        let y = (distance * sine / cosine).clamp(self.y[0], self.y[1]);
        let share = |at: f64, [start, end]: [f64; 2]| (at - start) / (end - start);
        self.corner + share(x, self.x) * self.edges[0] + share(y, self.y) * self.edges[1]
    }
}

/// Returns the solid angle of a triangle with unit vectors a, b, c to its vertices, negative if
/// they run clockwise seen from the origin (van Oosterom and Strackee 1983):
/// [`crate::equation::SOLID_ANGLE`].
#[inline]
pub fn triangle(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    2.0 * a
        .dot(b.cross(c))
        .atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

/// A triangle seen from a point, [`crate::equation::LIGHT_TRIANGLE`].
#[derive(Clone, Copy, Debug)]
pub struct SphericalTriangle {
    vertices: [DVec3; 3],
    /// Vectors from the point to the vertices.
    to: [DVec3; 3],
    /// Unit vectors to the vertices.
    directions: [DVec3; 3],
    /// Solid angle of the triangle.
    pub solid_angle: f64,
}

impl SphericalTriangle {
    /// Creates the triangle with these vertices, seen from a point from which they run
    /// counter-clockwise.
    #[inline]
    pub fn new(from: DVec3, vertices: [DVec3; 3]) -> Option<Self> {
        let to = vertices.map(|v| v - from);
        let directions = to.map(DVec3::normalize_or_zero);
        let [a, b, c] = directions;
        Some(Self {
            vertices,
            to,
            directions,
            // A front that faces the point runs clockwise around the outward direction.
            solid_angle: if_large_enough(triangle(a, c, b))?,
        })
    }

    /// Maps two uniform numbers to a point of the triangle, uniform in solid angle.
    #[inline]
    pub fn sample(&self, [r1, r2]: [f64; 2]) -> DVec3 {
        let [a, c, b] = self.directions;
        // The vertex C' on the arc AC for which the triangle A, B, C' has the fraction r₁: its
        // half-angle along the arc from the formula of the solid angle, which is linear in its
        // tangent.
        let tangent = perpendicular(a, c);
        let (sin, cos) = (0.5 * r1 * self.solid_angle).sin_cos();
        let over = sin * (1.0 + a.dot(b));
        let under = cos * a.dot(b.cross(tangent)) - sin * b.dot(tangent);
        let scale = 1.0 / (over * over + under * under);
        let vertex =
            (under * under - over * over) * scale * a + 2.0 * over * under * scale * tangent;
        // On the arc from B to it the measure is that of one minus the cosine.
        let one_minus_cos = 0.5 * r2 * (vertex - b).length_squared();
        let along = (one_minus_cos * (2.0 - one_minus_cos)).max(0.0).sqrt();
        let direction = (1.0 - one_minus_cos) * b + along * perpendicular(b, vertex);
        // Intersection with the plane, in barycentric coordinates: on the triangle despite
        // rounding.
        let [p, q, r] = self.to;
        let weights = [q.cross(r), r.cross(p), p.cross(q)].map(|n| (-n.dot(direction)).max(0.0));
        let [u, v, w] = weights.map(|w| w / (weights[0] + weights[1] + weights[2]));
        u * self.vertices[0] + v * self.vertices[1] + w * self.vertices[2]
    }
}

/// Returns the unit vector perpendicular to the unit vector `a` towards `b`; zero if they are
/// parallel.
#[inline]
fn perpendicular(a: DVec3, b: DVec3) -> DVec3 {
    let way = b - a;
    (way - way.dot(a) * a).normalize_or_zero()
}

/// The cap of a sphere that is visible from a point outside, [`crate::equation::LIGHT_SPHERE`].
#[derive(Clone, Copy, Debug)]
pub struct VisibleCap<V: Vector = DVec3> {
    centre: DVec3,
    radius: f64,
    /// Frame around the direction from the centre to the point.
    frame: Frame<V>,
    /// Sine and cosine of the cone's half-angle.
    sine: V::Real,
    cosine: V::Real,
    /// Solid angle of the cap.
    pub solid_angle: V::Real,
}

impl VisibleCap {
    /// Creates the cap of a whole sphere with its normal outward; `None` for zones and inward
    /// normals, too.
    #[inline]
    pub fn new(from: DVec3, sphere: &Sphere) -> Option<Self> {
        let (cap, exists) = Self::of(from, sphere)?;
        exists.then_some(cap)
    }
}

impl<V: Vector> VisibleCap<V> {
    /// Returns the caps from several points, and which of the points see one; `None` for zones and
    /// inward normals.
    #[inline]
    pub fn of(from: V, sphere: &Sphere) -> Option<(Self, MaskOf<V>)> {
        let Sphere { centre, radius, .. } = *sphere;
        if sphere.inward || sphere.heights() != [-radius, radius] {
            return None;
        }
        let all = V::Real::splat;
        let to_point = from - V::splat_vector(centre);
        let distance = to_point.length_squared().sqrt();
        let sine = all(radius) / distance;
        let cosine = ((distance - radius) * (distance + radius)).sqrt() / distance;
        // 2π(1 − cos), without its cancellation.
        let solid_angle = sine * TAU * sine / (cosine + 1.0);
        let exists = distance.cmpgt(all(radius)) & solid_angle.cmpgt(all(MIN_SOLID_ANGLE));
        let frame = Frame::new(to_point * distance.recip());
        Some((
            Self {
                centre,
                radius,
                frame,
                sine,
                cosine,
                solid_angle,
            },
            exists,
        ))
    }

    /// Maps two uniform numbers to a point of the cap, uniform in solid angle.
    #[inline]
    pub fn sample(&self, [r1, r2]: [V::Real; 2]) -> V {
        let (sine, cosine, one) = (self.sine, self.cosine, V::Real::splat(1.0));
        // 1 − cos θ of the direction, then sin θ over the sine of the cone.
        let one_minus_cos = r1 * sine * sine / (cosine + 1.0);
        let square = r1 * (V::Real::splat(2.0) - one_minus_cos) / (cosine + 1.0);
        let (ratio, rest) = (
            square.sqrt(),
            (one - square).maximum(V::Real::splat(0.0)).sqrt(),
        );
        // The angle at the centre is the arc sine of that ratio minus θ.
        let (sin_theta, cos_theta) = (ratio * sine, one - one_minus_cos);
        let sin = (ratio * cos_theta - rest * sin_theta).maximum(V::Real::splat(0.0));
        let cos = rest * cos_theta + ratio * sin_theta;
        let (sin_phi, cos_phi) = sin_cos_of_turn(r2);
        let normal = self.frame.world(V::of([sin * cos_phi, sin * sin_phi, cos]));
        V::splat_vector(self.centre) + normal * V::Real::splat(self.radius)
    }
}
