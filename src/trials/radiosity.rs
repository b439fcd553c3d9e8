//! Radiosity on trial: form factors against closed forms, furnaces, hidden light, and the path tracer.

use std::f64::consts::{FRAC_1_PI, PI};
use std::sync::Arc;

use glam::DVec3;

use super::furnace::off_cap;
use super::images::{Channel, film};
use super::probes::{BOUNCES, IMAGE, SINGLE, any_direction};
use super::scenes::{
    FLOOR, HEIGHT, LIGHT, RECTANGLE, at_origin, corners, floor, half_hidden_light, lambert, light,
    polygon_irradiance, rectangle_light, scene, square,
};
use super::subject::{Property, RIGHT, STANDARD, Setup, Subject, Table, on, parts};
use crate::equation::{Equation, FORM_FACTOR, RADIOSITY};
use crate::estimator::radiosity::{Element, Fineness, FormFactors, Mesh, RESIDUAL};
use crate::estimator::{Estimator, Parts, Path, Radiosity, Standard, radiosity};
use crate::form_factor;
use crate::harness::outcome::Outcome;
use crate::harness::trial::Context;
use crate::harness::welch_map::image_mean;
use crate::rng::Stream;
use crate::scene::room::diffuse;
use crate::scene::simple::{CAP_SHARE, Cap, cavity_cap, closed_cube, furnace_box};
use crate::scene::{Scene, Surface};
use crate::shape::Ray;
use crate::zoo::{AnyFamily, Bench, Family, Mutant, data, mutant};

/// Form factors are kept in single precision.
const SINGLE_PRECISION: f64 = 1e-6;
/// Albedo of furnaces and cavities.
const ALBEDO: f64 = 0.75;
/// How far the radiance in them can be off: a residual r leaves an error of at most r/(1 − ρ).
const SETTLED: f64 = RESIDUAL / (1.0 - ALBEDO) + SINGLE_PRECISION;

fn fineness(patches: u32) -> Fineness {
    Fineness {
        patches,
        halvings: 0,
    }
}

fn solve<P: Parts + Copy>(setup: Setup<P>, scene: &Scene, patches: u32) -> Option<Radiosity<P>> {
    Radiosity::new(setup.parts, scene, fineness(patches), &|_| true).ok()
}

/// A kind of ray with its radiance.
type KnownRay = (fn(&mut Stream) -> Ray, f64);

/// A radiance that is known along every ray of a kind: the largest relative deviation.
struct Known {
    scene: Arc<Scene>,
    patches: u32,
    /// Each kind of ray with its radiance.
    rays: Vec<KnownRay>,
    tolerance: f64,
}

const RAYS: u64 = 50;

impl Property for Known {
    fn run<P: Parts + Copy>(&self, context: &Context, setup: Setup<P>) -> Vec<Outcome> {
        let mut rng = context.rng("rays");
        let solved = solve(setup, &self.scene, self.patches);
        let mut deviation = |&(ray, reference): &KnownRay| {
            let Some(solved) = &solved else {
                return f64::NAN;
            };
            let largest = (0..RAYS).map(|_| {
                let ray = ray(&mut rng);
                let hit = self.scene.intersect(&ray);
                let found = solved.radiance(&self.scene, &ray, hit, &mut rng).x;
                let scale = if reference == 0.0 { 1.0 } else { reference };
                (found - reference).abs() / scale
            });
            // Unlike the maximum of numbers, this keeps NaN.
            largest.fold(0.0, |a: f64, b| if b > a || b.is_nan() { b } else { a })
        };
        let error = self.rays.iter().map(&mut deviation).sum();
        vec![Outcome::exact(
            "radiance",
            RAYS,
            error,
            self.tolerance,
            "the worst ray",
        )]
    }
}

/// What is asked of the form factors of a mesh: a number that should be 0.
struct Factors {
    scene: Arc<Scene>,
    patches: u32,
    error: fn(&[Element], &[Vec<f64>]) -> f64,
    tolerance: f64,
}

impl Property for Factors {
    fn run<P: Parts + Copy>(&self, _: &Context, setup: Setup<P>) -> Vec<Outcome> {
        let error = || {
            let mesh = Mesh::new(&self.scene, fineness(self.patches)).ok()?;
            let factors = FormFactors::new(&setup.parts, &self.scene, &mesh, &|_| true).ok()?;
            let elements = mesh.elements();
            let rows: Vec<_> = (0..elements.len())
                .map(|i| factors.of_element(&mesh, i))
                .collect();
            Some((self.error)(elements, &rows))
        };
        let error = error().unwrap_or(f64::NAN);
        let n = u64::from(self.patches);
        vec![Outcome::exact(
            "form factors",
            n,
            error,
            self.tolerance,
            "all patches",
        )]
    }
}

/// Unit plates of different albedo, so that their patches can be told apart.
const PLATES: [f64; 2] = [0.25, 0.75];

fn plates(name: &str, second: DVec3, edges: [DVec3; 2]) -> Arc<Scene> {
    scene(name, |s| {
        let [a, b] = PLATES.map(|albedo| s.surface(Surface::new(lambert(albedo))));
        s.rectangle(DVec3::ZERO, [DVec3::X, DVec3::Y], a);
        s.rectangle(second, edges, b);
    })
}

/// F from the first plate to the second, less a closed form, relative to it.
fn between_plates(elements: &[Element], rows: &[Vec<f64>], reference: f64) -> f64 {
    let of = |plate: usize| move |element: &Element| element.albedo.x == PLATES[plate];
    let mut sum = 0.0;
    for (from, row) in elements.iter().zip(rows).filter(|(e, _)| of(0)(e)) {
        let pairs = elements.iter().zip(row);
        let to_second: f64 = pairs.filter(|(e, _)| of(1)(e)).map(|(_, f)| f).sum();
        // The plate's area is 1.
        sum += from.area * to_second;
    }
    sum / reference - 1.0
}

/// F between opposite faces of a cube.
pub const OPPOSITE: f64 = 0.199_824_895_698_387_4;
/// F between neighbouring faces of a cube: (1 − [`OPPOSITE`])/4.
pub const NEIGHBOURS: f64 = 0.200_043_776_075_403_1;

/// How far the row sums of a closed cube's inside are from 1; the outside sees nothing.
fn closure(_: &[Element], rows: &[Vec<f64>]) -> f64 {
    let sums = rows.iter().map(|row| row.iter().sum::<f64>());
    let errors: Vec<f64> = sums
        .filter(|&sum| sum != 0.0)
        .map(|sum| (sum - 1.0).abs())
        .collect();
    // Half of the sides are inside.
    if 2 * errors.len() == rows.len() {
        errors.into_iter().fold(0.0, f64::max)
    } else {
        f64::NAN
    }
}

/// Σ |A_i F_ij − A_j F_ji| over all pairs, relative to Σ A_i F_ij.
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

/// In a cube of one albedo of which one wall emits, the irradiances of all walls add up to the emitted
/// flux over 1 − ρ.
struct Energy;

impl Property for Energy {
    fn run<P: Parts + Copy>(&self, _: &Context, setup: Setup<P>) -> Vec<Outcome> {
        let rho = 0.6;
        let room = scene("cube with a wall of light", |s| {
            let wall = s.surface(Surface::new(lambert(rho)));
            closed_cube(s, 1.0, true, wall);
            let lit = Surface::new(lambert(rho)).emitting(DVec3::splat(LIGHT));
            // Just before a wall, which gets no light any more.
            square(s, DVec3::new(0.0, 0.0, 1.0 - 1e-9), 1.0, false, lit);
        });
        let flux = 4.0 * PI * LIGHT;
        let found = solve(setup, &room, 300).map(|solved| {
            let each = solved.irradiances();
            each.map(|(element, e)| element.area * e.x).sum::<f64>()
        });
        let error = found.map_or(f64::NAN, |found| found / (flux / (1.0 - rho)) - 1.0);
        vec![Outcome::exact("flux", 1, error, BOUNCES, "all patches")]
    }
}

/// The path tracer and radiosity in the all-diffuse room.
struct SameRoom {
    scene: Arc<Scene>,
}

const SIZE: [u32; 2] = [40, 30];
const REPLICATIONS: u64 = 400;
const PATCHES: u32 = 500;

impl Property for SameRoom {
    fn run<P: Parts + Copy>(&self, context: &Context, setup: Setup<P>) -> Vec<Outcome> {
        let n = context.n(REPLICATIONS) as u32;
        let films = || {
            let solved = solve(setup, &self.scene, PATCHES)?;
            // Every replication is the same: two are enough to say so.
            let a = film(context, "radiosity", (&*self.scene, SIZE, 0..2), &solved)?;
            let paths = Path::<Standard>::default();
            let b = film(context, "paths", (&*self.scene, SIZE, 0..n), &paths)?;
            Some([a, b].map(|film| Channel::new(&film)))
        };
        match films() {
            Some([a, b]) => vec![image_mean(
                "image mean",
                &a.statistics(),
                &b.statistics(),
                IMAGE,
            )],
            None => vec![Outcome::exact("film", 0, f64::NAN, 0.0, "no solution")],
        }
    }
}

fn known(
    name: &str,
    property: impl Into<String>,
    equation: &'static Equation,
    known: Known,
) -> Bench<Subject> {
    let size = (RAYS, known.tolerance, 0);
    let subject = "estimator::Radiosity";
    Bench::new(
        data(name, property, equation, subject, "exact", size),
        on(known),
    )
}

fn furnaces() -> Vec<Bench<Subject>> {
    let rho = ALBEDO;
    let inside = |rng: &mut Stream| Ray::new(DVec3::new(0.1, 0.2, -0.3), any_direction(rng));
    let cap = |cap, reference| {
        cavity_cap(rho, cap).ok().map(|scene| Known {
            scene: scene.into(),
            patches: 100,
            rays: vec![(off_cap as fn(&mut Stream) -> Ray, reference)],
            tolerance: SETTLED,
        })
    };
    let reflecting = rho * CAP_SHARE / (1.0 - rho);
    let black = rho * CAP_SHARE / (1.0 - rho * (1.0 - CAP_SHARE));
    let nested = scene("box in a dark box", |s| {
        let wall = s.surface(Surface::new(lambert(rho)).emitting(DVec3::ONE));
        closed_cube(s, 1.0, true, wall);
        let dark = s.surface(Surface::new(lambert(rho)));
        closed_cube(s, 2.0, true, dark);
    });
    let furnace = furnace_box(rho).ok().map(|scene| Known {
        scene: scene.into(),
        patches: 60,
        rays: vec![(inside, 4.0)],
        tolerance: SETTLED,
    });
    let nested = Known {
        scene: nested,
        patches: 150,
        rays: vec![
            (inside, 4.0),
            (
                |rng| Ray::new(DVec3::new(1.5, 1.4, -1.6), any_direction(rng)),
                0.0,
            ),
        ],
        tolerance: SETTLED,
    };
    let name = |cap| format!("radiosity/cavity/{cap}");
    [
        furnace.map(|f| {
            let property = "in a closed furnace box of albedo 0.75 the radiance is 4";
            known("radiosity/furnace-box", property, &RADIOSITY, f)
        }),
        cap(Cap::Reflecting, reflecting).map(|f| {
            let property = format!("off a reflecting cap the radiance in a cavity is {reflecting}");
            known(&name("reflecting"), property, &RADIOSITY, f)
        }),
        cap(Cap::Black, black).map(|f| {
            let property = format!("off a black cap the radiance in a cavity is {black:.6}");
            known(&name("black"), property, &RADIOSITY, f)
        }),
        Some(known(
            "radiosity/nested",
            "a furnace box in a dark box shows 4 inside and nothing outside",
            &RADIOSITY,
            nested,
        )),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Direct light on a floor.
fn floors() -> Vec<Bench<Subject>> {
    let [a, b, ..] = RECTANGLE;
    let half = [a, b, b.with_y(0.0), a.with_y(0.0)];
    let upright = scene("light that sinks below the horizon", |s| {
        floor(s, lambert(FLOOR));
        let lit = s.surface(light(LIGHT));
        s.rectangle(
            DVec3::new(1.0, -1.0, -1.0),
            [2.0 * DVec3::Z, 2.0 * DVec3::Y],
            lit,
        );
    });
    let risen =
        [[-1.0, 0.0], [1.0, 0.0], [1.0, 1.0], [-1.0, 1.0]].map(|[y, z]| DVec3::new(1.0, y, z));
    let bench = |name, what: &str, scene, irradiance: f64, tolerance| {
        let reference = FLOOR * FRAC_1_PI * LIGHT * irradiance;
        let property = format!("a floor reflects {reference:.6} of {what}");
        let rays: Vec<KnownRay> = vec![(|_| at_origin(), reference)];
        let subject = Known {
            scene,
            patches: 4,
            rays,
            tolerance,
        };
        known(name, property, &FORM_FACTOR, subject)
    };
    vec![
        bench(
            "radiosity/rectangle",
            "a square light's radiance",
            rectangle_light(false),
            polygon_irradiance(&corners(HEIGHT * DVec3::Z, 1.0)),
            SINGLE_PRECISION,
        ),
        bench(
            "radiosity/half-hidden",
            "a square light that a wall hides by half",
            half_hidden_light(),
            polygon_irradiance(&half),
            IMAGE,
        ),
        bench(
            "radiosity/horizon",
            "an upright light of which half is below the horizon",
            upright,
            polygon_irradiance(&risen),
            SINGLE_PRECISION,
        ),
    ]
}

fn factors() -> Vec<Bench<Subject>> {
    let cube = scene("closed cube", |s| {
        let wall = s.surface(Surface::new(lambert(0.5)));
        closed_cube(s, 1.0, true, wall);
    });
    let parallel = plates("parallel plates", DVec3::Z, [DVec3::Y, DVec3::X]);
    let perpendicular = plates("perpendicular plates", DVec3::ZERO, [DVec3::Y, DVec3::Z]);
    let bench = |name: &str, property: String, subject: Factors| {
        let size = (u64::from(subject.patches), subject.tolerance, 0);
        let path = "estimator::radiosity::FormFactors";
        let trial = data(name, property, &FORM_FACTOR, path, "exact", size);
        Bench::new(trial, on(subject))
    };
    vec![
        bench(
            "radiosity/parallel-plates",
            format!("between parallel unit plates at distance 1 F = {OPPOSITE:.6}"),
            Factors {
                scene: parallel,
                patches: 64,
                error: |elements, rows| between_plates(elements, rows, OPPOSITE),
                tolerance: 1e-4,
            },
        ),
        bench(
            "radiosity/perpendicular-plates",
            format!("between unit plates at a right angle with a common edge F = {NEIGHBOURS:.6}"),
            Factors {
                scene: perpendicular,
                patches: 400,
                error: |elements, rows| between_plates(elements, rows, NEIGHBOURS),
                tolerance: SINGLE,
            },
        ),
        bench(
            "radiosity/closure",
            "in a closed cube the form factors from each patch add up to 1".to_owned(),
            Factors {
                scene: Arc::clone(&cube),
                patches: 100,
                error: closure,
                tolerance: SINGLE_PRECISION,
            },
        ),
        bench(
            "radiosity/reciprocity",
            "in a closed cube A_i F_ij = A_j F_ji, but for the mean over three nodes".to_owned(),
            Factors {
                scene: cube,
                patches: 400,
                error: reciprocity,
                tolerance: 0.02,
            },
        ),
    ]
}

fn rooms() -> Vec<Bench<Subject>> {
    let subject = "estimator::Radiosity";
    let energy = Bench::new(
        data(
            "radiosity/energy",
            "in a cube with a wall of light all walls together receive the flux over 1 − ρ",
            &RADIOSITY,
            subject,
            "exact",
            (300, BOUNCES, 0),
        ),
        on(Energy),
    );
    let pixels = u64::from(SIZE[0] * SIZE[1]) * REPLICATIONS;
    let same = diffuse().ok().map(|room| {
        let trial = data(
            "radiosity/diffuse-room",
            "radiosity and the path tracer make the same image of the diffuse room",
            &RADIOSITY,
            subject,
            "Welch, equivalence",
            (pixels, IMAGE, 1),
        );
        Bench::new(
            trial,
            on(SameRoom {
                scene: Arc::new(room),
            }),
        )
    });
    std::iter::once(energy).chain(same).collect()
}

/// Radiosity as a whole.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    let mut benches = furnaces();
    benches.extend(floors());
    benches.extend(factors());
    benches.extend(rooms());
    vec![Box::new(Family {
        whole_estimator: true,
        benches,
        faults: faults(),
        ..Family::new("radiosity", STANDARD)
    })]
}

/// F towards the middle of a polygon for a surface that faces it: the receiver's cosine is gone.
fn without_cosine(_: DVec3, corners: &[DVec3]) -> f64 {
    let middle: DVec3 = corners.iter().sum();
    form_factor::polygon(middle.normalize_or_zero(), corners)
}

fn faults() -> Vec<Mutant<Subject>> {
    let factor = |name, wrong, form_factor: fn(DVec3, &[DVec3]) -> f64, caught_by| {
        let table = Table {
            form_factor,
            ..RIGHT
        };
        mutant(name, &FORM_FACTOR, wrong, parts(table), caught_by)
    };
    let balance = |name, wrong, table: Table, caught_by| {
        mutant(name, &RADIOSITY, wrong, parts(table), caught_by)
    };
    vec![
        factor(
            "form-factor-without-cosine",
            "the cosine at the receiver is missing",
            without_cosine,
            &[
                "radiosity/horizon",
                "radiosity/closure",
                "radiosity/parallel-plates",
            ],
        ),
        factor(
            "form-factor-orientation",
            "the edges run the wrong way: fronts are taken for backs",
            |normal, corners| -form_factor::polygon(normal, corners),
            &["radiosity/rectangle", "radiosity/closure"],
        ),
        factor(
            "form-factor-doubled",
            "1/π for 1/2π",
            |normal, corners| 2.0 * form_factor::polygon(normal, corners),
            &[
                "radiosity/parallel-plates",
                "radiosity/perpendicular-plates",
            ],
        ),
        factor(
            "form-factor-open",
            "the edge from the last corner to the first is left out",
            |normal, corners| {
                let pairs = corners.windows(2);
                let edge = |pair: &[DVec3]| {
                    let across = pair[0].cross(pair[1]);
                    pair[0].angle_between(pair[1]) * across.normalize_or_zero().dot(normal)
                };
                pairs.map(edge).sum::<f64>() * -0.5 * FRAC_1_PI
            },
            &["radiosity/reciprocity", "radiosity/perpendicular-plates"],
        ),
        mutant(
            "horizon-not-cut",
            &FORM_FACTOR,
            "the part of a polygon below the horizon counts, negatively",
            parts(Table {
                horizon: |_, polygon| *polygon,
                ..RIGHT
            }),
            &["radiosity/horizon"],
        ),
        mutant(
            "hidden-patches-seen",
            &FORM_FACTOR,
            "nothing hides anything",
            parts(Table {
                visible: |_, _, _, _| true,
                ..RIGHT
            }),
            &["radiosity/half-hidden", "radiosity/nested"],
        ),
        mutant(
            "sphere-cosine-missing",
            &FORM_FACTOR,
            "the cosines between parts of a sphere are 1",
            parts(Table {
                cosine: |_, _| 1.0,
                ..RIGHT
            }),
            &["radiosity/cavity/reflecting"],
        ),
        balance(
            "emission-exchanged",
            "patches send each other what they emit, which was counted as direct light",
            Table {
                exchanged: |leaving, _| leaving,
                ..RIGHT
            },
            &["radiosity/furnace-box", "radiosity/energy"],
        ),
        balance(
            "emission-reflected",
            "the albedo is applied to what a surface emits, too",
            Table {
                leaving: |albedo, emitted, irradiance| {
                    radiosity::leaving(albedo, albedo * emitted, irradiance)
                },
                ..RIGHT
            },
            &["radiosity/furnace-box"],
        ),
        balance(
            "two-sweeps",
            "the solution ends after two sweeps",
            Table {
                solved: |_, sweeps| sweeps >= 2,
                ..RIGHT
            },
            &[
                "radiosity/furnace-box",
                "radiosity/cavity/black",
                "radiosity/diffuse-room",
            ],
        ),
        balance(
            "exitance-for-radiance",
            "ρE is taken for the radiance, without 1/π",
            Table {
                leaving: |albedo, emitted, irradiance| emitted + albedo * irradiance,
                ..RIGHT
            },
            &["radiosity/furnace-box", "radiosity/rectangle"],
        ),
    ]
}
