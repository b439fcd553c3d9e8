//! Direct light through whole estimators: irradiance from lights of every shape in closed form, by
//! each strategy alone and by both.

use whitefurnace::integrator::Heuristic;
use whitefurnace::light::light_sampler::PowerLightSampler;

use crate::form_factors;
use crate::prelude::*;
use crate::scenes::{
    FLOOR, LIGHT, NEAR, RECTANGLE, SMALL_LIGHT, TRIANGLE, corners, half_hidden_light, near_light,
    polygon_irradiance, ray_to_origin, rectangle_light, sphere_irradiance, sphere_light,
    three_lights, triangle_light,
};
use crate::streams::frequencies;
use crate::subject::with_altered_parts;

/// Radiance that the floor reflects of an irradiance, given as E/L, of a light of radiance
/// [`LIGHT`].
pub fn reflected(irradiance: f64) -> f64 {
    FLOOR * FRAC_1_PI * LIGHT * irradiance
}

/// Irradiance E/L of the three lights together, in units of [`LIGHT`].
pub fn three() -> f64 {
    0.5 * polygon_irradiance(&TRIANGLE)
        + 2.0 * sphere_irradiance(0.5, 2.0, 1.0)
        + 4.0 * polygon_irradiance(&corners(SMALL_LIGHT, 0.4))
}

pub fn trials() -> Vec<FamilyTrial<EstimatorSubject>> {
    [
        lights(),
        strategies(),
        form_factors::trials(),
        vec![weights()],
        picks(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// A light over the floor.
pub(super) struct Light {
    pub scene: Arc<Scene>,
    /// E/L at the origin.
    pub irradiance: f64,
    /// The light in words.
    pub what: &'static str,
}

/// Returns a trial of the radiance that the floor reflects of a light at the origin.
pub(super) fn lit(
    name: &'static str,
    consequence: &'static str,
    light: &Light,
    kind: EstimatorKind,
    ray: Rays,
    equation: &'static Equation,
    draws: Draws,
) -> FamilyTrial<EstimatorSubject> {
    let reference = reflected(light.irradiance);
    let property = format!("a floor reflects {reference:.6} of {}", light.what);
    radiance(name, equation, &light.scene, kind, ray)
        .states(property, consequence)
        .by_draws(reference, CLOSED_FORM_DELTA, draws)
}

fn lights() -> Vec<FamilyTrial<EstimatorSubject>> {
    use EstimatorKind::{Path, Report, Whitted};
    let [a, b, ..] = RECTANGLE;
    let visible_half = [a, b, b.with_y(0.0), a.with_y(0.0)];
    let square = Light {
        scene: rectangle_light(false),
        irradiance: polygon_irradiance(&RECTANGLE),
        what: "a square light's radiance",
    };
    let hidden = Light {
        scene: half_hidden_light(),
        irradiance: polygon_irradiance(&visible_half),
        what: "a square light that a wall hides by half",
    };
    let away = Light {
        scene: rectangle_light(true),
        irradiance: 0.0,
        what: "a light that shines the other way",
    };
    let triangle = Light {
        scene: triangle_light(),
        irradiance: polygon_irradiance(&TRIANGLE),
        what: "a slanted triangular light",
    };
    let sphere = Light {
        scene: sphere_light(),
        irradiance: sphere_irradiance(0.5, 2.0, 1.0),
        what: "a spherical light",
    };
    let three = Light {
        scene: three_lights(),
        irradiance: three(),
        what: "three lights of different size and radiance",
    };
    let by = |name, consequence, light, kind, equation, draws| {
        lit(
            name,
            consequence,
            light,
            kind,
            |_| ray_to_origin(),
            equation,
            draws,
        )
    };
    vec![
        by(
            "irradiance/rectangle",
            "a floor under a panel lamp is too bright or too dark when path traced",
            &square,
            Path,
            &GEOMETRY,
            Draws::scrambles(32, 11_000),
        ),
        by(
            "irradiance/rectangle-report",
            "the report's method makes a floor under a panel lamp too bright or too dark",
            &square,
            Report(2),
            &GEOMETRY,
            Draws::scrambles(16, 11_000),
        ),
        by(
            "irradiance/rectangle-whitted",
            "Whitted's ray tracing makes a floor under a panel lamp too bright or too dark",
            &square,
            Whitted(7),
            &WHITTED,
            Draws::scrambles(16, 11_000),
        ),
        by(
            "irradiance/half-hidden",
            "what stands before a lamp casts too dark or too light a soft shadow",
            &hidden,
            Path,
            &GEOMETRY,
            Draws::scrambles(64, 11_500),
        ),
        by(
            "irradiance/behind",
            "one-sided lamps shine from their backs, too",
            &away,
            Path,
            &GEOMETRY,
            Draws::scrambles(16, 11_000),
        ),
        by(
            "irradiance/triangle",
            "a slanted triangle of a mesh lamp is too bright or too dim",
            &triangle,
            Path,
            &GEOMETRY,
            Draws::scrambles(64, 9_000),
        ),
        by(
            "irradiance/sphere",
            "globe lamps light a floor too much or too little when path traced",
            &sphere,
            Path,
            &GEOMETRY,
            Draws::scrambles(16, 52_000),
        ),
        by(
            "irradiance/three-lights",
            "the more lamps a scene has, the more its brightness is off",
            &three,
            Path,
            &ESTIMATOR,
            Draws::scrambles(64, 12_500),
        ),
    ]
}

/// Trials of one strategy of the path tracer, with the other removed and all the MIS weight.
fn strategies() -> Vec<FamilyTrial<EstimatorSubject>> {
    let alone = |name, consequence, how, scene: &_, polygon: &[_], draws, alone: fn(_) -> _| {
        let reference = reflected(polygon_irradiance(polygon));
        let property = format!("{how} alone: a floor reflects {reference:.6} of a square light");
        let both = radiance(name, &MIS, scene, EstimatorKind::Path, |_| ray_to_origin())
            .states(property, consequence)
            .by_draws(reference, CLOSED_FORM_DELTA, draws);
        with_altered_parts(both, alone)
    };
    // A horizontal direction has pdf 0, so the path ends after its shadow ray.
    let shadow_rays = |table| PartTable {
        cosine_hemisphere: |_| DVec3::X,
        mis_weight: |_, _| 1.0,
        ..table
    };
    let hits = |table| PartTable {
        visible: |_, _, _, _| false,
        mis_weight: |_, _| 1.0,
        ..table
    };
    vec![
        alone(
            "irradiance/shadow-rays-alone",
            "shadow rays bring too much or too little light: lit floors and shadows are off",
            "by shadow rays",
            &rectangle_light(false),
            &RECTANGLE,
            Draws::scrambles(16, 11_000),
            shadow_rays,
        ),
        alone(
            "irradiance/hits-alone",
            "lamps that paths hit by chance count too much or too little: a glow near them",
            "by hits",
            &near_light(),
            &NEAR,
            Draws::scrambles(32, 12_400),
            hits,
        ),
    ]
}

const ARGUMENTS: u64 = 10_000;

/// The MIS weights of both strategies sum to one, and are proportional to the densities or to their
/// squares.
pub(super) struct Weights(pub Heuristic);

impl Property for Weights {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let (power, parts) = (self.0 == Heuristic::Power, setup.parts);
        let (stream, proportion) = if power {
            ("power weights", "squares")
        } else {
            ("weights", "balance")
        };
        let weight = |p, q| {
            if power {
                parts.mis_power_weight(p, q)
            } else {
                parts.mis_weight(p, q)
            }
        };
        let times = |weight: f64, p: f64| if power { weight * p * p } else { weight * p };
        let mut rng = context.rng(stream);
        let (mut sum, mut unlike) = (0.0_f64, 0.0_f64);
        for _ in 0..context.arguments(ARGUMENTS) {
            let [p, q] = [uniform(&mut rng) + 1e-3, uniform(&mut rng) + 1e-3];
            let [a, b] = [weight(p, q), weight(q, p)];
            sum = sum.max((a + b - 1.0).abs());
            unlike = unlike.max((times(a, q) - times(b, p)).abs());
        }
        let worst = "the worst of random densities";
        let exact = |name, error| Outcome::identity(name, ARGUMENTS, error, 1e-12, worst);
        vec![exact("sum of weights", sum), exact(proportion, unlike)]
    }
}

fn weights() -> FamilyTrial<EstimatorSubject> {
    trial(
        "irradiance/weights",
        "MIS weights sum to one and are proportional to the densities",
        "direct light counts more or less than once: lit surfaces are too bright or too dark",
        &MIS,
        "sampling::mis::balance",
        "exact",
        with_parts(Weights(Heuristic::Balance)),
    )
}

/// Emitters are picked with the stated probabilities: by given ones, or by flux.
struct Picks {
    shares: [f64; 4],
    by_flux: Option<PowerLightSampler>,
}

impl Property for Picks {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let mut rng = context.rng(if self.by_flux.is_some() {
            "picks"
        } else {
            "picks by share"
        });
        let n = context.n(1_170_000);
        // Given probabilities are passed on unchanged.
        let rounding = if self.by_flux.is_some() { 1e-15 } else { 0.0 };
        let mut observed = vec![0; self.shares.len()];
        let mut unlike = 0.0_f64;
        for _ in 0..n {
            let r = uniform(&mut rng);
            let (pick, share) = match &self.by_flux {
                None => setup.parts.pick_by_probability(r, &self.shares),
                Some(picks) => {
                    let pick = setup.parts.pick_emitter(r, picks);
                    (pick, picks.probability(pick))
                }
            };
            observed[pick] += 1;
            unlike = unlike.max((share - self.shares[pick]).abs());
        }
        let (masses, place) = (self.shares.to_vec(), |i| format!("emitter {i}"));
        let worst = "the worst of all picks";
        vec![
            frequencies("picks", masses, place, n, observed),
            Outcome::identity("share of the pick", n, unlike, rounding, worst),
        ]
    }
}

fn picks() -> Vec<FamilyTrial<EstimatorSubject>> {
    const PROBABILITIES: [f64; 4] = [0.4, 0.3, 0.0, 0.3];
    const FLUXES: [f64; 4] = [3.0, 2.0, 0.0, 3.0];
    let picks = |name, consequence, of, equation, part, picks| {
        let property = format!(
            "each of four emitters is picked with its probability {of}, and never if that is 0"
        );
        trial(
            name,
            property,
            consequence,
            equation,
            part,
            "chi-square",
            with_parts(picks),
        )
    };
    let of_flux = FLUXES.map(|flux| {
        if flux > 0.0 {
            0.5 * flux / 8.0 + 0.5 / 3.0
        } else {
            0.0
        }
    });
    let by_flux = Picks {
        shares: of_flux,
        by_flux: Some(PowerLightSampler::new(&FLUXES)),
    };
    let by_share = Picks {
        shares: PROBABILITIES,
        by_flux: None,
    };
    vec![
        picks(
            "irradiance/picks",
            "some of many lamps are too bright, others too dim or never on",
            "by flux",
            &ESTIMATOR,
            "light::light_sampler::FluxPicks",
            by_flux,
        ),
        picks(
            "irradiance/picks-by-share",
            "lamps are too bright or dim, as each has the probability of the next one",
            "from given shares",
            &LIGHT_PICK,
            "light::light_sampler::pick",
            by_share,
        ),
    ]
}
