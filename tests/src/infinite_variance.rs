//! Roulette where its variance is infinite: survival at most the squared albedo.
//!
//! The mean is unbiased, but the second moment does not exist: a t test of the mean is valid for no
//! number of samples, and cannot conclude equivalence. Two things can be tested instead. The whole
//! distribution is known: with albedo a and survival q a walk of k bounces is worth x_k =
//! Σ (a/q)^j over j ≤ k and has probability (1 − q) q^k, from which the mean follows by summation.
//! And min(X, x_c) is bounded, with a closed form of its mean, so that the empirical Bernstein
//! inequality holds for it.

use whitefurnace::harness::chi_square::{CELL_DELTA, Counts, chi_square};
use whitefurnace::harness::mean::bounded_mean;
use whitefurnace::harness::pointwise::LargestError;

use crate::furnace::inside;
use crate::prelude::*;
use crate::roulette::{SUBJECT, WalkParts, variance, walk};
use crate::scenes::{mirror, sphere_furnace};

/// Albedo, for which survivals up to 0.81 have infinite variance.
const ALBEDO: f64 = 0.9;
/// Survival: the tail of the law falls with the power ln q/ln(q/a) = 1.58.
const SURVIVAL: f64 = 0.75;

/// How far the value of a walk may be from the law's: rounding of at most some hundred operations.
const ROUNDING: f64 = 1e-12;
/// Cells of the chi-square test: 0, 1, 2, 3 bounces, and more.
const CELLS: usize = 5;

/// The law of the estimate in a furnace of this albedo under constant survival, both in (0, 1) and
/// different.
#[derive(Clone, Copy)]
struct Law {
    albedo: f64,
    survival: f64,
}

const LAW: Law = Law {
    albedo: ALBEDO,
    survival: SURVIVAL,
};

impl Law {
    /// Value of a walk of k bounces: x_k = (r^(k+1) − 1)/(r − 1) with r = a/q.
    fn value(self, bounces: u32) -> f64 {
        let r = self.albedo / self.survival;
        (r.powi(bounces as i32 + 1) - 1.0) / (r - 1.0)
    }

    /// Probability of k bounces: (1 − q) q^k.
    fn probability(self, bounces: u32) -> f64 {
        (1.0 - self.survival) * self.at_least(bounces)
    }

    /// Probability of k bounces or more: q^k.
    fn at_least(self, bounces: u32) -> f64 {
        self.survival.powi(bounces as i32)
    }

    /// Returns the number of bounces of a value; `None` for a value that the law does not have.
    fn bounces(self, value: f64) -> Option<u32> {
        let r = self.albedo / self.survival;
        let bounces = ((1.0 + value * (r - 1.0)).ln() / r.ln()).round() - 1.0;
        // A cast of NaN or of a negative number gives 0, whose value is then compared.
        let bounces = bounces as u32;
        let expected = self.value(bounces);
        ((value - expected).abs() <= ROUNDING * expected).then_some(bounces)
    }

    /// Mean of the bounded values: E[min(X, x_c)].
    fn mean_up_to(self, c: u32) -> f64 {
        let below: f64 = (0..c).map(|k| self.probability(k) * self.value(k)).sum();
        below + self.at_least(c) * self.value(c)
    }
}

/// Compares values of `draw` with the law: their frequencies (any other value is forbidden), and
/// the mean of min(X, x_c) by empirical Bernstein.
fn against_the_law(n: u64, c: u32, mut draw: impl FnMut() -> f64) -> Vec<Outcome> {
    let mut counts = Counts {
        n,
        observed: vec![0; CELLS],
        ..Counts::default()
    };
    let (highest, reference) = (LAW.value(c), LAW.mean_up_to(c));
    let mut values = Values::new(reference);
    for _ in 0..n {
        let value = draw();
        match LAW.bounces(value) {
            Some(bounces) => counts.observed[(bounces as usize).min(CELLS - 1)] += 1,
            None => {
                counts.forbidden += 1;
                counts.example.get_or_insert(DVec3::splat(value));
            }
        }
        values.push(value.clamp(0.0, highest));
    }
    let last = CELLS as u32 - 1;
    let masses = (0..last).map(|k| LAW.probability(k));
    let places = (0..last).map(|k| format!("{k} bounces"));
    let partition = Partition::from_masses(
        masses.chain([LAW.at_least(last)]).collect(),
        places.chain([format!("{last} bounces or more")]).collect(),
    );
    let delta = BOUNCES_DELTA * reference;
    vec![
        chi_square("values of the law", &partition, &counts, CELL_DELTA),
        bounded_mean(
            "radiance",
            &values,
            reference,
            [0.0, highest],
            Claim::Equal { delta },
        ),
    ]
}

const WALKS: u64 = 9_000_000;

/// Compares walks with the law.
fn law(context: &Context, parts: WalkParts) -> Vec<Outcome> {
    let mut rng = context.rng("law");
    against_the_law(context.n(WALKS), 8, || {
        walk(&mut rng, parts, ALBEDO, SURVIVAL)
    })
}

/// Survivals, in units of the squared albedo, on both sides of the boundary.
const SURVIVALS: [f64; 3] = [0.95, 1.0, 1.1];
/// Number of terms of the sums over the law: the remainder is about 1.1^-400 = 3e-17 of the whole.
const TERMS: u32 = 400;
/// Relative tolerance of those sums.
const SUM_TOLERANCE: f64 = 1e-9;

/// Compares the mean and the second moment with closed forms, by summation over the number of
/// bounces of their probabilities and of the values that walks return. The mean is 1/(1 − a) on
/// both sides of the boundary; the second moment has the closed form where survival exceeds the
/// squared albedo, and elsewhere its terms never fall.
fn boundary(context: &Context, parts: WalkParts) -> Vec<Outcome> {
    let mut rng = context.rng("walks of given length");
    let [mut mean_error, mut moment_error] = [LargestError::default(), LargestError::default()];
    let mut pairs = 0;
    for a in [0.5, 0.75, 0.9] {
        for q in SURVIVALS.map(|side| side * a * a) {
            pairs += 1;
            let mut value = |bounces| {
                let certain = WalkParts {
                    survives: |_, _| true,
                    longest: Some(bounces),
                    ..parts
                };
                walk(&mut rng, certain, a, q)
            };
            let term = |(k, x): (i32, f64)| (1.0 - q) * q.powi(k) * x;
            let values: Vec<f64> = (0..TERMS).map(&mut value).collect();
            let weighted = |power: i32| {
                let powers = values.iter().map(move |x| x.powi(power));
                (0..).zip(powers).map(term)
            };
            let mean = 1.0 / (1.0 - a);
            let place = || format!("albedo {a}, survival {q}");
            mean_error.update((weighted(1).sum::<f64>() / mean - 1.0).abs(), place);
            let second = variance(a, q) + mean * mean;
            let error = if second.is_finite() {
                (weighted(2).sum::<f64>() / second - 1.0).abs()
            } else {
                let terms: Vec<f64> = weighted(2).collect();
                let falls = |pair: &[f64]| 1.0 - pair[1] / pair[0];
                terms.windows(2).map(falls).fold(0.0, f64::max)
            };
            moment_error.update(error, place);
        }
    }
    let exact = |name, worst: LargestError| {
        Outcome::identity(name, pairs, worst.error, SUM_TOLERANCE, worst.place)
    };
    vec![
        exact("mean by summation", mean_error),
        exact("second moment by summation", moment_error),
    ]
}

/// Trials of the abstract furnace.
pub fn trials() -> Vec<FamilyTrial<WalkParts>> {
    vec![
        trial(
            "roulette/infinite-variance/law",
            format!("at albedo {ALBEDO} and survival {SURVIVAL} the walk has its closed-form law"),
            "a long render settles on too dark a room: rare, very bright paths are missing",
            &ROULETTE,
            SUBJECT,
            "chi-square, empirical Bernstein",
            law,
        ),
        trial(
            "roulette/infinite-variance/boundary",
            "the variance is finite exactly for survival above the squared albedo, the mean right on both sides",
            "advice on how often roulette may end paths is wrong: fireflies never cease",
            &ROULETTE,
            SUBJECT,
            "exact",
            boundary,
        ),
    ]
}

const PATHS: u64 = 3_800_000;

/// Trial of the path tracer with survival 0.75 in a hall of emitting mirrors of reflectance 0.9:
/// its radiance follows the same law, as no direction changes it.
pub fn hall() -> FamilyTrial<EstimatorSubject> {
    let probe = Probe {
        scene: sphere_furnace(mirror(ALBEDO), 0.0),
        kind: EstimatorKind::Path,
        ray: inside,
    };
    trial(
        "furnace/mirrors/infinite-variance",
        format!(
            "in a hall of mirrors of reflectance {ALBEDO} survival {SURVIVAL} gives the closed-form law"
        ),
        "halls of mirrors settle on a wrong brightness where roulette leaves fireflies",
        &ROULETTE,
        "integrator::Path",
        "chi-square, empirical Bernstein",
        move |context: &Context, subject: EstimatorSubject| {
            let subject = subject.altered(|table| PartTable {
                survival_by_throughput: |_, _| SURVIVAL,
                ..table
            });
            let mut radiance =
                probe.radiances(subject.configuration(), context.seed_of("radiance"));
            against_the_law(context.n(PATHS), 4, || radiance().x)
        },
    )
}
