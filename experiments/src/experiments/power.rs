//! Checks that the statistics have their stated power: on their own, and in the registry's trials.

pub mod graded;

use whitefurnace::harness::tails::{binomial_cdf, binomial_interval, binomial_two_sided};

use crate::experiments::prelude::*;
use trials::statistics::{N, Statistic, with_power};

pub(super) const POWER: Experiment = Experiment {
    id: "power",
    title: "power: measured rejections against the stated curves; the registry's own, at δ",
    headline: "stated against measured power: {holds} hold, {fails} fail, {undecided} undecided",
    version: 4,
    equations: &[&equation::ESTIMATOR],
    run,
};

/// Powers at which the stated curve is checked.
const CHECKED: [f64; 5] = [0.1, 0.3, 0.5, 0.9, 0.99];

/// Result at one effect size.
struct Point {
    stated: f64,
    effect: f64,
    rejected: u64,
    /// Mean and standard deviation of the statistic.
    values: [f64; 2],
}

fn run(run: &mut Run) -> Result<(), Error> {
    let replications = run.count(run.by_tier(200, 2000)).max(2);
    let mut panels = Vec::new();
    let mut rows = Vec::new();
    let statistics = with_power();
    // The other half of the level is that of the graded controls.
    let level = 0.5 * FAMILYWISE_LEVEL / (statistics.len() * CHECKED.len()) as f64;
    for (i, statistic) in statistics.iter().enumerate() {
        let mut points = Vec::new();
        for stated in CHECKED {
            let effect = effect_of(statistic, stated);
            let point = measure(run.seed(), statistic, effect, stated, replications)?;
            report(run, statistic, &point, replications, level);
            let (name, rejected, [mean, spread]) = (statistic.name, point.rejected, point.values);
            rows.push(format!(
                "{name},{effect:e},{stated},{rejected},{replications},{mean:e},{spread:e}"
            ));
            points.push(point);
        }
        panels.push(series(statistic, &points, i % PER_PANEL, replications).to_vec());
    }
    run.csv(
        "power.csv",
        "statistic,effect,stated,rejected,replications,mean,spread",
        &rows,
    )?;
    let value = format!(
        "measured: powers of 0.1 to 0.99 at level {ALPHA:.0e} (n = {N}, {replications} replications, \
         family-wise level {FAMILYWISE_LEVEL:.0e} with the graded controls); extrapolated by the same curves: misses of 1e-9 \
         at δ and false alarms of 1e-9"
    );
    run.note("what is extrapolated", value);
    let titles = ["sums of values", "counts, cells, bounds"];
    let panels = panels.chunks(PER_PANEL).zip(titles).map(|(series, what)| {
        let title = format!(
            "Power at level 1e-9, {what}: curves stated, points from {replications} replications"
        );
        let axes = ["effect (standard errors)", "probability of rejection"];
        Chart::new(title, axes, [EFFECT_RANGE, [0.0, 1.02]], series.concat())
    });
    let panels: Vec<Chart> = panels.collect();
    let description = "Measured rates of rejection lie on the stated curves, or above them where the stated power is a \
               lower bound.";
    charts(run, "power.svg", description, 960, &panels)?;
    graded::graded(run, 0.5 * FAMILYWISE_LEVEL)?;
    registry(run)
}

/// Statistics in each panel of the figure.
const PER_PANEL: usize = 5;
/// Range of effects in the figure, in standard errors.
const EFFECT_RANGE: [f64; 2] = [3.0, 17.0];

/// Returns the effect with this power, by bisection: the curve is increasing.
fn effect_of(statistic: &Statistic, wanted: f64) -> f64 {
    let (mut low, mut high) = (0.0, 20.0 * statistic.unit);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if statistic.power(middle) < wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    // Discrete statistics jump: the stated power is that at the effect itself.
    high
}

fn measure(
    master: u64,
    statistic: &Statistic,
    effect: f64,
    wanted: f64,
    replications: u64,
) -> Result<Point, Error> {
    let seed = seed_for(master, &format!("power {} {wanted}", statistic.name));
    let replicate = |k| (statistic.run)(&mut stream(seed, k, 0), effect);
    let outcomes = parallel_map(0..replications as u32, replicate)?;
    let rejected = outcomes.iter().filter(|o| o.p < ALPHA).count() as u64;
    let moments: Moments = outcomes.iter().map(|o| o.value).collect();
    Ok(Point {
        stated: wanted,
        effect,
        rejected,
        values: [moments.mean(), moments.variance().sqrt()],
    })
}

/// Returns the probability of a count of rejections at least this far from the stated power, on the
/// lower side alone where that is a bound.
fn p_of_count(rejected: u64, replications: u64, stated: f64, bound: bool) -> f64 {
    let p = if bound {
        binomial_cdf
    } else {
        binomial_two_sided
    };
    p(rejected, replications, stated)
}

fn report(run: &mut Run, statistic: &Statistic, point: &Point, replications: u64, level: f64) {
    let Point {
        stated,
        rejected,
        values: [mean, spread],
        ..
    } = *point;
    let p = p_of_count(rejected, replications, stated, statistic.is_bound());
    let at_least = if statistic.is_bound() {
        "at least "
    } else {
        ""
    };
    let share = rejected as f64 / replications as f64;
    let key = format!("{}.{stated}", statistic.name.replace(' ', "-"));
    run.numbers(
        &key,
        [("rejected", share), ("mean", mean), ("spread", spread)],
    );
    let value = format!(
        "{rejected} of {replications} rejected, effect {:.3} standard errors, statistic {mean:.2} ± {spread:.2}",
        point.effect / statistic.unit
    );
    run.claim(
        &format!("{} at power {at_least}{stated}", statistic.name),
        value,
        p >= level,
    );
}

/// Returns the stated curve, and the measured points with 95 % intervals.
fn series(
    statistic: &Statistic,
    points: &[Point],
    colour: usize,
    replications: u64,
) -> [Series; 2] {
    let place = |point: &Point| {
        [
            point.effect / statistic.unit,
            point.rejected as f64 / replications as f64,
        ]
    };
    let bars = points
        .iter()
        .map(|p| binomial_interval(p.rejected, replications, 0.025))
        .collect();
    [
        Series::curve(statistic.name, colour, EFFECT_RANGE, 280, |x| {
            statistic.power(x * statistic.unit)
        }),
        Series::new("", colour, Mark::Points, points.iter().map(place)).with_bars(bars),
    ]
}

/// Detectable effect of one random measure of the registry, in units of its δ.
struct Detectable<'a> {
    row: &'a Row,
    ratio: f64,
}

/// Records the stated power of every random measure of the registry at its own δ.
fn registry(run: &mut Run) -> Result<(), Error> {
    let trials = trials::all();
    run.add_equations_of(&trials);
    let (scale, found) = (suite::scale(run), suite::rows(run, &trials)?);
    let random = found.iter().flatten().filter(|row| row.outcome.is_random());
    let mut measures: Vec<Detectable> = random
        .map(|row| Detectable {
            row,
            ratio: row.outcome.minimum_detectable_effect() / row.outcome.claim.size(),
        })
        .collect();
    measures.sort_by(|a, b| b.ratio.total_cmp(&a.ratio));
    let line = |Detectable { row, ratio }: &Detectable| {
        let Row {
            trial, outcome: o, ..
        } = row;
        let (delta, detects, miss) = (o.claim.size(), o.minimum_detectable_effect(), o.miss());
        run.numbers(
            &format!("{trial}: {}", o.name),
            [("detects_over_delta", *ratio), ("miss", miss)],
        );
        let Outcome {
            name, statistic, n, ..
        } = o;
        format!("{trial},\"{name}\",{statistic},{n},{delta:e},{detects:e},{ratio:.4},{miss:e}")
    };
    let lines: Vec<String> = measures.iter().map(line).collect();
    run.csv(
        "registry.csv",
        "trial,measure,statistic,n,delta,detects,detects_over_delta,miss_at_delta",
        &lines,
    )?;
    // Effects that are just detected shrink as 1/√n (in a Poisson count, whose δ grows as n²,
    // faster).
    let limit = scale.powf(-0.5);
    let weak = measures
        .iter()
        .filter(|m| m.ratio > limit || m.ratio.is_nan());
    let weakest = measures.first().map_or_else(String::new, |m| {
        format!("{:.3} δ ({}: {})", m.ratio, m.row.trial, m.row.outcome.name)
    });
    let value = format!(
        "{} random measures at scale {scale}, {} of them weaker than {limit:.1} δ; the weakest detects {weakest}",
        measures.len(),
        weak.count()
    );
    if scale == 1.0 {
        let all_seen = measures.iter().all(|m| m.row.outcome.miss() <= ALPHA);
        run.claim(
            "the registry misses its δ at most once in 1e9",
            value,
            all_seen,
        );
    } else {
        run.note("the registry's power at δ, at reduced size", value);
    }
    draw_registry(run, &measures, scale, limit)
}

/// Draws every measure in the order of its ratio, by statistic; measures that vary by rounding
/// alone lie below.
fn draw_registry(
    run: &mut Run,
    measures: &[Detectable],
    scale: f64,
    limit: f64,
) -> Result<(), Error> {
    let mut kinds: Vec<&str> = measures.iter().map(|m| m.row.outcome.statistic).collect();
    kinds.sort_unstable();
    kinds.dedup();
    let count = measures.len() as f64;
    let largest = measures
        .iter()
        .map(|m| m.ratio)
        .filter(|ratio| ratio.is_finite())
        .fold(limit, f64::max);
    let line = [[0.0, limit], [count + 1.0, limit]];
    let mut series = vec![Series::new("just seen at full size", 0, Mark::Faint, line)];
    for (colour, kind) in kinds.into_iter().enumerate() {
        let of_kind = measures.iter().enumerate();
        let of_kind = of_kind.filter(|(_, m)| m.row.outcome.statistic == kind && m.ratio > 0.0);
        let points = of_kind.map(|(i, m)| [i as f64 + 1.0, m.ratio]);
        series.push(Series::new(kind, colour, Mark::Points, points));
    }
    let title = format!("What each random measure of the registry detects, scale {scale}");
    let axes = [
        "measure, the weakest first (as in registry.csv)",
        "minimum detectable effect/δ",
    ];
    let ranges = [[0.0, count + 1.0], [0.01 * limit, 1.5 * largest]];
    let chart = Chart::new(title, axes, ranges, series).log([false, true]);
    let description = "Below the line a measure sees the effect that it must see.";
    charts(run, "registry.svg", description, 560, &[chart])
}
