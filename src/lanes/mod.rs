//! The lane engine: eight paths at a time, with the same bits as each of them alone, or sixteen in single precision.
//!
//! It follows the readable estimators vertex by vertex. All arithmetic is that of the same functions, generic over
//! [`Real`](crate::real::Real); each sample draws the same random numbers in the same order; and a film's sums are
//! exact. So an image of this engine equals that of [`render`](crate::render::render) byte by byte, and every trial of
//! a readable estimator is one of this engine. When a path ends, its lane takes the next sample.

mod lights;
mod path;
mod rays;
mod report;
mod row;
mod samples;
mod scene;
mod shading;
mod specular;
mod walks;
mod walls;
mod whitted;

use std::ops::Range;

use crate::error::Error;
use crate::film::Pixel;
use crate::outline::Outlines;
use crate::real::Wide;
use crate::render::{LaneEstimator, Numbers, Sampling};
use crate::scene::Scene;
pub use rays::{EightRays, LaneRays};
use row::{Scatter, row};
use samples::{Points, Streams};
use scene::LaneScene;
pub(crate) use walks::Walks;

/// An estimator in its scene, for rows of pixels.
pub(crate) struct Engine<'a, R: Wide<N>, const N: usize> {
    scene: LaneScene<'a, R, N>,
    estimator: LaneEstimator,
    sampling: Sampling,
    outlines: Outlines,
}

/// A row of pixels: the corner of the first in a frame of this size.
pub(crate) type Place = ([u32; 2], [u32; 2]);

/// Pixels, and how many samples a replication of each has.
pub(crate) type PixelsAndCounts<'a> = (&'a mut [Pixel], &'a [u32]);

impl<'a, R: Wide<N>, const N: usize> Engine<'a, R, N> {
    pub fn new(scene: &'a Scene, estimator: LaneEstimator, (sampling, outlines): (Sampling, Outlines)) -> Self {
        Self { scene: LaneScene::new(scene), estimator, sampling, outlines }
    }

    /// Adds the replications `range` to a row of pixels.
    pub fn row(&self, place: Place, range: &Range<u32>, pixels: PixelsAndCounts<'_>) -> Result<(), Error> {
        match self.estimator {
            LaneEstimator::Path(path) => self.row_by(&path, place, range, pixels),
            LaneEstimator::Report(report) => self.row_by(&report, place, range, pixels),
            LaneEstimator::Whitted(whitted) => self.row_by(&whitted, place, range, pixels),
        }
    }

    fn row_by<E: Scatter>(
        &self,
        estimator: &E,
        place: Place,
        range: &Range<u32>,
        pixels: PixelsAndCounts<'_>,
    ) -> Result<(), Error> {
        let of = (&self.scene, estimator);
        match self.sampling.numbers {
            Numbers::Independent => {
                row::<E, R, Streams<N>, N>(of, (&self.sampling, &self.outlines), place, range, pixels)
            }
            Numbers::Sobol(_) => row::<E, R, Points<N>, N>(of, (&self.sampling, &self.outlines), place, range, pixels),
        }
    }
}
