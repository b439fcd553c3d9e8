//! The harness's statistics at small sizes, under a true hypothesis and under effects of known size:
//! what `calibration` and `power` examine.

use whitefurnace::harness::chi_square::{Counts, binomial, chi_square};
use whitefurnace::harness::convergence::variance_ratio;
use whitefurnace::harness::domain::Partition;
use whitefurnace::harness::ks::kolmogorov_smirnov;
use whitefurnace::harness::mean::{Values, bounded_mean, mean, mean_known_sigma, welch};
use whitefurnace::harness::outcome::{ALPHA, Claim, Outcome, Verdict};
use whitefurnace::harness::sequential::{ConfidenceSequence, Decision, Sprt};
use whitefurnace::harness::tails::{
    binomial_cdf, binomial_sf, binomial_two_sided, chi_square_sf, normal_sf, normal_upper,
    student_upper,
};
use whitefurnace::rng::{Stream, uniform};

/// Values per replication.
pub const N: u64 = 4000;
/// Cells of the chi-square test; every second one is heavier by the effect, the others lighter.
const CELLS: usize = 4;
/// The probability of the binomial test's hypothesis.
const SHARE: f64 = 0.3;

const ANY: Claim = Claim::Exact { delta: 1.0 };

/// A statistic and what is known of it.
pub struct Statistic {
    /// Its name.
    pub name: &'static str,
    /// The statistic on fresh values with an effect, in the units of `unit`.
    pub run: fn(&mut Stream, effect: f64) -> Outcome,
    /// One standard error of the estimate: the unit in which effects are measured.
    pub unit: f64,
    /// The probability of rejection at level [`ALPHA`] under an effect, where a closed form is known.
    pub power: Option<fn(effect: f64) -> f64>,
}

/// Two-sided statistics of continuous variables: their p-values are uniform under the hypothesis.
pub fn continuous() -> [Statistic; 6] {
    let n = N as f64;
    let mean_error = (1.0 / 12.0 / n).sqrt();
    [
        Statistic {
            name: "z",
            run: |rng, effect| {
                let sigma = (1.0f64 / 12.0).sqrt();
                mean_known_sigma("z", &uniforms(rng, N, effect), 0.5, sigma, ANY)
            },
            unit: mean_error,
            power: Some(|effect| normal_power(effect / (1.0 / 12.0 / N as f64).sqrt())),
        },
        Statistic {
            name: "t",
            run: |rng, effect| mean("t", &uniforms(rng, N, effect), 0.5, ANY),
            unit: mean_error,
            power: Some(|effect| student_power(effect / (1.0 / 12.0 / N as f64).sqrt(), N - 1)),
        },
        Statistic {
            name: "Welch",
            run: |rng, effect| {
                let a = uniforms(rng, N, effect);
                welch("Welch", &a, &uniforms(rng, 3 * N, 0.0), ANY)
            },
            unit: mean_error * (4.0f64 / 3.0).sqrt(),
            power: Some(|effect| student_power(effect / (1.0 / 9.0 / N as f64).sqrt(), 2 * N)),
        },
        Statistic {
            name: "chi-square",
            run: |rng, effect| {
                let mut counts = Counts {
                    n: N,
                    observed: vec![0; CELLS],
                    ..Counts::default()
                };
                for _ in 0..N {
                    counts.observed[skewed_cell(rng, effect)] += 1;
                }
                let places = (0..CELLS).map(|i| format!("cell {i}")).collect();
                let partition = Partition::of_masses(vec![1.0 / CELLS as f64; CELLS], places);
                chi_square("cells", &partition, &counts, 1.0)
            },
            unit: 1.0 / n.sqrt(),
            power: Some(|effect| {
                noncentral_chi_square_sf(CELLS as f64 - 1.0, N as f64 * effect * effect)
            }),
        },
        Statistic {
            name: "Kolmogorov-Smirnov",
            run: |rng, effect| {
                let mut values: Vec<f64> = (0..N).map(|_| uniform(rng) + effect).collect();
                kolmogorov_smirnov("law", &mut values, |x| x.clamp(0.0, 1.0), 1.0)
            },
            unit: 1.0 / n.sqrt(),
            power: None,
        },
        Statistic {
            name: "variance ratio",
            run: |rng, effect| {
                let squares = |rng: &mut Stream, scale: f64| {
                    Values::collect(scale / 12.0, N, || scale * (uniform(rng) - 0.5).powi(2))
                };
                let a = squares(rng, 1.0 + effect);
                variance_ratio("ratio", &a, &squares(rng, 1.0), 1.0, 1.0)
            },
            // The relative standard deviation of (u − ½)² is √0.8.
            unit: (2.0 * 0.8 / n).sqrt(),
            power: None,
        },
    ]
}

/// The binomial test: discrete, with a closed form for its power.
pub fn discrete() -> Statistic {
    Statistic {
        name: "binomial",
        run: |rng, effect| {
            let k = (0..N).filter(|_| uniform(rng) < SHARE + effect).count() as u64;
            binomial("share", k, N, SHARE, 1.0)
        },
        unit: (SHARE * (1.0 - SHARE) / N as f64).sqrt(),
        power: Some(binomial_power),
    }
}

/// An event with a promised probability: at most `rate`.
pub struct Promise {
    /// What must be rare.
    pub name: &'static str,
    /// How rare.
    pub rate: f64,
    /// Whether it happened in one replication.
    pub happened: fn(&mut Stream) -> bool,
}

/// The level at which promises are checked.
pub const LEVEL: f64 = 0.05;

/// One-sided, discrete, sequential and equivalence statistics: they promise a bound.
pub fn promises() -> [Promise; 6] {
    [
        Promise {
            name: "empirical Bernstein rejects a true mean",
            rate: LEVEL,
            happened: |rng| {
                bounded_mean("b", &uniforms(rng, 500, 0.0), 0.5, [0.0, 1.0], ANY).p < LEVEL
            },
        },
        Promise {
            name: "binomial test rejects a true share",
            rate: LEVEL,
            happened: |rng| (discrete().run)(rng, 0.0).p < LEVEL,
        },
        Promise {
            name: "confidence sequence ever excludes the mean",
            rate: LEVEL,
            happened: |rng| {
                let mut sequence = ConfidenceSequence::new(LEVEL, [0.0, 1.0]);
                (0..1000).any(|_| {
                    sequence.push(uniform(rng));
                    sequence.decide(0.5, 0.0) == Decision::Alternative
                })
            },
        },
        Promise {
            name: "SPRT rejects a true hypothesis",
            rate: LEVEL,
            happened: |rng| sprt(rng, 0.5) == Decision::Alternative,
        },
        Promise {
            name: "SPRT accepts a false hypothesis",
            rate: LEVEL,
            happened: |rng| sprt(rng, 0.6) == Decision::Null,
        },
        Promise {
            name: "equivalence concluded at the very margin",
            rate: ALPHA,
            happened: |rng| {
                let claim = Claim::Approximate { margin: 0.05 };
                mean("e", &uniforms(rng, N, 0.0), 0.45, claim).verdict() == Verdict::Holds
            },
        },
    ]
}

fn uniforms(rng: &mut Stream, n: u64, shift: f64) -> Values {
    Values::collect(0.5, n, || uniform(rng) + shift)
}

fn sprt(rng: &mut Stream, truth: f64) -> Decision {
    let mut test = Sprt::new(LEVEL, LEVEL);
    while test.bernoulli(uniform(rng) < truth, 0.5, 0.6) == Decision::Continue {}
    test.decision()
}

/// A cell of probability (1 ± effect)/[`CELLS`].
fn skewed_cell(rng: &mut Stream, effect: f64) -> usize {
    let pair = (uniform(rng) * (CELLS / 2) as f64) as usize;
    2 * pair + usize::from(uniform(rng) < 0.5 * (1.0 - effect))
}

/// Power of a two-sided z test at [`ALPHA`] under a shift in standard errors.
fn normal_power(shift: f64) -> f64 {
    let critical = normal_upper(ALPHA / 2.0);
    normal_sf(critical - shift) + normal_sf(critical + shift)
}

/// The same for Student's t with many degrees of freedom: the shifted statistic is close to normal
/// with variance 1 + t²/(2 dof).
fn student_power(shift: f64, dof: u64) -> f64 {
    let critical = student_upper(ALPHA / 2.0, dof as f64);
    let spread = (1.0 + critical * critical / (2.0 * dof as f64)).sqrt();
    normal_sf((critical - shift) / spread) + normal_sf((critical + shift) / spread)
}

/// P(X ≥ critical value at [`ALPHA`]) of the noncentral chi-square law: a Poisson mixture.
fn noncentral_chi_square_sf(dof: f64, noncentrality: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1000.0);
    while high - low > 1e-9 {
        let middle = 0.5 * (low + high);
        if chi_square_sf(middle, dof) > ALPHA {
            low = middle;
        } else {
            high = middle;
        }
    }
    let half = 0.5 * noncentrality;
    let mut weight = (-half).exp();
    let mut sum = 0.0;
    for j in 0..1000 {
        sum += weight * chi_square_sf(high, dof + 2.0 * f64::from(j));
        weight *= half / f64::from(j + 1);
    }
    sum
}

/// The exact power of the binomial test: the probability of its two tails under the effect.
fn binomial_power(effect: f64) -> f64 {
    let centre = (SHARE * N as f64) as u64;
    let rejects = |k: u64| binomial_two_sided(k, N, SHARE) < ALPHA;
    let below = (0..centre).rev().find(|&k| rejects(k));
    let above = (centre..=N).find(|&k| rejects(k));
    below.map_or(0.0, |k| binomial_cdf(k, N, SHARE + effect))
        + above.map_or(0.0, |k| binomial_sf(k, N, SHARE + effect))
}
