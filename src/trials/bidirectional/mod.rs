//! Particles and the camera: the light tracer and bidirectional path tracing on scenes with closed forms,
//! strategy by strategy, and against the path tracer.

mod faults;
mod scenes;

use std::sync::Arc;

use super::passes::ImageKind::{Bdpt, LightTracer};
use super::passes::{ImageKind, Passes, Region, altered, image, same_as_path, whole};
use super::probes::{BOUNCES, IMAGE, SINGLE, words};
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
    let behind = |name, kind| {
        let what = "a floor under a light that faces up";
        mean(
            (name, kind, &GEOMETRY),
            what,
            scenes::rectangle(true),
            (SQUARE, 100, IMAGE),
        )
    };
    vec![
        rectangle("bidirectional/light-tracer/rectangle", LightTracer, 8_000),
        rectangle("bidirectional/bdpt/rectangle", Bdpt, 4_000),
        sphere("bidirectional/light-tracer/sphere", LightTracer, 20_000),
        sphere("bidirectional/bdpt/sphere", Bdpt, 4_000),
        behind("bidirectional/light-tracer/behind", LightTracer),
        behind("bidirectional/bdpt/behind", Bdpt),
        frame("bidirectional/light-tracer/frame", LightTracer, 17_000),
        frame("bidirectional/bdpt/frame", Bdpt, 17_000),
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
        let size = ([24, 8], count, BOUNCES);
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
            "bidirectional/light-tracer/cavity-black",
            LightTracer,
            Cap::Black,
            10_000,
        ),
        cavity(
            "bidirectional/light-tracer/cavity-reflecting",
            LightTracer,
            Cap::Reflecting,
            10_000,
        ),
        cavity("bidirectional/bdpt/cavity-black", Bdpt, Cap::Black, 2_000),
        cavity(
            "bidirectional/bdpt/cavity-reflecting",
            Bdpt,
            Cap::Reflecting,
            3_000,
        ),
        sky("bidirectional/bdpt/environment", 2_000),
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
            ([24, 12], count, IMAGE),
        )
    };
    let glass = |name, kind, count| {
        let what = "a ball in glass, all in equilibrium";
        mean(
            (name, kind, &REFRACTION),
            what,
            scenes::in_glass(),
            ([16, 12], count, IMAGE),
        )
    };
    vec![
        mirror(
            "bidirectional/light-tracer/mirror-caustic",
            LightTracer,
            60_000,
        ),
        mirror("bidirectional/bdpt/mirror-caustic", Bdpt, 30_000),
        glass("bidirectional/light-tracer/in-glass", LightTracer, 10_000),
        glass("bidirectional/bdpt/in-glass", Bdpt, 3_000),
    ]
}

/// Gives one strategy all the weight: paths of `length` vertices besides the eye, `s` of them from the
/// light.
macro_rules! only {
    ($length:literal, $s:literal) => {
        |subject| Setup {
            parts: Some(Table {
                strategy_weight: |path, s| f64::from(u8::from(path.len() == $length && s == $s)),
                ..subject.parts.unwrap_or(RIGHT)
            }),
            ..subject
        }
    };
}

/// Each strategy alone finds all the light of the paths that it makes.
fn alone() -> Vec<Bench<Subject>> {
    let floor = |name, what, count, only| {
        let size = (SQUARE, count, IMAGE);
        let bench = mean((name, Bdpt, &MIS), what, scenes::rectangle(false), size);
        altered(bench, only)
    };
    // In a sphere every path of m scatterings has the expectation ρ^m.
    let rho: f64 = 0.75;
    let sphere = |name, what, length: i32, count, only| {
        let scene = (scenes::sphere_furnace(rho), rho.powi(length - 1));
        altered(
            mean(
                (name, Bdpt, &PATH_DENSITY),
                what,
                scene,
                (SQUARE, count, IMAGE),
            ),
            only,
        )
    };
    vec![
        floor(
            "bidirectional/alone/hits",
            "a floor under a square light, by hits alone",
            30_000,
            only!(2, 0),
        ),
        floor(
            "bidirectional/alone/shadow-rays",
            "a floor under a square light, by shadow rays alone",
            4_000,
            only!(2, 1),
        ),
        floor(
            "bidirectional/alone/seen-particles",
            "a floor under a square light, by particles that the camera sees",
            8_000,
            only!(2, 2),
        ),
        sphere(
            "bidirectional/alone/first-connections",
            "twice reflected light in a sphere, by connections next to the camera",
            3,
            8_000,
            only!(3, 2),
        ),
        sphere(
            "bidirectional/alone/inner-connections",
            "light that a sphere reflects three times, by connections in the middle",
            4,
            12_000,
            only!(4, 2),
        ),
    ]
}

/// The same image as the path tracer's.
fn equivalence() -> Vec<Bench<Subject>> {
    let same = |name, kind, scene, (count, rays)| {
        let passes = Passes {
            scene,
            kind,
            frame: [16, 12],
            count,
        };
        let property = "an image of particles has the path tracer's mean";
        same_as_path(words(name, property, &RENDERING), &passes, (rays, IMAGE))
    };
    let cornell = scenes::cornell_box().ok();
    let room = scenes::diffuse_room().ok();
    let light_tracer = cornell.map(|scene| {
        let name = "bidirectional/light-tracer/cornell";
        same(name, LightTracer, scene, (20_000, 3_000_000))
    });
    let bdpt = room.map(|scene| {
        let name = "bidirectional/bdpt/diffuse-room";
        same(name, Bdpt, scene, (2_000, 3_000_000))
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
