//! Particles and the camera: the light tracer and bidirectional path tracing on scenes with closed forms,
//! strategy by strategy, and against the path tracer.

mod faults;
mod scenes;

use std::sync::Arc;

use super::passes::ImageKind::{Bdpt, LightTracer};
use super::passes::{ImageKind, Passes, Region, altered, image, same_as_path, whole};
use super::probes::{IMAGE, SINGLE, words};
use super::subject::{Property, RIGHT, STANDARD, Setup, Subject, Table, on};
use crate::equation::{Equation, GEOMETRY, IMPORTANCE, MIS, PATH_DENSITY, REFRACTION, RENDERING};
use crate::estimator::{Density, Parts};
use crate::harness::outcome::Outcome;
use crate::harness::trial::Context;
use crate::rng::uniform;
use crate::scene::Scene;
use crate::scene::simple::{CAP_SHARE, Cap, environment, furnace_box};
use crate::zoo::{AnyFamily, Bench, Family, data};

/// The family.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    let mut benches = direct();
    benches.extend(furnaces());
    benches.extend(specular());
    benches.extend(alone());
    benches.extend(equivalence());
    benches.push(weights());
    vec![Box::new(Family {
        whole_estimator: true,
        benches,
        faults: faults::faults(),
        equivalents: faults::equivalents(),
        share: 1.0 / 4.0,
        ..Family::new("bidirectional", STANDARD)
    })]
}

/// A square image.
const SQUARE: [u32; 2] = [14, 14];

/// A trial of the whole image: name, property, equation; scene and mean; frame, passes and δ.
fn mean(
    (name, kind, equation): (&'static str, ImageKind, &'static Equation),
    what: &str,
    (scene, reference): (Arc<Scene>, f64),
    (frame, count, delta): ([u32; 2], u64, f64),
) -> Bench<Subject> {
    let passes = Passes {
        scene,
        kind,
        frame,
        count,
    };
    let words = words(
        name,
        format!("{what}: the image has mean {reference:.6}"),
        equation,
    );
    image(words, &passes, reference, &[whole(delta)])
}

/// Light that is reflected once, and light that is seen.
fn direct() -> Vec<Bench<Subject>> {
    let rectangle = |name, kind, count| {
        let what = "a floor under a square light";
        mean(
            (name, kind, &GEOMETRY),
            what,
            scenes::rectangle(false),
            (SQUARE, count, IMAGE),
        )
    };
    let sphere = |name, kind, count| {
        let what = "a floor under a spherical light";
        mean(
            (name, kind, &GEOMETRY),
            what,
            scenes::sphere(),
            (SQUARE, count, IMAGE),
        )
    };
    vec![
        rectangle("bidirectional/light-tracer/rectangle", LightTracer, 8_000),
        rectangle("bidirectional/bdpt/rectangle", Bdpt, 8_000),
        sphere("bidirectional/light-tracer/sphere", LightTracer, 20_000),
        sphere("bidirectional/bdpt/sphere", Bdpt, 16_000),
        mean(
            ("bidirectional/bdpt/behind", Bdpt, &GEOMETRY),
            "a floor under a light that faces up",
            scenes::rectangle(true),
            (SQUARE, 6_000, IMAGE),
        ),
        frame("bidirectional/light-tracer/frame", LightTracer, 17_000),
        frame("bidirectional/bdpt/frame", Bdpt, 8_000),
    ]
}

/// A uniform emitter fills the image: every pixel shows its radiance, the outermost as well.
fn frame(name: &'static str, kind: ImageKind, count: u64) -> Bench<Subject> {
    let (scene, reference) = scenes::emitting_plane();
    let passes = Passes {
        scene,
        kind,
        frame: [24, 8],
        count,
    };
    let outer = Region {
        name: "outer columns",
        holds: |[x, _], [width, _]| x < 2 || x + 2 >= width,
        delta: 0.02,
    };
    let property = format!("an emitter that fills a wide image shows {reference} in every pixel");
    let words = words(name, property, &IMPORTANCE);
    image(words, &passes, reference, &[whole(SINGLE), outer])
}

/// Rooms that emit and reflect.
fn furnaces() -> Vec<Bench<Subject>> {
    let rho = 0.75;
    let furnace = |name, kind, count| {
        let scene = Arc::new(furnace_box(rho).ok()?);
        let what = "a closed furnace box of albedo 0.75";
        let size = ([16, 12], count, IMAGE);
        Some(mean(
            (name, kind, &RENDERING),
            what,
            (scene, 1.0 / (1.0 - rho)),
            size,
        ))
    };
    let cavity = |name, kind, cap, count| {
        let (what, reference) = match cap {
            Cap::Reflecting => (
                "a cavity of albedo 0.75 with a reflecting cap that emits",
                rho * CAP_SHARE / (1.0 - rho),
            ),
            Cap::Black => (
                "a cavity of albedo 0.75 with a black cap that emits",
                rho * CAP_SHARE / (1.0 - rho * (1.0 - CAP_SHARE)),
            ),
        };
        let scene = scenes::cavity(rho, cap).ok()?;
        Some(mean(
            (name, kind, &RENDERING),
            what,
            (scene, reference),
            (SQUARE, count, IMAGE),
        ))
    };
    let sky = |name, count| {
        let scene = Arc::new(environment().ok()?);
        let what = "white surfaces, mirror and glass under a white sky";
        let size = ([24, 8], count, SINGLE);
        Some(mean((name, Bdpt, &RENDERING), what, (scene, 1.0), size))
    };
    [
        furnace(
            "bidirectional/light-tracer/furnace-box",
            LightTracer,
            10_000,
        ),
        furnace("bidirectional/bdpt/furnace-box", Bdpt, 3_000),
        cavity(
            "bidirectional/light-tracer/cavity-reflecting",
            LightTracer,
            Cap::Reflecting,
            28_000,
        ),
        cavity("bidirectional/bdpt/cavity-black", Bdpt, Cap::Black, 2_500),
        sky("bidirectional/bdpt/environment", 14_000),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Mirror and glass between light and surface.
fn specular() -> Vec<Bench<Subject>> {
    let mirror = |name, kind, count| {
        let what = "a floor that is lit by way of a mirror";
        mean(
            (name, kind, &PATH_DENSITY),
            what,
            scenes::mirror_caustic(),
            ([22, 9], count, IMAGE),
        )
    };
    let (scene, squared_index, share) = scenes::in_glass();
    let glass = |name, kind, what, reference, count| {
        let scene = Arc::clone(&scene);
        mean(
            (name, kind, &REFRACTION),
            what,
            (scene, reference),
            (SQUARE, count, IMAGE),
        )
    };
    vec![
        mirror(
            "bidirectional/light-tracer/mirror-caustic",
            LightTracer,
            60_000,
        ),
        mirror("bidirectional/bdpt/mirror-caustic", Bdpt, 60_000),
        glass(
            "bidirectional/light-tracer/in-glass",
            LightTracer,
            "a ball in glass, all in equilibrium, before what is dark to particles",
            share * squared_index,
            70_000,
        ),
        glass(
            "bidirectional/bdpt/in-glass",
            Bdpt,
            "a ball in glass, all in equilibrium",
            squared_index,
            3_000,
        ),
    ]
}

/// The subject whose strategies have all the weight or none.
fn weighted(subject: Subject, strategy_weight: fn(&[Density], usize) -> f64) -> Subject {
    Setup {
        parts: Some(Table {
            strategy_weight,
            ..subject.parts.unwrap_or(RIGHT)
        }),
        ..subject
    }
}

/// All the weight for paths of `length` vertices besides the eye, `s` of them from the light.
macro_rules! only {
    ($length:literal, $s:literal) => {
        |subject| {
            weighted(subject, |path, s| {
                f64::from(path.len() == $length && s == $s)
            })
        }
    };
}

/// Each strategy alone finds all the light of the paths that it makes.
fn alone() -> Vec<Bench<Subject>> {
    let floor = |name, what, scene, count, only: fn(Subject) -> Subject| {
        let size = (SQUARE, count, IMAGE);
        let bench = mean((name, Bdpt, &MIS), what, scene, size);
        altered(bench, only)
    };
    let mut benches = vec![
        floor(
            "bidirectional/alone/hits",
            "a floor under a near light, by hits alone",
            scenes::near(),
            4_000,
            only!(2, 0),
        ),
        floor(
            "bidirectional/alone/shadow-rays",
            "a floor under a square light, by shadow rays alone",
            scenes::rectangle(false),
            5_000,
            only!(2, 1),
        ),
        floor(
            "bidirectional/alone/seen-particles",
            "a floor under a square light, by particles that the camera sees",
            scenes::rectangle(false),
            8_000,
            only!(2, 2),
        ),
    ];
    benches.extend(
        [
            (
                "bidirectional/alone/sphere-hits",
                only!(4, 0) as fn(Subject) -> Subject,
            ),
            ("bidirectional/alone/sphere-shadow-rays", only!(4, 1)),
            ("bidirectional/alone/sphere-inner-connections", only!(4, 2)),
            ("bidirectional/alone/sphere-first-connections", only!(4, 3)),
        ]
        .map(|(name, only)| sphere(name, only)),
    );
    benches
}

/// In a sphere of albedo ρ the paths of three scatterings have the expectation ρ³ for every strategy, and
/// every single one has that value: densities are uniform. Roulette would add its noise; walks end after
/// three scatterings instead.
fn sphere(name: &'static str, only: fn(Subject) -> Subject) -> Bench<Subject> {
    let rho: f64 = 0.5;
    let scene = (scenes::sphere_furnace(rho), rho.powi(3));
    let what = "light that a sphere reflects three times, by one strategy alone";
    let bench = mean(
        (name, Bdpt, &PATH_DENSITY),
        what,
        scene,
        (SQUARE, 400, IMAGE),
    );
    altered(bench, move |subject| {
        let table = only(subject).parts.unwrap_or(RIGHT);
        Setup {
            parts: Some(Table {
                survival_by_throughput: |throughput| f64::from(throughput.x > 0.1),
                ..table
            }),
            ..subject
        }
    })
}

/// The same image as the path tracer's.
fn equivalence() -> Vec<Bench<Subject>> {
    let same = |name, kind, scene, (count, frames)| {
        let passes = Passes {
            scene,
            kind,
            frame: [16, 12],
            count,
        };
        let property = "an image of particles has the path tracer's mean";
        same_as_path(words(name, property, &RENDERING), &passes, (frames, IMAGE))
    };
    let cornell = scenes::cornell_box().ok();
    let room = scenes::diffuse_room().ok();
    let light_tracer = cornell.map(|scene| {
        let name = "bidirectional/light-tracer/cornell";
        same(name, LightTracer, scene, (22_000, 20_000))
    });
    let bdpt = room.map(|scene| {
        let name = "bidirectional/bdpt/diffuse-room";
        same(name, Bdpt, scene, (2_800, 16_000))
    });
    light_tracer.into_iter().chain(bdpt).collect()
}

const PATHS: u64 = 10_000;

/// On any path the weights of all strategies that exist sum to one, and are in proportion to the products
/// of densities.
struct Weights;

impl Property for Weights {
    fn run<P: Parts + Copy>(&self, context: &Context, setup: Setup<P>) -> Vec<Outcome> {
        let mut rng = context.rng("paths");
        let (mut sums, mut balance) = (0.0_f64, 0.0_f64);
        for _ in 0..context.n(PATHS) {
            let length = 1 + (8.0 * uniform(&mut rng)) as usize;
            let path: Vec<Density> = (0..length)
                .map(|i| Density {
                    light: uniform(&mut rng) + 0.01,
                    eye: uniform(&mut rng) + 0.01,
                    specular: i > 0 && uniform(&mut rng) < 0.3,
                })
                .collect();
            // The density of the strategy that takes s vertices from the light; 0 if it does not exist.
            let density = |s: usize| -> f64 {
                let open = |i: usize| path.get(i).is_none_or(|x| !x.specular);
                if s > 0 && !(open(s - 1) && open(s)) {
                    return 0.0;
                }
                let (light, eye) = path.split_at(s);
                let light: f64 = light.iter().map(|x| x.light).product();
                light * eye.iter().map(|x| x.eye).product::<f64>()
            };
            let all: f64 = (0..=length).map(density).sum();
            let existing = (0..=length).filter(|&s| density(s) > 0.0);
            let mut sum = 0.0;
            for s in existing {
                let weight = setup.parts.strategy_weight(&path, s);
                balance = balance.max((weight - density(s) / all).abs());
                sum += weight;
            }
            sums = sums.max((sum - 1.0).abs());
        }
        let exact =
            |name, error| Outcome::exact(name, PATHS, error, 1e-12, "the worst of random paths");
        vec![exact("sum of weights", sums), exact("balance", balance)]
    }
}

fn weights() -> Bench<Subject> {
    let property =
        "the weights of all strategies of a path sum to one, in proportion to their densities";
    let name = "bidirectional/weights";
    let size = (PATHS, 1e-12, 0);
    Bench::new(
        data(
            name,
            property,
            &PATH_DENSITY,
            "estimator::weight",
            "exact",
            size,
        ),
        on(Weights),
    )
}
