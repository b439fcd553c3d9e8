//! A kd-tree (Bentley 1975) of points with values: all that lie within a radius, always in the same order.

use glam::DVec3;

/// Points with values, as a balanced tree without pointers: the middle of a slice is its root, the halves
/// before and after it are the branches.
#[derive(Clone, Debug, Default)]
pub struct KdTree<T> {
    nodes: Vec<Node<T>>,
}

#[derive(Clone, Copy, Debug)]
struct Node<T> {
    point: DVec3,
    /// The coordinate (0 to 2) that divides the branches.
    axis: usize,
    value: T,
}

/// Slices at least this long are arranged by two threads.
const PARALLEL: usize = 4096;

impl<T: Send> KdTree<T> {
    /// A tree of finite points. The same points in the same order give the same tree, whatever the threads.
    pub fn new(points: impl IntoIterator<Item = (DVec3, T)>) -> Self {
        let node = |(point, value)| Node { point, axis: 0, value };
        let mut nodes: Vec<Node<T>> = points.into_iter().map(node).collect();
        arrange(&mut nodes);
        Self { nodes }
    }
}

impl<T> KdTree<T> {
    /// Bytes of memory that each point takes.
    pub const BYTES: usize = size_of::<Node<T>>();

    /// How many points there are.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The values, in the tree's order.
    pub fn values(&self) -> impl Iterator<Item = &T> {
        self.nodes.iter().map(|node| &node.value)
    }

    /// Visits every value whose point p has ‖p − centre‖² ≤ `radius_squared`, in the tree's order.
    #[inline]
    pub fn within(&self, centre: DVec3, radius_squared: f64, mut visit: impl FnMut(&T)) {
        walk(&self.nodes, centre, radius_squared, &mut visit);
    }
}

/// Puts the median along the widest axis into the middle of the slice, and so on in both halves.
fn arrange<T: Send>(nodes: &mut [Node<T>]) {
    if nodes.len() < 2 {
        return;
    }
    let (low, high) = nodes
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), node| (low.min(node.point), high.max(node.point)));
    let axis = (high - low).max_position();
    let middle = nodes.len() / 2;
    let (before, root, after) = nodes.select_nth_unstable_by(middle, |a, b| a.point[axis].total_cmp(&b.point[axis]));
    root.axis = axis;
    if before.len() >= PARALLEL {
        rayon::join(|| arrange(before), || arrange(after));
    } else {
        arrange(before);
        arrange(after);
    }
}

fn walk<T>(nodes: &[Node<T>], centre: DVec3, radius_squared: f64, visit: &mut impl FnMut(&T)) {
    let middle = nodes.len() / 2;
    let Some(root) = nodes.get(middle) else {
        return;
    };
    let offset = centre[root.axis] - root.point[root.axis];
    let near_plane = offset * offset <= radius_squared;
    if offset <= 0.0 || near_plane {
        walk(&nodes[..middle], centre, radius_squared, visit);
    }
    if root.point.distance_squared(centre) <= radius_squared {
        visit(&root.value);
    }
    if offset >= 0.0 || near_plane {
        walk(&nodes[middle + 1..], centre, radius_squared, visit);
    }
}
