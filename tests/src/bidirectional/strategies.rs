//! The strategies of bidirectional path tracing: each alone against a closed form, and their MIS
//! weights.

use whitefurnace::harness::mean::MIN_SYMMETRIC_VALUES;
use whitefurnace::integrator::Density;

use crate::bidirectional::scenes::KnownImage;
use crate::bidirectional::{SMALL, SQUARE, Size, mean, scenes};
use crate::image_mean::ImageEstimatorKind::Bdpt;
use crate::prelude::*;
use crate::subject::with_altered_parts;

/// An MIS weight.
type Weight = fn(&[Density], usize) -> f64;

/// Selects one strategy: weight 1 for paths of `LENGTH` vertices besides the eye, `S` of them from
/// the light.
fn only<const LENGTH: usize, const S: usize>(path: &[Density], s: usize) -> f64 {
    f64::from(path.len() == LENGTH && s == S)
}

/// Trials in which one strategy alone finds all the light of the paths that it makes.
pub(super) fn alone() -> Vec<FamilyTrial<EstimatorSubject>> {
    let floor = |name, consequence, what, scene, frame, strategy_weight: Weight| {
        let size = Size::sobol(frame, 4, MIN_SYMMETRIC_VALUES);
        let family_trial = mean(name, consequence, Bdpt, &MIS, what, scene, size);
        with_altered_parts(family_trial, move |table| PartTable {
            strategy_weight,
            ..table
        })
    };
    let mut trials = vec![
        floor(
            "bidirectional/alone/hits",
            "bidirectional paths that run into a lamp make its surroundings too bright or dim",
            "a floor under a near light, by hits alone",
            scenes::near(),
            SMALL,
            only::<2, 0>,
        ),
        floor(
            "bidirectional/alone/shadow-rays",
            "shadow rays of bidirectional paths make lit floors too bright or too dark",
            "a floor under a square light, by shadow rays alone",
            scenes::rectangle(false),
            [4, 4],
            only::<2, 1>,
        ),
        floor(
            "bidirectional/alone/seen-particles",
            "particles joined to the camera make lit floors too bright or too dark",
            "a floor under a square light, by particles that the camera sees",
            scenes::rectangle(false),
            SMALL,
            only::<2, 2>,
        ),
    ];
    trials.extend(
        [
            (
                "bidirectional/alone/sphere-hits",
                "indirect light is wrong where eye paths hit a lamp at their end",
                only::<4, 0> as Weight,
            ),
            (
                "bidirectional/alone/sphere-shadow-rays",
                "indirect light is wrong where eye paths end in a shadow ray",
                only::<4, 1>,
            ),
            (
                "bidirectional/alone/sphere-inner-connections",
                "indirect light is wrong where an eye path and a light path join half way",
                only::<4, 2>,
            ),
            (
                "bidirectional/alone/sphere-first-connections",
                "indirect light is wrong where light paths join what the eye sees first",
                only::<4, 3>,
            ),
        ]
        .map(|(name, consequence, weight)| sphere(name, consequence, weight)),
    );
    trials
}

/// Trial of one strategy in a sphere of albedo ρ. Paths of three scatterings have the expectation
/// ρ³ by every strategy, and every single one has that value, as densities are uniform. Roulette
/// would add its noise; walks end after three scatterings instead.
fn sphere(
    name: &'static str,
    consequence: &'static str,
    strategy_weight: Weight,
) -> FamilyTrial<EstimatorSubject> {
    let rho: f64 = 0.5;
    let image = KnownImage {
        scene: scenes::sphere_furnace(rho),
        mean: rho.powi(3),
    };
    let size = Size {
        delta: 0.0,
        ..Size::new(SQUARE, 400)
    };
    let what = "light that a sphere reflects three times, by one strategy alone";
    let family_trial = mean(name, consequence, Bdpt, &PATH_DENSITY, what, image, size);
    with_altered_parts(family_trial, move |table| PartTable {
        strategy_weight,
        survival_by_throughput: |throughput, _| f64::from(throughput.x > 0.1),
        ..table
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
    trial(
        "bidirectional/weights",
        "the weights of all strategies of a path sum to one, in proportion to their densities",
        "bidirectional images are too bright or dark, as light counts more or less than once",
        &PATH_DENSITY,
        "integrator::weight",
        "exact",
        with_parts(Weights),
    )
}
