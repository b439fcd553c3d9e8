//! A kd-tree (Bentley 1975) of points, for queries of all points within a radius, always in the
//! same order.

use std::ops::Range;

use glam::DVec3;

use super::real::{Mask as _, Real as _, Vector as _};
use super::simd::{LANES, Lanes, Lanes3};

/// Points as a balanced tree without pointers: a range of points is divided near its middle by a
/// plane, and so are both halves. A short range is a leaf.
#[derive(Clone, Debug, Default)]
pub struct KdTree {
    /// All points, [`LANES`] in a chunk; the last chunk ends with padding.
    chunks: Vec<Lanes3>,
    /// Splitting planes: number i divides a range of points after the first i + 1 chunks of all
    /// points.
    planes: Vec<Plane>,
    length: usize,
}

/// A splitting plane across an axis: no point of the first half lies beyond it, none of the second
/// half before it.
#[derive(Clone, Copy, Debug, Default)]
struct Plane {
    at: f64,
    axis: u8,
}

/// A point during construction.
struct Node {
    point: DVec3,
    /// Index of the point in the list given.
    index: u32,
}

/// Length from which the two halves of a slice are built in parallel.
const MIN_PARALLEL_LENGTH: usize = 4096;
/// Largest number of points of a leaf, all of which are tested.
const MAX_LEAF_POINTS: usize = 2 * LANES;
/// Largest number of points with the same [`KdTree::approximate_index`].
const MAX_SAME_INDEX: usize = 512;

impl KdTree {
    /// Bytes of memory that each point takes during construction.
    pub const BYTES: usize =
        size_of::<Node>() + size_of::<u32>() + (size_of::<Lanes3>() + size_of::<Plane>()) / LANES;

    /// Builds a tree of finite points, fewer than 2³². Returns for each of its points the index
    /// among those given, too. The same points in the same order give the same tree, whatever the
    /// number of threads.
    pub fn new(points: impl Iterator<Item = DVec3>) -> (Self, Vec<u32>) {
        let node = |(point, index)| Node { point, index };
        let mut nodes: Vec<Node> = points.zip(0..).map(node).collect();
        let mut planes = vec![Plane::default(); nodes.len() / LANES];
        build(&mut nodes, &mut planes);
        let chunk = |nodes: &[Node]| {
            let point = |lane: usize| nodes.get(lane).map_or(DVec3::INFINITY, |node| node.point);
            Lanes3::from_fn(point)
        };
        let tree = Self {
            chunks: nodes.chunks(LANES).map(chunk).collect(),
            planes,
            length: nodes.len(),
        };
        (tree, nodes.iter().map(|node| node.index).collect())
    }

    /// Returns the number of points.
    pub fn len(&self) -> usize {
        self.length
    }

    /// Returns whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// Finds every point p that has ‖p − centre‖² ≤ `radius_squared`. Calls `visit`, in the tree's
    /// order, with the number of each chunk of [`LANES`] points that has some, and a bit for each.
    #[inline]
    pub fn within(&self, centre: DVec3, radius_squared: f64, mut visit: impl FnMut(usize, u32)) {
        self.walk(0..self.len(), centre, radius_squared, &mut visit);
    }

    /// Returns the approximate index, in the tree's order, of a point: near most of those that lie
    /// near it.
    pub fn approximate_index(&self, point: DVec3) -> usize {
        let mut range = 0..self.len();
        while range.len() > MAX_SAME_INDEX {
            let middle = range.start + middle(range.len());
            let Plane { at, axis } = self.planes[middle / LANES - 1];
            range = if point[usize::from(axis)] < at {
                range.start..middle
            } else {
                middle..range.end
            };
        }
        range.start
    }

    fn walk(
        &self,
        range: Range<usize>,
        centre: DVec3,
        radius_squared: f64,
        visit: &mut impl FnMut(usize, u32),
    ) {
        if range.len() <= MAX_LEAF_POINTS {
            return self.scan(range, centre, radius_squared, visit);
        }
        let middle = range.start + middle(range.len());
        let Plane { at, axis } = self.planes[middle / LANES - 1];
        let offset = centre[usize::from(axis)] - at;
        let is_near = offset * offset <= radius_squared;
        if offset < 0.0 || is_near {
            self.walk(range.start..middle, centre, radius_squared, visit);
        }
        if offset > 0.0 || is_near {
            self.walk(middle..range.end, centre, radius_squared, visit);
        }
    }

    /// Tests each point of a range.
    #[inline]
    fn scan(
        &self,
        range: Range<usize>,
        centre: DVec3,
        radius_squared: f64,
        visit: &mut impl FnMut(usize, u32),
    ) {
        let centre = Lanes3::splat_vector(centre);
        for chunk in range.start / LANES..range.end.div_ceil(LANES) {
            let distances_squared = (self.chunks[chunk] - centre).length_squared();
            let far = distances_squared.cmpgt(Lanes::splat(radius_squared));
            let near = (!far).bits();
            if near != 0 {
                visit(chunk, near);
            }
        }
    }
}

/// Returns the index at which a range is divided: a multiple of [`LANES`], so that all leaves begin
/// at one.
fn middle(length: usize) -> usize {
    (length / 2).next_multiple_of(LANES)
}

/// Divides the slice across its widest axis, and recursively both halves.
fn build(nodes: &mut [Node], planes: &mut [Plane]) {
    if nodes.len() <= MAX_LEAF_POINTS {
        return;
    }
    let (low, high) = nodes.iter().fold(
        (DVec3::INFINITY, DVec3::NEG_INFINITY),
        |(low, high), node| (low.min(node.point), high.max(node.point)),
    );
    let axis = (high - low).max_position();
    let middle = middle(nodes.len());
    let (_, first, _) =
        nodes.select_nth_unstable_by(middle, |a, b| a.point[axis].total_cmp(&b.point[axis]));
    let plane = Plane {
        at: first.point[axis],
        axis: axis as u8,
    };
    let (before, after) = nodes.split_at_mut(middle);
    // The last plane of the former is not used by the first half.
    let (planes_before, planes_after) = planes.split_at_mut(middle / LANES);
    planes_before[middle / LANES - 1] = plane;
    if before.len() >= MIN_PARALLEL_LENGTH {
        rayon::join(
            || build(before, planes_before),
            || build(after, planes_after),
        );
    } else {
        build(before, planes_before);
        build(after, planes_after);
    }
}
