//! Checks that the statistics keep their stated error rates.

use std::collections::BTreeMap;

use whitefurnace::harness::ks::kolmogorov_smirnov;
use whitefurnace::harness::tails::{binomial_sf, kolmogorov_upper};

use crate::experiments::prelude::*;
use trials::statistics::{self, ErrorRateBound, N};

pub(super) const CALIBRATION: Experiment = Experiment {
    id: "calibration",
    title: "p-values of true hypotheses are uniform, stated error rates are kept (accumulates over runs)",
    headline: "p-values and stated error rates over {replications %d} replications: {holds} hold, {fails} fail",
    version: 5,
    equations: &[],
    run,
};

/// Scale at which the registry's trials are repeated.
const SCALE: f64 = 1.0 / 1024.0;
/// Statistics of continuous variables, whose p-values are uniform, not only stochastically larger
/// than uniform...
const CONTINUOUS: [&str; 6] = [
    "t",
    "z",
    "Welch",
    "chi-square",
    "Kolmogorov-Smirnov",
    "variance ratio",
];
/// ...from about this number of values on.
const MIN_VALUES: u64 = 900;

/// Replications of one part, which an interrupted run need not repeat.
const REPLICATIONS_PER_PART: usize = 32;

/// Prefixes of names in the accumulated rows.
const STATISTIC: &str = "statistic ";
const ERROR_RATE: &str = "promise ";
const TRIAL: &str = "trial ";

fn run(run: &mut Run) -> Result<(), Error> {
    let key = format!(
        "calibration version {}, seed {}, n = {N}, registry at scale 1/1024",
        CALIBRATION.version,
        run.seed()
    );
    let mut accumulated = run.accumulated("calibration.csv", &key, "replication,name,p")?;
    let first = accumulated.next();
    let replications: Vec<u64> = (first..first + run.count(run.by_tier(64, 1024))).collect();
    let registry = trials::all();
    run.add_equations_of(&registry);
    let master = run.seed();
    let registry = trials_with_p_values(registry, master)?;
    let bar = Bar::new("", replications.len() as u64, "seeds");
    for part in replications.chunks(REPLICATIONS_PER_PART) {
        let found = run.part(&format!("from-{}", part[0]), || {
            let found = parallel_map(part, |&k| -> Result<Vec<[String; 2]>, Error> {
                let mut rows = examine_statistics(master, k);
                rows.extend(examine_registry(&registry, master, k)?);
                Ok(rows)
            })?;
            found.into_iter().collect::<Result<Vec<_>, _>>()
        })?;
        for (&k, rows) in part.iter().zip(found) {
            rows.iter().for_each(|row| accumulated.push(k, row));
        }
        bar.advance(part.len() as u64);
    }
    let family = accumulated.look(FAMILYWISE_LEVEL);
    accumulated.write()?;
    let mut by_name: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for (name, p) in accumulated.column("name").zip(accumulated.numbers("p")) {
        by_name.entry(name).or_default().push(p);
    }
    let (all, own, look) = (accumulated.next(), replications.len(), accumulated.looks());
    let value = format!(
        "{all} replications so far, {own} of this run; n = {N} per statistic, registry at scale 1/1024; \
         family-wise level {FAMILYWISE_LEVEL:.0e} for all looks, {family:.1e} for this one, number {look}"
    );
    run.note("size", value);
    run.number("replications", all as f64);
    let level = family / by_name.len().max(10) as f64;
    judge(run, &by_name, level);
    draw(run, &by_name, level)
}

/// Returns the p-values of the statistics, and whether each promise was broken, in replication k.
fn examine_statistics(master: u64, k: u64) -> Vec<[String; 2]> {
    let rng = |name: &str| stream(seed_for(master, name), k as u32, 0);
    let statistics = statistics::continuous().into_iter().map(|statistic| {
        let name = format!("{STATISTIC}{}", statistic.name);
        let p = (statistic.run)(&mut rng(&name), 0.0).p;
        [name, format!("{p:.6e}")]
    });
    let error_rate_bounds = statistics::error_rate_bounds().into_iter().map(|bound| {
        let name = format!("{ERROR_RATE}{}", bound.name);
        let happened = (bound.happened)(&mut rng(&name));
        [name, u8::from(happened).to_string()]
    });
    statistics.chain(error_rate_bounds).collect()
}

/// Groups whose p-values are meaningless at this scale: the checks of whole BSDFs integrate for
/// seconds, and the pixels of the images have two replications each.
const EXCLUDED_GROUPS: [&str; 2] = ["bsdf", "images"];

/// Returns the trials that have p-values to examine, determined by a separate replication.
fn trials_with_p_values(registry: Vec<Trial>, master: u64) -> Result<Vec<Trial>, Error> {
    let context = Context::new(seed_for(master, "calibration, which trials"), SCALE)?;
    let examined = parallel_map(&registry, |trial| {
        !EXCLUDED_GROUPS.contains(&group(&trial.name)) && !p_values(trial, &context).is_empty()
    })?;
    Ok(registry
        .into_iter()
        .zip(examined)
        .filter_map(|(trial, kept)| kept.then_some(trial))
        .collect())
}

/// Returns the p-values of these trials in replication k.
fn examine_registry(trials: &[Trial], master: u64, k: u64) -> Result<Vec<[String; 2]>, Error> {
    let context = Context::new(seed_for(master, &format!("calibration {k}")), SCALE)?;
    Ok(trials
        .iter()
        .flat_map(|trial| p_values(trial, &context))
        .collect())
}

/// Returns the p-values of a trial's continuous statistics, with their names.
fn p_values(trial: &Trial, context: &Context) -> Vec<[String; 2]> {
    let outcomes = run_trial(trial, context).into_iter().map(|row| row.outcome);
    let continuous = outcomes.filter(|o| {
        // A furnace that is constant by construction has no meaningful p-values.
        let varies = o.half_width() > 1e-9 * o.reference.abs();
        // Nor has a chi-square whose cells have all been pooled into one.
        let varies = varies && o.dof != Some(0.0);
        CONTINUOUS.contains(&o.statistic) && o.n >= MIN_VALUES && varies
    });
    let named = |o: Outcome| {
        [
            format!("{TRIAL}{}: {}", trial.name, o.name.replace(',', ";")),
            format!("{:.6e}", o.p),
        ]
    };
    continuous.map(named).collect()
}

/// Judges each name at `level`, its share of the look's level.
fn judge(run: &mut Run, by_name: &BTreeMap<&str, Vec<f64>>, level: f64) {
    let error_rate_bounds = statistics::error_rate_bounds();
    let (mut registered, mut worst) = (0, (1.0, String::from("none")));
    for (&name, values) in by_name {
        let n = values.len() as u64;
        if let Some(ErrorRateBound { rate, .. }) = error_rate_bounds
            .iter()
            .find(|p| name.strip_prefix(ERROR_RATE) == Some(p.name))
        {
            let k = values.iter().filter(|&&happened| happened > 0.5).count() as u64;
            let value = format!("{k} of {n}, at most {rate:.0e} promised");
            run.number(&format!("{name}.share"), k as f64 / n as f64);
            run.claim(name, value, binomial_sf(k, n, *rate) >= level);
            continue;
        }
        let outcome = kolmogorov_smirnov(name, &mut values.clone(), |p| p, 1.0);
        run.number(&format!("{name}.distance"), outcome.estimate);
        if name.starts_with(TRIAL) {
            registered += 1;
            if outcome.p < worst.0 {
                worst = (outcome.p, name.to_owned());
            }
            if outcome.p >= level {
                continue;
            }
        }
        let value = format!(
            "D = {:.4} over {n} seeds, p = {:.2e}",
            outcome.estimate, outcome.p
        );
        run.claim(name, value, outcome.p >= level);
    }
    let value = format!(
        "{registered} measures, least p = {:.2e} ({})",
        worst.0, worst.1
    );
    run.claim("p-values of the registry's trials", value, worst.0 >= level);
}

fn draw(run: &mut Run, by_name: &BTreeMap<&str, Vec<f64>>, level: f64) -> Result<(), Error> {
    let n = by_name
        .values()
        .map(|values| values.len() as u64)
        .max()
        .unwrap_or(1);
    let radius = kolmogorov_upper(n, level);
    let band = |sign: f64| {
        let label = if sign > 0.0 {
            "limit at the level of this look"
        } else {
            ""
        };
        Series::new(
            label,
            6,
            Mark::Line,
            [[0.0, sign * radius], [1.0, sign * radius]],
        )
    };
    let panel = |title: String, prefix: &str, mark: Mark| {
        let named = by_name
            .iter()
            .filter_map(|(name, values)| Some((name.strip_prefix(prefix)?, values)));
        let series = named.enumerate().map(|(i, (name, values))| {
            let (label, stretches) = if mark == Mark::Faint {
                ("", 40)
            } else {
                (name, 200)
            };
            Series::new(label, i, mark, deviations(values, stretches))
        });
        let series = series.chain([band(1.0), band(-1.0)]).collect();
        let axes = ["p-value expected at this rank", "observed − expected"];
        Chart::new(
            title,
            axes,
            [[0.0, 1.0], [-1.5 * radius, 2.8 * radius]],
            series,
        )
    };
    let statistics = panel(
        format!("Statistics of true hypotheses, {n} seeds, n = {N}"),
        STATISTIC,
        Mark::Line,
    );
    let trials = panel(
        format!("The registry's trials, {n} seeds, scale 1/1024, a line each"),
        TRIAL,
        Mark::Faint,
    );
    let description =
        "Lines between the limits are those of uniform p-values, as true hypotheses give.";
    charts(
        run,
        "quantiles.svg",
        description,
        900,
        &[statistics, trials],
    )
}

/// Returns the differences of sorted p-values from their expected quantiles: the largest of each of
/// `stretches` intervals of equal length.
fn deviations(values: &[f64], stretches: usize) -> Vec<[f64; 2]> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len() as f64;
    let expected = |i: usize| (i as f64 + 0.5) / n;
    let points = sorted.iter().enumerate();
    let points: Vec<[f64; 2]> = points
        .map(|(i, p)| [expected(i), p - expected(i)])
        .collect();
    points
        .chunks(sorted.len().div_ceil(stretches))
        .filter_map(|part| {
            part.iter()
                .copied()
                .max_by(|a, b| a[1].abs().total_cmp(&b[1].abs()))
        })
        .collect()
}
