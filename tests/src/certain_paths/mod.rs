//! Walks whose value is certain although their directions are random, so that one path per pixel
//! decides to rounding, without statistics.
//!
//! In a cavity that emits 1 and reflects a, a path that is never ended sees 1 + a + a² + ...,
//! whatever its directions. In thermal equilibrium with glass every path within the glass sees n².
//! The first finds limits on path length, the second wrong radiance factors.
//!
//! For this the estimators run with tables of components that take the chance out: [`ENDLESS`]
//! makes roulette deterministic, [`COUNTED`] and [`GATHERED`] make every particle count the same.
//! [`EveryPixelKnown`] then compares each pixel with its known value, and [`ParticleSum`] the sum
//! over all particles.

mod eye;
mod glass;

use whitefurnace::integrator::photon::photon_map::{PhotonMap, PhotonMapKind};
use whitefurnace::sampling::sampler::ImagePass;

use crate::certain_paths::eye::{Eye, HITS, PARTICLES};
use crate::mean_radiance::largest;
use crate::prelude::*;
use crate::scenes::{hollow, lambert, mean_channel, mirror, seen_by};

/// Roulette that ends a path only once its throughput is below 10⁻¹³ and does not reweight
/// survivors, and full MIS weight for light that paths from the eye hit.
const ENDLESS: PartTable = PartTable {
    survival_by_throughput: |throughput, _| throughput.max_element(),
    survives: |_, throughput| throughput > 1e-13,
    roulette_weight: |_| 1.0,
    strategy_weight: |_, s| f64::from(u8::from(s == 0)),
    ..CORRECT
};

/// [`ENDLESS`], with every factor of a splat that depends on place or direction replaced by a
/// constant: each vertex of a particle adds its flux to the image, wherever it lies.
const COUNTED: PartTable = PartTable {
    brdf: |bsdf, _, _| FRAC_1_PI * bsdf.albedo(),
    cosine: |_, _| 1.0,
    cosine_hemisphere_pdf: |_| FRAC_1_PI,
    solid_angle_per_area: |_, _| 1.0,
    importance: |_, _, _| 1.0,
    visible: |_, _, _, _| true,
    ..ENDLESS
};

/// [`ENDLESS`], with photons that count whole wherever they lie, and glass that reflects nothing.
const GATHERED: PartTable = PartTable {
    fresnel: |_, _, _| 0.0,
    same_side: |_, _| true,
    photon_density: |_, flux, _, _| flux,
    ..ENDLESS
};

/// Rounding of some thousand factors and terms.
const ROUNDING: f64 = 1e-11;
/// Albedo of the walls of long walks: 0.98^1000 is 2·10⁻⁹.
const ALBEDO: f64 = 0.98;
/// Segments of the estimators that have a limit. They recurse.
const SEGMENTS: u32 = 600;

/// Compares every pixel of each scene with the one value that all its paths have.
struct EveryPixelKnown {
    eye: Eye,
    /// Scenes, each with the value of all its pixels.
    scenes: Vec<(Arc<Scene>, f64)>,
}

impl Property for EveryPixelKnown {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let mut rng = context.rng("ways");
        let outcome = |(scene, expected): &(Arc<Scene>, f64)| {
            let seed = context.seed_of("passes");
            let image = self.eye.image(setup, scene, &mut rng, seed);
            let image = image.unwrap_or_default();
            let off = image.iter().map(|value| (value / expected - 1.0).abs());
            let error = if image.is_empty() {
                f64::NAN
            } else {
                largest(off)
            };
            Outcome::identity(
                scene.name(),
                image.len() as u64,
                error,
                ROUNDING,
                "the worst pixel",
            )
        };
        self.scenes.iter().map(outcome).collect()
    }
}

/// Compares the sum over particles with its known value: all of them carry the same flux, and add
/// the same in all.
struct ParticleSum {
    scene: Arc<Scene>,
    /// Sums the image of the light tracer instead of the flux of a photon map.
    by_eye: bool,
    expected: f64,
}

impl Property for ParticleSum {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let (parts, seed) = (setup.parts, context.seed_of("particles"));
        let sum = if self.by_eye {
            let mut rng = context.rng("ways");
            let image = Eye::LightTracer.image(setup, &self.scene, &mut rng, seed);
            image.map(|image| image.iter().sum::<f64>())
        } else {
            let map = PhotonMap::new(
                parts,
                &self.scene,
                PhotonMapKind::All,
                PARTICLES,
                ImagePass::independent(seed, 0),
            );
            map.map(|map| mean_channel(&self.scene, map.photons().map(|photon| photon.flux).sum()))
        };
        let error = sum.map_or(f64::NAN, |sum| sum / self.expected - 1.0);
        // Images add in multiples of 2⁻³².
        let tolerance = if self.by_eye { 1e-9 } else { ROUNDING };
        vec![Outcome::identity(
            "sum over particles",
            u64::from(PARTICLES),
            error,
            tolerance,
            "all",
        )]
    }
}

/// Builds a unit cavity that emits 1 and reflects [`ALBEDO`].
fn cavity(name: &str, bsdf: Bsdf, eye: DVec3) -> Arc<Scene> {
    let camera = Camera::new(eye, DVec3::new(0.1, 0.2, -0.1), DVec3::Z, 0.6);
    seen_by(camera, name, |s| {
        hollow(s, 1.0, Surface::new(bsdf).emitting(DVec3::ONE));
    })
}

/// Returns a trial of [`EveryPixelKnown`].
fn every_pixel_known(
    name: &str,
    equation: &'static Equation,
    property: String,
    consequence: impl Into<String>,
    eye: Eye,
    scenes: Vec<(Arc<Scene>, f64)>,
) -> FamilyTrial<EstimatorSubject> {
    trial(
        name,
        property,
        consequence,
        equation,
        eye.path(),
        "exact",
        with_parts(EveryPixelKnown { eye, scenes }),
    )
}

/// Returns a trial of [`ParticleSum`] in a diffuse cavity, by its image (`by_eye`) or its photons.
fn particle_sum(
    name: &str,
    consequence: &str,
    subject: &'static str,
    by_eye: bool,
    expected: f64,
    eye: DVec3,
) -> FamilyTrial<EstimatorSubject> {
    let property = format!(
        "in a cavity of albedo {ALBEDO} the particles together add {expected:.6} until they are negligible"
    );
    let scene = cavity("diffuse cavity", lambert(ALBEDO), eye);
    trial(
        name,
        property,
        consequence,
        &PATH_LENGTH,
        subject,
        "exact",
        with_parts(ParticleSum {
            scene,
            by_eye,
            expected,
        }),
    )
}

const EYE_INSIDE: DVec3 = DVec3::new(-0.3, 0.1, 0.2);
/// An eye from which the whole cavity lies within the image.
const EYE_OUTSIDE: DVec3 = DVec3::new(0.0, -5.0, 0.0);

fn long() -> Vec<FamilyTrial<EstimatorSubject>> {
    let all = 1.0 / (1.0 - ALBEDO);
    let cut = all * (1.0 - ALBEDO.powi(SEGMENTS as i32));
    let diffuse = every_pixel_known(
        "furnace/long/path",
        &PATH_LENGTH,
        format!("in a diffuse cavity of albedo {ALBEDO} every path sees {all:.6}"),
        "white rooms are too dark, as very long paths are cut without saying so",
        HITS,
        vec![(cavity("diffuse cavity", lambert(ALBEDO), EYE_INSIDE), all)],
    );
    let mirrors = |(name, eye): (_, Eye)| {
        let scene = cavity("mirrors", mirror(ALBEDO), EYE_INSIDE);
        let expected = if eye.is_limited() { cut } else { all };
        let property =
            format!("between mirrors of {ALBEDO} that emit 1 every path sees {expected:.6}");
        every_pixel_known(
            name,
            &PATH_LENGTH,
            property,
            format!(
                "a hall of mirrors is too dark by {}, as deep reflections are cut",
                eye.method()
            ),
            eye,
            vec![(scene, expected)],
        )
    };
    let photon_map = particle_sum(
        "furnace/long/photon-map",
        "white rooms are too dark by photon mapping, as particles stop too early",
        "integrator::photon::photon_map::PhotonMap",
        false,
        PI * 4.0 * PI * all,
        EYE_INSIDE,
    );
    let mut trials = vec![diffuse];
    trials.extend(MIRRORS.into_iter().zip(Eye::all(SEGMENTS)).map(mirrors));
    trials.push(photon_map);
    trials
}

/// Names of the trials between mirrors, in the order of [`Eye::all`].
const MIRRORS: [&str; 6] = [
    "furnace/mirrors/path",
    "furnace/mirrors/photons",
    "furnace/mirrors/sppm",
    "furnace/mirrors/bdpt",
    "furnace/mirrors/report",
    "furnace/mirrors/whitted",
];
/// Trials of estimators without a limit on segments.
const UNLIMITED: &[&str] = &[
    "furnace/long/path",
    MIRRORS[0],
    MIRRORS[1],
    MIRRORS[2],
    MIRRORS[3],
    "furnace/long/photon-map",
];
const LONG: &[&str] = &[
    "furnace/long/path",
    MIRRORS[0],
    MIRRORS[1],
    MIRRORS[2],
    MIRRORS[3],
    MIRRORS[4],
    MIRRORS[5],
    "furnace/long/photon-map",
];
const PARTICLE: &[&str] = &["furnace/long/light-tracer"];

/// Returns whether a walk has at most this many vertices, from its throughput.
fn within(throughput: f64, vertices: f64) -> bool {
    throughput > ALBEDO.powf(vertices - 0.5)
}

/// Faults that end walks at a number of vertices. The trials `all` must reject the short ones, and
/// only those of estimators without a limit of their own, `unlimited`, the longest.
fn cuts(
    table: PartTable,
    unlimited: &'static [&'static str],
    all: &'static [&'static str],
) -> Vec<Fault<EstimatorSubject>> {
    let cut = |name, wrong, segments, survives: fn(f64, f64) -> bool, rejected_by| {
        let subject = EstimatorSubject {
            segments: Some(segments),
            ..parts(PartTable { survives, ..table })
        };
        fault(name, &PATH_LENGTH, wrong, subject, rejected_by)
    };
    vec![
        cut(
            "cut-at-63",
            "paths end at 63 vertices",
            63,
            |_, t| within(t, 63.0),
            all,
        ),
        cut(
            "cut-at-255",
            "paths end at 255 vertices",
            255,
            |_, t| within(t, 255.0),
            all,
        ),
        cut(
            "cut-at-1000",
            "paths end at 1000 vertices",
            SEGMENTS,
            |_, t| within(t, 1000.0),
            unlimited,
        ),
    ]
}

/// Trials and faults of long walks by every estimator, and of glass.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    let family = |name, table, trials, faults| -> Box<dyn AnyFamily> {
        Box::new(Family {
            trials,
            faults,
            ..Family::whole(name, parts(table))
        })
    };
    // The particles of the unit cavity together add L A (1 + a + a² + ...) to the image.
    let splats = 4.0 * PI / (1.0 - ALBEDO);
    let tracer = particle_sum(
        PARTICLE[0],
        "white rooms are too dark in light-traced images, as particles stop too early",
        "integrator::LightTracer",
        true,
        splats,
        EYE_OUTSIDE,
    );
    vec![
        family(
            "long-walks",
            ENDLESS,
            long(),
            cuts(ENDLESS, UNLIMITED, LONG),
        ),
        family(
            "long-particles",
            COUNTED,
            vec![tracer],
            cuts(COUNTED, PARTICLE, PARTICLE),
        ),
        family(
            "equilibrium-in-glass",
            ENDLESS,
            glass::equilibrium(),
            glass::faults(),
        ),
        family(
            "photons-in-glass",
            GATHERED,
            glass::photon_lookups(),
            glass::factors(GATHERED, glass::PHOTON_LOOKUPS),
        ),
    ]
}
