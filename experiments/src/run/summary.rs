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
fn count(result: &ExperimentResult, verdict: Judgement) -> usize {
    result
        .findings
        .iter()
        .filter(|row| row.verdict == Some(verdict))
        .count()
}

/// Returns the experiment's headline with the numbers of this run.
///
/// # Errors
/// A key that the run did not record, or a format that does not fit the number.
pub fn headline(template: &str, result: &ExperimentResult) -> Result<String, String> {
    let mut pieces = template.split('{');
    let mut text = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let (field, after) = piece
            .split_once('}')
            .ok_or_else(|| format!("\"{{{piece}\" has no end"))?;
        text += &match field {
            "holds" => count(result, Judgement::Holds).to_string(),
            "fails" => count(result, Judgement::Fails).to_string(),
            "undecided" => count(result, Judgement::Undecided).to_string(),
            _ => {
                let (key, format) = field
                    .split_once(' ')
                    .map_or((field, None), |(key, format)| (key, Some(format)));
                let value = result
                    .numbers
                    .get(key)
                    .ok_or_else(|| format!("{} has no number {key}", result.id))?;
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
    result: &ExperimentResult,
    label: &str,
    out: &Path,
) -> String {
    // A shrunk run may lack a number that was not finite.
    let found =
        headline(experiment.headline, result).unwrap_or_else(|_| experiment.title.to_owned());
    let picture = result
        .figures
        .first()
        .map(|file| out.join(experiment.id).join(file).display().to_string());
    let fails = match count(result, Judgement::Fails) {
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
pub fn verdicts(results: &[ExperimentResult]) -> (String, bool) {
    let named = |wanted: Judgement| -> Vec<String> {
        let of = |result: &ExperimentResult| -> Vec<String> {
            let rows = result
                .findings
                .iter()
                .filter(|row| row.verdict == Some(wanted));
            rows.map(|row| format!("{}: {}: {}", result.id, row.what, row.value))
                .collect()
        };
        results.iter().flat_map(of).collect()
    };
    let [fails, undecided] = [Judgement::Fails, Judgement::Undecided].map(named);
    let holds: usize = results
        .iter()
        .map(|result| count(result, Judgement::Holds))
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
    if results.iter().any(|result| result.shrink != 1) {
        text += "; nothing is judged in a run with --shrink";
    }
    (text, fails.is_empty())
}
