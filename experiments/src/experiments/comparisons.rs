//! Error rates of `compare`: random images with many noise distributions, from two to sixteen a
//! side.

use std::f64::consts::TAU;

use whitefurnace::harness::images::{Rules, Side, compare};
use whitefurnace::harness::tails::{binomial_interval, binomial_sf};

use crate::experiments::prelude::*;

pub(super) const COMPARISONS: Experiment = Experiment {
    id: "comparisons",
    title: "error rates of compare, over numbers of images and laws of noise",
    headline: "false alarms of compare at a level of {all.level %.0%}: at most {worst.alarms %.1%} in any of {all.cells %d} cells of {all.runs %d} runs",
    version: 1,
    equations: &[],
    run,
};

/// Width and height of the images.
const SIDE: usize = 24;
/// Numbers of images of the two sides.
const NUMBERS: [[usize; 2]; 7] = [[2, 2], [3, 3], [4, 4], [8, 8], [16, 16], [3, 16], [16, 4]];
/// Samples of a pixel that are added in single precision.
const SAMPLES: u32 = 4096;
/// Level at which the images are judged: the default of `compare` is finer, and would need more
/// runs.
const LEVEL: f64 = 0.01;
/// Brightness of the first side in runs where a difference should be found.
const BRIGHTER: [(f64, &str); 2] = [(1.1, "tenth"), (2.0, "twice")];

/// An image, row by row.
type Image = Vec<f64>;

/// A distribution of images of mean 1 on either side.
struct NoiseModel {
    key: &'static str,
    what: &'static str,
    /// Draws an image of a side.
    draw: fn(&mut Stream, usize) -> Image,
    rounding: f64,
}

fn exponential(rng: &mut Stream) -> f64 {
    -(1.0 - uniform(rng)).ln()
}

fn normal(rng: &mut Stream) -> f64 {
    let [u, v] = uniform2(rng);
    (-2.0 * (1.0 - u).ln()).sqrt() * (TAU * v).cos()
}

/// Returns 1 with probability `chance`, else 0.
fn bernoulli(rng: &mut Stream, chance: f64) -> f64 {
    f64::from(u8::from(uniform(rng) < chance))
}

/// Draws independent pixels, by column and row.
fn each(rng: &mut Stream, value: impl Fn(&mut Stream, usize, usize) -> f64) -> Image {
    (0..SIDE * SIDE)
        .map(|i| value(rng, i % SIDE, i / SIDE))
        .collect()
}

/// Draws from a Pareto distribution with this index and mean 1.
fn pareto(rng: &mut Stream, index: f64) -> f64 {
    (1.0 - uniform(rng)).powf(-1.0 / index) * (index - 1.0) / index
}

/// Draws an image of box means over 5 × 5 independent values, as from a wide filter or photons.
fn blurred(rng: &mut Stream) -> Image {
    let plain = each(rng, |rng, _, _| exponential(rng));
    let at = |x: usize, y: usize| plain[y % SIDE * SIDE + x % SIDE];
    let mean = |i: usize| {
        (0..25)
            .map(|k| at(i % SIDE + k % 5, i / SIDE + k / 5))
            .sum::<f64>()
            / 25.0
    };
    (0..SIDE * SIDE).map(mean).collect()
}

/// Draws means of few distinct samples near 1, added one by one; the first side adds in single
/// precision.
fn sums(rng: &mut Stream, side: usize) -> Image {
    each(rng, |rng, _, _| {
        let (mut single, mut double) = (0.0_f32, 0.0);
        let first = 0.999 + 0.001 * uniform(rng);
        for _ in 0..SAMPLES / 16 {
            // Sixteen equal samples: random numbers take most of the time.
            let sample = (first + 0.001 * uniform(rng)) as f32;
            for _ in 0..16 {
                single += sample;
                double += f64::from(sample);
            }
        }
        if side == 0 {
            f64::from(single / SAMPLES as f32)
        } else {
            double / f64::from(SAMPLES)
        }
    })
}

/// Rounds a value of normal size to the nearest 16-bit float.
fn half(value: f64) -> f64 {
    let unit = (value.log2().floor() - 10.0).exp2();
    (value / unit).round() * unit
}

/// Returns a distribution of images that are rounded to 32-bit floats.
const fn noise(
    key: &'static str,
    what: &'static str,
    draw: fn(&mut Stream, usize) -> Image,
) -> NoiseModel {
    NoiseModel {
        key,
        what,
        draw,
        rounding: 1e-5,
    }
}

const NOISE_MODELS: [NoiseModel; 14] = [
    noise("normal", "normal", |rng, _| {
        each(rng, |rng, _, _| 1.0 + 0.1 * normal(rng))
    }),
    noise("exponential", "exponential", |rng, _| {
        each(rng, |rng, _, _| exponential(rng))
    }),
    noise(
        "unlike",
        "exponential, and on the second side a tenth of it",
        |rng, side| {
            each(rng, |rng, _, _| {
                if side == 0 {
                    exponential(rng)
                } else {
                    0.9 + 0.1 * exponential(rng)
                }
            })
        },
    ),
    noise(
        "bright",
        "ten pixels of an image ten times as bright",
        |rng, _| {
            each(rng, |rng, _, _| {
                0.1 * exponential(rng) + 0.9 + 10.0 * (bernoulli(rng, 0.0174) - 0.0174)
            })
        },
    ),
    noise("rare", "one such pixel in three images", |rng, _| {
        each(rng, |rng, _, _| {
            1.0 + 0.1 * normal(rng) + 50.0 * bernoulli(rng, 0.000_58)
        })
    }),
    noise("few", "two values, nearly", |rng, _| {
        each(rng, |rng, _, _| 0.001 * uniform(rng) + bernoulli(rng, 0.3))
    }),
    noise("edges", "calm, but for a column of two values", |rng, _| {
        each(rng, |rng, x, _| {
            1.0 + 0.01 * normal(rng)
                + if x == 5 {
                    2.0 * bernoulli(rng, 0.3)
                } else {
                    0.0
                }
        })
    }),
    noise("lone", "calm, but for a pixel of two values", |rng, _| {
        each(rng, |rng, x, y| {
            1.0 + 0.01 * normal(rng)
                + if [x, y] == [5, 5] {
                    20.0 * bernoulli(rng, 0.3)
                } else {
                    0.0
                }
        })
    }),
    noise("graded", "coins of all chances", |rng, _| {
        each(rng, |rng, x, _| {
            bernoulli(rng, 10f64.powf(-3.0 * x as f64 / SIDE as f64))
        })
    }),
    noise("heavy", "Pareto 2.5", |rng, _| {
        each(rng, |rng, _, _| pareto(rng, 2.5))
    }),
    noise("heavier", "Pareto 1.5", |rng, _| {
        each(rng, |rng, _, _| pareto(rng, 1.5))
    }),
    noise("correlated", "5 × 5 pixels together", |rng, _| {
        blurred(rng)
    }),
    noise("common", "a factor of each image", |rng, _| {
        let factor = 1.0 + 0.05 * exponential(rng);
        each(rng, |rng, _, _| factor * (1.0 + 0.1 * normal(rng)))
    }),
    NoiseModel {
        rounding: 1.0 / 2048.0,
        ..noise(
            "half",
            "the second side in 16-bit floats, with less noise than these resolve",
            |rng, side| {
                each(rng, |rng, _, _| {
                    let value = 1.000_3 + 0.000_01 * normal(rng);
                    if side == 0 { value } else { half(value) }
                })
            },
        )
    },
];
const SINGLE: NoiseModel = noise(
    "single",
    "the first side's samples added in single precision",
    sums,
);

/// Compares images drawn from a distribution, the first side's `factor` times as bright.
fn compare_draws(
    model: &NoiseModel,
    numbers: [usize; 2],
    factor: f64,
    rng: &mut Stream,
) -> Verdict {
    let [a, b] = [0, 1].map(|side| -> Vec<Image> {
        let factor = if side == 0 { factor } else { 1.0 };
        let image = |_| {
            (model.draw)(rng, side)
                .into_iter()
                .map(|value| factor * value)
                .collect()
        };
        (0..numbers[side]).map(image).collect()
    });
    let [a, b] = [&a, &b].map(|side| Side::Images(side.iter().map(Vec::as_slice).collect()));
    let rules = Rules {
        level: LEVEL,
        rounding: model.rounding,
        single_sums: model.key == SINGLE.key,
        ..Rules::default()
    };
    compare(SIDE, &[[a, b]], &rules).verdict
}

fn run(run: &mut Run) -> Result<(), Error> {
    let runs = run.count(run.by_tier(40, 1000)) as u32;
    let less = runs.div_ceil(10);
    let cells: Vec<(&NoiseModel, [usize; 2])> = NOISE_MODELS
        .iter()
        .flat_map(|model| NUMBERS.map(|numbers| (model, numbers)))
        .chain([(&SINGLE, [4, 4])])
        .collect();
    let level = FAMILYWISE_LEVEL / (2 * cells.len()) as f64;
    let (mut worst, mut worst_equal, mut kept, mut kept_equal) = (0.0_f64, 0.0_f64, true, true);
    for (model, numbers) in &cells {
        let key = format!("{}.{}-{}", model.key, numbers[0], numbers[1]);
        let seed = seed_for(run.seed(), &format!("comparisons {key}"));
        // A distribution that is slow to draw from is drawn less often.
        let runs = if model.key == SINGLE.key { less } else { runs };
        let count = |factor: f64,
                     runs: u32,
                     from: u32,
                     wanted: fn(&Verdict) -> bool|
         -> Result<u64, Error> {
            let repeat = |i: u32| {
                u64::from(wanted(&compare_draws(
                    model,
                    *numbers,
                    factor,
                    &mut stream(seed, from + i, 0),
                )))
            };
            Ok(parallel_map(0..runs, repeat)?.into_iter().sum())
        };
        let fails = |verdict: &Verdict| *verdict == Verdict::Fails;
        let alarms = count(1.0, runs, 0, fails)?;
        // Sides whose difference is just more than the margin.
        let equal = count(1.0101, less, 1 << 20, |verdict| *verdict == Verdict::Holds)?;
        let rate = alarms as f64 / f64::from(runs);
        kept &= binomial_sf(alarms, runs.into(), LEVEL) >= level;
        kept_equal &= binomial_sf(equal, less.into(), LEVEL) >= level;
        worst = worst.max(rate);
        worst_equal = worst_equal.max(equal as f64 / f64::from(less));
        run.number(&format!("{key}.alarms"), rate);
        run.number(
            &format!("{key}.alarms-at-most"),
            binomial_interval(alarms, runs.into(), 0.025)[1],
        );
        for (i, (factor, name)) in BRIGHTER.into_iter().enumerate() {
            let seen = count(factor, less, (2 + i as u32) << 20, fails)?;
            run.number(&format!("{key}.{name}"), seen as f64 / f64::from(less));
        }
        run.note(&key, format!("{}: {alarms} of {runs} DIFFER", model.what));
    }
    run.note(
        "size",
        format!(
            "{} cells, {runs} runs each, {SIDE}x{SIDE} pixels, level {LEVEL}",
            cells.len()
        ),
    );
    run.numbers(
        "all",
        [
            ("cells", cells.len() as f64),
            ("runs", f64::from(runs)),
            ("level", LEVEL),
        ],
    );
    run.numbers("worst", [("alarms", worst), ("equal", worst_equal)]);
    let value = format!("at most {worst} of the runs, level {LEVEL}");
    run.claim("no cell has more false alarms than its level", value, kept);
    let value = format!("at most {worst_equal} of the runs");
    run.claim(
        "none calls a difference beyond the margin equal more often than the level",
        value,
        kept_equal,
    );
    Ok(())
}
