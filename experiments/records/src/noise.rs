//! Numbers of a run beside those of the record, and the noise that both state.

use std::collections::BTreeMap;

use crate::results::ExperimentResult;

/// Number of standard errors that count as the half width of an interval.
pub const STANDARD_ERRORS: f64 = 5.0;

/// A number in the record and in a run.
pub struct NumberPair<'a> {
    /// Its name.
    pub key: &'a str,
    /// Its value in the record and in the run.
    pub values: [f64; 2],
    /// Half widths of the intervals, if both state one.
    pub halves: Option<[f64; 2]>,
}

impl NumberPair<'_> {
    /// Returns the difference of the values.
    pub fn distance(&self) -> f64 {
        (self.values[1] - self.values[0]).abs()
    }

    /// Returns true if the numbers differ beyond the noise that both state.
    pub fn differs(&self) -> bool {
        // Tolerance for rounding, where noise is zero.
        let rounding = 1e-12 * self.values[0].abs().max(self.values[1].abs());
        self.halves
            .is_some_and(|[a, b]| self.distance() > a.hypot(b) + rounding)
    }
}

/// Returns the half width of a number's interval, if the experiment states one.
pub fn half_width(numbers: &BTreeMap<String, f64>, key: &str) -> Option<f64> {
    let get = |name: String| numbers.get(&name).copied();
    let between =
        |stem: &str| Some(0.5 * (get(format!("{stem}.high"))? - get(format!("{stem}.low"))?).abs());
    // The interval of an estimate or a difference may be named after its subject.
    let stem = [".estimate", ".difference"]
        .iter()
        .find_map(|end| key.strip_suffix(end));
    get(format!("{key}.half"))
        .or_else(|| between(key))
        .or_else(|| stem.and_then(|stem| get(format!("{stem}.half"))))
        .or_else(|| stem.and_then(between))
        .or_else(|| get(format!("{key}_error")).map(|error| STANDARD_ERRORS * error))
        // A width of 0 means an exact number, or rounding.
        .filter(|half| *half > 0.0)
}

/// Returns true if both estimate the same quantity: of a trial with many measures each run records
/// the one closest to its limit, and their references tell them apart.
fn same_reference(both: [&ExperimentResult; 2], key: &str) -> bool {
    let Some(stem) = key.strip_suffix(".estimate") else {
        return true;
    };
    let [a, b] = both.map(|from| from.numbers.get(&format!("{stem}.reference")));
    a == b
}

/// Returns the numbers that the record and a run have both.
pub fn pairs<'a>(
    recorded: &'a ExperimentResult,
    ours: &'a ExperimentResult,
) -> Vec<NumberPair<'a>> {
    let both = recorded.numbers.iter().filter_map(|(key, &value)| {
        let own = *ours.numbers.get(key)?;
        let halves = half_width(&recorded.numbers, key).zip(half_width(&ours.numbers, key));
        let halves = halves.filter(|_| same_reference([recorded, ours], key));
        Some(NumberPair {
            key,
            values: [value, own],
            halves: halves.map(|(a, b)| [a, b]),
        })
    });
    both.collect()
}

/// Returns the numbers of a run that differ from the record beyond the noise that both state, a
/// line each.
pub fn beyond_noise(recorded: &ExperimentResult, ours: &ExperimentResult) -> Vec<String> {
    let beyond = pairs(recorded, ours)
        .into_iter()
        .filter(NumberPair::differs);
    let line = |pair: NumberPair<'_>| {
        let ([theirs, own], noise) = (pair.values, pair.halves.map_or(0.0, |[a, b]| a.hypot(b)));
        format!(
            "{}.{}: {own:.6e}, recorded {theirs:.6e}, apart by more than {noise:.1e}",
            ours.id, pair.key
        )
    };
    beyond.map(line).collect()
}
