//! The loop over pixels, replications and samples for estimators that follow several paths at a
//! time.

use std::ops::Range;

use super::row::{LaneEstimator, RowRenderer};
use super::silhouette::Outlines;
use super::{Prepared, Progress, Renderer, UNINTERRUPTED, each_part};
use crate::error::Error;
use crate::film::Film;
use crate::integrator::Estimator as _;
use crate::math::simd::{LANES, Lanes, SINGLES, Singles, Wide};
use crate::sampling::Sampling;
use crate::scene::Scene;
use crate::scene::lanes::LaneScene;

/// [`render`](super::render()) several paths at a time: the same bytes.
///
/// # Errors
/// Those of [`render`](super::render()).
pub fn render_lanes(
    scene: &Scene,
    estimator: LaneEstimator,
    sampling: Sampling,
    film: &mut Film,
    range: &Range<u32>,
    done: Progress<'_>,
) -> Result<bool, Error> {
    ByLanes {
        estimator,
        sampling,
        precision: Precision::Double,
    }
    .add(scene, film, range.clone(), done)
}

/// Refuses scenes in which single precision would be seen: where the largest coordinate lies
/// outside [`SINGLE_EXTENTS`] or is more than [`SINGLE_DETAIL`] times the size of something: the
/// radius of a sphere or the height of a zone, or the second largest extent of triangles that hang
/// together; and where surfaces [coincide](Scene::coincident_in_singles).
///
/// # Errors
/// [`Error::Option`] that says why, and what to do.
pub fn check_singles(scene: &Scene) -> Result<(), Error> {
    let extent = scene.extent();
    let [low, high] = SINGLE_EXTENTS;
    if !(low..=high).contains(&extent) {
        return Err(Error::Option(format!(
            "the scene reaches to {extent:?}, and in single precision may to {low:?} at least and {high:?} at most"
        )));
    }
    let detail = scene.smallest_detail();
    if extent > detail * SINGLE_DETAIL {
        return Err(Error::Option(format!(
            "the scene has something of size {detail:.1e}, too small for single precision where the scene reaches to \
             {extent:?}, more than {SINGLE_DETAIL} times as far"
        )));
    }
    match scene.coincident_in_singles() {
        Some(coincidence) => Err(Error::Option(format!("in single precision {coincidence}"))),
        None => Ok(()),
    }
}

/// The least and the most that a scene may reach to in single precision: no product of a few
/// lengths is lost.
pub const SINGLE_EXTENTS: [f64; 2] = [1e-6, 1e6];
/// How many times as far as the size of its smallest thing a scene may reach in single precision.
/// The experiment `single` measures what is seen below and beyond.
pub const SINGLE_DETAIL: f64 = 4096.0;

/// Renders as [`ByRays`](super::ByRays) does, several paths at a time.
#[derive(Clone, Copy, Debug)]
pub struct ByLanes {
    /// The estimator of the radiance along a ray.
    pub estimator: LaneEstimator,
    /// Which rays, by which random numbers.
    pub sampling: Sampling,
    /// How exactly it computes.
    pub precision: Precision,
}

/// The precision of the numbers of a lane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// Eight paths at a time, to the bytes of [`ByRays`](super::ByRays).
    #[default]
    Double,
    /// Sixteen paths at a time: the same paths by the same random numbers, rounded, where
    /// [`check_singles`] finds nothing.
    Single,
    /// The same in any scene, to measure what would be seen there.
    UncheckedSingle,
}

impl Renderer for ByLanes {
    fn samples_per_replication(&self) -> u32 {
        self.sampling.samples_per_replication()
    }
    fn prepare<'a>(
        &'a self,
        scene: &'a Scene,
        frame: [u32; 2],
    ) -> Result<Box<dyn Prepared + 'a>, Error> {
        if self.precision == Precision::Single {
            check_singles(scene)?;
        }
        Ok(match self.precision {
            Precision::Double => Box::new(self.prepared::<Lanes, LANES>(scene, frame)),
            Precision::Single | Precision::UncheckedSingle => {
                Box::new(self.prepared::<Singles, SINGLES>(scene, frame))
            }
        })
    }
}

impl ByLanes {
    fn prepared<'a, R: Wide<N>, const N: usize>(
        &self,
        scene: &'a Scene,
        frame: [u32; 2],
    ) -> RowRenderer<'a, R, N> {
        let Self {
            estimator,
            sampling,
            ..
        } = *self;
        let sees_in_mirrors =
            matches!(estimator, LaneEstimator::Path(path) if path.sees_in_mirrors());
        let outlines = Outlines::new(scene, frame, sampling, sees_in_mirrors);
        RowRenderer {
            scene: LaneScene::new(scene),
            estimator,
            sampling,
            frame,
            outlines,
        }
    }
}

impl<R: Wide<N>, const N: usize> Prepared for RowRenderer<'_, R, N> {
    fn add(&self, film: &mut Film, range: Range<u32>, done: Progress<'_>) -> Result<bool, Error> {
        each_part(self.sampling, UNINTERRUPTED, film, &range, done, |pieces| {
            pieces
                .iter_mut()
                .try_for_each(|piece| Self::add(self, piece))
        })
    }
}
