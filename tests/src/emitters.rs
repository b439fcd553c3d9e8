//! Points on emitters: uniform in area on every shape.

use whitefurnace::harness::chi_square::sampler_against_partition;
use whitefurnace::light::emitter::{Emitter, EmitterShape};
use whitefurnace::sampling::warp::{sphere_zone, triangle};

use crate::prelude::*;

/// A map from two random numbers to a point of a standard shape.
type Map = fn([f64; 2]) -> DVec3;

/// Sampling maps of the three shapes, each replaceable.
#[derive(Clone, Copy)]
pub struct Points {
    /// Samples (u, v, 0) of a triangle.
    pub triangle: Map,
    /// Samples the unit square through an emitter.
    pub rectangle: Map,
    /// Samples the unit sphere through an emitter.
    pub sphere: Map,
}

fn on(shape: EmitterShape, random: [f64; 2]) -> DVec3 {
    Emitter::new(shape, DVec3::ONE).sample(random).point
}

fn unit_square(random: [f64; 2]) -> DVec3 {
    on(
        EmitterShape::Rectangle {
            corner: DVec3::ZERO,
            edges: [DVec3::X, DVec3::Y],
        },
        random,
    )
}

const CORRECT: Points = Points {
    triangle: |random| {
        let [u, v] = triangle(random);
        DVec3::new(u, v, 0.0)
    },
    rectangle: unit_square,
    sphere: |random| on(EmitterShape::Sphere(Sphere::new(DVec3::ZERO, 1.0)), random),
};

const SAMPLES: u64 = 5_300_000;

fn cells(context: &Context, domain: Domain, map: Map) -> Vec<Outcome> {
    let mut rng = context.rng("cells");
    let partition = Partition::equal(domain, 3, 4);
    vec![sampler_against_partition(
        "cells of equal area",
        &partition,
        context.n(SAMPLES),
        || Some(map(uniform2(&mut rng))),
    )]
}

fn trials() -> Vec<FamilyTrial<Points>> {
    let family_trial = |name: &str, equation: &'static Equation, subject, on: TrialFn<Points>| {
        let property = format!("points of a {name} are uniform in area");
        trial(
            format!("emitter/{name}"),
            property,
            format!("a {name} that gives light is brighter in one part, and shadows are skewed"),
            equation,
            subject,
            "chi-square",
            on,
        )
    };
    vec![
        family_trial(
            "triangle",
            &TRIANGLE_POINT,
            "sampling::warp::triangle",
            |c, p| cells(c, Domain::Triangle, p.triangle),
        ),
        family_trial(
            "rectangle",
            &GEOMETRY,
            "light::emitter::Emitter::sample",
            |c, p| cells(c, Domain::Square, p.rectangle),
        ),
        family_trial(
            "sphere",
            &GEOMETRY,
            "sampling::warp::sphere_zone",
            |c, p| cells(c, Domain::Sphere, p.sphere),
        ),
    ]
}

fn faults() -> Vec<Fault<Points>> {
    vec![
        fault!("unfolded", TRIANGLE_POINT, "the square is not folded: u + v may exceed 1",
            Points: { triangle: |[r1, r2]| DVec3::new(r1, r2, 0.0) }, "emitter/triangle"),
        fault!("crowded", TRIANGLE_POINT, "v = r₂(1 − u) with u = r₁: points crowd at the corner V₁",
            Points: { triangle: |[r1, r2]| DVec3::new(r1, r2 * (1.0 - r1), 0.0) }, "emitter/triangle"),
        fault!("one-number", GEOMETRY, "one random number for both coordinates: the diagonal",
            Points: { rectangle: |[r, _]| unit_square([r, r]) }, "emitter/rectangle"),
        fault!("crowded-poles", GEOMETRY, "uniform in the inclination: points crowd at the poles",
            Points: { sphere: |[r1, r2]| sphere_zone([0.5 - 0.5 * (PI * r1).cos(), r2], 1.0, [-1.0, 1.0]) },
            "emitter/sphere"),
    ]
}

/// Trials and faults of points on emitters.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    vec![Box::new(Family {
        trials: trials(),
        faults: faults(),
        equivalents: vec![
            fault!("folded-otherwise", TRIANGLE_POINT, "u = 1 − √r₁, v = r₂√r₁: another map, the same density",
            Points: { triangle: |[r1, r2]| DVec3::new(1.0 - r1.sqrt(), r2 * r1.sqrt(), 0.0) }, "emitter/triangle"),
        ],
        ..Family::new("points", CORRECT)
    })]
}
