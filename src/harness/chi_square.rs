//! Chi-square test of a sampler against its pdf over cells, with exact binomial tails for lost
//! samples.

use glam::DVec3;

use super::copied;
use super::domain::Partition;
use super::graded::grade;
use super::outcome::{ALPHA, Cell, Claim, Outcome};
use super::power::Sensitivity;
use super::tails::{
    binomial_cdf, binomial_interval, binomial_sf, binomial_two_sided, chi_square_sf, normal_upper,
    poisson_cdf, poisson_interval, poisson_sf,
};

/// Least expected count of a cell where there are fewer than [`MANY_CELLS`] cells.
pub const MIN_EXPECTED_FEW_CELLS: f64 = 1000.0;
/// Least expected count of a cell otherwise, for the far tail to be valid. With 100, 32 cells had
/// twice the nominal tail at 1e-9; the logarithm of that ratio falls as the inverse of the count.
pub const MIN_EXPECTED_MANY_CELLS: f64 = 300.0;
/// Number of cells from which [`MIN_EXPECTED_MANY_CELLS`] applies instead of
/// [`MIN_EXPECTED_FEW_CELLS`].
pub const MANY_CELLS: usize = 32;

/// Sample counts per cell.
#[derive(Clone, Debug, Default)]
pub struct Counts {
    /// Number of samples asked for: accepted, lost and forbidden.
    pub n: u64,
    /// Samples per cell.
    pub observed: Vec<u64>,
    /// Samples that the sampler did not return.
    pub lost: u64,
    /// Samples outside the domain, or where the pdf is not a positive finite number.
    pub forbidden: u64,
    /// First forbidden sample.
    pub example: Option<DVec3>,
}

impl Counts {
    /// Sums the counts of the grid cells of each cell of a coarsened partition.
    pub(super) fn coarsened(&self, partition: &Partition) -> Self {
        let mut counts = Self {
            observed: vec![0; partition.masses.len()],
            ..self.clone()
        };
        for (cell, observed) in partition.cells_of_grid().zip(&self.observed) {
            counts.observed[cell] += observed;
        }
        counts
    }

    /// Returns the counts as if the least probable cell that is not pooled were off by `effect`,
    /// relative, and the others made up for it evenly: the distribution with such an error in some
    /// cell that is hardest to detect. `None` if there are fewer than two cells.
    fn perturbed(&self, partition: &Partition, effect: f64) -> Option<Self> {
        let accepted: u64 = self.observed.iter().sum();
        let mass = partition.mass();
        let expected: Vec<f64> = partition
            .masses
            .iter()
            .map(|m| accepted as f64 * m / mass)
            .collect();
        let pooled = pool(&expected, &self.observed);
        let min_expected = pooled.iter().map(|&[e, _]| e).fold(f64::INFINITY, f64::min);
        let at = (0..expected.len())
            .filter(|&i| expected[i] >= min_expected)
            .min_by(|&i, &j| expected[i].total_cmp(&expected[j]))?;
        let rest = accepted as f64 - expected[at];
        if pooled.len() < 2 || rest <= 0.0 {
            return None;
        }
        let mut perturbed = self.clone();
        let mut total = 0;
        for (i, count) in perturbed.observed.iter_mut().enumerate() {
            if i != at {
                let less = effect * expected[at] * expected[i] / rest;
                *count = (*count as f64 - less).round().max(0.0) as u64;
                total += *count;
            }
        }
        perturbed.observed[at] = accepted.saturating_sub(total);
        Some(perturbed)
    }
}

/// Counts n samples. `allowed` says whether the pdf is a positive finite number at a point.
pub fn count(
    partition: &Partition,
    n: u64,
    mut sample: impl FnMut() -> Option<DVec3>,
    allowed: impl Fn(DVec3) -> bool,
) -> Counts {
    let mut counts = Counts {
        n,
        observed: vec![0; partition.masses.len()],
        ..Counts::default()
    };
    for _ in 0..n {
        match sample() {
            None => counts.lost += 1,
            Some(point) => match partition.cell(point).filter(|_| allowed(copied(point))) {
                Some(cell) => counts.observed[cell] += 1,
                None => {
                    counts.forbidden += 1;
                    counts.example.get_or_insert(point);
                }
            },
        }
    }
    counts
}

/// Pearson's test of counts against a partition, together with the exact test of the lost samples
/// and the rejection of any forbidden one.
///
/// The estimate is the largest relative deviation of a cell's probability; the interval is the hull
/// of the simultaneous intervals of all cells, and must lie within ±`delta`. Lost samples are part
/// of the count: they are compared with the partition's loss, not divided away.
pub fn chi_square(name: &str, partition: &Partition, counts: &Counts, delta: f64) -> Outcome {
    grade(pearson(name, partition, counts, delta), |effect| {
        let wrong = counts.perturbed(partition, effect)?;
        Some(pearson(name, partition, &wrong, delta))
    })
}

fn pearson(name: &str, partition: &Partition, counts: &Counts, delta: f64) -> Outcome {
    let accepted: u64 = counts.observed.iter().sum();
    let mass = partition.mass();
    let expected: Vec<f64> = partition
        .masses
        .iter()
        .map(|m| accepted as f64 * if mass == 0.0 { 0.0 } else { m / mass })
        .collect();
    let pooled = pool(&expected, &counts.observed);
    // Deviations that the density's rounding explains do not count. Normalised, masses may be off
    // by twice as much.
    let deviation = |[e, o]: [f64; 2]| ((o - e).abs() - 2.0 * partition.relative * e).max(0.0);
    let statistic: f64 = pooled
        .iter()
        .map(|&cell| deviation(cell).powi(2) / cell[0])
        .sum();
    let dof = pooled.len().saturating_sub(1) as f64;
    let p_cells = if dof > 0.0 {
        chi_square_sf(statistic, dof)
    } else {
        1.0
    };
    let p_lost = loss_p_value(partition, counts);
    // If nothing can be lost, there is no second random test to divide the level with.
    let tests = if partition.loss == 0.0 && partition.error == 0.0 {
        1
    } else {
        2
    };
    // Without quadrature error, a cell of probability zero is as forbidden as the outside.
    let in_zero_cell = partition.error == 0.0
        && (partition.masses.iter().zip(&counts.observed)).any(|(&m, &o)| m == 0.0 && o > 0);
    let p = if counts.forbidden > 0 || in_zero_cell {
        0.0
    } else if p_cells.is_nan() || p_lost.is_nan() {
        f64::NAN
    } else {
        (tests as f64 * p_cells.min(p_lost)).min(1.0)
    };
    let min_expected = pooled.iter().map(|&[e, _]| e).fold(f64::INFINITY, f64::min);
    let hull = Hull::new(&pooled, accepted as f64);
    let outcome = Outcome {
        name: name.to_owned(),
        statistic: "chi-square",
        value: statistic,
        dof: Some(dof),
        p,
        n: counts.n,
        valid_from: 2,
        estimate: hull.worst,
        reference: 0.0,
        interval: hull.interval,
        claim: Claim::Equal { delta },
        sensitivity: Sensitivity::Cells {
            dof,
            n: accepted as f64,
            min_probability: min_expected / accepted as f64,
            tests,
        },
        worst: describe(partition, counts, &expected, p_lost),
        cells: cells(partition, counts, &expected),
        graded: Vec::new(),
    };
    let mass_error_effect =
        partition.error * partition.error * accepted as f64 / (min_expected / accepted as f64);
    let is_certain = counts.forbidden > 0 || p_lost < ALPHA / tests as f64;
    if mass_error_effect > MAX_MASS_ERROR_EFFECT && !is_certain {
        // Undecided: the cells' probabilities are not known accurately enough for this many
        // samples.
        Outcome {
            valid_from: u64::MAX,
            ..outcome
        }
    } else if counts.n == 0 || (dof < 1.0 && p >= ALPHA) {
        // Two equally probable cells need this many samples.
        let needed = (2.0 * MIN_EXPECTED_FEW_CELLS) as u64;
        outcome.undecided("one cell holds everything", needed)
    } else {
        outcome
    }
}

/// Tests a sampler against cells of known probability: `n` samples, a 2 % claim per cell.
pub fn sampler_against_partition<V: Into<DVec3>>(
    name: &str,
    partition: &Partition,
    n: u64,
    mut sample: impl FnMut() -> Option<V>,
) -> Outcome {
    let counts = count(partition, n, || sample().map(Into::into), |_| true);
    chi_square(name, partition, &counts, CELL_DELTA)
}

/// Largest relative δ of a single cell's probability.
pub const CELL_DELTA: f64 = 0.02;

/// Largest amount that errors of the cells' probabilities may add to the statistic's mean: at 6
/// standard deviations, a fifth of the tail.
const MAX_MASS_ERROR_EFFECT: f64 = 1e-3;

/// Pools cells that expect too little, smallest first, until none does; returns pairs of expected
/// and observed counts.
pub fn pool(expected: &[f64], observed: &[u64]) -> Vec<[f64; 2]> {
    let min_expected = |cells: usize| {
        if cells < MANY_CELLS {
            MIN_EXPECTED_FEW_CELLS
        } else {
            MIN_EXPECTED_MANY_CELLS
        }
    };
    let mut cells: Vec<[f64; 2]> = expected
        .iter()
        .zip(observed)
        .map(|(&e, &o)| [e, o as f64])
        .collect();
    cells.sort_by(|a, b| b[0].total_cmp(&a[0]));
    while cells.len() > 1 && cells[cells.len() - 1][0] < min_expected(cells.len()) {
        let [e, o] = cells.pop().unwrap_or_default();
        let last = cells.len() - 1;
        cells[last][0] += e;
        cells[last][1] += o;
        // The pooled cell has grown: restore the order.
        let pooled = cells.pop().unwrap_or_default();
        let at = cells.partition_point(|c| c[0] >= pooled[0]);
        cells.insert(at, pooled);
    }
    cells
}

/// Returns the two-sided exact p-value of the number of lost samples, the loss being known to
/// within the partition's error.
fn loss_p_value(partition: &Partition, counts: &Counts) -> f64 {
    let error = partition.error + partition.relative * partition.mass();
    let max_loss = partition.loss + error;
    let min_loss = (partition.loss - error).max(0.0);
    let tails = binomial_sf(counts.lost, counts.n, max_loss).min(binomial_cdf(
        counts.lost,
        counts.n,
        min_loss,
    ));
    (2.0 * tails).min(1.0)
}

/// Hull of the simultaneous intervals of the cells' relative deviations.
struct Hull {
    worst: f64,
    interval: [f64; 2],
}

impl Hull {
    fn new(pooled: &[[f64; 2]], accepted: f64) -> Self {
        let z = normal_upper(ALPHA / (2.0 * pooled.len() as f64));
        let mut hull = Self {
            worst: 0.0,
            interval: [0.0, 0.0],
        };
        for &[e, o] in pooled {
            let deviation = o / e - 1.0;
            let half = z * ((1.0 - e / accepted).max(0.0) / e).sqrt();
            if deviation.abs() > hull.worst.abs() {
                hull.worst = deviation;
            }
            hull.interval[0] = hull.interval[0].min(deviation - half);
            hull.interval[1] = hull.interval[1].max(deviation + half);
        }
        hull
    }
}

fn cells(partition: &Partition, counts: &Counts, expected: &[f64]) -> Vec<Cell> {
    expected
        .iter()
        .zip(&counts.observed)
        .zip(&partition.places)
        // An empty cell of probability zero is right.
        .map(|((&e, &o), place)| Cell::new(place.clone(), e, o as f64, e.sqrt()))
        .collect()
}

fn describe(partition: &Partition, counts: &Counts, expected: &[f64], p_lost: f64) -> String {
    if let Some(point) = counts.example {
        let Counts { forbidden, n, .. } = counts;
        return match partition.outside(point) {
            Some(why) => format!(
                "{forbidden} of {n} samples are outside or where the pdf is zero; the first, {point}, {why}"
            ),
            None => format!(
                "{forbidden} of {n} samples where the pdf is zero or not finite, the first at {point}"
            ),
        };
    }
    if p_lost < ALPHA {
        return format!(
            "{} samples lost, {:.1} expected",
            counts.lost,
            partition.loss * counts.n as f64
        );
    }
    cells(partition, counts, expected)
        .iter()
        .max_by(|a, b| a.sigmas.abs().total_cmp(&b.sigmas.abs()))
        .map_or_else(String::new, |cell| {
            format!(
                "cell at {}: {} samples, {:.1} expected, {:+.1} sigmas",
                cell.place, cell.observed, cell.expected, cell.sigmas
            )
        })
}

/// Tests a discrete choice (mirror or refraction, which lobe, which light), k of n against its
/// probability, by exact binomial tails. `delta` is absolute. Probabilities of 0 or 1 are allowed,
/// too: no success in n bounds the true one.
pub fn binomial(name: &str, k: u64, n: u64, probability: f64, delta: f64) -> Outcome {
    grade(binomial_test(name, k, n, probability, delta), |effect| {
        // Probabilities stay within 0 and 1, and counts within 0 and n.
        let wrong = (k as f64 + effect * n as f64).round();
        let wrong = wrong.clamp(0.0, n as f64) as u64;
        let possible = (0.0..=1.0).contains(&(probability + effect));
        possible.then(|| binomial_test(name, wrong, n, probability, delta))
    })
}

fn binomial_test(name: &str, k: u64, n: u64, probability: f64, delta: f64) -> Outcome {
    let [fraction, expected] = [k as f64 / n as f64, n as f64 * probability];
    let deviation = (expected * (1.0 - probability)).sqrt();
    let successes = Cell::new(String::from("successes"), expected, k as f64, deviation);
    let failures = Cell {
        place: String::from("failures"),
        expected: n as f64 - expected,
        observed: (n - k) as f64,
        sigmas: -successes.sigmas,
    };
    let outcome = Outcome {
        name: name.to_owned(),
        statistic: "binomial",
        value: k as f64,
        dof: None,
        p: if (0.0..=1.0).contains(&probability) {
            binomial_two_sided(k, n, probability)
        } else {
            f64::NAN
        },
        n,
        valid_from: 1,
        estimate: fraction,
        reference: probability,
        interval: binomial_interval(k, n, ALPHA / 2.0),
        claim: Claim::Equal { delta },
        sensitivity: Sensitivity::Binomial { n, probability },
        worst: format!(
            "{k} of {n}, {expected:.1} expected, {:+.1} sigmas",
            successes.sigmas
        ),
        cells: vec![successes, failures],
        graded: Vec::new(),
    };
    if n == 0 {
        // 0 of 0 is NaN, but no wrong proportion.
        Outcome {
            estimate: probability,
            ..outcome
        }
        .undecided("no values", 1)
    } else {
        outcome
    }
}

/// Tests rare events among n values, k of them against the Poisson distribution with mean
/// `expected` ≥ 0, by exact tails. `delta` is a number of events.
pub fn poisson(name: &str, k: u64, n: u64, expected: f64, delta: f64) -> Outcome {
    grade(poisson_test(name, k, n, expected, delta), |effect| {
        let wrong = (k as f64 + effect).round().max(0.0) as u64;
        (expected + effect >= 0.0).then(|| poisson_test(name, wrong, n, expected, delta))
    })
}

fn poisson_test(name: &str, k: u64, n: u64, expected: f64, delta: f64) -> Outcome {
    let tails = poisson_sf(k, expected).min(poisson_cdf(k, expected));
    let outcome = Outcome {
        name: name.to_owned(),
        statistic: "Poisson",
        value: k as f64,
        dof: None,
        p: if expected >= 0.0 {
            (2.0 * tails).min(1.0)
        } else {
            f64::NAN
        },
        n,
        valid_from: 1,
        estimate: k as f64,
        reference: expected,
        interval: poisson_interval(k, ALPHA / 2.0),
        claim: Claim::Equal { delta },
        sensitivity: Sensitivity::Poisson { mean: expected },
        worst: format!("{k} among {n} values, {expected:.1e} expected"),
        cells: vec![Cell::new(
            String::from("events"),
            expected,
            k as f64,
            expected.sqrt(),
        )],
        graded: Vec::new(),
    };
    if n == 0 {
        outcome.undecided("no values", 1)
    } else {
        outcome
    }
}
