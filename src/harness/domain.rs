//! Domains of samplers, and their partition into cells.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;

use super::quadrature::{Integral, Rectangle, halving_budget, integrate_within};
use super::quantiles::Quantiles;

/// Set of directions (local, unit, measured by solid angle) or of points (measured by area), with a
/// map to the unit square in which rows and columns make cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Domain {
    /// All directions; rows of equal solid angle.
    Sphere,
    /// Directions with z ≥ 0; rows of equal solid angle: equal probability for the uniform
    /// distribution.
    Hemisphere,
    /// Directions with z ≥ 0; rows of equal projected solid angle: equal probability for cos θ/π.
    CosineHemisphere,
    /// Points (x, y, 0) with x² + y² ≤ 1; rings of equal area.
    Disk,
    /// Points (x, y, 0) of the unit square.
    Square,
    /// Points (u, v, 0) with u, v ≥ 0 and u + v ≤ 1; strips of equal area.
    Triangle,
}

/// A coordinate with the sine and cosine of its angle.
#[derive(Clone, Copy)]
struct Coordinate {
    value: f64,
    sin: f64,
    cos: f64,
}

impl Coordinate {
    fn new(value: f64, angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self { value, sin, cos }
    }
}

/// Largest error of unit length and borders of points in double precision.
const ROUNDING: f64 = 1e-9;

impl Domain {
    /// Maps a point to the unit square; `None` outside the domain (and for NaN).
    pub fn to_square(self, p: DVec3) -> Option<[f64; 2]> {
        self.to_square_within(p, ROUNDING)
    }

    /// Maps a point whose unit length or border may be off by `rounding` to the unit square.
    fn to_square_within(self, p: DVec3, rounding: f64) -> Option<[f64; 2]> {
        let azimuth = || {
            let turn = p.y.atan2(p.x) / TAU;
            if turn < 0.0 { turn + 1.0 } else { turn }
        };
        let inside = |yes: bool, square: [f64; 2]| yes.then_some(square);
        match self {
            Self::Sphere => inside(
                self.has_direction(p, rounding),
                [0.5 * (1.0 - p.z), azimuth()],
            ),
            Self::Hemisphere => inside(self.has_direction(p, rounding), [1.0 - p.z, azimuth()]),
            Self::CosineHemisphere => inside(
                self.has_direction(p, rounding),
                [p.x * p.x + p.y * p.y, azimuth()],
            ),
            Self::Disk => {
                let s = p.x * p.x + p.y * p.y;
                inside(s <= 1.0 + rounding && p.z == 0.0, [s, azimuth()])
            }
            Self::Square => {
                let unit = 0.0..=1.0;
                inside(unit.contains(&p.x) && unit.contains(&p.y), [p.x, p.y])
            }
            Self::Triangle => {
                let rest = 1.0 - p.x;
                let yes = p.x >= 0.0 && p.y >= 0.0 && p.y <= rest + rounding;
                inside(
                    yes,
                    [1.0 - rest * rest, if rest > 0.0 { p.y / rest } else { 0.0 }],
                )
            }
        }
    }

    /// Returns the largest polar angle, radians; `None` for a domain of points.
    pub(super) fn largest_angle(self) -> Option<f64> {
        match self {
            Self::Sphere => Some(PI),
            Self::Hemisphere | Self::CosineHemisphere => Some(FRAC_PI_2),
            Self::Disk | Self::Square | Self::Triangle => None,
        }
    }

    /// Returns whether a vector is one of the domain's directions, up to an error `rounding` of
    /// unit length and horizon.
    fn has_direction(self, w: DVec3, rounding: f64) -> bool {
        // Directions in double precision are exact at the horizon.
        let above = w.z >= if rounding > ROUNDING { -rounding } else { 0.0 };
        (w.length_squared() - 1.0).abs() < rounding && (self == Self::Sphere || above)
    }

    /// Returns the smooth coordinate (θ, r, x or u) of the row border at s in [0, 1].
    fn border(self, s: f64) -> f64 {
        match self {
            Self::Sphere => (1.0 - 2.0 * s).acos(),
            Self::Hemisphere => (1.0 - s).acos(),
            Self::CosineHemisphere => s.sqrt().asin(),
            Self::Disk => s.sqrt(),
            Self::Square => s,
            Self::Triangle => 1.0 - (1.0 - s).sqrt(),
        }
    }

    /// Returns the point at a smooth coordinate and a column coordinate in [0, 1], and its measure
    /// per unit of both.
    fn point(self, row: Coordinate, column: Coordinate) -> (DVec3, f64) {
        let (a, b) = (row.value, column.value);
        match self {
            Self::Sphere | Self::Hemisphere | Self::CosineHemisphere => {
                let [x, y] = [row.sin * column.cos, row.sin * column.sin];
                (DVec3::new(x, y, row.cos), TAU * row.sin)
            }
            Self::Disk => (DVec3::new(a * column.cos, a * column.sin, 0.0), TAU * a),
            Self::Square => (DVec3::new(a, b, 0.0), 1.0),
            Self::Triangle => (DVec3::new(a, b * (1.0 - a), 0.0), 1.0 - a),
        }
    }

    /// Integrates f over rows × columns [s₀, s₁] × [b₀, b₁] of the square, with respect to the
    /// domain's measure.
    pub fn integrate(
        self,
        part: [[f64; 2]; 2],
        tolerance: f64,
        f: &dyn Fn(DVec3) -> f64,
    ) -> Integral {
        self.integrate_within(self.area(part), tolerance, &mut halving_budget(), f)
    }

    /// Returns the rectangle of smooth coordinates of rows × columns of the square.
    fn area(self, [rows, columns]: [[f64; 2]; 2]) -> Rectangle {
        Rectangle {
            x: rows.map(|s| self.border(s)),
            y: columns,
        }
    }

    /// Integrates f over a rectangle of the smooth coordinates.
    fn integrate_within(
        self,
        area: Rectangle,
        tolerance: f64,
        budget: &mut usize,
        f: &dyn Fn(DVec3) -> f64,
    ) -> Integral {
        integrate_within(area, tolerance, budget, &mut |rows, columns| {
            let columns = columns.map(|b| Coordinate::new(b, TAU * b));
            rows.map(|a| {
                let row = Coordinate::new(a, a);
                columns.map(|column| {
                    let (point, measure) = self.point(row, column);
                    f(point) * measure
                })
            })
        })
    }

    /// Integrates f over the whole domain, cut into 2 × 4 parts to begin with, so that no lobe is
    /// overlooked.
    pub fn integrate_all(self, tolerance: f64, f: &dyn Fn(DVec3) -> f64) -> Integral {
        let parts = (0..8).map(|k| self.integrate(grid_cell(k, [2, 4]), tolerance / 8.0, f));
        parts.fold(Integral::default(), |sum, part| Integral {
            value: sum.value + part.value,
            error: sum.error + part.error,
        })
    }
}

/// Returns the rows and columns of cell k of a grid of the unit square, counted row by row.
fn grid_cell(k: usize, [rows, columns]: [usize; 2]) -> [[f64; 2]; 2] {
    let ends = |i: usize, n: usize| [i as f64 / n as f64, (i + 1) as f64 / n as f64];
    [ends(k / columns, rows), ends(k % columns, columns)]
}

/// A domain cut into cells of known probability.
#[derive(Clone, Debug)]
pub struct Partition {
    /// Domain that is partitioned.
    pub domain: Domain,
    /// Probabilities of the cells; with `loss` they sum to one.
    pub masses: Vec<f64>,
    /// Places of the cells, in words.
    pub places: Vec<String>,
    /// Probability that the sampler returns nothing.
    pub loss: f64,
    /// Accuracy of the probabilities: 0 for closed forms, else the quadrature's error, at least its
    /// tolerance.
    pub error: f64,
    /// Further relative error of each probability: rounding of a density in single precision.
    pub(crate) relative: f64,
    /// Largest error of unit length and borders of points.
    rounding: f64,
    rows: usize,
    columns: usize,
    /// Quantiles that define rows and columns, if the domain's square does not.
    quantiles: Option<Quantiles>,
    /// Cell that each cell of the grid belongs to.
    cell_of: Vec<usize>,
}

/// Rows and columns of the grid on which a density is integrated before its cells are merged
/// into larger ones.
pub(super) const FINE_GRID: [usize; 2] = [32, 64];
/// Total tolerance of a partition's probabilities.
pub const MASS_TOLERANCE: f64 = 1e-6;

impl Partition {
    /// Creates rows × columns cells of equal probability, for the distribution that is uniform in
    /// the domain's square: exact, without loss.
    pub fn equal(domain: Domain, rows: usize, columns: usize) -> Self {
        let cells = rows * columns;
        Self {
            domain,
            masses: vec![1.0 / cells as f64; cells],
            places: (0..cells)
                .map(|k| {
                    place(
                        [k / columns, k / columns + 1],
                        [k % columns, k % columns + 1],
                        rows,
                        columns,
                    )
                })
                .collect(),
            loss: 0.0,
            error: 0.0,
            relative: 0.0,
            rounding: ROUNDING,
            rows,
            columns,
            quantiles: None,
            cell_of: (0..cells).collect(),
        }
    }

    /// Creates grid cells of equal probability from the quantiles of a density of directions.
    pub(super) fn quantiles(domain: Domain, quantiles: Quantiles) -> Self {
        Self {
            quantiles: Some(quantiles),
            ..Self::equal(domain, FINE_GRID[0], FINE_GRID[1])
        }
    }

    /// Creates the outcomes of a discrete distribution with these probabilities (which sum to one),
    /// for counts made elsewhere.
    pub fn from_masses(masses: Vec<f64>, places: Vec<String>) -> Self {
        Self {
            domain: Domain::Square,
            rows: 1,
            columns: masses.len(),
            quantiles: None,
            cell_of: (0..masses.len()).collect(),
            masses,
            places,
            loss: 0.0,
            error: 0.0,
            relative: 0.0,
            rounding: ROUNDING,
        }
    }

    /// Creates about `cells` cells of nearly equal probability under a density: adaptive quadrature
    /// integrates the cells of a fine grid (for directions, one of the density's quantiles), which
    /// are merged by halving.
    pub fn from_pdf(domain: Domain, cells: usize, pdf: &dyn Fn(DVec3) -> f64) -> Self {
        Self::fine_grid(domain, MASS_TOLERANCE, pdf).coarsened(cells)
    }

    /// Integrates a density over each cell of a fine grid by adaptive quadrature, to this
    /// tolerance in all. One minus the sum is the loss. The work is bounded:
    /// a density that is too rough leaves an error with which no test holds, NaN leaves NaN.
    pub(crate) fn fine_grid(domain: Domain, tolerance: f64, pdf: &dyn Fn(DVec3) -> f64) -> Self {
        let [rows, columns] = FINE_GRID;
        let grid = match domain.largest_angle() {
            Some(largest) => Self::quantiles(domain, Quantiles::from_pdf(FINE_GRID, largest, pdf)),
            None => Self::equal(domain, rows, columns),
        };
        let area = |k: usize| match &grid.quantiles {
            Some(quantiles) => quantiles.grid_cell([k / columns, k % columns]),
            None => domain.area(grid_cell(k, FINE_GRID)),
        };
        let mut cells: Vec<Integral> = (0..rows * columns)
            .map(|k| domain.integrate_within(area(k), tolerance, &mut 0, pdf))
            .collect();
        // Smooth cells are done at once, and leave most of the tolerance to those that an edge
        // crosses.
        let cell_tolerance = 0.5 * tolerance / cells.len() as f64;
        let rough = |cell: &&Integral| cell.error > cell_tolerance;
        let rough_tolerance = 0.5 * tolerance / cells.iter().filter(rough).count().max(1) as f64;
        let mut budget = halving_budget();
        for (k, cell) in cells.iter_mut().enumerate() {
            if cell.error > cell_tolerance {
                *cell = domain.integrate_within(area(k), rough_tolerance, &mut budget, pdf);
            }
        }
        let masses: Vec<f64> = cells.iter().map(|cell| cell.value).collect();
        let error: f64 = cells.iter().map(|cell| cell.error).sum();
        // NaN stays.
        let error = if error <= tolerance { tolerance } else { error };
        let loss = (1.0 - masses.iter().sum::<f64>()).max(0.0);
        Self {
            masses,
            loss,
            error,
            ..grid
        }
    }

    /// Merges the cells of a grid by halving into about `cells` cells of nearly equal probability.
    pub fn coarsened(&self, cells: usize) -> Self {
        let mut partition = Self {
            masses: Vec::new(),
            places: Vec::new(),
            ..self.clone()
        };
        partition.coarsen(&self.masses, [0, self.rows], [0, self.columns], cells);
        partition
    }

    /// Sets the largest error of unit length and borders of points: 1e-9 unless set; 1e-5 suits
    /// points in single precision.
    pub fn rounding(self, rounding: f64) -> Self {
        Self { rounding, ..self }
    }

    /// Returns why a point is outside the domain, in words that follow the point; `None` if it is
    /// inside.
    pub(crate) fn outside(&self, point: DVec3) -> Option<String> {
        let directions = matches!(
            self.domain,
            Domain::Sphere | Domain::Hemisphere | Domain::CosineHemisphere
        );
        let length = point.length();
        let why = || match directions && (length * length - 1.0).abs() >= self.rounding {
            true => format!(
                "is no unit vector to {:.0e}: its length is {length}",
                self.rounding
            ),
            false => format!("is no point of the domain {:?}", self.domain),
        };
        self.cell(point).is_none().then(why)
    }

    /// Returns the cell of a point; `None` outside the domain.
    pub fn cell(&self, point: DVec3) -> Option<usize> {
        let [s, b] = match &self.quantiles {
            Some(quantiles) if self.domain.has_direction(point, self.rounding) => {
                quantiles.to_square(point)?
            }
            Some(_) => return None,
            None => self.domain.to_square_within(point, self.rounding)?,
        };
        let index = |x: f64, n: usize| ((x * n as f64) as usize).min(n - 1);
        Some(self.cell_of[index(s, self.rows) * self.columns + index(b, self.columns)])
    }

    /// Returns whether [`Partition::cell`] of a point exists.
    pub(super) fn contains(&self, point: DVec3) -> bool {
        if self.quantiles.is_some() {
            self.domain.has_direction(point, self.rounding)
        } else {
            self.cell(point).is_some()
        }
    }

    /// Iterates over the cells that the grid's cells belong to, row by row.
    pub(crate) fn cells_of_grid(&self) -> impl Iterator<Item = usize> {
        self.cell_of.iter().copied()
    }

    /// Returns the sum of all probabilities: 1 − loss.
    pub fn mass(&self) -> f64 {
        self.masses.iter().sum()
    }

    /// Describes where a block of grid cells lies.
    fn place(&self, rows: [usize; 2], columns: [usize; 2]) -> String {
        let Some(quantiles) = &self.quantiles else {
            return place(rows, columns, self.rows, self.columns);
        };
        let [from, to] = rows.map(|row| quantiles.degrees(row as f64 / self.rows as f64));
        let [least, most] = columns.map(|column| column as f64 / self.columns as f64);
        format!(
            "{from:.4} to {to:.4} degrees from z, quantiles {least:.3} to {most:.3} of the azimuth there"
        )
    }

    /// Cuts a block of grid cells into `cells` cells of about equal probability.
    fn coarsen(
        &mut self,
        fine_masses: &[f64],
        rows: [usize; 2],
        columns: [usize; 2],
        cells: usize,
    ) {
        let all = self.columns;
        let mass = |r: [usize; 2], c: [usize; 2]| -> f64 {
            (r[0]..r[1])
                .map(|i| {
                    fine_masses[i * all + c[0]..i * all + c[1]]
                        .iter()
                        .sum::<f64>()
                })
                .sum()
        };
        let total = mass(rows, columns);
        let first = cells / 2;
        let target = total * first as f64 / cells as f64;
        // All cuts across rows or columns, by their distance from the wanted probability.
        let cuts = (rows[0] + 1..rows[1])
            .map(|m| ([[rows[0], m], columns], [[m, rows[1]], columns]))
            .chain(
                (columns[0] + 1..columns[1])
                    .map(|m| ([rows, [columns[0], m]], [rows, [m, columns[1]]])),
            );
        let best = cuts
            .map(|(a, b)| ((mass(a[0], a[1]) - target).abs(), a, b))
            .min_by(|x, y| x.0.total_cmp(&y.0));
        match best {
            Some((_, a, b)) if cells > 1 => {
                self.coarsen(fine_masses, a[0], a[1], first);
                self.coarsen(fine_masses, b[0], b[1], cells - first);
            }
            _ => {
                for i in rows[0]..rows[1] {
                    self.cell_of[i * all + columns[0]..i * all + columns[1]]
                        .fill(self.masses.len());
                }
                self.masses.push(total);
                self.places.push(self.place(rows, columns));
            }
        }
    }
}

fn place(r: [usize; 2], c: [usize; 2], rows: usize, columns: usize) -> String {
    format!(
        "row {}-{} of {rows}; column {}-{} of {columns}",
        r[0], r[1], c[0], c[1]
    )
}
