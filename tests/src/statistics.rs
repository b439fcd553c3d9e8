//! The harness's statistics at small sizes, under a true hypothesis and under effects of known
//! size: the subject of tests and of the experiments `calibration` and `power`.

use std::sync::LazyLock;

use rand_distr::{Distribution, Poisson};
use whitefurnace::harness::chi_square::{Counts, binomial, chi_square, poisson};
use whitefurnace::harness::convergence::variance_ratio;
use whitefurnace::harness::directions::Precision;
use whitefurnace::harness::directions::own_pdf::OwnPdfs;
use whitefurnace::harness::domain::Partition;
use whitefurnace::harness::ks::kolmogorov_smirnov;
use whitefurnace::harness::mean::{bounded_mean, mean, mean_known_sigma, welch};
use whitefurnace::harness::outcome::{ALPHA, Verdict};
use whitefurnace::harness::power::Sensitivity;
use whitefurnace::math::moments::Moments;
use whitefurnace::sampling::rng::stream;

use crate::mean_radiance::any_direction;
use crate::prelude::*;

/// Values per replication.
pub const N: u64 = 4000;
/// Cells of the chi-square test; the effect makes the first heavier and the others evenly lighter.
const CELLS: usize = 4;
/// Probability under the binomial test's hypothesis.
const PROBABILITY: f64 = 0.3;
/// Mean under the Poisson test's hypothesis.
const POISSON_MEAN: f64 = 30.0;

const ANY: Claim = Claim::Equal { delta: 1.0 };

/// A statistic, its unit and its stated power.
pub struct Statistic {
    /// Its name.
    pub name: &'static str,
    /// Computes the statistic on fresh values with an effect, in multiples of `unit`.
    pub run: fn(&mut Stream, effect: f64) -> Outcome,
    /// One standard error of the estimate: the unit in which effects are measured.
    pub unit: f64,
    /// The sensitivity from which the library states its power, for the distribution of the values.
    pub sensitivity: fn(effect: f64) -> Sensitivity,
}

impl Statistic {
    /// Returns the stated probability of rejection at level [`ALPHA`] under an effect.
    pub fn power(&self, effect: f64) -> f64 {
        1.0 - (self.sensitivity)(effect).miss(effect)
    }

    /// Returns whether the stated power is a lower bound only.
    pub fn is_bound(&self) -> bool {
        is_bound(&(self.sensitivity)(0.0))
    }
}

/// Returns whether the power that follows from a sensitivity is a lower bound only.
pub fn is_bound(sensitivity: &Sensitivity) -> bool {
    // With many cells, cells that lose counts may reject as well.
    use Sensitivity::{Bernstein, Cells, Distance};
    matches!(
        sensitivity,
        Distance { .. } | Bernstein { .. } | Cells { tests: 2.., .. }
    )
}

fn normal(standard_error: f64, dof: f64) -> Sensitivity {
    Sensitivity::Normal {
        standard_error,
        dof,
        tests: 1,
    }
}

/// Standard error of a mean of [`N`] uniform numbers.
fn mean_error() -> f64 {
    (1.0 / 12.0 / N as f64).sqrt()
}

/// Standard error of the ratio of the mean squares of uniform numbers, the first of which are
/// scaled: the relative standard deviation of (u − ½)² is √0.8.
fn ratio_error(scale: f64) -> f64 {
    (0.8 * (scale * scale + 1.0) / N as f64).sqrt()
}

/// Two-sided statistics of continuous variables, whose p-values are uniform under the hypothesis.
pub fn continuous() -> [Statistic; 7] {
    [
        Statistic {
            name: "z",
            run: |rng, effect| {
                mean_known_sigma(
                    "z",
                    &uniforms(rng, N, effect),
                    0.5,
                    (1.0f64 / 12.0).sqrt(),
                    ANY,
                )
            },
            unit: mean_error(),
            sensitivity: |_| normal(mean_error(), f64::INFINITY),
        },
        Statistic {
            name: "t",
            run: |rng, effect| mean("t", &uniforms(rng, N, effect), 0.5, ANY),
            unit: mean_error(),
            sensitivity: |_| normal(mean_error(), N as f64 - 1.0),
        },
        Statistic {
            name: "Welch",
            run: |rng, effect| {
                let a = uniforms(rng, N, effect);
                welch("Welch", &a, &uniforms(rng, 3 * N, 0.0), ANY)
            },
            unit: mean_error() * (4.0f64 / 3.0).sqrt(),
            // (1 + 1/3)²/(1 + 1/27) degrees of freedom per value.
            sensitivity: |_| normal(mean_error() * (4.0f64 / 3.0).sqrt(), 12.0 / 7.0 * N as f64),
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
                chi_square(
                    "cells",
                    &Partition::from_masses(vec![1.0 / CELLS as f64; CELLS], places),
                    &counts,
                    1.0,
                )
            },
            unit: ((CELLS as f64 - 1.0) / N as f64).sqrt(),
            sensitivity: |_| Sensitivity::Cells {
                dof: CELLS as f64 - 1.0,
                n: N as f64,
                min_probability: 1.0 / CELLS as f64,
                tests: 1,
            },
        },
        Statistic {
            name: "Kolmogorov-Smirnov",
            run: |rng, effect| {
                let mut values: Vec<f64> =
                    (0..N).map(|_| two_step_law(uniform(rng), effect)).collect();
                kolmogorov_smirnov("law", &mut values, |x| x.clamp(0.0, 1.0), 1.0)
            },
            unit: 1.0 / (N as f64).sqrt(),
            sensitivity: |_| Sensitivity::Distance { n: N },
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
            unit: ratio_error(1.0),
            sensitivity: |effect| normal(ratio_error(1.0 + effect), N as f64 - 1.0),
        },
        Statistic {
            name: "neighbour distances",
            run: |rng, effect| neighbour_distances(rng, N, effect),
            unit: neighbour_error(1e-6),
            sensitivity: |effect| normal(neighbour_error(effect), NEIGHBOUR_BLOCKS as f64 - 1.0),
        },
    ]
}

/// Draws among which neighbours are looked for, as few as possible.
const NEIGHBOURS: u64 = 64;
/// Number of blocks of so many draws that are judged; the first only decides regions.
const NEIGHBOUR_BLOCKS: u64 = N / NEIGHBOURS - 1;

/// Tests directions uniform over the sphere by their own pdf, which is too high by a fraction, as
/// `judge --own-pdf` does: the first component of the distances to their neighbours.
fn neighbour_distances(rng: &mut Stream, n: u64, effect: f64) -> Outcome {
    let pdf = (1.0 + effect) * 0.25 * FRAC_1_PI;
    let mut own = OwnPdfs::new(Precision::DOUBLE).with_block_size(NEIGHBOURS as usize);
    for _ in 0..n {
        own.push(Some(any_direction(rng)), pdf);
    }
    let outcomes = own.outcomes(0.5);
    let component = outcomes
        .into_iter()
        .find(|o| o.name.starts_with("component 1"));
    component.expect("the first component")
}

/// Returns the mean and the variance of cos πu for u = (1 − (1 + effect) W)^(m − 1), where W is the
/// probability of being nearer than the nearest of m − 1 uniform directions.
fn neighbour_moments(effect: f64) -> [f64; 2] {
    const STEPS: u32 = 20_000;
    let power = NEIGHBOURS as f64 - 1.0;
    // W exceeds w with probability (1 − w)^(m − 1), which is uniform in [0, 1].
    let values = (0..STEPS).map(|i| {
        let w = 1.0 - ((f64::from(i) + 0.5) / f64::from(STEPS)).powf(power.recip());
        (PI * (1.0 - ((1.0 + effect) * w).min(1.0)).powf(power)).cos()
    });
    let moments: Moments = values.collect();
    [moments.mean(), moments.variance()]
}

/// Standard error of [`neighbour_distances`], in units of the effect. Two directions may be each
/// other's neighbours, so that values are not independent: by how much is measured in long runs.
fn neighbour_error(effect: f64) -> f64 {
    const LONG: u64 = 8_000_000;
    /// Effects of the long runs, about those at the lowest and the highest powers.
    const ENDS: [f64; 2] = [0.1, 0.3];
    static DEPENDENCE: LazyLock<[f64; 2]> = LazyLock::new(|| {
        ENDS.map(|effect| {
            let outcome = neighbour_distances(&mut stream(0, 0, 0), LONG, effect);
            let error = (outcome.estimate - outcome.reference) / outcome.value;
            error * error * LONG as f64 / neighbour_moments(effect)[1]
        })
    });
    let [low, high] = *DEPENDENCE;
    let dependence = low + (high - low) * (effect - ENDS[0]) / (ENDS[1] - ENDS[0]);
    let [mean, variance] = neighbour_moments(effect);
    let judged = (NEIGHBOUR_BLOCKS * NEIGHBOURS) as f64;
    effect / mean.abs() * (dependence * variance / judged).sqrt()
}

/// The binomial test of a share.
fn binomial_test() -> Statistic {
    Statistic {
        name: "binomial",
        run: |rng, effect| {
            let k = (0..N)
                .filter(|_| uniform(rng) < PROBABILITY + effect)
                .count() as u64;
            binomial("share", k, N, PROBABILITY, 1.0)
        },
        unit: (PROBABILITY * (1.0 - PROBABILITY) / N as f64).sqrt(),
        sensitivity: |_| Sensitivity::Binomial {
            n: N,
            probability: PROBABILITY,
        },
    }
}

fn poisson_test() -> Statistic {
    Statistic {
        name: "Poisson",
        run: |rng, effect| {
            // A positive mean is legal; NaN would fail instead of being rejected by mistake.
            let count = Poisson::new(POISSON_MEAN + effect).map_or(f64::NAN, |law| law.sample(rng));
            poisson("events", count as u64, N, POISSON_MEAN, 1.0)
        },
        unit: POISSON_MEAN.sqrt(),
        sensitivity: |_| Sensitivity::Poisson { mean: POISSON_MEAN },
    }
}

/// The empirical Bernstein test of values in [0, 1].
fn bernstein_test() -> Statistic {
    Statistic {
        name: "empirical Bernstein",
        run: |rng, effect| {
            let values = Values::collect(0.5, N, || uniform(rng));
            bounded_mean("bounded", &values, 0.5 - effect, [0.0, 1.0], ANY)
        },
        unit: mean_error(),
        sensitivity: |_| Sensitivity::Bernstein {
            root: (1.0 / 6.0 / N as f64).sqrt(),
            range: 7.0 / (3.0 * (N as f64 - 1.0)),
        },
    }
}

/// Every kind of statistic whose power is stated, those of sums first.
pub fn with_power() -> Vec<Statistic> {
    let [z, t, welch, cells, distance, ratio, neighbours] = continuous();
    vec![
        z,
        t,
        welch,
        ratio,
        bernstein_test(),
        cells,
        distance,
        binomial_test(),
        poisson_test(),
        neighbours,
    ]
}

/// An event with a promised upper bound of its probability.
pub struct ErrorRateBound {
    /// The event that must be rare.
    pub name: &'static str,
    /// Upper bound of its probability.
    pub rate: f64,
    /// Returns whether it happened in one replication.
    pub happened: fn(&mut Stream) -> bool,
}

fn bound(name: &'static str, rate: f64, happened: fn(&mut Stream) -> bool) -> ErrorRateBound {
    ErrorRateBound {
        name,
        rate,
        happened,
    }
}

/// Level at which promises are checked.
pub const LEVEL: f64 = 0.05;

/// One-sided, discrete and equivalence statistics, of which only a bound of the error rate is
/// stated.
pub fn error_rate_bounds() -> [ErrorRateBound; 3] {
    [
        bound("empirical Bernstein rejects a true mean", LEVEL, |rng| {
            bounded_mean("b", &uniforms(rng, 500, 0.0), 0.5, [0.0, 1.0], ANY).p < LEVEL
        }),
        bound("binomial test rejects a true share", LEVEL, |rng| {
            (binomial_test().run)(rng, 0.0).p < LEVEL
        }),
        bound("equivalence concluded at the very margin", ALPHA, |rng| {
            mean(
                "e",
                &uniforms(rng, N, 0.0),
                0.45,
                Claim::Equivalent { margin: 0.05 },
            )
            .verdict()
                == Verdict::Holds
        }),
    ]
}

fn uniforms(rng: &mut Stream, n: u64, shift: f64) -> Values {
    Values::collect(0.5, n, || uniform(rng) + shift)
}

/// Maps a uniform number to a distribution that is uniform on either half of [0, 1] and has
/// probability 1/2 + effect in the lower: its distribution function is farthest off at the middle
/// alone.
fn two_step_law(u: f64, effect: f64) -> f64 {
    let lower = 0.5 + effect;
    if u < lower {
        0.5 * u / lower
    } else {
        0.5 + 0.5 * (u - lower) / (1.0 - lower)
    }
}

/// Samples a cell: the first with probability (1 + effect)/[`CELLS`], the others alike. Of all
/// distributions that are off by the effect in some cell, this one is the hardest to detect.
fn skewed_cell(rng: &mut Stream, effect: f64) -> usize {
    let first = (1.0 + effect) / CELLS as f64;
    let u = uniform(rng);
    if u < first {
        return 0;
    }
    let others = (CELLS - 1) as f64;
    (1 + ((u - first) / (1.0 - first) * others) as usize).min(CELLS - 1)
}
