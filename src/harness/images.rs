//! Tests of two renderers by images that they made independently: the image mean, regions, tiles
//! and pixels, by Welch's test under one level for all, with nothing assumed about the distribution
//! of a pixel's values or the correlation of neighbours beyond what the images show.
//!
//! A quarter of the level goes to each kind of area, and is divided among its areas and channels
//! (Bonferroni). An area is judged where skewness leaves the tail of its test valid
//! ([`Sigma::skew_term`]); a kind is counted where at least [`MIN_JUDGED_FRACTION`] of its areas
//! that vary are judged. The difference of the two sides' third cumulants bends the tail of a
//! difference: renderers whose noise is alike may be skewed more, up to
//! [`MAX_UNCANCELLED_SKEW_TERM`]. Beyond that, a difference of [`LARGE_DIFFERENCE_FACTOR`]
//! times the critical value or more stands.
//!
//! Standard errors are estimates, and enter no inequality that needs the true ones: with few
//! images, p comes from Student's distribution, whose degrees of freedom are found by the sides'
//! shares of the variance of many pixels ([`MIN_INDEPENDENT_PIXELS`]), as those of few values can
//! be far off where the sides have different numbers of images.
//!
//! A difference must be more than that of one pixel, whose values may be few: one pixel makes up at
//! most [`MAX_PIXEL_FRACTION`] of an area's, and a pixel's own is compared with the noise of the
//! noisiest of its tile as well.
//!
//! All this holds as far as the images show their brightest paths. Noise that has not been seen has
//! no test: [`Comparison::brightest`] shows where a few values carry much of the noise
//! ([`MAX_BRIGHT_FRACTION`]), so that rarer ones may be missing.
//!
//! In a channel without noise, where no pixel of either side varies in [`MIN_NOISELESS_VALUES`]
//! values or more, values are compared directly: any difference beyond rounding is a rejection. The
//! same holds for an area without noise beside others that have some, where as many values differ
//! and none of them is black: black ones may have missed all light, and are evidence if they are
//! [`MIN_CONSTANT_VALUES`]. Light that is hit once in many images may still be missing.
//!
//! ```
//! use whitefurnace::harness::images::{Rules, Side, compare};
//! use whitefurnace::harness::outcome::Verdict;
//!
//! // Four images of 8 × 8 pixels of each renderer, in one channel.
//! let image = |seed: u32| (0..64).map(|i| f64::from((7 * i + seed) * 37 %
//! 41)).collect::<Vec<f64>>(); let [a, b]: [Vec<Vec<f64>>; 2] = [0, 20].map(|seed| (seed..seed +
//! 4).map(image).collect()); let [a, b] = [&a, &b].map(|images|
//! Side::Images(images.iter().map(Vec::as_slice).collect())); let found = compare(8, &[[a, b]],
//! &Rules { margin: 0.5, ..Rules::default() }); assert_eq!(found.verdict, Verdict::Holds);
//! ```

mod area_test;
mod pixel_statistics;
mod side;

pub use area_test::{AreaKind, AreaTest};
pub use pixel_statistics::{ImageMoments, PValueMap, PixelStatistics, image_mean, welch_map};
pub use side::{Area, Brightest, Side};

use super::mean::{MAX_SKEW_TERM, MIN_CONSTANT_VALUES, Sigma, satterthwaite};
use super::outcome::{Verdict, equivalence_verdict};
use super::parallel::*;
use super::power::smallest_effect_in_estimates;
use super::tails::{student_two_sided, student_upper};
use crate::math::HALF_ROUNDING;
use side::{AreaStatistics, SideStatistics, area, grid};

/// Least fraction of the varying areas that must be judged for their kind to be counted.
pub const MIN_JUDGED_FRACTION: f64 = 0.5;
/// Largest term of one side's skewness where the other's cancels it: four times the usual limit, as
/// the next terms of the expansion fall as the square.
pub const MAX_UNCANCELLED_SKEW_TERM: f64 = 4.0 * MAX_SKEW_TERM;
/// Factor on the critical standard errors of its level above which a difference stands in spite of
/// skewness, if the tail there, times twice the effect of skewness (the exponential of two
/// [`Sigma::skew_term`]s), is below the level.
pub const LARGE_DIFFERENCE_FACTOR: f64 = 2.0;
/// Largest skewness with which a large difference stands: that of 25 observed events, enough to
/// know the distribution.
pub const MAX_LARGE_DIFFERENCE_SKEWNESS: f64 = 0.2;
/// Number of independently varying pixels that show how variance and skewness are divided between
/// the sides.
pub const MIN_INDEPENDENT_PIXELS: f64 = 64.0;
/// Fraction of a side's variance carried by the brightest thousandth of its values above which
/// further bright values may be missing: exponential noise has 5 %, noise whose variance is barely
/// finite (Pareto's distribution of index 2.5) and shadow rays to a lamp on the ceiling, at 4
/// samples, a quarter and more.
pub const MAX_BRIGHT_FRACTION: f64 = 0.2;
/// Least normal 16-bit float: below it, rounding is absolute.
pub const MIN_NORMAL_HALF: f64 = 1.0 / 16384.0;
/// Largest relative error of a mean of 4096 samples that are added one by one in single precision:
/// 4096·2⁻²⁴.
pub const SINGLE_SUM_ERROR: f64 = 1.0 / 4096.0;
/// Largest fraction of an area's difference that one pixel may have.
pub const MAX_PIXEL_FRACTION: f64 = 0.5;
/// Probability of missing a bias of the minimum detectable size.
pub const MISS_PROBABILITY: f64 = 0.1;
/// Fraction of the second image's mean below which differences are relative to that mean.
pub const DARK_FRACTION: f64 = 1e-3;

/// Least number of values of each side, pixels times images, none of which varies, that are taken
/// to have no noise. Independent values of one distribution are all the same on either side, but
/// differ between the sides, with a probability of at most 2·4⁻ⁿ.
pub const MIN_NOISELESS_VALUES: f64 = 16.0;

/// Rules by which images are judged.
#[derive(Clone, Debug)]
pub struct Rules {
    /// Largest probability that two right renderers are called different.
    pub level: f64,
    /// Largest difference of image means that are called equal, relative to the second's.
    pub margin: f64,
    /// Side of a tile, pixels.
    pub tile: usize,
    /// Regions to judge besides a grid of nine.
    pub regions: Vec<Area>,
    /// Fraction of the values below which differences are rounding.
    pub rounding: f64,
    /// Whether samples may have been added one by one in single precision: differences up to
    /// [`SINGLE_SUM_ERROR`] are then no evidence, and the verdict is undecided if there are no
    /// others.
    pub single_sums: bool,
}

impl Default for Rules {
    fn default() -> Self {
        Self {
            level: 1e-3,
            margin: 0.01,
            tile: 16,
            regions: Vec::new(),
            rounding: 1e-5,
            single_sums: false,
        }
    }
}

/// Result of a comparison: the image mean, regions, tiles and pixels.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The image mean, regions, tiles and pixels, in this order.
    pub kinds: [AreaKind; 4],
    /// Brightest values of the two sides, channel by channel.
    pub brightest: Vec<[Brightest; 2]>,
    /// Verdict: fails if any area is rejected by more than [`Rules::single_sums`] allows; holds if
    /// none is, and the image means are equal within the margin. If undecided, about how many times
    /// as many images would decide; `u64::MAX` if more of the same would not.
    pub verdict: Verdict,
}

/// Compares two sides, channel by channel, of images of this `width`.
///
/// # Panics
/// If sides have different numbers of pixels, or a region is not within the image.
pub fn compare(width: usize, channels: &[[Side; 2]], rules: &Rules) -> Comparison {
    let pixels = match &channels[0][0] {
        Side::Images(images) => images[0].len(),
        Side::Errors(mean, _) | Side::Exact(mean) => mean.len(),
    };
    let size = [width, pixels / width];
    let (tiles_across, tiles) = grid(size, [rules.tile; 2]);
    let (_, mut regions) = grid(size, size.map(|side| side.div_ceil(3)));
    let prepare = |side| SideStatistics::new(side, width, [&tiles, &regions]);
    let statistics: Vec<[SideStatistics; 2]> = channels
        .iter()
        .map(|sides| sides.each_ref().map(prepare))
        .collect();
    regions.extend(&rules.regions);
    let noiseless: Vec<bool> = channels
        .iter()
        .zip(&statistics)
        .map(|(of, sides)| {
            let enough = of
                .iter()
                .all(|side| f64::from(side.images()) * pixels as f64 >= MIN_NOISELESS_VALUES);
            enough
                && sides
                    .iter()
                    .all(|side| side.pixels.iter().all(|[_, variance, _]| *variance == 0.0))
        })
        .collect();
    let area_statistics = |channel: usize, area: &Area| {
        statistics[channel]
            .each_ref()
            .map(|side| side.area_statistics(area))
    };
    let whole = [0, 0, size[0], size[1]];
    let overall: Vec<f64> = (0..channels.len())
        .map(|channel| area_statistics(channel, &whole)[1].mean.abs())
        .collect();
    let of_tiles: Vec<Vec<[AreaStatistics; 2]>> = (0..channels.len())
        .map(|channel| {
            (&tiles)
                .into_par_iter()
                .map(|tile| area_statistics(channel, tile))
                .collect()
        })
        .collect();
    // Whether enough pixels vary independently on both sides to show how their noise is divided.
    let are_many = |channel: usize, at: &Area| {
        let correlation = statistics[channel].each_ref().map(|side| side.correlation);
        area(at) / correlation[0].max(correlation[1]) >= MIN_INDEPENDENT_PIXELS
    };
    let tile_of = |at: &Area| at[1] / rules.tile * tiles_across[0] + at[0] / rules.tile;
    // Whether a significant difference is more than one pixel with few values, of which each side
    // happens to have met another one every time: for a pixel, by the noisiest of its tile; for an
    // area, if no pixel makes up half of it.
    let is_confirmed = |test: &AreaTest, critical: f64| {
        let [a, b] = &statistics[test.channel];
        if area(&test.area) > 1.0 {
            let largest = a
                .pixels_of(&test.area)
                .map(|i| (a.pixels[i][0] - b.pixels[i][0]).abs())
                .fold(0.0, f64::max);
            largest <= MAX_PIXEL_FRACTION * area(&test.area) * (test.means[0] - test.means[1]).abs()
        } else {
            let tile = &tiles[tile_of(&test.area)];
            let noisiest = [a, b].map(|side| {
                side.pixels_of(tile)
                    .map(|i| side.pixels[i][1])
                    .fold(0.0, f64::max)
            });
            test.sigmas.abs() * test.standard_error > critical * (noisiest[0] + noisiest[1]).sqrt()
        }
    };
    // Below its least normal number, a 16-bit float is rounded absolutely.
    let min_magnitude = if rules.rounding >= HALF_ROUNDING {
        MIN_NORMAL_HALF
    } else {
        0.0
    };
    let rounding_of = |[x, y]: [f64; 2]| rules.rounding * x.abs().max(y.abs()).max(min_magnitude);
    // Number of values of each side in pixels that differ and are not black, if neither side is
    // without error.
    let values_that_differ = |channel: usize, at: &Area| {
        let [a, b] = &statistics[channel];
        let differ = |i: &usize| {
            let [x, y] = [a, b].map(|side| side.pixels[*i][0]);
            x != 0.0 && y != 0.0 && (x - y).abs() > rounding_of([x, y])
        };
        let images = channels[channel].iter().map(Side::images);
        if images.clone().any(|images| images == u32::MAX) {
            return 0.0;
        }
        let pixels = a.pixels_of(at).filter(differ).count();
        images.min().map_or(0.0, f64::from) * pixels as f64
    };
    let test = |channel: usize, at: Area| {
        let [a, b] = area_statistics(channel, &at);
        let pixels = area(&at);
        // A pixel's images are too few to estimate skewness: use those of its tile.
        let tile = tile_of(&at);
        let (pool, of) = if pixels > 1.0 {
            ([a, b], pixels)
        } else {
            (of_tiles[channel][tile], area(&tiles[tile]))
        };
        let [of_a, of_b] =
            [0, 1].map(|side| statistics[channel][side].cumulants(&pool[side], of, pixels));
        let uncancelled = of_a[1].abs() + of_b[1].abs();
        // A bound cancels nothing of the other side.
        let bounded = channels[channel]
            .iter()
            .any(|side| matches!(side, Side::Errors(..)));
        let second = of_a[0] + of_b[0];
        let skewness = |third: f64| {
            if third == 0.0 || second == 0.0 {
                0.0
            } else {
                third / second.powf(1.5)
            }
        };
        let scale = if b.mean.abs() > DARK_FRACTION * overall[channel] {
            b.mean.abs()
        } else {
            overall[channel]
        };
        let scale = if scale > 0.0 { scale } else { 1.0 };
        let rounding = rounding_of([a.mean, b.mean]);
        let difference = a.mean - b.mean;
        let standard_error = (a.variance + b.variance).sqrt();
        let dof = match are_many(channel, &at) {
            true => satterthwaite([(of_a[0], a.dof), (of_b[0], b.dof)]),
            // Least possible degrees of freedom, whatever the sides' variances (Mickey and Brown
            // 1966).
            false => a.dof.min(b.dof),
        };
        let sigmas = (difference.abs() - rounding).max(0.0).copysign(difference) / standard_error;
        // Many values that are all the same are evidence against another mean.
        let values = channels[channel]
            .iter()
            .map(|side| side.images() as f64 * pixels)
            .fold(f64::INFINITY, f64::min);
        let noiseless = noiseless[channel];
        let is_constant = a.independent[0] + b.independent[0] == 0.0;
        let constants_differ = difference.abs() > rounding
            && (noiseless
                || values >= MIN_CONSTANT_VALUES as f64
                || is_constant && values_that_differ(channel, &at) >= MIN_NOISELESS_VALUES);
        AreaTest {
            area: at,
            channel,
            means: [a.mean, b.mean],
            scale,
            standard_error,
            dof,
            skewness: [
                if bounded {
                    uncancelled
                } else {
                    (of_a[1] - of_b[1]).abs()
                },
                uncancelled,
            ]
            .map(skewness),
            sigmas,
            p: match standard_error > 0.0 {
                true => student_two_sided(sigmas, dof),
                false => f64::from(!constants_differ),
            },
            noiseless,
            rounding: rounding / scale,
            judged: false,
            is_large: false,
        }
    };
    let fewest_dof = area_statistics(0, &[0, 0, 1, 1])
        .iter()
        .map(|part| part.dof)
        .fold(f64::INFINITY, f64::min);
    let kind = |name, grid, areas: &[Area]| {
        let count = areas.len();
        let level = rules.level / (4 * count * channels.len()) as f64;
        let critical = |dof: f64| student_upper(level / 2.0, dof.clamp(1.0, 1e9));
        // All pixels share the fewest degrees of freedom.
        let fewest = critical(fewest_dof);
        let judge = |test: AreaTest| {
            let critical = if test.dof == fewest_dof {
                fewest
            } else {
                critical(test.dof)
            };
            let term = |skewness, t| Sigma::Estimated.skew_term(skewness, deviation(t, test.dof));
            let [cancelled, uncancelled] = test.skewness;
            let valid = term(cancelled, critical) <= MAX_SKEW_TERM
                && term(uncancelled, critical) <= MAX_UNCANCELLED_SKEW_TERM;
            let t = LARGE_DIFFERENCE_FACTOR * critical;
            let is_large = test.sigmas.abs() > t
                && uncancelled <= MAX_LARGE_DIFFERENCE_SKEWNESS
                && are_many(test.channel, &test.area)
                && student_two_sided(t, test.dof) * (2.0 * term(uncancelled, t)).exp() < level;
            let exact = test.standard_error == 0.0;
            let confirmed = exact || test.p >= level || is_confirmed(&test, critical);
            AreaTest {
                judged: test.varies() && (valid || is_large || exact) && confirmed,
                is_large,
                ..test
            }
        };
        let all = (0..channels.len() * count).into_par_iter();
        let tests = all
            .map(|i| judge(test(i / count, areas[i % count])))
            .collect();
        let mut kind = AreaKind {
            name,
            grid,
            tests,
            level,
            is_counted: false,
        };
        let judged = kind.judged().count();
        kind.is_counted =
            judged > 0 && judged as f64 >= MIN_JUDGED_FRACTION * kind.varying() as f64;
        kind
    };
    let kinds = [
        kind("image mean", [1, 1], &[whole]),
        kind("region", [3, 3], &regions),
        kind("tile", tiles_across, &tiles),
        kind("pixel", size, &grid(size, [1, 1]).1),
    ];
    let rejected = || kinds.iter().flat_map(AreaKind::rejected);
    let verdict = if rejected().any(|test| !rules.single_sums || !test.may_be_single_sums()) {
        Verdict::Fails
    } else if rejected().next().is_some() {
        Verdict::Undecided { needed: u64::MAX }
    } else {
        images_needed(&kinds[0], rules.margin)
            .map_or(Verdict::Holds, |needed| Verdict::Undecided { needed })
    };
    let brightest = statistics
        .iter()
        .map(|sides| sides.each_ref().map(SideStatistics::brightest))
        .collect();
    Comparison {
        kinds,
        brightest,
        verdict,
    }
}

/// Returns the deviation of a difference in true standard errors if it is t estimated ones: √E(z² |
/// t), where normal noise has E(z² | t) = (ν + 1) t²/(ν + t²). With few degrees of freedom t is
/// large because its denominator is small rather than because values are far out, where skewness
/// bends the distribution.
fn deviation(t: f64, dof: f64) -> f64 {
    if dof.is_finite() {
        t * ((dof + 1.0) / (dof + t * t)).sqrt()
    } else {
        t
    }
}

/// Returns how many times as many images would let the image means be called equal, if these do
/// not.
fn images_needed(means: &AreaKind, margin: f64) -> Option<u64> {
    let level = means.level;
    let needed_for = |test: &AreaTest| {
        let [term, uncancelled] = test.skewness;
        let valid_from = Sigma::Estimated.valid_from(
            1,
            term.max(uncancelled * MAX_SKEW_TERM / MAX_UNCANCELLED_SKEW_TERM),
            level,
        );
        match equivalence_verdict(test.interval(level), 0.0, margin, 1) {
            Verdict::Holds if test.judged => None,
            Verdict::Undecided { needed } if test.judged => Some(needed.max(2)),
            _ => Some(valid_from),
        }
    };
    // Few values without noise are no evidence; if no channel has more, nothing can be decided.
    let varying: Vec<&AreaTest> = means.tests.iter().filter(|test| test.varies()).collect();
    if varying.is_empty() {
        Some(u64::MAX)
    } else {
        varying.into_iter().filter_map(needed_for).max()
    }
}
