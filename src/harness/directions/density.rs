//! Densities of directions, and the grid of nearly equal probability on which their samples are
//! counted.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::harness::copied;
use crate::harness::domain::{Domain, FINE_GRID, Partition};
use crate::harness::quantiles::{Quantiles, height_and_turn};

/// A density of directions.
pub struct Density {
    /// Cells of the grid in the unit square of quantiles, with their probabilities.
    pub(super) fine_grid: Partition,
    /// Means of [`MOMENTS`] over the cells.
    pub(super) moments: [f64; MOMENTS.len()],
    pdf: Box<dyn Fn(DVec3) -> f64 + Send + Sync>,
}

/// Total quadrature error of the cells' probabilities.
pub(super) const FINE_TOLERANCE: f64 = 3e-8;

type Moment = fn(f64, f64) -> f64;

/// Functions of u and v whose means are tested: they detect errors spread over many cells. u is the
/// probability of smaller polar angles, v that of smaller azimuths within the row: both are uniform
/// numbers if the directions follow the density, however narrow that is.
pub(super) const MOMENTS: [(&str, Moment); 8] = [
    ("mean of u", |u, _| u),
    ("mean of u²", |u, _| u * u),
    ("mean of cos 2πv", |_, v| (TAU * v).cos()),
    ("mean of sin 2πv", |_, v| (TAU * v).sin()),
    ("mean of cos 4πv", |_, v| (2.0 * TAU * v).cos()),
    ("mean of sin 4πv", |_, v| (2.0 * TAU * v).sin()),
    ("mean of (2u − 1) cos 2πv", |u, v| {
        (2.0 * u - 1.0) * (TAU * v).cos()
    }),
    ("mean of (2u − 1) sin 2πv", |u, v| {
        (2.0 * u - 1.0) * (TAU * v).sin()
    }),
];

impl Density {
    /// Creates a density from a pdf with respect to solid angle, 1/sr, on [`Domain::Sphere`] or a
    /// hemisphere. One minus its integral is the sampler's loss.
    ///
    /// # Panics
    /// If the domain is not a set of directions.
    pub fn new(domain: Domain, pdf: impl Fn(DVec3) -> f64 + Send + Sync + 'static) -> Self {
        assert!(
            domain.largest_angle().is_some(),
            "a domain of points, where directions are needed"
        );
        let pdf = move |w: DVec3| pdf(w);
        Self::from_grid(Partition::fine_grid(domain, FINE_TOLERANCE, &pdf), pdf)
    }

    /// Creates a density that is constant on each cell of a grid of the sphere or hemisphere: rows
    /// of equal solid angle from the pole z = 1 down, columns by azimuth from x towards y. The
    /// numbers, at least 0, need not be normalised. The probabilities of its cells are exact.
    ///
    /// # Panics
    /// If rows differ in length, no number is above 0, or the domain is not a set of directions.
    pub fn from_table(domain: Domain, table: &[Vec<f64>]) -> Self {
        let (rows, columns) = (table.len(), table[0].len());
        assert!(
            table.iter().all(|row| row.len() == columns),
            "rows of different lengths"
        );
        let total: f64 = table.iter().flatten().sum();
        assert!(total > 0.0, "no number above 0");
        let largest = domain.largest_angle().expect("a domain of directions");
        let heights = 1.0 - largest.cos().round();
        let quantiles = Quantiles::from_table(heights, table);
        let measure = TAU * heights / (rows * columns) as f64;
        let densities: Vec<f64> = table
            .iter()
            .flatten()
            .map(|value| value / total / measure)
            .collect();
        let pdf = move |w: DVec3| {
            let [height, turn] = height_and_turn(w);
            let index = |x: f64, n: usize| ((x * n as f64) as usize).min(n - 1);
            if height <= heights {
                densities[index(height / heights, rows) * columns + index(turn, columns)]
            } else {
                0.0
            }
        };
        Self::from_grid(Partition::quantiles(domain, quantiles), pdf)
    }

    fn from_grid(fine_grid: Partition, pdf: impl Fn(DVec3) -> f64 + Send + Sync + 'static) -> Self {
        let mean = |f: Moment| {
            let all = fine_grid
                .masses
                .iter()
                .enumerate()
                .map(|(grid_cell, mass)| mass * moment_at(f, grid_cell));
            all.sum::<f64>() / fine_grid.mass()
        };
        let moments = MOMENTS.map(|(_, f)| mean(f));
        Self {
            fine_grid,
            moments,
            pdf: Box::new(pdf),
        }
    }

    /// Returns the pdf with respect to solid angle, 1/sr.
    pub fn pdf(&self, direction: DVec3) -> f64 {
        (self.pdf)(copied(direction))
    }

    /// Returns the probabilities of about `cells` cells on which samples are counted; with the loss
    /// they sum to one.
    pub fn cells(&self, cells: usize) -> Vec<f64> {
        self.fine_grid.coarsened(cells).masses
    }
}

/// Returns the value of a moment's function at the centre of a grid cell.
pub(super) fn moment_at(f: Moment, grid_cell: usize) -> f64 {
    let [rows, columns] = FINE_GRID;
    f(
        ((grid_cell / columns) as f64 + 0.5) / rows as f64,
        ((grid_cell % columns) as f64 + 0.5) / columns as f64,
    )
}
