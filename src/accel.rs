//! A bounding volume hierarchy with four children per node, and its brute-force twin.
//!
//! Why our own: the crates at hand answer hits in single precision, which a furnace of ten thousand
//! bounces and a watertight room cannot use. Boxes here are single precision too, but only as a filter:
//! they are rounded outward and tested with a margin that covers the rounding of the ray, so no
//! primitive that the double-precision test would hit is ever skipped.

mod packet;

use glam::{DVec3, Vec4};

use crate::real::Real;
use crate::shape::{Ray, Sphere};
use crate::watertight::{Shear, TriangleHit, Turn, Vertices};
pub(crate) use packet::Nearest;
pub use packet::{PacketHit, PacketStack};

/// What rays can hit.
#[derive(Clone, Copy, Debug)]
pub enum Primitive {
    /// A triangle by its vertices.
    Triangle(Vertices),
    /// A sphere or zone of it.
    Sphere(Sphere),
}

/// The nearest hit on a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrimitiveHit {
    /// Which primitive, by its place in the list that the hierarchy was built from.
    pub primitive: u32,
    /// t of (1).
    pub t: f64,
    /// Barycentric weights of a triangle's vertices; zero for spheres.
    pub weights: [f64; 3],
}

impl PrimitiveHit {
    /// This hit or a nearer one on another primitive. Of two at the same distance it is the one that comes first
    /// in the list, in whatever order they are tested.
    #[inline]
    fn or(self, primitive: u32, hit: TriangleHit) -> Self {
        if hit.t < self.t || hit.t == self.t && primitive < self.primitive {
            Self { primitive, t: hit.t, weights: hit.weights }
        } else {
            self
        }
    }
}

impl Primitive {
    /// A triangle.
    pub fn triangle(vertices: [DVec3; 3]) -> Self {
        Self::Triangle(vertices.map(|v| [v.x, v.y, v.z, 0.0]))
    }

    /// Where a ray, also as prepared for triangles, meets it; at infinity if nowhere.
    #[inline]
    fn hit<V: Turn>(&self, ray: &Ray<V>, shear: &Shear<V>) -> TriangleHit<V::Real> {
        match self {
            Self::Triangle(vertices) => {
                let [a, b, c] = vertices.map(|vertex| shear.project(&vertex.map(V::Real::splat)));
                shear.hit([&a, &b, &c])
            }
            Self::Sphere(sphere) => TriangleHit { t: sphere.distance(ray), weights: [V::Real::splat(0.0); 3] },
        }
    }

    fn bounds(&self) -> Bounds {
        match self {
            Self::Triangle(vertices) => vertices.iter().fold(Bounds::EMPTY, |bounds, v| {
                let v = DVec3::new(v[0], v[1], v[2]);
                bounds.union(Bounds { low: v, high: v })
            }),
            Self::Sphere(sphere) => {
                let r = DVec3::splat(sphere.radius);
                Bounds { low: sphere.centre - r, high: sphere.centre + r }
            }
        }
    }
}

#[derive(Clone, Copy, Debug)]
struct Bounds {
    low: DVec3,
    high: DVec3,
}

impl Bounds {
    const EMPTY: Self = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };

    fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    fn half_area(&self) -> f64 {
        let d = (self.high - self.low).max(DVec3::ZERO);
        d.x * d.y + d.y * d.z + d.z * d.x
    }
}

/// Up to four children. A child is `first << COUNT_BITS | count`: primitives if count > 0, else a node.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// `planes[axis][0]` are the children's lower bounds, `planes[axis][1]` the upper ones.
    planes: [[Vec4; 2]; 3],
    children: [u32; 4],
}

const COUNT_BITS: u32 = 3;
const COUNT_MASK: u32 = (1 << COUNT_BITS) - 1;
/// Most primitives in a leaf.
const LEAF: usize = 2;
/// Below this depth nodes split at the median, so that depth stays within the stack: a median level
/// divides by four, hence 4^15 primitives fit.
const SORTED_DEPTH: u32 = 6;
/// Three siblings wait per level, so this suffices for 21 levels.
const STACK: usize = 64;
/// A tree of up to [`SHALLOW`] levels needs this much only; clearing the larger stack would cost a small
/// scene some 4 % of its time.
const SMALL_STACK: usize = 3 * SHALLOW as usize + 1;
const SHALLOW: u32 = 7;
/// Rounding of the ray's origin to single precision, relative to its largest coordinate, with a margin
/// of two.
const ORIGIN_MARGIN: f32 = 1.0 / 8_388_608.0;
/// Rounding of the slab arithmetic, relative: a bound on 2γ₃ of Ize, JCGT 2(2), 2013.
const SLAB_MARGIN: f32 = 1.0 + 8.0 * f32::EPSILON;

/// The hierarchy over a list of primitives.
#[derive(Debug)]
pub struct Bvh {
    nodes: Vec<Node>,
    /// In the order of the leaves.
    primitives: Vec<Primitive>,
    /// For each of them, its place in the original list.
    ids: Vec<u32>,
    levels: u32,
}

impl Bvh {
    /// Builds the hierarchy with the surface-area heuristic over full sorted sweeps.
    pub fn new(primitives: &[Primitive]) -> Self {
        Self::of(primitives, |_| true)
    }

    /// The same over those for which `takes` holds; all keep their places in the list.
    pub(crate) fn of(primitives: &[Primitive], takes: impl Fn(u32) -> bool) -> Self {
        let all = primitives.iter().zip(0..).filter(|&(_, id)| takes(id));
        let mut items: Vec<(Bounds, u32)> = all.map(|(primitive, id)| (primitive.bounds(), id)).collect();
        let mut bvh = Self {
            nodes: Vec::new(),
            primitives: Vec::with_capacity(items.len()),
            ids: Vec::with_capacity(items.len()),
            levels: 0,
        };
        if !items.is_empty() {
            bvh.build_node(&mut items, primitives, 0);
        }
        bvh
    }

    fn build_node(&mut self, items: &mut [(Bounds, u32)], primitives: &[Primitive], depth: u32) -> u32 {
        self.levels = self.levels.max(depth + 1);
        let index = self.nodes.len();
        self.nodes.push(Node { planes: [[Vec4::INFINITY, Vec4::NEG_INFINITY]; 3], children: [0; 4] });
        for (slot, part) in split_in_four(items, depth).into_iter().enumerate() {
            let bounds = part.iter().fold(Bounds::EMPTY, |b, item| b.union(item.0));
            for axis in 0..3 {
                self.nodes[index].planes[axis][0][slot] = rounded_down(bounds.low[axis]);
                self.nodes[index].planes[axis][1][slot] = -rounded_down(-bounds.high[axis]);
            }
            self.nodes[index].children[slot] = if part.len() <= LEAF {
                let first = self.primitives.len();
                for &(_, id) in part.iter() {
                    self.primitives.push(primitives[id as usize]);
                    self.ids.push(id);
                }
                ((first as u32) << COUNT_BITS) | part.len() as u32
            } else {
                self.build_node(part, primitives, depth + 1) << COUNT_BITS
            };
        }
        index as u32
    }

    /// The nearest hit with 0 < t < `t_max`.
    #[inline]
    pub fn closest(&self, ray: &Ray, t_max: f64) -> Option<PrimitiveHit> {
        let shear = Shear::new(ray);
        let mut nearest = PrimitiveHit { primitive: 0, t: t_max, weights: [0.0; 3] };
        self.traverse(ray, t_max, |first, count| {
            for i in first..first + count {
                nearest = nearest.or(self.ids[i], self.primitives[i].hit(ray, &shear));
            }
            Some(nearest.t)
        });
        (nearest.t < t_max).then_some(nearest)
    }

    /// Whether any primitive for which `blocks` holds is hit with 0 < t < `t_max`.
    #[inline]
    pub fn occluded(&self, ray: &Ray, t_max: f64, blocks: impl Fn(u32) -> bool) -> bool {
        let shear = Shear::new(ray);
        let mut occluded = false;
        self.traverse(ray, t_max, |first, count| {
            occluded =
                (first..first + count).any(|i| self.primitives[i].hit(ray, &shear).t < t_max && blocks(self.ids[i]));
            (!occluded).then_some(t_max)
        });
        occluded
    }

    /// [`closest`](Self::closest) by testing every primitive.
    pub fn closest_brute_force(&self, ray: &Ray, t_max: f64) -> Option<PrimitiveHit> {
        let shear = Shear::new(ray);
        let nearest = PrimitiveHit { primitive: 0, t: t_max, weights: [0.0; 3] };
        let primitives = self.primitives.iter().zip(&self.ids);
        let nearest = primitives.fold(nearest, |nearest, (primitive, &id)| nearest.or(id, primitive.hit(ray, &shear)));
        (nearest.t < t_max).then_some(nearest)
    }

    /// Calls `leaf(first, count)` for the leaves that the ray may meet, near ones first. It returns the
    /// distance beyond which nothing matters any more, or `None` to stop.
    #[inline]
    fn traverse(&self, ray: &Ray, t_max: f64, leaf: impl FnMut(usize, usize) -> Option<f64>) {
        match self.levels {
            0 => {}
            1..=SHALLOW => self.traverse_with::<SMALL_STACK>(ray, t_max, leaf),
            _ => self.traverse_with::<STACK>(ray, t_max, leaf),
        }
    }

    #[inline]
    fn traverse_with<const N: usize>(&self, ray: &Ray, t_max: f64, mut leaf: impl FnMut(usize, usize) -> Option<f64>) {
        let slabs = Slabs::new(ray);
        let mut limit = rounded_up(t_max as f32);
        let mut stack = [(0f32, 0u32); N];
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let (near, child) = stack[waiting];
            if near > limit {
                continue;
            }
            let first = (child >> COUNT_BITS) as usize;
            let count = (child & COUNT_MASK) as usize;
            if count > 0 {
                match leaf(first, count) {
                    Some(t_max) => limit = rounded_up(t_max as f32),
                    None => return,
                }
                continue;
            }
            let node = &self.nodes[first];
            let (near, mut mask) = slabs.intersect(node, limit);
            let bottom = waiting;
            while mask != 0 {
                let slot = mask.trailing_zeros() as usize;
                mask &= mask - 1;
                let entry = (near[slot], node.children[slot]);
                let mut place = waiting;
                while place > bottom && stack[place - 1].0 < entry.0 {
                    stack[place] = stack[place - 1];
                    place -= 1;
                }
                stack[place] = entry;
                waiting += 1;
            }
        }
    }
}

/// A ray as the box test sees it. Near planes are tested from an origin moved towards them and far
/// planes from one moved away, by a bound on the origin's rounding.
struct Slabs {
    near_origin: [f32; 3],
    far_origin: [f32; 3],
    inverse: [f32; 3],
    near_side: [usize; 3],
}

impl Slabs {
    #[inline]
    fn new(ray: &Ray) -> Self {
        let origin = ray.origin.as_vec3();
        let margin = origin.abs().max_element() * ORIGIN_MARGIN + f32::MIN_POSITIVE;
        // A component of 0 would give 0 · ∞; a tiny one gives a slab that is all or nothing. Segments may be tiny as a whole.
        let direction = ray.direction.as_vec3();
        let tiny = (direction.abs().max_element() * 1e-18).max(f32::MIN_POSITIVE);
        let direction = direction.to_array().map(|d| if d.abs() < tiny { tiny.copysign(d) } else { d });
        let forward = direction.map(|d| d > 0.0);
        let shifted = |axis: usize, towards: bool| origin[axis] + if towards { margin } else { -margin };
        Self {
            near_origin: [0, 1, 2].map(|axis| shifted(axis, forward[axis])),
            far_origin: [0, 1, 2].map(|axis| shifted(axis, !forward[axis])),
            inverse: direction.map(|d| 1.0 / d),
            near_side: forward.map(|f| usize::from(!f)),
        }
    }

    /// Entry distances of the four boxes, and a bit for each box that the ray meets before `limit`.
    #[inline]
    fn intersect(&self, node: &Node, limit: f32) -> ([f32; 4], u32) {
        let mut near = Vec4::ZERO;
        let mut far = Vec4::splat(limit);
        for axis in 0..3 {
            let side = self.near_side[axis] & 1;
            let planes = &node.planes[axis];
            let inverse = Vec4::splat(self.inverse[axis]);
            near = near.max((planes[side] - Vec4::splat(self.near_origin[axis])) * inverse);
            far = far.min((planes[side ^ 1] - Vec4::splat(self.far_origin[axis])) * inverse);
        }
        let hits = near.cmple(far * SLAB_MARGIN);
        (near.to_array(), hits.bitmask())
    }
}

/// The largest single-precision number that is not above x.
fn rounded_down(x: f64) -> f32 {
    let rounded = x as f32;
    if f64::from(rounded) > x { rounded.next_down() } else { rounded }
}

/// A number above the distance that was rounded to x, with the slabs' relative margin.
#[inline]
fn rounded_up(x: f32) -> f32 {
    x * SLAB_MARGIN
}

/// Divides items among at most four parts, each time the part with the largest area that is too large
/// for a leaf.
fn split_in_four(items: &mut [(Bounds, u32)], depth: u32) -> Vec<&mut [(Bounds, u32)]> {
    let cost = |part: &[(Bounds, u32)]| {
        let bounds = part.iter().fold(Bounds::EMPTY, |b, item| b.union(item.0));
        if part.len() > LEAF { bounds.half_area().max(f64::MIN_POSITIVE) } else { -1.0 }
    };
    let mut parts = vec![items];
    while parts.len() < 4 {
        let widest = if depth < SORTED_DEPTH {
            (0..parts.len()).max_by(|&a, &b| cost(parts[a]).total_cmp(&cost(parts[b])))
        } else {
            (0..parts.len()).max_by_key(|&i| parts[i].len())
        };
        let Some(widest) = widest.filter(|&i| parts[i].len() > LEAF) else {
            break;
        };
        let part = parts.swap_remove(widest);
        let middle = if depth < SORTED_DEPTH { sort_at_best_split(part) } else { sort_at_median(part) };
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

/// Sorts along the axis of the cheapest split by the surface-area heuristic; returns its place.
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
            let cost = bounds.half_area() * split as f64 + right_areas[split] * (items.len() - split) as f64;
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
        bounds.union(Bounds { low: centre, high: centre })
    });
    sort_along(items, (centres.high - centres.low).max_position());
    items.len() / 2
}
