//! Supersampling of emitter silhouettes, and camera rays that follow mirrors first: both leave the
//! mean of a pixel unbiased.

use std::f64::consts::FRAC_PI_4;

use whitefurnace::render::silhouette;
use whitefurnace::render::silhouette::{POINTS_PER_SAMPLE, PrimaryRay};

use crate::prelude::*;
use crate::scenes::{panel, seen_by};

/// Silhouette supersampling of a pixel, so that each step can be replaced: the additional points,
/// the combination of their emitted radiance, and the rays that follow mirrors.
#[derive(Clone, Copy)]
pub struct OutlinePoints {
    /// The points within the pixel, from seed, pixel, replication and sample.
    pub points: fn(u64, u32, u32, u32) -> [[f64; 2]; POINTS_PER_SAMPLE],
    /// The pixel's value, from the radiance of the sample, its own direct emission and that of the
    /// points.
    pub with_supersampled_emission: fn(DVec3, DVec3, [DVec3; POINTS_PER_SAMPLE]) -> DVec3,
    /// The view after the mirrors that the camera ray meets, from the camera's view and the scene.
    pub follow_mirrors: fn(PrimaryRay, &Scene) -> PrimaryRay,
}

const CORRECT: OutlinePoints = OutlinePoints {
    points: silhouette::points,
    with_supersampled_emission: silhouette::with_supersampled_emission,
    follow_mirrors: PrimaryRay::follow_mirrors,
};

/// Emitted radiance at a point of the pixel, where three lights are seen, one in each channel: a
/// part of a disc, a triangle, a strip.
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

/// Radiance of the lights.
const RADIANCE: f64 = 4.0;
/// Fractions of the pixel that the lights cover.
const AREAS: [f64; 3] = [FRAC_PI_4, 0.25, 0.02];
/// Mean of all other light, which is xy.
const OTHER: f64 = 0.25;

const REPLICATIONS: u64 = 300_000;
const EFFECT: f64 = 0.008;

/// Compares the mean of each channel, over replications of two samples, with its closed form.
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
            (subject.with_supersampled_emission)(own + DVec3::splat(x * y), own, points.map(shown))
        };
        let values = 0.5 * [0, 1].map(sample).into_iter().sum::<DVec3>();
        replication += 1;
        values.to_array()
    })
}

/// Reflectance of the mirror, and the fraction of the pixel that the light covers in it, before a
/// bright background.
const REFLECTANCE: [f64; 3] = [0.25, 0.5, 1.0];
const AREA_IN_MIRROR: f64 = 0.375;

fn light_in_mirror() -> Arc<Scene> {
    let camera = Camera::new(DVec3::ZERO, DVec3::Y, DVec3::Z, 0.25);
    seen_by(camera, "light in a mirror", |s| {
        s.background(DVec3::ONE);
        let reflectance = REFLECTANCE.into();
        let mirror = Surface::new(Bsdf::Mirror { reflectance });
        let edges = [2.0 * DVec3::X, 2.0 * DVec3::Z];
        panel(s, DVec3::new(-1.0, 1.0, -1.0), edges, mirror);
        // Its mirror image is at y = 4, where the pixel covers [−1, 1] in x and z.
        let light = Surface::new(Bsdf::Black).emitting(DVec3::splat(RADIANCE));
        let edges = [3.5 * DVec3::Z, 3.0 * DVec3::X];
        panel(s, DVec3::new(-3.0, -2.0, -3.0), edges, light);
    })
}

/// Compares the mean of each channel through a mirror, over replications of one sample, with its
/// closed form.
fn channels_in_mirror(context: &Context, subject: OutlinePoints) -> Vec<Outcome> {
    let (mut rng, seed, scene) = (
        context.rng("samples"),
        context.seed_of("points"),
        light_in_mirror(),
    );
    let path = Path::new(Strategy::Mis);
    let view = |[x, y]: [f64; 2]| {
        let ray = scene.camera().ray([1, 1], x, y);
        (subject.follow_mirrors)(PrimaryRay::new(ray, scene.intersect(&ray)), &scene)
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
    // The number of samples is that of replications of two.
    means(about, context.n(2 * REPLICATIONS), || {
        let seen = view(uniform2(&mut rng));
        let radiance = seen.weight * path.radiance(&scene, &seen.ray, seen.hit, &mut rng);
        let shown =
            (subject.points)(seed, 7, replication, 0).map(|point| view(point).emitted(&scene));
        replication += 1;
        (subject.with_supersampled_emission)(radiance, seen.emitted(&scene), shown).to_array()
    })
}

/// Replaces a sample's own emission by the sum over the points, divided by `number`.
fn mean_over(number: f64, radiance: DVec3, shown: [DVec3; POINTS_PER_SAMPLE]) -> DVec3 {
    radiance + shown.into_iter().sum::<DVec3>() / number
}

/// Trials and faults of silhouette supersampling.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    vec![Box::new(Family {
        trials: vec![
            trial(
                "convergence/outlines",
                "supersampled emitter silhouettes leave the mean of a pixel unbiased",
                "lamps in the picture have bright or dark rims",
                &RANDOMISATION,
                "render::silhouette::replaced",
                "t",
                channels,
            ),
            trial(
                "convergence/in-mirrors",
                "camera rays that follow a mirror first, and supersampled silhouettes in it, leave the mean of a pixel unbiased",
                "lamps seen in a mirror have bright or dark rims, or are as bright as unmirrored",
                &RANDOMISATION,
                "render::silhouette::View::in_mirrors",
                "t",
                channels_in_mirror,
            ),
        ],
        faults: vec![
            fault!("own-kept", RANDOMISATION, "the sample's own direct emission is counted as well",
                = OutlinePoints { with_supersampled_emission: |radiance, _, shown| mean_over(POINTS_PER_SAMPLE as f64, radiance, shown), ..CORRECT },
                "convergence/outlines: disc | triangle | strip", "convergence/in-mirrors: red | green | blue"),
            fault!("by-seven", RANDOMISATION, "the sum over eight points is divided by seven",
                = OutlinePoints { with_supersampled_emission: |radiance, own, shown| mean_over(7.0, radiance - own, shown), ..CORRECT },
                "convergence/outlines: disc | triangle | strip", "convergence/in-mirrors: red | green | blue"),
            fault!("towards-corner", RANDOMISATION, "the points are not uniform: their coordinates are squared",
                = OutlinePoints {
                    points: |seed, pixel, replication, index| {
                        silhouette::points(seed, pixel, replication, index).map(|point| point.map(|x| x * x))
                    },
                    ..CORRECT
                },
                "convergence/outlines: disc | triangle | strip", "convergence/in-mirrors: red | green | blue"),
            fault!("mirror-without-loss", RANDOMISATION, "a mirror that camera rays follow reflects all light",
                = OutlinePoints {
                    follow_mirrors: |view, scene| PrimaryRay { weight: DVec3::ONE, ..view.follow_mirrors(scene) },
                    ..CORRECT
                },
                "convergence/in-mirrors: red | green"),
            fault!("mirror-passed", RANDOMISATION, "camera rays go straight on behind a mirror",
                = OutlinePoints {
                    follow_mirrors: |view, scene| {
                        let (ray, hit) = scene.spawn_and_trace(&view.hit.expect("a mirror"), view.ray.direction);
                        PrimaryRay { ray, hit, ..view.follow_mirrors(scene) }
                    },
                    ..CORRECT
                },
                "convergence/in-mirrors: red | green | blue"),
        ],
        ..Family::new("outlines", CORRECT)
    })]
}
