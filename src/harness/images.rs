//! Two renderers on trial by images that they made independently: the image mean, regions, tiles and pixels, by
//! Welch's test under one level for all, with nothing assumed of how a pixel's values are distributed or how
//! neighbours are correlated but what the images show.
//!
//! A quarter of the level goes to each kind of place, and is divided among its places and channels (Bonferroni). A
//! place is judged where skewness leaves the tail of its test valid ([`Sigma::skew_term`]); a kind counts where at
//! least [`LEAST_SHARE`] of its places that vary are judged. What bends the tail of a difference is the difference of
//! the two sides' third cumulants: renderers whose noise is alike may be skewed more, up to [`LARGEST_ALIKE`]. However
//! skewed noise is, a difference that is [`FAR`] stands.
//!
//! In a channel without noise, where no pixel of either side varies in [`ENOUGH_WITHOUT_NOISE`] values or more, values are
//! compared as they stand: any difference beyond rounding is one. What images never show, such as light that is hit
//! once in many images, is not excluded by that.
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

use rayon::prelude::*;

use super::mean::{ENOUGH_EQUAL, LARGEST_SKEW_TERM, Sigma, satterthwaite};
use super::outcome::{Verdict, approximate_verdict};
use super::power::Sensitivity;
use super::tails::{normal_upper, student_two_sided, student_upper};

/// The least share of the places that vary that must be judged for their kind to count.
pub const LEAST_SHARE: f64 = 0.5;
/// The largest term of one side's skewness where the other's takes it away: four times as far as otherwise, for the
/// next terms of the expansion fall as the square.
pub const LARGEST_ALIKE: f64 = 4.0 * LARGEST_SKEW_TERM;
/// A difference of so many standard errors over the root of the level has a smaller chance than the level under any law,
/// by Chebyshev's inequality, even if the standard error were twice what it seems.
pub const FAR: f64 = 2.0;
/// The chance to miss a bias that "would have been seen".
pub const MISS: f64 = 0.1;
/// Where the second image is darker than this share of its mean, differences are relative to that mean.
pub const DARK: f64 = 1e-3;

/// The least number of values of each side, pixels times images, none of which varies, that are taken to have no noise.
/// Independent values of one law are all the same on either side, but differ between the sides, with a chance of at
/// most 4⁻ⁿ.
pub const ENOUGH_WITHOUT_NOISE: f64 = 64.0;

/// What is known of one renderer, in one channel: pixels row by row.
#[derive(Clone, Debug)]
pub enum Side<'a> {
    /// Independent images, at least two; three or more tell of their skewness.
    Images(Vec<&'a [f64]>),
    /// One image and its standard errors. Pixels are taken to be independent, with a skewness of the mean of at most
    /// 1, as of light that was met once, and one degree of freedom each.
    Errors(&'a [f64], &'a [f64]),
    /// A reference without error.
    Exact(&'a [f64]),
}

impl Side<'_> {
    fn images(&self) -> u32 {
        match self {
            Self::Images(images) => images.len() as u32,
            Self::Errors(..) => 1,
            Self::Exact(_) => u32::MAX,
        }
    }
}

/// Left, top, and the first column and row that are outside.
pub type Area = [usize; 4];

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
}

impl Default for Rules {
    fn default() -> Self {
        Self { level: 1e-3, margin: 0.01, tile: 16, regions: Vec::new(), rounding: 1e-5 }
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
    /// The skewness of the difference, and what it were if the sides' did not cancel; NaN if unknown.
    pub skewness: [f64; 2],
    /// The difference in standard errors, after what may be rounding.
    pub sigmas: f64,
    /// Two-sided, before Bonferroni; 1 where nothing varies, but 0 where [`ENOUGH_EQUAL`] constants differ, and where
    /// any values differ in a channel without noise.
    pub p: f64,
    /// Whether its channel has no noise on either side: see [`ENOUGH_WITHOUT_NOISE`].
    pub noiseless: bool,
    /// What may be rounding, relative.
    pub rounding: f64,
    /// Whether skewness leaves the tail at the level of its kind valid.
    pub judged: bool,
}

impl Place {
    /// The difference, relative.
    pub fn difference(&self) -> f64 {
        (self.means[0] - self.means[1]) / self.scale
    }

    /// The difference's interval at a two-sided level, relative.
    pub fn interval(&self, level: f64) -> [f64; 2] {
        let half = student_upper(level / 2.0, self.dof.clamp(1.0, 1e9)) * self.standard_error / self.scale;
        [-1.0, 1.0].map(|side| self.difference() + side * (half + self.rounding))
    }

    /// The smallest relative difference that would have been seen at a level, but for a chance of [`MISS`].
    pub fn seen(&self, level: f64) -> f64 {
        let sensitivity = Sensitivity::Normal { standard_error: self.standard_error, dof: self.dof, tests: 1 };
        sensitivity.smallest_effect_at(MISS, level) / self.scale + self.rounding
    }

    /// Whether it differs whatever the law of noise is: see [`FAR`].
    fn is_far(&self, level: f64) -> bool {
        self.standard_error > 0.0 && self.sigmas.abs() >= FAR / level.sqrt()
    }

    /// Whether it says anything: images show noise here, or nowhere in the channel, or two constants that differ beyond
    /// doubt.
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
        (self.counts || place.is_far(self.level)) && place.judged && place.p < self.level
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
    /// Fails if any place is rejected; holds if none is, and the image means are equal within the margin. If undecided,
    /// about how many times as many images would decide.
    pub verdict: Verdict,
}

/// The mean of one side over an area.
#[derive(Clone, Copy)]
struct Part {
    mean: f64,
    variance: f64,
    dof: f64,
    /// Variance and third cumulant of the mean if pixels were independent.
    independent: [f64; 2],
}

/// One side with what its pixels say.
struct Prepared<'a> {
    side: &'a Side<'a>,
    width: usize,
    /// Mean, and variance and third cumulant of the mean, of each pixel.
    pixels: Vec<[f64; 3]>,
    /// How many times the variance of a tile's mean is what it were if pixels were independent.
    correlation: f64,
}

impl<'a> Prepared<'a> {
    fn new(side: &'a Side<'a>, width: usize, tiles: &[Area]) -> Self {
        let pixels: Vec<[f64; 3]> = match side {
            Side::Images(images) => (0..images[0].len())
                .into_par_iter()
                .map(|i| {
                    let n = images.len() as f64;
                    let mean = mean_of(images.iter().map(|image| image[i]));
                    let power = |k: i32| images.iter().map(|image| (image[i] - mean).powi(k)).sum::<f64>();
                    // Unbiased estimates, divided by n and n²; with two images 0/0: nothing is known of skewness.
                    [mean, power(2) / (n - 1.0) / n, power(3) / ((n - 1.0) * (n - 2.0)) / n]
                })
                .collect(),
            Side::Errors(mean, errors) => mean.iter().zip(*errors).map(|(&m, &e)| [m, e * e, e.powi(3)]).collect(),
            Side::Exact(mean) => mean.iter().map(|&m| [m, 0.0, 0.0]).collect(),
        };
        let mut prepared = Self { side, width, pixels, correlation: 1.0 };
        if let Side::Images(_) = side {
            let sums = tiles.iter().map(|tile| (prepared.part(tile), area(tile).powi(2)));
            let (found, independent) =
                sums.fold((0.0, 0.0), |(f, i), (part, k)| (f + k * part.variance, i + k * part.independent[0]));
            // NaN, where nothing varies, becomes 1.
            prepared.correlation = (found / independent).max(1.0);
        }
        prepared
    }

    fn part(&self, &[x0, y0, x1, y1]: &Area) -> Part {
        let pixels = || (y0..y1).flat_map(move |y| y * self.width + x0..y * self.width + x1);
        let share = 1.0 / area(&[x0, y0, x1, y1]);
        let sum = |k: usize| pixels().map(|i| self.pixels[i][k]).sum::<f64>() * share.powi(1 + k as i32);
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
            Side::Errors(..) => (sum(0), independent[0], satterthwaite(pixels().map(|i| (self.pixels[i][1], 1.0)))),
            Side::Exact(_) => (sum(0), 0.0, f64::INFINITY),
        };
        Part { mean, variance, dof, independent }
    }

    /// Variance and third cumulant of the mean of `pixels` pixels as those of a part of `of` pixels.
    fn cumulants(&self, part: &Part, of: f64, pixels: f64) -> [f64; 2] {
        // A sum of few terms is as skewed as so many fewer independent ones.
        let together = if pixels > 1.0 { self.correlation } else { 1.0 };
        let more = of / pixels;
        let [second, third] = part.independent;
        [second * more * together, third * (more * together).powi(2)]
    }
}

/// The mean of some values, which is exact where all are the same.
fn mean_of(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let first = values.clone().next().unwrap_or(f64::NAN);
    first + values.clone().map(|value| value - first).sum::<f64>() / values.count() as f64
}

fn area([x0, y0, x1, y1]: &Area) -> f64 {
    ((x1 - x0) * (y1 - y0)) as f64
}

/// Equal parts of a frame, or parts of these sides.
fn grid([width, height]: [usize; 2], [w, h]: [usize; 2]) -> ([usize; 2], Vec<Area>) {
    let counts = [width.div_ceil(w), height.div_ceil(h)];
    let part = |i: usize| {
        let [x, y] = [i % counts[0] * w, i / counts[0] * h];
        [x, y, (x + w).min(width), (y + h).min(height)]
    };
    (counts, (0..counts[0] * counts[1]).map(part).collect())
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
    regions.extend(&rules.regions);
    let prepared: Vec<[Prepared; 2]> =
        channels.iter().map(|sides| sides.each_ref().map(|side| Prepared::new(side, width, &tiles))).collect();
    let noiseless: Vec<bool> = channels
        .iter()
        .zip(&prepared)
        .map(|(of, sides)| {
            let enough = of.iter().all(|side| f64::from(side.images()) * pixels as f64 >= ENOUGH_WITHOUT_NOISE);
            enough && sides.iter().all(|side| side.pixels.iter().all(|[_, variance, _]| *variance == 0.0))
        })
        .collect();
    let parts = |channel: usize, area: &Area| prepared[channel].each_ref().map(|side| side.part(area));
    let whole = [0, 0, size[0], size[1]];
    let overall: Vec<f64> = (0..channels.len()).map(|channel| parts(channel, &whole)[1].mean.abs()).collect();
    let of_tiles: Vec<Vec<[Part; 2]>> =
        (0..channels.len()).map(|channel| tiles.par_iter().map(|tile| parts(channel, tile)).collect()).collect();
    let place = |channel: usize, at: Area| {
        let [a, b] = parts(channel, &at);
        let pixels = area(&at);
        // A pixel's images are too few to tell of skewness: those of its tile do.
        let tile = at[1] / rules.tile * tiles_across[0] + at[0] / rules.tile;
        let (pool, of) = if pixels > 1.0 { ([a, b], pixels) } else { (of_tiles[channel][tile], area(&tiles[tile])) };
        let [of_a, of_b] = [0, 1].map(|side| prepared[channel][side].cumulants(&pool[side], of, pixels));
        let alike = of_a[1].abs() + of_b[1].abs();
        // A bound takes nothing away from the other side.
        let bounded = channels[channel].iter().any(|side| matches!(side, Side::Errors(..)));
        let second = of_a[0] + of_b[0];
        let skewness = |third: f64| if third == 0.0 || second == 0.0 { 0.0 } else { third / second.powf(1.5) };
        let scale = if b.mean.abs() > DARK * overall[channel] { b.mean.abs() } else { overall[channel] };
        let scale = if scale > 0.0 { scale } else { 1.0 };
        let rounding = rules.rounding * a.mean.abs().max(b.mean.abs());
        let difference = a.mean - b.mean;
        let standard_error = (a.variance + b.variance).sqrt();
        let dof = satterthwaite([a, b].map(|side| (side.variance, side.dof)));
        let sigmas = (difference.abs() - rounding).max(0.0).copysign(difference) / standard_error;
        // So many values that are all the same speak against another mean.
        let values = channels[channel].iter().map(|side| side.images() as f64 * pixels).fold(f64::INFINITY, f64::min);
        let noiseless = noiseless[channel];
        let constants_differ = difference.abs() > rounding && (noiseless || values >= ENOUGH_EQUAL as f64);
        Place {
            area: at,
            channel,
            means: [a.mean, b.mean],
            scale,
            standard_error,
            dof,
            skewness: [if bounded { alike } else { (of_a[1] - of_b[1]).abs() }, alike].map(skewness),
            sigmas,
            p: match standard_error > 0.0 {
                true => student_two_sided(sigmas, dof),
                false => f64::from(!constants_differ),
            },
            noiseless,
            rounding: rounding / scale,
            judged: false,
        }
    };
    let kind = |name, grid, areas: &[Area]| {
        let count = areas.len();
        let level = rules.level / (4 * count * channels.len()) as f64;
        let tail = normal_upper(level / 2.0);
        let judge = |place: Place| {
            let [term, alike] = place.skewness.map(|skewness| Sigma::Estimated.skew_term(skewness, tail));
            let valid = term <= LARGEST_SKEW_TERM && alike <= LARGEST_ALIKE;
            let valid = valid || place.standard_error == 0.0 || place.is_far(level);
            Place { judged: place.varies() && valid, ..place }
        };
        let all = (0..channels.len() * count).into_par_iter();
        let places = all.map(|i| judge(place(i / count, areas[i % count]))).collect();
        let mut kind = Kind { name, grid, places, level, counts: false };
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
    let verdict = if kinds.iter().any(|kind| kind.rejected().next().is_some()) {
        Verdict::Fails
    } else {
        lacking(&kinds[0], rules.margin).map_or(Verdict::Holds, |needed| Verdict::Undecided { needed })
    };
    Comparison { kinds, verdict }
}

/// How many times as many images let the image mean be called equal, if these do not.
fn lacking(means: &Kind, margin: f64) -> Option<u64> {
    let level = means.level;
    let lack = |place: &Place| {
        let [term, alike] = place.skewness;
        let valid_from = Sigma::Estimated.valid_from(1, term.max(alike * LARGEST_SKEW_TERM / LARGEST_ALIKE), level);
        match approximate_verdict(place.interval(level), 0.0, margin, 1) {
            Verdict::Holds if place.judged => None,
            Verdict::Undecided { needed } if place.judged => Some(needed.max(2)),
            _ => Some(valid_from),
        }
    };
    // Few values without noise say nothing; where all channels have no more, nothing is said at all.
    let varying: Vec<&Place> = means.places.iter().filter(|place| place.varies()).collect();
    if varying.is_empty() { Some(u64::MAX) } else { varying.into_iter().filter_map(lack).max() }
}
