//! Variances of samplers against closed forms, and how fast the pixel strategies of section 2.7
//! converge on an edge of known coverage.

use glam::DVec3;

use crate::equation::{COSINE_HEMISPHERE, RANDOMISATION, SUPERSAMPLING};
use crate::harness::convergence::{slope, variance_ratio};
use crate::harness::mean::{Values, mean};
use crate::harness::outcome::{Claim, Outcome};
use crate::harness::trial::{Context, Control, Trial};
use crate::pixel::PixelSampling;
use crate::rng::{Stream, uniform, uniform2};
use crate::sampling::{
    cosine_hemisphere, cosine_hemisphere_pdf, uniform_hemisphere, uniform_hemisphere_pdf,
};
use crate::trials::hemisphere::{Pdf, Sampler};

const RATIO_SAMPLES: u64 = 16_000_000;
/// δ of variance ratios and mean squared errors, relative.
const VARIANCE_DELTA: f64 = 0.01;
const EDGE_SAMPLES: u64 = 8_000_000;
/// Groups of replications of a slope; fewer, and their sample skewness alone would spoil the tail.
const GROUPS: u64 = 4_000;
/// Squared errors averaged per group and size.
const REPLICATIONS: u32 = 20;
/// Δ of slopes. A logarithm of a mean of 20 squared errors is biased a little differently at small and
/// large N, which moves the slope by up to 0.005.
const SLOPE_MARGIN: f64 = 0.05;

/// Incoming radiance, its mean over cos θ/π, and the variances of (16) with uniform and cosine samples.
#[derive(Clone, Copy)]
struct Profile {
    name: &'static str,
    radiance: fn(DVec3) -> f64,
    mean: f64,
    uniform: f64,
    cosine: f64,
}

/// By ∫ over cos θ: uniform ∫ (2cL)² dc − m², cosine ∫ L² 2c dc − m².
const PROFILES: [Profile; 4] = [
    Profile {
        name: "cos",
        radiance: |w| w.z,
        mean: 2.0 / 3.0,
        uniform: 4.0 / 5.0 - 4.0 / 9.0,
        cosine: 1.0 / 2.0 - 4.0 / 9.0,
    },
    Profile {
        name: "1-cos",
        radiance: |w| 1.0 - w.z,
        mean: 1.0 / 3.0,
        uniform: 2.0 / 15.0 - 1.0 / 9.0,
        cosine: 1.0 / 6.0 - 1.0 / 9.0,
    },
    Profile {
        name: "cos2",
        radiance: |w| w.z * w.z,
        mean: 1.0 / 2.0,
        uniform: 4.0 / 7.0 - 1.0 / 4.0,
        cosine: 1.0 / 3.0 - 1.0 / 4.0,
    },
    Profile {
        name: "cap",
        radiance: |w| if w.z > 0.9 { 1.0 } else { 0.0 },
        mean: 0.19,
        uniform: 4.0 / 3.0 * (1.0 - 0.729) - 0.0361,
        cosine: 0.19 - 0.0361,
    },
];

/// A way to sample: directions and the pdf by which they are weighted.
type Method = (Sampler, Pdf);
const UNIFORM: Method = (uniform_hemisphere, uniform_hemisphere_pdf);
const COSINE: Method = (cosine_hemisphere, cosine_hemisphere_pdf);

/// Variance of one method over variance of the other, for one profile.
fn ratio(context: &Context, profile: Profile, [a, b]: [Method; 2]) -> Vec<Outcome> {
    let squares = |part: &str, (sampler, pdf): Method, expected: f64| {
        let mut rng = context.rng(part);
        Values::collect(expected, context.n(RATIO_SAMPLES), || {
            let w = sampler(uniform2(&mut rng));
            let value = (profile.radiance)(w) * w.z * std::f64::consts::FRAC_1_PI / pdf(w.z);
            (value - profile.mean).powi(2)
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

/// The squared error of a pixel whose part left of x = c is bright, c uniform in [0, 1): its coverage
/// is c.
fn squared_error(rng: &mut Stream, strategy: PixelSampling, samples: u32) -> f64 {
    let c = uniform(rng);
    let bright = (0..samples)
        .filter(|&i| strategy.position(i, uniform2(rng))[0] < c)
        .count();
    (bright as f64 / f64::from(samples) - c).powi(2)
}

/// The mean squared error of n × n samples on that edge: 1/(12n²) for a grid (an error uniform in
/// ±1/2n), 1/(6n²) at random (E[c(1 − c)] = 1/6), 1/(6n³) jittered (n of the n² cells are cut).
fn edge(context: &Context, strategy: PixelSampling, reference: f64) -> Vec<Outcome> {
    let mut rng = context.rng("edge");
    let values = Values::collect(reference, context.n(EDGE_SAMPLES), || {
        squared_error(&mut rng, strategy, EDGE_SIDE * EDGE_SIDE)
    });
    let delta = VARIANCE_DELTA * reference;
    vec![mean(
        "mean squared error",
        &values,
        reference,
        Claim::Exact { delta },
    )]
}

/// n of the trials of one size.
const EDGE_SIDE: u32 = 4;

/// The slope of ln(mean squared error) against ln N, N = n² samples, n = 1 to 16.
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

fn ratio_trial(profile: Profile) -> Trial {
    Trial {
        name: format!("convergence/ratio-{}", profile.name),
        property: format!(
            "uniform sampling has {:.4} times the variance of cosine sampling",
            profile.uniform / profile.cosine
        ),
        equation: &COSINE_HEMISPHERE,
        subject: "sampling::uniform_hemisphere, sampling::cosine_hemisphere",
        statistic: "variance ratio",
        samples: RATIO_SAMPLES,
        delta: VARIANCE_DELTA,
        assertions: 1,
        run: Box::new(move |c| ratio(c, profile, [UNIFORM, COSINE])),
        controls: vec![Control::new(
            "not-importance-sampling",
            "(18) taken for importance sampling, as the report does: both methods are uniform",
            move |c| ratio(c, profile, [UNIFORM, UNIFORM]),
        )],
    }
}

/// A strategy's name, its form for n, the mean squared error at [`EDGE_SIDE`], and the slope.
type Strategy = (&'static str, fn(u32) -> PixelSampling, f64, f64);

const STRATEGIES: [Strategy; 3] = [
    ("grid", PixelSampling::Grid, 1.0 / 192.0, -1.0),
    ("random", |_| PixelSampling::Random, 1.0 / 96.0, -1.0),
    ("jitter", PixelSampling::Jitter, 1.0 / 384.0, -1.5),
];

fn strategy_trials(index: usize) -> [Trial; 2] {
    let (name, strategy, error, order) = STRATEGIES[index];
    // Each strategy is the other's fault: jitter for the two of order 1, random for jitter.
    let (_, other, ..) = STRATEGIES[if name == "jitter" { 1 } else { 2 }];
    let trial = |what: &str, property: String, statistic, samples, delta| Trial {
        name: format!("convergence/{name}-{what}"),
        property,
        equation: if name == "grid" {
            &SUPERSAMPLING
        } else {
            &RANDOMISATION
        },
        subject: "pixel::PixelSampling::position",
        statistic,
        samples,
        delta,
        assertions: 1,
        run: Box::new(|_| Vec::new()),
        controls: Vec::new(),
    };
    let wrong = "another strategy in its place";
    [
        Trial {
            run: Box::new(move |c| edge(c, strategy(EDGE_SIDE), error)),
            controls: vec![Control::new("other", wrong, move |c| {
                edge(c, other(EDGE_SIDE), error)
            })],
            ..trial(
                "error",
                format!("the mean squared error on an edge is {error:.6}"),
                "t",
                EDGE_SAMPLES,
                VARIANCE_DELTA,
            )
        },
        Trial {
            run: Box::new(move |c| edge_slope(c, strategy, order)),
            controls: vec![Control::new("other", wrong, move |c| {
                edge_slope(c, other, order)
            })],
            ..trial(
                "slope",
                format!("the squared error falls with the power {order} of the number of samples"),
                "t of slopes",
                GROUPS,
                SLOPE_MARGIN,
            )
        },
    ]
}

/// Every trial of variances and orders of convergence.
pub fn trials() -> Vec<Trial> {
    let ratios = PROFILES.into_iter().map(ratio_trial);
    ratios
        .chain((0..STRATEGIES.len()).flat_map(strategy_trials))
        .collect()
}
