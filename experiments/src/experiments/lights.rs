//! Variance of the ways of sampling lights: solid-angle sampling by distance for each shape, and in
//! whole scenes; importance-based light selection along a line under several lights.

use std::f64::consts::FRAC_1_PI;
use std::sync::Arc;

use trials::scenes::{
    corners, floor, lambert, light, polygon_irradiance, scene, sphere_irradiance, square,
};
use whitefurnace::light::emitter::LightSampling;
use whitefurnace::light::light_sampler::MAX_EXACT_LIGHTS;
use whitefurnace::scene::SurfaceId;

use crate::experiments::prelude::*;
use crate::render::LightSamplingName;

pub(super) const LIGHTS: Experiment = Experiment {
    id: "lights",
    title: "variance of direct light: points on lights by area and by solid angle, lights by contribution",
    headline: "a lamp close by: variance {rectangle.light-area.0.05 %.0f} by points on its area, {rectangle.light-solid-angle.0.05 %.2f} by solid angle",
    version: 2,
    equations: &[
        &equation::LIGHT_RECTANGLE,
        &equation::LIGHT_TRIANGLE,
        &equation::LIGHT_SPHERE,
        &equation::LIGHT_PICK,
        &equation::SOLID_ANGLE,
        &equation::MIS,
        &equation::MIS_POWER,
    ],
    run,
};

/// A light of size about 1 above the origin, its lowest point at this height.
struct Shape {
    name: &'static str,
    add: fn(&mut SceneBuilder, f64, SurfaceId),
    /// Irradiance at the origin per emitted radiance.
    irradiance: fn(f64) -> f64,
}

const SHAPES: [Shape; 3] = [
    Shape {
        name: "rectangle",
        add: |s, height, surface| {
            let [a, b, _, d] = corners(height * DVec3::Z, 1.0);
            s.rectangle(a, [d - a, b - a], surface);
        },
        irradiance: |height| polygon_irradiance(&corners(height * DVec3::Z, 1.0)),
    },
    Shape {
        name: "triangle",
        add: |s, height, surface| s.mesh(&triangle(height), &[[0, 2, 1]], surface),
        irradiance: |height| polygon_irradiance(&triangle(height)),
    },
    Shape {
        name: "sphere",
        add: |s, height, surface| s.sphere(Sphere::new((height + 1.0) * DVec3::Z, 1.0), surface),
        irradiance: |height| sphere_irradiance(1.0, height + 1.0, 1.0),
    },
];

fn triangle(height: f64) -> [DVec3; 3] {
    [[-1.5, -1.0], [1.5, -1.0], [0.0, 2.0]].map(|[x, y]| DVec3::new(x, y, height))
}

const HEIGHTS: [f64; 11] = [0.05, 0.1, 0.2, 0.4, 0.7, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0];

/// Returns the compared paths with their labels: shadow rays alone, and multiple importance
/// sampling, each with both ways of sampling lights.
fn methods(
    separator: &str,
    ways: [(&str, LightSampling); 2],
    heuristic: Heuristic,
) -> Vec<(String, Path<'static>)> {
    let strategies = [("light", Strategy::Light), ("mis", Strategy::Mis)];
    let each = strategies
        .into_iter()
        .flat_map(|strategy| ways.map(|way| (strategy, way)));
    each.map(|((name, strategy), (way, lights))| {
        let path = Path {
            lights,
            heuristic,
            ..Path::new(strategy)
        };
        (format!("{name}{separator}{way}"), path)
    })
    .collect()
}

fn run(run: &mut Run) -> Result<(), Error> {
    by_distance(run)?;
    along_a_line(run)?;
    scenes(run)
}

fn by_distance(run: &mut Run) -> Result<(), Error> {
    let samples = run.count(run.by_tier(30_000, 2_000_000)) as u32;
    let mut panels = Vec::new();
    for shape in &SHAPES {
        let scenes = HEIGHTS.map(|height| (height, over_floor(shape, height)));
        let mut series = Vec::new();
        let ways = [
            ("area", LightSampling::Area),
            ("solid angle", LightSampling::SolidAngle),
        ];
        for (colour, (label, path)) in methods(" ", ways, Heuristic::default()).iter().enumerate() {
            let seed = seed_for(run.seed(), &format!("{} {label}", shape.name));
            let variances = parallel_map(&scenes, |(height, scene)| {
                let reference = FRAC_1_PI * (shape.irradiance)(*height);
                relative_variance(scene, 0.0, path, seed, samples, reference)
            })?;
            for (height, variance) in HEIGHTS.into_iter().zip(&variances) {
                run.number(
                    &format!("{}.{}.{height}", shape.name, label.replace(' ', "-")),
                    *variance,
                );
            }
            let points = HEIGHTS.into_iter().zip(variances).map(|(x, y)| [x, y]);
            series.push(Series::new(label, colour, Mark::Line, points));
        }
        let [area, angle] = [0, 1].map(|way: usize| series[way].points[0][1]);
        let value = format!(
            "variance by shadow rays alone: area {area:.3e}, solid angle {angle:.3e}, relative to the squared mean"
        );
        run.note(&format!("{} at height {}", shape.name, HEIGHTS[0]), value);
        let title = format!(
            "Light of a {}: variance of one sample, relative to the squared mean",
            shape.name
        );
        let height = "height over the floor (half of its side, or its radius, is 1)";
        let (axes, ranges) = ([height, "relative variance"], [[0.04, 40.0], [1e-8, 1e3]]);
        panels.push(Chart::new(title, axes, ranges, series).log([true, true]));
    }
    let description = "Sampling by area: the variance rises without bound as the light comes near. By solid angle it \
               stays small, and multiple importance sampling tames both.";
    charts(run, "lights.svg", description, 1260, &panels)
}

fn over_floor(shape: &Shape, height: f64) -> Arc<Scene> {
    scene(shape.name, |s| {
        floor(s, lambert(1.0));
        let surface = s.surface(light(1.0));
        (shape.add)(s, height, surface);
    })
}

/// Positions of three lamps over a floor; the last one shines upwards.
const LAMPS: [DVec3; 3] = [
    DVec3::new(-4.0, 0.0, 1.0),
    DVec3::new(4.0, 0.0, 1.0),
    DVec3::new(0.0, 0.0, 1.0),
];
const HALF: f64 = 0.5;

/// Records the variance of direct light on a floor, along a line under a row of lamps that extends
/// beyond both ends.
fn along_a_line(run: &mut Run) -> Result<(), Error> {
    let samples = run.count(run.by_tier(30_000, 1_000_000)) as u32;
    let room = scene("lamps", |s| {
        floor(s, lambert(1.0));
        for (lamp, up) in LAMPS.into_iter().zip([false, false, true]) {
            square(s, lamp, HALF, up, light(1.0));
        }
    });
    let places: Vec<f64> = (-12..=12).map(|i| 0.5 * f64::from(i)).collect();
    let mut series = Vec::new();
    let ways = [
        ("uniform", LightSampling::SphereAngle),
        ("by importance", LightSampling::Importance),
    ];
    for (colour, (label, path)) in methods(", ", ways, Heuristic::Power).iter().enumerate() {
        let seed = seed_for(run.seed(), &format!("lamps {label}"));
        let variances = parallel_map(&places, |&x| {
            let seen = |lamp: DVec3| polygon_irradiance(&corners(lamp - x * DVec3::X, HALF));
            let reference = FRAC_1_PI * (seen(LAMPS[0]) + seen(LAMPS[1]));
            relative_variance(&room, x, path, seed, samples, reference)
        })?;
        for (x, variance) in places.iter().zip(&variances) {
            run.number(
                &format!("lamps.{}.{x}", label.replace(", ", "-").replace(' ', "-")),
                *variance,
            );
        }
        series.push(Series::new(
            label,
            colour,
            Mark::Line,
            places.iter().zip(variances).map(|(&x, y)| [x, y]),
        ));
    }
    let [even, shares] = [0, 1].map(|way: usize| series[way].points[4][1]);
    let value = format!(
        "each as often {even:.3e}, by contribution {shares:.3e}, relative to the squared mean"
    );
    run.number("most", MAX_EXACT_LIGHTS as f64);
    run.note(
        "variance by shadow rays alone under one of three lamps",
        value,
    );
    let title = "Two lamps over a floor, and one that faces away: variance of one sample, relative to the squared mean";
    let axes = [
        "place on the floor (lamps at -4 and 4, height 1)",
        "relative variance",
    ];
    let chart = Chart::new(title, axes, [[-6.5, 6.5], [0.03, 10.0]], series).log([false, true]);
    let description = "Each as often: two shadow rays of three go to a lamp that is far or faces away. By contribution: few do.";
    charts(run, "picks.svg", description, 420, &[chart])
}

/// Returns the variance of one sample of the radiance of the floor at (x, 0, 0), divided by the
/// square of its closed form.
fn relative_variance(
    scene: &Scene,
    x: f64,
    path: &Path,
    seed: u64,
    samples: u32,
    expected: f64,
) -> f64 {
    let down = DVec3::new(0.1, 0.05, -1.0).normalize();
    let ray = Ray::new(x * DVec3::X - 0.02 * down, down);
    radiance_along(scene, path, &ray, seed, 0, samples).variance() / (expected * expected)
}

/// Compares whole images by multiple importance sampling at equal samples.
fn scenes(run: &mut Run) -> Result<(), Error> {
    for scene in [SceneName::Report, SceneName::Cornell] {
        let ways = [LightSamplingName::Area, LightSamplingName::SolidAngle];
        let mut variances = Vec::new();
        for light_sampler in ways {
            let job = run.with_run_options(Job {
                scene: scene.into(),
                light_sampler,
                size: [128, 96],
                spp: run.by_tier(32, 1024),
                ..Job::report(ConventionName::Physical)
            });
            let label = format!("{} {}", name(scene), name(light_sampler));
            let film = run.render(&job, &label)?;
            let sum: f64 = film
                .pixels()
                .iter()
                .map(|p| p.standard_error().y.powi(2))
                .sum();
            let variance = sum * f64::from(job.spp) / film.pixels().len() as f64;
            run.number(&label.replace(' ', "."), variance);
            variances.push(variance);
        }
        let [area, angle] = [variances[0], variances[1]];
        let value = format!(
            "area {area:.4e}, solid angle {angle:.4e}: ratio {:.3}",
            angle / area
        );
        run.note(
            &format!("{}, mean variance of a pixel's sample", name(scene)),
            value,
        );
    }
    Ok(())
}
