//! The registry of trials as HTML: trials, faults, and the trace from equation to chapter.

use std::collections::BTreeMap;
use std::path::Path;

use records::results::Results;
use trials::{all, all_faults};
use whitefurnace::suggest::did_you_mean;

use crate::mathml::{escape, typeset};
use crate::trace::Sources;

/// Returns the table of all trials. `equation` returns an equation's number as a link; `recorded`
/// are the numbers that the experiment `trials` recorded.
pub fn trials(
    equation: impl Fn(&str) -> String,
    recorded: Option<&BTreeMap<String, f64>>,
) -> String {
    let rows: Vec<String> = all()
        .iter()
        .map(|trial| {
            let range = |what, format: fn(f64) -> String| {
                let of_outcomes = recorded.map(|numbers| outcome_range(numbers, &trial.name, what));
                match of_outcomes.flatten() {
                    None => "–".to_owned(),
                    Some([low, high]) if low == high => format(low),
                    Some([low, high]) => format!("{}<br>to {}", format(low), format(high)),
                }
            };
            let delta = range("delta", |delta| match delta {
                0.0 => "0".to_owned(),
                _ => escape(&format!("{delta:.1e}")),
            });
            let n = range("n", |n| n.to_string());
            let controls: Vec<_> = trial.controls.iter().map(|c| code(c.name)).collect();
            let (place, equation) = (trial_fragment(&trial.name), equation(trial.source));
            let (property, statistic) = (capitalized(&typeset(&trial.property)), escape(trial.statistic));
            let consequence = typeset(&trial.consequence);
            format!(
                "<tr id=\"{place}\"><td>{equation}</td><td>{property}.\
                 <div class=\"consequence\">If this fails: {consequence}.</div><div class=\"equation-source\">{}; \
                 controls {}</div></td><td>{statistic}</td><td>{n}</td><td class=\"nowrap\">{delta}</td></tr>",
                code(&trial.name),
                controls.join(", "),
            )
        })
        .collect();
    table(&["equation", "property", "statistic", "n", "δ"], &rows)
}

/// Returns the least and greatest recorded value of a number of a trial's outcomes; `None` if there
/// is none.
fn outcome_range(numbers: &BTreeMap<String, f64>, trial: &str, what: &str) -> Option<[f64; 2]> {
    // "trial.what", or "trial.outcome.what".
    let is_of = |key: &str| {
        let rest = key
            .strip_prefix(trial)
            .and_then(|rest| rest.strip_prefix('.'));
        rest.and_then(|rest| rest.strip_suffix(what))
            .is_some_and(|outcome| outcome.is_empty() || outcome.ends_with('.'))
    };
    numbers
        .iter()
        .filter(|(key, _)| is_of(key))
        .map(|(_, value)| *value)
        .fold(None, |range, value| match range {
            None => Some([value; 2]),
            Some([low, high]) => Some([value.min(low), value.max(high)]),
        })
}

/// Returns the name of a trial, checked against the registry.
pub fn trial(name: &str) -> Result<String, String> {
    let trials = all();
    if trials.iter().any(|trial| trial.name == name) {
        return Ok(code(name));
    }
    Err(format!(
        "no trial \"{name}\"{}",
        did_you_mean(name, trials.iter().map(|trial| &trial.name))
    ))
}

/// Returns the HTML id of a trial on the page that lists them.
pub fn trial_fragment(name: &str) -> String {
    format!("trial-{}", name.replace(['/', '.'], "-"))
}

/// Returns the table of faults: the error that each makes, and the trials that must reject it.
pub fn faults() -> String {
    let rows: Vec<String> = all_faults()
        .iter()
        .map(|fault| {
            let trials: Vec<_> = fault.rejected_by.iter().map(|trial| code(trial)).collect();
            let verb = if fault.equivalent {
                "accepted by"
            } else {
                "rejected by"
            };
            let name = code(&format!("{}: {}", fault.family, fault.name));
            row([
                &name,
                &typeset(fault.wrong),
                &format!("{verb}<br>{}", trials.join("<br>")),
            ])
        })
        .collect();
    table(&["fault", "what is wrong", "trials"], &rows)
}

/// Returns the matrix equation → code → trials and tests → experiments → chapter, from the project
/// in `sources` and the recorded `results`.
pub fn traceability(
    sources: &Path,
    results: &Results,
    equation: impl Fn(&str) -> String,
    experiment: impl Fn(&str) -> String,
) -> Result<String, String> {
    let read = Sources::read(sources)
        .map_err(|error| format!("cannot read the sources in {}: {error}", sources.display()))?;
    let lines = |items: &[String]| {
        if items.is_empty() {
            return "–".to_owned();
        }
        let items: Vec<_> = items.iter().map(|item| code(item)).collect();
        items.join("<br>")
    };
    let rows: Vec<String> = read
        .matrix(&all(), results)
        .iter()
        .map(|trace| {
            let judged: Vec<String> = trace.trials.iter().chain(&trace.tests).cloned().collect();
            let experiments: Vec<_> = trace.experiments.iter().map(|id| experiment(id)).collect();
            let [number, code] = [equation(trace.equation.id), lines(&trace.code)];
            row([&number, &code, &lines(&judged), &experiments.join(", ")])
        })
        .collect();
    Ok(table(
        &["chapter", "code", "trials and tests", "experiments"],
        &rows,
    ))
}

/// Returns a table row of cells that are HTML.
pub fn row<const N: usize>(cells: [&str; N]) -> String {
    format!("<tr><td>{}</td></tr>", cells.join("</td><td>"))
}

/// Returns a table of at most five columns, with rows that are HTML. Narrow windows show the cells
/// of a row below each other, each with its column's name.
pub fn table(columns: &[&str], rows: &[String]) -> String {
    let head: String = columns.iter().map(|c| format!("<th>{c}</th>")).collect();
    let names: String = (1..)
        .zip(columns)
        .map(|(i, c)| format!("--column-{i}:'{c}';"))
        .collect();
    format!(
        "<div class=\"table-wrapper\"><table class=\"registry\" style=\"{names}\"><thead><tr>{head}</tr></thead>\
         <tbody>{}</tbody></table></div>",
        rows.concat()
    )
}

/// Formats code, whose long names may break after signs.
pub fn code(text: &str) -> String {
    let text = ["/", "_", "::"].iter().fold(escape(text), |text, sign| {
        text.replace(sign, &format!("{sign}<wbr>"))
    });
    format!("<code>{text}</code>")
}

/// Returns the text with a capital first letter.
fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_those_of_a_trials_own_outcomes() {
        let numbers = [
            ("a/b.n", 7.0),
            ("a/c.red.n", 5.0),
            ("a/c.blue.n", 3.0),
            ("a/c.blue.delta", 9.0),
            ("a/c-long.red.n", 1.0),
        ];
        let numbers = numbers.map(|(key, value)| (key.to_owned(), value)).into();
        assert_eq!(outcome_range(&numbers, "a/b", "n"), Some([7.0; 2]));
        assert_eq!(outcome_range(&numbers, "a/c", "n"), Some([3.0, 5.0]));
        assert_eq!(outcome_range(&numbers, "a/c", "delta"), Some([9.0; 2]));
        assert_eq!(outcome_range(&numbers, "a/b", "delta"), None);
        // No name of a trial looks like another's with an outcome.
        let names: Vec<String> = all().into_iter().map(|trial| trial.name).collect();
        for [a, b] in names.iter().flat_map(|a| names.iter().map(move |b| [a, b])) {
            assert!(!b.starts_with(&format!("{a}.")), "{a} and {b}");
        }
    }
}
