//! Eight rays that go through the hierarchy together, each with the same answer as alone.
//!
//! A node is visited if any of them may meet it. Then the box of each of its children, and each primitive of a leaf,
//! is tested against all of them at once.

use std::array::from_fn;
use std::ops::Range;

use wide::f32x8;

use super::{Bvh, COUNT_BITS, COUNT_MASK, Node, ORIGIN_MARGIN, SLAB_MARGIN, STACK, rounded_up};
use crate::real::{LANES, LaneMask, Lanes, Lanes3, Real, Vector};
use crate::shape::Ray;
use crate::watertight::{Shear, TriangleHit};

/// The nearest hits of eight rays.
#[derive(Clone, Copy, Debug)]
pub struct PacketHit {
    /// The lanes whose ray has hit something.
    pub met: LaneMask,
    /// Which primitive, by its place in the list that the hierarchy was built from; 0 in other lanes.
    pub primitive: [u32; LANES],
    /// t of (1), infinite in other lanes.
    pub t: Lanes,
    /// Barycentric weights of a triangle's vertices; zero for spheres.
    pub weights: [Lanes; 3],
}

/// What eight rays have hit so far.
pub(crate) struct Nearest {
    primitive: Lanes,
    t: Lanes,
    weights: [Lanes; 3],
}

/// Children that wait to be visited: where the rays enter their boxes, and which they are. One buffer serves all packets.
#[derive(Clone, Debug)]
pub struct PacketStack([(f32x8, u32); STACK]);

/// Rays as the box test sees them, as [`super::Slabs`] of each.
struct Slabs {
    /// What the planes at the low ends are seen from, and those at the high ends.
    origins: [[f32x8; 3]; 2],
    inverse: [f32x8; 3],
}

impl Nearest {
    pub fn new() -> Self {
        let zero = Lanes::splat(0.0);
        Self { primitive: zero, t: Lanes::splat(f64::INFINITY), weights: [zero; 3] }
    }

    /// Takes the hits on other primitives where they are nearer. Of two at the same distance it is the one that comes
    /// first in the list, in whatever order they are tested.
    #[inline]
    pub fn or(&mut self, primitive: Lanes, hit: &TriangleHit<Lanes>) {
        let nearer = hit.t.below(self.t) | hit.t.equals(self.t) & primitive.below(self.primitive);
        self.primitive = Lanes::choose(nearer, primitive, self.primitive);
        self.t = Lanes::choose(nearer, hit.t, self.t);
        self.weights = from_fn(|i| Lanes::choose(nearer, hit.weights[i], self.weights[i]));
    }

    /// The hits of the `active` lanes.
    #[inline]
    pub fn of(&self, active: LaneMask) -> PacketHit {
        let met = active & self.t.below(Lanes::splat(f64::INFINITY));
        let primitive = Lanes::choose(met, self.primitive, Lanes::splat(0.0)).to_array().map(|id| id as u32);
        let t = Lanes::choose(met, self.t, Lanes::splat(f64::INFINITY));
        PacketHit { met, primitive, t, weights: self.weights }
    }
}

impl Default for PacketStack {
    fn default() -> Self {
        Self([(f32x8::ZERO, 0); STACK])
    }
}

impl Bvh {
    /// [`closest`](Self::closest) for each ray of the `active` lanes, without limit.
    #[inline]
    pub fn closest_of_packet(&self, ray: &Ray<Lanes3>, active: LaneMask, stack: &mut PacketStack) -> PacketHit {
        let shear = Shear::new(ray);
        let mut nearest = Nearest::new();
        self.traverse_packet(ray, limits(active, nearest.t), stack, |leaf| {
            for i in leaf {
                nearest.or(Lanes::splat(f64::from(self.ids[i])), &self.primitives[i].hit(ray, &shear));
            }
            limits(active, nearest.t)
        });
        nearest.of(active)
    }

    /// [`occluded`](Self::occluded) up to t = 1 for each segment of the `active` lanes; no in other lanes.
    #[inline]
    pub fn occluded_of_packet(
        &self,
        segment: &Ray<Lanes3>,
        active: LaneMask,
        blocks: impl Fn(u32) -> bool,
        stack: &mut PacketStack,
    ) -> LaneMask {
        let (shear, one) = (Shear::new(segment), Lanes::splat(1.0));
        let mut free = active;
        self.traverse_packet(segment, limits(free, one), stack, |leaf| {
            for i in leaf {
                if blocks(self.ids[i]) {
                    free = free & !self.primitives[i].hit(segment, &shear).t.below(one);
                }
            }
            limits(free, one)
        });
        active & !free
    }

    /// Calls `leaf` with the primitives that any ray may meet, near ones first. It returns the distances beyond which
    /// nothing matters to a ray any more.
    #[inline]
    fn traverse_packet(
        &self,
        ray: &Ray<Lanes3>,
        mut limits: f32x8,
        PacketStack(stack): &mut PacketStack,
        mut leaf: impl FnMut(Range<usize>) -> f32x8,
    ) {
        let slabs = Slabs::new(ray);
        stack[0] = (f32x8::ZERO, 0);
        let mut waiting = usize::from(self.levels > 0);
        while waiting > 0 {
            waiting -= 1;
            let (near, child) = stack[waiting];
            if near.simd_le(limits).to_bitmask() == 0 {
                continue;
            }
            let first = (child >> COUNT_BITS) as usize;
            let count = (child & COUNT_MASK) as usize;
            if count > 0 {
                limits = leaf(first..first + count);
                continue;
            }
            let node = &self.nodes[first];
            let entered = [0, 1, 2, 3].map(|slot| {
                let (near, hits) = slabs.intersect(node, slot, limits);
                (near, if node.children[slot] == 0 { 0 } else { hits })
            });
            // The first ray that meets a box stands for all. Boxes that none meets come last.
            let mut order: [u32; 4] = from_fn(|slot| {
                let (near, hits) = entered[slot];
                let distance = near.as_array()[hits.trailing_zeros() as usize & 7];
                if hits == 0 { u32::MAX } else { distance.to_bits() & !3 | slot as u32 }
            });
            for [i, j] in [[0, 1], [2, 3], [0, 2], [1, 3], [1, 2]] {
                (order[i], order[j]) = (order[i].min(order[j]), order[i].max(order[j]));
            }
            let met = entered.iter().filter(|(_, hits)| *hits != 0).count();
            for &key in order[..met].iter().rev() {
                let slot = (key & 3) as usize;
                stack[waiting] = (entered[slot].0, node.children[slot]);
                waiting += 1;
            }
        }
    }
}

/// The distances beyond which nothing matters; none matters where `lanes` says no.
#[inline]
fn limits(lanes: LaneMask, t: Lanes) -> f32x8 {
    let t = Lanes::choose(lanes, t, Lanes::splat(f64::NEG_INFINITY));
    f32x8::new(t.to_array().map(rounded_up))
}

impl Slabs {
    #[inline]
    fn new(ray: &Ray<Lanes3>) -> Self {
        let single = |v: Lanes3| v.components().map(|component| f32x8::new(component.to_array().map(|x| x as f32)));
        let origin = single(ray.origin);
        let largest = |[x, y, z]: [f32x8; 3]| x.abs().fast_max(y.abs()).fast_max(z.abs());
        let margin = largest(origin) * f32x8::splat(ORIGIN_MARGIN) + f32x8::splat(f32::MIN_POSITIVE);
        // As in the test of one ray.
        let direction = single(ray.direction);
        let tiny = (largest(direction) * f32x8::splat(1e-18)).fast_max(f32x8::splat(f32::MIN_POSITIVE));
        let sign = f32x8::splat(-0.0);
        let inverse = direction.map(|d| f32x8::ONE / (d.abs().fast_max(tiny) | (d & sign)));
        Self { origins: [origin.map(|o| o + margin), origin.map(|o| o - margin)], inverse }
    }

    /// Where the rays enter the box of a child, and a bit for each ray that does so before its limit.
    #[inline(always)]
    fn intersect(&self, node: &Node, slot: usize, limits: f32x8) -> (f32x8, u32) {
        let (mut near, mut far) = (f32x8::ZERO, limits);
        for axis in 0..3 {
            let [low, high] = [0, 1].map(|end| {
                (f32x8::splat(node.planes[axis][end].as_ref()[slot]) - self.origins[end][axis]) * self.inverse[axis]
            });
            near = near.fast_max(low.fast_min(high));
            far = far.fast_min(low.fast_max(high));
        }
        (near, near.simd_le(far * f32x8::splat(SLAB_MARGIN)).to_bitmask())
    }
}
