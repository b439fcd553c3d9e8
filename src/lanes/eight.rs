//! The lane engine's question alone, for those who measure it: what do eight rays meet first?

use std::fmt;

use super::scene::{LaneScene, Seen};
use crate::real::{LANES, LaneMask, Lanes, Lanes3, WideMask};
use crate::scene::Scene;
use crate::shape::Ray;

/// A small scene of triangles, all of which eight rays are tested against at once.
pub struct EightRays<'a> {
    scene: LaneScene<'a, Lanes, LANES>,
    seen: Box<Seen<Lanes, LANES>>,
}

impl fmt::Debug for EightRays<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("EightRays").field(&self.scene.scene.name()).finish()
    }
}

impl<'a> EightRays<'a> {
    /// `None` for a scene of more than 64 primitives, in which rays go through the hierarchy, and for one with spheres.
    pub fn new(scene: &'a Scene) -> Option<Self> {
        let scene = LaneScene::new(scene);
        scene.has_few_triangles().then(|| Self { scene, seen: Box::new(Seen::new()) })
    }

    /// How far each ray's nearest hit is, in units of its direction's length; infinite where there is none.
    pub fn closest(&mut self, ray: &Ray<Lanes3>) -> Lanes {
        self.scene.closest(ray, LaneMask::splat(true), &mut self.seen).t
    }

    /// How many additions, subtractions, multiplications and divisions of one lane that takes. Comparisons and choices
    /// are not counted.
    pub fn operations(&mut self, ray: &Ray<Lanes3>) -> u32 {
        self.scene.operations(ray, &mut self.seen)
    }
}
