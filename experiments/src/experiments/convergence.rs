//! Convergence of the error with the number of samples, for independent numbers and Sobol' points.

use std::sync::Arc;

use trials::scenes::{ray_to_origin, rectangle_light};
use whitefurnace::harness::convergence::log_slope;
use whitefurnace::sampling::sampler::{Sampler, Sobol, scramble};

use crate::experiments::prelude::*;

pub(super) const CONVERGENCE: Experiment = Experiment {
    id: "convergence",
    title: "variance against samples, independent numbers and Sobol' points: smooth, edge, room",
    headline: "variance falls as samples to the power {edge.independent.slope %.2f}, by Sobol' points {edge.Sobol'.slope %.2f} at an edge, {smooth.Sobol'.slope %.2f} in smooth light",
    version: 2,
    equations: &[&equation::SOBOL, &equation::ESTIMATOR],
    run,
};

/// An integral to estimate.
enum Integrand {
    /// Light of an unoccluded square on a floor, by shadow rays: a smooth integrand of two numbers.
    Smooth(Arc<Scene>),
    /// A pixel whose part with y − ½ < 0.37 (x − ½) is bright.
    Edge,
    /// A pixel of the all-diffuse room, by path tracing. Mirrors and glass would add paths so rare
    /// and bright that the variance itself cannot be estimated.
    Room(Box<Scene>),
}

/// The pixel of the room: on the floor, with direct and indirect light.
const PIXEL: [f64; 2] = [512.0, 700.0];
const FRAME: [u32; 2] = [1024, 768];

impl Integrand {
    fn sample<R: Sampler>(&self, rng: &mut R) -> f64 {
        let radiance = |scene: &Scene, ray: &Ray, strategy, rng: &mut R| {
            let hit = scene.intersect(ray);
            Path::new(strategy).radiance(scene, ray, hit, rng).x
        };
        match self {
            Self::Smooth(scene) => radiance(scene, &ray_to_origin(), Strategy::Light, rng),
            Self::Edge => {
                let [x, y] = uniform2(rng);
                f64::from(u8::from(y - 0.5 < 0.37 * (x - 0.5)))
            }
            Self::Room(scene) => {
                let [x, y] = uniform2(rng);
                let ray = scene.camera().ray(FRAME, PIXEL[0] + x, PIXEL[1] + y);
                radiance(scene, &ray, Strategy::Mis, rng)
            }
        }
    }

    /// Returns the mean of N samples of replication `k`: independent streams, or one scramble.
    fn mean(&self, sobol: bool, seed: u64, k: u32, samples: u32) -> f64 {
        let scramble = scramble(seed, samples, k);
        let seed = seed_for(seed, &samples.to_string());
        let sum: f64 = (0..samples)
            .map(|index| {
                let mut numbers = stream(seed, k, index);
                if sobol {
                    self.sample(&mut Sobol::new(index as u16, scramble, numbers))
                } else {
                    self.sample(&mut numbers)
                }
            })
            .sum();
        sum / f64::from(samples)
    }
}

/// Number of groups of replications; the jackknife over groups gives the error of the slope.
const GROUPS: u32 = 16;
/// Replications of a group.
const REPLICATIONS: u32 = 32;
/// Number of slopes judged.
const SLOPE_INTERVALS: f64 = 6.0;

/// Variances at each number of samples over groups, the slope of their means, and its standard
/// error.
struct ConvergenceFit {
    samples: Vec<f64>,
    variances: Vec<Moments>,
    slope: f64,
    error: f64,
}

impl ConvergenceFit {
    /// Returns the half width of an interval at this experiment's share of the level, in standard
    /// errors.
    fn critical() -> f64 {
        student_upper(
            FAMILYWISE_LEVEL / 2.0 / SLOPE_INTERVALS,
            f64::from(GROUPS - 1),
        )
    }

    /// Returns the confidence interval of the slope.
    fn interval(&self) -> [f64; 2] {
        let half = Self::critical() * self.error;
        [self.slope - half, self.slope + half]
    }
}

fn measure(
    integrand: &Integrand,
    sobol: bool,
    seed: u64,
    sizes: &[u32],
) -> Result<ConvergenceFit, Error> {
    let found: Vec<Vec<f64>> = parallel_map(0..GROUPS, |group| {
        let variance = |&samples: &u32| {
            let first = group * REPLICATIONS;
            let moments: Moments = (first..first + REPLICATIONS)
                .map(|k| integrand.mean(sobol, seed, k, samples))
                .collect();
            moments.variance()
        };
        sizes.iter().map(variance).collect()
    })?;
    Ok(fit_slope(
        sizes.iter().map(|&n| f64::from(n)).collect(),
        &found,
    ))
}

/// Fits the slope of the variances that groups found at each number of samples, and its standard
/// error by the jackknife.
fn fit_slope(samples: Vec<f64>, found: &[Vec<f64>]) -> ConvergenceFit {
    // Variances, not their logarithms, are averaged: the logarithm of a noisy variance is biased,
    // more so where few samples leave the mean skewed.
    let without = |left_out: Option<usize>| -> Vec<Moments> {
        let kept = |&(k, _): &(usize, &Vec<f64>)| Some(k) != left_out;
        let at = |i: usize| {
            found
                .iter()
                .enumerate()
                .filter(kept)
                .map(|(_, group)| group[i])
                .collect()
        };
        (0..samples.len()).map(at).collect()
    };
    let slope = |variances: &[Moments]| {
        let means: Vec<f64> = variances.iter().map(Moments::mean).collect();
        log_slope(&samples, &means)
    };
    let variances = without(None);
    let jackknife: Moments = (0..found.len()).map(|k| slope(&without(Some(k)))).collect();
    let n = found.len() as f64;
    let (slope, error) = (slope(&variances), (n - 1.0) * jackknife.standard_error());
    ConvergenceFit {
        samples,
        variances,
        slope,
        error,
    }
}

fn run(run: &mut Run) -> Result<(), Error> {
    let room = room::diffuse()?;
    let cases = [
        (
            "smooth",
            "Unoccluded square light",
            Integrand::Smooth(rectangle_light(false)),
            run.by_tier(10, 13),
        ),
        (
            "edge",
            "Half-covered pixel",
            Integrand::Edge,
            run.by_tier(11, 14),
        ),
        (
            "room",
            "A pixel of the all-diffuse room",
            Integrand::Room(Box::new(room)),
            run.by_tier(7, 11),
        ),
    ];
    let mut plots = Vec::new();
    for (key, title, integrand, powers) in &cases {
        // From 4 on: with fewer points a net has no advantage.
        let sizes: Vec<u32> = (2..=*powers).map(|m| 1 << m).collect();
        let mut series = Vec::new();
        let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
        let mut slopes = Vec::new();
        for (colour, sobol) in [(2, false), (0, true)] {
            let numbers = if sobol { "Sobol'" } else { "independent" };
            let seed = seed_for(run.seed(), &format!("{key} {numbers}"));
            let fit = measure(integrand, sobol, seed, &sizes)?;
            let means = fit.variances.iter().map(Moments::mean);
            (low, high) = (
                means.clone().fold(low, f64::min),
                means.fold(high, f64::max),
            );
            let interval = fit.interval();
            let slope = fit.slope;
            let found = [
                ("slope", slope),
                ("slope.low", interval[0]),
                ("slope.high", interval[1]),
            ];
            run.numbers(&format!("{key}.{numbers}"), found);
            slopes.push((slope, interval));
            let half = slope - interval[0];
            let label = format!("{numbers}, slope {slope:.3} ± {half:.3}").replace('-', "−");
            series.extend(drawn(&label, colour, &fit));
        }
        judge(run, key, title, &slopes);
        let ranges = [
            [3.0, f64::from(1u32 << powers) * 1.3],
            [low / 3.0, high * 30.0],
        ];
        plots.push(
            Chart::new(
                *title,
                ["samples N", "variance of the mean"],
                ranges,
                series,
            )
            .log([true, true]),
        );
    }
    let description = "Straight lines on logarithmic axes: independent samples fall with slope −1 in each panel, Sobol' \
               points faster where the integrand is smooth.";
    charts(run, "convergence.svg", description, 1350, &plots)
}

/// Draws mean variances with intervals, and the line of the slope through their centre.
fn drawn(label: &str, colour: usize, fit: &ConvergenceFit) -> [Series; 2] {
    let means: Vec<f64> = fit.variances.iter().map(Moments::mean).collect();
    let centre = |values: &[f64]| values.iter().map(|v| v.ln()).sum::<f64>() / values.len() as f64;
    let (x, y) = (centre(&fit.samples), centre(&means));
    let line = |n: f64| [n, (y + fit.slope * (n.ln() - x)).exp()];
    let bars = fit.variances.iter().map(|m| {
        let half = ConvergenceFit::critical() * m.standard_error();
        [(m.mean() - half).max(0.05 * m.mean()), m.mean() + half]
    });
    let points = fit.samples.iter().zip(&means).map(|(&n, &v)| [n, v]);
    [
        Series::new(label, colour, Mark::Points, points).with_bars(bars.collect()),
        Series::new("", colour, Mark::Line, fit.samples.iter().map(|&n| line(n))),
    ]
}

fn judge(run: &mut Run, key: &str, title: &str, slopes: &[(f64, [f64; 2])]) {
    let [(independent, around), (sobol, net)] = slopes else {
        return;
    };
    let what = format!("{title}: slope of independent samples is −1");
    let value = format!(
        "{independent:.4}, interval [{:.4}, {:.4}]",
        around[0], around[1]
    );
    run.claim(&what, value, around[0] <= -1.0 && -1.0 <= around[1]);
    let value = format!("{sobol:.4}, interval [{:.4}, {:.4}]", net[0], net[1]);
    if key == "room" {
        // The room is not smooth; the gain of Sobol' points there is reported, not claimed.
        run.note(&format!("{title}: slope of Sobol' points"), value);
    } else {
        run.claim(
            &format!("{title}: Sobol' points fall faster"),
            value,
            net[1] < around[0],
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_of_a_slope_is_that_of_the_delta_method() {
        // Without noise but at the last number of samples: the slope is ln(v/8) over ln 4, with the
        // relative error of v.
        let last: Vec<f64> = (0..16)
            .map(|group| 2.0 + 0.01 * f64::from(group % 4))
            .collect();
        let groups: Vec<Vec<f64>> = last.iter().map(|v| vec![8.0, *v]).collect();
        let ConvergenceFit { slope, error, .. } = fit_slope(vec![1.0, 4.0], &groups);
        let mean = last.iter().sum::<f64>() / 16.0;
        let variance = last.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 15.0;
        assert!(
            (slope - (mean / 8.0).ln() / 4_f64.ln()).abs() < 1e-12,
            "{slope}"
        );
        let expected = (variance / 16.0).sqrt() / mean / 4_f64.ln();
        assert!(
            (error / expected - 1.0).abs() < 1e-3,
            "{error} and {expected}"
        );
    }
}
