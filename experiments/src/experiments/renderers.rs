//! Judges renderers with one fault each, and one without, by their images with `compare`.

use whitefurnace::film::Pixel;
use whitefurnace::harness::images::Rules;
use whitefurnace::scene::file::Description;

use super::answers::faulty_parts;
use crate::compare::word;
use crate::experiments::prelude::*;

pub(super) const RENDERERS: Experiment = Experiment {
    id: "renderers",
    title: "renderers with a fault each on trial by their images",
    headline: "renderers on trial: the right one agrees, albedos 1 % too low are seen as {albedo.difference %.1%}",
    version: 1,
    equations: &[&equation::RENDERING],
    run,
};

/// Width and height of the images, and of a tile.
const SIDE: u32 = 64;
const TILE: usize = 8;
/// Images of each renderer.
const IMAGES: u32 = 8;

/// A renderer: returns the image of a seed.
type Renderer<'a> = Box<dyn Fn(u64) -> Result<Planes, Error> + 'a>;

/// Builds the Cornell box with the albedos of its walls and boxes scaled by `share`.
fn cornell(share: f64) -> Result<Scene, Error> {
    let mut scene = Description::parse(
        "cornell",
        include_str!("../../../src/scene/files/cornell.toml"),
    )?;
    for (_, surface) in &mut scene.materials {
        if let Bsdf::Lambert { albedo } = &mut surface.bsdf {
            *albedo *= share;
        }
    }
    scene.build()
}

fn run(run: &mut Run) -> Result<(), Error> {
    let samples = run.count(run.by_tier(64, 1024)) as u32;
    let (scene, darker) = (cornell(1.0)?, cornell(0.99)?);
    let by = |scene: &Scene, path: &Path, seed| -> Result<Planes, Error> {
        let film = render_samples(scene, path, random_points(seed), [SIDE; 2], samples)?;
        Ok(planes(film.pixels(), Pixel::mean))
    };
    let mis = Path::new(Strategy::Mis);
    let unweighted = faulty_parts("no-roulette-weight")?;
    let right = |seed| by(&scene, &mis, seed);
    let changed = |change: fn(&[f64], usize) -> f64| -> Renderer<'_> {
        Box::new(move |seed| {
            Ok(right(seed)?.map(|plane| (0..plane.len()).map(|i| change(&plane, i)).collect()))
        })
    };
    let renderers: [(&str, &str, Renderer<'_>); 6] = [
        (
            "right",
            "light by shadow rays alone",
            Box::new(|seed| by(&scene, &Path::new(Strategy::Light), seed)),
        ),
        (
            "albedo",
            "albedos 1 % less",
            Box::new(|seed| by(&darker, &mis, seed)),
        ),
        (
            "roulette",
            "survivors of roulette not weighted",
            Box::new(|seed| {
                let path = mis.with_parts(Parts::replaced(&unweighted.parts));
                by(&scene, &path, seed)
            }),
        ),
        (
            "shift",
            "half a pixel to the right",
            changed(|plane, i| {
                let left = if (i as u32).is_multiple_of(SIDE) {
                    i
                } else {
                    i - 1
                };
                0.5 * (plane[i] + plane[left])
            }),
        ),
        (
            "gamma",
            "gamma applied",
            changed(|plane, i| plane[i].powf(1.0 / 2.2)),
        ),
        (
            "clamp",
            "pixels cut at 1",
            changed(|plane, i| plane[i].min(1.0)),
        ),
    ];
    let seeds = |of: &str| -> Vec<u64> {
        (0..IMAGES)
            .map(|image| seed_for(run.seed(), &format!("renderers {of} {image}")))
            .collect()
    };
    let reference = seeds("reference")
        .into_iter()
        .map(right)
        .collect::<Result<Vec<_>, _>>()?;
    let rules = Rules {
        tile: TILE,
        ..Rules::default()
    };
    let mut panels = Vec::new();
    let mut found = Vec::new();
    for (key, what, renderer) in &renderers {
        let images = seeds(key)
            .into_iter()
            .map(renderer)
            .collect::<Result<Vec<_>, _>>()?;
        let comparison = compare_planes(SIDE, [&images, &reference], &rules);
        found.push((*key, *what, comparison));
    }
    for (key, what, comparison) in &found {
        let word = word(comparison.verdict);
        let [means, _, tiles, _] = &comparison.kinds;
        let mean = means.tests[1];
        let [low, high] = mean.interval(means.level);
        run.note(key, format!("{what}: {word}"));
        run.number(
            &format!("{key}.differs"),
            f64::from(comparison.verdict == Verdict::Fails),
        );
        run.numbers(
            key,
            [
                ("difference", mean.difference()),
                ("low", low),
                ("high", high),
            ],
        );
        for kind in &comparison.kinds {
            run.number(
                &format!("{key}.{}", kind.name.replace(' ', "-")),
                kind.rejected().count() as f64,
            );
        }
        let green = tiles.tests.iter().filter(|place| place.channel == 1);
        panels.push(Map {
            title: format!("{what}: {word}"),
            axes: ["x (pixels)".into(), "y (pixels, down)".into()],
            ranges: [[0.0, f64::from(SIDE)], [f64::from(SIDE), 0.0]],
            size: [SIDE / TILE as u32; 2],
            values: green
                .map(|place| {
                    if place.judged {
                        100.0 * place.difference()
                    } else {
                        f64::NAN
                    }
                })
                .collect(),
            bound: 5.0,
            unit: "difference (%)".into(),
        });
    }
    let agrees = found
        .iter()
        .all(|(key, _, comparison)| (*key == "right") == (comparison.verdict == Verdict::Holds));
    run.note(
        "images",
        format!("{IMAGES} of each, {SIDE}x{SIDE}, {samples} spp"),
    );
    run.number("samples", f64::from(samples));
    if run.by_tier(false, true) {
        run.claim(
            "the right renderer agrees, each fault is seen",
            format!("{} renderers", found.len()),
            agrees,
        );
    }
    let description = "Noise for the right renderer; each fault has a pattern of its own.";
    maps(run, "tiles.svg", description, [1080, 700], 3, &panels)
}
