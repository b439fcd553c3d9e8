//! Adaptive sampling, [`crate::equation::ADAPTIVE`]: more samples for pixels around which a pilot,
//! the first samples of each pixel, found more noise.
//!
//! The pilot's samples stay in the image. If they had a say in how many samples their own pixel
//! takes, its mean would be biased: the brighter they happen to be, the less they would weigh. So
//! the number of samples of a pixel depends on the pilot of other pixels alone, and their mean is
//! as unbiased as with any other number.

use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::{PreparedRenderer, Progress};
use crate::error::Error;
use crate::film::{BegunReplications, Film, Pixel};
use crate::sampling::sampler::MAX_POINTS;

/// Least number of values of a pixel whose spread gives its noise, and largest number of
/// replications that take part in the pilot.
const VALUES: u32 = 4;

/// Divisor of the mean number of samples that gives the least, so that pixels where the pilot
/// overlooked the noise still get samples.
const LEAST_DIVISOR: u32 = 8;

/// Largest number of points of a scramble that give one value: a pilot that takes long would delay
/// the first image.
const MAX_POINTS_PER_VALUE: u32 = 8;

/// Largest weight of a pixel, in multiples of the mean, so that none takes nearly all samples.
const MAX_RELATIVE_WEIGHT: f64 = 8.0;

/// Radius, pixels, of the box filter that is applied twice to the noise: a pixel's own estimate is
/// far too noisy.
const FILTER_RADIUS: usize = 3;

/// Distance, pixels, between neighbours in a sublattice. The pixels of a sublattice share their
/// samples by the noise of all others.
const SPACING: usize = 2;

/// The first samples of an image, and the noise that they show.
#[derive(Clone, Debug, PartialEq)]
pub struct Pilot {
    /// Values of each pixel, and features of the film's own replications.
    noise: Film,
    begun: BegunReplications,
}

impl Pilot {
    /// Takes the first samples of the first four of `replications` replications of each pixel, or of
    /// all if they are fewer: an eighth of a replication, but at least one sample and at most eight
    /// for each of four values or more. Features are kept of the replications in `range`, which the
    /// film is for. `None` if `progress` returned false.
    ///
    /// # Errors
    /// Those of [`PreparedRenderer::add`].
    ///
    /// # Panics
    /// For a film without samples, or without replications.
    pub fn take(
        renderer: &dyn PreparedRenderer,
        film: &Film,
        replications: u32,
        range: &Range<u32>,
        progress: Progress<'_>,
    ) -> Result<Option<Self>, Error> {
        let mean = film.samples_per_replication();
        let stride = MAX_POINTS.min(u32::MAX / replications.max(1));
        let replications = replications.min(VALUES);
        // A single scramble is divided into blocks of points.
        let blocks = VALUES.div_ceil(replications).min(mean);
        let block = (mean / LEAST_DIVISOR / blocks).clamp(1, MAX_POINTS_PER_VALUE);
        let empty = Film::new(film.resolution(), Some(film.window()), mean)?;
        let (mut noise, mut of_block) = (empty.clone(), empty.clone());
        let mut sums = Vec::new();
        for replication in 0..replications {
            let mut of_replication = vec![DVec3::ZERO; film.pixels().len()];
            for first in (0..blocks).map(|k| k * block) {
                let end = first + block;
                of_block.assign(&empty);
                of_block.set_sample_counts(vec![end; film.pixels().len()]);
                // Samples of earlier blocks count as none.
                let earlier = if first > 0 {
                    vec![vec![DVec3::ZERO; film.pixels().len()]; replication as usize + 1]
                } else {
                    Vec::new()
                };
                of_block.begun = Some(Arc::new(BegunReplications {
                    samples: first,
                    stride,
                    sums: earlier,
                }));
                if !renderer.add(&mut of_block, replication..replication + 1, progress)? {
                    return Ok(None);
                }
                let rows = noise
                    .pixels_mut()
                    .par_iter_mut()
                    .zip_eq(of_block.pixels())
                    .zip_eq(&mut of_replication);
                rows.try_for_each(|((noise, pixel), sum)| {
                    let added = pixel.mean() * f64::from(end);
                    *sum += added;
                    noise.push(added / f64::from(block), block)?;
                    if range.contains(&replication) {
                        noise.merge_features(pixel)?;
                    }
                    Ok(())
                })?;
            }
            sums.push(of_replication);
        }
        let begun = BegunReplications {
            samples: block * blocks,
            stride,
            sums,
        };
        Ok(Some(Self { noise, begun }))
    }

    /// Returns a film whose pixels hold the values that the noise is measured by.
    pub fn noise(&self) -> &Film {
        &self.noise
    }

    /// Returns the number of samples in a replication of each pixel, row by row from the top.
    pub fn counts(&self) -> Vec<u32> {
        let mean = self.noise.samples_per_replication();
        counts(
            &self.noise,
            self.begun.samples.max(mean / LEAST_DIVISOR),
            mean,
        )
    }

    /// Gives the pixels of the film these numbers of samples, of which the pilot has taken the first.
    /// A film that rendering has filled before keeps its features, among which are the pilot's.
    ///
    /// # Errors
    /// [`Error::Option`] if the film's sums are full.
    ///
    /// # Panics
    /// If a count is smaller than the pilot's, or there are not as many as pixels.
    pub fn begin(self, film: &mut Film, counts: Vec<u32>) -> Result<(), Error> {
        assert!(
            counts.iter().all(|&count| count >= self.begun.samples),
            "fewer samples than the pilot's"
        );
        if film.pixels().iter().all(Pixel::is_empty) {
            let pairs = film.pixels_mut().iter_mut().zip(self.noise.pixels());
            pairs
                .into_iter()
                .try_for_each(|(pixel, pilot)| pixel.merge_features(pilot))?;
        }
        film.set_sample_counts(counts);
        film.begun = Some(Arc::new(self.begun));
        Ok(())
    }
}

/// Returns the number of samples in a replication of each pixel, row by row from the top: from
/// `least` to [`MAX_POINTS`], `mean` on average (itself in that range), and the more the larger the
/// standard error is around the pixel in a film of two replications or more. Pixels an even number of
/// columns and rows away, and the pixel itself, have no say in it.
pub fn counts(noise: &Film, least: u32, mean: u32) -> Vec<u32> {
    let width = noise.size()[0] as usize;
    // Standard deviations are averaged, not variances, lest a few values that are large by chance
    // take all samples.
    let noise: Vec<f64> = noise
        .pixels()
        .iter()
        .map(|pixel| pixel.standard_error().length())
        .collect();
    let mut counts = vec![mean; noise.len()];
    for sublattice in 0..SPACING * SPACING {
        let is_own =
            |at: usize| at % width % SPACING + SPACING * (at / width % SPACING) == sublattice;
        let others = box_filtered(&noise, |at| !is_own(at), width);
        let smooth = box_filtered(&others, |_| true, width);
        let (places, own): (Vec<usize>, Vec<f64>) = (0..noise.len())
            .filter(|&at| is_own(at))
            .map(|at| (at, smooth[at]))
            .unzip();
        for (at, count) in places.into_iter().zip(shares(&own, least, mean)) {
            counts[at] = count;
        }
    }
    counts
}

/// Returns the number of samples in a replication of each of some pixels from their noise.
fn shares(noise: &[f64], least: u32, mean: u32) -> impl Iterator<Item = u32> {
    let average = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
    let weights: Vec<f64> = noise.iter().map(|&noise| share(noise)).collect();
    let mean_weight = average(&weights);
    let extra = f64::from(mean - least);
    // A scramble has at most [`MAX_POINTS`] points.
    let max_relative = MAX_RELATIVE_WEIGHT.min(f64::from(MAX_POINTS - least) / extra - 1.0);
    let relative = |weight: f64| {
        if mean_weight > 0.0 {
            (weight / mean_weight).min(max_relative)
        } else {
            0.0
        }
    };
    let relative: Vec<f64> = weights.into_iter().map(relative).collect();
    let mean_relative = average(&relative);
    let mut remainder = 0.5;
    relative.into_iter().map(move |relative| {
        // What rounding leaves is carried to the next pixel.
        remainder += f64::from(least) + extra * (1.0 + relative - mean_relative);
        let count = whole_nets(remainder as u32).max(least);
        remainder -= f64::from(count);
        count
    })
}

/// Returns the weight of a pixel's noise: σ^(3/4) is the best share where the variance of n points
/// falls like n^(-5/3), which lies between the rates of rough integrands, 1/n, and smooth ones, n⁻³.
fn share(noise: f64) -> f64 {
    let root = noise.sqrt();
    root * root.sqrt()
}

/// Returns the largest number up to n with at most three binary digits other than the last zeros.
/// So many points of a sequence consist of a few whole nets, which are more even than others.
fn whole_nets(n: u32) -> u32 {
    let digits = u32::BITS - n.leading_zeros();
    let cut = digits.saturating_sub(3);
    n >> cut << cut
}

/// Returns for each pixel the mean of the values that count within [`FILTER_RADIUS`] columns and
/// rows; 0 if none does.
fn box_filtered(
    values: &[f64],
    does_count: impl Fn(usize) -> bool + Sync,
    width: usize,
) -> Vec<f64> {
    let height = values.len() / width;
    let window =
        |at: usize, end: usize| at.saturating_sub(FILTER_RADIUS)..(at + FILTER_RADIUS + 1).min(end);
    let add = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
    // Sums and numbers of values.
    let rows: Vec<[f64; 2]> = (0..values.len())
        .into_par_iter()
        .map(|at| {
            let row = at - at % width;
            let places = window(at % width, width).map(|x| row + x);
            places
                .filter(|&at| does_count(at))
                .fold([0.0; 2], |sums, at| add(sums, [values[at], 1.0]))
        })
        .collect();
    (0..values.len())
        .into_par_iter()
        .map(|at| {
            let places = window(at / width, height).map(|y| y * width + at % width);
            let [sum, count] = places.fold([0.0; 2], |sums, at| add(sums, rows[at]));
            sum / f64::max(count, 1.0)
        })
        .collect()
}
