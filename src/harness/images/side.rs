//! One side of a comparison: means, noise and skewness of its areas, and its brightest values.

use crate::harness::mean::satterthwaite;
use crate::harness::parallel::*;

/// Images of one renderer, or their mean and standard errors, in one channel, row by row.
#[derive(Clone, Debug)]
pub enum Side<'a> {
    /// Independent images, at least two; three or more give their skewness.
    Images(Vec<&'a [f64]>),
    /// One image and its standard errors. Pixels are taken to be independent, with a skewness of
    /// the mean of at most 1, as for light that was met once, and one degree of freedom each.
    Errors(&'a [f64], &'a [f64]),
    /// A reference without error.
    Exact(&'a [f64]),
}

impl Side<'_> {
    pub(super) fn images(&self) -> u32 {
        match self {
            Self::Images(images) => images.len() as u32,
            Self::Errors(..) => 1,
            Self::Exact(_) => u32::MAX,
        }
    }
}

/// Rectangle of pixels: left, top, and the first column and row outside.
pub type Area = [usize; 4];

/// The brightest thousandth of a side's values in one channel, at least one.
#[derive(Clone, Copy, Debug)]
pub struct Brightest {
    /// Number of these values.
    pub count: usize,
    /// Fraction of the variance of the image mean that they carry; from 0 to about 1. NaN where
    /// nothing varies.
    pub variance_fraction: f64,
    /// Number of the image with the brightest value, and number of its pixel.
    pub at: [usize; 2],
}

/// Mean of one side over an area.
#[derive(Clone, Copy)]
pub(super) struct AreaStatistics {
    pub mean: f64,
    pub variance: f64,
    pub dof: f64,
    /// Variance and third cumulant of the mean if pixels were independent.
    pub independent: [f64; 2],
}

/// One side with the statistics of its pixels.
pub(super) struct SideStatistics<'a> {
    side: &'a Side<'a>,
    width: usize,
    /// Mean, and variance and third cumulant of the mean, of each pixel.
    pub pixels: Vec<[f64; 3]>,
    /// Variance of the mean of a tile, or of a ninth of the image if that is more, over its value
    /// if pixels were independent; at least 1.
    pub correlation: f64,
}

impl<'a> SideStatistics<'a> {
    /// Computes the statistics; `grids` are the areas from which the correlation of pixels is
    /// found.
    pub fn new(side: &'a Side<'a>, width: usize, grids: [&[Area]; 2]) -> Self {
        let pixels: Vec<[f64; 3]> = match side {
            Side::Images(images) => (0..images[0].len())
                .into_par_iter()
                .map(|i| {
                    let n = images.len() as f64;
                    let mean = mean_of(images.iter().map(|image| image[i]));
                    let power = |k: i32| {
                        images
                            .iter()
                            .map(|image| (image[i] - mean).powi(k))
                            .sum::<f64>()
                    };
                    // Unbiased estimates, divided by n and n²; two images give 0/0: skewness is
                    // unknown.
                    [
                        mean,
                        power(2) / (n - 1.0) / n,
                        power(3) / ((n - 1.0) * (n - 2.0)) / n,
                    ]
                })
                .collect(),
            Side::Errors(mean, errors) => mean
                .iter()
                .zip(*errors)
                .map(|(&m, &e)| [m, e * e, e.powi(3)])
                .collect(),
            Side::Exact(mean) => mean.iter().map(|&m| [m, 0.0, 0.0]).collect(),
        };
        let mut statistics = Self {
            side,
            width,
            pixels,
            correlation: 1.0,
        };
        if let Side::Images(_) = side {
            let ratio = |areas: &[Area]| {
                let sums = areas
                    .iter()
                    .map(|at| (statistics.area_statistics(at), area(at).powi(2)));
                let (found, independent) = sums.fold((0.0, 0.0), |(f, i), (part, k)| {
                    (f + k * part.variance, i + k * part.independent[0])
                });
                found / independent
            };
            // NaN, where nothing varies, becomes 1.
            statistics.correlation = grids.map(ratio).into_iter().fold(1.0, f64::max);
        }
        statistics
    }

    /// Iterates over the numbers of the pixels of an area.
    pub fn pixels_of(&self, area: &Area) -> impl Iterator<Item = usize> + use<> {
        pixels_of(self.width, area)
    }

    pub fn area_statistics(&self, at: &Area) -> AreaStatistics {
        let pixels = || self.pixels_of(at);
        let share = 1.0 / area(at);
        let sum =
            |k: usize| pixels().map(|i| self.pixels[i][k]).sum::<f64>() * share.powi(1 + k as i32);
        let independent = [sum(1), sum(2)];
        let (mean, variance, dof) = match self.side {
            Side::Images(images) => {
                let n = images.len() as f64;
                let of = |image: &&[f64]| pixels().map(|i| image[i]).sum::<f64>() * share;
                let means: Vec<f64> = images.iter().map(of).collect();
                let mean = mean_of(means.iter().copied());
                let squares = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>();
                (mean, squares / (n - 1.0) / n, n - 1.0)
            }
            Side::Errors(..) => (
                sum(0),
                independent[0],
                satterthwaite(pixels().map(|i| (self.pixels[i][1], 1.0))),
            ),
            Side::Exact(_) => (sum(0), 0.0, f64::INFINITY),
        };
        AreaStatistics {
            mean,
            variance,
            dof,
            independent,
        }
    }

    /// Returns the values that are brightest relative to the mean of their pixel.
    pub fn brightest(&self) -> Brightest {
        // Height above the mean, number of the image, number of the pixel.
        let (mut values, per_square): (Vec<(f64, u32, usize)>, f64) = match self.side {
            Side::Images(images) => {
                let above = |k: usize| {
                    move |(i, value): (usize, &f64)| (value - self.pixels[i][0], k as u32, i)
                };
                let values = images
                    .iter()
                    .enumerate()
                    .flat_map(|(k, image)| image.iter().enumerate().map(above(k)));
                // A lone bright value exceeds the mean, which contains it, by 1 − 1/n of itself,
                // and n(n − 1) squares make the variance of a mean.
                (values.collect(), (images.len() as f64 - 1.0).powi(-2))
            }
            Side::Errors(_, errors) => (
                errors
                    .iter()
                    .enumerate()
                    .map(|(i, &error)| (error, 0, i))
                    .collect(),
                1.0,
            ),
            Side::Exact(_) => (Vec::new(), 1.0),
        };
        let count = (values.len() / 1000).max(1).min(values.len());
        if count < values.len() {
            values.select_nth_unstable_by(count, |x, y| y.0.total_cmp(&x.0));
        }
        let top = &values[..count];
        let squares: f64 = top.iter().map(|(above, ..)| above * above).sum();
        let variance: f64 = self.pixels.iter().map(|[_, variance, _]| variance).sum();
        let first = top
            .iter()
            .max_by(|x, y| x.0.total_cmp(&y.0))
            .map_or([0; 2], |&(_, k, i)| [k as usize, i]);
        Brightest {
            count,
            variance_fraction: squares * per_square / variance,
            at: first,
        }
    }

    /// Returns variance and third cumulant of the mean of `pixels` pixels, estimated from a part of
    /// `of` pixels.
    pub fn cumulants(&self, part: &AreaStatistics, of: f64, pixels: f64) -> [f64; 2] {
        // A sum of correlated terms is as skewed as a smaller number of independent ones.
        let together = if pixels > 1.0 { self.correlation } else { 1.0 };
        let more = of / pixels;
        let [second, third] = part.independent;
        [second * more * together, third * (more * together).powi(2)]
    }
}

/// Returns the mean of the values, exactly where all are the same.
fn mean_of(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let first = values.clone().next().unwrap_or(f64::NAN);
    first + values.clone().map(|value| value - first).sum::<f64>() / values.count() as f64
}

/// Iterates over the numbers of the pixels of an area in an image of this width.
pub(super) fn pixels_of(
    width: usize,
    &[x0, y0, x1, y1]: &Area,
) -> impl Iterator<Item = usize> + use<> {
    (y0..y1).flat_map(move |y| y * width + x0..y * width + x1)
}

pub(super) fn area([x0, y0, x1, y1]: &Area) -> f64 {
    ((x1 - x0) * (y1 - y0)) as f64
}

/// Cuts an image of `width` × `height` pixels into parts of `w` × `h`; returns their numbers across
/// and down, and the parts.
pub(super) fn grid([width, height]: [usize; 2], [w, h]: [usize; 2]) -> ([usize; 2], Vec<Area>) {
    let counts = [width.div_ceil(w), height.div_ceil(h)];
    let part = |i: usize| {
        let [x, y] = [i % counts[0] * w, i / counts[0] * h];
        [x, y, (x + w).min(width), (y + h).min(height)]
    };
    (counts, (0..counts[0] * counts[1]).map(part).collect())
}
