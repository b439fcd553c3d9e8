//! Radiosity on trial: form factors against closed forms, furnaces, hidden light, and the path tracer.

mod factors;
mod faults;

pub use factors::{NEIGHBOURS, OPPOSITE};

use std::f64::consts::FRAC_1_PI;
use std::sync::Arc;

use glam::DVec3;

use crate::equation::{Equation, FORM_FACTOR, RADIOSITY};
use crate::estimator::radiosity::{Fineness, RESIDUAL};
use crate::estimator::{Estimator, Parts, Path, Radiosity, Standard};
use crate::harness::outcome::Outcome;
use crate::harness::trial::Context;
use crate::harness::welch_map::image_mean;
use crate::rng::Stream;
use crate::scene::room::diffuse;
use crate::scene::simple::{CAP_SHARE, Cap, cavity_cap, closed_cube, furnace_box};
use crate::scene::{Scene, Surface};
use crate::shape::Ray;
use crate::trials::furnace::off_cap;
use crate::trials::images::{Channel, film};
use crate::trials::probes::{BOUNCES, IMAGE, any_direction};
use crate::trials::scenes::{
    FLOOR, HEIGHT, LIGHT, RECTANGLE, at_origin, corners, floor, half_hidden_light, lambert, light,
    polygon_irradiance, rectangle_light, scene,
};
use crate::trials::subject::{Property, STANDARD, Setup, Subject, on};
use crate::zoo::{AnyFamily, Bench, Family, data};

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
        on(factors::Energy),
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
    benches.extend(factors::factors());
    benches.extend(rooms());
    vec![Box::new(Family {
        whole_estimator: true,
        benches,
        faults: faults::faults(),
        ..Family::new("radiosity", STANDARD)
    })]
}
