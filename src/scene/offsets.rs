//! How far from surfaces and edges rays start and end, and how small things may be for that.

use glam::DVec3;

use super::{Part, PartShape};
use crate::real::{Real, Vector};
use crate::shape::Ray;

/// A hit on a triangle lies at least this far from each edge, as a share of the height over it.
///
/// Rounding can put a point on an edge of a closed room outside the room, where its next ray is
/// lost. The share of points that moves is about 10⁻⁹ of a triangle, by at most 2⁻³¹ of its size:
/// no trial could see it.
pub const EDGE_MARGIN: f64 = 1.0 / 4_294_967_296.0;
/// Rays leave a surface from this far above it, relative to the largest coordinate of the scene:
/// some thousand roundings of a hit point, and a thousandth of [`EDGE_MARGIN`]'s step.
pub const OFFSET: f64 = 1.0 / 1_099_511_627_776.0;
/// In single precision shadow rays end this far above an emitter, relative to the largest
/// coordinate of the scene: 2⁻¹⁸, sixty-four roundings of the longest of them.
pub const SINGLE_END: f64 = 1.0 / 262_144.0;
/// In single precision rays leave a primitive from this far above it, relative to its reach (the
/// largest sum of a point's coordinates, each times the unit normal's and without sign): 2⁻²⁰,
/// sixteen roundings, twice the error of a point on it. Where surfaces touch, what leaves one of
/// them nearer than that to the other starts behind it: of a ball on the floor the lowest part,
/// whose share of its area is that distance over its diameter.
pub const SINGLE_OFFSET: f64 = 1.0 / 1_048_576.0;
/// In single precision rays leave a primitive from at least this far above it, relative to the
/// largest coordinate of the scene: 2⁻²⁴, one rounding.
pub const SINGLE_LEAST_OFFSET: f64 = 1.0 / 16_777_216.0;
/// In single precision the least distance of a hit from each edge, relative to the largest
/// coordinate: 2⁻¹⁶. That is more than [`SINGLE_NEAREST`](crate::watertight::SINGLE_NEAREST) of the
/// largest triangle, so that a wall is met that rises over the edge, and eight offsets or more, so
/// that no ray starts behind one that rises at more than ten degrees.
pub const SINGLE_EDGE_MARGIN: f64 = 16.0 * SINGLE_OFFSET;
/// In single precision the most that a hit is moved inwards by [`SINGLE_EDGE_MARGIN`], as a share
/// of a triangle's least height.
pub const SINGLE_LARGEST_MARGIN: f64 = 1.0 / 16.0;

/// A multiple of [`OFFSET`], or as large a one of [`SINGLE_END`] in single precision.
#[inline]
pub(crate) fn offset_in<R: Real>(offset: f64) -> R {
    R::by_precision(offset, offset * (SINGLE_END / OFFSET))
}

/// A surface point from which rays leave.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place<V: Vector> {
    /// The point.
    pub point: V,
    /// The unit normal.
    pub normal: V,
    /// The distance from the surface at which rays start.
    pub offset: V::Real,
}

impl<V: Vector> Place<V> {
    /// The ray that leaves from the side to which `direction` points.
    #[inline]
    pub fn leave(&self, direction: V) -> Ray<V> {
        let offset = self.offset.copysign(self.normal.dot(direction));
        Ray::new(self.point + self.normal * offset, direction)
    }

    /// The segment to another surface point, as a ray that ends at t = 1.
    #[inline]
    pub fn segment(&self, other: &Self) -> Ray<V> {
        let start = self.leave(other.point - self.point).origin;
        let end = other.leave(self.point - other.point).origin;
        Ray::new(start, end - start)
    }
}

/// The least radius of a sphere, height of a zone of one, and longest edge of a triangle, relative
/// to the largest coordinate: a thousand times the [`OFFSET`] from which rays start.
pub const SMALLEST_DETAIL: f64 = 1024.0 * OFFSET;

/// The point of a triangle with these barycentric weights, inside by a margin such as
/// [`EDGE_MARGIN`].
#[inline]
pub(crate) fn inner_point<V: Vector>(
    [a, b, c]: [V; 3],
    weights: [V::Real; 3],
    margin: V::Real,
) -> V {
    let weights = weights.map(|weight| weight.at_least(margin));
    let scale = (weights[0] + weights[1] + weights[2]).recip();
    (a * weights[0] + b * weights[1] + c * weights[2]) * scale
}

pub(super) fn longest_edge([a, b, c]: [DVec3; 3]) -> f64 {
    [b - a, c - b, a - c]
        .map(DVec3::length)
        .into_iter()
        .fold(0.0, f64::max)
}

/// [`Scene::smallest_detail`] of these parts.
pub(super) fn smallest_detail(parts: &[Part], vertices: &[DVec3]) -> f64 {
    // Each vertex names one before it of the same thing, or itself.
    let mut before: Vec<u32> = (0..vertices.len() as u32).collect();
    fn first_of(before: &mut [u32], mut vertex: u32) -> u32 {
        while before[vertex as usize] != vertex {
            before[vertex as usize] = before[before[vertex as usize] as usize];
            vertex = before[vertex as usize];
        }
        vertex
    }
    let mut smallest = f64::INFINITY;
    for part in parts {
        match part.shape {
            PartShape::Sphere(sphere) => {
                let [low, high] = sphere.heights();
                smallest = smallest.min(sphere.radius).min(high - low);
            }
            PartShape::Triangle {
                vertices: corners, ..
            } => {
                let firsts = corners.map(|corner| first_of(&mut before, corner));
                let first = firsts.into_iter().fold(u32::MAX, u32::min);
                firsts
                    .into_iter()
                    .for_each(|of| before[of as usize] = first);
            }
        }
    }
    let mut boxes = vec![[DVec3::INFINITY, DVec3::NEG_INFINITY]; vertices.len()];
    for part in parts {
        if let PartShape::Triangle {
            vertices: corners, ..
        } = part.shape
        {
            let of = &mut boxes[first_of(&mut before, corners[0]) as usize];
            for corner in corners.map(|corner| vertices[corner as usize]) {
                *of = [of[0].min(corner), of[1].max(corner)];
            }
        }
    }
    let second = |[low, high]: [DVec3; 2]| {
        let mut extents = (high - low).to_array();
        extents.sort_by(f64::total_cmp);
        extents[1]
    };
    boxes
        .into_iter()
        .filter(|[low, high]| low.x <= high.x)
        .map(second)
        .fold(smallest, f64::min)
}
