//! The strategies of bidirectional path tracing: each alone against a closed form, and their MIS
//! weights.

use whitefurnace::integrator::Density;

use crate::bidirectional::scenes::KnownImage;
use crate::bidirectional::{SQUARE, Size, mean, scenes};
use crate::image_mean::ImageEstimatorKind::Bdpt;
use crate::image_mean::with_altered_subject;
use crate::prelude::*;

/// Returns the subject with another MIS weight, so that chosen strategies have all the weight or
/// none.
fn weighted(
    subject: EstimatorSubject,
    strategy_weight: fn(&[Density], usize) -> f64,
) -> EstimatorSubject {
    EstimatorSubject {
        parts: Some(PartTable {
            strategy_weight,
            ..subject.parts.unwrap_or(CORRECT)
        }),
        ..subject
    }
}

/// Selects one strategy: weight 1 for paths of `length` vertices besides the eye, `s` of them from
/// the light.
macro_rules! only {
    ($length:literal, $s:literal) => {
        |subject| {
            weighted(subject, |path, s| {
                f64::from(path.len() == $length && s == $s)
            })
        }
    };
}

/// Trials in which one strategy alone finds all the light of the paths that it makes.
pub(super) fn alone() -> Vec<FamilyTrial<EstimatorSubject>> {
    let floor =
        |name, consequence, what, scene, count, only: fn(EstimatorSubject) -> EstimatorSubject| {
            let size = Size {
                frame: SQUARE,
                count,
                delta: IMAGE_DELTA,
            };
            let family_trial = mean(name, consequence, Bdpt, &MIS, what, scene, size);
            with_altered_subject(family_trial, only)
        };
    let mut trials = vec![
        floor(
            "bidirectional/alone/hits",
            "bidirectional paths that run into a lamp make its surroundings too bright or dim",
            "a floor under a near light, by hits alone",
            scenes::near(),
            7_000,
            only!(2, 0),
        ),
        floor(
            "bidirectional/alone/shadow-rays",
            "shadow rays of bidirectional paths make lit floors too bright or too dark",
            "a floor under a square light, by shadow rays alone",
            scenes::rectangle(false),
            7_000,
            only!(2, 1),
        ),
        floor(
            "bidirectional/alone/seen-particles",
            "particles joined to the camera make lit floors too bright or too dark",
            "a floor under a square light, by particles that the camera sees",
            scenes::rectangle(false),
            8_000,
            only!(2, 2),
        ),
    ];
    trials.extend(
        [
            (
                "bidirectional/alone/sphere-hits",
                "indirect light is wrong where eye paths hit a lamp at their end",
                only!(4, 0) as fn(EstimatorSubject) -> EstimatorSubject,
            ),
            (
                "bidirectional/alone/sphere-shadow-rays",
                "indirect light is wrong where eye paths end in a shadow ray",
                only!(4, 1),
            ),
            (
                "bidirectional/alone/sphere-inner-connections",
                "indirect light is wrong where an eye path and a light path join half way",
                only!(4, 2),
            ),
            (
                "bidirectional/alone/sphere-first-connections",
                "indirect light is wrong where light paths join what the eye sees first",
                only!(4, 3),
            ),
        ]
        .map(|(name, consequence, only)| sphere(name, consequence, only)),
    );
    trials
}

/// Trial of one strategy in a sphere of albedo ρ. Paths of three scatterings have the expectation
/// ρ³ by every strategy, and every single one has that value, as densities are uniform. Roulette
/// would add its noise; walks end after three scatterings instead.
fn sphere(
    name: &'static str,
    consequence: &'static str,
    only: fn(EstimatorSubject) -> EstimatorSubject,
) -> FamilyTrial<EstimatorSubject> {
    let rho: f64 = 0.5;
    let image = KnownImage {
        scene: scenes::sphere_furnace(rho),
        mean: rho.powi(3),
    };
    let size = Size {
        frame: SQUARE,
        count: 400,
        delta: 0.0,
    };
    let what = "light that a sphere reflects three times, by one strategy alone";
    let family_trial = mean(name, consequence, Bdpt, &PATH_DENSITY, what, image, size);
    with_altered_subject(family_trial, move |subject| {
        let table = only(subject).parts.unwrap_or(CORRECT);
        EstimatorSubject {
            parts: Some(PartTable {
                survival_by_throughput: |throughput, _| f64::from(throughput.x > 0.1),
                ..table
            }),
            ..subject
        }
    })
}

const PATHS: u64 = 10_000;

/// On any path, the MIS weights of all strategies that exist sum to one, and are proportional to
/// the products of densities.
struct Weights;

impl Property for Weights {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let mut rng = context.rng("paths");
        let (mut sums, mut balance) = (0.0_f64, 0.0_f64);
        for _ in 0..context.arguments(PATHS) {
            let length = 1 + (8.0 * uniform(&mut rng)) as usize;
            let path: Vec<Density> = (0..length)
                .map(|_| Density {
                    light: uniform(&mut rng) + 0.01,
                    eye: uniform(&mut rng) + 0.01,
                    connectible: if uniform(&mut rng) < 0.6 {
                        uniform(&mut rng) + 0.01
                    } else {
                        0.0
                    },
                })
                .collect();
            // Density of the strategy that takes s vertices from the light; 0 if it does not exist.
            let density = |s: usize| -> f64 {
                let (light, eye) = path.split_at(s);
                let connectible = light.last().map_or(1.0, |x| x.connectible);
                let light: f64 = light.iter().map(|x| x.light).product();
                connectible * light * eye.iter().map(|x| x.eye).product::<f64>()
            };
            let all: f64 = (0..=length).map(density).sum();
            let existing = (0..=length).filter(|&s| density(s) > 0.0);
            let mut sum = 0.0;
            for s in existing {
                let weight = setup.parts.strategy_weight(&path, s);
                balance = balance.max((weight - density(s) / all).abs());
                sum += weight;
            }
            sums = sums.max((sum - 1.0).abs());
        }
        let exact =
            |name, error| Outcome::identity(name, PATHS, error, 1e-12, "the worst of random paths");
        vec![exact("sum of weights", sums), exact("balance", balance)]
    }
}

pub(super) fn weights() -> FamilyTrial<EstimatorSubject> {
    let property =
        "the weights of all strategies of a path sum to one, in proportion to their densities";
    let name = "bidirectional/weights";
    trial(
        name,
        property,
        "bidirectional images are too bright or dark, as light counts more or less than once",
        &PATH_DENSITY,
        "integrator::weight",
        "exact",
        with_parts(Weights),
    )
}
