//! The default run as a whole: its duration, and its numbers compared with the record.

use std::collections::BTreeMap;

use records::noise::beyond_noise;
use records::results::DEFAULT_RUN;
use whitefurnace::error::Error;
use whitefurnace::math::moments::Moments;

use crate::render::name;
use crate::run::record::{RunResults, recorded_folder, result, update_readme, write_json};
use crate::run::{ExperimentResult, Judgement, Options, read_json};

/// File with every number of the recorded runs, a list each: their spread is the noise of numbers
/// that state none.
const NUMBERS: &str = "numbers.json";
/// Largest distance of a run from the mean of the recorded runs, in their standard deviations.
const MAX_DISTANCE: f64 = 10.0;
/// Relative tolerance of numbers without noise, since mathematical functions of platforms round
/// differently.
const RELATIVE_TOLERANCE: f64 = 1e-6;

/// Numbers of several runs, by experiment and name.
type NumbersByKey = BTreeMap<String, Vec<f64>>;

/// Returns times and counts of a whole default run; an error if a part of it was kept from an
/// earlier run, which has no time.
fn timings(ran: &RunResults, options: &Options) -> Result<ExperimentResult, Error> {
    let Some(seconds) = ran.seconds.iter().copied().collect::<Option<Vec<f64>>>() else {
        return Err(Error::Option(
            "the time of a whole run is recorded: add --fresh".to_owned(),
        ));
    };
    let findings = || ran.results.iter().flat_map(|result| &result.findings);
    let count = |verdict| {
        findings()
            .filter(|row| row.verdict == Some(verdict))
            .count() as f64
    };
    let mut numbers = BTreeMap::from([
        ("seconds".to_owned(), seconds.iter().sum()),
        ("threads".to_owned(), rayon::current_num_threads() as f64),
        ("experiments".to_owned(), seconds.len() as f64),
        ("holds".to_owned(), count(Judgement::Holds)),
        ("undecided".to_owned(), count(Judgement::Undecided)),
    ]);
    let each = ran.results.iter().zip(&seconds);
    numbers.extend(each.map(|(result, seconds)| (format!("{}.seconds", result.id), *seconds)));
    Ok(ExperimentResult {
        id: DEFAULT_RUN.to_owned(),
        title: "the default run: how long it takes, and its claims".to_owned(),
        version: 1,
        tier: name(options.tier),
        seed: options.seed,
        shrink: options.shrink,
        command: "cargo run --release -- --fresh".to_owned(),
        numbers,
        ..ExperimentResult::default()
    })
}

/// Records a default run: a run with the default seed starts the record anew, a run with another
/// seed adds its numbers.
///
/// # Errors
/// A part of the first was kept from an earlier run, which has no time; a file cannot be read or
/// written.
pub fn record(ran: &RunResults, options: &Options) -> Result<(), Error> {
    let folder = recorded_folder().join(DEFAULT_RUN);
    let is_first = options.seed == 1;
    if is_first {
        std::fs::create_dir_all(&folder).map_err(Error::file("create", &folder))?;
        write_json(&folder.join("result.json"), &timings(ran, options)?)?;
    }
    let mut numbers: NumbersByKey = if is_first {
        NumbersByKey::new()
    } else {
        read_json(&folder.join(NUMBERS))?
    };
    for (key, value) in numbers_by_key(&ran.results) {
        numbers.entry(key).or_default().push(value);
    }
    write_json(&folder.join(NUMBERS), &numbers)?;
    update_readme()
}

/// Returns the numbers of a run, by experiment and name.
fn numbers_by_key(results: &[ExperimentResult]) -> impl Iterator<Item = (String, f64)> {
    let named = |result: &ExperimentResult| {
        let id = result.id.clone();
        result
            .numbers
            .clone()
            .into_iter()
            .map(move |(key, value)| (format!("{id}.{key}"), value))
    };
    results.iter().flat_map(named)
}

/// Comparison of a run's numbers with the record.
pub struct RecordComparison {
    /// Number of compared numbers.
    pub compared: usize,
    /// Numbers that differ beyond noise, a line each.
    pub beyond: Vec<String>,
}

/// Compares the numbers of a default run with the recorded default runs, and where both state their
/// noise with the recorded full run.
///
/// # Errors
/// There is no record.
pub fn compare_with_record(results: &[ExperimentResult]) -> Result<RecordComparison, Error> {
    let recorded: NumbersByKey = read_json(&recorded_folder().join(DEFAULT_RUN).join(NUMBERS))?;
    let ours: BTreeMap<String, f64> = numbers_by_key(results).collect();
    let mut beyond = Vec::new();
    for (key, values) in &recorded {
        match ours.get(key) {
            Some(&value) if is_near(values, value) => {}
            Some(value) => beyond.push(format!(
                "{key}: {value:.6e}, in recorded default runs {values:.6?}"
            )),
            None => beyond.push(format!("{key}: is no longer there")),
        }
    }
    beyond.extend(
        ours.keys()
            .filter(|key| !recorded.contains_key(*key))
            .map(|key| format!("{key}: is not recorded")),
    );
    for ours in results {
        match result(&recorded_folder().join(&ours.id)) {
            Some(recorded) => beyond.extend(beyond_noise(&recorded, ours)),
            None => beyond.push(format!("{}: there is no record of it", ours.id)),
        }
    }
    Ok(RecordComparison {
        compared: ours.len(),
        beyond,
    })
}

/// Returns true if a value is as close to the mean of the others as their spread predicts.
fn is_near(others: &[f64], value: f64) -> bool {
    let others: Moments = others.iter().copied().collect();
    // A single value gives no estimate of the noise.
    let variance = if others.count() > 1 {
        others.variance()
    } else {
        0.0
    };
    let spread = (variance * (1.0 + 1.0 / others.count() as f64)).sqrt();
    (value - others.mean()).abs()
        <= MAX_DISTANCE * spread + RELATIVE_TOLERANCE * others.mean().abs().max(value.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_near_by_their_spread_or_exactly() {
        assert!(
            is_near(&[1.0, 1.1, 0.9], 1.5)
                && !is_near(&[1.0, 1.1, 0.9], -1.0)
                && !is_near(&[1.0, 1.1, 0.9], 3.0)
        );
        assert!(is_near(&[9.0, 9.0, 9.0], 9.0) && !is_near(&[9.0, 9.0, 9.0], 8.0));
        assert!(is_near(&[0.5], 0.5 + 1e-8) && !is_near(&[0.5], 0.501));
    }
}
