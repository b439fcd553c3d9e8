//! Radiosity on trial: form factors against closed forms, furnaces, hidden light, and the path tracer.

mod factors;
mod faults;
mod fields;

pub use factors::{NEIGHBOURS, OPPOSITE};

use whitefurnace::estimator::Radiosity;
use whitefurnace::estimator::radiosity::{Fineness, RESIDUAL, ReadOut};
use whitefurnace::scene::room::diffuse;
use whitefurnace::scene::simple::{CAP_SHARE, Cap, cavity_cap, closed_cube, furnace_box};

use crate::furnace::off_cap;
use crate::images::{Levels, same_mean};
use crate::mean_radiance::any_direction;
use crate::prelude::*;
use crate::scenes::{lambert, scene};

/// Form factors are kept in single precision.
const SINGLE_PRECISION: f64 = 1e-6;
/// Albedo of furnaces and cavities.
const ALBEDO: f64 = 0.75;
/// Albedo of boxes within boxes: so low that light settles even if all of them see each other.
const NESTED: f64 = 0.3;
/// How far the radiance in them can be off: a residual r leaves an error of at most r/(1 − ρ).
const SETTLED: f64 = RESIDUAL / (1.0 - ALBEDO) + SINGLE_PRECISION;

fn fineness(patches: u32) -> Fineness {
    Fineness { patches, halvings: 0 }
}

fn solve<P: EstimatorParts + Copy>(setup: Configuration<P>, scene: &Scene, patches: u32) -> Option<Radiosity<P>> {
    Radiosity::new(setup.parts, scene, fineness(patches), &|_| true).ok()
}

/// A kind of ray.
type EstimatorKind = fn(&mut Stream) -> Ray;
/// A kind of ray with its radiance.
type KnownRay = (EstimatorKind, DVec3);

/// A radiance that is known along every ray of a kind: the largest relative deviation.
struct Known {
    scene: Arc<Scene>,
    patches: u32,
    /// Each kind of ray with its radiance.
    rays: Vec<KnownRay>,
    tolerance: f64,
    read_out: ReadOut,
}

const RAYS: u64 = 50;

impl Property for Known {
    fn run<P: EstimatorParts + Copy>(&self, context: &Context, setup: Configuration<P>) -> Vec<Outcome> {
        let mut rng = context.rng("rays");
        let solved = solve(setup, &self.scene, self.patches).map(|solved| solved.read(self.read_out));
        let mut deviation = |&(ray, reference): &KnownRay| {
            let Some(solved) = &solved else {
                return f64::NAN;
            };
            let largest = (0..RAYS).map(|_| {
                let ray = ray(&mut rng);
                let hit = self.scene.intersect(&ray);
                let found = solved.radiance(&self.scene, &ray, hit, &mut rng);
                let largest = reference.max_element();
                let scale = if largest == 0.0 { 1.0 } else { largest };
                let off = (found - reference).abs() / scale;
                // Unlike the largest element, this keeps NaN.
                off.x.max(off.y).max(off.z) + 0.0 * off.element_sum()
            });
            // Unlike the maximum of numbers, this keeps NaN.
            largest.fold(0.0, |a: f64, b| if b > a || b.is_nan() { b } else { a })
        };
        let error = self.rays.iter().map(&mut deviation).sum();
        vec![Outcome::exact("radiance", RAYS, error, self.tolerance, "the worst ray")]
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
    fn run<P: EstimatorParts + Copy>(&self, context: &Context, setup: Configuration<P>) -> Vec<Outcome> {
        let n = context.n(REPLICATIONS) as u32;
        let films = || {
            let solved = solve(setup, &self.scene, PATCHES)?;
            // Every replication is the same: two are enough to say so.
            let a = Levels::render(context, "radiosity", (&*self.scene, SIZE, 0..2), &solved)?;
            let paths = Path::<Standard>::default();
            let b = Levels::render(context, "paths", (&*self.scene, SIZE, 0..n), &paths)?;
            Some([a, b])
        };
        match films() {
            // Patches are flat: radiosity is near, not equal.
            Some([a, b]) => vec![same_mean("image mean", &a, &b, IMAGE).within_delta()],
            None => vec![Outcome::exact("film", 0, f64::NAN, 0.0, "no solution")],
        }
    }
}

fn known(
    name: &str,
    property: impl Into<String>,
    equation: &'static Equation,
    known: Known,
) -> FamilyTrial<EstimatorSubject> {
    let subject = "estimator::Radiosity";
    trial(name, property, equation, [subject, "exact"], with_parts(known))
}

/// From within a box towards points so near to its edges and corners that patches look huge.
fn into_corners(rng: &mut Stream) -> Ray {
    let origin = DVec3::new(0.1, 0.2, -0.3);
    let corner = any_direction(rng).signum();
    let mut target = (1.0 - 1e-5) * corner;
    let free = any_direction(rng);
    if free.x > 0.0 {
        target.z = free.z;
    }
    Ray::new(origin, (target - origin).normalize())
}

fn furnaces() -> Vec<FamilyTrial<EstimatorSubject>> {
    let rho = ALBEDO;
    let interpolated = ReadOut::Interpolated;
    let inside = |rng: &mut Stream| Ray::new(DVec3::new(0.1, 0.2, -0.3), any_direction(rng));
    let of = |scene: Arc<Scene>, patches, rays: &[(EstimatorKind, f64)]| Known {
        scene,
        patches,
        rays: rays.iter().map(|&(ray, l)| (ray, DVec3::splat(l))).collect(),
        tolerance: SETTLED,
        read_out: interpolated,
    };
    let cap = |cap, reference| {
        let rays = [(off_cap as EstimatorKind, reference)];
        let scene = cavity_cap(rho, cap).ok()?;
        Some(of(scene.into(), 100, &rays))
    };
    let reflecting = rho * CAP_SHARE / (1.0 - rho);
    let black = rho * CAP_SHARE / (1.0 - rho * (1.0 - CAP_SHARE));
    let nested = scene("box in a dark box", |s| {
        let wall = s.surface(Surface::new(lambert(NESTED)).emitting(DVec3::ONE));
        closed_cube(s, 1.0, true, wall);
        let dark = s.surface(Surface::new(lambert(NESTED)));
        closed_cube(s, 2.0, true, dark);
    });
    let outside = |rng: &mut Stream| Ray::new(DVec3::new(1.5, 1.4, -1.6), any_direction(rng));
    let lit = 1.0 / (1.0 - NESTED);
    let nested = of(nested, 150, &[(inside, lit), (outside, 0.0)]);
    let furnace = |read_out, ray| {
        let scene = furnace_box(rho).ok()?;
        let known = of(scene.into(), 60, &[(ray, 4.0)]);
        Some(Known { read_out, ..known })
    };
    let (albedo, emission) = (DVec3::new(0.25, 0.5, 0.75), DVec3::new(3.0, 1.0, 0.5));
    let coloured = scene("coloured furnace", |s| {
        let wall = s.surface(Surface::new(Bsdf::Lambert { albedo }).emitting(emission));
        closed_cube(s, 1.0, true, wall);
    });
    let coloured = Known { rays: vec![(inside, emission / (DVec3::ONE - albedo))], ..of(coloured, 60, &[]) };
    let name = |cap| format!("radiosity/cavity/{cap}");
    [
        furnace(interpolated, inside).map(|f| {
            let property = "in a closed furnace box of albedo 0.75 the radiance is 4";
            known("radiosity/furnace-box", property, &RADIOSITY, f)
        }),
        furnace(ReadOut::Gathered, into_corners).map(|f| {
            let property = "gathered next to edges and corners of the furnace box it is 4, too";
            known("radiosity/corners", property, &RADIOSITY, f)
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
            format!("a furnace box in a dark box shows {lit:.6} inside and nothing outside"),
            &RADIOSITY,
            nested,
        )),
        Some(known(
            "radiosity/coloured",
            "in a furnace box each channel is its emission over 1 less its albedo",
            &RADIOSITY,
            coloured,
        )),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn rooms() -> Vec<FamilyTrial<EstimatorSubject>> {
    let subject = "estimator::Radiosity";
    let energy = trial(
        "radiosity/energy",
        "in a cube with a wall of light all walls together receive the flux over 1 − ρ",
        &RADIOSITY,
        [subject, "exact"],
        with_parts(factors::Energy),
    );
    let same = diffuse().ok().map(|room| {
        trial(
            "radiosity/diffuse-room",
            "radiosity and the path tracer make the same image of the diffuse room",
            &RADIOSITY,
            [subject, "Welch, equivalence"],
            with_parts(SameRoom { scene: Arc::new(room) }),
        )
    });
    std::iter::once(energy).chain(same).collect()
}

/// Radiosity as a whole.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    let mut trials = furnaces();
    trials.extend(fields::trials());
    trials.extend(factors::factors());
    trials.extend(rooms());
    vec![Box::new(Family {
        whole_estimator: true,
        trials,
        faults: faults::faults(),
        ..Family::new("radiosity", STANDARD)
    })]
}
