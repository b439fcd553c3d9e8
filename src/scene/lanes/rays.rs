//! The nearest hits of several rays, for those who measure the search for them.

use std::fmt;

use super::{IntersectionScratch, LaneScene};
use crate::geometry::shape::Ray;
use crate::math::real::Mask;
use crate::math::simd::{LANES, Lanes, Wide};
use crate::scene::Scene;

/// A small scene of triangles, against which several rays are tested at once.
pub struct LaneRays<'a, R: Wide<N>, const N: usize> {
    scene: LaneScene<'a, R, N>,
    scratch: IntersectionScratch<R, N>,
}

/// The same for eight rays in double precision.
pub type EightRays<'a> = LaneRays<'a, Lanes, LANES>;

impl<R: Wide<N>, const N: usize> fmt::Debug for LaneRays<'_, R, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("LaneRays")
            .field(&self.scene.scene.name())
            .finish()
    }
}

impl<'a, R: Wide<N>, const N: usize> LaneRays<'a, R, N> {
    /// `None` for a scene of more than 64 primitives, in which rays go through the hierarchy, and
    /// for one with spheres.
    pub fn new(scene: &'a Scene) -> Option<Self> {
        let scene = LaneScene::new(scene);
        scene.has_few_triangles().then(|| Self {
            scene,
            scratch: IntersectionScratch::new(),
        })
    }

    /// How far each ray's nearest hit is, in units of its direction's length; infinite where there
    /// is none.
    pub fn closest(&mut self, ray: &Ray<R::Vector>) -> R {
        self.scene
            .closest(ray, R::Mask::splat(true), &mut self.scratch)
            .t
    }
}
