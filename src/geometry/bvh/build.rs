//! Construction of the hierarchy by the surface-area heuristic.

use std::array::from_fn;

use glam::DVec3;

use super::{Bvh, Leaf, MAX_LEAF_PRIMITIVES, Node, Primitive, WIDTH};

/// Depth below which nodes split at the median, so that depth stays within the stack: a median
/// level divides by eight, and eleven of them separate more primitives than 32-bit indices can
/// number.
const SAH_DEPTH: u32 = 6;

/// Widening of boxes relative to the largest coordinate of all, 2⁻⁴⁸: rays along an axis drift
/// across it by much less (`crate::geometry::bvh::LEAST_DIRECTION`).
const BOX_MARGIN: f64 = 1.0 / 281_474_976_710_656.0;

#[derive(Clone, Copy, Debug)]
struct Bounds {
    low: DVec3,
    high: DVec3,
}

impl Bounds {
    const EMPTY: Self = Self {
        low: DVec3::INFINITY,
        high: DVec3::NEG_INFINITY,
    };

    fn of(primitive: &Primitive) -> Self {
        match primitive {
            Primitive::Triangle(vertices) => vertices.iter().fold(Self::EMPTY, |bounds, &v| {
                bounds.union(Self { low: v, high: v })
            }),
            Primitive::Sphere(sphere) => {
                let r = DVec3::splat(sphere.radius);
                Self {
                    low: sphere.centre - r,
                    high: sphere.centre + r,
                }
            }
        }
    }

    fn union(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    fn widened(self, by: f64) -> Self {
        Self {
            low: self.low - by,
            high: self.high + by,
        }
    }

    fn half_area(&self) -> f64 {
        let d = (self.high - self.low).max(DVec3::ZERO);
        d.x * d.y + d.y * d.z + d.z * d.x
    }
}

impl Bvh {
    /// Builds the hierarchy with the surface-area heuristic over full sorted sweeps.
    pub fn new(primitives: &[Primitive]) -> Self {
        Self::over_subset(primitives, |_| true)
    }

    /// Builds the hierarchy over the primitives for which `takes` holds; all keep their indices in
    /// the list.
    pub(crate) fn over_subset(primitives: &[Primitive], takes: impl Fn(u32) -> bool) -> Self {
        let all = primitives.iter().zip(0..).filter(|&(_, id)| takes(id));
        let mut items: Vec<(Bounds, u32)> = all
            .map(|(primitive, id)| (Bounds::of(primitive), id))
            .collect();
        let bounds = items
            .iter()
            .fold(Bounds::EMPTY, |bounds, item| bounds.union(item.0));
        let drift = BOX_MARGIN * bounds.low.abs().max(bounds.high.abs()).max_element();
        items
            .iter_mut()
            .for_each(|(bounds, _)| *bounds = bounds.widened(drift));
        let mut bvh = Self {
            nodes: Vec::new(),
            leaves: Vec::new(),
            spheres: Vec::new(),
        };
        if !items.is_empty() {
            bvh.build_node(&mut items, primitives, 0);
        }
        bvh
    }

    fn build_node(
        &mut self,
        items: &mut [(Bounds, u32)],
        primitives: &[Primitive],
        depth: u32,
    ) -> u32 {
        let index = self.nodes.len();
        let mut node = Node {
            planes: [[[0.0; WIDTH]; 2]; 3],
            children: [0; WIDTH],
            child_count: 0,
        };
        self.nodes.push(node);
        for (slot, part) in split(items, depth).into_iter().enumerate() {
            let bounds = part.iter().fold(Bounds::EMPTY, |b, item| b.union(item.0));
            for axis in 0..3 {
                node.planes[axis][0][slot] = rounded_down(bounds.low[axis]);
                node.planes[axis][1][slot] = -rounded_down(-bounds.high[axis]);
            }
            node.child_count += 1;
            node.children[slot] = if part.len() <= MAX_LEAF_PRIMITIVES {
                self.add_leaf(part, primitives) * 2 + 1
            } else {
                self.build_node(part, primitives, depth + 1) * 2
            };
        }
        self.nodes[index] = node;
        index as u32
    }

    fn add_leaf(&mut self, part: &[(Bounds, u32)], primitives: &[Primitive]) -> u32 {
        let first = self.spheres.len();
        let mut triangles: Vec<([DVec3; 3], u32)> = Vec::new();
        for &(_, id) in part {
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

/// Returns the largest single-precision number that is not above x.
pub(super) fn rounded_down(x: f64) -> f32 {
    let rounded = x as f32;
    if f64::from(rounded) > x {
        rounded.next_down()
    } else {
        rounded
    }
}

/// Divides items into at most [`WIDTH`] parts, each time splitting the part with the largest area
/// that is too large for a leaf.
fn split(items: &mut [(Bounds, u32)], depth: u32) -> Vec<&mut [(Bounds, u32)]> {
    let area = |part: &[(Bounds, u32)]| {
        let bounds = part.iter().fold(Bounds::EMPTY, |b, item| b.union(item.0));
        if part.len() > MAX_LEAF_PRIMITIVES {
            bounds.half_area().max(f64::MIN_POSITIVE)
        } else {
            -1.0
        }
    };
    let mut parts = vec![items];
    while parts.len() < WIDTH {
        let widest = if depth < SAH_DEPTH {
            (0..parts.len()).max_by(|&a, &b| area(parts[a]).total_cmp(&area(parts[b])))
        } else {
            (0..parts.len()).max_by_key(|&i| parts[i].len())
        };
        let Some(widest) = widest.filter(|&i| parts[i].len() > MAX_LEAF_PRIMITIVES) else {
            break;
        };
        let part = parts.swap_remove(widest);
        let middle = if depth < SAH_DEPTH {
            sort_at_best_split(part)
        } else {
            sort_at_median(part)
        };
        let (left, right) = part.split_at_mut(middle);
        parts.push(left);
        parts.push(right);
    }
    parts
}

fn sort_along(items: &mut [(Bounds, u32)], axis: usize) {
    let centre = |item: &(Bounds, u32)| item.0.low[axis] + item.0.high[axis];
    items.sort_unstable_by(|a, b| centre(a).total_cmp(&centre(b)).then(a.1.cmp(&b.1)));
}

/// Sorts along the axis of the cheapest split by the surface-area heuristic; returns the position
/// of the split.
fn sort_at_best_split(items: &mut [(Bounds, u32)]) -> usize {
    let mut best = (f64::INFINITY, 0, items.len() / 2);
    let mut right_areas = vec![0.0; items.len()];
    for axis in 0..3 {
        sort_along(items, axis);
        let mut bounds = Bounds::EMPTY;
        for (i, item) in items.iter().enumerate().rev() {
            bounds = bounds.union(item.0);
            right_areas[i] = bounds.half_area();
        }
        bounds = Bounds::EMPTY;
        for split in 1..items.len() {
            bounds = bounds.union(items[split - 1].0);
            let cost = bounds.half_area() * split as f64
                + right_areas[split] * (items.len() - split) as f64;
            if cost < best.0 {
                best = (cost, axis, split);
            }
        }
    }
    sort_along(items, best.1);
    best.2
}

/// Sorts along the longest axis of the centres; returns the middle.
fn sort_at_median(items: &mut [(Bounds, u32)]) -> usize {
    let centres = items.iter().fold(Bounds::EMPTY, |bounds, item| {
        let centre = 0.5 * (item.0.low + item.0.high);
        bounds.union(Bounds {
            low: centre,
            high: centre,
        })
    });
    sort_along(items, (centres.high - centres.low).max_position());
    items.len() / 2
}
