//! Two renderers on trial by images that they made independently: the image mean, regions, tiles
//! and pixels, by Welch's test under one level for all, with nothing assumed of how a pixel's
//! values are distributed or how neighbours are correlated but what the images show.
//!
//! A quarter of the level goes to each kind of place, and is divided among its places and channels
//! (Bonferroni). A place is judged where skewness leaves the tail of its test valid
//! ([`Sigma::skew_term`]); a kind counts where at least [`LEAST_SHARE`] of its places that vary are
//! judged. The difference of the two sides' third cumulants bends the tail of a difference:
//! renderers whose noise is alike may be skewed more, up to [`LARGEST_ALIKE`]. Beyond that, a
//! difference that is [`FAR`] stands.
//!
//! Standard errors are estimates, and enter no inequality that needs the true ones: with few
//! images, p comes from Student's law, whose degrees of freedom are found by the sides' shares of
//! the variance of many pixels ([`MANY`]), as those of few values can be far off where the sides
//! have different numbers of images.
//!
//! Nor does a difference stand on one pixel alone, whose values may be few: see
//! [`LARGEST_LONE_SHARE`], and pixels are held against the noisiest of their tile as well.
//!
//! All this holds as far as the images show their brightest paths. Noise that has not been seen has
//! no test: [`Comparison::brightest`] tells where a few values carry much of the noise
//! ([`LARGEST_BRIGHT_SHARE`]), so that rarer ones may be missing.
//!
//! In a channel without noise, where no pixel of either side varies in [`ENOUGH_WITHOUT_NOISE`]
//! values or more, values are compared as they stand: any difference beyond rounding is one. What
//! images never show, such as light that is hit once in many images, is not excluded by that.
//!
//! ```
//! use whitefurnace::harness::images::{Rules, Side, compare};
//! use whitefurnace::harness::outcome::Verdict;
//!
//! // Four images of 8 × 8 pixels of each renderer, in one channel.
//! let image = |seed: u32| (0..64).map(|i| f64::from((7 * i + seed) * 37 % 41)).collect::<Vec<f64>>();
//! let [a, b]: [Vec<Vec<f64>>; 2] = [0, 20].map(|seed| (seed..seed + 4).map(image).collect());
//! let [a, b] = [&a, &b].map(|images| Side::Images(images.iter().map(Vec::as_slice).collect()));
//! let found = compare(8, &[[a, b]], &Rules { margin: 0.5, ..Rules::default() });
//! assert_eq!(found.verdict, Verdict::Holds);
//! ```

mod side;

use rayon::prelude::*;

pub use side::{Area, Brightest, Side};

use super::mean::{ENOUGH_EQUAL, LARGEST_SKEW_TERM, Sigma, satterthwaite};
use super::outcome::{Verdict, approximate_verdict};
use super::power::smallest_effect_in_estimates;
use super::tails::{student_two_sided, student_upper};
use crate::image::read::HALF;
use side::{Part, Prepared, area, grid};

/// The least share of the places that vary that must be judged for their kind to count.
pub const LEAST_SHARE: f64 = 0.5;
/// The largest term of one side's skewness where the other's takes it away: four times as far as
/// otherwise, for the next terms of the expansion fall as the square.
pub const LARGEST_ALIKE: f64 = 4.0 * LARGEST_SKEW_TERM;
/// A difference of so many times the standard errors that its level needs stands in spite of
/// skewness, if the tail there, times what skewness may do to it twice over (the exponential of two
/// [`Sigma::skew_term`]s), is below the level.
pub const FAR: f64 = 2.0;
/// The largest skewness with which a large difference stands: as of 25 events that were seen, which
/// tell of the law.
pub const LARGEST_SKEWNESS: f64 = 0.2;
/// So many pixels that vary independently tell how variance and skewness are shared between the
/// sides.
pub const MANY: f64 = 64.0;
/// Where the brightest thousandth of the values carries more than this share of a side's variance,
/// there may be more that have not been seen: exponential noise has 5 %, noise whose variance is
/// barely finite (Pareto's law of index 2.5) and shadow rays to a lamp on the ceiling, at 4
/// samples, a quarter and more.
pub const LARGEST_BRIGHT_SHARE: f64 = 0.2;
/// The least normal 16-bit float: below it, rounding is absolute.
pub const LEAST_HALF: f64 = 1.0 / 16384.0;
/// How far a mean of 4096 samples may be off, relatively, if they are added one by one in single
/// precision: 4096·2⁻²⁴.
pub const SINGLE_SUMS: f64 = 1.0 / 4096.0;
/// The largest share of a part's difference that one pixel may have.
pub const LARGEST_LONE_SHARE: f64 = 0.5;
/// The chance to miss a bias that "would have been seen".
pub const MISS: f64 = 0.1;
/// Where the second image is darker than this share of its mean, differences are relative to that
/// mean.
pub const DARK: f64 = 1e-3;

/// The least number of values of each side, pixels times images, none of which varies, that are
/// taken to have no noise. Independent values of one law are all the same on either side, but
/// differ between the sides, with a chance of at most 4⁻ⁿ.
pub const ENOUGH_WITHOUT_NOISE: f64 = 64.0;

/// How images are judged.
#[derive(Clone, Debug)]
pub struct Rules {
    /// The chance that two right renderers are called different, at most.
    pub level: f64,
    /// How far image means may differ to be called equal, relative to the second's.
    pub margin: f64,
    /// The side of a tile, pixels.
    pub tile: usize,
    /// Regions to judge beside a grid of nine.
    pub regions: Vec<Area>,
    /// Differences below this share of the values are rounding.
    pub rounding: f64,
    /// Whether samples may have been added one by one in single precision: differences up to
    /// [`SINGLE_SUMS`] are then no evidence, and all that is found if there are no others is
    /// undecided.
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

/// One channel of a part of the images.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Where.
    pub area: Area,
    /// The number of the channel.
    pub channel: usize,
    /// Of the two sides.
    pub means: [f64; 2],
    /// What differences are relative to.
    pub scale: f64,
    /// Of the difference.
    pub standard_error: f64,
    /// Degrees of freedom of the standard error.
    pub dof: f64,
    /// The skewness of the difference, and what it were if the sides' did not cancel; NaN if
    /// unknown.
    pub skewness: [f64; 2],
    /// The difference in standard errors, after what may be rounding.
    pub sigmas: f64,
    /// Two-sided, before Bonferroni; 1 where nothing varies, but 0 where [`ENOUGH_EQUAL`] constants
    /// differ, and where any values differ in a channel without noise.
    pub p: f64,
    /// Whether its channel has no noise on either side: see [`ENOUGH_WITHOUT_NOISE`].
    pub noiseless: bool,
    /// What may be rounding, relative.
    pub rounding: f64,
    /// Whether skewness leaves the tail at the level of its kind valid, or the difference is far.
    pub judged: bool,
    /// Whether the difference is so large that it stands in spite of skewness: see [`FAR`].
    pub far: bool,
}

impl Place {
    /// The difference, relative.
    pub fn difference(&self) -> f64 {
        (self.means[0] - self.means[1]) / self.scale
    }

    /// The difference's interval at a two-sided level, relative.
    pub fn interval(&self, level: f64) -> [f64; 2] {
        let half =
            student_upper(level / 2.0, self.dof.clamp(1.0, 1e9)) * self.standard_error / self.scale;
        [-1.0, 1.0].map(|side| self.difference() + side * (half + self.rounding))
    }

    /// The smallest relative difference that would be seen at a level in other images like these,
    /// but for a chance of [`MISS`], on average over what the standard error is estimated to be.
    pub fn seen(&self, level: f64) -> f64 {
        let estimates = if self.standard_error > 0.0 {
            smallest_effect_in_estimates(self.dof, level, MISS)
        } else {
            0.0
        };
        estimates * self.standard_error / self.scale + self.rounding
    }

    /// Whether its difference, if any, is within [`SINGLE_SUMS`].
    pub fn may_be_single_sums(&self) -> bool {
        (self.means[0] - self.means[1]).abs()
            <= SINGLE_SUMS * self.means[0].abs().max(self.means[1].abs())
    }

    /// Whether it says anything: images show noise here, or nowhere in the channel, or two
    /// constants that differ beyond doubt.
    pub fn varies(&self) -> bool {
        self.standard_error > 0.0 || self.noiseless || self.p == 0.0
    }
}

/// Places of one kind, channel by channel.
#[derive(Clone, Debug)]
pub struct Kind {
    /// What they are.
    pub name: &'static str,
    /// Across and down, where they are a grid.
    pub grid: [usize; 2],
    /// All of them.
    pub places: Vec<Place>,
    /// The level of each.
    pub level: f64,
    /// Whether enough of those that vary are judged.
    pub counts: bool,
}

impl Kind {
    /// The places that are judged.
    pub fn judged(&self) -> impl Iterator<Item = &Place> {
        self.places.iter().filter(|place| place.judged)
    }

    /// How many vary.
    pub fn varying(&self) -> usize {
        self.places.iter().filter(|place| place.varies()).count()
    }

    /// Whether a place of it differs.
    pub fn rejects(&self, place: &Place) -> bool {
        (self.counts || place.far) && place.judged && place.p < self.level
    }

    /// What differs.
    pub fn rejected(&self) -> impl Iterator<Item = &Place> {
        self.places.iter().filter(|place| self.rejects(place))
    }
}

/// What was found: the image mean, regions, tiles and pixels.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// In this order.
    pub kinds: [Kind; 4],
    /// The brightest values of the two sides, channel by channel.
    pub brightest: Vec<[Brightest; 2]>,
    /// Fails if any place is rejected, by more than [`Rules::single_sums`] lets pass; holds if none
    /// is, and the image means are equal within the margin. If undecided, about how many times as
    /// many images would decide; `u64::MAX` if more of the same would not.
    pub verdict: Verdict,
}

/// Compares two sides, channel by channel, of frames of this `width`.
///
/// # Panics
/// If sides have different numbers of pixels, or a region is not within the frame.
pub fn compare(width: usize, channels: &[[Side; 2]], rules: &Rules) -> Comparison {
    let pixels = match &channels[0][0] {
        Side::Images(images) => images[0].len(),
        Side::Errors(mean, _) | Side::Exact(mean) => mean.len(),
    };
    let size = [width, pixels / width];
    let (tiles_across, tiles) = grid(size, [rules.tile; 2]);
    let (_, mut regions) = grid(size, size.map(|side| side.div_ceil(3)));
    let prepare = |side| Prepared::new(side, width, [&tiles, &regions]);
    let prepared: Vec<[Prepared; 2]> = channels
        .iter()
        .map(|sides| sides.each_ref().map(prepare))
        .collect();
    regions.extend(&rules.regions);
    let noiseless: Vec<bool> = channels
        .iter()
        .zip(&prepared)
        .map(|(of, sides)| {
            let enough = of
                .iter()
                .all(|side| f64::from(side.images()) * pixels as f64 >= ENOUGH_WITHOUT_NOISE);
            enough
                && sides
                    .iter()
                    .all(|side| side.pixels.iter().all(|[_, variance, _]| *variance == 0.0))
        })
        .collect();
    let parts =
        |channel: usize, area: &Area| prepared[channel].each_ref().map(|side| side.part(area));
    let whole = [0, 0, size[0], size[1]];
    let overall: Vec<f64> = (0..channels.len())
        .map(|channel| parts(channel, &whole)[1].mean.abs())
        .collect();
    let of_tiles: Vec<Vec<[Part; 2]>> = (0..channels.len())
        .map(|channel| tiles.par_iter().map(|tile| parts(channel, tile)).collect())
        .collect();
    // Whether so many pixels vary independently on both sides that they tell how their noise is
    // shared.
    let are_many = |channel: usize, at: &Area| {
        let correlation = prepared[channel].each_ref().map(|side| side.correlation);
        area(at) / correlation[0].max(correlation[1]) >= MANY
    };
    let tile_of = |at: &Area| at[1] / rules.tile * tiles_across[0] + at[0] / rules.tile;
    // Whether a difference that seems real is more than one pixel with few values, of which each
    // side happens to have met another one every time: of a pixel, by the noisiest of its tile; of
    // a part, if no pixel makes up half of it.
    let is_confirmed = |place: &Place, critical: f64| {
        let [a, b] = &prepared[place.channel];
        if area(&place.area) > 1.0 {
            let largest = a
                .pixels_of(&place.area)
                .map(|i| (a.pixels[i][0] - b.pixels[i][0]).abs())
                .fold(0.0, f64::max);
            largest
                <= LARGEST_LONE_SHARE * area(&place.area) * (place.means[0] - place.means[1]).abs()
        } else {
            let tile = &tiles[tile_of(&place.area)];
            let noisiest = [a, b].map(|side| {
                side.pixels_of(tile)
                    .map(|i| side.pixels[i][1])
                    .fold(0.0, f64::max)
            });
            place.sigmas.abs() * place.standard_error
                > critical * (noisiest[0] + noisiest[1]).sqrt()
        }
    };
    let place = |channel: usize, at: Area| {
        let [a, b] = parts(channel, &at);
        let pixels = area(&at);
        // A pixel's images are too few to tell of skewness: those of its tile do.
        let tile = tile_of(&at);
        let (pool, of) = if pixels > 1.0 {
            ([a, b], pixels)
        } else {
            (of_tiles[channel][tile], area(&tiles[tile]))
        };
        let [of_a, of_b] =
            [0, 1].map(|side| prepared[channel][side].cumulants(&pool[side], of, pixels));
        let alike = of_a[1].abs() + of_b[1].abs();
        // A bound takes nothing away from the other side.
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
        let scale = if b.mean.abs() > DARK * overall[channel] {
            b.mean.abs()
        } else {
            overall[channel]
        };
        let scale = if scale > 0.0 { scale } else { 1.0 };
        // Below its least normal number, a 16-bit float is rounded absolutely.
        let least = if rules.rounding >= HALF {
            LEAST_HALF
        } else {
            0.0
        };
        let rounding = rules.rounding * a.mean.abs().max(b.mean.abs()).max(least);
        let difference = a.mean - b.mean;
        let standard_error = (a.variance + b.variance).sqrt();
        let dof = match are_many(channel, &at) {
            true => satterthwaite([(of_a[0], a.dof), (of_b[0], b.dof)]),
            // At least so many, whatever the shares of the sides (Mickey and Brown 1966).
            false => a.dof.min(b.dof),
        };
        let sigmas = (difference.abs() - rounding).max(0.0).copysign(difference) / standard_error;
        // So many values that are all the same speak against another mean.
        let values = channels[channel]
            .iter()
            .map(|side| side.images() as f64 * pixels)
            .fold(f64::INFINITY, f64::min);
        let noiseless = noiseless[channel];
        let constants_differ =
            difference.abs() > rounding && (noiseless || values >= ENOUGH_EQUAL as f64);
        Place {
            area: at,
            channel,
            means: [a.mean, b.mean],
            scale,
            standard_error,
            dof,
            skewness: [
                if bounded {
                    alike
                } else {
                    (of_a[1] - of_b[1]).abs()
                },
                alike,
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
            far: false,
        }
    };
    let fewest_dof = parts(0, &[0, 0, 1, 1])
        .iter()
        .map(|part| part.dof)
        .fold(f64::INFINITY, f64::min);
    let kind = |name, grid, areas: &[Area]| {
        let count = areas.len();
        let level = rules.level / (4 * count * channels.len()) as f64;
        let critical = |dof: f64| student_upper(level / 2.0, dof.clamp(1.0, 1e9));
        // Pixels have the fewest degrees of freedom, all the same.
        let fewest = critical(fewest_dof);
        let judge = |place: Place| {
            let critical = if place.dof == fewest_dof {
                fewest
            } else {
                critical(place.dof)
            };
            let term = |skewness, t| Sigma::Estimated.skew_term(skewness, deviation(t, place.dof));
            let [cancelled, alike] = place.skewness;
            let valid = term(cancelled, critical) <= LARGEST_SKEW_TERM
                && term(alike, critical) <= LARGEST_ALIKE;
            let t = FAR * critical;
            let far = place.sigmas.abs() > t
                && alike <= LARGEST_SKEWNESS
                && are_many(place.channel, &place.area)
                && student_two_sided(t, place.dof) * (2.0 * term(alike, t)).exp() < level;
            let exact = place.standard_error == 0.0;
            let confirmed = exact || place.p >= level || is_confirmed(&place, critical);
            Place {
                judged: place.varies() && (valid || far || exact) && confirmed,
                far,
                ..place
            }
        };
        let all = (0..channels.len() * count).into_par_iter();
        let places = all
            .map(|i| judge(place(i / count, areas[i % count])))
            .collect();
        let mut kind = Kind {
            name,
            grid,
            places,
            level,
            counts: false,
        };
        let judged = kind.judged().count();
        kind.counts = judged > 0 && judged as f64 >= LEAST_SHARE * kind.varying() as f64;
        kind
    };
    let kinds = [
        kind("image mean", [1, 1], &[whole]),
        kind("region", [3, 3], &regions),
        kind("tile", tiles_across, &tiles),
        kind("pixel", size, &grid(size, [1, 1]).1),
    ];
    let rejected = || kinds.iter().flat_map(Kind::rejected);
    let verdict = if rejected().any(|place| !rules.single_sums || !place.may_be_single_sums()) {
        Verdict::Fails
    } else if rejected().next().is_some() {
        Verdict::Undecided { needed: u64::MAX }
    } else {
        lacking(&kinds[0], rules.margin)
            .map_or(Verdict::Holds, |needed| Verdict::Undecided { needed })
    };
    let brightest = prepared
        .iter()
        .map(|sides| sides.each_ref().map(Prepared::brightest))
        .collect();
    Comparison {
        kinds,
        brightest,
        verdict,
    }
}

/// How many true standard errors a difference is off that is t estimated ones: √E(z² | t), where
/// normal noise has E(z² | t) = (ν + 1) t²/(ν + t²). With few degrees of freedom t is large for its
/// small denominator more than for values far out, where skewness bends the law.
fn deviation(t: f64, dof: f64) -> f64 {
    if dof.is_finite() {
        t * ((dof + 1.0) / (dof + t * t)).sqrt()
    } else {
        t
    }
}

/// How many times as many images let the image mean be called equal, if these do not.
fn lacking(means: &Kind, margin: f64) -> Option<u64> {
    let level = means.level;
    let lack = |place: &Place| {
        let [term, alike] = place.skewness;
        let valid_from = Sigma::Estimated.valid_from(
            1,
            term.max(alike * LARGEST_SKEW_TERM / LARGEST_ALIKE),
            level,
        );
        match approximate_verdict(place.interval(level), 0.0, margin, 1) {
            Verdict::Holds if place.judged => None,
            Verdict::Undecided { needed } if place.judged => Some(needed.max(2)),
            _ => Some(valid_from),
        }
    };
    // Few values without noise say nothing; where all channels have no more, nothing is said at
    // all.
    let varying: Vec<&Place> = means.places.iter().filter(|place| place.varies()).collect();
    if varying.is_empty() {
        Some(u64::MAX)
    } else {
        varying.into_iter().filter_map(lack).max()
    }
}
