//! More points for the outlines of lights: they leave the mean of a pixel as it is.

use std::f64::consts::FRAC_PI_4;

use whitefurnace::outline::{self, POINTS};

use crate::mean_radiance::means;
use crate::prelude::*;

/// How a pixel takes the points of an outline: their places, and what it makes of what they show.
#[derive(Clone, Copy)]
pub struct OutlinePoints {
    /// By seed, pixel, replication and sample.
    pub points: fn(u64, u32, u32, u32) -> [[f64; 2]; POINTS],
    /// By the radiance of the sample, its own direct emission and that of the points.
    pub replaced: fn(DVec3, DVec3, [DVec3; POINTS]) -> DVec3,
}

const RIGHT: OutlinePoints = OutlinePoints { points: outline::points, replaced: outline::replaced };

/// What three lights show through a point of the pixel, one in each channel: a part of a disc, a triangle, a strip.
fn shown([x, y]: [f64; 2]) -> DVec3 {
    RADIANCE * DVec3::from([x * x + y * y < 1.0, x + 2.0 * y < 1.0, (x - 0.37).abs() < 0.01].map(f64::from))
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

/// The mean of `POINTS` or another number of them, in place of a sample's own.
fn mean_over(number: f64, radiance: DVec3, shown: [DVec3; POINTS]) -> DVec3 {
    radiance + shown.into_iter().sum::<DVec3>() / number
}

/// The points of an outline.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    vec![Box::new(Family {
        trials: vec![trial(
            "convergence/outlines",
            "more points for what lights show directly leave the mean of a pixel as it is",
            &RANDOMISATION,
            ["outline::replaced", "t"],
            channels,
        )],
        faults: vec![
            fault!("own-kept", RANDOMISATION, "the sample's own direct emission is counted as well",
                = OutlinePoints { replaced: |radiance, _, shown| mean_over(POINTS as f64, radiance, shown), ..RIGHT },
                "convergence/outlines: disc | triangle | strip"),
            fault!("by-seven", RANDOMISATION, "the sum over eight points is divided by seven",
                = OutlinePoints { replaced: |radiance, own, shown| mean_over(7.0, radiance - own, shown), ..RIGHT },
                "convergence/outlines: disc | triangle | strip"),
            fault!("towards-corner", RANDOMISATION, "the points are not uniform: their coordinates are squared",
                = OutlinePoints {
                    points: |seed, pixel, replication, index| {
                        outline::points(seed, pixel, replication, index).map(|point| point.map(|x| x * x))
                    },
                    ..RIGHT
                },
                "convergence/outlines: disc | triangle | strip"),
        ],
        ..Family::new("outlines", RIGHT)
    })]
}
