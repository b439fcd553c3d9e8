//! Variances of samplers against closed forms, and how fast the pixel strategies of section 2.7
//! converge on an edge of known coverage.

use whitefurnace::harness::convergence::{slope, variance_ratio};
use whitefurnace::harness::mean::MIN_SYMMETRIC_VALUES;
use whitefurnace::sampling::pixel::PixelSampling;

use crate::hemisphere::Method;
use crate::prelude::*;

/// Relative δ of variance ratios and mean squared errors.
const VARIANCE_DELTA: f64 = 0.01;
/// Samples by each method, for each profile. Radiances of a small disc are rare and equal: their squares vary most.
const RATIO_SAMPLES: [u64; 4] = [4_200_000, 4_200_000, 4_300_000, 15_000_000];
const EDGE_SAMPLES: u64 = 3_900_000;
/// Number of groups of replications from which a slope is estimated.
const GROUPS: u64 = MIN_SYMMETRIC_VALUES;
/// Squared errors averaged per group and size.
const REPLICATIONS: u32 = 20;
/// Δ of slopes. A logarithm of a mean of 20 squared errors is biased a little differently at small
/// and large N, which moves the slope by up to 0.005.
const SLOPE_MARGIN: f64 = 0.05;

/// A profile of incoming radiance with its closed forms: the mean and the variances of (16).
#[derive(Clone, Copy)]
pub struct Profile {
    /// Its name.
    pub name: &'static str,
    /// The incoming light, in words.
    pub light: &'static str,
    /// Incoming radiance from a local direction.
    pub radiance: fn(DVec3) -> f64,
    /// Mean under the density cos θ/π.
    pub mean: f64,
    /// Variance with uniform samples.
    pub uniform: f64,
    /// Variance with cosine-weighted samples.
    pub cosine: f64,
}

impl Profile {
    /// Returns the estimate (16) from one direction.
    pub fn estimate(&self, method: Method, random: [f64; 2]) -> f64 {
        let w = (method.sampler)(random);
        (self.radiance)(w) * w.z * FRAC_1_PI / (method.pdf)(w.z)
    }
}

/// Profiles with variances by integration over c = cos θ: uniform ∫ (2cL)² dc − m², cosine ∫ L² 2c
/// dc − m².
pub const PROFILES: [Profile; 4] = [
    Profile {
        name: "cos",
        light: "strongest overhead",
        radiance: |w| w.z,
        mean: 2.0 / 3.0,
        uniform: 4.0 / 5.0 - 4.0 / 9.0,
        cosine: 1.0 / 2.0 - 4.0 / 9.0,
    },
    Profile {
        name: "1-cos",
        light: "strongest at the horizon",
        radiance: |w| 1.0 - w.z,
        mean: 1.0 / 3.0,
        uniform: 2.0 / 15.0 - 1.0 / 9.0,
        cosine: 1.0 / 6.0 - 1.0 / 9.0,
    },
    Profile {
        name: "cos2",
        light: "concentrated overhead",
        radiance: |w| w.z * w.z,
        mean: 1.0 / 2.0,
        uniform: 4.0 / 7.0 - 1.0 / 4.0,
        cosine: 1.0 / 3.0 - 1.0 / 4.0,
    },
    Profile {
        name: "cap",
        light: "a disc overhead",
        radiance: |w| if w.z > 0.9 { 1.0 } else { 0.0 },
        mean: 0.19,
        uniform: 4.0 / 3.0 * (1.0 - 0.729) - 0.0361,
        cosine: 0.19 - 0.0361,
    },
];

/// Compares the variance of one method over that of the other with its closed form, for one
/// profile.
fn ratio(context: &Context, profile: Profile, samples: u64, [a, b]: [Method; 2]) -> Vec<Outcome> {
    let squares = |part: &str, method: Method, expected: f64| {
        let mut rng = context.rng(part);
        Values::collect(expected, context.n(samples), || {
            (profile.estimate(method, uniform2(&mut rng)) - profile.mean).powi(2)
        })
    };
    vec![variance_ratio(
        "variance of uniform over cosine sampling",
        &squares("uniform", a, profile.uniform),
        &squares("cosine", b, profile.cosine),
        profile.uniform / profile.cosine,
        VARIANCE_DELTA,
    )]
}

/// Squared error of a pixel that is bright left of x = c, c uniform in [0, 1), so that its coverage
/// is c.
pub fn squared_error(rng: &mut Stream, strategy: PixelSampling, samples: u32) -> f64 {
    let c = uniform(rng);
    let bright = (0..samples)
        .filter(|&i| strategy.position(i, uniform2(rng))[0] < c)
        .count();
    (bright as f64 / f64::from(samples) - c).powi(2)
}

/// Compares the mean squared error of n × n samples of that edge with its closed form: 1/(12n²) for
/// a grid (an error uniform in ±1/2n), 1/(6n²) at random (E[c(1 − c)] = 1/6), 1/(6n³) jittered (n
/// of the n² cells are cut).
fn edge(context: &Context, strategy: PixelSampling, reference: f64) -> Vec<Outcome> {
    let mut rng = context.rng("edge");
    let value = || squared_error(&mut rng, strategy, EDGE_SIDE * EDGE_SIDE);
    vec![mean_of(
        "mean squared error",
        reference,
        VARIANCE_DELTA,
        context.n(EDGE_SAMPLES),
        value,
    )]
}

/// n in the trials of one size.
const EDGE_SIDE: u32 = 4;

/// Compares the slope of ln(mean squared error) against ln N, N = n² samples, n = 1 to 16, with its
/// closed form.
fn edge_slope(
    context: &Context,
    strategy: fn(u32) -> PixelSampling,
    reference: f64,
) -> Vec<Outcome> {
    const SIDES: [u32; 5] = [1, 2, 4, 8, 16];
    let mut rng = context.rng("slope");
    let groups: Vec<Vec<f64>> = (0..context.n(GROUPS))
        .map(|_| {
            let error = |n: u32| {
                let sum: f64 = (0..REPLICATIONS)
                    .map(|_| squared_error(&mut rng, strategy(n), n * n))
                    .sum();
                sum / f64::from(REPLICATIONS)
            };
            SIDES.map(error).to_vec()
        })
        .collect();
    let sizes = SIDES.map(|n| f64::from(n * n));
    vec![slope(
        "slope of the error",
        &sizes,
        &groups,
        reference,
        SLOPE_MARGIN,
    )]
}

fn ratio_bench(profile: Profile, samples: u64) -> FamilyTrial<[Method; 2]> {
    let ratio_of = profile.uniform / profile.cosine;
    trial(
        format!("convergence/ratio-{}", profile.name),
        format!("uniform sampling has {ratio_of:.4} times the variance of cosine sampling"),
        format!(
            "light that is {} is noisier than the choice of sampler promises",
            profile.light
        ),
        &COSINE_HEMISPHERE,
        "sampling::warp::uniform_hemisphere, sampling::warp::cosine_hemisphere",
        "variance ratio",
        move |c, methods| ratio(c, profile, samples, methods),
    )
}

fn ratios() -> Family<[Method; 2]> {
    Family {
        trials: PROFILES
            .into_iter()
            .zip(RATIO_SAMPLES)
            .map(|(profile, samples)| ratio_bench(profile, samples))
            .collect(),
        faults: vec![fault!("not-importance-sampling", COSINE_HEMISPHERE,
            "(18) taken for importance sampling, as the report does: both methods are uniform",
            = [Method::UNIFORM, Method::UNIFORM],
            "convergence/ratio-cos", "convergence/ratio-1-cos", "convergence/ratio-cos2", "convergence/ratio-cap")],
        ..Family::new("variance", [Method::UNIFORM, Method::COSINE])
    }
}

/// Returns the strategy for n × n samples.
type Strategy = fn(u32) -> PixelSampling;

fn strategy_benches(name: &'static str, error: f64, order: f64) -> Vec<FamilyTrial<Strategy>> {
    let equation = if name == "grid" {
        &SUPERSAMPLING
    } else {
        &RANDOMISATION
    };
    let subject = "sampling::pixel::PixelSampling::position";
    vec![
        trial(
            format!("convergence/{name}-error"),
            format!("the mean squared error on an edge is {error:.6}"),
            format!(
                "edges in a picture are rougher than {name} sampling of pixels should leave them"
            ),
            equation,
            subject,
            "t",
            move |c, strategy: Strategy| edge(c, strategy(EDGE_SIDE), error),
        ),
        trial(
            format!("convergence/{name}-slope"),
            format!("the squared error falls with the power {order} of the number of samples"),
            format!("more samples by {name} sampling smooth the edges in a picture too slowly"),
            equation,
            subject,
            "t of slopes",
            move |c, strategy: Strategy| edge_slope(c, strategy, order),
        ),
    ]
}

const RANDOM: Strategy = |_| PixelSampling::Random;

/// Trials and faults of sampling variances and of pixel strategies, each strategy a fault under the
/// others' trials.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    let trials = strategy_benches;
    vec![
        Box::new(ratios()),
        Box::new(Family {
            trials: trials("grid", 1.0 / 192.0, -1.0),
            faults: vec![
                fault!("jitter", SUPERSAMPLING, "the sub-pixels' points are random",
                    = PixelSampling::Jitter, "convergence/grid-error", "convergence/grid-slope"),
                fault!("centre", SUPERSAMPLING, "every ray through the centre: more samples change nothing",
                    = |_| PixelSampling::Centre, "convergence/grid-error", "convergence/grid-slope"),
            ],
            ..Family::new("grid", PixelSampling::Grid as Strategy)
        }),
        Box::new(Family {
            trials: trials("random", 1.0 / 96.0, -1.0),
            faults: vec![
                fault!("jitter", RANDOMISATION, "one random point in each sub-pixel",
                = PixelSampling::Jitter, "convergence/random-error", "convergence/random-slope"),
            ],
            ..Family::new("random", RANDOM)
        }),
        Box::new(Family {
            trials: trials("jitter", 1.0 / 384.0, -1.5),
            faults: vec![
                fault!("random", RANDOMISATION, "random points in the whole pixel",
                    = RANDOM, "convergence/jitter-error", "convergence/jitter-slope"),
                fault!("grid", RANDOMISATION, "the sub-pixels' centres: no randomness",
                    = PixelSampling::Grid, "convergence/jitter-error", "convergence/jitter-slope"),
            ],
            ..Family::new("jitter", PixelSampling::Jitter as Strategy)
        }),
    ]
}
