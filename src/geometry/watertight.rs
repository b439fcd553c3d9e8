//! A triangle test without gaps: Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection",
//! JCGT 2(1), 2013, in double precision. The readable twin is
//! [`moller_trumbore`](crate::geometry::shape::moller_trumbore), equation
//! [`crate::equation::TRIANGLE_SOLUTION`].
//!
//! Nothing leaks because each vertex is sheared and projected to two dimensions by the same rounded
//! operations, whatever triangle it belongs to, so a closed mesh stays a closed polygonal map
//! around the ray. An edge value is the difference of two rounded products. Rounding is monotone,
//! so its sign is the true sign or it is exactly zero, and zero counts as inside. Neighbours that
//! share an edge get exactly opposite values. Hence every ray that crosses the map is inside some
//! triangle.
//!
//! Edge values are also rounded to zero where the ray passes far from a triangle that is tiny or
//! seen edge-on. Where one is zero, the ray must therefore be within the triangle's
//! [bounds](in_bounds), too, as every ray is that crosses it.

use std::fmt::Debug;

use glam::DVec3;

use super::shape::Ray;
use crate::math::real::{Mask, Real};
use crate::math::simd::{Axes, PermuteAxes};

/// A projected vertex: sheared across the ray's direction, with its depth along the axis nearest to
/// that.
pub type Projected<R> = [R; 3];

/// Per-ray data of the test: the axis order and the shear that turns the direction to +z.
#[derive(Clone, Copy, Debug)]
pub struct Shear<R = f64, A = [usize; 3]> {
    origin: [R; 3],
    axes: A,
    shear: [R; 3],
}

/// [`Shear`] of several rays.
pub type LaneShear<R> = Shear<R, <<R as Real>::Vector as PermuteAxes>::Axes>;

/// A hit of the watertight test: distance in units of the direction's length, and the barycentric
/// weights of the three vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit<R = f64> {
    /// Distance t of (1).
    pub t: R,
    /// Weights of V₀, V₁, V₂; they sum to one up to rounding.
    pub weights: [R; 3],
}

impl<R: Real, A: Axes<R>> Shear<R, A> {
    /// Prepares a ray. The direction must not be zero.
    #[inline]
    pub fn new<V: PermuteAxes<Real = R, Axes = A>>(ray: &Ray<V>) -> Self {
        let axes = V::axes(ray.direction);
        let [x, y, z] = axes.permuted(ray.direction.components());
        let inverse = z.recip();
        Self {
            origin: axes.permuted(ray.origin.components()),
            axes,
            shear: [x * inverse, y * inverse, inverse],
        }
    }

    /// Returns a vertex in the ray's sheared coordinates.
    #[inline]
    pub fn project(&self, vertex: [R; 3]) -> Projected<R> {
        let ([ox, oy, oz], [sx, sy, _]) = (self.origin, self.shear);
        let [x, y, z] = self.axes.permuted(vertex);
        let z = z - oz;
        [(x - ox) - sx * z, (y - oy) - sy * z, z]
    }

    /// Returns the distance of a point at a depth, in units of the direction's length.
    #[inline]
    pub fn distance(&self, depth: R) -> R {
        depth * self.shear[2]
    }

    /// Returns the hit ahead, from either side, edges and vertices included, on the triangle of
    /// three projected vertices; t is infinite where there is none. Hits as near as rounding
    /// ([`MIN_RELATIVE_DISTANCE`]) are at the ray's origin, not ahead.
    #[inline]
    pub fn hit(&self, vertices: [&Projected<R>; 3]) -> TriangleHit<R> {
        let [a, b, c] = vertices;
        let edges = [edge(c, b), edge(a, c), edge(b, a)];
        self.hit_within(edges, [a[2], b[2], c[2]], || {
            // A copy, so that the vertices stay in registers.
            in_bounds(vertices.map(|vertex| *vertex))
        })
    }

    /// Returns the hit as [`hit`](Self::hit), from the triangle's [`edge`]s, each opposite to its
    /// vertex, and the depths of its vertices. `in_bounds` returns [`in_bounds`] of its vertices; it
    /// is called only if a ray hits with an edge of zero.
    #[inline(always)]
    pub fn hit_within(
        &self,
        [u, v, w]: [R; 3],
        depths: [R; 3],
        in_bounds: impl FnOnce() -> R::Mask,
    ) -> TriangleHit<R> {
        let zero = R::splat(0.0);
        let [lowest, highest] = [u.minimum(v).minimum(w), u.maximum(v).maximum(w)];
        let inside = !(lowest.cmplt(zero) & highest.cmpgt(zero));
        if !inside.any() {
            return TriangleHit {
                t: R::splat(f64::INFINITY),
                weights: [zero; 3],
            };
        }
        self.hit_inside(inside, [u, v, w], depths, in_bounds)
    }

    /// Returns the hits as [`hit_within`](Self::hit_within) in lanes whose edges have no two
    /// different signs.
    #[inline(always)]
    pub fn hit_inside(
        &self,
        inside: R::Mask,
        [u, v, w]: [R; 3],
        depths: [R; 3],
        in_bounds: impl FnOnce() -> R::Mask,
    ) -> TriangleHit<R> {
        let (zero, none) = (R::splat(0.0), R::splat(f64::INFINITY));
        let determinant = u + v + w;
        let inverse = determinant.recip();
        let weights = [u * inverse, v * inverse, w * inverse];
        let t =
            self.distance(weights[0] * depths[0] + weights[1] * depths[1] + weights[2] * depths[2]);
        let farthest = depths[0]
            .abs()
            .maximum(depths[1].abs())
            .maximum(depths[2].abs());
        let ahead = t.cmpgt(
            self.distance(
                farthest * R::by_precision(MIN_RELATIVE_DISTANCE, SINGLE_MIN_RELATIVE_DISTANCE),
            )
            .abs(),
        );
        // Where the determinant is zero, t is not a number, and not ahead.
        let mut hit = inside & ahead;
        let on_edge = hit & (u.cmpeq(zero) | v.cmpeq(zero) | w.cmpeq(zero));
        if on_edge.any() {
            hit = hit & (!on_edge | in_bounds());
        }
        TriangleHit {
            t: R::select(hit, t, none),
            weights,
        }
    }
}

/// Bound on the rounding of the distance at which a ray meets a triangle, relative to its farthest
/// vertex: 2⁻⁴⁸, sixteen machine epsilons.
pub const MIN_RELATIVE_DISTANCE: f64 = 1.0 / 281_474_976_710_656.0;
/// [`MIN_RELATIVE_DISTANCE`] in single precision, 2⁻¹⁹.
pub const SINGLE_MIN_RELATIVE_DISTANCE: f64 = 1.0 / 524_288.0;

/// Returns the edge function of two projected vertices, whose sign is the side on which the ray
/// passes: twice the signed area of the triangle of these two and the ray. Exchanging the vertices
/// changes the sign and nothing else.
#[inline]
pub fn edge<R: Real>(a: &Projected<R>, b: &Projected<R>) -> R {
    a[0] * b[1] - a[1] * b[0]
}

/// Returns whether the ray passes through the bounding rectangle of three projected vertices, exact
/// as comparisons are.
#[cold]
pub fn in_bounds<R: Real>([a, b, c]: [Projected<R>; 3]) -> R::Mask {
    let zero = R::splat(0.0);
    let is_between = |axis: usize| {
        let lowest = a[axis].minimum(b[axis]).minimum(c[axis]);
        let highest = a[axis].maximum(b[axis]).maximum(c[axis]);
        !(lowest.cmpgt(zero) | highest.cmplt(zero))
    };
    is_between(0) & is_between(1)
}

impl<R: Real> Shear<R, [usize; 3]> {
    /// Prepares one ray in every lane, each for another triangle. The direction must not be zero.
    #[inline]
    pub fn splat(ray: &Ray) -> Self {
        let axes = DVec3::axes(ray.direction);
        let splat = |v: DVec3| axes.permuted(v.to_array()).map(R::splat);
        let [x, y, z] = splat(ray.direction);
        let inverse = z.recip();
        Self {
            origin: splat(ray.origin),
            axes,
            shear: [x * inverse, y * inverse, inverse],
        }
    }
}

impl Shear {
    /// Returns the hit of one ray with 0 < t < `t_max` on a triangle of these vertices.
    #[inline]
    pub fn intersect(&self, vertices: [DVec3; 3], t_max: f64) -> Option<TriangleHit> {
        let [a, b, c] = vertices.map(|vertex| self.project(vertex.to_array()));
        let hit = self.hit([&a, &b, &c]);
        (hit.t < t_max).then_some(hit)
    }
}
