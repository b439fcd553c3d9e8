//! More points for the outlines of lights, and camera rays that follow mirrors first: they leave
//! the mean of a pixel as it is.

use std::f64::consts::FRAC_PI_4;

use whitefurnace::render::silhouette;
use whitefurnace::render::silhouette::{POINTS, View};

use crate::mean_radiance::means;
use crate::prelude::*;

/// How a pixel takes the points of an outline: their places, what it makes of what they show, and
/// what rays show that follow mirrors.
#[derive(Clone, Copy)]
pub struct OutlinePoints {
    /// By seed, pixel, replication and sample.
    pub points: fn(u64, u32, u32, u32) -> [[f64; 2]; POINTS],
    /// By the radiance of the sample, its own direct emission and that of the points.
    pub replaced: fn(DVec3, DVec3, [DVec3; POINTS]) -> DVec3,
    /// By what the camera ray shows, and the scene.
    pub in_mirrors: fn(View, &Scene) -> View,
}

const RIGHT: OutlinePoints = OutlinePoints {
    points: silhouette::points,
    replaced: silhouette::replaced,
    in_mirrors: View::in_mirrors,
};

/// What three lights show through a point of the pixel, one in each channel: a part of a disc, a
/// triangle, a strip.
fn shown([x, y]: [f64; 2]) -> DVec3 {
    RADIANCE
        * DVec3::from(
            [
                x * x + y * y < 1.0,
                x + 2.0 * y < 1.0,
                (x - 0.37).abs() < 0.01,
            ]
            .map(f64::from),
        )
}

/// Of the lights.
const RADIANCE: f64 = 4.0;
/// The shares of the pixel in which they are seen.
const AREAS: [f64; 3] = [FRAC_PI_4, 0.25, 0.02];
/// The mean of all other light, xy.
const OTHER: f64 = 0.25;

const REPLICATIONS: u64 = 300_000;
const EFFECT: f64 = 0.008;

/// The mean of each channel, over replications of two samples.
fn channels(context: &Context, subject: OutlinePoints) -> Vec<Outcome> {
    let mut rng = context.rng("samples");
    let seed = context.seed_of("points");
    let mut replication = 0;
    let names = ["disc", "triangle", "strip"];
    let about = [0, 1, 2].map(|i| (names[i], RADIANCE * AREAS[i] + OTHER, EFFECT));
    means(about, context.n(REPLICATIONS), || {
        let sample = |index| {
            let [x, y] = uniform2(&mut rng);
            let points = (subject.points)(seed, 7, replication, index);
            let own = shown([x, y]);
            (subject.replaced)(own + DVec3::splat(x * y), own, points.map(shown))
        };
        let values = 0.5 * [0, 1].map(sample).into_iter().sum::<DVec3>();
        replication += 1;
        values.to_array()
    })
}

/// What the mirror reflects, and the share of the pixel in which a light is seen in it before a
/// bright background.
const REFLECTANCE: [f64; 3] = [0.25, 0.5, 1.0];
const AREA_IN_MIRROR: f64 = 0.375;

fn light_in_mirror() -> Scene {
    let mut s = SceneBuilder::new("light in a mirror");
    s.background(DVec3::ONE);
    let light = s.surface(Surface::new(Bsdf::Black).emitting(DVec3::splat(RADIANCE)));
    let mirror = s.surface(Surface::new(Bsdf::Mirror {
        reflectance: REFLECTANCE.into(),
    }));
    s.rectangle(
        DVec3::new(-1.0, 1.0, -1.0),
        [2.0 * DVec3::X, 2.0 * DVec3::Z],
        mirror,
    );
    // Its image in the mirror is twice as far behind it as it is behind the eye.
    s.rectangle(
        DVec3::new(-3.0, -2.0, -3.0),
        [3.5 * DVec3::Z, 3.0 * DVec3::X],
        light,
    );
    s.build(Camera::new(DVec3::ZERO, DVec3::Y, DVec3::Z, 0.25))
        .expect("a legal scene")
}

/// The mean of each channel through a mirror, over replications of one sample.
fn channels_in_mirror(context: &Context, subject: OutlinePoints) -> Vec<Outcome> {
    let (mut rng, seed, scene) = (
        context.rng("samples"),
        context.seed_of("points"),
        light_in_mirror(),
    );
    let path = Path::new(Standard, Strategy::Mis);
    let view = |[x, y]: [f64; 2]| {
        let ray = scene.camera().ray([1, 1], x, y);
        (subject.in_mirrors)(View::new(ray, scene.intersect(&ray)), &scene)
    };
    let mean =
        |reflectance: f64| reflectance * (AREA_IN_MIRROR * RADIANCE + (1.0 - AREA_IN_MIRROR));
    let mut replication = 0;
    let about = [0, 1, 2].map(|i| {
        (
            ["red", "green", "blue"][i],
            mean(REFLECTANCE[i]),
            REFLECTANCE[i] * EFFECT,
        )
    });
    // As many samples as replications of two have.
    means(about, context.n(2 * REPLICATIONS), || {
        let seen = view(uniform2(&mut rng));
        let radiance = seen.weight * path.radiance(&scene, &seen.ray, seen.hit, &mut rng);
        let shown =
            (subject.points)(seed, 7, replication, 0).map(|point| view(point).emitted(&scene));
        replication += 1;
        (subject.replaced)(radiance, seen.emitted(&scene), shown).to_array()
    })
}

/// The mean of `POINTS` or another number of them, in place of a sample's own.
fn mean_over(number: f64, radiance: DVec3, shown: [DVec3; POINTS]) -> DVec3 {
    radiance + shown.into_iter().sum::<DVec3>() / number
}

/// The points of an outline.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    vec![Box::new(Family {
        trials: vec![
            trial(
                "convergence/outlines",
                "more points for what lights show directly leave the mean of a pixel as it is",
                &RANDOMISATION,
                ["render::silhouette::replaced", "t"],
                channels,
            ),
            trial(
                "convergence/in-mirrors",
                "camera rays that follow a mirror first, and more points for a light in it, leave the mean of a pixel as it is",
                &RANDOMISATION,
                ["render::silhouette::View::in_mirrors", "t"],
                channels_in_mirror,
            ),
        ],
        faults: vec![
            fault!("own-kept", RANDOMISATION, "the sample's own direct emission is counted as well",
                = OutlinePoints { replaced: |radiance, _, shown| mean_over(POINTS as f64, radiance, shown), ..RIGHT },
                "convergence/outlines: disc | triangle | strip", "convergence/in-mirrors: red | green | blue"),
            fault!("by-seven", RANDOMISATION, "the sum over eight points is divided by seven",
                = OutlinePoints { replaced: |radiance, own, shown| mean_over(7.0, radiance - own, shown), ..RIGHT },
                "convergence/outlines: disc | triangle | strip", "convergence/in-mirrors: red | green | blue"),
            fault!("towards-corner", RANDOMISATION, "the points are not uniform: their coordinates are squared",
                = OutlinePoints {
                    points: |seed, pixel, replication, index| {
                        silhouette::points(seed, pixel, replication, index).map(|point| point.map(|x| x * x))
                    },
                    ..RIGHT
                },
                "convergence/outlines: disc | triangle | strip", "convergence/in-mirrors: red | green | blue"),
            fault!("mirror-without-loss", RANDOMISATION, "a mirror that camera rays follow reflects all light",
                = OutlinePoints {
                    in_mirrors: |view, scene| View { weight: DVec3::ONE, ..view.in_mirrors(scene) },
                    ..RIGHT
                },
                "convergence/in-mirrors: red | green"),
            fault!("mirror-passed", RANDOMISATION, "camera rays go straight on behind a mirror",
                = OutlinePoints {
                    in_mirrors: |view, scene| {
                        let (ray, hit) = scene.onward(&view.hit.expect("a mirror"), view.ray.direction);
                        View { ray, hit, ..view.in_mirrors(scene) }
                    },
                    ..RIGHT
                },
                "convergence/in-mirrors: red | green | blue"),
        ],
        ..Family::new("outlines", RIGHT)
    })]
}
