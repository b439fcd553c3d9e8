//! The whole suite under many master seeds: how often a correct build goes red.

use whitefurnace::error::Error;
use whitefurnace::harness::outcome::{ALPHA, CAPACITY, Verdict};
use whitefurnace::harness::tails::binomial_interval;
use whitefurnace::harness::trial::Row;
use whitefurnace::rng::seed_for;
use whitefurnace::trials;

use crate::lab::{Experiment, Lab};
use crate::ledger::{Ledger, number};
use crate::plot::chart::{Chart, Mark, Series, charts};
use crate::progress::Progress;
use crate::suite::{self, FAMILY};

/// The suite at a reduced scale over master seeds.
pub const FALSE_ALARMS: Experiment = Experiment {
    id: "false-alarms",
    title: "the whole suite under fresh master seeds (accumulates over runs)",
    version: 2,
    equations: &[],
    run,
};

const COLUMNS: &str = "replication,holds,fails,undecided,random,smallest_p,where";
const FAILS: usize = 2;
const RANDOM: usize = 4;
const SMALLEST: usize = 5;

fn run(lab: &mut Lab) -> Result<(), Error> {
    let trials = trials::all();
    lab.bears_on(suite::equations(&trials));
    let scale = lab.scale(suite::REDUCED);
    let key = format!(
        "false-alarms version {}, seed {}, scale {scale}, {} trials",
        FALSE_ALARMS.version,
        lab.seed(),
        trials.len()
    );
    let mut ledger = lab.ledger("false-alarms.csv", &key, COLUMNS)?;
    let first = ledger.next();
    let seeds = lab.count(lab.by_tier(2, 200));
    let bar = Progress::default().bar_of(seeds, "seeds");
    for k in first..first + seeds {
        let seed = seed_for(lab.seed(), &format!("false-alarms {k}"));
        let row = lab.part(&format!("seed-{k}"), || {
            Ok(fields(&suite::run(&trials, seed, scale)?.concat()))
        })?;
        ledger.push(k, &row);
        bar.advance(1);
    }
    bar.finish();
    let level = ledger.look(FAMILY);
    ledger.write()?;
    report(lab, &ledger, scale, level);
    draw(lab, &ledger)
}

/// The p-values that are compared are those whose tail is valid at this scale.
fn fields(rows: &[Row]) -> Vec<String> {
    let count = |wanted: fn(Verdict) -> bool| rows.iter().filter(|row| wanted(row.verdict)).count();
    let random = || {
        rows.iter()
            .map(|row| (row, &row.outcome))
            .filter(|(_, outcome)| outcome.is_random() && outcome.n >= outcome.valid_from)
    };
    let smallest = random().min_by(|(_, a), (_, b)| a.p.total_cmp(&b.p));
    vec![
        count(|verdict| verdict == Verdict::Holds).to_string(),
        count(|verdict| verdict == Verdict::Fails).to_string(),
        count(|verdict| matches!(verdict, Verdict::Undecided { .. })).to_string(),
        random().count().to_string(),
        smallest.map_or(1.0, |(_, outcome)| outcome.p).to_string(),
        smallest.map_or_else(String::new, |(row, _)| row.trial.clone()),
    ]
}

/// Judges all suites at `level`, the share of this look.
fn report(lab: &mut Lab, ledger: &Ledger, scale: f64, level: f64) {
    let rows = ledger.rows();
    let column = |at: usize| rows.iter().map(move |row| number(row, at));
    let seeds = rows.len() as f64;
    let (fails, random): (f64, f64) = (column(FAILS).sum(), column(RANDOM).sum());
    let bound = ALPHA * CAPACITY as f64;
    let red = column(FAILS).filter(|&fails| fails > 0.0).count() as u64;
    let [_, high] = binomial_interval(red, rows.len() as u64, 0.5 * level);
    lab.number("seeds", seeds);
    lab.number("fails", fails);
    lab.number("tests", random);
    lab.number("bound", bound);
    lab.claim(
        "suites with a false rejection",
        format!(
            "{red} of {seeds} at scale {scale}, bound {bound:.0e} each; the rate is below {high:.2} at level \
             {level:.1e} (look {} of {FAMILY:.0e} for all)",
            ledger.looks()
        ),
        fails == 0.0,
    );
    let smallest = column(SMALLEST).fold(1.0, f64::min);
    // P(least of m p-values ≤ x) ≤ m x, under any dependence.
    let chance = (random * smallest).min(1.0);
    lab.number("smallest_p", smallest);
    lab.claim(
        "least p-value of all",
        format!(
            "{smallest:.2e} of {random} tests whose tail is valid at this scale, about {:.1e} expected; so small with probability at most {chance:.3}",
            1.0 / random
        ),
        chance >= level,
    );
    let undecided: f64 = column(3).sum();
    lab.note(
        "undecided",
        format!("{:.1} measures per seed at this scale", undecided / seeds),
    );
}

/// Each seed's least p-value against the quantile that independent tests would give it.
fn draw(lab: &mut Lab, ledger: &Ledger) -> Result<(), Error> {
    let mut least: Vec<f64> = ledger
        .rows()
        .iter()
        .map(|row| number(row, SMALLEST))
        .collect();
    least.sort_by(f64::total_cmp);
    let seeds = least.len() as f64;
    // How many tails are valid differs a little from seed to seed.
    let random = ledger
        .rows()
        .iter()
        .map(|row| number(row, RANDOM))
        .sum::<f64>()
        / seeds;
    let random = random.round().max(1.0);
    let expected = |i: usize| 1.0 - (1.0 - (i as f64 + 0.5) / seeds).powf(1.0 / random);
    let points = least
        .iter()
        .enumerate()
        .map(|(i, &p)| [expected(i), p])
        .collect();
    let low = 0.1 / (random * seeds);
    let diagonal = vec![[low, low], [0.1, 0.1]];
    charts(
        &lab.figure("false-alarms.svg"),
        "Points along the line: least p-values as independent tests of true hypotheses give.",
        [900, 560],
        &[Chart {
            title: format!("Least p-value of each of {seeds} suites of {random} random tests"),
            axes: [
                "expected of independent tests at this rank".into(),
                "least p-value observed".into(),
            ],
            ranges: [[low, 0.1], [low.min(0.5 * least[0]), 1.0]],
            log: [true, true],
            series: vec![
                Series::new("as expected", 6, Mark::Line, diagonal),
                Series::new("a suite under a fresh master seed", 2, Mark::Points, points),
            ],
        }],
    )
}
