//! Russian roulette and path length in the abstract furnace.

use trials::roulette::{CORRECT, WalkParts, variance, walk};

use super::critical;
use crate::experiments::prelude::*;

const ALBEDOS: [f64; 3] = [0.5, 0.75, 0.9];

fn walks(run: &Run, label: &str, n: u64, parts: WalkParts, [a, q]: [f64; 2]) -> (Moments, Moments) {
    let mut rng = stream(seed_for(run.seed(), label), 0, 0);
    let mean = 1.0 / (1.0 - a);
    let (mut values, mut squares) = (Moments::default(), Moments::default());
    for _ in 0..n {
        let value = walk(&mut rng, parts, a, q);
        values.push(value);
        squares.push((value - mean).powi(2));
    }
    (values, squares)
}

/// Returns the expected number of vertices of a path: 1 + q + q² + ...
fn vertices(q: f64) -> f64 {
    1.0 / (1.0 - q)
}

fn holds(moments: &Moments, known: f64) -> bool {
    (moments.mean() - known).abs() <= critical() * moments.standard_error()
}

/// Plots mean, variance and efficiency against survival: closed forms, and walks where the variance
/// of the squares is finite, from survival = albedo on.
pub fn roulette(run: &mut Run, file: &str) -> Result<(), Error> {
    let n = run.count(run.by_tier(100_000, 2_000_000));
    let [mut means, mut variances, mut efficiencies] = [const { Vec::new() }; 3];
    let mut all_hold = true;
    for (colour, a) in ALBEDOS.into_iter().enumerate() {
        let exact = 1.0 / (1.0 - a);
        let survivals = [0.5, 0.6, 0.75, 0.8, 0.9, 0.95]
            .into_iter()
            .filter(|&q| q >= a);
        let found: Vec<_> = survivals
            .map(|q| {
                (
                    q,
                    walks(run, &format!("roulette {a} {q}"), n, CORRECT, [a, q]),
                )
            })
            .collect();
        let label = format!("albedo {a}");
        means.push(Series::new(
            &label,
            colour,
            Mark::Line,
            [[0.2, exact], [1.0, exact]],
        ));
        let measured = |q: f64, m: &Moments| [q, m.mean(), critical() * m.standard_error()];
        let values = found.iter().map(|(q, (values, _))| measured(*q, values));
        means.push(Series::measured("", colour, values));
        let curve = |f: &dyn Fn(f64) -> f64| {
            (1..400)
                .map(|i| a * a + f64::from(i) / 400.0 * (1.0 - a * a))
                .map(|q| [q, f(q)])
                .collect::<Vec<_>>()
        };
        let efficiency = |q: f64| 1.0 / (variance(a, q) * vertices(q));
        variances.push(Series::new(
            &label,
            colour,
            Mark::Line,
            curve(&|q| variance(a, q)),
        ));
        let squares = found.iter().map(|(q, (_, squares))| measured(*q, squares));
        variances.push(Series::measured("", colour, squares));
        variances.push(wall(a * a, [1e-3, 1e4]));
        efficiencies.push(Series::new(&label, colour, Mark::Line, curve(&efficiency)));
        let points = found
            .iter()
            .map(|(q, (_, s))| [*q, 1.0 / (s.mean() * vertices(*q))]);
        efficiencies.push(Series::new("", colour, Mark::Points, points));
        efficiencies.push(wall(a * a, [1e-4, 1e1]));
        for (q, (values, squares)) in &found {
            all_hold &= holds(values, exact) && holds(squares, variance(a, *q));
            run.numbers(
                &format!("roulette.{a}.{q}"),
                [("mean", values.mean()), ("variance", squares.mean())],
            );
        }
        let [low, high] = [a, 0.95].map(efficiency);
        let value = format!(
            "{low:.4}, {high:.4}; the variance is infinite up to {:.4}",
            a * a
        );
        run.note(
            &format!("roulette, albedo {a}: efficiency at survival {a} and 0.95"),
            value,
        );
    }
    run.claim(
        "roulette: means and variances are their closed forms",
        format!("{n} walks each"),
        all_hold,
    );
    let chart = |title: &str, label: &str, range, series| {
        Chart::new(
            title,
            ["survival probability q", label],
            [[0.2, 1.0], range],
            series,
        )
    };
    let title = "Variance: infinite left of the squared albedo (grey)";
    let variances = chart(title, "variance of a path", [1e-2, 1e4], variances);
    let efficiencies = chart(
        "Efficiency: 1/(variance × vertices)",
        "efficiency",
        [1e-4, 1e1],
        efficiencies,
    );
    let panels = [
        chart("Mean: whatever the survival", "mean", [0.0, 14.0], means),
        variances.log([false, true]),
        efficiencies.log([false, true]),
    ];
    let description = "The mean does not depend on the survival probability; the variance has no bound left of the squared albedo.";
    charts(run, file, description, 1260, &panels)
}

fn wall(x: f64, [low, high]: [f64; 2]) -> Series {
    Series::new("", 6, Mark::Faint, [[x, low], [x, high]])
}

/// Smallest loss that is drawn.
const LEAST: f64 = 1e-4;

/// Plots the relative bias of a path truncated after b bounces: a^(b+1).
pub fn truncation(run: &mut Run, file: &str) -> Result<(), Error> {
    let n = run.count(run.by_tier(200_000, 4_000_000));
    let mut series = Vec::new();
    let mut all_hold = true;
    for (colour, a) in ALBEDOS.into_iter().enumerate() {
        let exact = 1.0 / (1.0 - a);
        let mut curve = Series::curve(&format!("albedo {a}"), colour, [0.0, 20.0], 200, |b| {
            a.powf(b + 1.0)
        });
        curve.points.retain(|[_, lost]| *lost >= LEAST);
        series.push(curve);
        let mut found = Vec::new();
        for b in [1, 2, 3, 5, 7, 10, 15, 20] {
            let (values, _) = walks(
                run,
                &format!("cut {a} {b}"),
                n,
                WalkParts {
                    longest: Some(b),
                    ..CORRECT
                },
                [a, 0.95],
            );
            let known = a.powi(b as i32 + 1);
            all_hold &= holds(&values, exact * (1.0 - known));
            let (lost, half) = (
                1.0 - values.mean() / exact,
                critical() * values.standard_error() / exact,
            );
            if b == 7 {
                run.number(&format!("cut.{a}.7"), lost);
                let [lost, closed] = [lost, known].map(|share| 100.0 * share);
                let value =
                    format!("{lost:.2} % of the light is missing, closed form {closed:.2} %");
                run.note(&format!("seven bounces at albedo {a}"), value);
            }
            // Values below the noise cannot be drawn on a logarithmic axis.
            if lost > half {
                found.push([f64::from(b), lost, half]);
            }
        }
        series.push(Series::measured("", colour, found));
    }
    series.push(wall(7.0, [LEAST, 1.0]));
    run.claim(
        "path length: the bias of cut paths is −a^(b+1)",
        format!("{n} walks each"),
        all_hold,
    );
    let title = "Share of light lost by cutting paths; the report's seven bounces in grey";
    let (axes, ranges) = (["bounces b", "relative bias"], [[0.0, 20.5], [LEAST, 1.0]]);
    let chart = Chart::new(title, axes, ranges, series).log([false, true]);
    charts(
        run,
        file,
        "Straight lines: each bounce more loses less by the albedo.",
        520,
        &[chart],
    )
}
