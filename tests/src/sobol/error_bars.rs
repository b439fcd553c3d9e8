//! Error bars of means of Sobol' points: of the right size, and right as often as they say.

use whitefurnace::harness::convergence::variance_ratio;
use whitefurnace::harness::ks::kolmogorov_smirnov;
use whitefurnace::sampling::rng::seed_for;

use super::*;

/// Images in the trial of error bars. Squared errors vary more than squared error bars, so they
/// take four fifths.
const IMAGES: u64 = 265_000;
/// Scrambles of one image's pixel.
const REPLICATIONS: u32 = 8;
/// Points of each scramble.
const POINTS_PER_SCRAMBLE: u32 = 4;
/// Relative δ of the ratio.
const BAR_DELTA: f64 = 0.05;

/// Coverage of a pixel by the half-plane y − ½ < 0.37 (x − ½): ½ by symmetry.
fn covered([x, y]: [f64; 2]) -> f64 {
    f64::from(u8::from(y - 0.5 < 0.37 * (x - 0.5)))
}

/// Compares the mean squared error of a pixel's mean with the mean of its squared error bar: their
/// ratio is 1.
pub(super) fn error_bars(context: &Context, subject: SobolParts) -> Vec<Outcome> {
    let n = context.n(IMAGES);
    let rows = |part: &str, image: u64| -> Vec<Vec<f64>> {
        let seed = seed_for(context.seed_of(part), &image.to_string());
        let sample = |replication, index| {
            let point = Point {
                seed,
                pixel: 0,
                replication,
                index,
            };
            covered(uniform2(&mut Scripted(SampleStream::new(subject, point))))
        };
        (0..REPLICATIONS)
            .map(|replication| {
                (0..POINTS_PER_SCRAMBLE)
                    .map(|i| sample(replication, i))
                    .collect()
            })
            .collect()
    };
    let expected = 1e-3; // near which cubes are summed
    let squares = |part: &str, n: u64, of: &dyn Fn(&[Vec<f64>]) -> f64| {
        let mut images = 0..n;
        Values::collect(expected, n, || of(&rows(part, images.next().unwrap_or(n))))
    };
    let error = |rows: &[Vec<f64>]| {
        let sum: f64 = rows.iter().flatten().sum();
        (sum / f64::from(REPLICATIONS * POINTS_PER_SCRAMBLE) - 0.5).powi(2)
    };
    let errors = squares("errors", n - n / 5, &error);
    let bars = squares("bars", n / 5, &subject.squared_error);
    vec![variance_ratio(
        "squared error over squared error bar",
        &errors,
        &bars,
        1.0,
        BAR_DELTA,
    )]
}

/// Pixels whose intervals are tested.
const PIXELS: u64 = 70_000;
/// δ of Kolmogorov's distance.
const COVERAGE_DELTA: f64 = 0.025;
/// Scrambles of each pixel, as many as `render` makes.
const PIXEL_SCRAMBLES: u32 = 4;
/// Points of each of those scrambles.
const PIXEL_POINTS: u32 = 8;
/// Blocks of numbers that are summed.
const BLOCKS: [u32; 2] = [0, 1];

/// Tests that Student's intervals from four scrambles hold the mean as often as they say, at every
/// level: their p-values are uniform. The integrand is the sum of all numbers of two blocks, so
/// many terms that its means are normal, as the interval assumes.
pub(super) fn coverage(context: &Context, subject: SobolParts) -> Vec<Outcome> {
    let seed = context.seed_of("coverage");
    let known = 0.5 * f64::from(BLOCK) * BLOCKS.len() as f64;
    let sample = |pixel, replication, index| -> f64 {
        let point = Point {
            seed,
            pixel,
            replication,
            index,
        };
        BLOCKS
            .iter()
            .flat_map(|&block| (subject.numbers)(point, block))
            .sum()
    };
    let p_value = |pixel| {
        let row = |replication| {
            (0..PIXEL_POINTS)
                .map(|i| sample(pixel, replication, i))
                .collect()
        };
        let rows: Vec<Vec<f64>> = (0..PIXEL_SCRAMBLES).map(row).collect();
        let mean = rows.iter().flatten().sum::<f64>() / f64::from(PIXEL_SCRAMBLES * PIXEL_POINTS);
        (subject.p)(
            (mean - known) / (subject.squared_error)(&rows).sqrt(),
            PIXEL_SCRAMBLES,
        )
    };
    let mut values: Vec<f64> = (0..context.n(PIXELS) as u32).map(p_value).collect();
    vec![kolmogorov_smirnov(
        "p-values",
        &mut values,
        |p| p,
        COVERAGE_DELTA,
    )]
}
