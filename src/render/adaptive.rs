//! Adaptive sampling, [`crate::equation::ADAPTIVE`]: more samples for pixels where a pilot, a few
//! samples of each pixel, found more noise.
//!
//! The pilot's own samples are thrown away. So the number of samples of a pixel depends on none of
//! the samples it has, and their mean is as unbiased as with any other number. Averages that
//! include the pilot's samples are biased, as the pilot's values decide how much it weighs.

use crate::film::{Film, Pixel};
use crate::sampling::Sampling;
use crate::sampling::rng::seed_for;
use crate::sampling::sampler::MAX_POINTS;

/// Number of scrambles of the pilot, whose spread gives the noise.
pub const REPLICATIONS: u32 = 4;

/// Divisor of the pixel's number of samples that gives the pilot's, with at least one point and at
/// most [`MAX_PILOT_POINTS`] of each scramble.
const PILOT_DIVISOR: u32 = 32;
const MAX_PILOT_POINTS: u32 = 8;

/// Fraction of the samples that is divided evenly, so that pixels where the pilot overlooked the
/// noise still get samples.
const UNIFORM_FRACTION: f64 = 0.2;

/// Largest noise that counts, in multiples of the mean, so that no pixel takes nearly all samples.
const MAX_RELATIVE_NOISE: f64 = 8.0;

/// Radius, pixels, of the box filter that is applied twice to the noise: a pixel's own estimate is
/// far too noisy.
const FILTER_RADIUS: usize = 3;

/// Returns the sampling settings of the pilot, of [`REPLICATIONS`] replications, for an image of
/// `replications` replications: fewer points in each, and another seed.
pub fn pilot(sampling: Sampling, replications: u32) -> Sampling {
    let samples = sampling
        .samples_per_replication()
        .saturating_mul(replications);
    let points = (samples / (PILOT_DIVISOR * REPLICATIONS)).clamp(1, MAX_PILOT_POINTS);
    Sampling {
        seed: seed_for(sampling.seed, "adaptive"),
        ..sampling.with_samples(points)
    }
}

/// Returns the number of samples in a replication of each pixel, row by row from the top: from 1 to
/// [`MAX_POINTS`], `mean` on average (itself in that range), and the more the larger the standard
/// error is around the pixel in the pilot's film, which needs two replications or more.
pub fn counts(pilot: &Film, mean: u32) -> Vec<u32> {
    let noise = |pixel: &Pixel| pixel.standard_error().length();
    let width = pilot.size()[0] as usize;
    // Standard deviations are averaged, not variances, lest a few values that are large by chance
    // take all samples.
    let noise: Vec<f64> = pilot.pixels().iter().map(noise).collect();
    let noise = box_filtered(&box_filtered(&noise, width), width);
    let average = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
    let extra = f64::from(mean.saturating_sub(1));
    // A scramble has at most [`MAX_POINTS`] points.
    let max_relative = MAX_RELATIVE_NOISE
        .min((f64::from(MAX_POINTS - 1) / extra - 1.0) / (1.0 - UNIFORM_FRACTION));
    let mean_noise = average(&noise);
    let relative = |noise: f64| {
        if mean_noise > 0.0 {
            (noise / mean_noise).min(max_relative)
        } else {
            0.0
        }
    };
    let relative: Vec<f64> = noise.into_iter().map(relative).collect();
    let mean_relative = average(&relative);
    let mut remainder = 0.5;
    let count = |relative: f64| {
        // The rounding remainder is carried to the next pixel.
        remainder += extra * (1.0 + (1.0 - UNIFORM_FRACTION) * (relative - mean_relative));
        let whole = f64::floor(remainder);
        remainder -= whole;
        1 + whole as u32
    };
    relative.into_iter().map(count).collect()
}

/// Returns the mean within [`FILTER_RADIUS`] columns and rows of each pixel.
fn box_filtered(values: &[f64], width: usize) -> Vec<f64> {
    let height = values.len() / width;
    let window =
        |at: usize, end: usize| at.saturating_sub(FILTER_RADIUS)..(at + FILTER_RADIUS + 1).min(end);
    let mean = |sum: f64, of: std::ops::Range<usize>| sum / of.len() as f64;
    let rows: Vec<f64> = (0..values.len())
        .map(|at| {
            let (row, columns) = (
                &values[at - at % width..][..width],
                window(at % width, width),
            );
            mean(row[columns.clone()].iter().sum(), columns)
        })
        .collect();
    let column = |at: usize| {
        let window = window(at / width, height);
        mean(
            window.clone().map(|y| rows[y * width + at % width]).sum(),
            window,
        )
    };
    (0..values.len()).map(column).collect()
}
