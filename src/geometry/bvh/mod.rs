//! A bounding volume hierarchy with eight children per node. A ray is tested against the boxes of
//! all children at once, and against all triangles of a leaf.
//!
//! Existing crates return hits in single precision, which a furnace of ten thousand bounces and a
//! watertight room cannot use. Boxes here are single precision too, but only as a filter: they are
//! rounded outward and tested with a margin that covers the rounding of the ray, so no primitive
//! that the double-precision test would hit is ever skipped.

mod build;
mod packet;

use arrayvec::ArrayVec;
use glam::DVec3;

use super::shape::{Ray, Sphere};
use super::watertight::{Shear, TriangleHit};
use crate::math::real::{Mask, Real, Vector};
use crate::math::simd::{EightSingles, FOUR, LANES, Scalar, Wide};
pub(crate) use packet::Nearest;
pub use packet::{PacketHit, PacketStack};

/// A primitive that rays can hit.
#[derive(Clone, Copy, Debug)]
pub enum Primitive {
    /// A triangle by its vertices.
    Triangle([DVec3; 3]),
    /// A sphere or zone of it.
    Sphere(Sphere),
}

/// Nearest hit on a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrimitiveHit {
    /// Index of the primitive in the list that the hierarchy was built from.
    pub primitive: u32,
    /// t of (1).
    pub t: f64,
    /// Barycentric weights of a triangle's vertices; zero for spheres.
    pub weights: [f64; 3],
}

impl PrimitiveHit {
    /// Returns this hit or a nearer one in a lane, on another primitive. Of two at the same distance
    /// the one that comes first in the list wins, in whatever order they are tested.
    #[inline]
    fn nearer<R: Real>(self, primitive: u32, hits: &TriangleHit<R>, lane: usize) -> Self {
        let t = hits.t.lane(lane);
        if t < self.t || t == self.t && primitive < self.primitive {
            Self {
                primitive,
                t,
                weights: hits.weights.map(|weight| weight.lane(lane)),
            }
        } else {
            self
        }
    }
}

/// Returns the hit of a ray on a sphere in the form of a triangle's.
#[inline]
pub(crate) fn sphere_hit<V: Vector>(sphere: &Sphere, ray: &Ray<V>) -> TriangleHit<V::Real> {
    TriangleHit {
        t: sphere.distance(ray),
        weights: [V::Real::splat(0.0); 3],
    }
}

/// A node with up to [`WIDTH`] children.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
struct Node {
    /// Bounds of the children: `planes[axis][0]` lower, `planes[axis][1]` upper.
    planes: [[[f32; WIDTH]; 2]; 3],
    /// Twice the index of a node, or twice that of a leaf plus one.
    children: [u32; WIDTH],
    child_count: usize,
}

/// Primitives that a ray is tested against together.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
struct Leaf {
    /// Triangles by vertex and coordinate. Unused places repeat the first.
    vertices: [[[f64; MAX_LEAF_PRIMITIVES]; 3]; 3],
    /// Indices of the triangles in the original list.
    triangles: [u32; MAX_LEAF_PRIMITIVES],
    triangle_count: usize,
    /// Index of the first sphere, and number of spheres.
    spheres: (u32, u32),
}

/// Largest number of children of a node.
const WIDTH: usize = LANES;
/// Largest number of primitives in a leaf.
const MAX_LEAF_PRIMITIVES: usize = FOUR;
/// Size of the traversal stack. Seven siblings wait per level, so this suffices for 73 levels,
/// which the hierarchy does not exceed (`build::MAX_DEPTH`).
const STACK_SIZE: usize = 512;
/// Rounding of the ray's origin to single precision, relative to its largest coordinate, with a
/// margin of two.
const ORIGIN_MARGIN: f32 = 1.0 / 8_388_608.0;
/// Least component of a direction, relative to the largest: 0 would give 0 · ∞. Rays from near the
/// origin, whose coordinates need no rounding margin, thereby drift across planes in which boxes
/// end, so boxes are widened (`build::BOX_MARGIN`).
const LEAST_DIRECTION: f32 = 1e-18;
/// Rounding of the slab arithmetic, relative: a bound on 2γ₃ of Ize, JCGT 2(2), 2013.
const SLAB_MARGIN: f32 = 1.0 + 8.0 * f32::EPSILON;

/// The hierarchy over a list of primitives.
#[derive(Debug)]
pub struct Bvh {
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
    /// Spheres in the order of the leaves, each with its index in the original list.
    spheres: Vec<(u32, Sphere)>,
    /// Index of the node above all primitives but the walls.
    without_walls: u32,
}

/// Part of a hierarchy that rays traverse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// All primitives.
    All,
    /// All primitives but the walls that the hierarchy was built with.
    WithoutWalls,
}

impl Leaf {
    /// Returns the hits of a ray on the leaf's triangles, one lane each.
    #[inline]
    fn hits<T: Scalar>(&self, shear: &Shear<T::Four>) -> TriangleHit<T::Four> {
        let lanes = |numbers: [f64; FOUR]| T::Four::from_array(numbers.map(T::rounded));
        let vertex = |i: usize| self.vertices[i].map(lanes);
        let [a, b, c] = [0, 1, 2].map(|i| shear.project(vertex(i)));
        shear.hit([&a, &b, &c])
    }
}

impl Bvh {
    /// Returns the nearest hit with 0 < t < `t_max`.
    pub fn closest(&self, ray: &Ray, t_max: f64) -> Option<PrimitiveHit> {
        self.closest_in::<f64>(ray, t_max)
    }

    /// Returns [`closest`](Self::closest) in the precision of `T`, of whose numbers the ray and
    /// `t_max` consist.
    pub fn closest_in<T: Scalar>(&self, ray: &Ray, t_max: f64) -> Option<PrimitiveHit> {
        let none = PrimitiveHit {
            primitive: 0,
            t: t_max,
            weights: [0.0; 3],
        };
        let nearest = self.nearest_with::<T>(Part::All, ray, none);
        (nearest.t < t_max).then_some(nearest)
    }

    /// Returns the nearest hit on a part in the precision of `T`, or a known hit on another primitive
    /// if that comes first.
    pub(crate) fn nearest_with<T: Scalar>(
        &self,
        part: Part,
        ray: &Ray,
        known: PrimitiveHit,
    ) -> PrimitiveHit {
        let all = T::Four::splat;
        let (shear, ray_of_all) = (Shear::splat(ray), ray_of_all::<T>(ray));
        let mut nearest = known;
        self.traverse::<true>(part, ray, known.t, |leaf| {
            if leaf.triangle_count > 0 {
                let hits = leaf.hits::<T>(&shear);
                let mut near =
                    (!hits.t.cmpgt(all(nearest.t)) & hits.t.cmplt(all(f64::INFINITY))).bits();
                while near != 0 {
                    let lane = near.trailing_zeros() as usize % MAX_LEAF_PRIMITIVES;
                    near &= near - 1;
                    nearest = nearest.nearer(leaf.triangles[lane], &hits, lane);
                }
            }
            for (id, sphere) in self.spheres_of(leaf) {
                nearest = nearest.nearer(*id, &sphere_hit(sphere, &ray_of_all), 0);
            }
            Some(nearest.t)
        });
        nearest
    }

    /// Returns whether any primitive for which `blocks` holds is hit with 0 < t < `t_max`.
    #[inline]
    pub fn occluded(&self, ray: &Ray, t_max: f64, blocks: impl Fn(u32) -> bool) -> bool {
        self.occluded_in::<f64>(ray, t_max, blocks)
    }

    /// Returns [`occluded`](Self::occluded) in the precision of `T`, of whose numbers the ray and
    /// `t_max` consist.
    #[inline]
    pub fn occluded_in<T: Scalar>(
        &self,
        ray: &Ray,
        t_max: f64,
        blocks: impl Fn(u32) -> bool,
    ) -> bool {
        self.occluded_by::<T>(Part::All, ray, t_max, blocks)
    }

    /// Returns whether any primitive of a part for which `blocks` holds is hit with 0 < t < `t_max`,
    /// in the precision of `T`.
    #[inline]
    pub(crate) fn occluded_by<T: Scalar>(
        &self,
        part: Part,
        ray: &Ray,
        t_max: f64,
        blocks: impl Fn(u32) -> bool,
    ) -> bool {
        let (shear, ray_of_all) = (Shear::splat(ray), ray_of_all::<T>(ray));
        let end = T::Four::splat(t_max);
        let mut occluded = false;
        self.traverse::<false>(part, ray, t_max, |leaf| {
            if leaf.triangle_count > 0 {
                let hits = leaf.hits::<T>(&shear).t.cmplt(end).bits();
                occluded = hits != 0
                    && (0..MAX_LEAF_PRIMITIVES)
                        .any(|lane| hits >> lane & 1 == 1 && blocks(leaf.triangles[lane]));
            }
            let meets = |(id, sphere): &(u32, Sphere)| {
                sphere.distance(&ray_of_all).cmplt(end).any() && blocks(*id)
            };
            occluded = occluded || self.spheres_of(leaf).iter().any(meets);
            (!occluded).then_some(t_max)
        });
        occluded
    }

    /// Calls `each` with the indices of the primitives whose boxes meet the box from `low` to
    /// `high`, and of some of their neighbours, until it returns false.
    pub(crate) fn overlapping(&self, low: DVec3, high: DVec3, mut each: impl FnMut(u32) -> bool) {
        let [low, negative_high] = [low, -high].map(|v| v.to_array().map(build::rounded_down));
        let low = low.map(EightSingles::splat_scalar);
        let high = negative_high.map(|x| EightSingles::splat_scalar(-x));
        let mut waiting = ArrayVec::<u32, STACK_SIZE>::new();
        waiting.extend((!self.nodes.is_empty()).then_some(0));
        while let Some(child) = waiting.pop() {
            let place = (child / 2) as usize;
            if child % 2 == 1 {
                let leaf = &self.leaves[place];
                let triangles = &leaf.triangles[..leaf.triangle_count];
                let spheres = self.spheres_of(leaf).iter().map(|(id, _)| id);
                if !triangles.iter().chain(spheres).all(|id| each(*id)) {
                    return;
                }
                continue;
            }
            let node = &self.nodes[place];
            let misses = |axis: usize| {
                let [below, above] = node.planes[axis].map(EightSingles::from_array);
                below.cmpgt(high[axis]) | above.cmplt(low[axis])
            };
            let mut meets =
                !(misses(0) | misses(1) | misses(2)).bits() & ((1 << node.child_count) - 1);
            while meets != 0 {
                waiting.push(node.children[meets.trailing_zeros() as usize % WIDTH]);
                meets &= meets - 1;
            }
        }
    }

    #[inline]
    fn spheres_of(&self, leaf: &Leaf) -> &[(u32, Sphere)] {
        let (first, count) = leaf.spheres;
        &self.spheres[first as usize..][..count as usize]
    }

    /// Returns the index of the node above the primitives of a part; `None` if there are none.
    #[inline]
    fn root(&self, part: Part) -> Option<u32> {
        let root = match part {
            Part::All => 0,
            Part::WithoutWalls => self.without_walls,
        };
        (!self.nodes.is_empty()).then_some(root)
    }

    /// Calls `leaf` for the leaves of a part that the ray may meet, near ones first if `SORTED`. It
    /// returns the distance beyond which hits no longer matter, or `None` to stop.
    #[inline]
    fn traverse<const SORTED: bool>(
        &self,
        part: Part,
        ray: &Ray,
        t_max: f64,
        mut leaf: impl FnMut(&Leaf) -> Option<f64>,
    ) {
        let Some(root) = self.root(part) else {
            return;
        };
        // With a single leaf, testing boxes saves nothing.
        if let ([all], 0) = (&self.leaves[..], self.without_walls) {
            leaf(all);
            return;
        }
        let slabs = Slabs::new(ray);
        let mut limit = rounded_up(t_max as f32);
        // Not an array, which would be filled for every ray.
        let mut waiting = ArrayVec::<Waiting, STACK_SIZE>::new();
        let mut child = root * 2;
        loop {
            let place = (child / 2) as usize;
            if child % 2 == 1 {
                match leaf(&self.leaves[place]) {
                    Some(t_max) => limit = rounded_up(t_max as f32),
                    None => return,
                }
            } else {
                let node = &self.nodes[place];
                let (near, mut hits) = slabs.intersect(node, limit);
                if hits != 0 {
                    let near = near.lanes();
                    let mut next = || {
                        let slot = hits.trailing_zeros() as usize % WIDTH;
                        hits &= hits - 1;
                        let child = node.children[slot];
                        (
                            hits != 0,
                            Waiting {
                                near: near[slot],
                                child,
                            },
                        )
                    };
                    // The nearest child is next, without a detour over the stack.
                    let bottom = waiting.len();
                    let (mut is_more, mut nearest) = next();
                    while is_more {
                        let (more, mut other) = next();
                        is_more = more;
                        if other.near < nearest.near {
                            std::mem::swap(&mut nearest, &mut other);
                        }
                        let mut place = waiting.len();
                        waiting.push(other);
                        while SORTED && place > bottom && waiting[place - 1].near < other.near {
                            waiting[place] = waiting[place - 1];
                            place -= 1;
                            waiting[place] = other;
                        }
                    }
                    child = nearest.child;
                    continue;
                }
            }
            child = loop {
                match waiting.pop() {
                    Some(other) if other.near > limit => {}
                    Some(other) => break other.child,
                    None => return,
                }
            };
        }
    }
}

/// Returns a ray in every lane of [`Scalar::Four`].
#[inline]
fn ray_of_all<T: Scalar>(ray: &Ray) -> Ray<<T::Four as Real>::Vector> {
    let [origin, direction] =
        [ray.origin, ray.direction].map(<T::Four as Real>::Vector::splat_vector);
    Ray::new(origin, direction)
}

/// A child that is still to be visited.
#[derive(Clone, Copy)]
struct Waiting {
    /// Distance at which the ray enters its box.
    near: f32,
    child: u32,
}

/// A ray prepared for the box test. Near planes are tested from an origin moved towards them and
/// far planes from one moved away, by a bound on the origin's rounding.
struct Slabs {
    near_origin: [EightSingles; 3],
    far_origin: [EightSingles; 3],
    inverse: [EightSingles; 3],
    near_side: [usize; 3],
}

impl Slabs {
    #[inline]
    fn new(ray: &Ray) -> Self {
        let origin = ray.origin.as_vec3();
        let margin = origin.abs().max_element() * ORIGIN_MARGIN + f32::MIN_POSITIVE;
        // Segments may be tiny as a whole.
        let direction = ray.direction.as_vec3();
        let tiny = (direction.abs().max_element() * LEAST_DIRECTION).max(f32::MIN_POSITIVE);
        let direction = direction
            .to_array()
            .map(|d| if d.abs() < tiny { tiny.copysign(d) } else { d });
        let forward = direction.map(|d| d > 0.0);
        let shifted =
            |axis: usize, towards: bool| origin[axis] + if towards { margin } else { -margin };
        Self {
            near_origin: [0, 1, 2]
                .map(|axis| EightSingles::splat_scalar(shifted(axis, forward[axis]))),
            far_origin: [0, 1, 2]
                .map(|axis| EightSingles::splat_scalar(shifted(axis, !forward[axis]))),
            inverse: direction.map(|d| EightSingles::splat_scalar(1.0 / d)),
            near_side: forward.map(|f| usize::from(!f)),
        }
    }

    /// Returns the entry distances of the boxes, and a bit for each box that the ray meets before
    /// `limit`.
    #[inline]
    fn intersect(&self, node: &Node, limit: f32) -> (EightSingles, u32) {
        let (mut near, mut far) = (EightSingles::splat(0.0), EightSingles::splat_scalar(limit));
        for axis in 0..3 {
            let side = self.near_side[axis] & 1;
            let plane = |side: usize| EightSingles::from_array(node.planes[axis][side]);
            near = ((plane(side) - self.near_origin[axis]) * self.inverse[axis]).maximum(near);
            far = ((plane(side ^ 1) - self.far_origin[axis]) * self.inverse[axis]).minimum(far);
        }
        let hits = !near.cmpgt(far * EightSingles::splat_scalar(SLAB_MARGIN));
        (near, hits.bits() & ((1 << node.child_count) - 1))
    }
}

/// Returns a bound above the distance that was rounded to x, with the slabs' relative margin.
#[inline]
fn rounded_up(x: f32) -> f32 {
    x * SLAB_MARGIN
}
