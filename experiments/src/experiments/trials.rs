//! The verdict table: every trial of the registry, by equation.

use std::collections::BTreeMap;

use whitefurnace::equation::Equation;

use crate::experiments::prelude::*;
use crate::plot::forest::{Line, forest};
use crate::run::{ExperimentResult, record};

pub(super) const TRIALS: Experiment = Experiment {
    id: "trials",
    title: "the verdicts: every equation and claim on trial",
    headline: "every equation and claim on trial: {holds} findings hold, {fails} fail, {undecided} undecided",
    version: 2,
    equations: &[],
    run,
};

/// Largest number of lines that fit on one figure.
const LINES_PER_FIGURE: usize = 45;

/// Name of the intervals in the figures.
const INTERVAL: &str = "interval at level 1 − 10⁻⁹";

fn run(run: &mut Run) -> Result<(), Error> {
    let mut trials = trials::all();
    trials.sort_by_key(|trial| {
        equation::ALL
            .iter()
            .position(|equation| equation.id == trial.source)
    });
    run.add_equations_of(&trials);
    let (scale, found) = (suite::scale(run), suite::rows(run, &trials)?);
    let all: Vec<String> = found.iter().flatten().map(Row::csv).collect();
    run.csv("trials.csv", CSV_HEADER, &all)?;
    let figures = draw(run, &trials, &found)?;
    let recorded = record::result(&record::recorded_folder().join(TRIALS.id));
    for equation in equation::ALL {
        let rows: Vec<_> = trials
            .iter()
            .zip(&found)
            .filter(|(trial, _)| trial.source == equation.id)
            .collect();
        summarise(run, equation, &rows);
        for (trial, rows) in rows {
            report(
                run,
                trial,
                rows,
                &figures[group(&trial.name)],
                recorded.as_ref(),
            );
        }
    }
    totals(run, &found, scale);
    Ok(())
}

/// Adds a line for an equation: the joint verdict of its trials.
fn summarise(run: &mut Run, equation: &Equation, trials: &[(&Trial, &Vec<Row>)]) {
    let what = match equation.number {
        "" => equation.title.to_owned(),
        number => format!("({number}) {}", equation.title),
    };
    if trials.is_empty() {
        run.note(&what, "no trial of its own".to_owned());
        return;
    }
    let verdict = suite::joint_verdict(trials.iter().flat_map(|(_, rows)| rows.iter()));
    let names: usize = trials.iter().map(|(_, rows)| rows.len()).sum();
    run.claim(
        &what,
        format!("trials {}, measures {names}", trials.len()),
        verdict,
    );
}

/// Adds a line for a trial: the measure closest to its limit.
fn report(
    run: &mut Run,
    trial: &Trial,
    rows: &[Row],
    figure: &str,
    recorded: Option<&ExperimentResult>,
) {
    let Some(row) = rows
        .iter()
        .max_by(|a, b| interval_extent(a).total_cmp(&interval_extent(b)))
    else {
        return;
    };
    let verdict = suite::joint_verdict(rows);
    let o = &row.outcome;
    let (Outcome { n, p, .. }, detects, power) = (o, o.minimum_detectable_effect(), o.power());
    let numbers = format!("detects {detects:.2e}, power {power}, n = {n}, p = {p:.2e}");
    let mut value = format!("{}: {}, {numbers}, {figure}", trial.property, evidence(row));
    if let Verdict::Undecided { needed } = verdict {
        value += &format!(
            "; needs about {needed}{}",
            recorded_verdict(recorded, &trial.name)
        );
    }
    run.detail(&trial.name, value, verdict);
    for (key, o) in recorded_outcomes(&trial.name, rows) {
        let (delta, [low, high]) = (o.claim.size(), o.interval);
        run.numbers(&key, [("estimate", o.estimate), ("delta", delta)]);
        run.number(&format!("{key}.n"), o.n as f64);
        if key == trial.name {
            run.numbers(
                &key,
                [("reference", o.reference), ("low", low), ("high", high)],
            );
        }
    }
}

/// Returns the outcomes with an effect size, whose numbers are recorded, with their keys: the name
/// of the trial if it has only one, so that the key means the same outcome in every run; else
/// "trial: outcome".
fn recorded_outcomes<'a>(trial: &str, rows: &'a [Row]) -> Vec<(String, &'a Outcome)> {
    let sized: Vec<&Outcome> = rows
        .iter()
        .map(|row| &row.outcome)
        .filter(|outcome| outcome.claim != Claim::Test)
        .collect();
    let key = |outcome: &Outcome| match sized.len() {
        1 => trial.to_owned(),
        _ => format!("{trial}: {}", outcome.name),
    };
    sized
        .iter()
        .map(|outcome| (key(outcome), *outcome))
        .collect()
}

/// Formats evidence as in "mean of z 0.50002 in [0.49990, 0.50013], should be 0.5 ± 0.002".
fn evidence(row: &Row) -> String {
    let o = &row.outcome;
    if !o.is_random() {
        return format!(
            "{} {:.2e}, at most {:.1e}",
            o.name,
            o.estimate,
            o.claim.size()
        );
    }
    if o.claim == Claim::Test {
        return format!("{} {:.4e}", o.name, o.value);
    }
    let (
        Outcome {
            name,
            estimate,
            interval: [low, high],
            reference,
            ..
        },
        delta,
    ) = (o, o.claim.size());
    format!("{name} {estimate:.6} in [{low:.6}, {high:.6}], should be {reference:.6} ± {delta:.1e}")
}

/// Returns the largest distance of the interval's ends from the reference, in units of δ.
fn interval_extent(row: &Row) -> f64 {
    let o = &row.outcome;
    let far = o.interval.map(|end| (end - o.reference).abs());
    match o.claim {
        Claim::Test => -o.p,
        claim => far[0].max(far[1]) / claim.size(),
    }
}

/// Records the counts of verdicts, and the level at which they were made.
fn totals(run: &mut Run, found: &[Vec<Row>], scale: f64) {
    let rows: Vec<&Row> = found.iter().flatten().collect();
    let count = |word: &str| rows.iter().filter(|row| row.verdict.word() == word).count();
    for word in ["holds", "fails", "undecided"] {
        run.number(word, count(word) as f64);
    }
    run.number("trials", found.len() as f64);
    run.number("scale", scale);
    let smallest = rows
        .iter()
        .filter(|row| row.outcome.is_random())
        .map(|row| row.outcome.p)
        .fold(1.0, f64::min);
    run.number("smallest_p", smallest);
    let (trials, [holds, fails, undecided]) =
        (found.len(), ["holds", "fails", "undecided"].map(count));
    let value = format!(
        "{trials} trials at scale {scale}: {holds} measures hold, {fails} fail, {undecided} undecided; smallest p \
         {smallest:.1e}; family-wise level {:.0e} ({ALPHA:.0e} for each of at most {CAPACITY})",
        ALPHA * CAPACITY as f64,
    );
    run.note("in all", value);
}

/// Draws the figures of each group of trials and returns the first one's name, by group.
fn draw(
    run: &mut Run,
    trials: &[Trial],
    found: &[Vec<Row>],
) -> Result<BTreeMap<String, String>, Error> {
    let mut lines: BTreeMap<String, Vec<Line>> = BTreeMap::new();
    for (trial, rows) in trials.iter().zip(found) {
        let group = group(&trial.name);
        lines
            .entry(group.to_owned())
            .or_default()
            .extend(rows.iter().filter_map(|row| line(trial, group, row)));
    }
    let mut figures = BTreeMap::new();
    for (group, lines) in lines {
        for (i, part) in lines.chunks(LINES_PER_FIGURE).enumerate() {
            let file = if i == 0 {
                format!("{group}.svg")
            } else {
                format!("{group}-{}.svg", i + 1)
            };
            let title = format!("Trials of the group “{group}”, scale {}", suite::scale(run));
            let description = "Zero is the reference. An interval within the band about it holds.";
            forest(&run.figure(&file), &title, description, INTERVAL, part)?;
            figures.entry(group.clone()).or_insert(file);
        }
        figures
            .entry(group)
            .or_insert_with(|| "no figure".to_owned());
    }
    Ok(figures)
}

/// Converts a row to units of its δ; `None` where no effect size is claimed.
fn line(trial: &Trial, group: &str, row: &Row) -> Option<Line> {
    let o = &row.outcome;
    if o.claim == Claim::Test || o.claim.size() <= 0.0 {
        return None;
    }
    let short = trial.name.strip_prefix(group).unwrap_or(&trial.name);
    let number = equation::by_id(trial.source).map_or("", |equation| equation.number);
    let number = if number.is_empty() {
        String::new()
    } else {
        format!("({number}) ")
    };
    Some(Line::of(
        format!("{number}{}: {}", short.trim_start_matches('/'), o.name),
        row,
    ))
}

/// Returns the verdict of the last recorded full run on a trial, as a clause.
fn recorded_verdict(recorded: Option<&ExperimentResult>, what: &str) -> String {
    let recorded = recorded.filter(|recorded| recorded.version == TRIALS.version);
    let verdict = recorded.and_then(|recorded| {
        let mut findings = recorded.findings.iter();
        let verdict = findings.find(|finding| finding.what == what)?.verdict?;
        Some(format!(
            " [{} in the recorded {} run]",
            verdict.word(),
            recorded.tier
        ))
    });
    verdict.unwrap_or_else(|| " [not recorded]".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A key belongs to one outcome, whichever of a trial's is nearest to its limit.
    #[test]
    fn numbers_are_recorded_by_outcome() {
        let row = |name: &str, claim| Row {
            trial: "family/trial".to_owned(),
            control: String::new(),
            property: String::new(),
            source: "",
            verdict: Verdict::Holds,
            seed: 1,
            outcome: Outcome {
                claim,
                ..Outcome::identity(name, 1, 0.0, 1.0, "")
            },
        };
        let equal = Claim::Equal { delta: 1.0 };
        let keys = |rows: &[Row]| -> Vec<String> {
            let recorded = recorded_outcomes("family/trial", rows);
            recorded.into_iter().map(|(key, _)| key).collect()
        };
        let [mean, tiles, red] = [("mean", equal), ("tiles", Claim::Test), ("red", equal)]
            .map(|(name, claim)| row(name, claim));
        assert_eq!(keys(&[mean.clone(), tiles.clone()]), ["family/trial"]);
        assert_eq!(
            keys(&[red, tiles, mean]),
            ["family/trial: red", "family/trial: mean"]
        );
    }
}
