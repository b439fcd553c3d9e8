//! Four diffuse models in the white furnace, rendered: a model that conserves energy is
//! indistinguishable from the background.

use std::f64::consts::PI;

use whitefurnace::camera::Camera;

use crate::experiments::diffuse::{DISTANCE, MARGIN, SIGMA, closed_form};
use crate::experiments::prelude::*;

pub(super) const FURNACE: Experiment = Experiment {
    id: "furnace",
    title: "white spheres of four diffuse models in the white furnace: a model that keeps all light vanishes",
    headline: "in the white furnace EON is {eon.mean %.2f} % off white, Oren–Nayar {corrected.mean %.1f} %, as printed {printed.mean %.1f} %",
    version: 1,
    equations: &[
        &equation::LAMBERT,
        &equation::OREN_NAYAR,
        &equation::OREN_NAYAR_CONSTANTS,
        &equation::EON_ALBEDO,
        &equation::EON_MULTIPLE,
    ],
    run,
};

/// Bound of the colour scale, per cent.
const BOUND: f64 = 24.0;
/// Tolerance of mean albedos, since the view is from a finite distance and the closed form is for
/// parallel rays.
const PARALLEL: f64 = 1e-4;

/// Builds a white unit sphere under a sky of radiance 1, seen by almost parallel rays.
fn scene(model: DiffuseName) -> Result<Scene, Error> {
    let mut scene = SceneBuilder::new("white-sphere");
    scene.background(DVec3::ONE);
    let white = scene.surface(Surface::new(model.bsdf(DVec3::ONE, SIGMA)));
    scene.sphere(Sphere::new(DVec3::ZERO, 1.0), white);
    scene.build(Camera::new(
        DVec3::new(DISTANCE, 0.0, 0.0),
        DVec3::ZERO,
        DVec3::Z,
        MARGIN / DISTANCE,
    ))
}

/// Returns the mean albedo over the disc that the sphere covers: ∫ E(asin r) 2r dr.
fn mean_albedo(model: DiffuseName) -> f64 {
    const STEPS: u32 = 100_000;
    // Equal areas of the disc.
    let squares = (0..STEPS).map(|i| (f64::from(i) + 0.5) / f64::from(STEPS));
    squares
        .map(|square| closed_form(model, square.sqrt().asin()))
        .sum::<f64>()
        / f64::from(STEPS)
}

fn run(run: &mut Run) -> Result<(), Error> {
    let side = run.by_tier(96, 128);
    let spp = run.count(run.by_tier(128, 1024)).max(2) as u32;
    let critical = normal_upper(FAMILYWISE_LEVEL / 2.0 / DiffuseName::ALL.len() as f64);
    let mut panels = Vec::new();
    for model in DiffuseName::ALL {
        let (scene, path) = (scene(model)?, Path::default());
        let sampling = random_points(seed_for(run.seed(), model.title()));
        let film = render_samples(&scene, &path, sampling, [side; 2], spp)?;
        let [mean, half] = over_the_disc(&film).map(|percent| 100.0 * percent);
        let half = critical * half;
        let known = 100.0 * (mean_albedo(model) - 1.0);
        let inclinations = (0..900).map(|tenth| (f64::from(tenth) / 10.0).to_radians());
        let deviations = inclinations.map(|t| 100.0 * (closed_form(model, t) - 1.0));
        let (least, most) = (
            deviations.clone().fold(f64::MAX, f64::min),
            deviations.fold(f64::MIN, f64::max),
        );
        run.numbers(
            &name(model),
            [("mean", mean), ("mean.half", half), ("mean.closed", known)],
        );
        run.numbers(
            &name(model),
            [("least.closed", least), ("most.closed", most)],
        );
        let what = format!("mean deviation of {}", model.title());
        let value = format!(
            "{mean:+.3} ± {half:.3} %, closed form {known:+.3} %, from {least:+.2} to {most:+.2} % over \
             the inclinations"
        );
        run.claim(
            &what,
            value,
            (mean - known).abs() <= half + 100.0 * PARALLEL,
        );
        panels.push(Map {
            title: model.title().to_owned(),
            axes: ["across (radii)".into(), "up (radii)".into()],
            ranges: [[-MARGIN, MARGIN]; 2],
            size: [side, side],
            values: film
                .pixels()
                .iter()
                .map(|pixel| 100.0 * (pixel.mean().x - 1.0))
                .collect(),
            bound: BOUND,
            unit: "radiance − 1 (%)".into(),
        });
    }
    run.note(
        "furnace.svg",
        format!("{side}x{side}, {spp} spp, white spheres, σ = {SIGMA}, sky of radiance 1"),
    );
    let description =
        "Lambert's and EON's spheres vanish but for noise; both forms of Oren–Nayar are too dark.";
    maps(run, "furnace.svg", description, [980, 820], 2, &panels)
}

/// Returns the mean deviation from 1 over the sphere's disc, and its standard error. The mean over
/// the picture is its product with the disc's share of the area, whichever pixels the rim cuts.
fn over_the_disc(film: &Film) -> [f64; 2] {
    let pixels = film.pixels();
    let n = pixels.len() as f64;
    let mean = pixels.iter().map(|p| p.mean().x - 1.0).sum::<f64>() / n;
    let squares = pixels.iter().map(|p| p.standard_error().x.powi(2));
    let error = squares.sum::<f64>().sqrt() / n;
    let share = PI / (2.0 * MARGIN).powi(2);
    [mean / share, error / share]
}
