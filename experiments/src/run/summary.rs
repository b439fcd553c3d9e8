//! Formats the summary that a run prints of each experiment, and its verdicts.

use std::fmt::Write as _;
use std::path::Path;

use records::number;

use crate::run::{Experiment, ExperimentResult, Judgement};

/// Longest line of a summary, characters.
pub const LINE_WIDTH: usize = 100;
/// Largest number of undecided claims that are named.
const MAX_NAMED_CLAIMS: usize = 5;

/// Counts the findings of an experiment with this verdict.
fn count(outcome: &ExperimentResult, verdict: Judgement) -> usize {
    outcome
        .findings
        .iter()
        .filter(|row| row.verdict == Some(verdict))
        .count()
}

/// Returns the experiment's headline with the numbers of this run.
///
/// # Errors
/// A key that the run did not record, or a format that does not fit the number.
pub fn headline(template: &str, outcome: &ExperimentResult) -> Result<String, String> {
    let mut pieces = template.split('{');
    let mut text = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let (field, after) = piece
            .split_once('}')
            .ok_or_else(|| format!("\"{{{piece}\" has no end"))?;
        text += &match field {
            "holds" => count(outcome, Judgement::Holds).to_string(),
            "fails" => count(outcome, Judgement::Fails).to_string(),
            "undecided" => count(outcome, Judgement::Undecided).to_string(),
            _ => {
                let (key, format) = field
                    .split_once(' ')
                    .map_or((field, None), |(key, format)| (key, Some(format)));
                let value = outcome
                    .numbers
                    .get(key)
                    .ok_or_else(|| format!("{} has no number {key}", outcome.id))?;
                number::format(*value, format)?
            }
        };
        text += after;
    }
    Ok(text)
}

/// Returns a sentence on the finding and the path of its picture, wrapped at [`LINE_WIDTH`];
/// `label` names the experiment and its duration.
pub fn summary(
    experiment: &Experiment,
    outcome: &ExperimentResult,
    label: &str,
    out: &Path,
) -> String {
    // A shrunk run may lack a number that was not finite.
    let found =
        headline(experiment.headline, outcome).unwrap_or_else(|_| experiment.title.to_owned());
    let picture = outcome
        .figures
        .first()
        .map(|file| out.join(experiment.id).join(file).display().to_string());
    let fails = match count(outcome, Judgement::Fails) {
        0 => String::new(),
        fails => format!(" ({fails} FAIL)"),
    };
    let words = format!("{label}: {found}{fails}");
    let words = words.split(' ').chain(picture.as_deref());
    let mut text = String::new();
    let mut column = 0;
    for word in words {
        let length = word.chars().count();
        if column > 0 && column + 1 + length > LINE_WIDTH {
            text += "\n     ";
            column = 5;
        } else if column > 0 {
            text.push(' ');
            column += 1;
        }
        text += word;
        column += length;
    }
    text
}

/// Returns the lines of claims that fail or, if they are few, are undecided, each cut at
/// [`LINE_WIDTH`]; then the counts. The second value is true if nothing fails.
pub fn verdicts(outcomes: &[ExperimentResult]) -> (String, bool) {
    let named = |wanted: Judgement| -> Vec<String> {
        let of = |outcome: &ExperimentResult| -> Vec<String> {
            let rows = outcome
                .findings
                .iter()
                .filter(|row| row.verdict == Some(wanted));
            rows.map(|row| format!("{}: {}: {}", outcome.id, row.what, row.value))
                .collect()
        };
        outcomes.iter().flat_map(of).collect()
    };
    let [fails, undecided] = [Judgement::Fails, Judgement::Undecided].map(named);
    let holds: usize = outcomes
        .iter()
        .map(|outcome| count(outcome, Judgement::Holds))
        .sum();
    let mut text = String::new();
    for line in &fails {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "FAILS: {line}");
    }
    for line in undecided.iter().take(MAX_NAMED_CLAIMS) {
        let line = format!("undecided: {line}");
        let cut: String = line.chars().take(LINE_WIDTH - 1).collect();
        let _ = writeln!(
            text,
            "{cut}{}",
            if cut.len() < line.len() { "…" } else { "" }
        );
    }
    let more = undecided.len().saturating_sub(MAX_NAMED_CLAIMS);
    if more > 0 {
        let _ = writeln!(text, "and {more} more undecided, in results.json");
    }
    let _ = write!(
        text,
        "{holds} hold, {} fail, {} undecided at this tier",
        fails.len(),
        undecided.len()
    );
    if outcomes.iter().any(|outcome| outcome.shrink != 1) {
        text += "; nothing is judged in a run with --shrink";
    }
    (text, fails.is_empty())
}
