//! Low-discrepancy numbers: each coordinate is uniform, a scramble is stratified, blocks, pixels
//! and scrambles are independent, estimates are unbiased, and error bars come from scrambles, of
//! which a few are enough.

mod error_bars;
mod faults;

use whitefurnace::harness::tails::student_two_sided;
use whitefurnace::math::moments::Moments;
use whitefurnace::sampling::rng::stream;
use whitefurnace::sampling::sampler::{BLOCK, FIRST_LIGHT_BLOCK, Sampler, Sobol, scramble};

use crate::irradiance::reflected;
use crate::prelude::*;
use crate::scenes::{RECTANGLE, mean_channel, polygon_irradiance, ray_to_origin, rectangle_light};
use crate::script::{Script, Scripted};
use crate::streams::frequencies;

/// Numbers of a block.
type Block = [f64; BLOCK as usize];

/// A point: master seed, pixel, replication (scramble), index in the scramble.
#[derive(Clone, Copy)]
pub struct Point {
    seed: u64,
    pixel: u32,
    replication: u32,
    index: u32,
}

/// Low-discrepancy numbers and the error bar of their means, so that each can be replaced.
#[derive(Clone, Copy)]
pub struct SobolParts {
    /// Returns the numbers of a block of a point.
    numbers: fn(Point, u32) -> Block,
    /// Returns the squared error bar of the mean of all samples, given in a row for each
    /// replication.
    squared_error: fn(&[Vec<f64>]) -> f64,
    /// Returns the p-value of an error, in error bars, from the number of replications.
    p: fn(f64, u32) -> f64,
}

/// Returns the program's numbers: those of [`Sobol`] with a scramble for each pixel and
/// replication.
fn sobol(point: Point, block: u32) -> Block {
    let Point {
        seed,
        pixel,
        replication,
        index,
    } = point;
    let scramble = scramble(seed, pixel, replication);
    scrambled(
        point,
        block,
        scramble,
        stream(seed, pixel, replication ^ index << 16),
    )
}

fn scrambled(point: Point, block: u32, scramble: u64, fill: Stream) -> Block {
    let mut points = Sobol::new(point.index as u16, scramble, fill);
    points.block(block);
    std::array::from_fn(|_| uniform(&mut points))
}

const CORRECT: SobolParts = SobolParts {
    numbers: sobol,
    // The mean of each scramble is one value.
    squared_error: |rows| {
        let means = rows
            .iter()
            .map(|row| row.iter().sum::<f64>() / row.len() as f64);
        let moments: Moments = means.collect();
        moments.variance() / rows.len() as f64
    },
    p: |error, replications| student_two_sided(error, f64::from(replications - 1)),
};

/// A sampler's source of a subject's numbers, as an estimator takes them.
struct SampleStream {
    subject: SobolParts,
    point: Point,
    block: u32,
    numbers: Block,
    used: usize,
}

impl SampleStream {
    fn new(subject: SobolParts, point: Point) -> Self {
        Self {
            subject,
            point,
            block: 0,
            numbers: (subject.numbers)(point, 0),
            used: 0,
        }
    }
}

impl Script for SampleStream {
    fn block(&mut self, block: u32) {
        self.block = block;
        self.numbers = (self.subject.numbers)(self.point, block);
        self.used = 0;
    }
    fn number(&mut self) -> f64 {
        if self.used == self.numbers.len() {
            self.block(self.block + 1);
        }
        self.used += 1;
        self.numbers[self.used - 1]
    }
}

const UNIFORM: u64 = 3_200_000;
const CELLS: usize = 8;

/// Tests the cells of each coordinate, and of the bits below its 23 leading ones, over scrambles:
/// one point of each, because the points of one scramble are not independent.
fn uniformity(context: &Context, subject: SobolParts) -> Vec<Outcome> {
    let seed = context.seed_of("uniform");
    let n = context.n(UNIFORM);
    let mut observed = vec![vec![0; CELLS]; BLOCK as usize + 1];
    let cell = |u: f64| (u * CELLS as f64) as usize;
    for replication in 0..n as u32 {
        // The index takes every value; each scramble is used once.
        let point = Point {
            seed,
            pixel: 0,
            replication,
            index: replication % 1024,
        };
        let numbers = (subject.numbers)(point, 1);
        for (counts, &u) in observed.iter_mut().zip(&numbers) {
            counts[cell(u)] += 1;
        }
        observed[BLOCK as usize][cell((numbers[0] * f64::from(1 << 23)).fract())] += 1;
    }
    let named = |i: usize| match i {
        8 => "low bits".to_owned(),
        i => format!("coordinate {i}"),
    };
    let outcome = |(i, observed)| {
        let (masses, place) = (vec![1.0 / CELLS as f64; CELLS], |k| format!("{k}/{CELLS}"));
        frequencies(&named(i), masses, place, n, observed)
    };
    observed.into_iter().enumerate().map(outcome).collect()
}

const LARGEST_POWER: u32 = 10;

/// Tests that every elementary interval of area 2⁻ᵐ holds exactly one of the first 2ᵐ points of a
/// scramble, in the first two coordinates, and every interval of length 2⁻ᵐ one, in each
/// coordinate. m = 1 to 10.
fn stratification(context: &Context, subject: SobolParts) -> Vec<Outcome> {
    let seed = context.seed_of("stratified");
    let (mut two, mut one) = ((0, String::from("none")), (0, String::from("none")));
    let mut checked = 0;
    let mut see = |most: &mut (usize, String), empty, place: String| {
        checked += 1;
        if empty > most.0 {
            *most = (empty, place);
        }
    };
    for (replication, block) in [
        (0, 0),
        (1, 1),
        (2, 7),
        (3, FIRST_LIGHT_BLOCK),
        (4, FIRST_LIGHT_BLOCK + 3),
    ] {
        let point = |index| Point {
            seed,
            pixel: 5,
            replication,
            index,
        };
        let points: Vec<Block> = (0..1 << LARGEST_POWER)
            .map(|index| (subject.numbers)(point(index), block))
            .collect();
        for m in 1..=LARGEST_POWER {
            let first = &points[..1 << m];
            for split in 0..=m {
                let cell = |p: &Block| {
                    let [a, b] = [(p[0], split), (p[1], m - split)]
                        .map(|(u, bits)| (u * f64::from(1u32 << bits)) as usize);
                    (a << (m - split)) + b
                };
                see(
                    &mut two,
                    empty_cells(first, cell),
                    format!("block {block}, 2^{m} points, 2^-{split} wide"),
                );
            }
            for d in 0..BLOCK as usize {
                let empty = empty_cells(first, |p| (p[d] * f64::from(1u32 << m)) as usize);
                see(
                    &mut one,
                    empty,
                    format!("block {block}, 2^{m} points, coordinate {d}"),
                );
            }
        }
    }
    let exact = |name: &str, (empty, worst): (usize, String)| {
        let worst = format!("most empty intervals: {worst}");
        Outcome::identity(name, checked, empty as f64, 0.0, worst)
    };
    vec![
        exact("elementary intervals", two),
        exact("intervals of one coordinate", one),
    ]
}

/// Counts the empty cells among as many as there are points.
fn empty_cells(points: &[Block], cell: impl Fn(&Block) -> usize) -> usize {
    let mut taken = vec![false; points.len()];
    points.iter().for_each(|p| taken[cell(p)] = true);
    taken.iter().filter(|taken| !**taken).count()
}

const PAIRS: u64 = 6_200_000;
/// δ of correlations.
const CORRELATION_DELTA: f64 = 0.005;

/// Tests that a coordinate is uncorrelated with the same one of the next block, pixel and scramble,
/// and with the next coordinate; one point of each scramble.
fn independence(context: &Context, subject: SobolParts) -> Vec<Outcome> {
    let seed = context.seed_of("independent");
    let centred = |u: f64| 12f64.sqrt() * (u - 0.5);
    let about = [
        "next block",
        "next pixel",
        "next scramble",
        "next coordinate",
    ]
    .map(|next| (format!("correlation, {next}"), 0.0, CORRELATION_DELTA));
    let mut replication = 0;
    means(about, context.n(PAIRS), || {
        let point = Point {
            seed,
            pixel: 2,
            replication: 2 * replication,
            index: replication % 512,
        };
        let here = (subject.numbers)(point, 1);
        let next_pixel = Point { pixel: 3, ..point };
        let next_scramble = Point {
            replication: 2 * replication + 1,
            ..point
        };
        replication += 1;
        let others = [
            (subject.numbers)(point, 2)[0],
            (subject.numbers)(next_pixel, 1)[0],
            (subject.numbers)(next_scramble, 1)[0],
            here[1],
        ];
        others.map(|other| centred(here[0]) * centred(other))
    })
}

/// Scrambles in the estimate's mean, and points of each.
const SCRAMBLES: u64 = 12_000;
const POINTS: u32 = 16;
/// Relative δ of the mean.
const MEAN_DELTA: f64 = 0.003;

/// Returns the mean of estimates by these points.
fn estimate(scene: &Scene, subject: SobolParts, points: impl Iterator<Item = Point>) -> f64 {
    let path = Path::new(Strategy::Light);
    let (mut sum, mut count) = (0.0, 0.0);
    for point in points {
        let mut rng = Scripted(SampleStream::new(subject, point));
        let radiance = path.radiance(scene, &ray_to_origin(), None, &mut rng);
        sum += mean_channel(scene, radiance);
        count += 1.0;
    }
    sum / count
}

/// Compares the mean of a path tracer's estimates over scrambles with the closed form of the
/// irradiance.
fn unbiased(context: &Context, subject: SobolParts) -> Vec<Outcome> {
    let seed = context.seed_of("mean");
    let scene = rectangle_light(false);
    let reference = reflected(polygon_irradiance(&RECTANGLE));
    let mut replication = 0;
    vec![mean_of(
        "radiance over scrambles",
        reference,
        MEAN_DELTA,
        context.n(SCRAMBLES),
        || {
            let point = |index| Point {
                seed,
                pixel: 1,
                replication,
                index,
            };
            let mean = estimate(&scene, subject, (0..POINTS).map(point));
            replication += 1;
            mean
        },
    )]
}

/// Returns a trial of the Sobol' sampler.
fn family_trial<S: 'static>(
    name: &str,
    property: &str,
    consequence: &str,
    statistic: &'static str,
    on: TrialFn<S>,
) -> FamilyTrial<S> {
    trial(
        format!("sampler/{name}"),
        property,
        consequence,
        &SOBOL,
        "sampling::sampler::Sobol, sampling::sampler::scramble",
        statistic,
        on,
    )
}

fn trials() -> Vec<FamilyTrial<SobolParts>> {
    vec![
        family_trial(
            "uniform",
            "over scrambles each coordinate is uniform, in its lower bits, too",
            "parts of lamps and of the sky are never sampled: images are biased",
            "chi-square",
            uniformity,
        ),
        family_trial(
            "stratified",
            "each elementary interval holds one of the first 2^m points of a scramble",
            "Sobol' points leave as much noise as random ones",
            "exact",
            stratification,
        ),
        family_trial(
            "independent",
            "blocks, pixels, scrambles and coordinates are uncorrelated",
            "images show a pattern over their pixels, as in mmp/pbrt-v3#236",
            "t",
            independence,
        ),
        family_trial(
            "mean",
            "the mean of 16 Sobol' points is unbiased through a path tracer",
            "renders by Sobol' points settle on a wrong brightness",
            "t",
            unbiased,
        ),
    ]
}

/// Trials and faults of low-discrepancy numbers.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    vec![
        Box::new(Family {
            trials: trials(),
            faults: faults::of_numbers(),
            ..Family::new("sobol", CORRECT)
        }),
        Box::new(Family {
            trials: vec![
                family_trial(
                    "error-bars",
                    "the variance over scrambles gives the error of their mean",
                    "error bars of images by Sobol' points are far too wide or too narrow",
                    "variance ratio",
                    error_bars::error_bars,
                ),
                family_trial(
                    "coverage",
                    "Student's intervals from four scrambles err as often as they say",
                    "the stated interval of a pixel misses the truth more often than it says",
                    "Kolmogorov-Smirnov",
                    error_bars::coverage,
                ),
            ],
            faults: faults::of_error_bars(),
            ..Family::new("sobol error bars", CORRECT)
        }),
    ]
}
