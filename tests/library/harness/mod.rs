//! Tests of the statistical harness by module: exact where possible, by sampling elsewhere.

pub mod checkup_parts; // each part of the check-up of BSDFs
mod chi_square;
mod convergence;
pub mod directions; // sampled directions of any program
mod domain;
mod graded;
mod guard;
pub mod images; // two sets of images
mod insufficient_samples; // samples without evidence
mod ks;
pub mod lobe_checkup; // end-to-end check-ups of paper, mirrors and glass, and faulty ones
mod mean;
pub mod narrow_lobes; // BSDFs that scatter nearly all light in one direction
mod outcome;
pub mod own_pdf; // pdfs judged by their own samples
mod pixel_statistics;
mod power;
mod quadrature;
pub mod single_precision; // subjects that compute in f32
mod tails;
mod trial;

// Imports for the modules, which say `use super::*`.
use whitefurnace::harness::bsdf_checkup::{
    BsdfSubject, CheckUp, Lobe, LobeSample, LobeSubject, Loss, SampledDirection, check_up,
    check_up_lobes,
};
use whitefurnace::harness::chi_square::{
    Counts, binomial, chi_square, count, poisson, sampler_against_partition,
};
use whitefurnace::harness::convergence::{slope, variance_ratio};
use whitefurnace::harness::domain::{Domain, Partition};
use whitefurnace::harness::guard::{fault_objection, power_objection};
use whitefurnace::harness::images::{PixelStatistics, image_mean, welch_map};
use whitefurnace::harness::ks::kolmogorov_smirnov;
use whitefurnace::harness::mean::{
    MIN_CONSTANT_VALUES, Sigma, Values, bounded_mean, mean, mean_known_sigma, skewness_of_sum,
    welch, welch_satterthwaite,
};
use whitefurnace::harness::outcome::{ALPHA, Cell, Claim, Outcome, Verdict};
use whitefurnace::harness::power::Sensitivity;
use whitefurnace::harness::tails::{
    binomial_cdf, binomial_sf, binomial_two_sided, chi_square_sf, normal_sf, normal_upper,
    poisson_cdf, poisson_interval, poisson_sf, student_two_sided, student_upper,
};
use whitefurnace::harness::trial::Context;

use crate::prelude::*;

/// Returns the context of the environment, at scale 1 whatever the scale of the trials.
fn at_scale_1(name: &str) -> Context {
    Context {
        scale: 1.0,
        ..context(name)
    }
}

/// Returns the sensitivity of a single test with this standard error.
fn normal(standard_error: f64, dof: f64) -> Sensitivity {
    Sensitivity::Normal {
        standard_error,
        dof,
        tests: 1,
    }
}

/// Values whose cubes are summed about `centre`.
fn values(centre: f64, numbers: &[f64]) -> Values {
    let mut numbers = numbers.iter();
    Values::collect(centre, numbers.len() as u64, || {
        *numbers.next().expect("as many")
    })
}

/// Returns n values with the given mean, alternately `spread` above and below it.
fn around(mean: f64, spread: f64, n: u64) -> Values {
    let mut side = -1.0;
    Values::collect(mean, n, || {
        side = -side;
        mean + side * spread
    })
}

/// Returns n values of which one in a hundred is 1 and the others are 0.
fn rare(n: u64) -> Values {
    let mut i = 0;
    Values::collect(0.01, n, || {
        i += 1;
        f64::from(u8::from(i % 100 == 0))
    })
}

/// Returns cells of these probabilities, named by their numbers.
fn cells(masses: &[f64]) -> Partition {
    Partition::from_masses(
        masses.to_vec(),
        (0..masses.len()).map(|i| i.to_string()).collect(),
    )
}

/// One channel of an image, with owned pixels.
#[derive(Clone)]
struct Image {
    mean: Vec<f64>,
    variance: Vec<f64>,
    count: Vec<u64>,
}

impl Image {
    fn new(mean: &[f64], variance: &[f64], count: &[u64]) -> Self {
        Self {
            mean: mean.to_vec(),
            variance: variance.to_vec(),
            count: count.to_vec(),
        }
    }

    fn statistics(&self) -> PixelStatistics<'_> {
        PixelStatistics {
            mean: &self.mean,
            variance: &self.variance,
            count: &self.count,
        }
    }
}

/// Returns the outcome of a t test of 100 values with this estimate, which is right within ±`half`.
fn outcome(estimate: f64, half: f64, claim: Claim) -> Outcome {
    Outcome {
        statistic: "t",
        n: 100,
        valid_from: 2,
        estimate,
        reference: estimate,
        interval: [estimate - half, estimate + half],
        claim,
        ..Outcome::identity("toy", 0, 0.0, 0.0, "")
    }
}

/// Asserts the fields of a test named by its statistic, to 1e-12: statistic and p-value, estimate
/// and reference, and the half width of the interval.
fn assert_test(
    found: &Outcome,
    statistic: &str,
    n: u64,
    test: [f64; 2],
    values: [f64; 2],
    half: f64,
) {
    assert_eq!(
        (&*found.name, found.statistic, found.n),
        (statistic, statistic, n)
    );
    let [estimate, reference] = values;
    let numbers = [
        found.value,
        found.p,
        found.estimate,
        found.reference,
        found.interval[0],
        found.interval[1],
    ];
    let expected = [
        test[0],
        test[1],
        estimate,
        reference,
        estimate - half,
        estimate + half,
    ];
    assert_relative_eq!(numbers[..], expected[..], max_relative = 1e-12);
}

/// Asserts the place of a cell and its numbers: expected, observed, and their distance.
fn assert_cell(cell: &Cell, place: &str, numbers: [f64; 3]) {
    assert_eq!(cell.place, place);
    let found = [cell.expected, cell.observed, cell.sigmas];
    assert_relative_eq!(
        found[..],
        numbers[..],
        max_relative = 1e-12,
        epsilon = 1e-12
    );
}
