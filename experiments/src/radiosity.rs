//! Radiosity in the diffuse room: how the solution moves as patches are halved, and how far it is from
//! the path tracer.

use std::time::Instant;

use glam::DVec3;
use whitefurnace::equation;
use whitefurnace::error::Error;
use whitefurnace::estimator::radiosity::{Fineness, ReadOut};
use whitefurnace::estimator::{Path, Radiosity, Standard};
use whitefurnace::film::Film;
use whitefurnace::pixel::PixelSampling;
use whitefurnace::render::{Numbers, Sampling, render};
use whitefurnace::scene::{Scene, room};

use crate::lab::{Experiment, Lab};
use crate::plot::chart::{Chart, Corner, Mark, Series, charts};
use crate::progress::interrupted;

/// Refines the mesh.
pub const RADIOSITY: Experiment = Experiment {
    id: "radiosity",
    title: "radiosity in the diffuse room: error against the number of patches",
    version: 1,
    equations: &[&equation::RADIOSITY, &equation::FORM_FACTOR],
    run,
};

const SIZE: [u32; 2] = [64, 48];
/// Patches before they are halved.
const COARSE: u32 = 60;

/// One mesh.
struct Level {
    patches: f64,
    mean: DVec3,
    /// Root mean square of the pixels' differences from the path tracer, its noise taken off, relative to
    /// the mean: interpolated and gathered.
    distances: [f64; 2],
}

fn run(lab: &mut Lab) -> Result<(), Error> {
    let scene = room::diffuse()?;
    let spp = lab.count(lab.by_tier(1_000, 20_000)) as u32;
    let paths = image(lab, &scene, &Path::<Standard>::default(), spp.max(2))?;
    let reference = mean(&paths);
    let halvings = lab.by_tier(2, 3);
    let mut levels = Vec::new();
    for halvings in 0..=halvings {
        let fineness = Fineness {
            patches: COARSE,
            halvings,
        };
        let start = Instant::now();
        let solved = Radiosity::new(Standard, &scene, fineness, &|_| !interrupted())?;
        let seconds = start.elapsed().as_secs_f64();
        let patches = solved.irradiances().count() as f64 / 2.0;
        let (residual, sweeps) = (solved.residual(), solved.sweeps());
        let interpolated = image(lab, &scene, &solved, 1)?;
        let gathered = image(lab, &scene, &solved.read(ReadOut::Gathered), 1)?;
        let level = Level {
            patches,
            mean: mean(&interpolated),
            distances: [&interpolated, &gathered].map(|film| distance(film, &paths)),
        };
        let key = format!("halvings-{halvings}");
        lab.number(&format!("{key}.patches"), patches);
        lab.number(&format!("{key}.mean"), level.mean.y);
        lab.number(&format!("{key}.residual"), residual);
        lab.number(&format!("{key}.interpolated"), level.distances[0]);
        lab.number(&format!("{key}.gathered"), level.distances[1]);
        lab.note(
            &format!("{patches} patches"),
            format!(
                "image mean {:+.3} % from the path tracer, pixels {:.2} % (gathered {:.2} %), residual \
                 {residual:.1e} after {sweeps} sweeps, {seconds:.1} s",
                100.0 * (level.mean.y / reference.y - 1.0),
                100.0 * level.distances[0],
                100.0 * level.distances[1],
            ),
        );
        levels.push(level);
    }
    let noise = paths.relative_error() / f64::from(SIZE[0] * SIZE[1]).sqrt();
    richardson(lab, &levels, reference.y, noise);
    draw(lab, &levels, reference.y)
}

/// An image of the room with every ray through its pixel's centre, so that edges add no noise.
fn image<E: whitefurnace::estimator::Estimator>(
    lab: &Lab,
    scene: &Scene,
    estimator: &E,
    spp: u32,
) -> Result<Film, Error> {
    let mut film = Film::new(SIZE, None, 1)?;
    let sampling = Sampling {
        pixel: PixelSampling::Centre,
        numbers: Numbers::Independent,
        seed: lab.seed(),
    };
    let row_done = |_| !interrupted();
    if render(scene, estimator, sampling, &mut film, &(0..spp), &row_done)? {
        Ok(film)
    } else {
        Err(Error::Interrupted)
    }
}

fn mean(film: &Film) -> DVec3 {
    let pixels = film.pixels();
    pixels.iter().map(|p| p.mean()).sum::<DVec3>() / pixels.len() as f64
}

fn distance(film: &Film, paths: &Film) -> f64 {
    let pairs = film.pixels().iter().zip(paths.pixels());
    let squares: f64 = pairs
        .map(|(a, b)| (a.mean().y - b.mean().y).powi(2) - b.standard_error().y.powi(2))
        .sum();
    (squares.max(0.0) / film.pixels().len() as f64).sqrt() / mean(paths).y
}

/// Order and limit from the last three meshes (Richardson 1911): if the error is proportional to a power
/// of the patches' size, differences of means shrink by a constant factor.
fn richardson(lab: &mut Lab, levels: &[Level], reference: f64, noise: f64) {
    let [.., a, b, c] = levels else { return };
    let [a, b, c] = [a, b, c].map(|level| level.mean.y);
    let ratio = (a - b) / (b - c);
    let limit = c + (c - b) / (ratio - 1.0);
    lab.number("order", ratio.log2());
    lab.number("limit", limit);
    lab.number("mesh_error", c / limit - 1.0);
    lab.number("reference", reference);
    lab.note(
        "extrapolation",
        format!(
            "observed order {:.2}; the finest mesh is {:+.3} % from the limit {limit:.5}, and the limit \
             {:+.3} % from the path tracer's {reference:.5} ± {:.3} %",
            ratio.log2(),
            100.0 * (c / limit - 1.0),
            100.0 * (limit / reference - 1.0),
            100.0 * noise,
        ),
    );
    lab.number("difference", c / reference - 1.0);
    lab.claim(
        "the finest mesh agrees with the path tracer",
        format!(
            "image means {:+.3} % apart, at most 0.5 %",
            100.0 * (c / reference - 1.0)
        ),
        (c / reference - 1.0).abs() + 4.0 * noise < 0.005,
    );
}

fn draw(lab: &mut Lab, levels: &[Level], reference: f64) -> Result<(), Error> {
    let series = |label: &str, colour, value: &dyn Fn(&Level) -> f64| {
        let points = levels
            .iter()
            .map(|l| [l.patches, 100.0 * value(l)])
            .collect();
        Series::new(label, colour, Mark::Points, points)
    };
    let difference = move |level: &Level| (level.mean.y / reference - 1.0).abs();
    let chart = Chart {
        title: "Radiosity in the diffuse room against the path tracer".to_owned(),
        axes: ["patches".to_owned(), "deviation (%)".to_owned()],
        ranges: [[50.0, 10_000.0], [0.01, 20.0]],
        log: [true, true],
        series: vec![
            series("pixels, interpolated (rms)", 2, &|l| l.distances[0]),
            series("pixels, gathered (rms)", 1, &|l| l.distances[1]),
            series("image mean", 0, &difference),
        ],
        legend: Corner::UpperRight,
    };
    charts(&lab.figure("radiosity.svg"), [900, 500], &[chart])
}
