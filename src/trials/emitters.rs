//! Points on emitters: uniform in area on every shape; form factors through the geometry term.

use glam::DVec3;

use crate::emitter::{Emitter, EmitterShape};
use crate::equation::{Equation, GEOMETRY, TRIANGLE_POINT};
use crate::harness::chi_square::{CELL_DELTA, sampler_against_partition};
use crate::harness::domain::{Domain, Partition};
use crate::harness::mean::{Values, mean};
use crate::harness::outcome::{Claim, Outcome};
use crate::harness::trial::Context;
use crate::radiometry::geometry_term;
use crate::rng::uniform2;
use crate::sampling::{sphere_zone, triangle};
use crate::shape::Sphere;
use crate::zoo::{AnyFamily, Bench, Family, Mutant, data, mutant};

/// A map from two random numbers to a point of a standard shape.
type Map = fn([f64; 2]) -> DVec3;
/// G(x, n_x, y, n_y).
type Geometry = fn(DVec3, DVec3, DVec3, DVec3) -> f64;

/// The maps of the three shapes and the geometry term, each replaceable.
#[derive(Clone, Copy)]
pub struct Points {
    /// (u, v, 0) of a triangle.
    pub triangle: Map,
    /// A point of the unit square through an emitter.
    pub rectangle: Map,
    /// A point of the unit sphere through an emitter.
    pub sphere: Map,
    /// The geometry term.
    pub geometry: Geometry,
}

fn unit_square([r1, r2]: [f64; 2]) -> DVec3 {
    let shape = EmitterShape::Rectangle {
        corner: DVec3::ZERO,
        edges: [DVec3::X, DVec3::Y],
    };
    Emitter::new(shape, DVec3::ONE).sample([r1, r2]).point
}

const RIGHT: Points = Points {
    triangle: |random| {
        let [u, v] = triangle(random);
        DVec3::new(u, v, 0.0)
    },
    rectangle: unit_square,
    sphere: |random| {
        let shape = EmitterShape::Sphere(Sphere::new(DVec3::ZERO, 1.0));
        Emitter::new(shape, DVec3::ONE).sample(random).point
    },
    geometry: geometry_term,
};

const SAMPLES: u64 = 5_600_000;
const FORM_SAMPLES: u64 = 2_200_000;
/// δ of form factors, relative.
const DELTA: f64 = 0.003;
/// The form factor of unit squares that face each other at distance 1 (Howell's catalogue, C-11).
pub const PARALLEL: f64 = 0.199_824_895_698_387_4;

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

/// F = 1/(π A) ∫∫ G: the mean of G/π over points of both squares.
fn form_factor(context: &Context, points: Points) -> Vec<Outcome> {
    let mut rng = context.rng("points");
    let values = Values::collect(PARALLEL, context.n(FORM_SAMPLES), || {
        let x = (points.rectangle)(uniform2(&mut rng));
        let y = (points.rectangle)(uniform2(&mut rng)) + DVec3::Z;
        (points.geometry)(x, DVec3::Z, y, -DVec3::Z) * std::f64::consts::FRAC_1_PI
    });
    let delta = DELTA * PARALLEL;
    vec![mean(
        "form factor",
        &values,
        PARALLEL,
        Claim::Exact { delta },
    )]
}

fn benches() -> Vec<Bench<Points>> {
    let trial = |name: &str, property: &str, equation: &'static Equation, subject, size| {
        let statistic = if name == "form-factor" {
            "t"
        } else {
            "chi-square"
        };
        data(
            format!("emitter/{name}"),
            property,
            equation,
            subject,
            statistic,
            size,
        )
    };
    let chi = (SAMPLES, CELL_DELTA, 1);
    vec![
        Bench::new(
            trial(
                "triangle",
                "points of a triangle are uniform in area",
                &TRIANGLE_POINT,
                "sampling::triangle",
                chi,
            ),
            |c, points: Points| cells(c, Domain::Triangle, points.triangle),
        ),
        Bench::new(
            trial(
                "rectangle",
                "points of a rectangle are uniform in area",
                &GEOMETRY,
                "emitter::Emitter::sample",
                chi,
            ),
            |c, points: Points| cells(c, Domain::Square, points.rectangle),
        ),
        Bench::new(
            trial(
                "sphere",
                "points of a sphere are uniform in area",
                &GEOMETRY,
                "sampling::sphere_zone",
                chi,
            ),
            |c, points: Points| cells(c, Domain::Sphere, points.sphere),
        ),
        Bench::new(
            trial(
                "form-factor",
                "parallel unit squares at distance 1 have the form factor 0.19982",
                &GEOMETRY,
                "radiometry::geometry_term",
                (FORM_SAMPLES, DELTA, 1),
            ),
            form_factor,
        ),
    ]
}

fn faults() -> Vec<Mutant<Points>> {
    let geometry = |name, wrong, geometry: Geometry| {
        let subject = Points { geometry, ..RIGHT };
        let caught_by: &[&str] = &["emitter/form-factor"];
        mutant(name, &GEOMETRY, wrong, subject, caught_by)
    };
    vec![
        mutant(
            "unfolded",
            &TRIANGLE_POINT,
            "the square is not folded: u + v may exceed 1",
            Points {
                triangle: |[r1, r2]| DVec3::new(r1, r2, 0.0),
                ..RIGHT
            },
            &["emitter/triangle"],
        ),
        mutant(
            "crowded",
            &TRIANGLE_POINT,
            "v = r₂(1 − u) with u = r₁: points crowd at the corner V₁",
            Points {
                triangle: |[r1, r2]| DVec3::new(r1, r2 * (1.0 - r1), 0.0),
                ..RIGHT
            },
            &["emitter/triangle"],
        ),
        mutant(
            "one-number",
            &GEOMETRY,
            "one random number for both coordinates: the diagonal",
            Points {
                rectangle: |[r, _]| unit_square([r, r]),
                ..RIGHT
            },
            &["emitter/rectangle"],
        ),
        mutant(
            "crowded-poles",
            &GEOMETRY,
            "uniform in the inclination: points crowd at the poles",
            Points {
                sphere: |[r1, r2]| {
                    sphere_zone(
                        [0.5 - 0.5 * (std::f64::consts::PI * r1).cos(), r2],
                        1.0,
                        [-1.0, 1.0],
                    )
                },
                ..RIGHT
            },
            &["emitter/sphere"],
        ),
        geometry("one-cosine", "the cosine at y is missing", |x, nx, y, _| {
            nx.dot((y - x).normalize()).max(0.0) / (y - x).length_squared()
        }),
        geometry("distance", "the distance for its square", |x, nx, y, ny| {
            geometry_term(x, nx, y, ny) * (y - x).length()
        }),
        geometry(
            "normal-flipped",
            "the normal at y points away",
            |x, nx, y, ny| geometry_term(x, nx, y, -ny),
        ),
    ]
}

/// The emitters' points.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    vec![Box::new(Family {
        benches: benches(),
        faults: faults(),
        equivalents: vec![mutant(
            "folded-otherwise",
            &TRIANGLE_POINT,
            "u = 1 − √r₁, v = r₂√r₁: another map, the same density",
            Points {
                triangle: |[r1, r2]| DVec3::new(1.0 - r1.sqrt(), r2 * r1.sqrt(), 0.0),
                ..RIGHT
            },
            &["emitter/triangle"],
        )],
        share: 1.0 / 4.0,
        ..Family::new("points", RIGHT)
    })]
}
