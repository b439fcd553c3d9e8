//! Trials of radiosity: form factors against closed forms, furnaces, hidden light, and the path
//! tracer.

mod factors;
mod faults;
mod fields;

pub use factors::{NEIGHBOURS, OPPOSITE};

use whitefurnace::integrator::Radiosity;
use whitefurnace::integrator::radiosity::{MeshResolution, RESIDUAL, ReadOut};
use whitefurnace::scene::room::diffuse;
use whitefurnace::scene::simple::{Cap, cavity_cap, closed_cube, furnace_box};

use crate::furnace::{in_box, off_cap, off_cap_radiance};
use crate::images::{Frames, PixelMoments, same_mean};
use crate::mean_radiance::{any_direction, largest};
use crate::prelude::*;
use crate::scenes::{lambert, scene, valid};

const SUBJECT: &str = "integrator::Radiosity";
/// Rounding of form factors, which are kept in single precision.
const SINGLE_PRECISION: f64 = 1e-6;
/// Albedo of furnaces and cavities.
const ALBEDO: f64 = 0.75;
/// Albedo of boxes within boxes: so low that the iteration converges even if all of them see each
/// other.
const NESTED: f64 = 0.3;
/// Tolerance of their radiance: a residual r leaves an error of at most r/(1 − ρ).
const RADIANCE_TOLERANCE: f64 = RESIDUAL / (1.0 - ALBEDO) + SINGLE_PRECISION;

fn resolution(patches: u32) -> MeshResolution {
    MeshResolution {
        patches,
        halvings: 0,
    }
}

fn solve<'a>(setup: Configuration<'a>, scene: &Scene, patches: u32) -> Option<Radiosity<'a>> {
    Radiosity::new(setup.parts, scene, resolution(patches), &|_| true).ok()
}

/// A kind of ray and its radiance.
type KnownRay = (Rays, DVec3);

/// Compares the radiance along rays with its known values: the largest relative deviation.
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
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let mut rng = SampleStream::from(context.rng("rays"));
        let solved =
            solve(setup, &self.scene, self.patches).map(|solved| solved.read(self.read_out));
        let mut deviation = |&(ray, reference): &KnownRay| {
            let Some(solved) = &solved else {
                return f64::NAN;
            };
            let scale = if reference == DVec3::ZERO {
                1.0
            } else {
                reference.max_element()
            };
            let off = |_| {
                let ray = ray(&mut rng);
                let found =
                    solved.radiance(&self.scene, &ray, self.scene.intersect(&ray), &mut rng);
                largest(((found - reference).abs() / scale).to_array().into_iter())
            };
            largest((0..RAYS).map(off))
        };
        let error = self.rays.iter().map(&mut deviation).sum();
        vec![Outcome::identity(
            "radiance",
            RAYS,
            error,
            self.tolerance,
            "the worst ray",
        )]
    }
}

/// Compares radiosity with the path tracer in the all-diffuse room.
struct SameRoom(Arc<Scene>);

const SIZE: [u32; 2] = [40, 30];
const REPLICATIONS: u64 = 160;
const PATCHES: u32 = 500;

impl Property for SameRoom {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let frames = |count| Frames::first(&self.0, SIZE, count);
        let films = || {
            let solved = solve(setup, &self.0, PATCHES)?;
            // Radiosity is deterministic: two replications are enough to show it.
            let a = PixelMoments::render(context, "radiosity", &frames(2), &solved)?;
            let paths = Path::default();
            let b =
                PixelMoments::render(context, "paths", &frames(context.n(REPLICATIONS)), &paths)?;
            Some([a, b])
        };
        match films() {
            // Patches are flat: radiosity is near, not equal.
            Some([a, b]) => vec![same_mean("image mean", &a, &b, IMAGE_DELTA).as_equivalence()],
            None => vec![Outcome::identity("film", 1, f64::NAN, 0.0, "no solution")],
        }
    }
}

/// Samples a ray from within a box towards points so near to its edges and corners that patches
/// look huge.
fn into_corners(rng: &mut SampleStream) -> Ray {
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
    let outside = |rng: &mut SampleStream| Ray::new(DVec3::new(1.5, 1.4, -1.6), any_direction(rng));
    let box_of = |name, walls: &[(f64, Surface)]| {
        scene(name, |s| {
            for &(half, surface) in walls {
                let wall = s.surface(surface);
                closed_cube(s, half, true, wall);
            }
        })
    };
    let dark = Surface::new(lambert(NESTED));
    let nested = box_of(
        "box in a dark box",
        &[(1.0, dark.emitting(DVec3::ONE)), (2.0, dark)],
    );
    let lit = 1.0 / (1.0 - NESTED);
    let (albedo, emission) = (DVec3::new(0.25, 0.5, 0.75), DVec3::new(3.0, 1.0, 0.5));
    let wall = Surface::new(Bsdf::Lambert { albedo }).emitting(emission);
    let coloured = box_of("coloured furnace", &[(1.0, wall)]);
    let cavity = |cap| valid(cavity_cap(ALBEDO, cap));
    let [reflecting, black] =
        [Cap::Reflecting, Cap::Black].map(|cap| off_cap_radiance(ALBEDO, cap));
    let furnace = || valid(furnace_box(ALBEDO));
    let of = |scene, patches, rays: &[KnownRay]| Known {
        scene,
        patches,
        rays: rays.to_vec(),
        tolerance: RADIANCE_TOLERANCE,
        read_out: ReadOut::Interpolated,
    };
    let grey = DVec3::splat;
    let gathered = Known {
        read_out: ReadOut::Gathered,
        ..of(furnace(), 60, &[(into_corners, grey(4.0))])
    };
    [
        (
            "radiosity/furnace-box",
            "a radiosity room is too dark or too bright, as bounces are lost or gained",
            "in a closed furnace box of albedo 0.75 the radiance is 4".to_owned(),
            of(furnace(), 60, &[(in_box, grey(4.0))]),
        ),
        (
            "radiosity/corners",
            "rooms by radiosity have dark or bright lines along edges and in corners",
            "gathered next to its edges and corners the radiance in the furnace box is 4, too"
                .to_owned(),
            gathered,
        ),
        (
            "radiosity/cavity/reflecting",
            "a lamp that also reflects gives a radiosity room too much or too little light",
            format!("off a reflecting cap the radiance in a cavity is {reflecting}"),
            of(cavity(Cap::Reflecting), 100, &[(off_cap, grey(reflecting))]),
        ),
        (
            "radiosity/cavity/black",
            "a room lit by a small window is too dark or too bright by radiosity",
            format!("off a black cap the radiance in a cavity is {black:.6}"),
            of(cavity(Cap::Black), 100, &[(off_cap, grey(black))]),
        ),
        (
            "radiosity/nested",
            "light leaks through walls into the next room by radiosity",
            format!("a furnace box in a dark box shows {lit:.6} inside and nothing outside"),
            of(nested, 150, &[(in_box, grey(lit)), (outside, DVec3::ZERO)]),
        ),
        (
            "radiosity/coloured",
            "radiosity mixes up the colours of walls and of lamps",
            "in a furnace box each channel is its emission over 1 less its albedo".to_owned(),
            of(coloured, 60, &[(in_box, emission / (DVec3::ONE - albedo))]),
        ),
    ]
    .into_iter()
    .map(|(name, consequence, property, known)| {
        trial(
            name,
            property,
            consequence,
            &RADIOSITY,
            SUBJECT,
            "exact",
            with_parts(known),
        )
    })
    .collect()
}

fn rooms() -> Vec<FamilyTrial<EstimatorSubject>> {
    vec![
        trial(
            "radiosity/energy",
            "in a cube with a wall of light all walls together receive the flux over 1 − ρ",
            "radiosity creates or loses light in all, so that a whole room is too bright or dark",
            &RADIOSITY,
            SUBJECT,
            "exact",
            with_parts(factors::Energy),
        ),
        trial(
            "radiosity/diffuse-room",
            "radiosity and the path tracer make the same image of the diffuse room",
            "a room by radiosity differs visibly from the same room by path tracing",
            &RADIOSITY,
            SUBJECT,
            "Welch, equivalence",
            with_parts(SameRoom(valid(diffuse()))),
        ),
    ]
}

/// Trials and faults of radiosity.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    let trials = [furnaces(), fields::trials(), factors::factors(), rooms()]
        .into_iter()
        .flatten()
        .collect();
    vec![Box::new(Family {
        trials,
        faults: faults::faults(),
        ..Family::whole("radiosity", STANDARD)
    })]
}
