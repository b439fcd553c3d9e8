//! Films of scenes that no program names, and films side by side in one PNG.

use std::path::Path;

use whitefurnace::error::Error;
use whitefurnace::film::{Film, Window};
use whitefurnace::geometry::shape::Ray;
use whitefurnace::image::{Display, write_rgb};
use whitefurnace::integrator::{Estimator, Path as PathTracer};
use whitefurnace::math::moments::Moments;
use whitefurnace::render::{ByLanes, LaneEstimator, Precision, Renderer as _, render};
use whitefurnace::sampling::Sampling;
use whitefurnace::sampling::pixel::PixelSampling;
use whitefurnace::sampling::rng::stream;
use whitefurnace::sampling::sampler::Numbers;
use whitefurnace::scene::Scene;

use crate::run::progress::interrupted;

/// Renders the first `samples` samples of every pixel of a frame, or of a window of it, onto a film
/// of one sample per replication, with independent numbers.
pub fn render_samples<E: Estimator>(
    scene: &Scene,
    estimator: &E,
    (pixel, seed): (PixelSampling, u64),
    (size, window): ([u32; 2], Option<Window>),
    samples: u32,
) -> Result<Film, Error> {
    let sampling = Sampling {
        pixel,
        numbers: Numbers::Independent,
        seed,
        outlines: false,
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

/// The same film of a path tracer with its standard parts, several paths at a time.
///
/// # Errors
/// A scene that lanes do not serve: with rough glass, or shadow rays to an environment map.
pub fn render_paths(
    scene: &Scene,
    path: PathTracer,
    (pixel, seed): (PixelSampling, u64),
    (size, window): ([u32; 2], Option<Window>),
    samples: u32,
) -> Result<Film, Error> {
    let sampling = Sampling {
        pixel,
        numbers: Numbers::Independent,
        seed,
        outlines: false,
    };
    let lanes = ByLanes {
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

/// Samples of the first channel along one ray, each with random numbers of its own: sample i takes
/// those of the stream (seed, place, i).
pub fn radiance_along(
    scene: &Scene,
    path: &PathTracer,
    ray: &Ray,
    (seed, place): (u64, u32),
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

/// White pixels between two pictures.
const GAP: u32 = 6;

/// Writes films of the same size side by side, each pixel as `magnification`² equal ones.
pub fn write_row(
    path: &Path,
    films: &[Film],
    display: Display,
    magnification: u32,
) -> Result<(), Error> {
    let [width, height] = films
        .first()
        .map_or([1, 1], Film::size)
        .map(|n| n * magnification);
    let size = [films.len() as u32 * (width + GAP) - GAP, height];
    let mut rgb = vec![u8::MAX; 3 * size[0] as usize * size[1] as usize];
    for (k, film) in (0..).zip(films) {
        for y in 0..height {
            for x in 0..width {
                let mean = film.pixel(x / magnification, y / magnification).mean();
                let at = 3 * (y * size[0] + k * (width + GAP) + x) as usize;
                rgb[at..at + 3].copy_from_slice(&mean.to_array().map(|l| display.encode(l)));
            }
        }
    }
    write_rgb(path, size, &rgb)
}
