//! The loop over pixels, replications and samples for estimators that trace several paths at a
//! time, in lanes.

use std::ops::Range;

use super::row::{LaneEstimator, RowRenderer};
use super::silhouette::Silhouettes;
use super::{
    CHUNK_SAMPLES, PixelRun, PreparedRayRenderer, PreparedRenderer, Progress, Renderer,
    for_each_run,
};
use crate::error::Error;
use crate::film::Film;
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
    estimator: LaneEstimator<'_>,
    sampling: Sampling,
    film: &mut Film,
    range: &Range<u32>,
    progress: Progress<'_>,
) -> Result<bool, Error> {
    LaneRenderer {
        estimator,
        sampling,
        precision: Precision::Double,
    }
    .add(scene, film, range.clone(), progress)
}

/// Refuses scenes in which single precision would be visible: where the largest coordinate lies
/// outside [`SINGLE_EXTENTS`] or is more than [`SINGLE_MAX_EXTENT_RATIO`] times the size of a
/// detail (the radius of a sphere or the height of a zone, or the second largest extent of
/// connected triangles); and where surfaces [coincide](Scene::coincident_in_singles).
///
/// # Errors
/// [`Error::Option`] with the reason, and advice.
pub fn check_single_precision(scene: &Scene) -> Result<(), Error> {
    let extent = scene.largest_coordinate();
    let [low, high] = SINGLE_EXTENTS;
    if !(low..=high).contains(&extent) {
        return Err(Error::Option(format!(
            "the scene reaches to {extent:?}; in single precision it must reach from {low:?} to {high:?}"
        )));
    }
    let detail = scene.smallest_detail();
    if extent > detail * SINGLE_MAX_EXTENT_RATIO {
        return Err(Error::Option(format!(
            "the scene has something of size {detail:.1e}, too small for single precision where the scene reaches to \
             {extent:?}, more than {SINGLE_MAX_EXTENT_RATIO} times as far"
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
pub const SINGLE_MAX_EXTENT_RATIO: f64 = 4096.0;

/// Renderer as [`RayRenderer`](super::RayRenderer), several paths at a time.
#[derive(Clone, Copy, Debug)]
pub struct LaneRenderer<'e> {
    /// Estimator of the radiance along a ray. With replaced parts it renders as
    /// [`RayRenderer`](super::RayRenderer), in double precision only.
    pub estimator: LaneEstimator<'e>,
    /// Sampling settings.
    pub sampling: Sampling,
    /// Precision of the arithmetic.
    pub precision: Precision,
}

/// Precision of a lane's numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// Eight paths at a time, to the bytes of [`RayRenderer`](super::RayRenderer).
    #[default]
    Double,
    /// Sixteen paths at a time: the same paths by the same random numbers, rounded, in scenes that
    /// pass [`check_single_precision`].
    Single,
    /// Single precision in any scene, to measure the errors that [`check_single_precision`]
    /// prevents.
    UncheckedSingle,
}

impl Renderer for LaneRenderer<'_> {
    fn samples_per_replication(&self) -> u32 {
        self.sampling.samples_per_replication()
    }
    fn prepare<'a>(
        &'a self,
        scene: &'a Scene,
        resolution: [u32; 2],
    ) -> Result<Box<dyn PreparedRenderer + 'a>, Error> {
        if self.precision == Precision::Single {
            check_single_precision(scene)?;
        }
        if !self.estimator.parts().are_default() {
            if self.precision != Precision::Double {
                let message = "replaced parts are rendered in double precision alone";
                return Err(Error::Option(message.to_owned()));
            }
            let (estimator, sampling) = (self.estimator.along_rays(), self.sampling);
            let by_rays = PreparedRayRenderer::new(scene, estimator, sampling, resolution);
            return Ok(Box::new(by_rays));
        }
        Ok(match self.precision {
            Precision::Double => Box::new(self.prepared::<Lanes, LANES>(scene, resolution)),
            Precision::Single | Precision::UncheckedSingle => {
                Box::new(self.prepared::<Singles, SINGLES>(scene, resolution))
            }
        })
    }
}

impl LaneRenderer<'_> {
    fn prepared<'a, R: Wide<N>, const N: usize>(
        &'a self,
        scene: &'a Scene,
        resolution: [u32; 2],
    ) -> RowRenderer<'a, R, N> {
        let sees_in_mirrors = self.estimator.along_rays().sees_in_mirrors();
        RowRenderer {
            scene: LaneScene::new(scene),
            estimator: self.estimator,
            sampling: self.sampling,
            resolution,
            silhouettes: Silhouettes::new(scene, resolution, self.sampling, sees_in_mirrors),
        }
    }
}

impl<R: Wide<N>, const N: usize> PreparedRenderer for RowRenderer<'_, R, N> {
    fn add(
        &self,
        film: &mut Film,
        range: Range<u32>,
        progress: Progress<'_>,
    ) -> Result<bool, Error> {
        let add = |runs: &mut [PixelRun<'_>]| runs.iter_mut().try_for_each(|run| self.add_run(run));
        for_each_run(self.sampling, CHUNK_SAMPLES, film, &range, progress, add)
    }
}
