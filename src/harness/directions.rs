//! Tests of sampled directions from any program: against a density, with their weights and reported
//! pdfs.
//!
//! ```
//! use whitefurnace::harness::directions::{Density, Directions, Sample};
//! use whitefurnace::harness::domain::Domain;
//! use whitefurnace::harness::outcome::Verdict;
//! use whitefurnace::sampling::rng::{seed_for, stream, uniform2};
//! use whitefurnace::sampling::warp::{cosine_hemisphere, cosine_hemisphere_pdf};
//!
//! let density = Density::new(Domain::Hemisphere, |w| cosine_hemisphere_pdf(w.z));
//! let mut rng = stream(seed_for(2019, "directions"), 0, 0);
//! let mut directions = Directions::new(&density);
//! for _ in 0..200_000 {
//!     let direction = cosine_hemisphere(uniform2(&mut rng));
//!     directions.push(&Sample { direction: Some(direction), weight: None, pdf: None });
//! }
//! for outcome in directions.outcomes(0.05, None) {
//!     assert_eq!(outcome.verdict(), Verdict::Holds, "{outcome}");
//! }
//! ```

mod density;
mod neighbours;
pub mod own_pdf;
mod rounding;

use glam::DVec3;

use super::chi_square::{Counts, chi_square};
use super::mean::{Values, mean};
use super::outcome::{ALPHA, Claim, Outcome, Verdict};
use super::tails::normal_upper;
use crate::sampling::rng::{Stream, stream};
pub use density::Density;
use density::{FINE_TOLERANCE, MOMENTS, moment_at};
pub use rounding::{Precision, Rounding};
use rounding::{density_range, unrounded};

/// Number of forbidden samples after which others are not looked for beyond their rounding.
const SURELY_FORBIDDEN: u64 = 100;

/// One output of a sampler.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Unit vector, within its precision; `None` for a lost sample.
    pub direction: Option<DVec3>,
    /// Factor of a path's throughput: f |cos θ| / pdf.
    pub weight: Option<f64>,
    /// Pdf reported by the sampler, with respect to solid angle, 1/sr.
    pub pdf: Option<f64>,
}

/// Samples so far, counted on a fine grid.
pub struct Directions<'a> {
    density: &'a Density,
    precision: Precision,
    counts: Counts,
    moments: [Values; MOMENTS.len()],
    /// Weights; 0 for a lost sample.
    weights: Values,
    pdfs: ReportedPdfs,
    /// Source of randomness for drawing among directions that round to the same numbers.
    random: Stream,
}

/// Reported pdfs so far.
struct ReportedPdfs {
    count: u64,
    /// Largest error relative to the density, beyond rounding, and the sample that has it.
    worst: (f64, String),
    /// Smallest relative error that a sample could have shown.
    finest: f64,
}

/// Largest error of a pdf reported in double precision, relative to the density.
pub const PDF_TOLERANCE: f64 = 1e-3;
/// Largest relative error of a pdf that may have been computed in single precision: half of an
/// error of one percent, so that such an error is detected. Correct pdfs of GGX with α of 0.02 or
/// more, by the usual 1 − cos² θ (1 − α²) in the denominator, were off by up to 1.5e-3.
pub const SINGLE_PDF_TOLERANCE: f64 = 5e-3;
/// Further relative error of a pdf in single precision, times the pdf in 1/sr: where 1 − cos θ is
/// of the size 1/(8π pdf), as over the half vectors of a lobe, a rounding of cos² θ, 2⁻²⁴, changes
/// a pdf with the square of that in the denominator by 16π · 2⁻²⁴ pdf. The constant is 2.5 times
/// that; pdfs of GGX with α of 0.01 were off by 1.2 times.
const SINGLE_PDF_CONDITION: f64 = 128.0 / 16_777_216.0;
/// Relative error of a pdf that must be detected.
const DETECTABLE_PDF_ERROR: f64 = 1e-2;
/// Number of samples from which it is found how finely a reported pdf can be judged.
const PRECISION_SAMPLES: u64 = 1000;
/// Relative variation below which weights are equal up to rounding to 32 bits.
const CONSTANT_TOLERANCE: f64 = 1e-5;
/// Least and largest numbers of cells: `COARSE_CELLS`, whose probabilities are tested to a margin,
/// and `FINE_CELLS`, for errors of small extent.
const COARSE_CELLS: [usize; 2] = [6, 96];
const FINE_CELLS: [usize; 2] = [128, 1024];
/// Samples per cell of the many cells.
const SAMPLES_PER_FINE_CELL: u64 = 1200;
/// Largest product of samples and cells for which probabilities known to [`FINE_TOLERANCE`]
/// suffice.
const MAX_SAMPLES_TIMES_CELLS: u64 = 100_000_000_000;

impl<'a> Directions<'a> {
    /// Starts without samples, for numbers in double precision.
    pub fn new(density: &'a Density) -> Self {
        Self::with_precision(density, Precision::DOUBLE)
    }

    /// Starts without samples, for numbers of this precision.
    pub fn with_precision(density: &'a Density, precision: Precision) -> Self {
        Self {
            density,
            precision,
            counts: Counts {
                observed: vec![0; density.fine_grid.masses.len()],
                ..Counts::default()
            },
            moments: density.moments.map(Values::new),
            weights: Values::new(1.0),
            pdfs: ReportedPdfs {
                count: 0,
                worst: (0.0, String::new()),
                finest: f64::INFINITY,
            },
            random: stream(0x6a75_6467, 0, 0),
        }
    }

    /// Adds a sample.
    ///
    /// A direction rounded to more than 1e-8 is replaced by one drawn from the density among those
    /// that round to the same numbers. So rounded samples of the density follow it exactly, and
    /// errors hidden by rounding are not judged. A sample counts as forbidden if the density is
    /// zero wherever it may have been. After a hundred, with which the samples fail whatever
    /// follows, fewer such places are tried.
    pub fn push(&mut self, sample: &Sample) {
        self.counts.n += 1;
        if let Some(weight) = sample.weight {
            let weight = sample.direction.map_or(0.0, |_| weight);
            self.weights.push(weight);
        }
        let Some(direction) = sample.direction else {
            self.counts.lost += 1;
            return;
        };
        let unrounded = unrounded(
            self.density,
            &self.precision,
            direction,
            self.counts.forbidden < SURELY_FORBIDDEN,
            &mut self.random,
        );
        match unrounded.and_then(|unrounded| self.density.fine_grid.cell(unrounded)) {
            Some(grid_cell) => {
                self.counts.observed[grid_cell] += 1;
                for (values, (_, f)) in self.moments.iter_mut().zip(MOMENTS) {
                    values.push(moment_at(f, grid_cell));
                }
            }
            None => {
                self.counts.forbidden += 1;
                self.counts.example.get_or_insert(direction);
            }
        }
        if let Some(reported) = sample.pdf {
            self.report(direction, reported);
        }
    }

    /// Compares a reported pdf with the density.
    fn report(&mut self, direction: DVec3, reported: f64) {
        self.pdfs.count += 1;
        let pdf = self.density.pdf(direction.normalize());
        let rounding = self.precision.pdf.half_width(reported);
        // Relative distance of the reported pdf from a range of densities.
        let beyond = |[least, most]: [f64; 2]| {
            let excess = ((least - reported).max(reported - most) - rounding).max(0.0);
            if excess == 0.0 { 0.0 } else { excess / pdf }
        };
        let tolerance = self.pdf_tolerance();
        let conditioned = if tolerance > PDF_TOLERANCE {
            SINGLE_PDF_CONDITION * pdf
        } else {
            0.0
        };
        // In units in which the tolerance covers rounding.
        let scale = tolerance / tolerance.max(conditioned);
        let error = if reported.is_nan() {
            f64::NAN
        } else {
            scale * beyond([pdf, pdf])
        };
        if self.pdfs.count > PRECISION_SAMPLES && error <= self.pdfs.worst.0 {
            return;
        }
        let range = density_range(self.density, &self.precision, direction);
        let finest = (0.5 * (range[1] - range[0]) + rounding) / pdf;
        let tells = scale == 1.0 && !finest.is_nan();
        if tells {
            self.pdfs.finest = self.pdfs.finest.min(finest);
        }
        let error = if error.is_nan() {
            error
        } else {
            scale * beyond(range)
        };
        // NaN is the largest error.
        if error.is_nan() || error > self.pdfs.worst.0 {
            let worst = format!(
                "sample {}: {reported:e} is reported, the density is {pdf:e}",
                self.counts.n
            );
            self.pdfs.worst = (error, worst);
        }
    }

    /// Returns the mean weight and its standard error, from two or more samples with weights.
    pub fn mean_weight(&self) -> Option<[f64; 2]> {
        let weights = self.weights.moments;
        (weights.count() > 1).then(|| [weights.mean(), weights.standard_error()])
    }

    /// Returns the outcomes: chi-square over few and over many cells, means, reported pdfs, and the
    /// mean weight against its expected value. `margin`, in (0, 1), is how far a cell's probability
    /// and the mean weight may be off, relative, and means of functions of the quantiles, absolute.
    pub fn outcomes(&self, margin: f64, mean_weight: Option<f64>) -> Vec<Outcome> {
        let n = self.counts.n;
        let fine_grid = &self.density.fine_grid;
        // The interval of each cell's probability, and as much again for the largest deviation,
        // lies within the margin.
        let min_expected = (2.0 * normal_upper(ALPHA / COARSE_CELLS[1] as f64) / margin).powi(2);
        let max_cells =
            ((n as f64 / min_expected) as usize).clamp(COARSE_CELLS[0], COARSE_CELLS[1]);
        let enough = |cells: &usize| {
            fine_grid
                .coarsened(*cells)
                .masses
                .iter()
                .all(|mass| n as f64 * mass >= min_expected)
        };
        let coarse_cells = (COARSE_CELLS[0]..=max_cells)
            .rev()
            .find(enough)
            .unwrap_or(COARSE_CELLS[0]);
        let mut outcomes = vec![self.cells(coarse_cells, margin)];
        let fine_cells = (n / SAMPLES_PER_FINE_CELL)
            .min(MAX_SAMPLES_TIMES_CELLS.checked_div(n).unwrap_or(0))
            .min(FINE_CELLS[1] as u64) as usize;
        if fine_cells >= FINE_CELLS[0] && fine_grid.error <= FINE_TOLERANCE {
            outcomes.push(Outcome {
                claim: Claim::Test,
                graded: Vec::new(),
                ..self.cells(fine_cells, margin)
            });
        }
        let claim = Claim::Equal { delta: margin };
        let means = MOMENTS.iter().zip(&self.moments).zip(self.density.moments);
        outcomes.extend(
            means.map(|(((name, _), values), reference)| mean(name, values, reference, claim)),
        );
        outcomes.extend(self.pdfs());
        if let Some(expected) = mean_weight {
            outcomes.push(self.weight(expected, margin));
        }
        outcomes
    }

    fn cells(&self, cells: usize, margin: f64) -> Outcome {
        let partition = self.density.fine_grid.coarsened(cells);
        let (name, counts) = (format!("{cells} cells"), self.counts.coarsened(&partition));
        chi_square(&name, &partition, &counts, margin)
    }

    fn pdf_tolerance(&self) -> f64 {
        let exact = [self.precision.direction, self.precision.pdf] == [Rounding::DOUBLE; 2];
        if exact {
            PDF_TOLERANCE
        } else {
            SINGLE_PDF_TOLERANCE
        }
    }

    /// Returns the outcome of reported pdfs, if there are any; undecided if they are too coarse to
    /// show an error of one percent.
    fn pdfs(&self) -> Option<Outcome> {
        let (count, (error, worst)) = (self.pdfs.count, &self.pdfs.worst);
        let tolerance = self.pdf_tolerance();
        let coarse = *error <= tolerance && self.pdfs.finest + tolerance > DETECTABLE_PDF_ERROR;
        (count > 0).then(|| {
            let outcome =
                Outcome::identity("reported pdf", count, *error, tolerance, worst.clone());
            let why = "the numbers are too coarse for this density";
            if coarse {
                outcome.undecided(why, u64::MAX)
            } else {
                outcome
            }
        })
    }

    /// Returns the outcome of the mean weight; undecided if the weights are rounded to more than
    /// the margin.
    fn weight(&self, expected: f64, margin: f64) -> Outcome {
        let (name, moments) = ("mean weight", self.weights.moments);
        let rounding = self.precision.weight.half_width(expected);
        let outcome = if moments.count() > 1
            && moments.variance().sqrt() <= CONSTANT_TOLERANCE * moments.mean()
        {
            let found = moments.mean();
            let error = ((found - expected).abs() - rounding).max(0.0) / expected;
            let worst = format!("all weights are {found:e}, which should be {expected:e}");
            Outcome::identity(name, moments.count(), error, CONSTANT_TOLERANCE, worst)
        } else {
            // Rounding may have moved all weights alike.
            let moved = (moments.mean() - expected).clamp(-rounding, rounding);
            let delta = margin * expected;
            mean(
                name,
                &self.weights,
                expected + moved,
                Claim::Equal { delta },
            )
        };
        if rounding > margin * expected && outcome.verdict() == Verdict::Holds {
            return outcome.undecided("the weights are too coarse for this margin", u64::MAX);
        }
        outcome
    }
}
