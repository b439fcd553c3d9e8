//! Films of scenes without a name on the command line, and films side by side in one PNG.

use std::path::Path;

use glam::DVec3;
use whitefurnace::error::Error;
use whitefurnace::film::{Film, Pixel, Window};
use whitefurnace::geometry::shape::Ray;
use whitefurnace::image::{Display, write_rgb};
use whitefurnace::integrator::{Estimator, Path as PathTracer};
use whitefurnace::math::moments::Moments;
use whitefurnace::render::{LaneEstimator, LaneRenderer, Precision, Renderer as _, render};
use whitefurnace::sampling::Sampling;
use whitefurnace::sampling::pixel::PixelSampling;
use whitefurnace::sampling::rng::stream;
use whitefurnace::sampling::sampler::SamplerKind;
use whitefurnace::scene::Scene;

use crate::run::progress::interrupted;

/// Renders the first `samples` samples of every pixel of a frame, or of a window of it, onto a film
/// of one sample per replication, with independent random numbers.
pub fn render_samples(
    scene: &Scene,
    estimator: &dyn Estimator,
    pixel: PixelSampling,
    seed: u64,
    size: [u32; 2],
    window: Option<Window>,
    samples: u32,
) -> Result<Film, Error> {
    let sampling = Sampling {
        pixel,
        sampler: SamplerKind::Independent,
        seed,
        silhouettes: false,
    };
    let mut film = Film::new(size, window, 1)?;
    let on = |_| !interrupted();
    let complete = render(scene, estimator, sampling, &mut film, &(0..samples), &on)?;
    if complete {
        Ok(film)
    } else {
        Err(Error::Interrupted)
    }
}

/// Renders the film of [`render_samples`] for a path tracer, by [`LaneRenderer`].
///
/// # Errors
/// Those of [`render_samples`].
pub fn render_paths(
    scene: &Scene,
    path: PathTracer<'_>,
    pixel: PixelSampling,
    seed: u64,
    size: [u32; 2],
    window: Option<Window>,
    samples: u32,
) -> Result<Film, Error> {
    let sampling = Sampling {
        pixel,
        sampler: SamplerKind::Independent,
        seed,
        silhouettes: false,
    };
    let lanes = LaneRenderer {
        estimator: LaneEstimator::Path(path),
        sampling,
        precision: Precision::Double,
    };
    let mut film = Film::new(size, window, 1)?;
    let complete = lanes.add(scene, &mut film, 0..samples, &|_| !interrupted())?;
    if complete {
        Ok(film)
    } else {
        Err(Error::Interrupted)
    }
}

/// Returns samples of the first channel along one ray, each with its own random numbers: sample i
/// takes those of the stream (seed, place, i).
pub fn radiance_along(
    scene: &Scene,
    path: &PathTracer,
    ray: &Ray,
    seed: u64,
    place: u32,
    samples: u32,
) -> Moments {
    let hit = scene.intersect(ray);
    (0..samples)
        .map(|i| {
            path.radiance(scene, ray, hit, &mut stream(seed, place, i))
                .x
        })
        .collect()
}

/// Width of the white gap between two pictures, pixels.
const GAP: u32 = 6;

/// Writes films of the same size side by side, each pixel as `magnification`² equal ones.
pub fn write_row(
    path: &Path,
    films: &[Film],
    display: Display,
    magnification: u32,
) -> Result<(), Error> {
    let size = films.first().map_or([1, 1], Film::size);
    let means = |film: &Film| film.pixels().iter().map(Pixel::mean).collect();
    let images: Vec<Vec<DVec3>> = films.iter().map(means).collect();
    write_pixels(path, &images, size, display, magnification)
}

/// Writes images of this size, row by row from the top, as [`write_row`] does.
pub fn write_pixels(
    path: &Path,
    images: &[Vec<DVec3>],
    size: [u32; 2],
    display: Display,
    magnification: u32,
) -> Result<(), Error> {
    let [width, height] = size.map(|n| n * magnification);
    let whole = [images.len() as u32 * (width + GAP) - GAP, height];
    let mut rgb = vec![u8::MAX; 3 * whole[0] as usize * whole[1] as usize];
    for (k, image) in (0..).zip(images) {
        for y in 0..height {
            for x in 0..width {
                let pixel = y / magnification * size[0] + x / magnification;
                let at = 3 * (y * whole[0] + k * (width + GAP) + x) as usize;
                let shown = image[pixel as usize].to_array();
                rgb[at..at + 3].copy_from_slice(&shown.map(|l| display.encode(l)));
            }
        }
    }
    write_rgb(path, whole, &rgb)
}
