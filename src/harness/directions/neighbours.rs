//! Nearest neighbours among directions, by a kd-tree (Bentley 1975).

use glam::DVec3;

/// Largest number of points of a leaf.
const LEAF: usize = 8;

/// A point, and its place in the list of the caller.
#[derive(Clone, Copy)]
struct Point {
    at: DVec3,
    index: usize,
}

/// Points in the order of a tree: the middle one of a range divides it across `axes` of the middle.
struct Tree {
    points: Vec<Point>,
    axes: Vec<usize>,
}

/// The nearest neighbour of a direction.
#[derive(Clone, Copy)]
pub(super) struct Neighbour {
    /// Its place in the list.
    pub index: usize,
    /// Squared distance of the two unit vectors.
    pub square: f64,
}

/// Returns for each direction the nearest other one on its side of the horizon z = 0; itself at the
/// distance 2 if there is none.
pub(super) fn nearest_neighbours(directions: &[DVec3]) -> Vec<Neighbour> {
    let alone = |index| Neighbour { index, square: 4.0 };
    let mut nearest: Vec<Neighbour> = (0..directions.len()).map(alone).collect();
    for upper in [true, false] {
        let points = directions
            .iter()
            .enumerate()
            .map(|(index, &at)| Point { at, index })
            .filter(|point| (point.at.z >= 0.0) == upper);
        let tree = Tree::new(points.collect());
        for &point in &tree.points {
            tree.search(0, tree.points.len(), point, &mut nearest[point.index]);
        }
    }
    nearest
}

impl Tree {
    fn new(mut points: Vec<Point>) -> Self {
        let mut axes = vec![0; points.len()];
        build(&mut points, &mut axes);
        Self { points, axes }
    }

    /// Replaces the neighbour by the nearest other point in a range, if that is nearer.
    fn search(&self, from: usize, to: usize, of: Point, nearest: &mut Neighbour) {
        let mut test = |other: &Point| {
            let square = other.at.distance_squared(of.at);
            if other.index != of.index && square < nearest.square {
                let index = other.index;
                *nearest = Neighbour { index, square };
            }
        };
        if to - from <= LEAF {
            self.points[from..to].iter().for_each(test);
            return;
        }
        let middle = from + (to - from) / 2;
        let divider = &self.points[middle];
        test(divider);
        let axis = self.axes[middle];
        let offset = of.at[axis] - divider.at[axis];
        let halves = [[from, middle], [middle + 1, to]];
        let near = usize::from(offset > 0.0);
        let [first, second] = [halves[near], halves[1 - near]];
        self.search(first[0], first[1], of, nearest);
        if offset * offset < nearest.square {
            self.search(second[0], second[1], of, nearest);
        }
    }
}

fn build(points: &mut [Point], axes: &mut [usize]) {
    if points.len() <= LEAF {
        return;
    }
    let places: Vec<DVec3> = points.iter().map(|point| point.at).collect();
    let [low, high] = extent(&places);
    let (axis, middle) = ((high - low).max_position(), points.len() / 2);
    points.select_nth_unstable_by(middle, |a, b| a.at[axis].total_cmp(&b.at[axis]));
    axes[middle] = axis;
    build(&mut points[..middle], &mut axes[..middle]);
    build(&mut points[middle + 1..], &mut axes[middle + 1..]);
}

/// Returns the corners of the box around points.
pub(super) fn extent(points: &[DVec3]) -> [DVec3; 2] {
    points.iter().fold(
        [DVec3::INFINITY, DVec3::NEG_INFINITY],
        |[low, high], &point| [low.min(point), high.max(point)],
    )
}
