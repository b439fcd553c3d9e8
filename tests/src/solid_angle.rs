//! Emitters sampled by the solid angle that they subtend: directions uniform in it, against cells
//! and means whose values come from angles on the sphere.

use whitefurnace::geometry::shape::triangle_point;
use whitefurnace::harness::chi_square::{CELL_DELTA, Counts, chi_square};
use whitefurnace::light::emitter::{Emitter, EmitterPoint, EmitterShape};
use whitefurnace::math::frame::{Frame, azimuth};

use crate::prelude::*;
use crate::scenes::{TRIANGLE, polygon_irradiance, sphere_irradiance};

/// Samples a point of an emitter from a reference point and two random numbers; returns it and its
/// pdf with respect to solid angle.
type Sample = fn(&Emitter, DVec3, [f64; 2]) -> Option<(EmitterPoint, f64)>;

/// Solid angle of a convex polygon seen from the origin: the sum of the angles between the planes
/// through its edges, less (n − 2)π. Loses digits for small polygons.
pub fn excess(vertices: &[DVec3]) -> f64 {
    let n = vertices.len();
    let normal = |i: usize| vertices[i % n].cross(vertices[(i + 1) % n]);
    let angles = (0..n).map(|i| PI - normal(i).angle_between(normal(i + 1)));
    angles.sum::<f64>() - (n as f64 - 2.0) * PI
}

/// Corner of the rectangle of the trial, off the axis and slanted against the receiver, seen from
/// the origin.
const CORNER: DVec3 = DVec3::new(-0.8, -0.5, 1.0);
const EDGES: [DVec3; 2] = [DVec3::new(0.0, 1.2, 0.0), DVec3::new(1.6, 0.0, 0.3)];
/// Centre of the sphere of the trial.
const CENTRE: DVec3 = DVec3::new(0.3, 0.2, 1.5);
const RADIUS: f64 = 1.0;

/// Cells per coordinate.
const GRID: [usize; 2] = [3, 2];

/// A shape with two coordinates in [0, 1] whose coordinate lines are straight or equally spaced in
/// solid angle.
struct Shape {
    emitter: Emitter,
    /// Returns the coordinates of a point.
    place: fn(DVec3) -> [f64; 2],
    /// Returns the point with these coordinates; `None` if cells have equal solid angles.
    point: Option<fn([f64; 2]) -> DVec3>,
    /// Closed forms: solid angle, and irradiance per radiance of a receiver with normal z.
    solid_angle: f64,
    irradiance: f64,
}

fn on_rectangle([u, v]: [f64; 2]) -> DVec3 {
    CORNER + u * EDGES[0] + v * EDGES[1]
}

/// Maps coordinates to a point: strips of equal area, each divided evenly.
fn on_triangle([s, share]: [f64; 2]) -> DVec3 {
    let rest = (1.0 - s).sqrt();
    triangle_point(TRIANGLE, 1.0 - rest, share * rest)
}

fn rectangle() -> Shape {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(on_rectangle);
    let shape = EmitterShape::Rectangle {
        corner: CORNER,
        edges: EDGES,
    };
    Shape {
        emitter: Emitter::new(shape, DVec3::ONE),
        place: |p| EDGES.map(|edge| edge.dot(p - CORNER) / edge.length_squared()),
        point: Some(on_rectangle),
        solid_angle: excess(&corners),
        irradiance: polygon_irradiance(&corners),
    }
}

fn triangle() -> Shape {
    Shape {
        emitter: Emitter::new(EmitterShape::Triangle(TRIANGLE), DVec3::ONE),
        place: |p| {
            let [a, b, c] = TRIANGLE;
            let normal = (b - a).cross(c - a);
            let share = |edge: DVec3| edge.cross(p - a).dot(normal) / normal.length_squared();
            let (u, v) = (-share(c - a), share(b - a));
            let rest = 1.0 - u;
            [1.0 - rest * rest, v / rest]
        },
        point: Some(on_triangle),
        solid_angle: excess(&TRIANGLE),
        irradiance: polygon_irradiance(&TRIANGLE),
    }
}

fn sphere() -> Shape {
    let distance = CENTRE.length();
    let cosine = (RADIUS / distance).asin().cos();
    Shape {
        emitter: Emitter::new(
            EmitterShape::Sphere(Sphere::new(CENTRE, RADIUS)),
            DVec3::ONE,
        ),
        place: |p| {
            let local = Frame::new(CENTRE.normalize()).local(p.normalize());
            let cosine = (RADIUS / CENTRE.length()).asin().cos();
            [(1.0 - local.z) / (1.0 - cosine), azimuth(local) / TAU]
        },
        point: None,
        solid_angle: TAU * (1.0 - cosine),
        irradiance: sphere_irradiance(RADIUS, distance, CENTRE.z / distance),
    }
}

/// Returns the probabilities of the cells, each its fraction of the solid angle.
fn masses(shape: &Shape) -> Vec<f64> {
    let [rows, columns] = GRID;
    let share = |i: usize, n: usize| i as f64 / n as f64;
    let cell = |k: usize| {
        let Some(point) = shape.point else {
            return 1.0 / (rows * columns) as f64;
        };
        let [i, j] = [k / columns, k % columns];
        let (u, v) = (
            [i, i + 1].map(|i| share(i, rows)),
            [j, j + 1].map(|j| share(j, columns)),
        );
        let mut outline: Vec<DVec3> = [[u[0], v[0]], [u[1], v[0]], [u[1], v[1]], [u[0], v[1]]]
            .map(point)
            .to_vec();
        // At a triangle's vertex two corners of a cell coincide.
        outline.dedup();
        excess(&outline) / shape.solid_angle
    };
    (0..rows * columns).map(cell).collect()
}

const SAMPLES: u64 = 3_050_000;
/// Relative δ of the mean cosine.
const DELTA: f64 = 0.003;

/// Tests the cells, the mean cosine and the pdf of a shape seen from the origin.
fn seen(context: &Context, subject: Sample, shape: &Shape) -> Vec<Outcome> {
    let mut rng = context.rng("directions");
    let [rows, columns] = GRID;
    let mut counts = Counts {
        n: context.n(SAMPLES),
        observed: vec![0; rows * columns],
        ..Counts::default()
    };
    let expected = shape.irradiance / shape.solid_angle;
    let mut cosines = Values::new(expected);
    let mut worst = 0.0_f64;
    for _ in 0..counts.n {
        let Some((light, pdf)) = subject(&shape.emitter, DVec3::ZERO, uniform2(&mut rng)) else {
            counts.lost += 1;
            continue;
        };
        let [u, v] = (shape.place)(light.point);
        let index = |x: f64, n: usize| ((x * n as f64).max(0.0) as usize).min(n - 1);
        counts.observed[index(u, rows) * columns + index(v, columns)] += 1;
        cosines.push(light.point.normalize().z);
        worst = worst.max((pdf * shape.solid_angle - 1.0).abs());
    }
    let places =
        (0..rows * columns).map(|k| format!("row {}, column {}", k / columns, k % columns));
    let partition = Partition::from_masses(masses(shape), places.collect());
    let claim = Claim::Equal {
        delta: DELTA * expected,
    };
    vec![
        chi_square("cells of the solid angle", &partition, &counts, CELL_DELTA),
        mean("mean cosine", &cosines, expected, claim),
        Outcome::identity(
            "pdf",
            counts.n,
            worst,
            1e-12,
            "pdf times solid angle, less one",
        ),
    ]
}

fn trials() -> Vec<FamilyTrial<Sample>> {
    let family_trial =
        |name: &str, what: &str, equation: &'static Equation, subject, shape: fn() -> Shape| {
            trial(
                format!("emitter/{name}"),
                format!("directions to {what} are uniform in its solid angle"),
                format!("soft shadows lean to one side where {what} that gives light is near"),
                equation,
                subject,
                "chi-square, t",
                move |context: &Context, subject| seen(context, subject, &shape()),
            )
        };
    vec![
        family_trial(
            "seen-rectangle",
            "a rectangle",
            &LIGHT_RECTANGLE,
            "geometry::solid_angle::SphericalRectangle",
            rectangle,
        ),
        family_trial(
            "seen-triangle",
            "a triangle",
            &LIGHT_TRIANGLE,
            "geometry::solid_angle::SphericalTriangle",
            triangle,
        ),
        family_trial(
            "seen-sphere",
            "a sphere",
            &LIGHT_SPHERE,
            "geometry::solid_angle::VisibleCap",
            sphere,
        ),
    ]
}

/// Samples points uniform in area, with the pdf of directions uniform in solid angle.
pub fn uniform_in_area(
    emitter: &Emitter,
    from: DVec3,
    random: [f64; 2],
) -> Option<(EmitterPoint, f64)> {
    Some((emitter.sample(random), emitter.pdf_solid_angle(from)?))
}

/// Samples the correct points with another pdf.
pub fn with_pdf(
    emitter: &Emitter,
    from: DVec3,
    random: [f64; 2],
    pdf: impl Fn(f64) -> f64,
) -> Option<(EmitterPoint, f64)> {
    let (light, right) = emitter.sample_solid_angle(from, random)?;
    Some((light, pdf(right)))
}

/// Samples the cone of a sphere uniformly in the angle θ instead of in solid angle.
fn linear_in_angle(
    emitter: &Emitter,
    from: DVec3,
    [r1, r2]: [f64; 2],
) -> Option<(EmitterPoint, f64)> {
    let pdf = emitter.pdf_solid_angle(from)?;
    let lost = 1.0 / (TAU * pdf);
    let angle = r1 * (1.0 - lost).acos();
    emitter.sample_solid_angle(from, [(1.0 - angle.cos()) / lost, r2])
}

fn faults() -> Vec<Fault<Sample>> {
    vec![
        fault!("area-for-solid-angle", LIGHT_RECTANGLE, "points uniform in area, said to be uniform in solid angle",
            = uniform_in_area,
            "emitter/seen-rectangle: cells of the solid angle | mean cosine",
            "emitter/seen-triangle: cells of the solid angle | mean cosine",
            "emitter/seen-sphere: cells of the solid angle | mean cosine"),
        fault!("half-angle-for-angle", SOLID_ANGLE, "the factor 2 of the half-angle is missing in the solid angle",
            = |emitter, from, random| with_pdf(emitter, from, random, |pdf| 2.0 * pdf),
            "emitter/seen-triangle: pdf"),
        fault!("excess-from-the-wrong-side", SOLID_ANGLE,
            "the solid angle of all directions that miss the shape: the sign of the excess is wrong",
            = |emitter, from, random| with_pdf(emitter, from, random, |pdf| 1.0 / (2.0 * TAU - 1.0 / pdf)),
            "emitter/seen-triangle: pdf", "emitter/seen-rectangle: pdf"),
        fault!("no-arc", LIGHT_TRIANGLE, "uniform along the arc from B, not in one minus its cosine",
            = |emitter, from, [r1, r2]| emitter.sample_solid_angle(from, [r1, r2 * r2]),
            "emitter/seen-triangle: cells of the solid angle"),
        fault!("one-number-seen", LIGHT_RECTANGLE, "one random number for both coordinates",
            = |emitter, from, [r, _]| emitter.sample_solid_angle(from, [r, r]),
            "emitter/seen-rectangle: cells of the solid angle"),
        fault!("linear-in-angle", LIGHT_SPHERE, "the angle from the axis is uniform: directions crowd at the middle",
            = linear_in_angle, "emitter/seen-sphere: mean cosine"),
        fault!("tangent-for-sine", LIGHT_SPHERE, "tan θ = R/d for sin θ = R/d: the cone does not touch the sphere",
            = |emitter, from, random| with_pdf(emitter, from, random, |pdf| {
                let cosine = 1.0 - 1.0 / (TAU * pdf);
                let sine = (1.0 - cosine * cosine).sqrt();
                1.0 / (TAU * (1.0 - sine.atan().cos()))
            }),
            "emitter/seen-sphere: pdf"),
    ]
}

/// Trials and faults of emitters sampled by solid angle.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    vec![Box::new(Family {
        trials: trials(),
        faults: faults(),
        equivalents: vec![
            fault!("mirrored-numbers", LIGHT_SPHERE, "1 − r for r: as uniform as r",
            = |emitter, from, [r1, r2]| emitter.sample_solid_angle(from, [1.0 - r1, 1.0 - r2]),
            "emitter/seen-sphere"),
        ],
        ..Family::new("solid-angle", Emitter::sample_solid_angle as Sample)
    })]
}
