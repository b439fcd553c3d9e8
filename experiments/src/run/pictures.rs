//! Films of scenes without a name on the command line, and films side by side in one PNG.

use std::path::Path;

use glam::DVec3;
use whitefurnace::error::Error;
use whitefurnace::film::{Film, Pixel};
use whitefurnace::geometry::shape::Ray;
use whitefurnace::image::{Display, write_rgb};
use whitefurnace::integrator::{Estimator, Path as PathTracer};
use whitefurnace::math::moments::Moments;
use whitefurnace::render::{LaneEstimator, LaneRenderer, Precision, Renderer, render};
use whitefurnace::sampling::Sampling;
use whitefurnace::sampling::pixel::PixelSampling;
use whitefurnace::sampling::rng::stream;
use whitefurnace::sampling::sampler::SamplerKind;
use whitefurnace::scene::Scene;

use crate::render::Rendered;
use crate::run::progress::interrupted;

/// Returns sampling by independent random numbers and rays through random points of each pixel.
pub fn random_points(seed: u64) -> Sampling {
    Sampling {
        pixel: PixelSampling::Random,
        sampler: SamplerKind::Independent,
        seed,
        silhouettes: false,
    }
}

/// Returns sampling by independent random numbers and rays through the centre of each pixel, so that
/// edges add no noise.
pub fn pixel_centres(seed: u64) -> Sampling {
    Sampling {
        pixel: PixelSampling::Centre,
        ..random_points(seed)
    }
}

/// Renders the first `samples` samples of every pixel of a frame onto a film of one sample per
/// replication.
pub fn render_samples(
    scene: &Scene,
    estimator: &dyn Estimator,
    sampling: Sampling,
    size: [u32; 2],
    samples: u32,
) -> Result<Film, Error> {
    let (mut film, on) = (Film::new(size, None, 1)?, |_| !interrupted());
    let complete = render(scene, estimator, sampling, &mut film, &(0..samples), &on)?;
    Rendered { film, complete }.into_complete()
}

/// Renders the film of [`render_samples`] for a path tracer, by [`LaneRenderer`].
///
/// # Errors
/// Those of [`render_samples`].
pub fn render_paths(
    scene: &Scene,
    path: PathTracer<'_>,
    sampling: Sampling,
    size: [u32; 2],
    samples: u32,
) -> Result<Film, Error> {
    let lanes = LaneRenderer {
        estimator: LaneEstimator::Path(path),
        sampling,
        precision: Precision::Double,
    };
    render_film(&lanes, scene, Film::new(size, None, 1)?, samples)
}

/// Adds the first `samples` replications to an empty film.
pub fn render_film(
    renderer: &dyn Renderer,
    scene: &Scene,
    mut film: Film,
    samples: u32,
) -> Result<Film, Error> {
    let complete = renderer.add(scene, &mut film, 0..samples, &|_| !interrupted())?;
    Rendered { film, complete }.into_complete()
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
