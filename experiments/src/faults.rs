//! Which trials see which faults.

use whitefurnace::error::Error;
use whitefurnace::harness::outcome::Verdict;
use whitefurnace::harness::trial::{Context, Row, group, run_control};
use whitefurnace::trials;

use crate::lab::{Experiment, Lab};
use crate::plot::matrix::{Seen, matrix};
use crate::suite::{self, parallel};

/// Runs every pair of a fault and a trial that fit together.
pub const FAULTS: Experiment = Experiment {
    id: "faults",
    title: "fault × trial: which trials reject which faults",
    version: 1,
    equations: &[],
    run,
};

/// A trial on a faulty subject.
type RunFault = Box<dyn Fn(&Context) -> Vec<Row> + Send + Sync>;

/// A fault inside a trial.
struct Pair {
    /// The row of the matrix.
    fault: String,
    /// What is wrong.
    wrong: String,
    /// The column.
    trial: String,
    /// Whether the trial is the one that must reject it.
    named: bool,
    /// The trial on the faulty subject.
    run: RunFault,
}

/// Every pair that is tried: here each trial with its own negative controls.
fn pairs() -> Vec<Pair> {
    let mut pairs = Vec::new();
    for trial in trials::all() {
        let trial = std::sync::Arc::new(trial);
        for index in 0..trial.controls.len() {
            let (control, shared) = (&trial.controls[index], trial.clone());
            pairs.push(Pair {
                fault: format!("{}: {}", group(&trial.name), control.name),
                wrong: control.wrong.to_owned(),
                trial: trial.name.clone(),
                named: true,
                run: Box::new(move |context| {
                    run_control(&shared, &shared.controls[index], context)
                }),
            });
        }
    }
    pairs
}

fn run(lab: &mut Lab) -> Result<(), Error> {
    let trials = trials::all();
    lab.bears_on(suite::equations(&trials));
    let pairs = pairs();
    let scale = lab.scale(lab.by_tier(suite::REDUCED, 1.0));
    let context = Context::new(lab.seed(), scale)?;
    let seen = parallel(&pairs, |pair| judge(&(pair.run)(&context)))?;
    let table: Vec<String> = pairs
        .iter()
        .zip(&seen)
        .map(|(pair, seen)| {
            let wrong = pair.wrong.replace('"', "'");
            format!("{},{},{},\"{wrong}\"", pair.fault, pair.trial, word(*seen))
        })
        .collect();
    lab.csv("faults.csv", "fault,trial,verdict,wrong", &table)?;
    draw(lab, &pairs, &seen)?;
    for (pair, seen) in pairs.iter().zip(&seen) {
        if pair.named && *seen == Seen::Missed {
            lab.claim(
                &format!("{} in {}", pair.fault, pair.trial),
                "not rejected".to_owned(),
                false,
            );
        }
    }
    totals(lab, &pairs, &seen, scale);
    Ok(())
}

/// Rejected if any outcome fails; a fault that every outcome lets through is missed.
fn judge(rows: &[Row]) -> Seen {
    let any = |wanted: fn(Verdict) -> bool| rows.iter().any(|row| wanted(row.verdict));
    if any(|verdict| verdict == Verdict::Fails) {
        Seen::Rejected
    } else if any(|verdict| matches!(verdict, Verdict::Undecided { .. })) {
        Seen::Undecided
    } else {
        Seen::Missed
    }
}

fn word(seen: Seen) -> &'static str {
    match seen {
        Seen::Rejected => "rejected",
        Seen::Missed => "not rejected",
        Seen::Undecided => "undecided",
    }
}

fn totals(lab: &mut Lab, pairs: &[Pair], seen: &[Seen], scale: f64) {
    let mut counts = Vec::new();
    for kind in [Seen::Rejected, Seen::Missed, Seen::Undecided] {
        let count = seen.iter().filter(|&&s| s == kind).count();
        lab.number(&word(kind).replace(' ', "_"), count as f64);
        counts.push(format!("{count} {}", word(kind)));
    }
    lab.number("pairs", pairs.len() as f64);
    let named = || pairs.iter().zip(seen).filter(|(pair, _)| pair.named);
    let missed = named().filter(|(_, seen)| **seen == Seen::Missed).count();
    let value = format!(
        "{} pairs at scale {scale}: {}; a correct build misses a named fault with probability at most \
         1e-9 each, 1e-6 in all, at scale 1",
        pairs.len(),
        counts.join(", ")
    );
    if scale >= 1.0 || missed > 0 {
        let rejected = named().all(|(_, seen)| *seen == Seen::Rejected);
        lab.claim("every fault is rejected by its trial", value, rejected);
    } else {
        lab.note("faults rejected by their trials", value);
    }
}

fn draw(lab: &mut Lab, pairs: &[Pair], seen: &[Seen]) -> Result<(), Error> {
    let unique = |names: Vec<&String>| {
        let mut found: Vec<String> = Vec::new();
        for name in names {
            if !found.contains(name) {
                found.push(name.clone());
            }
        }
        found
    };
    let rows = unique(pairs.iter().map(|pair| &pair.fault).collect());
    let columns = unique(pairs.iter().map(|pair| &pair.trial).collect());
    matrix(&lab.figure("faults.svg"), &rows, &columns, |row, column| {
        let fits = |pair: &Pair| pair.fault == rows[row] && pair.trial == columns[column];
        pairs.iter().position(fits).map(|i| seen[i])
    })
}
