//! The loop over pixels, replications and samples for estimators that trace several paths at a
//! time, in lanes.

use std::ops::Range;

use super::row::{LaneEstimator, RowRenderer};
use super::silhouette::Silhouettes;
use super::{CHUNK_SAMPLES, Prepared, Progress, Renderer, for_each_tile};
use crate::error::Error;
use crate::film::Film;
use crate::integrator::Estimator as _;
use crate::math::simd::{LANES, Lanes, SINGLES, Singles, Wide};
use crate::sampling::Sampling;
use crate::scene::Scene;
use crate::scene::lanes::LaneScene;

/// Renders as [`render`](super::render()), several paths at a time, to the same bytes.
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

/// Refuses scenes in which single precision would be visible: where the largest coordinate lies
/// outside [`SINGLE_EXTENTS`] or is more than [`SINGLE_DETAIL`] times the size of a detail (the
/// radius of a sphere or the height of a zone, or the second largest extent of connected
/// triangles); and where surfaces [coincide](Scene::coincident_in_singles).
///
/// # Errors
/// [`Error::Option`] with the reason, and advice.
pub fn check_singles(scene: &Scene) -> Result<(), Error> {
    let extent = scene.extent();
    let [low, high] = SINGLE_EXTENTS;
    if !(low..=high).contains(&extent) {
        return Err(Error::Option(format!(
            "the scene reaches to {extent:?}; in single precision it must reach from {low:?} to {high:?}"
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

/// Least and largest extent of a scene in single precision: no product of a few lengths overflows
/// or underflows.
pub const SINGLE_EXTENTS: [f64; 2] = [1e-6, 1e6];
/// Largest ratio of a scene's extent to its smallest detail in single precision. The experiment
/// `single` measures the error below and beyond.
pub const SINGLE_DETAIL: f64 = 4096.0;

/// Renderer as [`ByRays`](super::ByRays), several paths at a time.
#[derive(Clone, Copy, Debug)]
pub struct ByLanes {
    /// Estimator of the radiance along a ray.
    pub estimator: LaneEstimator,
    /// Sampling settings.
    pub sampling: Sampling,
    /// Precision of the arithmetic.
    pub precision: Precision,
}

/// Precision of a lane's numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// Eight paths at a time, to the bytes of [`ByRays`](super::ByRays).
    #[default]
    Double,
    /// Sixteen paths at a time: the same paths by the same random numbers, rounded, in scenes that
    /// pass [`check_singles`].
    Single,
    /// Single precision in any scene, to measure the errors that [`check_singles`] prevents.
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
        let silhouettes = Silhouettes::new(scene, frame, sampling, sees_in_mirrors);
        RowRenderer {
            scene: LaneScene::new(scene),
            estimator,
            sampling,
            frame,
            silhouettes,
        }
    }
}

impl<R: Wide<N>, const N: usize> Prepared for RowRenderer<'_, R, N> {
    fn add(&self, film: &mut Film, range: Range<u32>, done: Progress<'_>) -> Result<bool, Error> {
        for_each_tile(self.sampling, CHUNK_SAMPLES, film, &range, done, |pieces| {
            pieces
                .iter_mut()
                .try_for_each(|piece| Self::add(self, piece))
        })
    }
}
