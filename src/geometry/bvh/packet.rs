//! Packet traversal: several rays go through the hierarchy together, each with the same result as
//! alone.
//!
//! A node is visited if any ray may meet it. Then the box of each of its children, and each
//! primitive of a leaf, is tested against all rays at once.

use std::array::from_fn;

use super::{
    Bvh, LEAST_DIRECTION, Leaf, Node, ORIGIN_MARGIN, Part, PrimitiveHit, SLAB_MARGIN, STACK_SIZE,
    rounded_up, sphere_hit,
};
use crate::geometry::shape::Ray;
use crate::geometry::watertight::{LaneShear, Shear, TriangleHit};
use crate::math::real::{Mask, Real, Vector};
use crate::math::simd::{LANES, Lanes, Scalar, Wide, map_array};

/// Nearest hits of several rays.
#[derive(Clone, Copy, Debug)]
pub struct PacketHit<R: Real = Lanes, const N: usize = LANES> {
    /// Lanes whose ray has hit something.
    pub hit_mask: R::Mask,
    /// Index of the primitive in the list that the hierarchy was built from; 0 in other lanes.
    pub primitive: [u32; N],
    /// Distance t of (1), infinite in other lanes.
    pub t: R,
    /// Barycentric weights of a triangle's vertices; zero for spheres.
    pub weights: [R; 3],
}

/// Nearest hits of several rays so far.
pub(crate) struct Nearest<R> {
    primitive: R,
    t: R,
    weights: [R; 3],
}

/// Traversal stack of a packet: children still to be visited, with the distances at which the rays
/// enter their boxes. One buffer serves all packets.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub struct PacketStack<const N: usize = LANES> {
    /// Distance at which the first ray that meets a box enters it, which orders the children of a
    /// node.
    nearest: [f32; STACK_SIZE],
    entered: [[f32; N]; STACK_SIZE],
    children: [u32; STACK_SIZE],
}

/// Rays prepared for the box test, lane by lane as in [`crate::geometry::bvh::Slabs`].
struct Slabs<S> {
    /// Origins for the planes at the low ends, and for those at the high ends.
    origins: [[S; 3]; 2],
    inverse: [S; 3],
}

impl<R: Real> Nearest<R> {
    pub fn new() -> Self {
        let zero = R::splat(0.0);
        Self {
            primitive: zero,
            t: R::splat(f64::INFINITY),
            weights: [zero; 3],
        }
    }

    /// Takes the hits on other primitives where they are nearer. Of two at the same distance the
    /// one that comes first in the list wins, in whatever order they are tested.
    #[inline]
    pub fn take_nearer(&mut self, primitive: R, hit: &TriangleHit<R>) {
        let nearer = hit.t.cmplt(self.t) | hit.t.cmpeq(self.t) & primitive.cmplt(self.primitive);
        self.primitive = R::select(nearer, primitive, self.primitive);
        self.t = R::select(nearer, hit.t, self.t);
        self.weights = from_fn(|i| R::select(nearer, hit.weights[i], self.weights[i]));
    }

    /// Returns the hit of each lane; t is infinite in lanes without one.
    #[inline]
    pub fn hits<const N: usize>(&self) -> [PrimitiveHit; N]
    where
        R: Wide<N>,
    {
        let (primitives, t) = (self.primitive.to_u32(), self.t.lanes());
        let weights = map_array(self.weights, R::lanes);
        from_fn(|i| PrimitiveHit {
            primitive: primitives[i],
            t: t[i].into(),
            weights: weights.map(|weight| weight[i].into()),
        })
    }

    /// Returns the hits of the `active` lanes.
    #[inline]
    pub fn of<const N: usize>(&self, active: R::Mask) -> PacketHit<R, N>
    where
        R: Wide<N>,
    {
        let hit_mask = active & self.t.cmplt(R::splat(f64::INFINITY));
        let primitive = R::select(hit_mask, self.primitive, R::splat(0.0)).to_u32();
        let t = R::select(hit_mask, self.t, R::splat(f64::INFINITY));
        PacketHit {
            hit_mask,
            primitive,
            t,
            weights: self.weights,
        }
    }
}

impl<const N: usize> Default for PacketStack<N> {
    fn default() -> Self {
        Self {
            nearest: [0.0; STACK_SIZE],
            entered: [[0.0; N]; STACK_SIZE],
            children: [0; STACK_SIZE],
        }
    }
}

impl Bvh {
    /// Returns [`closest`](Self::closest) for each ray of the `active` lanes, without limit.
    #[inline]
    pub fn closest_of_packet<R: Wide<N>, const N: usize>(
        &self,
        ray: &Ray<R::Vector>,
        active: R::Mask,
        stack: &mut PacketStack<N>,
    ) -> PacketHit<R, N> {
        let mut nearest = Nearest::new();
        self.nearest_of_packet(Part::All, ray, active, &mut nearest, stack);
        nearest.of(active)
    }

    /// Takes the nearest hits of the `active` lanes on a part where they come before those known;
    /// other lanes may take hits, too.
    #[inline]
    pub(crate) fn nearest_of_packet<R: Wide<N>, const N: usize>(
        &self,
        part: Part,
        ray: &Ray<R::Vector>,
        active: R::Mask,
        nearest: &mut Nearest<R>,
        stack: &mut PacketStack<N>,
    ) {
        let shear = Shear::new(ray);
        self.traverse_packet::<R, N>(part, ray, limits(active, nearest.t), stack, |leaf| {
            for i in 0..leaf.triangle_count {
                nearest.take_nearer(
                    R::splat(leaf.triangles[i].into()),
                    &leaf.hit_of_packet(i, &shear),
                );
            }
            for (id, sphere) in self.spheres_of(leaf) {
                nearest.take_nearer(R::splat((*id).into()), &sphere_hit(sphere, ray));
            }
            limits(active, nearest.t)
        });
    }

    /// Calls `leaf` for the leaves of a part that any ray may meet, near ones first. It returns for
    /// each ray the distance beyond which hits no longer matter.
    #[inline]
    fn traverse_packet<R: Wide<N>, const N: usize>(
        &self,
        part: Part,
        ray: &Ray<R::Vector>,
        mut limits: R::Single,
        stack: &mut PacketStack<N>,
        mut leaf: impl FnMut(&Leaf) -> R::Single,
    ) {
        let slabs = Slabs::<R::Single>::new::<R, N>(ray);
        let root = self.root(part);
        (stack.entered[0], stack.children[0]) = ([0.0; N], root.map_or(0, |root| root * 2));
        let mut stack_size = usize::from(root.is_some());
        while stack_size > 0 {
            stack_size -= 1;
            let (near, child) = (stack.entered[stack_size], stack.children[stack_size]);
            if R::Single::from_array(near.map(Scalar::from_single))
                .cmpgt(limits)
                .bits()
                == u32::MAX >> (32 - N)
            {
                continue;
            }
            let place = (child / 2) as usize;
            if child % 2 == 1 {
                limits = leaf(&self.leaves[place]);
                continue;
            }
            let node = &self.nodes[place];
            let bottom = stack_size;
            for slot in 0..node.child_count {
                let (near, hits) = slabs.intersect(node, slot, limits);
                if hits == 0 {
                    continue;
                }
                let near = near.lanes().map(Scalar::single);
                let nearest = near[hits.trailing_zeros() as usize % N];
                let mut place = stack_size;
                while place > bottom && stack.nearest[place - 1] < nearest {
                    stack.nearest[place] = stack.nearest[place - 1];
                    stack.entered[place] = stack.entered[place - 1];
                    stack.children[place] = stack.children[place - 1];
                    place -= 1;
                }
                stack.nearest[place] = nearest;
                stack.entered[place] = near;
                stack.children[place] = node.children[slot];
                stack_size += 1;
            }
        }
    }
}

impl Leaf {
    /// Returns the hits of the rays on one of the leaf's triangles.
    #[inline]
    fn hit_of_packet<R: Wide<N>, const N: usize>(
        &self,
        triangle: usize,
        shear: &LaneShear<R>,
    ) -> TriangleHit<R> {
        let vertex = |vertex: usize| self.vertices[vertex].map(|axis| R::splat(axis[triangle]));
        let [a, b, c] = [0, 1, 2].map(|i| shear.project(vertex(i)));
        shear.hit([&a, &b, &c])
    }
}

/// Returns the distances beyond which hits no longer matter; −∞ in lanes that are not in `lanes`.
#[inline]
fn limits<R: Wide<N>, const N: usize>(lanes: R::Mask, t: R) -> R::Single {
    let t = R::select(lanes, t, R::splat(f64::NEG_INFINITY));
    R::Single::from_array(
        t.lanes()
            .map(|t| Scalar::from_single(rounded_up(t.single()))),
    )
}

impl<S: Real> Slabs<S> {
    #[inline]
    fn new<R: Wide<N, Single = S>, const N: usize>(ray: &Ray<R::Vector>) -> Self {
        let largest = |[x, y, z]: [S; 3]| x.abs().maximum(y.abs()).maximum(z.abs());
        let origin = ray.origin.components().map(R::single);
        let margin = largest(origin) * f64::from(ORIGIN_MARGIN) + f64::from(f32::MIN_POSITIVE);
        // As in the test of one ray.
        let direction = ray.direction.components().map(R::single);
        let tiny = (largest(direction) * f64::from(LEAST_DIRECTION))
            .maximum(S::splat(f32::MIN_POSITIVE.into()));
        let inverse = direction.map(|d| d.abs().maximum(tiny).copysign(d).recip());
        Self {
            origins: [origin.map(|o| o + margin), origin.map(|o| o - margin)],
            inverse,
        }
    }

    /// Returns the distances at which the rays enter the box of a child, and a bit for each ray
    /// that enters it before its limit.
    #[inline(always)]
    fn intersect<const N: usize>(&self, node: &Node, slot: usize, limits: S) -> (S, u32)
    where
        S: Wide<N>,
    {
        let (mut near, mut far) = (S::splat(0.0), limits);
        for axis in 0..3 {
            let [low, high] = [0, 1].map(|end| {
                let plane = S::splat(node.planes[axis][end][slot].into());
                (plane - self.origins[end][axis]) * self.inverse[axis]
            });
            near = near.maximum(low.minimum(high));
            far = far.minimum(low.maximum(high));
        }
        (near, (!near.cmpgt(far * f64::from(SLAB_MARGIN))).bits())
    }
}
