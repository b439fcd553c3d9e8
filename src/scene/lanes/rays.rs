//! Nearest hits of ray packets, public for benchmarks.

use std::fmt;

use super::{IntersectionScratch, LaneScene};
use crate::geometry::shape::Ray;
use crate::math::real::Mask;
use crate::math::simd::{LANES, Lanes, Lanes3, Wide};
use crate::scene::Scene;

/// Intersects packets of N rays with a scene.
pub struct PacketIntersector<'a, R: Wide<N>, const N: usize> {
    scene: LaneScene<'a, R, N>,
    scratch: IntersectionScratch<R, N>,
}

/// [`PacketIntersector`] for eight rays in double precision.
pub type EightRayIntersector<'a> = PacketIntersector<'a, Lanes, LANES>;

impl<R: Wide<N>, const N: usize> fmt::Debug for PacketIntersector<'_, R, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("PacketIntersector")
            .field(&self.scene.scene.name())
            .finish()
    }
}

impl<'a, R: Wide<N>, const N: usize> PacketIntersector<'a, R, N> {
    /// Prepares a scene.
    pub fn new(scene: &'a Scene) -> Self {
        Self {
            scene: LaneScene::new(scene),
            scratch: IntersectionScratch::new(),
        }
    }

    /// Returns the distance to each ray's nearest hit, in units of its direction's length; infinite
    /// without a hit.
    pub fn closest(&mut self, ray: &Ray<R::Vector>) -> R {
        self.scene
            .closest(ray, R::Mask::splat(true), &mut self.scratch)
            .t
    }
}

impl EightRayIntersector<'_> {
    /// Returns the same as [`closest`](Self::closest). It is compiled in this crate, with its
    /// optimisations, where a generic function is compiled in the caller's.
    pub fn closest_of_eight(&mut self, ray: &Ray<Lanes3>) -> Lanes {
        self.closest(ray)
    }
}
