//! The statistical harness, module by module: exactly where it can be, by sampling where only that shows it.

pub mod bsdf_checkup; // a BSDF that is not ours, and faulty versions of it
pub mod calibration; // error rates and power of the statistics, at a small size
pub mod checkup_parts; // what each part of the check-up of BSDFs reports
mod chi_square;
mod convergence;
mod domain;
mod graded;
mod guard;
mod ks;
pub mod lobe_checkup; // paper, mirrors and glass, and faulty ones
mod mean;
mod no_evidence; // samples that say nothing
mod outcome;
mod power;
mod quadrature;
mod sequential;
mod tails;
mod trial;
mod welch_map;

use whitefurnace::harness::domain::Partition;
use whitefurnace::harness::mean::Values;
use whitefurnace::harness::welch_map::PixelStatistics;

/// Values whose cubes are summed about `centre`.
fn values(centre: f64, numbers: &[f64]) -> Values {
    let mut numbers = numbers.iter();
    Values::collect(centre, numbers.len() as u64, || *numbers.next().expect("as many"))
}

/// n values with the given mean that lie `spread` above and below it in turn.
fn around(mean: f64, spread: f64, n: u64) -> Values {
    let mut side = -1.0;
    Values::collect(mean, n, || {
        side = -side;
        mean + side * spread
    })
}

/// n values of which one in a hundred is 1 and the others 0.
fn rare(n: u64) -> Values {
    let mut i = 0;
    Values::collect(0.01, n, || {
        i += 1;
        f64::from(u8::from(i % 100 == 0))
    })
}

/// Cells of these probabilities, called by their numbers.
fn cells(masses: &[f64]) -> Partition {
    Partition::of_masses(masses.to_vec(), (0..masses.len()).map(|i| i.to_string()).collect())
}

/// One channel of an image with its own pixels.
#[derive(Clone)]
struct Image {
    mean: Vec<f64>,
    variance: Vec<f64>,
    count: Vec<u64>,
}

impl Image {
    fn new(mean: &[f64], variance: &[f64], count: &[u64]) -> Self {
        Self { mean: mean.to_vec(), variance: variance.to_vec(), count: count.to_vec() }
    }

    fn statistics(&self) -> PixelStatistics<'_> {
        PixelStatistics { mean: &self.mean, variance: &self.variance, count: &self.count }
    }
}
