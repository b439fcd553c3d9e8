//! Whether the statistics see what they are said to see.

use whitefurnace::equation;
use whitefurnace::error::Error;
use whitefurnace::harness::mean::Values;
use whitefurnace::harness::outcome::ALPHA;
use whitefurnace::harness::tails::{binomial_interval, binomial_two_sided};
use whitefurnace::rng::{seed_for, stream};

use crate::lab::{Experiment, Lab};
use crate::plot::chart::{Chart, Corner, Mark, Series, charts};
use crate::statistics::{N, Statistic, continuous, discrete};
use crate::suite::{FAMILY, parallel};

/// Rejections at the suite's own level under effects of known size.
pub const POWER: Experiment = Experiment {
    id: "power",
    title: "power at level 1e-9: measured rejections against the stated curve",
    version: 1,
    equations: &[&equation::ESTIMATOR],
    run,
};

/// Powers at which the stated curve is checked.
const CHECKED: [f64; 5] = [0.1, 0.3, 0.5, 0.9, 0.99];

/// Power as a function of the effect.
type Curve = fn(f64) -> f64;

/// What was measured at one effect.
struct Point {
    stated: f64,
    effect: f64,
    rejected: u64,
    values: Values,
}

fn run(lab: &mut Lab) -> Result<(), Error> {
    let replications = lab.count(lab.by_tier(200, 2000)).max(2);
    let mut panels = Vec::new();
    let mut rows = Vec::new();
    let statistics: Vec<Statistic> = continuous().into_iter().chain([discrete()]).collect();
    let known = statistics.iter().filter_map(|s| Some((s, s.power?)));
    let known: Vec<(&Statistic, Curve)> = known.collect();
    let level = FAMILY / (known.len() * CHECKED.len()) as f64;
    for (i, &(statistic, power)) in known.iter().enumerate() {
        let mut points = Vec::new();
        for stated in CHECKED {
            let effect = effect_of(power, stated, statistic.unit);
            let point = measure(lab.seed(), statistic, effect, stated, replications)?;
            report(lab, statistic, &point, replications, level);
            rows.push(format!(
                "{},{:e},{stated},{},{replications},{:e},{:e}",
                statistic.name,
                effect,
                point.rejected,
                point.values.moments.mean(),
                point.values.moments.variance().sqrt()
            ));
            points.push(point);
        }
        panels.extend(series(statistic, power, &points, i, replications));
    }
    lab.csv(
        "power.csv",
        "statistic,effect,stated,rejected,replications,mean,spread",
        &rows,
    )?;
    lab.note(
        "what is extrapolated",
        format!(
            "measured: powers of 0.1 to 0.99 at level {ALPHA:.0e} (n = {N}, {replications} replications, \
             family-wise level {FAMILY:.0e}); extrapolated by the same curves: misses of 1e-9 at δ and \
             false alarms of 1e-9"
        ),
    );
    charts(
        &lab.figure("power.svg"),
        [900, 560],
        &[Chart {
            title: format!(
                "Power at level 1e-9, n = {N}: curves stated, points from {replications} replications"
            ),
            axes: [
                "effect (standard errors)".into(),
                "probability of rejection".into(),
            ],
            ranges: [[4.0, 11.0], [0.0, 1.02]],
            log: [false, false],
            series: panels,
            legend: Corner::LowerRight,
        }],
    )
}

/// The effect with this power: the curve rises.
fn effect_of(power: Curve, wanted: f64, unit: f64) -> f64 {
    let (mut low, mut high) = (0.0, 20.0 * unit);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if power(middle) < wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    // Discrete statistics jump: what is stated is the power at the effect itself.
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
    let numbers: Vec<u32> = (0..replications as u32).collect();
    let outcomes = parallel(&numbers, |&k| {
        (statistic.run)(&mut stream(seed, k, 0), effect)
    })?;
    let mut values = Values::new(0.0);
    outcomes.iter().for_each(|o| values.push(o.value));
    Ok(Point {
        stated: wanted,
        effect,
        rejected: outcomes.iter().filter(|o| o.p < ALPHA).count() as u64,
        values,
    })
}

fn report(lab: &mut Lab, statistic: &Statistic, point: &Point, replications: u64, level: f64) {
    let Point {
        stated, rejected, ..
    } = *point;
    let share = rejected as f64 / replications as f64;
    let [mean, spread] = [
        point.values.moments.mean(),
        point.values.moments.variance().sqrt(),
    ];
    let key = format!("{}.{stated}", statistic.name.replace(' ', "-"));
    lab.number(&format!("{key}.rejected"), share);
    lab.number(&format!("{key}.mean"), mean);
    lab.number(&format!("{key}.spread"), spread);
    lab.claim(
        &format!("{} at power {stated}", statistic.name),
        format!(
            "{rejected} of {replications} rejected, effect {:.3} standard errors, statistic {mean:.2} ± {spread:.2}",
            point.effect / statistic.unit
        ),
        binomial_two_sided(rejected, replications, stated) >= level,
    );
}

/// The stated curve, and the measured points with 95 % intervals.
fn series(
    statistic: &Statistic,
    power: Curve,
    points: &[Point],
    colour: usize,
    replications: u64,
) -> [Series; 2] {
    let curve = (0..=140).map(|i| 4.0 + 0.05 * f64::from(i));
    let curve = curve.map(|x| [x, power(x * statistic.unit)]).collect();
    let place = |point: &Point| {
        [
            point.effect / statistic.unit,
            point.rejected as f64 / replications as f64,
        ]
    };
    let mut measured = Series::new("", colour, Mark::Points, points.iter().map(place).collect());
    measured.bars = points
        .iter()
        .map(|point| binomial_interval(point.rejected, replications, 0.025))
        .collect();
    [
        Series::new(statistic.name, colour, Mark::Line, curve),
        measured,
    ]
}
