//! Faults of low-discrepancy numbers.

use whitefurnace::harness::tails::normal_sf;
use whitefurnace::math::moments::Moments;
use whitefurnace::sampling::rng::stream;

use crate::prelude::*;
use crate::sobol::{Block, CORRECT, Point, SobolParts, scrambled, sobol};

/// Returns a block in which one number is repeated in place of the next.
fn repeated(mut block: Block, one: usize) -> Block {
    block[one + 1] = block[one];
    block
}

/// Faults of the numbers themselves.
pub(super) fn of_numbers() -> Vec<Fault<SobolParts>> {
    let with = |numbers| SobolParts { numbers, ..CORRECT };
    vec![
        fault!("unscrambled", SOBOL, "one scramble for everything: each point of the sequence is where it always is",
            = with(|point, block| {
                let fill = stream(point.seed, point.replication, point.index);
                scrambled(point, block, 0, fill)
            }),
            "sampler/independent: correlation, next scramble"),
        fault!("one-scramble-for-all-pixels", SOBOL, "the scramble does not depend on the pixel",
            = with(|point, block| sobol(Point { pixel: 0, ..point }, block)),
            "sampler/independent: correlation, next pixel"),
        fault!("blocks-alike", SOBOL, "every block is the same points",
            = with(|point, _| sobol(point, 0)), "sampler/independent: correlation, next block"),
        fault!("scramble-per-sample", SOBOL, "each sample has a scramble of its own: independent numbers, no net",
            = with(|point, block| {
                sobol(Point { replication: point.replication ^ point.index << 16, ..point }, block)
            }),
            "sampler/stratified: elementary intervals | intervals of one coordinate"),
        fault!("second-coordinate-twice", SOBOL,
            "the third number repeats the second: points on a light lie on its diagonal",
            = with(|point, block| repeated(sobol(point, block), 1)),
            "sampler/mean"),
        fault!("first-coordinate-twice", SOBOL, "the second number repeats the first: directions lie on a spiral",
            = with(|point, block| repeated(sobol(point, block), 0)),
            "sampler/independent: correlation, next coordinate"),
        fault!("last-sixteenth-empty", SOBOL,
            "numbers of [0, 15/16): the last sixteenth of every coordinate is never met",
            = with(|point, block| sobol(point, block).map(|u| u * 15.0 / 16.0)),
            "sampler/uniform: coordinate 0 | coordinate 1 | coordinate 2 | coordinate 3 | coordinate 4 \
             | coordinate 5 | coordinate 6 | coordinate 7"),
        fault!("no-fill", SOBOL, "nothing below the 23 leading bits",
            = with(|point, block| sobol(point, block).map(|u| (u * f64::from(1 << 23)).floor() / f64::from(1 << 23))),
            "sampler/uniform: low bits"),
    ]
}

/// Faults of the spread over replications, and of the error bars from it.
pub(super) fn of_error_bars() -> Vec<Fault<SobolParts>> {
    vec![
        fault!("one-scramble-for-two-replications", SOBOL,
            "every second replication of a pixel is the points of the one before again",
            SobolParts: { numbers: |point, block| {
                sobol(Point { replication: point.replication / 2, ..point }, block)
            } },
            "sampler/error-bars", "sampler/coverage"),
        fault!("samples-as-if-independent", SOBOL, "an error bar from single samples, which repel each other",
            SobolParts: { squared_error: |rows| {
                let moments: Moments = rows.iter().flatten().copied().collect();
                moments.variance() / moments.count() as f64
            } },
            "sampler/error-bars", "sampler/coverage"),
        fault!("few-as-if-many", SOBOL, "the normal distribution's interval, for a variance that is known",
            SobolParts: { p: |error, _| 2.0 * normal_sf(error.abs()) },
            "sampler/coverage"),
    ]
}
