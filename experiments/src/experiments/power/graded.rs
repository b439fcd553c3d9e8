//! Graded controls of the registry over many seeds: the correct subject's values shifted by exactly
//! δ, with each trial's own distribution and n, rejected as often as stated.

use std::collections::BTreeMap;

use whitefurnace::harness::mean::MAX_SKEW_TERM;
use whitefurnace::harness::tails::binomial_sf;

use super::p_of_count;
use crate::experiments::prelude::*;
use crate::experiments::suite_seeds::{Measure, POWERS, SuiteSeeds};

/// Least number of seeds that are judged.
const MIN_SEEDS: u64 = 200;

/// Largest level that is judged: above it almost everything is rejected.
const MAX_LEVEL: f64 = 0.9;

/// Largest error of the power that skewness may cause; with 200 seeds, five standard deviations are
/// 0.1 and more.
const MAX_POWER_ERROR: f64 = 0.02;

/// A graded control at one power, over all seeds.
pub struct ControlCount {
    /// Name of the measure: "trial: outcome".
    pub name: String,
    statistic: String,
    up: bool,
    bound: bool,
    /// Power stated at the level.
    pub power: f64,
    /// Median of the levels that the seeds state.
    pub level: f64,
    /// Number of seeds that reject it.
    pub rejected: u64,
    seeds: u64,
}

impl ControlCount {
    /// Returns the p-value of the count.
    pub fn p(&self) -> f64 {
        p_of_count(self.rejected, self.seeds, self.power, self.bound)
    }

    fn share(&self) -> f64 {
        self.rejected as f64 / self.seeds as f64
    }

    fn label(&self) -> String {
        format!("{} {}δ", self.name, self.sign())
    }

    fn sign(&self) -> char {
        if self.up { '+' } else { '-' }
    }

    fn evidence(&self) -> String {
        let (
            Self {
                rejected,
                seeds,
                level,
                power,
                ..
            },
            p,
        ) = (self, self.p());
        format!(
            "{rejected} of {seeds} rejected at level {level:.1e}, {power:.3} stated, p = {p:.1e}"
        )
    }
}

/// Returns a bound on the change of the power by skewness where the critical value is `z`. To first
/// order, the mean's skewness g changes it by g (2x² + 1)/6 φ(x) and, through the standard error,
/// by g z x/2 φ(x), x standard errors from the effect; at most g (1 + z)/8.
/// [`valid_from`](Measure::valid_from), which describes the tail at the suite's own level, gives g.
fn power_error(measure: &Measure, z: f64) -> f64 {
    if measure.valid_from <= 2 {
        return 0.0;
    }
    let used = (measure.valid_from as f64 / measure.n as f64).sqrt();
    let g = used * 3.0 * MAX_SKEW_TERM / normal_upper(0.5 * ALPHA).powi(3);
    g * (1.0 + z) / 8.0
}

/// Returns the median; for an even number the upper of the two middle values.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Measures that were not judged, by the reason.
pub type LeftOut = BTreeMap<&'static str, Vec<String>>;

/// Counts the graded controls of the registry; judges them at `family`, the level of all together.
pub fn graded(run: &mut Run, family: f64) -> Result<(), Error> {
    let seeds = SuiteSeeds::open(run)?;
    let count = run.count(run.by_tier(2, MIN_SEEDS));
    let mut by_name: BTreeMap<String, Vec<Measure>> = BTreeMap::new();
    let bar = Bar::new("", count, "seeds");
    for k in 0..count {
        for measure in seeds.subjects(k)? {
            if measure.random {
                by_name
                    .entry(measure.name.clone())
                    .or_default()
                    .push(measure);
            }
        }
        bar.advance(1);
    }
    let mut left_out = LeftOut::default();
    let counted: Vec<ControlCount> = by_name
        .values()
        .flat_map(|found| count_rejections(found, &mut left_out))
        .collect();
    report(run, &counted, &left_out, count, seeds.scale, family);
    let line = |c: &ControlCount| {
        let ControlCount {
            name,
            statistic,
            power,
            level,
            rejected,
            seeds,
            ..
        } = c;
        let (side, p) = (c.sign(), c.p());
        format!("\"{name}\",{side},{statistic},{power},{level:e},{rejected},{seeds},{p:e}")
    };
    let lines: Vec<String> = counted.iter().map(line).collect();
    run.csv(
        "graded.csv",
        "measure,side,statistic,stated,level,rejected,seeds,p",
        &lines,
    )?;
    draw(run, &counted, seeds.scale)
}

/// Counts the graded controls of one measure, given its outcome under every seed; if none can be
/// judged, the measure is listed in `left_out` with the reason.
pub fn count_rejections(found: &[Measure], left_out: &mut LeftOut) -> Vec<ControlCount> {
    let first = &found[0];
    let mut reason = if first.approximate {
        "claimed within a margin only"
    } else {
        "without graded control"
    };
    let mut counted: Vec<ControlCount> = Vec::new();
    for up in [true, false] {
        for (at, &wanted) in POWERS.iter().enumerate() {
            let of_side = |measure: &Measure| {
                let graded = measure.graded.iter().find(|graded| graded.up == up);
                graded.map(|graded| (graded.p, graded.levels[at]))
            };
            let values: Vec<(f64, [f64; 2])> = found.iter().filter_map(of_side).collect();
            if values.is_empty() {
                continue;
            }
            let part = |i: usize| median(values.iter().map(|(_, level)| level[i]).collect());
            let [level, power] = [part(0), part(1)];
            let z = normal_upper(0.5 * level);
            if level > MAX_LEVEL {
                reason = "effect too small at this scale";
            } else if median(
                found
                    .iter()
                    .map(|measure| power_error(measure, z))
                    .collect(),
            ) > MAX_POWER_ERROR
            {
                reason = "too skewed at this scale";
            } else if level > ALPHA || wanted == POWERS[0] {
                // An effect that is detected at the suite's own level is judged there for both
                // powers.
                counted.push(ControlCount {
                    name: first.name.clone(),
                    statistic: first.statistic.clone(),
                    up,
                    bound: first.bound,
                    power,
                    level,
                    rejected: values.iter().filter(|(p, _)| *p < level).count() as u64,
                    seeds: values.len() as u64,
                });
            }
        }
    }
    if counted.is_empty() {
        left_out.entry(reason).or_default().push(first.name.clone());
    }
    counted
}

fn report(
    run: &mut Run,
    counted: &[ControlCount],
    left_out: &LeftOut,
    seeds: u64,
    scale: f64,
    family: f64,
) {
    let level = family / counted.len().max(1) as f64;
    let weakest = counted.iter().min_by(|a, b| a.p().total_cmp(&b.p()));
    let failing: Vec<&ControlCount> = counted.iter().filter(|c| c.p() < level).collect();
    let mut names: Vec<&str> = counted.iter().map(|c| c.name.as_str()).collect();
    names.dedup();
    let (counts, measures, fails) = (counted.len(), names.len(), failing.len());
    run.numbers(
        "graded",
        [
            ("seeds", seeds as f64),
            ("measures", measures as f64),
            ("counts", counts as f64),
            ("scale_divides_by", 1.0 / scale),
            ("fails", fails as f64),
        ],
    );
    for (at, &power) in POWERS.iter().enumerate() {
        let near: Vec<&ControlCount> = at_power(counted, power).collect();
        let rejected: u64 = near.iter().map(|c| c.rejected).sum();
        let all: u64 = near.iter().map(|c| c.seeds).sum();
        let share = rejected as f64 / all.max(1) as f64;
        run.number(&format!("graded.share_{at}"), share);
        let value = format!(
            "{share:.4} of all are rejected ({} controls under {seeds} seeds)",
            near.len()
        );
        run.note(&format!("graded controls at power {power}"), value);
    }
    let mut value = format!(
        "{counts} counts for {measures} measures under {seeds} seeds at scale {scale}, {fails} of them off at level \
         {level:.1e} each"
    );
    if let Some(c) = weakest {
        run.numbers(
            "graded.weakest",
            [("share", c.share()), ("stated", c.power), ("p", c.p())],
        );
        value += &format!("; the furthest off is {}: {}", c.label(), c.evidence());
    }
    let what = "values off by δ are rejected as often as stated";
    let full = run.tier() == Tier::Full;
    if full {
        run.claim(what, value, failing.is_empty());
    } else {
        run.note(what, value);
    }
    for c in failing.iter().filter(|_| full) {
        run.detail(&c.label(), c.evidence(), false);
    }
    for (reason, names) in left_out {
        run.note(
            &format!("not judged: {reason}"),
            format!("{}: {}", names.len(), names.join("; ")),
        );
    }
    let none: usize = left_out.values().map(Vec::len).sum();
    run.number("graded.not_judged", none as f64);
}

/// Returns the controls counted at this power, and not at the suite's own level.
fn at_power(counted: &[ControlCount], power: f64) -> impl Iterator<Item = &ControlCount> {
    // A count's power jumps, and may exceed the one asked for.
    counted
        .iter()
        .filter(move |c| !c.bound && c.level > ALPHA && (c.power - power).abs() < 0.05)
}

/// Draws how many controls were rejected how often, and how many would be by the binomial
/// distribution of each.
fn draw(run: &mut Run, counted: &[ControlCount], scale: f64) -> Result<(), Error> {
    let panels = POWERS.map(|power| {
        let near: Vec<&ControlCount> = at_power(counted, power).collect();
        let seeds = near.iter().map(|c| c.seeds).max().unwrap_or(1);
        let width = seeds.div_ceil(50);
        let bins = seeds / width + 1;
        let place = |bin: u64| (bin as f64 + 0.5) * width as f64 / seeds as f64;
        let found = |bin: u64| near.iter().filter(|c| c.rejected / width == bin).count() as f64;
        let expected = |bin: u64| {
            let [from, to] = [bin * width, (bin + 1) * width];
            let tail = |c: &&ControlCount, k: u64| binomial_sf(k, c.seeds, c.power);
            near.iter().map(|c| tail(c, from) - tail(c, to)).sum::<f64>()
        };
        let series = |of: &dyn Fn(u64) -> f64| (0..bins).map(|bin| [place(bin), of(bin)]).collect();
        let [found, expected]: [Vec<[f64; 2]>; 2] = [series(&found), series(&expected)];
        let most = found.iter().chain(&expected).map(|at| at[1]).fold(1.0, f64::max);
        let [low, high] = [(power - 0.3_f64).max(0.0), (power + 0.3).min(1.0)];
        let within = |points: Vec<[f64; 2]>| points.into_iter().filter(move |at| (low..=high).contains(&at[0]));
        let title = format!(
            "Values off by δ, rejected at the level of power {power}: {} controls, {seeds} seeds, scale {scale}",
            near.len()
        );
        let series = vec![
            Series::new("binomial law of the stated power", 0, Mark::Line, within(expected)),
            Series::new("found", 2, Mark::Points, within(found)),
        ];
        Chart::new(title, ["share of seeds that reject", "controls"], [[low, high], [0.0, 1.1 * most]], series)
    });
    let description = "Points along the lines: graded controls are rejected as often as stated.";
    charts(run, "graded.svg", description, 760, &panels)
}
