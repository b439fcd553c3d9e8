//! Russian roulette and path length in an abstract closed furnace: a walk in which every surface
//! emits 1 and reflects the fraction a, so that the radiance is 1/(1 − a).

use whitefurnace::harness::mean::welch;
use whitefurnace::sampling::roulette;

use crate::infinite_variance;
use crate::prelude::*;

/// Walks per squared ratio of a walk's standard deviation and δ: enough for a mean to detect δ,
/// which must be 12.3 standard errors.
const WALKS_PER_RATIO: f64 = 160.0;
/// Walks of a mean, where it takes fewer to detect δ.
const MIN_WALKS: f64 = 250_000.0;
/// Walks of each policy whose means are compared.
const COMPARED_WALKS: u64 = 5_600_000;
/// Walks of each length at which paths are cut.
const CUT_WALKS: u64 = 1_250_000;
const VARIANCE_SAMPLES: u64 = 13_200_000;
/// Samples of a variance where survival exceeds albedo: throughput falls at each bounce, so that
/// estimates are bounded.
const BOUNDED_VARIANCE_SAMPLES: u64 = 5_400_000;
/// Relative δ of multi-bounce means.
const MEAN_DELTA: f64 = 0.005;
/// Relative δ of variances.
const VARIANCE_DELTA: f64 = 0.01;

/// The functions and limits of roulette, so that each can be replaced.
#[derive(Clone, Copy)]
pub struct WalkParts {
    /// Returns whether the path survives, from a random number and the survival probability.
    pub survives: fn(f64, f64) -> bool,
    /// Factor of a survivor's throughput, from the survival probability.
    pub weight: fn(f64) -> f64,
    /// Number of bounces after which the path is cut, if at all.
    pub longest: Option<u32>,
    /// Factor of emission, from the survival probability that follows it.
    pub emission: fn(f64) -> f64,
    /// Bounces that a cut path makes beyond `longest`.
    pub extra_bounces: u32,
}

/// The correct functions.
pub const CORRECT: WalkParts = WalkParts {
    survives: roulette::survives,
    weight: roulette::weight,
    longest: None,
    emission: |_| 1.0,
    extra_bounces: 0,
};

/// Bounces after which a walk is abandoned as endless, a fault of roulette: no correct walk is so
/// long (0.95^2000 = 3e-45).
const MAX_BOUNCES: u32 = 2_000;

/// Returns one estimate of the furnace's radiance.
pub fn walk(rng: &mut Stream, parts: WalkParts, albedo: f64, survival: f64) -> f64 {
    let (mut radiance, mut throughput) = ((parts.emission)(survival), 1.0);
    for _ in 0..parts.longest.unwrap_or(MAX_BOUNCES) {
        if !(parts.survives)(uniform(rng), survival) {
            break;
        }
        throughput *= albedo * (parts.weight)(survival);
        radiance += throughput * (parts.emission)(survival);
    }
    radiance
}

/// Compares the mean with 1/(1 − a).
fn mean_is_right(context: &Context, parts: WalkParts, [a, q]: [f64; 2]) -> Vec<Outcome> {
    let mut rng = context.rng("mean");
    let reference = 1.0 / (1.0 - a);
    let walks = WALKS_PER_RATIO * variance(a, q) / (MEAN_DELTA * reference).powi(2);
    vec![mean_of(
        "furnace radiance",
        reference,
        MEAN_DELTA,
        context.n(walks.max(MIN_WALKS) as u64),
        || walk(&mut rng, parts, a, q),
    )]
}

/// Var = (1 + 2a m)/(1 − a²/q) − m² with m = 1/(1 − a): from X = 1 + (a/q) X′ for survivors.
/// Infinite for q ≤ a².
pub fn variance(a: f64, q: f64) -> f64 {
    let m = 1.0 / (1.0 - a);
    if q <= a * a {
        return f64::INFINITY;
    }
    (1.0 + 2.0 * a * m) / (1.0 - a * a / q) - m * m
}

/// Compares the mean of (X − m)² with the closed form of the variance.
fn variance_is_right(context: &Context, parts: WalkParts, [a, q]: [f64; 2]) -> Vec<Outcome> {
    let mut rng = context.rng("variance");
    let square = || (walk(&mut rng, parts, a, q) - 1.0 / (1.0 - a)).powi(2);
    let samples = if q > a {
        BOUNDED_VARIANCE_SAMPLES
    } else {
        VARIANCE_SAMPLES
    };
    vec![mean_of(
        "variance",
        variance(a, q),
        VARIANCE_DELTA,
        context.n(samples),
        square,
    )]
}

/// Compares the means of two survival policies.
fn same_mean(context: &Context, parts: [WalkParts; 2], a: f64, q: [f64; 2]) -> Vec<Outcome> {
    let [first, second] = [0, 1].map(|i| {
        let mut rng = context.rng(["first", "second"][i]);
        Values::collect(1.0 / (1.0 - a), context.n(COMPARED_WALKS), || {
            walk(&mut rng, parts[i], a, q[i])
        })
    });
    let delta = MEAN_DELTA / (1.0 - a);
    vec![welch(
        "difference of means",
        &first,
        &second,
        Claim::Equal { delta },
    )]
}

/// Compares the means of paths that are cut after b bounces with (1 − a^(b+1))/(1 − a), for b from
/// 1 to 12. The path is cut after b + `extra_bounces` bounces: 0 is correct.
fn truncation(context: &Context, parts: WalkParts, a: f64) -> Vec<Outcome> {
    let cut = |b: u32| {
        let reference = (1.0 - a.powi(b as i32 + 1)) / (1.0 - a);
        let parts = WalkParts {
            longest: Some(b + parts.extra_bounces),
            ..parts
        };
        let name = format!("{b} bounces");
        let mut rng = context.rng(&name);
        let values = Values::collect(1.0 / (1.0 - a), context.n(CUT_WALKS), || {
            walk(&mut rng, parts, a, 0.95)
        });
        mean(
            &name,
            &values,
            reference,
            Claim::Equal {
                delta: MEAN_DELTA * reference,
            },
        )
    };
    (1..=12).map(cut).collect()
}

/// Pairs (albedo, survival). From survival = albedo on weights are bounded, lengths geometric, and
/// all moments exist; at (0.5, 0.45) seven do (the tail falls with the power ln q/ln(q/a) = 7.6),
/// enough for the mean. For survival at or below the squared albedo, where the variance is
/// infinite, see [`super::infinite_variance`].
const PAIRS: [[f64; 2]; 9] = [
    [0.5, 0.45],
    [0.5, 0.5],
    [0.5, 0.75],
    [0.5, 0.9],
    [0.75, 0.75],
    [0.75, 0.9],
    [0.75, 0.95],
    [0.9, 0.9],
    [0.9, 0.95],
];

/// The functions that walks test.
pub const SUBJECT: &str = "sampling::roulette::survives, sampling::roulette::weight";

fn pair_benches(pair: [f64; 2]) -> Vec<FamilyTrial<WalkParts>> {
    let [a, q] = pair;
    let name = |what| format!("roulette/albedo-{a}/survival-{q}/{what}");
    let m = 1.0 / (1.0 - a);
    let mut trials = vec![trial(
        name("mean"),
        format!("the mean is {m:.0} whatever the survival"),
        format!("rooms of albedo {a} are too dark or too bright at survival {q}"),
        &ROULETTE,
        SUBJECT,
        "t",
        move |c, parts| mean_is_right(c, parts, pair),
    )];
    if q >= a {
        trials.push(trial(
            name("variance"),
            format!("the variance is {:.6}", variance(a, q)),
            format!("rooms of albedo {a} are noisier than planned at survival {q}"),
            &ROULETTE,
            SUBJECT,
            "t",
            move |c, parts| variance_is_right(c, parts, pair),
        ));
    }
    trials
}

fn trials() -> Vec<FamilyTrial<WalkParts>> {
    let mut trials: Vec<_> = PAIRS.into_iter().flat_map(pair_benches).collect();
    trials.push(trial(
        "roulette/same-mean",
        "survivals 0.75 and 0.9 have the same mean at albedo 0.75",
        "stricter roulette makes a room darker, as in chunky-dev/chunky#1018",
        &ROULETTE,
        SUBJECT,
        "Welch",
        |c, parts| same_mean(c, [CORRECT, parts], 0.75, [0.75, 0.9]),
    ));
    trials.extend([0.5, 0.75, 0.9].map(|a| {
        trial(
            format!("roulette/albedo-{a}/cut"),
            "a path cut after b bounces has the relative bias −a^(b+1), b = 1 to 12",
            format!("a limit on bounces darkens rooms of albedo {a} more or less than stated"),
            &PATH_LENGTH,
            SUBJECT,
            "t",
            move |c, parts| truncation(c, parts, a),
        )
    }));
    trials.extend(infinite_variance::trials());
    trials
}

/// Names the outcomes of a trial of cut paths that must reject a wrong weight of survivors: all but
/// that of one bounce, where its effect is least.
macro_rules! cut_from_two {
    ($albedo:literal) => {
        concat!(
            "roulette/albedo-",
            $albedo,
            "/cut: 2 bounces | 3 bounces | 4 bounces | 5 bounces | 6 bounces | 7 bounces",
            " | 8 bounces | 9 bounces | 10 bounces | 11 bounces | 12 bounces"
        )
    };
}

fn faults() -> Vec<Fault<WalkParts>> {
    vec![
        fault!("no-weight", ROULETTE, "survivors are not divided by the survival",
            WalkParts: { weight: |_| 1.0 },
            "roulette/albedo-0.5/survival-0.45/mean", "roulette/albedo-0.5/survival-0.5/mean",
            "roulette/albedo-0.5/survival-0.5/variance", "roulette/albedo-0.5/survival-0.75/mean",
            "roulette/albedo-0.5/survival-0.75/variance", "roulette/albedo-0.5/survival-0.9/variance",
            "roulette/albedo-0.75/survival-0.75/mean", "roulette/albedo-0.75/survival-0.75/variance",
            "roulette/albedo-0.75/survival-0.9/variance", "roulette/albedo-0.75/survival-0.95/variance",
            "roulette/albedo-0.9/survival-0.9/mean", "roulette/albedo-0.9/survival-0.9/variance",
            "roulette/albedo-0.9/survival-0.95/variance", "roulette/same-mean",
            "roulette/infinite-variance/law: values of the law | radiance",
            "roulette/infinite-variance/boundary: mean by summation | second moment by summation",
            cut_from_two!(0.5),
            cut_from_two!(0.75),
            cut_from_two!(0.9)),
        fault!("flipped", ROULETTE,
            "survives if r ≥ survival: not seen at survival 1/2, where α and 1 − α are one",
            WalkParts: { survives: |r, q| r >= q }, "roulette/albedo-0.5/survival-0.9/mean",
            "roulette/albedo-0.75/survival-0.9/mean", "roulette/albedo-0.75/survival-0.95/mean",
            "roulette/albedo-0.9/survival-0.95/mean", "roulette/infinite-variance/law: values of the law"),
        fault!("other-share", ROULETTE,
            "divides by α for 1 − α: tried below 1/2, as the mean is infinite above",
            WalkParts: { weight: |q| 1.0 / (1.0 - q) }, "roulette/albedo-0.5/survival-0.45/mean"),
        fault!("weighted-emission", ROULETTE,
            "emission that was counted before the decision is divided as well",
            WalkParts: { emission: |q| 1.0 / q }, "roulette/albedo-0.75/survival-0.9/mean",
            "roulette/infinite-variance/boundary: mean by summation"),
        fault!("cut", PATH_LENGTH, "paths end after seven bounces, called unbiased",
            WalkParts: { longest: Some(7) }, "roulette/albedo-0.75/survival-0.75/mean",
            "roulette/albedo-0.75/survival-0.9/mean", "roulette/infinite-variance/law: radiance"),
        fault!("off-by-one", PATH_LENGTH, "a cut path makes one bounce more than said",
            WalkParts: { extra_bounces: 1 }, "roulette/albedo-0.5/cut: 1 bounces", "roulette/albedo-0.75/cut: 1 bounces",
            "roulette/albedo-0.9/cut: 1 bounces"),
    ]
}

/// Trials and faults of roulette in the abstract furnace.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    vec![Box::new(Family {
        trials: trials(),
        faults: faults(),
        equivalents: vec![
            fault!("upper-end", ROULETTE, "survives if r ≥ 1 − survival: the same probability at the other end",
            WalkParts: { survives: |r, q| r >= 1.0 - q }, "roulette/albedo-0.75/survival-0.9/mean"),
        ],
        ..Family::new("roulette", CORRECT)
    })]
}
