//! Densities of directions, and the grid of nearly equal probability on which their samples are counted.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::frame::{azimuth, from_spherical};
use crate::harness::copied;
use crate::harness::domain::{Domain, Partition};
use crate::harness::quadrature::{Rectangle, integrate_within, work};

/// A density of directions.
pub struct Density {
    /// The fields of the grid in the unit square of quantiles, [`ROWS`] × [`COLUMNS`], with their probabilities.
    pub(super) fields: Partition,
    /// The means of [`MOMENTS`] over the fields.
    pub(super) moments: [f64; MOMENTS.len()],
    pdf: Box<dyn Fn(DVec3) -> f64 + Send + Sync>,
    quantiles: Quantiles,
}

/// Rows of the grid, by quantiles of the polar angle.
const ROWS: usize = 32;
/// Columns of the grid, in each row by quantiles of the azimuth there.
const COLUMNS: usize = 64;
/// How well the fields' probabilities are known by quadrature, in all.
pub(super) const SHARP: f64 = 3e-8;

type Moment = fn(f64, f64) -> f64;

/// Functions of u and v whose means are tested: they notice what is spread over many cells. u is the share of the
/// probability at smaller polar angles, v the share at smaller azimuths within the row: both are uniform numbers if
/// the directions follow the density, however narrow that is.
pub(super) const MOMENTS: [(&str, Moment); 8] = [
    ("mean of u", |u, _| u),
    ("mean of u²", |u, _| u * u),
    ("mean of cos 2πv", |_, v| (TAU * v).cos()),
    ("mean of sin 2πv", |_, v| (TAU * v).sin()),
    ("mean of cos 4πv", |_, v| (2.0 * TAU * v).cos()),
    ("mean of sin 4πv", |_, v| (2.0 * TAU * v).sin()),
    ("mean of (2u − 1) cos 2πv", |u, v| (2.0 * u - 1.0) * (TAU * v).cos()),
    ("mean of (2u − 1) sin 2πv", |u, v| (2.0 * u - 1.0) * (TAU * v).sin()),
];

impl Density {
    /// A pdf with respect to solid angle, 1/sr, on [`Domain::Sphere`] or a hemisphere. What it lacks to one, samplers
    /// lose.
    ///
    /// # Panics
    /// If the domain is none of directions.
    pub fn new(domain: Domain, pdf: impl Fn(DVec3) -> f64 + Send + Sync + 'static) -> Self {
        let largest = largest_angle(domain);
        let blocks = sketch(largest, &pdf);
        let theta = borders(blocks.iter().map(|block| (block.theta, block.mass)), [0.0, largest], ROWS);
        let turns: Vec<Vec<f64>> = theta
            .windows(2)
            .map(|row| {
                let inside = |block: &Block| {
                    let common = block.theta[1].min(row[1]) - block.theta[0].max(row[0]);
                    (block.turn, block.mass * (common / (block.theta[1] - block.theta[0])).max(0.0))
                };
                borders(blocks.iter().map(inside), [0.0, 1.0], COLUMNS)
            })
            .collect();
        let (mut left, mut error) = (work(), 0.0);
        let mut masses = Vec::with_capacity(ROWS * COLUMNS);
        for (row, turns) in theta.windows(2).zip(&turns) {
            for column in turns.windows(2) {
                let field = Rectangle { x: [row[0], row[1]], y: [column[0], column[1]] };
                let share = SHARP / (ROWS * COLUMNS) as f64;
                let found = integrate_within(field, share, &mut left, &mut |theta, turn| {
                    pdf(from_spherical(theta, TAU * turn)) * TAU * theta.sin()
                });
                error += found.error;
                masses.push(found.value);
            }
        }
        let mut fields = Partition::equal(Domain::Square, ROWS, COLUMNS);
        fields.loss = (1.0 - masses.iter().sum::<f64>()).max(0.0);
        // NaN stays.
        fields.error = if error <= SHARP { SHARP } else { error };
        fields.masses = masses;
        let height = |theta: &f64| 2.0 * (0.5 * theta).sin().powi(2);
        let quantiles = Quantiles {
            polar: Scale::even(theta.iter().map(height).collect()),
            azimuths: turns.into_iter().map(Scale::even).collect(),
        };
        Self::of(fields, quantiles, pdf)
    }

    /// A pdf that is constant on each cell of a grid of the sphere or hemisphere: rows of cells from the pole z = 1 down,
    /// of equal solid angle, and in each the columns by azimuth, from x by way of y. Numbers of at least 0 in any
    /// proportion. The probabilities of its fields are exact.
    ///
    /// # Panics
    /// If rows differ in length, no number is above 0, or the domain is none of directions.
    pub fn of_table(domain: Domain, table: &[Vec<f64>]) -> Self {
        let (rows, columns) = (table.len(), table[0].len());
        assert!(table.iter().all(|row| row.len() == columns), "rows of different lengths");
        let sums: Vec<f64> = table.iter().map(|row| row.iter().sum()).collect();
        let total: f64 = sums.iter().sum();
        assert!(total > 0.0, "no number above 0");
        let heights = 1.0 - largest_angle(domain).cos().round();
        let even = |count: usize, size: f64| (0..=count).map(|i| size * i as f64 / count as f64).collect::<Vec<_>>();
        let azimuths: Vec<Scale> = table.iter().map(|row| Scale::new(even(columns, 1.0), row)).collect();
        let polar = Scale::new(even(rows, heights), &sums);
        let measure = TAU * heights / (rows * columns) as f64;
        let densities: Vec<f64> = table.iter().flatten().map(|value| value / total / measure).collect();
        let pdf = move |w: DVec3| {
            let [height, turn] = place(w);
            let index = |x: f64, n: usize| ((x * n as f64) as usize).min(n - 1);
            if height <= heights {
                densities[index(height / heights, rows) * columns + index(turn, columns)]
            } else {
                0.0
            }
        };
        Self::of(Partition::equal(Domain::Square, ROWS, COLUMNS), Quantiles { polar, azimuths }, pdf)
    }

    fn of(fields: Partition, quantiles: Quantiles, pdf: impl Fn(DVec3) -> f64 + Send + Sync + 'static) -> Self {
        let mean = |f: Moment| {
            let all = fields.masses.iter().enumerate().map(|(field, mass)| mass * at_centre(f, field));
            all.sum::<f64>() / fields.mass()
        };
        let moments = MOMENTS.map(|(_, f)| mean(f));
        Self { fields, moments, pdf: Box::new(pdf), quantiles }
    }

    /// The pdf with respect to solid angle, 1/sr.
    pub fn pdf(&self, direction: DVec3) -> f64 {
        (self.pdf)(copied(direction))
    }

    /// The probabilities of about so many cells on which samples are counted; with the loss they sum to one.
    pub fn cells(&self, cells: usize) -> Vec<f64> {
        self.fields.gathered(cells).masses
    }

    /// The field of the grid in which a unit vector lies; `None` outside the domain (and for NaN).
    pub(super) fn field(&self, direction: DVec3) -> Option<usize> {
        let [height, turn] = place(direction);
        let (row, u) = self.quantiles.polar.share(height)?;
        let (_, v) = self.quantiles.azimuths[row].share(turn)?;
        self.fields.cell(DVec3::new(u, v, 0.0))
    }

    /// About `cells` cells of nearly equal probability, gathered from the fields, and where they lie in words.
    pub(super) fn gathered(&self, cells: usize) -> Partition {
        let mut partition = self.fields.gathered(cells);
        let mut ends = vec![[[ROWS, 0], [COLUMNS, 0]]; partition.masses.len()];
        for (field, cell) in partition.cells_of_grid().enumerate() {
            for (range, at) in ends[cell].iter_mut().zip([field / COLUMNS, field % COLUMNS]) {
                *range = [range[0].min(at), range[1].max(at + 1)];
            }
        }
        let degrees = |row: usize| {
            let height = self.quantiles.polar.at(row as f64 / ROWS as f64);
            (2.0 * (0.5 * height).sqrt().min(1.0).asin()).to_degrees()
        };
        let place = |[rows, columns]: [[usize; 2]; 2]| {
            let [from, to] = rows.map(degrees);
            let [least, most] = columns.map(|column| column as f64 / COLUMNS as f64);
            format!("{from:.4} to {to:.4} degrees from z, quantiles {least:.3} to {most:.3} of the azimuth there")
        };
        partition.places = ends.into_iter().map(place).collect();
        partition
    }
}

/// The value of a moment's function at the centre of a field.
pub(super) fn at_centre(f: Moment, field: usize) -> f64 {
    f(((field / COLUMNS) as f64 + 0.5) / ROWS as f64, ((field % COLUMNS) as f64 + 0.5) / COLUMNS as f64)
}

/// The largest polar angle, radians.
fn largest_angle(domain: Domain) -> f64 {
    match domain {
        Domain::Sphere => PI,
        Domain::Hemisphere | Domain::CosineHemisphere => 0.5 * PI,
        Domain::Disk | Domain::Square | Domain::Triangle => panic!("a domain of points, where directions are needed"),
    }
}

/// 1 − z in [0, 2] and the azimuth in turns in [0, 1) of a unit vector.
fn place(w: DVec3) -> [f64; 2] {
    let height = if w.z > 0.0 { (w.x * w.x + w.y * w.y) / (1.0 + w.z) } else { 1.0 - w.z };
    [height, azimuth(w) / TAU]
}

/// Where the quantiles of a density lie.
struct Quantiles {
    /// Of 1 − z.
    polar: Scale,
    /// Of the azimuth in turns, for each interval of `polar`.
    azimuths: Vec<Scale>,
}

/// A distribution function that is linear between its borders.
struct Scale {
    /// Ascending.
    borders: Vec<f64>,
    /// The function's values there, from 0 to 1.
    shares: Vec<f64>,
}

impl Scale {
    /// Intervals of equal probability.
    fn even(borders: Vec<f64>) -> Self {
        let last = (borders.len() - 1) as f64;
        Self { shares: (0..borders.len()).map(|i| i as f64 / last).collect(), borders }
    }

    /// Intervals with probabilities in proportion to `masses`; even ones if these are all 0.
    fn new(borders: Vec<f64>, masses: &[f64]) -> Self {
        let total: f64 = masses.iter().sum();
        if total == 0.0 {
            return Self::even(borders);
        }
        let mut shares = vec![0.0];
        let mut sum = 0.0;
        for mass in masses {
            sum += mass;
            shares.push((sum / total).min(1.0));
        }
        Self { borders, shares }
    }

    /// The interval in which x lies, and the distribution function there; `None` outside.
    fn share(&self, x: f64) -> Option<(usize, f64)> {
        let last = self.borders.len() - 2;
        if !(x >= self.borders[0] && x <= self.borders[last + 1]) {
            return None;
        }
        let i = self.borders.partition_point(|&border| border <= x).saturating_sub(1).min(last);
        let inside = (x - self.borders[i]) / (self.borders[i + 1] - self.borders[i]);
        Some((i, self.shares[i] + inside * (self.shares[i + 1] - self.shares[i])))
    }

    /// Where the distribution function has a value in [0, 1].
    fn at(&self, share: f64) -> f64 {
        let i = self.shares.partition_point(|&s| s < share).clamp(1, self.shares.len() - 1);
        let size = self.shares[i] - self.shares[i - 1];
        let inside = if size > 0.0 { ((share - self.shares[i - 1]) / size).clamp(0.0, 1.0) } else { 0.0 };
        self.borders[i - 1] + inside * (self.borders[i] - self.borders[i - 1])
    }
}

/// A rectangle of polar angle and azimuth with a rough value of its probability.
struct Block {
    /// Range of the polar angle, radians.
    theta: [f64; 2],
    /// Range of the azimuth, turns.
    turn: [f64; 2],
    mass: f64,
    /// Whether the density varies more with the polar angle.
    across: bool,
}

/// Points of a block along each side.
const POINTS: usize = 4;

impl Block {
    fn new(theta: [f64; 2], turn: [f64; 2], pdf: &dyn Fn(DVec3) -> f64) -> Self {
        let (mut rows, mut columns) = ([0.0; POINTS], [0.0; POINTS]);
        let at = |[low, high]: [f64; 2], i: usize| low + (high - low) * (i as f64 + 0.5) / POINTS as f64;
        for (i, row) in rows.iter_mut().enumerate() {
            for (j, column) in columns.iter_mut().enumerate() {
                let theta = at(theta, i);
                let value = pdf(from_spherical(theta, TAU * at(turn, j))) * theta.sin();
                *row += value;
                *column += value;
            }
        }
        let mean = rows.iter().sum::<f64>() / (POINTS * POINTS) as f64;
        let mass = mean * TAU * (theta[1] - theta[0]) * (turn[1] - turn[0]);
        let range = |sums: [f64; POINTS]| {
            sums.iter().fold(f64::MIN, |a, &b| a.max(b)) - sums.iter().fold(f64::MAX, |a, &b| a.min(b))
        };
        // Quadrature finds what is not finite.
        Self { theta, turn, mass: if mass.is_finite() { mass } else { 0.0 }, across: range(rows) >= range(columns) }
    }

    fn halves(&self, pdf: &dyn Fn(DVec3) -> f64) -> [Self; 2] {
        let halved = |[low, high]: [f64; 2]| [[low, 0.5 * (low + high)], [0.5 * (low + high), high]];
        if self.across {
            halved(self.theta).map(|theta| Self::new(theta, self.turn, pdf))
        } else {
            halved(self.turn).map(|turn| Self::new(self.theta, turn, pdf))
        }
    }
}

/// A density in blocks of little probability each, roughly: where quantiles lie, not how much lies between them.
fn sketch(largest: f64, pdf: &dyn Fn(DVec3) -> f64) -> Vec<Block> {
    const SIDES: [usize; 2] = [64, 64];
    const LARGEST_SHARE: f64 = 1.0 / 8192.0;
    const MOST_HALVINGS: usize = 60;
    let ends = |i: usize, n: usize, size: f64| [size * i as f64 / n as f64, size * (i + 1) as f64 / n as f64];
    let mut blocks: Vec<Block> = (0..SIDES[0] * SIDES[1])
        .map(|k| Block::new(ends(k / SIDES[1], SIDES[0], largest), ends(k % SIDES[1], SIDES[1], 1.0), pdf))
        .collect();
    for _ in 0..MOST_HALVINGS {
        let total: f64 = blocks.iter().map(|block| block.mass).sum();
        let (large, small): (Vec<_>, Vec<_>) = blocks.into_iter().partition(|block| block.mass > LARGEST_SHARE * total);
        blocks = small;
        if large.is_empty() {
            break;
        }
        blocks.extend(large.iter().flat_map(|block| block.halves(pdf)));
    }
    blocks
}

/// Borders, strictly ascending, that cut `range` into `count` intervals of about equal mass, of pieces of constant density.
fn borders(pieces: impl Iterator<Item = ([f64; 2], f64)>, range: [f64; 2], count: usize) -> Vec<f64> {
    let mut changes: Vec<[f64; 2]> = Vec::new();
    let mut total = 0.0;
    for ([low, high], mass) in pieces.filter(|(_, mass)| *mass > 0.0) {
        let slope = mass / (high - low);
        changes.extend([[low, slope], [high, -slope]]);
        total += mass;
    }
    // A little everywhere keeps borders apart.
    let little = (1e-6 * total).max(f64::MIN_POSITIVE.sqrt());
    total += little;
    changes.push([range[1], 0.0]);
    changes.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut borders = vec![range[0]];
    let (mut x, mut sum, mut slope) = (range[0], 0.0, little / (range[1] - range[0]));
    for [next, change] in changes {
        let after = sum + slope * (next - x);
        while borders.len() < count && after >= total * borders.len() as f64 / count as f64 {
            borders.push(x + (total * borders.len() as f64 / count as f64 - sum) / slope);
        }
        (x, sum) = (next, after);
        slope += change;
    }
    borders.resize(count, range[1]);
    borders.push(range[1]);
    borders
}
