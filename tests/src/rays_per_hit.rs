//! N of (16) in the report's estimator: the mean does not depend on it, the cost does.

use std::sync::atomic::{AtomicU64, Ordering};

use whitefurnace::integrator::{Bidirectional, FiniteElements, NextEvent, Photons, Report};
use whitefurnace::sampling::roulette::Roulette;

use crate::furnace::inside;
use crate::prelude::*;
use crate::scenes::{lambert, sphere_furnace};
use crate::subject::estimates;

/// Albedo of the furnace.
const ALBEDO: f64 = 0.5;
/// Absorption of its walls, which ends the paths of the means.
const ABSORPTION: f64 = 0.2;
/// Segments of a path: N sample rays are traced at the first hit, N² at the second.
const SEGMENTS: u32 = 3;
/// The values of N, each with the number of estimates in its mean.
const RAYS: [(u32, u64); 3] = [(1, 240_000), (2, 115_000), (4, 55_000)];

/// The report's estimator with N sample rays in a furnace.
struct SampleRays {
    scene: Arc<Scene>,
    rays: u32,
    samples: u64,
}

impl SampleRays {
    fn new(absorption: f64, rays: u32, samples: u64) -> Self {
        Self {
            scene: sphere_furnace(lambert(ALBEDO), absorption),
            rays,
            samples,
        }
    }

    fn report<'a>(&self, setup: Configuration<'a>) -> Report<'a> {
        let segments = setup.segments.unwrap_or(SEGMENTS);
        Report {
            parts: setup.parts,
            rays: self.rays,
            segments,
            rules: setup.rules,
        }
    }
}

/// Compares the mean with a reference, the same for every N.
struct Mean(SampleRays);

impl Property for Mean {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let reference = (1.0 - ALBEDO.powi(SEGMENTS as i32 + 1)) / (1.0 - ALBEDO);
        let report = Box::new(self.0.report(setup));
        let mut radiance = estimates(context.seed_of("radiance"), &self.0.scene, report, inside);
        vec![mean_of(
            "radiance",
            reference,
            BOUNCES_DELTA,
            context.n(self.0.samples),
            || radiance().x,
        )]
    }
}

/// Wraps other components' roulette and directions, and counts the directions.
#[derive(Clone, Copy)]
struct Counting<'a> {
    parts: Parts<'a>,
    directions: &'a AtomicU64,
}

impl Scattering for Counting<'_> {
    fn uniform_hemisphere(&self, random: [f64; 2]) -> DVec3 {
        self.directions.fetch_add(1, Ordering::Relaxed);
        self.parts.uniform_hemisphere(random)
    }
}

impl Roulette for Counting<'_> {
    fn survival_by_absorption(&self, absorption: f64) -> f64 {
        self.parts.survival_by_absorption(absorption)
    }
    fn survives(&self, r: f64, survival: f64) -> bool {
        self.parts.survives(r, survival)
    }
}

impl NextEvent for Counting<'_> {}
impl Photons for Counting<'_> {}
impl Bidirectional for Counting<'_> {}
impl FiniteElements for Counting<'_> {}

const ESTIMATES: u64 = 100;

/// Counts the sample rays of one estimate: N + N², where nothing is absorbed.
struct Cost(SampleRays);

impl Property for Cost {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let rays = u64::from(self.0.rays);
        let expected: u64 = (1..SEGMENTS).map(|bounce| rays.pow(bounce)).sum();
        let mut rng = context.rng("rays");
        let mut worst = expected;
        for _ in 0..ESTIMATES {
            let directions = AtomicU64::new(0);
            let parts = Counting {
                parts: setup.parts,
                directions: &directions,
            };
            let counting = Configuration {
                parts: Parts::replaced(&parts),
                ..setup
            };
            let ray = inside(&mut rng);
            self.0
                .report(counting)
                .radiance(&self.0.scene, &ray, None, &mut rng);
            let counted = directions.into_inner();
            if counted.abs_diff(expected) > worst.abs_diff(expected) {
                worst = counted;
            }
        }
        let error = worst.abs_diff(expected) as f64;
        let place = format!("{worst} rays, should be {expected}");
        vec![Outcome::identity(
            "sample rays",
            ESTIMATES,
            error,
            0.0,
            place,
        )]
    }
}

pub fn trials() -> Vec<FamilyTrial<EstimatorSubject>> {
    let subject = "integrator::Report";
    let means = RAYS.into_iter().map(|(rays, samples)| {
        let furnace = SampleRays::new(ABSORPTION, rays, samples);
        trial(
            format!("furnace/report/rays-{rays}"),
            format!("with N = {rays} sample rays at each hit the mean is that of every N"),
            format!("images by N = {rays} are too bright or too dark"),
            &ESTIMATOR,
            subject,
            "t",
            with_parts(Mean(furnace)),
        )
    });
    let costs = RAYS.into_iter().map(|(rays, _)| {
        trial(
            format!("furnace/report/cost-{rays}"),
            format!("N = {rays} sample rays at each of two hits are N + N² rays"),
            format!("a render of N = {rays} takes another time than stated, or skips bounces"),
            &ESTIMATOR,
            subject,
            "exact",
            with_parts(Cost(SampleRays::new(0.0, rays, ESTIMATES))),
        )
    });
    means.chain(costs).collect()
}
