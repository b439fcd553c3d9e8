//! Adaptive sampling, [`crate::equation::ADAPTIVE`]: more samples for pixels where a pilot, a few samples of each pixel, has
//! seen more noise.
//!
//! The pilot's own samples are thrown away. So the number of samples of a pixel depends on none of them, and the mean over
//! these is as unbiased as with any other number. Averages in which the pilot's samples have a share by their number are
//! biased: what the pilot happens to see decides how much it weighs.

use crate::film::{Film, Pixel};
use crate::render::{Numbers, Sampling};
use crate::rng::seed_for;
use crate::sampler::LONGEST;

/// Scrambles of the pilot, whose spread tells the noise.
pub const REPLICATIONS: u32 = 4;

/// The samples of a pixel for each of which the pilot has one, unless it has more points of a scramble or fewer.
const SHARE: u32 = 32;
const POINTS: std::ops::RangeInclusive<u32> = 1..=8;

/// The share of all samples that are divided evenly: what the pilot overlooks costs at most five times the variance that
/// it has with equal numbers.
const EVEN: f64 = 0.2;

/// The most noise that counts, in multiples of the mean: no pixel waits for all.
const MOST: f64 = 8.0;

/// How far around a pixel noise is averaged, twice: a pixel's own estimate is far too noisy.
const REACH: usize = 3;

/// How to draw the [`REPLICATIONS`] of the pilot, by how the image draws so many: from other random numbers.
pub fn pilot(sampling: Sampling, replications: u32) -> Sampling {
    let numbers = match sampling.numbers {
        Numbers::Independent => Numbers::Independent,
        Numbers::Sobol(points) => {
            let share = points.saturating_mul(replications) / (SHARE * REPLICATIONS);
            Numbers::Sobol(share.clamp(*POINTS.start(), *POINTS.end()))
        }
    };
    Sampling { numbers, seed: seed_for(sampling.seed, "adaptive"), ..sampling }
}

/// How many samples a replication of each pixel has, row by row from the top: at least 1 and at most [`LONGEST`], `mean` of
/// them (no more than that) in the mean, and the more the larger the standard error is around it in the pilot's film, which
/// needs two replications at least.
pub fn counts(pilot: &Film, mean: u32) -> Vec<u32> {
    let noise = |pixel: &Pixel| pixel.standard_error().length();
    let width = pilot.size()[0] as usize;
    // Roots are averaged, not squares: a few large values, which are there by chance, shall not take all samples.
    let mut noise: Vec<f64> = pilot.pixels().iter().map(noise).collect();
    for _ in 0..2 {
        noise = blurred(&noise, width);
    }
    let average = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
    let shared = f64::from(mean.saturating_sub(1));
    // So that no scramble has more points than there are.
    let most = MOST.min((f64::from(LONGEST - 1) / shared - 1.0) / (1.0 - EVEN));
    let all = average(&noise);
    noise.iter_mut().for_each(|noise| *noise = if all > 0.0 { (*noise / all).min(most) } else { 0.0 });
    let all = average(&noise);
    let mut carried = 0.5;
    let count = |noise: f64| {
        // What is rounded off goes to the next pixel.
        carried += shared * (1.0 + (1.0 - EVEN) * (noise - all));
        let whole = f64::floor(carried);
        carried -= whole;
        1 + whole as u32
    };
    noise.into_iter().map(count).collect()
}

/// The mean of what lies within [`REACH`] columns and rows of each place.
fn blurred(values: &[f64], width: usize) -> Vec<f64> {
    let height = values.len() / width;
    let near = |at: usize, end: usize| at.saturating_sub(REACH)..(at + REACH + 1).min(end);
    let mean = |sum: f64, of: std::ops::Range<usize>| sum / of.len() as f64;
    let rows: Vec<f64> = (0..values.len())
        .map(|at| {
            let (row, columns) = (&values[at - at % width..][..width], near(at % width, width));
            mean(row[columns.clone()].iter().sum(), columns)
        })
        .collect();
    let column = |at: usize| {
        let near = near(at / width, height);
        mean(near.clone().map(|y| rows[y * width + at % width]).sum(), near)
    };
    (0..values.len()).map(column).collect()
}
