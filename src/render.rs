//! The loop over pixels, replications and samples.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Error;
use crate::estimator::Estimator;
use crate::film::{Features, Film, Pixel};
use crate::pixel::PixelSampling;
use crate::rng::{stream, uniform2};
use crate::scene::{Hit, Scene};
use crate::shape::Ray;

/// What, besides scene and estimator, decides every sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampling {
    /// Where in a pixel the rays go.
    pub pixel: PixelSampling,
    /// The master seed.
    pub seed: u64,
}

/// Adds the replications `range` to every pixel of the film.
///
/// Sample k of pixel (x, y) of the full frame draws from the stream (seed, pixel, k) and sums are
/// exact, so neither threads nor the order or division of the ranges change the result.
///
/// `row_done` is called after each row with its number of samples, from any thread; when it returns
/// false, the remaining rows are left out and `Ok(false)` is returned.
///
/// # Errors
/// [`Error::Radiance`] if the estimator returns what no film can hold.
pub fn render<E: Estimator>(
    scene: &Scene,
    estimator: &E,
    sampling: Sampling,
    film: &mut Film,
    range: &Range<u32>,
    row_done: &(dyn Fn(u64) -> bool + Sync),
) -> Result<bool, Error> {
    let frame = film.frame();
    let window = film.window();
    let samples = u64::from(range.end - range.start) * u64::from(film.samples_per_replication());
    let row_samples = samples * u64::from(window.size[0]);
    let stopped = AtomicBool::new(false);
    film.pixels_mut()
        .par_chunks_mut(window.size[0] as usize)
        .zip(window.corner[1]..window.corner[1] + window.size[1])
        .try_for_each(|(row, y)| {
            if stopped.load(Ordering::Relaxed) {
                return Ok(());
            }
            for (pixel, x) in row.iter_mut().zip(window.corner[0]..) {
                for replication in range.clone() {
                    let position = PixelPosition {
                        frame,
                        x,
                        y,
                        replication,
                    };
                    add_replication(scene, estimator, sampling, position, pixel)?;
                }
            }
            if !row_done(row_samples) {
                stopped.store(true, Ordering::Relaxed);
            }
            Ok(())
        })?;
    Ok(!stopped.into_inner())
}

/// Which replication of which pixel.
#[derive(Clone, Copy)]
struct PixelPosition {
    frame: [u32; 2],
    x: u32,
    y: u32,
    replication: u32,
}

#[inline]
fn add_replication<E: Estimator>(
    scene: &Scene,
    estimator: &E,
    sampling: Sampling,
    PixelPosition {
        frame,
        x,
        y,
        replication,
    }: PixelPosition,
    pixel: &mut Pixel,
) -> Result<(), Error> {
    let samples = sampling.pixel.samples_per_replication();
    let mut sum = DVec3::ZERO;
    for index in 0..samples {
        let mut rng = stream(
            sampling.seed,
            y * frame[0] + x,
            replication * samples + index,
        );
        let [dx, dy] = sampling.pixel.position(index, uniform2(&mut rng));
        let ray = scene
            .camera()
            .ray(frame, f64::from(x) + dx, f64::from(y) + dy);
        let hit = scene.intersect(&ray);
        if let Some(hit) = &hit {
            pixel.push_features(&features(scene, hit, &ray));
        }
        sum += estimator.radiance(scene, &ray, hit, &mut rng);
    }
    pixel
        .push(sum / f64::from(samples))
        .map_err(|error| match error {
            Error::Radiance { value, .. } => Error::Radiance {
                value,
                place: format!(" at pixel ({x}, {y}), replication {replication}"),
            },
            other => other,
        })
}

#[inline]
fn features(scene: &Scene, hit: &Hit, ray: &Ray) -> Features {
    Features {
        albedo: scene.surface(hit).bsdf.albedo(),
        normal: hit.normal * -hit.normal.dot(ray.direction).signum(),
        depth: hit.t,
    }
}
