//! Offsets of rays from surfaces and edges, and the smallest details they allow.

use super::shape::{Ray, SurfacePoint};
use crate::math::real::{Real, Vector};

/// Largest coordinate, radiance and image height of a scene: products of a few stay finite.
pub const LARGEST: f64 = 1e30;
/// Smallest area of a triangle or a zone of a sphere, that of a figure of side 1/[`LARGEST`]: its
/// reciprocal is finite, too.
pub const SMALLEST_AREA: f64 = 1e-60;

/// Least distance of a hit on a triangle from each edge, as a fraction of the height over it.
///
/// Rounding can put a point on an edge of a closed room outside the room, where its next ray is
/// lost. About 10⁻⁹ of a triangle's points are moved, by at most 2⁻³¹ of its size: no trial could
/// detect it.
pub const EDGE_MARGIN: f64 = 1.0 / 4_294_967_296.0;
/// Height above a surface at which rays start, relative to the largest coordinate of the scene:
/// some thousand roundings of a hit point, and a thousandth of [`EDGE_MARGIN`]'s step.
pub const OFFSET: f64 = 1.0 / 1_099_511_627_776.0;
/// Height above an emitter at which shadow rays end in single precision, relative to the largest
/// coordinate of the scene: 2⁻¹⁸, sixty-four roundings of the longest of them.
pub const SINGLE_END: f64 = 1.0 / 262_144.0;
/// Height above a primitive at which rays start in single precision, relative to its reach (the
/// largest sum of a point's absolute coordinates, each times that of the unit normal): 2⁻²⁰,
/// sixteen roundings, twice the error of a point on it. Where surfaces touch, rays that start on
/// one of them nearer than that to the other start behind it: the lowest part of a ball on the
/// floor, whose fraction of its area is that distance over its diameter.
pub const SINGLE_OFFSET: f64 = 1.0 / 1_048_576.0;
/// Least height above a primitive at which rays start in single precision, relative to the largest
/// coordinate of the scene: 2⁻²⁴, one rounding.
pub const SINGLE_LEAST_OFFSET: f64 = 1.0 / 16_777_216.0;
/// Least distance of a hit from each edge in single precision, relative to the largest coordinate:
/// 2⁻¹⁶. That is more than
/// [`SINGLE_MIN_RELATIVE_DISTANCE`](crate::geometry::watertight::SINGLE_MIN_RELATIVE_DISTANCE) of
/// the largest triangle, so that a ray hits a wall that rises over the edge, and eight offsets or
/// more, so that no ray starts behind one that rises at more than ten degrees.
pub const SINGLE_EDGE_MARGIN: f64 = 16.0 * SINGLE_OFFSET;
/// Largest distance by which [`SINGLE_EDGE_MARGIN`] moves a hit inwards, as a fraction of a
/// triangle's least height.
pub const SINGLE_LARGEST_MARGIN: f64 = 1.0 / 16.0;

/// Returns a multiple of [`OFFSET`], or the same multiple of [`SINGLE_END`] in single precision.
#[inline]
pub(crate) fn offset_in<R: Real>(offset: f64) -> R {
    R::by_precision(offset, offset * (SINGLE_END / OFFSET))
}

/// A surface point with its unit normal, and how far from it rays start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayOrigin<V: Vector> {
    /// Point.
    pub point: V,
    /// Unit normal.
    pub normal: V,
    /// Distance from the surface at which rays start.
    pub offset: V::Real,
}

impl<V: Vector> RayOrigin<V> {
    /// Returns the surface point of a lane.
    #[inline]
    pub fn lane(&self, lane: usize) -> SurfacePoint {
        SurfacePoint::new(self.point.lane(lane), self.normal.lane(lane))
    }

    /// Returns the ray that leaves from the side to which `direction` points.
    #[inline]
    pub fn spawn_ray(&self, direction: V) -> Ray<V> {
        let offset = self.offset.copysign(self.normal.dot(direction));
        Ray::new(self.point + self.normal * offset, direction)
    }

    /// Returns the segment to another surface point, as a ray that ends at t = 1.
    #[inline]
    pub fn segment(&self, other: &Self) -> Ray<V> {
        let start = self.spawn_ray(other.point - self.point).origin;
        let end = other.spawn_ray(self.point - other.point).origin;
        Ray::new(start, end - start)
    }
}

/// Returns the point of a triangle with these barycentric weights, inside by a margin such as
/// [`EDGE_MARGIN`].
#[inline]
pub(crate) fn inner_point<V: Vector>(
    [a, b, c]: [V; 3],
    weights: [V::Real; 3],
    margin: V::Real,
) -> V {
    let weights = weights.map(|weight| weight.maximum(margin));
    let scale = (weights[0] + weights[1] + weights[2]).recip();
    (a * weights[0] + b * weights[1] + c * weights[2]) * scale
}
