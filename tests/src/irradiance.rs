//! Direct light through whole estimators: irradiance of lights of every shape in closed form, by each
//! strategy alone and by both.

use whitefurnace::harness::chi_square::{CELL_DELTA, Counts, chi_square};

use crate::form_factors;
use crate::mean_radiance::MeanRadiance;
use crate::prelude::*;
use crate::scenes::{
    FLOOR, LIGHT, NEAR, RECTANGLE, SMALL_LIGHT, TRIANGLE, at_origin, corners, half_hidden_light, near_light,
    polygon_irradiance, rectangle_light, sphere_irradiance, sphere_light, three_lights, triangle_light,
};

/// What the floor reflects of an irradiance E, given as E/L, of a light of radiance [`LIGHT`].
pub fn reflected(irradiance: f64) -> f64 {
    FLOOR * FRAC_1_PI * LIGHT * irradiance
}

/// E/L of the three lights together, in units of [`LIGHT`].
pub fn three() -> f64 {
    0.5 * polygon_irradiance(&TRIANGLE)
        + 2.0 * sphere_irradiance(0.5, 2.0, 1.0)
        + 4.0 * polygon_irradiance(&corners(SMALL_LIGHT, 0.4))
}

/// The trials.
pub fn trials() -> Vec<FamilyTrial<EstimatorSubject>> {
    let mut trials = lights();
    trials.extend(strategies());
    trials.extend(form_factors::trials());
    trials.push(weights());
    trials.push(picks());
    trials
}

fn lights() -> Vec<FamilyTrial<EstimatorSubject>> {
    let rectangle = rectangle_light(false);
    let hidden = half_hidden_light();
    let [a, b, ..] = RECTANGLE;
    let visible_half = [a, b, b.with_y(0.0), a.with_y(0.0)];
    let family_trial = |name, what: &str, scene, kind, irradiance, samples, equation| {
        let reference = reflected(irradiance);
        let property = format!("a floor reflects {reference:.6} of {what}");
        radiance(
            name,
            property,
            equation,
            (&scene, kind, |_| at_origin()),
            reference, // Where nothing arrives, nothing varies.
            (samples, if reference == 0.0 { 0.0 } else { SINGLE }),
        )
    };
    let square = polygon_irradiance(&RECTANGLE);
    vec![
        family_trial(
            "irradiance/rectangle",
            "a square light's radiance",
            Arc::clone(&rectangle),
            EstimatorKind::Path,
            square,
            3_800_000,
            &GEOMETRY,
        ),
        family_trial(
            "irradiance/rectangle-report",
            "a square light's radiance",
            Arc::clone(&rectangle),
            EstimatorKind::Report(2),
            square,
            700_000,
            &GEOMETRY,
        ),
        family_trial(
            "irradiance/rectangle-whitted",
            "a square light's radiance",
            rectangle,
            EstimatorKind::Whitted(7),
            square,
            700_000,
            &WHITTED,
        ),
        family_trial(
            "irradiance/half-hidden",
            "a square light that a wall hides by half",
            Arc::clone(&hidden),
            EstimatorKind::Path,
            polygon_irradiance(&visible_half),
            20_000_000,
            &GEOMETRY,
        ),
        family_trial(
            "irradiance/behind",
            "a light that shines the other way",
            rectangle_light(true),
            EstimatorKind::Path,
            0.0,
            100_000,
            &GEOMETRY,
        ),
        family_trial(
            "irradiance/triangle",
            "a slanted triangular light",
            triangle_light(),
            EstimatorKind::Path,
            polygon_irradiance(&TRIANGLE),
            2_600_000,
            &GEOMETRY,
        ),
        family_trial(
            "irradiance/sphere",
            "a spherical light",
            sphere_light(),
            EstimatorKind::Path,
            sphere_irradiance(0.5, 2.0, 1.0),
            11_500_000,
            &GEOMETRY,
        ),
        family_trial(
            "irradiance/three-lights",
            "three lights of different size and radiance",
            three_lights(),
            EstimatorKind::Path,
            three(),
            13_000_000,
            &ESTIMATOR,
        ),
    ]
}

/// One strategy of the path tracer with the other taken away and all the weight.
fn strategies() -> Vec<FamilyTrial<EstimatorSubject>> {
    let far = rectangle_light(false);
    let near = near_light();
    let family_trial = |name, property, scene, polygon: &[_], samples, alone: fn(PartTable) -> PartTable| {
        let reference = reflected(polygon_irradiance(polygon));
        let property = format!("{property}: a floor reflects {reference:.6} of a square light");
        let probe = Probe { scene, kind: EstimatorKind::Path, ray: |_| at_origin() };
        let property_of = MeanRadiance { probe, reference, delta: SINGLE * reference, samples };
        trial(name, property, &MIS, ["estimator::Path", "t"], move |context: &Context, subject: EstimatorSubject| {
            let parts = alone(subject.parts.unwrap_or(CORRECT));
            property_of.run(context, subject.with(parts))
        })
    };
    vec![
        family_trial(
            "irradiance/shadow-rays-alone",
            "by shadow rays alone",
            far,
            &RECTANGLE,
            700_000,
            // A horizontal direction has no density: the path ends after its shadow ray.
            |table| PartTable { cosine_hemisphere: |_| DVec3::X, mis_weight: |_, _| 1.0, ..table },
        ),
        family_trial("irradiance/hits-alone", "by hits alone", near, &NEAR, 8_000_000, |table| PartTable {
            visible: |_, _, _, _| false,
            mis_weight: |_, _| 1.0,
            ..table
        }),
    ]
}

const ARGUMENTS: u64 = 10_000;

/// The weights of both strategies sum to one, and are in proportion to the densities.
struct Weights;

impl Property for Weights {
    fn run<P: EstimatorParts + Copy>(&self, context: &Context, setup: Configuration<P>) -> Vec<Outcome> {
        let mut rng = context.rng("weights");
        let (mut sum, mut balance) = (0.0_f64, 0.0_f64);
        for _ in 0..context.arguments(ARGUMENTS) {
            let [p, q] = [uniform(&mut rng) + 1e-3, uniform(&mut rng) + 1e-3];
            let [a, b] = [setup.parts.mis_weight(p, q), setup.parts.mis_weight(q, p)];
            sum = sum.max((a + b - 1.0).abs());
            balance = balance.max((a * q - b * p).abs());
        }
        let exact = |name, error| Outcome::exact(name, ARGUMENTS, error, 1e-12, "the worst of random densities");
        vec![exact("sum of weights", sum), exact("balance", balance)]
    }
}

fn weights() -> FamilyTrial<EstimatorSubject> {
    let property = "MIS weights sum to one and stand in proportion to the densities";
    let subject = "radiometry::balance";
    trial("irradiance/weights", property, &MIS, [subject, "exact"], with_parts(Weights))
}

const PICKS: u64 = 1_000_000;

/// Each of three emitters is picked with probability 1/3.
struct Picks;

impl Property for Picks {
    fn run<P: EstimatorParts + Copy>(&self, context: &Context, setup: Configuration<P>) -> Vec<Outcome> {
        let mut rng = context.rng("picks");
        let n = context.n(PICKS);
        let mut observed = vec![0; 3];
        (0..n).for_each(|_| observed[setup.parts.pick_emitter(uniform(&mut rng), 3)] += 1);
        let places = (0..3).map(|i| format!("emitter {i}")).collect();
        let partition = Partition::of_masses(vec![1.0 / 3.0; 3], places);
        let counts = Counts { n, observed, ..Counts::default() };
        vec![chi_square("picks", &partition, &counts, CELL_DELTA)]
    }
}

fn picks() -> FamilyTrial<EstimatorSubject> {
    let property = "each of three emitters is picked with probability 1/3";
    let subject = "estimator::NextEvent::pick_emitter";
    trial("irradiance/picks", property, &ESTIMATOR, [subject, "chi-square"], with_parts(Picks))
}
