//! Survival policies of Russian roulette: the path tracer's own in detail, and three of them in one
//! scene. Whatever the survival probability, the mean is unbiased.

use whitefurnace::harness::mean::welch;
use whitefurnace::sampling::roulette;
use whitefurnace::sampling::roulette::MAX_SURVIVAL;
use whitefurnace::scene::simple::{Cap, cavity_cap};

use crate::furnace::{off_cap, off_cap_radiance};
use crate::mean_radiance::scramble_means;
use crate::prelude::*;
use crate::scenes::valid;

/// Survival probability from the throughput, at an early hit or not.
pub type Survival = fn(DVec3, bool) -> f64;

/// A policy that depends on the throughput, and the factor of survivors.
#[derive(Clone, Copy)]
pub struct Policy {
    /// Survival probability from the throughput, at an early hit or not.
    pub survival: Survival,
    /// Factor of a survivor's throughput, from the survival probability.
    pub weight: fn(f64) -> f64,
}

const BY_THROUGHPUT: Policy = Policy {
    survival: roulette::by_throughput,
    weight: roulette::weight,
};

/// Albedos of the two surfaces that a walk meets with equal probability. One reflects all of a
/// channel, so that the highest survival matters, and nothing of another.
const COLOURS: [DVec3; 2] = [DVec3::new(1.0, 0.4, 0.0), DVec3::new(0.2, 0.8, 0.6)];

/// Number of early hits of a walk.
const RR_DEPTH: u32 = 2;

/// Hits after which a walk is abandoned as endless, which is a fault.
const MAX_BOUNCES: u32 = 2_000;

/// Returns the radiance of a walk between surfaces that emit 1, the throughput handled as by
/// [`whitefurnace::integrator::Path`]. Calls `see` at every decision with the throughput before it,
/// the highest survival allowed, the survival, and the throughput of a survivor.
fn walk(rng: &mut Stream, policy: Policy, mut see: impl FnMut(DVec3, f64, f64, DVec3)) -> DVec3 {
    let (mut radiance, mut throughput) = (DVec3::ONE, DVec3::ONE);
    for hit in 0..MAX_BOUNCES {
        let early = hit < RR_DEPTH;
        let before = throughput * COLOURS[usize::from(uniform(rng) < 0.5)];
        let survival = (policy.survival)(before, early);
        throughput = before * (policy.weight)(survival);
        see(
            before,
            if early { 1.0 } else { MAX_SURVIVAL },
            survival,
            throughput,
        );
        if !roulette::survives(uniform(rng), survival) {
            break;
        }
        radiance += throughput;
    }
    radiance
}

const WALKS: u64 = 4_500_000;

/// Compares the mean of each channel with 1/(1 − ā), where ā is the mean albedo.
fn channels(context: &Context, policy: Policy) -> Vec<Outcome> {
    let [x, y, z] = (DVec3::ONE / (DVec3::ONE - 0.5 * (COLOURS[0] + COLOURS[1]))).to_array();
    let about = [
        ("first channel", x),
        ("second channel", y),
        ("third channel", z),
    ];
    let mut rng = context.rng("walks");
    means(
        about.map(|(name, reference)| (name, reference, BOUNCES_DELTA * reference)),
        context.n(WALKS),
        || walk(&mut rng, policy, |_, _, _, _| ()).to_array(),
    )
}

const BOUNDED_WALKS: u64 = 100_000;
/// Rounding of a division and a product.
const ROUNDING: f64 = 1e-15;

/// Tests that survival is at most 1 at early hits and [`MAX_SURVIVAL`] at others, and that a
/// survivor's largest channel is 1, or its former value divided by the highest survival.
fn bounds(context: &Context, policy: Policy) -> Vec<Outcome> {
    let mut rng = context.rng("bounds");
    let [mut excess, mut largest] = [0.0_f64; 2];
    let n = context.n(BOUNDED_WALKS);
    for _ in 0..n {
        walk(&mut rng, policy, |before, highest, survival, after| {
            excess = excess.max(survival - highest);
            if survival > 0.0 {
                let bound = (before.max_element() / highest).max(1.0);
                largest = largest.max((after.max_element() / bound - 1.0).abs());
            }
        });
    }
    vec![
        Outcome::identity(
            "survival above the highest",
            n,
            excess,
            0.0,
            "the worst of all decisions",
        ),
        Outcome::identity(
            "largest channel of a survivor",
            n,
            largest,
            ROUNDING,
            "the worst of all decisions, relative",
        ),
    ]
}

fn trials() -> Vec<FamilyTrial<Policy>> {
    let subject = "sampling::roulette::by_throughput";
    vec![
        trial(
            "roulette/by-throughput/mean",
            "survival by the largest channel of the throughput preserves the mean of every channel",
            "light of one colour is lost where roulette looks at another",
            &ROULETTE,
            subject,
            "t",
            channels,
        ),
        trial(
            "roulette/by-throughput/bounds",
            "survival is at most 1 at early hits and 0.95 later, and a survivor's largest channel 1 or what it was divided by that",
            "renders between mirrors never end, or survivors become fireflies",
            &ROULETTE,
            subject,
            "exact",
            bounds,
        ),
    ]
}

fn faults() -> Vec<Fault<Policy>> {
    vec![
        fault!("no-weight", ROULETTE, "survivors are not divided by the survival",
            = Policy { weight: |_| 1.0, ..BY_THROUGHPUT },
            "roulette/by-throughput/mean: first channel | second channel | third channel",
            "roulette/by-throughput/bounds: largest channel of a survivor"),
        fault!("smallest-channel", ROULETTE, "the smallest channel decides: where it is 0, the others are lost",
            = Policy { survival: |t, _| t.min_element().min(MAX_SURVIVAL), ..BY_THROUGHPUT },
            "roulette/by-throughput/mean: first channel"),
        fault!("average-channel", ROULETTE, "the average of the channels decides: the mean stays, weights grow",
            = Policy { survival: |t, _| (t.element_sum() / 3.0).min(MAX_SURVIVAL), ..BY_THROUGHPUT },
            "roulette/by-throughput/bounds: largest channel of a survivor"),
        fault!("immortal", ROULETTE, "no highest survival: a path between perfect mirrors never ends",
            = Policy { survival: |t, _| t.max_element(), ..BY_THROUGHPUT },
            "roulette/by-throughput/bounds: survival above the highest"),
    ]
}

/// Trials and faults of the path tracer's policy.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    vec![Box::new(Family {
        trials: trials(),
        faults: faults(),
        ..Family::new("survival", BY_THROUGHPUT)
    })]
}

/// Albedo of the cavity in which the policies are compared.
const RHO: f64 = 0.6;
/// Rays per scramble.
const POINTS: u16 = 64;
const SCRAMBLES: u64 = 27_000;

/// Policies that must give the same mean as [`roulette::by_throughput`] in the cavity, with their
/// numbers of scrambles: a constant, and the report's 1 − α, where the walls absorb α = 1 − ρ.
const OTHER_POLICIES: [(&str, Survival, u64); 2] = [
    ("survival 0.9", |_, _| 0.9, 9_500),
    (
        "survival 1 − α",
        |_, _| roulette::by_absorption(1.0 - RHO),
        19_000,
    ),
];

/// Compares the path tracer as programs run it with the path tracer under each other policy, with
/// the subject's components.
fn same_mean(context: &Context, probe: &Probe, subject: EstimatorSubject) -> Vec<Outcome> {
    let reference = off_cap_radiance(RHO, Cap::Black);
    let values = |name, subject: &EstimatorSubject, count| {
        let estimator = probe.kind.estimator(subject.configuration());
        let seed = context.seed_of(name);
        let means = scramble_means(seed, POINTS, &probe.scene, estimator, probe.ray);
        Values::collect(reference, context.n(count), means)
    };
    let by_throughput = values("survival by throughput", &STANDARD, SCRAMBLES);
    let claim = Claim::Equal {
        delta: BOUNCES_DELTA * reference,
    };
    OTHER_POLICIES
        .iter()
        .map(|&(name, survival_by_throughput, scrambles)| {
            let subject = subject.altered(|table| PartTable {
                survival_by_throughput,
                ..table
            });
            let other = values(name, &subject, scrambles);
            welch(name, &by_throughput, &other, claim)
        })
        .collect()
}

/// Returns the trial of the policies in a cavity.
pub fn cavity() -> FamilyTrial<EstimatorSubject> {
    let probe = Probe {
        scene: valid(cavity_cap(RHO, Cap::Black)),
        kind: EstimatorKind::Path,
        ray: off_cap,
    };
    trial(
        "furnace/cavity/policies",
        "in a cavity the path tracer has the same mean with survival by throughput, 0.9, and 1 − α",
        "choosing another roulette changes how bright a room is",
        &ROULETTE,
        "integrator::Path, sampling::roulette::by_throughput",
        "Welch",
        move |context, subject| same_mean(context, &probe, subject),
    )
}
