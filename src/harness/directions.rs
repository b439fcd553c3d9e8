//! Sampled directions on trial, of whatever program drew them: against a density, with their weights and reported pdfs.
//!
//! ```
//! use whitefurnace::harness::directions::{Density, Directions, Sample};
//! use whitefurnace::harness::domain::Domain;
//! use whitefurnace::harness::outcome::Verdict;
//! use whitefurnace::{rng, sampling};
//!
//! let density = Density::new(Domain::Hemisphere, |w| sampling::cosine_hemisphere_pdf(w.z));
//! let mut rng = rng::stream(rng::seed_for(2019, "directions"), 0, 0);
//! let mut directions = Directions::new(&density);
//! for _ in 0..200_000 {
//!     let direction = sampling::cosine_hemisphere(rng::uniform2(&mut rng));
//!     directions.push(&Sample { direction: Some(direction), weight: None, pdf: None });
//! }
//! for outcome in directions.outcomes(0.05, None) {
//!     assert_eq!(outcome.verdict(), Verdict::Holds, "{outcome}");
//! }
//! ```

use glam::DVec3;

use super::chi_square::{Counts, chi_square};
use super::copied;
use super::domain::{Domain, MASS_TOLERANCE, Partition};
use super::mean::{Values, mean};
use super::outcome::{ALPHA, Claim, Outcome};
use super::tails::normal_upper;

/// A law of directions.
pub struct Density {
    fields: Partition,
    pdf: Box<dyn Fn(DVec3) -> f64 + Send + Sync>,
    /// Means of [`MOMENTS`].
    moments: [f64; MOMENTS.len()],
}

type Function = fn(DVec3) -> f64;

/// Functions of a direction whose means are tested: they notice what is spread over many cells.
const MOMENTS: [(&str, Function); 6] = [
    ("mean of x", |w| w.x),
    ("mean of y", |w| w.y),
    ("mean of z", |w| w.z),
    ("mean of x²", |w| w.x * w.x),
    ("mean of z²", |w| w.z * w.z),
    ("mean of xy", |w| w.x * w.y),
];

impl Density {
    /// A pdf with respect to solid angle, 1/sr. What it lacks to one, samplers lose.
    pub fn new(domain: Domain, pdf: impl Fn(DVec3) -> f64 + Send + Sync + 'static) -> Self {
        let fields = Partition::fields(domain, SHARP, &pdf);
        let moment = |f: Function| domain.integrate_all(MASS_TOLERANCE, &|w| f(w) * pdf(copied(w))).value;
        let moments = MOMENTS.map(|(_, f)| moment(f) / fields.mass());
        Self { fields, pdf: Box::new(pdf), moments }
    }

    /// A pdf that is constant on each cell of a grid of the domain: rows of cells from the pole z = 1 down, of equal
    /// solid angle, and in each the columns by azimuth, from x by way of y. Numbers of at least 0 in any proportion.
    ///
    /// # Panics
    /// If rows differ in length, or no number is above 0.
    pub fn of_table(domain: Domain, table: &[Vec<f64>]) -> Self {
        let columns = table[0].len();
        assert!(table.iter().all(|row| row.len() == columns), "rows of different lengths");
        let sum: f64 = table.iter().flatten().sum();
        assert!(sum > 0.0, "no number above 0");
        let even = Partition::equal(domain, table.len(), columns);
        let masses: Vec<f64> = table.iter().flatten().map(|value| value / sum).collect();
        let measure = domain.integrate_all(MASS_TOLERANCE, &|_| 1.0).value / masses.len() as f64;
        let moment = |f: Function| -> f64 {
            let fields = even.grid().zip(&masses).filter(|(_, mass)| **mass > 0.0);
            fields
                .map(|(field, mass)| mass / measure * domain.integrate(field, MASS_TOLERANCE * measure, &f).value)
                .sum()
        };
        let moments = MOMENTS.map(|(_, f)| moment(f));
        let fields = even.clone().weighted(masses.clone());
        let pdf = move |w| even.cell(w).map_or(0.0, |cell| masses[cell] / measure);
        Self { fields, pdf: Box::new(pdf), moments }
    }

    /// The pdf with respect to solid angle, 1/sr.
    pub fn pdf(&self, direction: DVec3) -> f64 {
        (self.pdf)(copied(direction))
    }
}

/// What a sampler returned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// A unit vector; `None` for a sample that was lost.
    pub direction: Option<DVec3>,
    /// What a path's throughput is multiplied by: f |cos θ| / pdf.
    pub weight: Option<f64>,
    /// The pdf that the sampler reports, with respect to solid angle, 1/sr.
    pub pdf: Option<f64>,
}

/// Samples so far, counted on a fine grid.
pub struct Directions<'a> {
    density: &'a Density,
    counts: Counts,
    moments: [Values; MOMENTS.len()],
    /// Weights; a lost sample's is 0.
    weights: Values,
    /// Of reported pdfs: how many, the largest error relative to the density, and which sample has it.
    pdfs: (u64, f64, String),
}

/// How far a reported pdf may be off, relative to the density: rounding of 32-bit directions where it is steep.
pub const PDF_TOLERANCE: f64 = 1e-3;
/// Weights that vary by less than this are all the same but for rounding to 32 bits.
const CONSTANT: f64 = 1e-5;
/// Numbers of cells: a few whose probabilities are told to a margin, and many for what is small in extent.
const FEW: [usize; 2] = [6, 96];
const MANY: [usize; 2] = [128, 1024];
/// Samples of each of the many cells.
const PER_CELL: u64 = 1200;
/// How well the cells' probabilities are known, which is enough for so many samples times cells.
const SHARP: f64 = 3e-8;
const SHARP_ENOUGH: u64 = 100_000_000_000;

impl<'a> Directions<'a> {
    /// No samples yet.
    pub fn new(density: &'a Density) -> Self {
        Self {
            density,
            counts: Counts { observed: vec![0; density.fields.masses.len()], ..Counts::default() },
            moments: density.moments.map(Values::new),
            weights: Values::new(1.0),
            pdfs: (0, 0.0, String::new()),
        }
    }

    /// Adds a sample.
    pub fn push(&mut self, sample: &Sample) {
        self.counts.n += 1;
        if let Some(weight) = sample.weight {
            self.weights.push(if sample.direction.is_some() { weight } else { 0.0 });
        }
        let Some(direction) = sample.direction else {
            self.counts.lost += 1;
            return;
        };
        for (values, (_, f)) in self.moments.iter_mut().zip(MOMENTS) {
            values.push(f(direction));
        }
        let pdf = self.density.pdf(direction);
        match self.density.fields.cell(direction).filter(|_| pdf > 0.0 && pdf.is_finite()) {
            Some(cell) => self.counts.observed[cell] += 1,
            None => {
                self.counts.forbidden += 1;
                self.counts.example.get_or_insert(direction);
            }
        }
        if let Some(reported) = sample.pdf {
            self.pdfs.0 += 1;
            let error = (reported - pdf).abs() / pdf;
            // NaN is the largest error.
            if error.is_nan() || error > self.pdfs.1 {
                let worst = format!("sample {}: {reported:e} is reported, the density is {pdf:e}", self.counts.n);
                (self.pdfs.1, self.pdfs.2) = (error, worst);
            }
        }
    }

    /// The mean weight and its standard error, of two samples with weights or more.
    pub fn mean_weight(&self) -> Option<[f64; 2]> {
        let weights = self.weights.moments;
        (weights.count() > 1).then(|| [weights.mean(), weights.standard_error()])
    }

    /// What the samples say: chi-square over few and over many cells, means, reported pdfs, and the mean weight against
    /// what it should be. `margin` is how far a cell's probability and the mean weight may be off, relative to them,
    /// and means of directions' components, absolute; in (0, 1).
    pub fn outcomes(&self, margin: f64, mean_weight: Option<f64>) -> Vec<Outcome> {
        let n = self.counts.n;
        let fields = &self.density.fields;
        // The interval of each cell's share, and as much again for the largest of their deviations, lies within the margin.
        let wanted = (2.0 * normal_upper(ALPHA / FEW[1] as f64) / margin).powi(2);
        let told = |cells: &usize| fields.gathered(*cells).masses.iter().all(|mass| n as f64 * mass >= wanted);
        let few = (FEW[0]..=FEW[1]).rev().find(told).unwrap_or(FEW[0]);
        let mut outcomes = vec![self.cells(few, margin)];
        let many = (n / PER_CELL).min(SHARP_ENOUGH.checked_div(n).unwrap_or(0)).min(MANY[1] as u64) as usize;
        if many >= MANY[0] && fields.error <= SHARP {
            outcomes.push(Outcome { claim: Claim::Test, graded: Vec::new(), ..self.cells(many, margin) });
        }
        let claim = Claim::Exact { delta: margin };
        let means = MOMENTS.iter().zip(&self.moments).zip(self.density.moments);
        outcomes.extend(means.map(|(((name, _), values), reference)| mean(name, values, reference, claim)));
        let (reported, error, worst) = &self.pdfs;
        if *reported > 0 {
            outcomes.push(Outcome::exact("reported pdf", *reported, *error, PDF_TOLERANCE, worst.clone()));
        }
        if let Some(expected) = mean_weight {
            outcomes.push(self.weight(expected, margin));
        }
        outcomes
    }

    fn cells(&self, cells: usize, margin: f64) -> Outcome {
        let partition = self.density.fields.gathered(cells);
        let mut counts = Counts { observed: vec![0; partition.masses.len()], ..self.counts.clone() };
        for (cell, observed) in partition.cells_of_grid().zip(&self.counts.observed) {
            counts.observed[cell] += observed;
        }
        chi_square(&format!("{cells} cells"), &partition, &counts, margin)
    }

    fn weight(&self, expected: f64, margin: f64) -> Outcome {
        let (name, moments) = ("mean weight", self.weights.moments);
        if moments.count() > 1 && moments.variance().sqrt() <= CONSTANT * moments.mean() {
            let (found, error) = (moments.mean(), (moments.mean() / expected - 1.0).abs());
            let worst = format!("all weights are {found:e}, which should be {expected:e}");
            return Outcome::exact(name, moments.count(), error, CONSTANT, worst);
        }
        mean(name, &self.weights, expected, Claim::Exact { delta: margin * expected })
    }
}
