//! The estimator (16) itself: mean, variance and standard error of known values, merged from two
//! parts, with lost samples that count as 0.

use whitefurnace::math::moments::{ExactMoments, Moments};

use crate::prelude::*;

/// Computes mean, variance and standard error of two sets of values together.
type Summary = fn(&[f64], &[f64]) -> [f64; 3];

fn summary(a: &[f64], b: &[f64]) -> [f64; 3] {
    let [a, b] = [a, b].map(|values| values.iter().copied().collect::<Moments>());
    of(a.merge(b))
}

fn of(moments: Moments) -> [f64; 3] {
    [moments.mean(), moments.variance(), moments.standard_error()]
}

/// Computes them with the film's accumulators.
fn exact_summary(a: &[f64], b: &[f64]) -> [f64; 3] {
    let fill = |values: &[f64]| {
        let mut moments = ExactMoments::default();
        let bad = values.iter().any(|&v| moments.push(v).is_err());
        (!bad).then_some(moments)
    };
    let (Some(mut moments), Some(other)) = (fill(a), fill(b)) else {
        return [f64::NAN; 3];
    };
    if moments.merge(&other).is_err() {
        return [f64::NAN; 3];
    }
    let n = (a.len() + b.len()) as u32;
    [
        moments.mean(n),
        moments.variance(n),
        moments.standard_error(n),
    ]
}

/// Computes them in two passes over all values: mean, then squared deviations from it.
fn two_passes(values: &[f64]) -> [f64; 3] {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    [mean, variance, (variance / n).sqrt()]
}

const SETS: u64 = 2_000;
/// Film accumulators round values to 2⁻³²; the smallest of these variances is about 1e-3.
const TOLERANCE: f64 = 1e-6;

/// Compares a summary with [`two_passes`] on sets of 4 to 42 values, some of which are lost samples
/// that count as 0. Two values of each part are never lost, so that a fault that leaves out the
/// lost ones has finite moments.
fn known_values(context: &Context, summary: Summary) -> Vec<Outcome> {
    let mut rng = context.rng("values");
    let (mut worst, mut lost) = (0.0_f64, 0);
    for _ in 0..context.arguments(SETS) {
        let mut set = || -> Vec<f64> {
            (0..2 + (20.0 * uniform(&mut rng)) as usize)
                .map(|i| {
                    let keep = uniform(&mut rng) < 0.8;
                    if keep || i < 2 {
                        1.0 + 2.0 * uniform(&mut rng)
                    } else {
                        0.0
                    }
                })
                .collect()
        };
        let (a, b) = (set(), set());
        let all = [a.clone(), b.clone()].concat();
        lost += all.iter().filter(|&&v| v == 0.0).count();
        let [expected, found] = [two_passes(&all), summary(&a, &b)];
        for (e, f) in expected.iter().zip(found) {
            let error = (e - f).abs();
            worst = if error.is_nan() {
                f64::INFINITY
            } else {
                worst.max(error)
            };
        }
    }
    let note = format!("{lost} lost samples among the values");
    vec![Outcome::identity(
        "mean, variance, standard error",
        SETS,
        worst,
        TOLERANCE,
        note,
    )]
}

fn faults() -> Vec<Fault<Summary>> {
    vec![
        fault!("divided-by-n", ESTIMATOR, "the variance is divided by n for n − 1",
            = |a, b| {
                let n = (a.len() + b.len()) as f64;
                let [mean, variance, _] = summary(a, b);
                let variance = variance * (n - 1.0) / n;
                [mean, variance, (variance / n).sqrt()]
            },
            "accumulator/known-values"),
        fault!("lost-renormalised", ESTIMATOR, "the mean is divided by the samples that were not lost",
            = |a, b| of(a.iter().chain(b).copied().filter(|&v| v != 0.0).collect()),
            "accumulator/known-values"),
        fault!("mean-of-means", ESTIMATOR, "two parts of different size count alike",
            = |a, b| {
                let [_, variance, error] = summary(a, b);
                let mean = 0.5 * (summary(a, &[])[0] + summary(b, &[])[0]);
                [mean, variance, error]
            },
            "accumulator/known-values"),
        fault!("merge-without-shift", ESTIMATOR, "merging forgets the difference of the means",
            = |a, b| {
                let n = (a.len() + b.len()) as f64;
                let squares = |v: &[f64]| two_passes(v)[1] * (v.len() as f64 - 1.0);
                let variance = (squares(a) + squares(b)) / (n - 1.0);
                [summary(a, b)[0], variance, (variance / n).sqrt()]
            },
            "accumulator/known-values"),
        fault!("error-not-divided", ESTIMATOR, "the standard deviation for the standard error",
            = |a, b| {
                let [mean, variance, _] = summary(a, b);
                [mean, variance, variance.sqrt()]
            },
            "accumulator/known-values"),
    ]
}

/// Trials and faults of the accumulators.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    vec![Box::new(Family {
        trials: vec![trial(
            "accumulator/known-values",
            "mean, variance and standard error of known values, merged from two parts",
            "the error bars of every image and verdict are wrong, above all after a merge",
            &ESTIMATOR,
            "math::moments::Moments, math::moments::ExactMoments",
            "exact",
            known_values,
        )],
        faults: faults(),
        equivalents: vec![
            fault!("exact-moments", ESTIMATOR, "the film's integers in place of floating point",
            = exact_summary as Summary, "accumulator/known-values"),
        ],
        ..Family::new("accumulator", summary as Summary)
    })]
}
