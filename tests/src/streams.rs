//! Random-number streams: distinct values, gaps, and no correlation between neighbouring pixels,
//! samples and draws.

use whitefurnace::harness::chi_square::{CELL_DELTA, Counts, chi_square, poisson};
use whitefurnace::sampling::rng::stream;

use crate::prelude::*;

/// Returns a number of [0, 1) from (seed, pixel, sample, draw).
pub type Numbers = fn(u64, u32, u32, u32) -> f64;

const DISTINCT_STREAMS: u64 = 1_000_000;
const GAP_SAMPLES: u64 = 4_000_000;
const PAIRS: u64 = 7_700_000;
/// δ of correlations.
const CORRELATION_DELTA: f64 = 0.005;
/// Bits of a uniform number.
const BITS: i32 = 53;

/// Returns draw 0 or 1 of the program's stream of a pixel and a sample.
fn right(seed: u64, pixel: u32, sample: u32, draw: u32) -> f64 {
    let mut rng = stream(seed, pixel, sample);
    for _ in 0..draw {
        uniform(&mut rng);
    }
    uniform(&mut rng)
}

/// Number of random bits at which δ equal pairs would be expected.
const COARSE_BITS: i32 = 32;

/// Number of equal pairs that n numbers of `bits` random bits are expected to hold.
fn equal_pairs(n: u64, bits: i32) -> f64 {
    0.5 * (n as f64).powi(2) * 2f64.powi(-bits)
}

/// Tests that first numbers of different pixels are distinct.
pub fn distinct(context: &Context, numbers: Numbers) -> Vec<Outcome> {
    let seed = context.seed_of("distinct");
    let pixels = 0..context.n(DISTINCT_STREAMS);
    vec![collisions(pixels.map(|i| numbers(seed, i as u32, 0, 0)))]
}

/// Tests the number of equal pairs among n numbers: about n²/2⁵⁴ are expected, a Poisson count.
pub fn collisions(numbers: impl Iterator<Item = f64>) -> Outcome {
    let mut bits: Vec<u64> = numbers.map(f64::to_bits).collect();
    bits.sort_unstable();
    let n = bits.len() as u64;
    let equal = bits.windows(2).filter(|pair| pair[0] == pair[1]).count() as u64;
    poisson(
        "equal pairs",
        equal,
        n,
        equal_pairs(n, BITS),
        equal_pairs(n, COARSE_BITS),
    )
}

/// Tests the lengths of the gaps between visits of [0, 1/2) along the samples of a pixel: 0, 1, 2
/// or more with probabilities 1/2, 1/4, 1/8, 1/8.
pub fn gaps(context: &Context, numbers: Numbers) -> Vec<Outcome> {
    let seed = context.seed_of("gaps");
    let n = context.n(GAP_SAMPLES);
    let mut observed = vec![0; 4];
    let mut length = 0;
    let mut found = 0;
    // On average every second sample ends a gap; the bound is for generators that never end one.
    for sample in 0..u32::try_from(8 * n).unwrap_or(u32::MAX) {
        if numbers(seed, 7, sample, 0) >= 0.5 {
            length += 1;
        } else {
            observed[length.min(3)] += 1;
            (length, found) = (0, found + 1);
        }
        if found == n {
            break;
        }
    }
    let masses = vec![0.5, 0.25, 0.125, 0.125];
    let place = |length| format!("gap of {length}");
    vec![frequencies("gaps", masses, place, n, observed)]
}

/// Returns two neighbouring numbers.
type Neighbours = fn(Numbers, u64, u32) -> [f64; 2];

const NEIGHBOURS: [(&str, Neighbours); 3] = [
    ("pixels", |f, seed, i| {
        [f(seed, 2 * i, 0, 0), f(seed, 2 * i + 1, 0, 0)]
    }),
    ("samples", |f, seed, i| {
        [f(seed, 5, 2 * i, 0), f(seed, 5, 2 * i + 1, 0)]
    }),
    ("draws", |f, seed, i| [f(seed, i, 3, 0), f(seed, i, 3, 1)]),
];

/// Statistics of pairs of numbers that should be uniform over 4 × 4 cells of the unit square, and
/// uncorrelated (the values 12 (u − ½)(v − ½) have mean 0 and variance 1).
pub struct Pairs {
    partition: Partition,
    counts: Counts,
    products: Values,
}

impl Default for Pairs {
    fn default() -> Self {
        let partition = Partition::equal(Domain::Square, 4, 4);
        Self {
            counts: Counts {
                observed: vec![0; partition.masses.len()],
                ..Counts::default()
            },
            partition,
            products: Values::new(0.0),
        }
    }
}

impl Pairs {
    /// Adds a pair.
    pub fn push(&mut self, [u, v]: [f64; 2]) {
        self.counts.n += 1;
        match self.partition.cell(DVec3::new(u, v, 0.0)) {
            Some(cell) => self.counts.observed[cell] += 1,
            None => self.counts.forbidden += 1,
        }
        self.products.push(12.0 * (u - 0.5) * (v - 0.5));
    }

    /// Returns the tests of cells and correlation, for neighbours of this kind.
    pub fn outcomes(&self, name: &str) -> [Outcome; 2] {
        let claim = Claim::Equal {
            delta: CORRELATION_DELTA,
        };
        [
            chi_square(
                &format!("pairs of neighbouring {name}"),
                &self.partition,
                &self.counts,
                CELL_DELTA,
            ),
            mean(
                &format!("correlation of neighbouring {name}"),
                &self.products,
                0.0,
                claim,
            ),
        ]
    }
}

/// Tests counts of n events in numbered cells against these probabilities.
pub fn frequencies(
    name: &str,
    masses: Vec<f64>,
    place: impl Fn(usize) -> String,
    n: u64,
    observed: Vec<u64>,
) -> Outcome {
    let places = (0..masses.len()).map(place).collect();
    let partition = Partition::from_masses(masses, places);
    let counts = Counts {
        n,
        observed,
        ..Counts::default()
    };
    chi_square(name, &partition, &counts, CELL_DELTA)
}

/// Tests pairs of neighbouring pixels, samples and draws.
pub fn neighbours(context: &Context, numbers: Numbers) -> Vec<Outcome> {
    NEIGHBOURS
        .iter()
        .flat_map(|(name, pair)| {
            let seed = context.seed_of(name);
            let mut pairs = Pairs::default();
            (0..context.n(PAIRS)).for_each(|i| pairs.push(pair(numbers, seed, i as u32)));
            pairs.outcomes(name)
        })
        .collect()
}

/// Multiples of the golden ratio: uniform, distinct, and not random.
fn golden(seed: u64, pixel: u32, sample: u32, draw: u32) -> f64 {
    const RATIO: f64 = 0.618_033_988_749_894_9;
    let start = right(seed, 0, 0, draw);
    (start + RATIO * (f64::from(pixel) + f64::from(sample))).fract()
}

fn trials() -> Vec<FamilyTrial<Numbers>> {
    let family_trial =
        |name: &str, property: &str, consequence: &str, statistic, on: TrialFn<Numbers>| {
            let subject = "sampling::rng::stream, sampling::rng::uniform";
            trial(
                format!("streams/{name}"),
                property,
                consequence,
                &ESTIMATOR,
                subject,
                statistic,
                on,
            )
        };
    vec![
        family_trial(
            "distinct",
            "numbers of different pixels are distinct: 53 random bits",
            "random numbers are so coarse that small, far lamps are missed or hit too often",
            "Poisson",
            distinct,
        ),
        family_trial(
            "gaps",
            "gaps between visits of [0, 1/2) are geometric",
            "samples repeat, or are too even: the error bars of images are wrong",
            "chi-square",
            gaps,
        ),
        family_trial(
            "neighbours",
            "neighbouring pixels, samples and draws are independent",
            "neighbouring pixels or bounces share random numbers: noise forms patterns",
            "chi-square and t",
            neighbours,
        ),
    ]
}

fn faults() -> Vec<Fault<Numbers>> {
    vec![
        fault!("coarse", ESTIMATOR, "sixteen random bits",
            = |seed, pixel, sample, draw| (right(seed, pixel, sample, draw) * 65_536.0).floor() / 65_536.0,
            "streams/distinct"),
        fault!("golden", ESTIMATOR, "multiples of the golden ratio", = golden, "streams/gaps"),
        fault!("shared-samples", ESTIMATOR, "every second sample repeats the one before",
            = |seed, pixel, sample, draw| right(seed, pixel, sample / 2, draw),
            "streams/neighbours: pairs of neighbouring samples | correlation of neighbouring samples", "streams/gaps"),
        fault!("shared-pixels", ESTIMATOR, "neighbouring pixels share a stream",
            = |seed, pixel, sample, draw| right(seed, pixel / 2, sample, draw),
            "streams/neighbours: pairs of neighbouring pixels | correlation of neighbouring pixels"),
        fault!("shared-draws", ESTIMATOR, "the same number twice",
            = |seed, pixel, sample, _| right(seed, pixel, sample, 0),
            "streams/neighbours: pairs of neighbouring draws | correlation of neighbouring draws"),
    ]
}

/// Trials and faults of the random-number streams.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    vec![Box::new(Family {
        trials: trials(),
        faults: faults(),
        equivalents: vec![fault!("one-minus-r", ESTIMATOR, "1 − r for every number r",
            = |seed, pixel, sample, draw| 1.0 - right(seed, pixel, sample, draw), "streams/gaps")],
        ..Family::new("streams", right as Numbers)
    })]
}
