//! Construction of the hierarchy: a binary tree by the surface-area heuristic over bins, whose
//! nodes are merged into wide ones so that the expected cost of a ray is least (Ylitie, Karras and
//! Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", HPG 2017,
//! section 3.1).

use std::array::from_fn;

use arrayvec::ArrayVec;
use glam::{DVec3, Vec3};

use super::{Bvh, Leaf, MAX_LEAF_PRIMITIVES, Node, Primitive, STACK_SIZE, WIDTH};

/// Depth of the binary tree that the traversal stack can take: each of its levels adds at most the
/// siblings of one wide node.
const MAX_DEPTH: u32 = ((STACK_SIZE - 1) / (WIDTH - 1)) as u32;
/// Number of bins per axis among which splits are looked for.
const BINS: usize = 16;
/// Number of primitives from which both halves of a split are built at the same time.
const PARALLEL_COUNT: usize = 4096;
/// Expected cost of testing a ray against a leaf, in units of that against the boxes of a node.
const LEAF_COST: f32 = 1.0;

/// Widening of boxes relative to the largest coordinate of all, 2⁻⁴⁸: rays along an axis drift
/// across it by much less (`crate::geometry::bvh::LEAST_DIRECTION`).
const BOX_MARGIN: f64 = 1.0 / 281_474_976_710_656.0;

/// An axis-aligned box, rounded outward to single precision.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    low: Vec3,
    high: Vec3,
}

/// A primitive of the list that the tree divides.
#[derive(Clone, Copy)]
struct Item {
    bounds: Bounds,
    /// Twice the centre of the bounds.
    centre: Vec3,
    id: u32,
}

/// A node of the binary tree. Its left child comes next in the list, its right child after all
/// nodes of the left one.
#[derive(Clone, Copy)]
struct BinaryNode {
    bounds: Bounds,
    /// Number of primitives below.
    count: u32,
    /// `costs[i]` is the least expected cost of the primitives below if they take up at most i + 1
    /// children of a wide node.
    costs: [f32; WIDTH - 1],
    /// How [`costs`](Self::costs) are reached: number of children that the left half gets, or 0 if
    /// one child fewer is as good. Of a single child, 0 is a leaf; else it becomes a wide node.
    left_children: [u8; WIDTH - 1],
}

/// Best split along an axis: items whose bin is below `bin` go to the left.
struct Split {
    cost: f32,
    axis: usize,
    bin: usize,
}

impl Bounds {
    const EMPTY: Self = Self {
        low: Vec3::INFINITY,
        high: Vec3::NEG_INFINITY,
    };

    /// Rounds the box from `low` to `high` outward.
    fn rounded(low: DVec3, high: DVec3) -> Self {
        Self {
            low: Vec3::from_array(low.to_array().map(rounded_down)),
            high: Vec3::from_array((-high).to_array().map(|x| -rounded_down(x))),
        }
    }

    fn union(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    fn half_area(&self) -> f32 {
        let d = (self.high - self.low).max(Vec3::ZERO);
        d.x * d.y + d.y * d.z + d.z * d.x
    }
}

impl Bvh {
    /// Builds the hierarchy.
    pub fn new(primitives: &[Primitive]) -> Self {
        Self::with_walls(primitives, |_| false)
    }

    /// Builds the hierarchy so that rays can [skip the walls](Part::WithoutWalls), the primitives
    /// whose indices `is_wall` accepts.
    pub(crate) fn with_walls(primitives: &[Primitive], is_wall: impl Fn(u32) -> bool) -> Self {
        let (mut walls, mut others): (Vec<Item>, Vec<Item>) = items(primitives)
            .into_iter()
            .partition(|item| is_wall(item.id));
        let mut bvh = Self {
            nodes: Vec::new(),
            leaves: Vec::new(),
            spheres: Vec::new(),
            without_walls: 0,
        };
        if walls.is_empty() {
            bvh.add_part(&mut others, primitives, 0);
            return bvh;
        }
        // The root has the walls below one child, and all others below another.
        bvh.nodes.push(Node::EMPTY);
        let mut root = Node::EMPTY;
        for items in [&mut walls, &mut others] {
            bvh.without_walls = bvh.nodes.len() as u32;
            match bvh.add_part(items, primitives, 1) {
                Some(bounds) => root.push(bounds, bvh.without_walls * 2),
                None => bvh.nodes.push(Node::EMPTY),
            }
        }
        bvh.nodes[0] = root;
        bvh
    }

    /// Adds a tree of these items at a depth, if there are any, and returns their bounds. Its root
    /// is the first of the nodes that it adds.
    fn add_part(
        &mut self,
        items: &mut [Item],
        primitives: &[Primitive],
        depth: u32,
    ) -> Option<Bounds> {
        if items.is_empty() {
            return None;
        }
        let mut binary = vec![BinaryNode::UNSET; 2 * items.len() - 1];
        build_binary(items, &mut binary, depth);
        let tree = Tree {
            nodes: &binary,
            items,
            primitives,
        };
        let root = Place { node: 0, item: 0 };
        if binary[0].left_children[0] == 0 {
            self.add_node(&tree, &[root]);
        } else {
            self.add_wide(&tree, root);
        }
        Some(binary[0].bounds)
    }

    /// Adds the wide node of a binary one and all below; returns its index.
    fn add_wide(&mut self, tree: &Tree, place: Place) -> u32 {
        let mut children = ArrayVec::new();
        let [left, right] = tree.halves(place);
        let of_left = usize::from(tree.node(place).left_children[0]);
        tree.list_children(left, of_left, &mut children);
        tree.list_children(right, WIDTH - of_left, &mut children);
        self.add_node(tree, &children)
    }

    fn add_node(&mut self, tree: &Tree, children: &[Place]) -> u32 {
        let index = self.nodes.len();
        let mut node = Node::EMPTY;
        self.nodes.push(node);
        for &child in children {
            let BinaryNode {
                bounds,
                left_children,
                ..
            } = *tree.node(child);
            let below = if left_children[0] == 0 {
                self.add_leaf(tree.items_of(child), tree.primitives) * 2 + 1
            } else {
                self.add_wide(tree, child) * 2
            };
            node.push(bounds, below);
        }
        self.nodes[index] = node;
        index as u32
    }

    fn add_leaf(&mut self, items: &[Item], primitives: &[Primitive]) -> u32 {
        let first = self.spheres.len();
        let mut triangles = ArrayVec::<([DVec3; 3], u32), MAX_LEAF_PRIMITIVES>::new();
        for &Item { id, .. } in items {
            match primitives[id as usize] {
                Primitive::Triangle(vertices) => triangles.push((vertices, id)),
                Primitive::Sphere(sphere) => self.spheres.push((id, sphere)),
            }
        }
        let none = ([DVec3::ZERO; 3], 0);
        let of = |place: usize| *triangles.get(place).or(triangles.first()).unwrap_or(&none);
        self.leaves.push(Leaf {
            vertices: from_fn(|vertex| from_fn(|axis| from_fn(|place| of(place).0[vertex][axis]))),
            triangles: from_fn(|place| of(place).1),
            triangle_count: triangles.len(),
            spheres: (first as u32, (self.spheres.len() - first) as u32),
        });
        self.leaves.len() as u32 - 1
    }
}

impl Node {
    const EMPTY: Self = Self {
        planes: [[[0.0; WIDTH]; 2]; 3],
        children: [0; WIDTH],
        child_count: 0,
    };

    /// Adds a child.
    fn push(&mut self, bounds: Bounds, child: u32) {
        let slot = self.child_count;
        for axis in 0..3 {
            self.planes[axis][0][slot] = bounds.low[axis];
            self.planes[axis][1][slot] = bounds.high[axis];
        }
        self.children[slot] = child;
        self.child_count += 1;
    }
}

/// Lists the primitives, each with its bounds.
fn items(primitives: &[Primitive]) -> Vec<Item> {
    let bounds = |primitive: &Primitive| match *primitive {
        Primitive::Triangle([a, b, c]) => [a.min(b).min(c), a.max(b).max(c)],
        Primitive::Sphere(sphere) => [sphere.centre - sphere.radius, sphere.centre + sphere.radius],
    };
    let largest = primitives.iter().fold(0.0, |largest: f64, primitive| {
        let [low, high] = bounds(primitive);
        largest.max(low.abs().max(high.abs()).max_element())
    });
    let drift = BOX_MARGIN * largest;
    primitives
        .iter()
        .zip(0..)
        .map(|(primitive, id)| {
            let [low, high] = bounds(primitive);
            let bounds = Bounds::rounded(low - drift, high + drift);
            Item {
                bounds,
                centre: bounds.low + bounds.high,
                id,
            }
        })
        .collect()
}

/// Place of a node in the binary tree, and that of its first primitive.
#[derive(Clone, Copy)]
struct Place {
    node: usize,
    item: usize,
}

/// The binary tree with the primitives in its order.
struct Tree<'a> {
    nodes: &'a [BinaryNode],
    items: &'a [Item],
    primitives: &'a [Primitive],
}

impl Tree<'_> {
    fn node(&self, place: Place) -> &BinaryNode {
        &self.nodes[place.node]
    }

    fn items_of(&self, place: Place) -> &[Item] {
        &self.items[place.item..][..self.node(place).count as usize]
    }

    fn halves(&self, place: Place) -> [Place; 2] {
        let left = Place {
            node: place.node + 1,
            item: place.item,
        };
        let count = self.node(left).count as usize;
        let right = Place {
            node: place.node + 2 * count,
            item: place.item + count,
        };
        [left, right]
    }

    /// Lists the nodes that become children of a wide node if this one may take up `count` of them.
    fn list_children(&self, place: Place, count: usize, children: &mut ArrayVec<Place, WIDTH>) {
        if count == 1 {
            children.push(place);
            return;
        }
        match usize::from(self.node(place).left_children[count - 1]) {
            0 => self.list_children(place, count - 1, children),
            of_left => {
                let [left, right] = self.halves(place);
                self.list_children(left, of_left, children);
                self.list_children(right, count - of_left, children);
            }
        }
    }
}

impl BinaryNode {
    const UNSET: Self = Self {
        bounds: Bounds::EMPTY,
        count: 0,
        costs: [0.0; WIDTH - 1],
        left_children: [0; WIDTH - 1],
    };

    /// A node of one primitive.
    fn single(bounds: Bounds) -> Self {
        Self {
            bounds,
            count: 1,
            costs: [bounds.half_area() * LEAF_COST; WIDTH - 1],
            left_children: [0; WIDTH - 1],
        }
    }

    /// The node above two others.
    fn above(left: &Self, right: &Self) -> Self {
        let bounds = left.bounds.union(right.bounds);
        let count = left.count + right.count;
        // The cost of both halves in `children` children together, and how many the left one gets.
        let divided = |children: usize| {
            (1..children)
                .map(|of_left| {
                    let of_right = children - of_left;
                    (left.costs[of_left - 1] + right.costs[of_right - 1], of_left)
                })
                .fold((f32::INFINITY, 1), |best, other| {
                    if other.0 < best.0 { other } else { best }
                })
        };
        let (below, of_left) = divided(WIDTH);
        let area = bounds.half_area();
        let (mut costs, mut left_children) = ([area + below; WIDTH - 1], [0; WIDTH - 1]);
        left_children[0] = of_left as u8;
        if count as usize <= MAX_LEAF_PRIMITIVES && area * LEAF_COST <= costs[0] {
            (costs[0], left_children[0]) = (area * LEAF_COST, 0);
        }
        for children in 2..WIDTH {
            costs[children - 1] = costs[children - 2];
            let (cost, of_left) = divided(children);
            if cost < costs[children - 1] {
                (costs[children - 1], left_children[children - 1]) = (cost, of_left as u8);
            }
        }
        Self {
            bounds,
            count,
            costs,
            left_children,
        }
    }
}

/// Builds the binary tree of all items at `depth` and brings them in its order. There are
/// 2n − 1 nodes for n items.
fn build_binary(items: &mut [Item], nodes: &mut [BinaryNode], depth: u32) {
    let [root, below @ ..] = nodes else {
        return;
    };
    if let [item] = items {
        *root = BinaryNode::single(item.bounds);
        return;
    }
    let (middle, is_large) = (divide(items, depth), items.len() >= PARALLEL_COUNT);
    let (left_items, right_items) = items.split_at_mut(middle);
    let (left, right) = below.split_at_mut(2 * middle - 1);
    if is_large {
        rayon::join(
            || build_binary(left_items, left, depth + 1),
            || build_binary(right_items, right, depth + 1),
        );
    } else {
        build_binary(left_items, left, depth + 1);
        build_binary(right_items, right, depth + 1);
    }
    *root = BinaryNode::above(&left[0], &right[0]);
}

/// Divides items in two by the surface-area heuristic; returns the number of those on the left.
/// Where nothing separates them, or the tree would grow too deep, each half gets as many.
fn divide(items: &mut [Item], depth: u32) -> usize {
    let centres = items.iter().fold(Bounds::EMPTY, |bounds, item| Bounds {
        low: bounds.low.min(item.centre),
        high: bounds.high.max(item.centre),
    });
    let levels = items.len().next_power_of_two().ilog2();
    // Most leaves hold as many as this, in whatever order.
    let is_leaf = items.len() <= MAX_LEAF_PRIMITIVES;
    let split = (!is_leaf && depth + levels < MAX_DEPTH)
        .then(|| best_split(items, &centres))
        .flatten();
    let Some(Split { axis, bin, .. }) = split else {
        let middle = items.len() / 2;
        let axis = (centres.high - centres.low).max_position();
        items.select_nth_unstable_by(middle, |a, b| {
            a.centre[axis]
                .total_cmp(&b.centre[axis])
                .then(a.id.cmp(&b.id))
        });
        return middle;
    };
    let mut middle = 0;
    for place in 0..items.len() {
        if bin_of(&items[place], &centres, axis) < bin {
            items.swap(place, middle);
            middle += 1;
        }
    }
    middle
}

/// Returns the bin in which an item's centre lies along an axis.
fn bin_of(item: &Item, centres: &Bounds, axis: usize) -> usize {
    let [low, high] = [centres.low[axis], centres.high[axis]];
    // Not a number for centres at infinity, which go to the first bin.
    (((item.centre[axis] - low) / (high - low) * BINS as f32) as usize).min(BINS - 1)
}

/// Returns the cheapest split between bins; `None` if all centres lie in one bin of each axis.
fn best_split(items: &[Item], centres: &Bounds) -> Option<Split> {
    let mut bins = [[(Bounds::EMPTY, 0u32); BINS]; 3];
    for item in items {
        for (axis, bins) in bins.iter_mut().enumerate() {
            let (bounds, count) = &mut bins[bin_of(item, centres, axis)];
            *bounds = bounds.union(item.bounds);
            *count += 1;
        }
    }
    let mut best: Option<Split> = None;
    for (axis, bins) in bins.iter().enumerate() {
        let mut right = [(0.0, 0); BINS];
        let (mut bounds, mut count) = (Bounds::EMPTY, 0);
        for bin in (1..BINS).rev() {
            bounds = bounds.union(bins[bin].0);
            count += bins[bin].1;
            right[bin] = (bounds.half_area(), count);
        }
        (bounds, count) = (Bounds::EMPTY, 0);
        for bin in 1..BINS {
            bounds = bounds.union(bins[bin - 1].0);
            count += bins[bin - 1].1;
            let (area, right_count) = right[bin];
            if count == 0 || right_count == 0 {
                continue;
            }
            let cost = bounds.half_area() * count as f32 + area * right_count as f32;
            if best.as_ref().is_none_or(|best| cost < best.cost) {
                best = Some(Split { cost, axis, bin });
            }
        }
    }
    best
}

/// Returns the largest single-precision number that is not above x.
pub(super) fn rounded_down(x: f64) -> f32 {
    let rounded = x as f32;
    if f64::from(rounded) > x {
        rounded.next_down()
    } else {
        rounded
    }
}
