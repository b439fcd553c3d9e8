//! A kd-tree (Bentley 1975) of points with values: all that lie within a radius, always in the same order.

use std::ops::Range;

use glam::DVec3;

use crate::real::{LANES, Lanes, Lanes3, Real as _, Vector as _, WideMask as _};

/// Points with values, as a balanced tree without pointers: the middle of a range is its root, the halves
/// before and after it are the branches. A short range is a leaf.
#[derive(Clone, Debug, Default)]
pub struct KdTree<T> {
    /// The coordinates of all points, one axis after the other; each list ends with numbers that are no point's.
    points: [Vec<f64>; 3],
    /// The coordinate (0 to 2) that divides the branches of a root.
    axes: Vec<u8>,
    values: Vec<T>,
}

/// A point on its way to its place, instead of its value.
struct Node {
    point: DVec3,
    /// Which of the points it is.
    index: u32,
    axis: u8,
}

/// Slices at least this long are arranged by two threads.
const PARALLEL: usize = 4096;
/// The most points of a leaf, all of which are looked at.
const LEAF: usize = 16;
/// The most points that have one and the same [`KdTree::place`].
const NEIGHBOURS: usize = 512;

impl<T: Copy> KdTree<T> {
    /// A tree of finite points, fewer than 2³². The same points in the same order give the same tree, whatever the
    /// threads.
    pub fn new(points: &[(DVec3, T)]) -> Self {
        let node = |(&(point, _), index)| Node { point, index, axis: 0 };
        let mut nodes: Vec<Node> = points.iter().zip(0..).map(node).collect();
        arrange(&mut nodes);
        let end = [f64::NAN; LANES];
        let coordinates = |axis: usize| nodes.iter().map(|node| node.point[axis]).chain(end).collect();
        Self {
            points: [coordinates(0), coordinates(1), coordinates(2)],
            axes: nodes.iter().map(|node| node.axis).collect(),
            values: nodes.iter().map(|node| points[node.index as usize].1).collect(),
        }
    }
}

impl<T> KdTree<T> {
    /// Bytes of memory that each point takes while the tree is made.
    pub const BYTES: usize = size_of::<Node>() + 3 * size_of::<f64>() + 1 + size_of::<T>();

    /// How many points there are.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The values, in the tree's order.
    pub fn values(&self) -> impl Iterator<Item = &T> {
        self.values.iter()
    }

    /// Visits every value whose point p has ‖p − centre‖² ≤ `radius_squared`, in the tree's order.
    #[inline]
    pub fn within(&self, centre: DVec3, radius_squared: f64, mut visit: impl FnMut(&T)) {
        self.walk(0..self.len(), centre, radius_squared, &mut visit);
    }

    /// About where in the tree's order a point would be: near most of those that lie near it.
    pub fn place(&self, point: DVec3) -> usize {
        let mut range = 0..self.len();
        while range.len() > NEIGHBOURS {
            let middle = range.start + range.len() / 2;
            let axis = usize::from(self.axes[middle]);
            range = if point[axis] < self.points[axis][middle] { range.start..middle } else { middle + 1..range.end };
        }
        range.start
    }

    fn walk(&self, range: Range<usize>, centre: DVec3, radius_squared: f64, visit: &mut impl FnMut(&T)) {
        if range.len() <= LEAF {
            return self.scan(range, centre, radius_squared, visit);
        }
        let middle = range.start + range.len() / 2;
        let axis = usize::from(self.axes[middle]);
        let offset = centre[axis] - self.points[axis][middle];
        let near_plane = offset * offset <= radius_squared;
        if offset < 0.0 || near_plane {
            self.walk(range.start..middle, centre, radius_squared, visit);
        }
        if near_plane {
            self.scan(middle..middle + 1, centre, radius_squared, visit);
        }
        if offset > 0.0 || near_plane {
            self.walk(middle + 1..range.end, centre, radius_squared, visit);
        }
    }

    /// Looks at each point of a range.
    #[inline]
    fn scan(&self, range: Range<usize>, centre: DVec3, radius_squared: f64, visit: &mut impl FnMut(&T)) {
        for first in range.clone().step_by(LANES) {
            let points = Lanes3::of([0, 1, 2].map(|axis| {
                let coordinates = self.points[axis][first..].first_chunk::<LANES>();
                Lanes::new(*coordinates.expect("numbers follow the last point"))
            }));
            let distances_squared = (points - Lanes3::splat_vector(centre)).length_squared();
            let far = distances_squared.above(Lanes::splat(radius_squared)).bits();
            for (i, value) in self.values[first..range.end.min(first + LANES)].iter().enumerate() {
                if far >> i & 1 == 0 {
                    visit(value);
                }
            }
        }
    }
}

/// Puts the median along the widest axis into the middle of the slice, and so on in both halves.
fn arrange(nodes: &mut [Node]) {
    if nodes.len() <= LEAF {
        return;
    }
    let (low, high) = nodes
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), node| (low.min(node.point), high.max(node.point)));
    let axis = (high - low).max_position();
    let middle = nodes.len() / 2;
    let (before, root, after) = nodes.select_nth_unstable_by(middle, |a, b| a.point[axis].total_cmp(&b.point[axis]));
    root.axis = axis as u8;
    if before.len() >= PARALLEL {
        rayon::join(|| arrange(before), || arrange(after));
    } else {
        arrange(before);
        arrange(after);
    }
}
