//! The lane engine: eight paths at a time, with the same bits as each of them alone.
//!
//! It follows the readable estimators vertex by vertex. All arithmetic is that of the same functions, generic over
//! [`Real`](crate::real::Real); each sample draws the same random numbers in the same order; and a film's sums are
//! exact. So an image of this engine equals that of [`render`](crate::render::render) byte by byte, and every trial of
//! a readable estimator is one of this engine. When a path ends, its lane takes the next sample.

mod path;
mod samples;
mod scene;
mod shading;

use std::ops::Range;

use crate::error::Error;
use crate::estimator::Path;
use crate::film::Pixel;
use crate::render::{Numbers, Sampling};
use crate::scene::Scene;
use samples::{Points, Streams};
use scene::LaneScene;

/// A path tracer in its scene, for rows of pixels.
pub(crate) struct Engine<'a> {
    scene: LaneScene<'a>,
    path: &'a Path,
    sampling: Sampling,
}

impl<'a> Engine<'a> {
    pub fn new(scene: &'a Scene, path: &'a Path, sampling: Sampling) -> Self {
        Self { scene: LaneScene::new(scene), path, sampling }
    }

    /// Adds the replications `range` to a row of pixels whose first stands at `corner` of the frame.
    pub fn row(&self, place: ([u32; 2], [u32; 2]), range: &Range<u32>, pixels: &mut [Pixel]) -> Result<(), Error> {
        let of = (&self.scene, self.path);
        match self.sampling.numbers {
            Numbers::Independent => path::row::<Streams>(of, &self.sampling, place, range, pixels),
            Numbers::Sobol(_) => path::row::<Points>(of, &self.sampling, place, range, pixels),
        }
    }
}
