//! Quantiles of a density of directions: a grid whose rows and columns follow lobes, however
//! narrow.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec3;

use super::quadrature::Rectangle;
use crate::math::frame::{azimuth, from_spherical};

/// Returns 1 − z in [0, 2] and the azimuth in turns in [0, 1) of a vector whose length is one up to
/// rounding.
pub(super) fn height_and_turn(w: DVec3) -> [f64; 2] {
    let aside = (w.x * w.x + w.y * w.y) / (1.0 + w.z.abs());
    [
        if w.z > 0.0 { aside } else { 2.0 - aside },
        azimuth(w) / TAU,
    ]
}

/// Quantiles of a density of directions.
#[derive(Clone, Debug)]
pub(super) struct Quantiles {
    /// Quantiles of 1 − z.
    polar: PiecewiseCdf,
    /// Quantiles of the azimuth in turns, for each interval of `polar`.
    azimuths: Vec<PiecewiseCdf>,
}

impl Quantiles {
    /// Finds rows of about equal probability by the polar angle from 0 to `largest`, radians, and
    /// columns in each by the azimuth. On the sphere the horizon is a border of rows, as densities
    /// of surfaces jump there.
    pub fn from_pdf([rows, columns]: [usize; 2], largest: f64, pdf: &dyn Fn(DVec3) -> f64) -> Self {
        let blocks = subdivide(largest, pdf);
        let mut theta = borders(
            blocks.iter().map(|block| (block.theta, block.mass)),
            [0.0, largest],
            rows,
        );
        if largest > FRAC_PI_2 {
            let aside = |i: &usize| (theta[*i] - FRAC_PI_2).abs();
            let nearest = (1..rows).min_by(|i, j| aside(i).total_cmp(&aside(j)));
            nearest.into_iter().for_each(|i| theta[i] = FRAC_PI_2);
        }
        let azimuths = theta.windows(2).map(|row| {
            let inside = |block: &Block| {
                let common = block.theta[1].min(row[1]) - block.theta[0].max(row[0]);
                (
                    block.turn,
                    block.mass * (common / (block.theta[1] - block.theta[0])).max(0.0),
                )
            };
            PiecewiseCdf::even(borders(blocks.iter().map(inside), [0.0, 1.0], columns))
        });
        let azimuths = azimuths.collect();
        let height = |theta: f64| 2.0 * (0.5 * theta).sin().powi(2);
        Self {
            polar: PiecewiseCdf::even(theta.into_iter().map(height).collect()),
            azimuths,
        }
    }

    /// Finds the quantiles of a density that is constant on the cells of a table of equal solid
    /// angles up to 1 − z = `height`.
    pub fn from_table(height: f64, table: &[Vec<f64>]) -> Self {
        let even = |count: usize, size: f64| {
            (0..=count)
                .map(|i| size * i as f64 / count as f64)
                .collect::<Vec<_>>()
        };
        let sums: Vec<f64> = table.iter().map(|row| row.iter().sum()).collect();
        let azimuths = table
            .iter()
            .map(|row| PiecewiseCdf::new(even(row.len(), 1.0), row))
            .collect();
        Self {
            polar: PiecewiseCdf::new(even(table.len(), height), &sums),
            azimuths,
        }
    }

    /// Returns the probability of smaller polar angles, and that of smaller azimuths within the
    /// row. A direction that rounding moved across the last border counts as on it; `None` for NaN.
    pub fn to_square(&self, w: DVec3) -> Option<[f64; 2]> {
        let [height, turn] = height_and_turn(w);
        let (row, u) = self.polar.cdf(height)?;
        let (_, v) = self.azimuths[row].cdf(turn)?;
        Some([u, v])
    }

    /// Returns the ranges of the polar angle, radians, and of the azimuth, turns, of a cell of the
    /// grid.
    pub fn grid_cell(&self, [row, column]: [usize; 2]) -> Rectangle {
        let turns = &self.azimuths[row].borders;
        Rectangle {
            x: [row, row + 1].map(|i| angle(self.polar.borders[i])),
            y: [turns[column], turns[column + 1]],
        }
    }

    /// Returns the polar angle, degrees, below which this fraction of the probability lies.
    pub fn degrees(&self, fraction: f64) -> f64 {
        angle(self.polar.inverse_cdf(fraction)).to_degrees()
    }
}

/// Returns the polar angle of 1 − z, radians.
fn angle(height: f64) -> f64 {
    2.0 * (0.5 * height).sqrt().min(1.0).asin()
}

/// Piecewise linear distribution function.
#[derive(Clone, Debug)]
struct PiecewiseCdf {
    /// Borders of the pieces, ascending.
    borders: Vec<f64>,
    /// Values of the function at the borders, from 0 to 1.
    values: Vec<f64>,
}

impl PiecewiseCdf {
    /// Creates intervals of equal probability.
    fn even(borders: Vec<f64>) -> Self {
        let last = (borders.len() - 1) as f64;
        Self {
            values: (0..borders.len()).map(|i| i as f64 / last).collect(),
            borders,
        }
    }

    /// Creates intervals with probabilities in proportion to `masses`; equal ones if these are
    /// all 0.
    fn new(borders: Vec<f64>, masses: &[f64]) -> Self {
        let total: f64 = masses.iter().sum();
        if total == 0.0 {
            return Self::even(borders);
        }
        let mut values = vec![0.0];
        let mut sum = 0.0;
        for mass in masses {
            sum += mass;
            values.push((sum / total).min(1.0));
        }
        Self { borders, values }
    }

    /// Returns the interval that contains x and the distribution function at x, or the nearer end
    /// if x lies outside; `None` for NaN.
    fn cdf(&self, x: f64) -> Option<(usize, f64)> {
        let last = self.borders.len() - 2;
        if x.is_nan() {
            return None;
        }
        let x = x.clamp(self.borders[0], self.borders[last + 1]);
        let i = self
            .borders
            .partition_point(|&border| border <= x)
            .saturating_sub(1)
            .min(last);
        let inside = (x - self.borders[i]) / (self.borders[i + 1] - self.borders[i]);
        Some((
            i,
            self.values[i] + inside * (self.values[i + 1] - self.values[i]),
        ))
    }

    /// Returns where the distribution function has a value in [0, 1].
    fn inverse_cdf(&self, fraction: f64) -> f64 {
        let i = self
            .values
            .partition_point(|&s| s < fraction)
            .clamp(1, self.values.len() - 1);
        let size = self.values[i] - self.values[i - 1];
        let inside = if size > 0.0 {
            ((fraction - self.values[i - 1]) / size).clamp(0.0, 1.0)
        } else {
            0.0
        };
        self.borders[i - 1] + inside * (self.borders[i] - self.borders[i - 1])
    }
}

/// Rectangle of polar angle and azimuth with a rough value of its probability.
struct Block {
    /// Range of the polar angle, radians.
    theta: [f64; 2],
    /// Range of the azimuth, turns.
    turn: [f64; 2],
    mass: f64,
    /// Whether the density varies more with the polar angle.
    across: bool,
}

/// Number of evaluation points along each side of a block.
const POINTS_PER_SIDE: usize = 4;

impl Block {
    fn new(theta: [f64; 2], turn: [f64; 2], pdf: &dyn Fn(DVec3) -> f64) -> Self {
        let (mut rows, mut columns) = ([0.0; POINTS_PER_SIDE], [0.0; POINTS_PER_SIDE]);
        let at = |[low, high]: [f64; 2], i: usize| {
            low + (high - low) * (i as f64 + 0.5) / POINTS_PER_SIDE as f64
        };
        for (i, row) in rows.iter_mut().enumerate() {
            for (j, column) in columns.iter_mut().enumerate() {
                let theta = at(theta, i);
                let value = pdf(from_spherical(theta, TAU * at(turn, j))) * theta.sin();
                *row += value;
                *column += value;
            }
        }
        let mean = rows.iter().sum::<f64>() / (POINTS_PER_SIDE * POINTS_PER_SIDE) as f64;
        let mass = mean * TAU * (theta[1] - theta[0]) * (turn[1] - turn[0]);
        let range = |sums: [f64; POINTS_PER_SIDE]| {
            sums.iter().fold(f64::MIN, |a, &b| a.max(b))
                - sums.iter().fold(f64::MAX, |a, &b| a.min(b))
        };
        // Values that are not finite are left to the quadrature to find.
        Self {
            theta,
            turn,
            mass: if mass.is_finite() { mass } else { 0.0 },
            across: range(rows) >= range(columns),
        }
    }

    fn halves(&self, pdf: &dyn Fn(DVec3) -> f64) -> [Self; 2] {
        let halved =
            |[low, high]: [f64; 2]| [[low, 0.5 * (low + high)], [0.5 * (low + high), high]];
        if self.across {
            halved(self.theta).map(|theta| Self::new(theta, self.turn, pdf))
        } else {
            halved(self.turn).map(|turn| Self::new(self.theta, turn, pdf))
        }
    }
}

/// Cuts a density into blocks of little probability each, roughly: it places quantiles, but does
/// not measure the probability between them.
fn subdivide(largest: f64, pdf: &dyn Fn(DVec3) -> f64) -> Vec<Block> {
    const SIDES: [usize; 2] = [64, 64];
    const MAX_BLOCK_FRACTION: f64 = 1.0 / 8192.0;
    const MAX_HALVINGS: usize = 60;
    let ends = |i: usize, n: usize, size: f64| {
        [size * i as f64 / n as f64, size * (i + 1) as f64 / n as f64]
    };
    let mut blocks: Vec<Block> = (0..SIDES[0] * SIDES[1])
        .map(|k| {
            Block::new(
                ends(k / SIDES[1], SIDES[0], largest),
                ends(k % SIDES[1], SIDES[1], 1.0),
                pdf,
            )
        })
        .collect();
    for _ in 0..MAX_HALVINGS {
        let total: f64 = blocks.iter().map(|block| block.mass).sum();
        let (large, small): (Vec<_>, Vec<_>) = blocks
            .into_iter()
            .partition(|block| block.mass > MAX_BLOCK_FRACTION * total);
        blocks = small;
        if large.is_empty() {
            break;
        }
        blocks.extend(large.iter().flat_map(|block| block.halves(pdf)));
    }
    blocks
}

/// Returns strictly ascending borders that cut `range` into `count` intervals of about equal mass,
/// for pieces of constant density.
fn borders(
    pieces: impl Iterator<Item = ([f64; 2], f64)>,
    range: [f64; 2],
    count: usize,
) -> Vec<f64> {
    let mut changes: Vec<[f64; 2]> = Vec::new();
    let mut total = 0.0;
    for ([low, high], mass) in pieces.filter(|(_, mass)| *mass > 0.0) {
        let slope = mass / (high - low);
        changes.extend([[low, slope], [high, -slope]]);
        total += mass;
    }
    // A little mass everywhere keeps borders apart.
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
