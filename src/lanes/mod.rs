//! Several paths at a time: the rays of all lanes, the surfaces that they meet, their random numbers, and the loops over
//! samples in which estimators follow them.
//!
//! All is generic over the numbers of a lane and over their count: eight in double precision, sixteen in single precision,
//! or one. A sample draws the same random numbers in any lane, and arithmetic rounds lane by lane, so its value does not
//! depend on the count. When a path ends, its lane takes the next sample.

mod interaction;
mod rays;
mod row;
mod samples;
mod scene;
mod state;
mod trace;
mod walls;

use std::ops::Range;

use crate::error::Error;
use crate::film::Pixel;
use crate::outline::Outlines;
use crate::real::Wide;
use crate::render::{LaneEstimator, Numbers, Sampling};
use crate::scene::Scene;
pub(crate) use interaction::{BsdfAt, BsdfSample, ShadingPoint, SurfaceInteraction};
pub use rays::{EightRays, LaneRays};
use row::row;
pub(crate) use samples::{LaneSampler, Sources};
use samples::{Points, Streams};
pub(crate) use scene::{IntersectionScratch, LaneScene, SceneData};
pub(crate) use state::{Integrator, PathState};
pub(crate) use trace::radiances;

/// An estimator in its scene, for rows of pixels.
pub(crate) struct Engine<'a, R: Wide<N>, const N: usize> {
    scene: LaneScene<'a, R, N>,
    estimator: LaneEstimator,
    pub sampling: Sampling,
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

    fn row_by<E: Integrator>(
        &self,
        estimator: &E,
        place: Place,
        range: &Range<u32>,
        pixels: PixelsAndCounts<'_>,
    ) -> Result<(), Error> {
        let of = (self.scene, estimator);
        match self.sampling.numbers {
            Numbers::Independent => {
                row::<E, R, Streams<N>, N>(of, (&self.sampling, &self.outlines), place, range, pixels)
            }
            Numbers::Sobol(_) => row::<E, R, Points<N>, N>(of, (&self.sampling, &self.outlines), place, range, pixels),
        }
    }
}

/// The lanes whose bits are set.
#[inline]
pub(crate) fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (lane < 32).then_some(lane)
    })
}
