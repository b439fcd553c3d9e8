//! Trials of form factors: closed forms, closure, reciprocity, and the flux that they transfer.

use whitefurnace::integrator::radiosity::{Element, FormFactors, Mesh, Patch};
use whitefurnace::scene::simple::closed_cube;

use crate::prelude::*;
use crate::radiosity::{SINGLE_PRECISION, resolution, solve};
use crate::scenes::{self, LIGHT, lambert, panel, scene, square};

/// An error, ideally 0, of the elements of a mesh and their rows of form factors.
type Error = fn(&[Element], &[Vec<f64>]) -> f64;

/// Computes the form factors of a mesh and an error of them.
struct Factors {
    scene: Arc<Scene>,
    patches: u32,
    error: Error,
    tolerance: f64,
}

impl Property for Factors {
    fn run(&self, _: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let error = || {
            let mesh = Mesh::new(&self.scene, resolution(self.patches)).ok()?;
            let factors = FormFactors::new(setup.parts, &self.scene, &mesh, &|_| true).ok()?;
            let elements = mesh.elements();
            let rows: Vec<_> = (0..elements.len())
                .map(|i| factors.of_element(&mesh, i))
                .collect();
            Some((self.error)(elements, &rows))
        };
        let error = error().unwrap_or(f64::NAN);
        let n = u64::from(self.patches);
        vec![Outcome::identity(
            "form factors",
            n,
            error,
            self.tolerance,
            "all patches",
        )]
    }
}

/// Albedos of two unit plates, by which their patches can be told apart.
const PLATES: [f64; 2] = [0.25, 0.75];

fn plates(name: &str, second: DVec3, edges: [DVec3; 2]) -> Arc<Scene> {
    scene(name, |s| {
        let [a, b] = PLATES.map(|albedo| Surface::new(lambert(albedo)));
        panel(s, DVec3::ZERO, [DVec3::X, DVec3::Y], a);
        panel(s, second, edges, b);
    })
}

/// Sum of A F from the elements of one albedo to those of another.
fn exchange(elements: &[Element], rows: &[Vec<f64>], from: f64, to: f64) -> f64 {
    let pairs = elements
        .iter()
        .zip(rows)
        .filter(|(element, _)| element.albedo.x == from);
    pairs
        .map(|(element, row)| {
            let there = elements
                .iter()
                .zip(row)
                .filter(|(element, _)| element.albedo.x == to);
            element.area * there.map(|(_, f)| f).sum::<f64>()
        })
        .sum()
}

/// Relative error of F from the first plate, whose area is 1, to the second, against a closed form.
fn between_plates(elements: &[Element], rows: &[Vec<f64>], reference: f64) -> f64 {
    exchange(elements, rows, PLATES[0], PLATES[1]) / reference - 1.0
}

/// Form factor between opposite faces of a cube.
pub const OPPOSITE: f64 = 0.199_824_895_698_387_4;
/// Form factor between neighbouring faces of a cube: (1 − [`OPPOSITE`])/4.
pub const NEIGHBOURS: f64 = 0.200_043_776_075_403_1;

/// Returns whether an element of a room around the origin faces it.
fn faces_inside(element: &Element) -> bool {
    let point = match element.patch {
        Patch::Flat { polygon, .. } => polygon.centroid(),
        Patch::Curved(_) => return false,
    };
    element.patch.normal(point).dot(point) < 0.0
}

/// Largest error of the row sums of a closed cube, which are 1 inside and 0 outside.
fn closure(elements: &[Element], rows: &[Vec<f64>]) -> f64 {
    let error = |(element, row): (&Element, &Vec<f64>)| {
        let expected = f64::from(u8::from(faces_inside(element)));
        (row.iter().sum::<f64>() - expected).abs()
    };
    elements.iter().zip(rows).map(error).fold(0.0, f64::max)
}

/// Albedos by which [`ball_in_room`] tells its two kinds of surfaces apart.
const ROOM: f64 = 0.25;
const BALL: f64 = 0.75;

/// Builds a ball in a cube, far from its middle and near to its walls.
fn ball_in_room() -> Arc<Scene> {
    scene("ball in a room", |s| {
        let wall = s.surface(Surface::new(lambert(ROOM)));
        closed_cube(s, 1.0, true, wall);
        scenes::ball(
            s,
            Sphere::new(DVec3::new(0.5, 0.45, -0.4), RADIUS),
            Surface::new(lambert(BALL)),
        );
    })
}

const RADIUS: f64 = 0.4;

/// Error of a ball that sees nothing but the room: A F to the room and A F from it are both its own
/// area 4πR², and so is the area of its patches.
fn ball(elements: &[Element], rows: &[Vec<f64>]) -> f64 {
    let expected = 4.0 * PI * RADIUS * RADIUS;
    let off = |(from, to)| (exchange(elements, rows, from, to) / expected - 1.0).abs();
    [(BALL, ROOM), (ROOM, BALL)]
        .map(off)
        .into_iter()
        .fold(0.0, f64::max)
}

/// Reciprocity error Σ |A_i F_ij − A_j F_ji| over all pairs, relative to Σ A_i F_ij.
fn reciprocity(elements: &[Element], rows: &[Vec<f64>]) -> f64 {
    let (mut difference, mut sum) = (0.0, 0.0);
    for (i, row) in rows.iter().enumerate() {
        for (j, factor) in row.iter().enumerate() {
            difference += (elements[i].area * factor - elements[j].area * rows[j][i]).abs();
            sum += elements[i].area * factor;
        }
    }
    difference / sum
}

/// Compares the irradiances of all walls of a cube, of one albedo and with one emitting wall, with
/// the emitted flux over 1 − ρ.
pub(super) struct Energy;

impl Property for Energy {
    fn run(&self, _: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let rho = 0.6;
        let room = scene("cube with a wall of light", |s| {
            let wall = s.surface(Surface::new(lambert(rho)));
            closed_cube(s, 1.0, true, wall);
            let lit = Surface::new(lambert(rho)).emitting(DVec3::splat(LIGHT));
            // Just in front of a wall, which then receives no light.
            square(s, DVec3::new(0.0, 0.0, 1.0 - 1e-9), 1.0, false, lit);
        });
        let flux = 4.0 * PI * LIGHT;
        let found = solve(setup, &room, 300).map(|solved| {
            let each = solved.irradiances();
            each.map(|(element, e)| element.area * e.x).sum::<f64>()
        });
        let error = found.map_or(f64::NAN, |found| found / (flux / (1.0 - rho)) - 1.0);
        vec![Outcome::identity(
            "flux",
            1,
            error,
            BOUNCES_DELTA,
            "all patches",
        )]
    }
}

pub(super) fn factors() -> Vec<FamilyTrial<EstimatorSubject>> {
    let cube = scene("closed cube", |s| {
        let wall = s.surface(Surface::new(lambert(0.5)));
        closed_cube(s, 1.0, true, wall);
    });
    let parallel = plates("parallel plates", DVec3::Z, [DVec3::Y, DVec3::X]);
    let perpendicular = plates("perpendicular plates", DVec3::ZERO, [DVec3::Y, DVec3::Z]);
    let of = |name: &str, property: String, consequence: &str, scene, patches, error, tolerance| {
        let factors = Factors {
            scene,
            patches,
            error,
            tolerance,
        };
        trial(
            name,
            property,
            consequence,
            &FORM_FACTOR,
            "integrator::radiosity::FormFactors",
            "exact",
            with_parts(factors),
        )
    };
    vec![
        of(
            "radiosity/parallel-plates",
            format!("between parallel unit plates at distance 1 F = {OPPOSITE:.6}"),
            "floor and ceiling exchange too much or too little light by radiosity",
            parallel,
            64,
            |elements, rows| between_plates(elements, rows, OPPOSITE),
            1e-4,
        ),
        of(
            "radiosity/perpendicular-plates",
            format!("between unit plates at a right angle with a common edge F = {NEIGHBOURS:.6}"),
            "walls that meet in a corner exchange too much or too little light by radiosity",
            perpendicular,
            400,
            |elements, rows| between_plates(elements, rows, NEIGHBOURS),
            CLOSED_FORM_DELTA,
        ),
        of(
            "radiosity/closure",
            "in a closed cube the form factors from each patch add up to 1".to_owned(),
            "radiosity loses light in a closed room, or makes it",
            Arc::clone(&cube),
            100,
            closure,
            SINGLE_PRECISION,
        ),
        of(
            "radiosity/ball",
            "A F from a ball to the room around it, and back, is the area of the ball".to_owned(),
            "balls in a room give and get too much or too little light by radiosity",
            ball_in_room(),
            300,
            ball,
            IMAGE_DELTA,
        ),
        of(
            "radiosity/reciprocity",
            "in a closed cube A_i F_ij = A_j F_ji, up to the mean over three nodes".to_owned(),
            "light is lost between walls by radiosity: one gives what the other does not get",
            cube,
            400,
            reciprocity,
            0.02,
        ),
    ]
}
