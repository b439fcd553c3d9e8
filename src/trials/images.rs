//! Whole films: what `render` makes of a scene with an estimator.

use std::ops::Range;
use std::sync::Arc;

use super::probes::IMAGE;
use super::subject::{Property, Setup, Subject, on};
use crate::equation::RENDERING;
use crate::estimator::{Estimator, Parts, Path, Report, Standard, Strategy};
use crate::film::Film;
use crate::harness::mean::{Values, mean};
use crate::harness::outcome::{Claim, Outcome};
use crate::harness::trial::Context;
use crate::harness::welch_map::{PixelStatistics, image_mean, map};
use crate::pixel::PixelSampling;
use crate::render::{Numbers, Sampling, render};
use crate::scene::Scene;
use crate::scene::room::diffuse;
use crate::scene::simple::environment;
use crate::zoo::{Bench, data};

/// A film of a scene, every ray through its pixel's centre, so that edges add no noise; `None` if the estimator returns what no film can hold, which is a fault.
pub(super) fn film<E: Estimator>(
    context: &Context,
    part: &str,
    (scene, size, range): (&Scene, [u32; 2], Range<u32>),
    estimator: &E,
) -> Option<Film> {
    let sampling = Sampling {
        numbers: Numbers::Independent,
        pixel: PixelSampling::Centre,
        seed: context.seed_of(part),
    };
    let mut film = Film::new(size, None, 1).ok()?;
    render(scene, estimator, sampling, &mut film, &range, &|_| true).ok()?;
    Some(film)
}

/// Means, variances and counts of a film's first channel.
pub(super) struct Channel {
    mean: Vec<f64>,
    variance: Vec<f64>,
    count: Vec<u64>,
}

impl Channel {
    pub fn new(film: &Film) -> Self {
        let pixels = film.pixels();
        Self {
            mean: pixels.iter().map(|p| p.mean().x).collect(),
            variance: pixels
                .iter()
                .map(|p| p.standard_error().x.powi(2) * f64::from(p.replications()))
                .collect(),
            count: pixels.iter().map(|p| u64::from(p.replications())).collect(),
        }
    }

    pub fn statistics(&self) -> PixelStatistics<'_> {
        PixelStatistics {
            mean: &self.mean,
            variance: &self.variance,
            count: &self.count,
        }
    }
}

/// The outcome of an estimator whose values no film can hold.
fn not_a_film() -> Vec<Outcome> {
    vec![Outcome::exact(
        "film",
        0,
        f64::NAN,
        0.0,
        "a radiance that no film holds",
    )]
}

/// The mean of the pixels of the white furnace: every one's expectation is 1.
struct WhiteFurnace {
    scene: Arc<Scene>,
}

const FURNACE_SIZE: [u32; 2] = [48, 16];
const FURNACE_REPLICATIONS: u64 = 24_000;

impl Property for WhiteFurnace {
    fn run<P: Parts + Copy>(&self, context: &Context, setup: Setup<P>) -> Vec<Outcome> {
        let parts = setup.parts;
        // One value per replication of the whole film: a mean of many pixels, nearly normal.
        let mut values = Values::new(1.0);
        for replication in 0..context.n(FURNACE_REPLICATIONS) {
            let part = format!("film {replication}");
            let frame = (&*self.scene, FURNACE_SIZE, 0..1);
            let Some(film) = film(
                context,
                &part,
                frame,
                &Path {
                    parts,
                    strategy: Strategy::Mis,
                },
            ) else {
                return not_a_film();
            };
            values.push(film.mean());
        }
        let claim = Claim::Exact { delta: IMAGE };
        vec![mean("image mean", &values, 1.0, claim)]
    }
}

/// The path tracer and the report's estimator with physical rules in the all-diffuse room: two
/// directions of sampling, two roulettes, with and without multiple importance sampling.
struct SameImage {
    scene: Arc<Scene>,
}

const ROOM_SIZE: [u32; 2] = [40, 30];
const ROOM_REPLICATIONS: u64 = 1_500;
/// Segments of the report's estimator: what it leaves out is below 0.75³¹ ≈ 1.3e-4 of the whole, a
/// hundredth of the margin, as no albedo exceeds 0.75.
const ROOM_SEGMENTS: u32 = 30;
/// Pixels' p-values are compared with the uniform law to this distance.
const FLATNESS: f64 = 0.25;

impl Property for SameImage {
    fn run<P: Parts + Copy>(&self, context: &Context, setup: Setup<P>) -> Vec<Outcome> {
        let n = context.n(ROOM_REPLICATIONS) as u32;
        let report = Report {
            parts: setup.parts,
            rays: 1,
            segments: setup.segments.unwrap_or(ROOM_SEGMENTS),
            rules: setup.rules,
        };
        let a = film(context, "report", (&*self.scene, ROOM_SIZE, 0..n), &report);
        let b = film(
            context,
            "path",
            (&*self.scene, ROOM_SIZE, 0..n),
            &Path::<Standard>::default(),
        );
        let (Some(a), Some(b)) = (a, b) else {
            return not_a_film();
        };
        let (a, b) = (Channel::new(&a), Channel::new(&b));
        let (a, b) = (a.statistics(), b.statistics());
        let pixels = map(&a, &b, ROOM_SIZE[0] as usize, 1);
        vec![
            image_mean("image mean", &a, &b, IMAGE),
            pixels.flatness("p-values of pixels", FLATNESS),
        ]
    }
}

/// The trials.
pub fn benches() -> Vec<Bench<Subject>> {
    let (Ok(white), Ok(room)) = (environment(), diffuse()) else {
        return Vec::new();
    };
    let white = WhiteFurnace {
        scene: Arc::new(white),
    };
    let same = SameImage {
        scene: Arc::new(room),
    };
    let pixels = u64::from(FURNACE_SIZE[0] * FURNACE_SIZE[1]) * FURNACE_REPLICATIONS;
    let room_pixels = u64::from(ROOM_SIZE[0] * ROOM_SIZE[1]) * ROOM_REPLICATIONS;
    vec![
        Bench::new(
            data(
                "images/white-furnace",
                "the film of a white Lambert sphere, a mirror and glass under a white sky has mean 1",
                &RENDERING,
                "render::render, estimator::Path",
                "t",
                (pixels, IMAGE, 1),
            ),
            on(white),
        ),
        Bench::new(
            data(
                "images/diffuse-room",
                "the path tracer and the report's estimator, unlimited, make the same image",
                &RENDERING,
                "render::render, estimator::Path, estimator::Report",
                "Welch, equivalence",
                (room_pixels, IMAGE, 2),
            ),
            on(same),
        ),
    ]
}
