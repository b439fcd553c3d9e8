//! Checks of trials: which are green, and for the red ones a message to act on.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::{Context, NegativeControl, Row, Trial, full_name, reject_control, rows, run_trial};
use crate::equation;
use crate::error::Error;
use crate::harness::guard;
use crate::harness::outcome::{Outcome, Verdict};

/// Returns whether a trial's rows are green: every outcome holds; *undecided* is green below scale
/// 1 only.
pub fn trial_is_green(rows: &[Row], context: &Context) -> bool {
    !rows.is_empty()
        && rows.iter().all(|row| match row.verdict {
            Verdict::Holds => true,
            Verdict::Fails => false,
            Verdict::Undecided { .. } => context.scale < 1.0,
        })
}

/// Returns the outcomes that must reject a control: those that it names or, where it names none,
/// the only random one or, where nothing is random, all of them. Empty if a name has no outcome, or
/// the choice is ambiguous.
pub fn required_outcomes<'a>(
    rejected_by: &[&str],
    outcomes: impl IntoIterator<Item = &'a Outcome>,
) -> Vec<&'a Outcome> {
    let all: Vec<&Outcome> = outcomes.into_iter().collect();
    if !rejected_by.is_empty() {
        let find = |name: &&str| all.iter().copied().find(|outcome| outcome.name == **name);
        let found: Option<Vec<_>> = rejected_by.iter().map(find).collect();
        return found.unwrap_or_default();
    }
    let random: Vec<_> = all.iter().copied().filter(|o| o.is_random()).collect();
    match random.len() {
        0 => all,
        1 => random,
        _ => Vec::new(),
    }
}

/// Returns whether a control is rejected for the reason that it states: every outcome that is
/// [`required_outcomes`] fails, and not for a NaN or an infinite estimate. Below scale 1
/// *undecided* is enough.
pub fn control_is_green(control: &NegativeControl, rows: &[Row], context: &Context) -> bool {
    let required = required_outcomes(&control.rejected_by, rows.iter().map(|row| &row.outcome));
    !required.is_empty()
        && required.iter().all(|outcome| match outcome.verdict() {
            Verdict::Fails => outcome.p.is_finite() && outcome.estimate.is_finite(),
            Verdict::Undecided { .. } => context.scale < 1.0,
            Verdict::Holds => false,
        })
}

/// Checks a trial and all of its controls. The error is a message to act on, one paragraph for the
/// trial and each control that is red; data files are written to the context's folder.
///
/// # Errors
/// The message, if anything is red.
pub fn check(trial: &Trial, context: &Context) -> Result<Vec<Row>, String> {
    let found = check_subject(trial, context);
    let message: String = trial
        .controls
        .iter()
        .filter_map(|control| check_control(trial, control, context).err())
        .collect();
    match found {
        Ok(rows) if message.is_empty() => Ok(rows),
        Ok(_) => Err(message),
        Err(first) => Err(first + &message),
    }
}

/// Checks a trial on its correct subject alone.
///
/// # Errors
/// The message, if it is red.
pub fn check_subject(trial: &Trial, context: &Context) -> Result<Vec<Row>, String> {
    let mut message = String::new();
    let found = run_trial(trial, context);
    if !trial_is_green(&found, context) {
        message += &explain(trial, &found, context);
    }
    // Below scale 1 effects of that size need not be detected.
    for row in found.iter().filter(|_| context.scale >= 1.0) {
        for graded in &row.outcome.graded {
            if !graded.has_required_verdict() {
                let _ = writeln!(
                    message,
                    "{}: {} says {} (p = {:.3e}) where the value is off by {:.3e}, the size of its \
                     claim: n or δ is wrong",
                    row.trial,
                    row.outcome.name,
                    graded.outcome.verdict().word(),
                    graded.outcome.p,
                    graded.effect
                );
            }
        }
    }
    message += &power_objections(&trial.name, found.iter().map(|row| &row.outcome), context);
    if message.is_empty() {
        Ok(found)
    } else {
        Err(message)
    }
}

/// Returns the [`guard`]'s objections to outcomes that are to hold, a line each; empty where sizes
/// are not [judged](Context::guard_applies).
pub fn power_objections<'a>(
    name: &str,
    outcomes: impl IntoIterator<Item = &'a Outcome>,
    context: &Context,
) -> String {
    outcomes
        .into_iter()
        .filter(|_| context.guard_applies())
        .filter_map(guard::power_objection)
        .map(|why| format!("{name}: too small for the error budget: {why}\n"))
        .collect()
}

/// Checks a trial on one of its faulty subjects.
///
/// # Errors
/// The message, if the fault is not rejected.
pub fn check_control(
    trial: &Trial,
    control: &NegativeControl,
    context: &Context,
) -> Result<Vec<Row>, String> {
    let found = reject_control(trial, control, context);
    let share = found.share;
    let rows = rows(trial, control.name, found.outcomes, context);
    if control_is_green(control, &rows, context) {
        let outcomes = rows.iter().map(|row| &row.outcome);
        let objections = required_outcomes(&control.rejected_by, outcomes)
            .into_iter()
            .filter_map(|outcome| guard::fault_objection(outcome, share));
        let message: String = objections
            .filter(|_| context.guard_applies())
            .map(|why| {
                let name = full_name(&trial.name, control.name);
                format!("{name}: too small for the error budget: {why}\n")
            })
            .collect();
        return if message.is_empty() {
            Ok(rows)
        } else {
            Err(message)
        };
    }
    let required_names = match control.rejected_by.as_slice() {
        [] => String::from("the trial's only random outcome (where there are several, name which)"),
        names => names.join(", "),
    };
    Err(format!(
        "{}: the negative control {} was not rejected\n  what is wrong with it: {}\n  to be rejected, \
         with finite numbers, by: {required_names}\n{}",
        trial.name,
        control.name,
        control.wrong,
        explain(trial, &rows, context)
    ))
}

/// Returns all that a reader needs in order to act on a verdict.
fn explain(trial: &Trial, rows: &[Row], context: &Context) -> String {
    let mut text = String::new();
    let source = equation::by_id(trial.source).map_or_else(
        || trial.source.to_owned(),
        |known| format!("{} ({}), {}", known.id, known.number, known.title),
    );
    for row in rows
        .iter()
        .filter(|row| row.verdict != Verdict::Holds || !row.control.is_empty())
    {
        let o = &row.outcome;
        let verdict = match row.verdict {
            Verdict::Undecided { needed } => format!("undecided, needs about {needed} samples"),
            other => other.word().to_owned(),
        };
        let _ = writeln!(
            text,
            "{}: {verdict}\n  property   {}\n  if this fails: {}\n  source     {}\n  subject    {}\n  \
             statistic  {} of {}: {:.6}, n = {}, p = {:.3e}\n  estimate   {:.9} in [{:.9}, {:.9}], \
             should be {:.9} ± {:.3e}\n  power      {} at that size, detects {:.3e}\n  worst      {}\n  repeat     {}",
            row.trial,
            trial.property,
            trial.consequence,
            source,
            trial.subject,
            o.statistic,
            o.name,
            o.value,
            o.n,
            o.p,
            o.estimate,
            o.interval[0],
            o.interval[1],
            o.reference,
            o.claim.size(),
            o.power(),
            o.minimum_detectable_effect(),
            o.worst,
            command(context, &row.trial, &row.control),
        );
        let name = format!("{} {}", row.trial, row.control);
        text += &data_file(write_cells(&name, o, &context.folder));
    }
    text
}

/// Returns the shell command that repeats this trial, or this control of it, alone: by the name of
/// the running test if it has one, as a `#[test]` function does, else by its own.
pub fn command(context: &Context, trial: &str, control: &str) -> String {
    let thread = std::thread::current();
    let test = match thread.name() {
        None | Some("main") => full_name(trial, control),
        Some(test) => test.to_owned(),
    };
    let scale = if context.scale == 1.0 {
        String::new()
    } else {
        format!("WHITEFURNACE_SCALE={} ", context.scale)
    };
    format!(
        "WHITEFURNACE_SEED={} {scale}cargo test -- --exact '{test}'",
        context.seed
    )
}

/// Asserts that every outcome holds, in a `#[test]` function of your own.
///
/// # Panics
/// If one does not, or there is none: the message has each outcome that fails or is undecided, its
/// data file in `target/trials` and the command that plots it.
#[track_caller]
pub fn assert_holds(outcomes: &[Outcome]) {
    assert!(!outcomes.is_empty(), "no outcome: nothing was put on trial");
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("trial");
    let folder = Path::new("target/trials");
    let mut message = String::new();
    for outcome in outcomes
        .iter()
        .filter(|outcome| outcome.verdict() != Verdict::Holds)
    {
        let _ = writeln!(message, "{outcome}");
        if let Verdict::Undecided { needed } = outcome.verdict() {
            let _ = writeln!(message, "  needs about {needed} samples");
        }
        message += &data_file(write_cells(test, outcome, folder));
    }
    assert!(message.is_empty(), "\n{message}");
}

/// Returns the lines of a message about a data file.
fn data_file(written: Result<Option<PathBuf>, Error>) -> String {
    match written {
        Ok(Some(path)) => {
            format!(
                "  data       {0}\n  plot       cargo run --release --bin plot-cells -- '{0}'\n",
                path.display()
            )
        }
        Ok(None) => String::new(),
        Err(error) => format!("  data       not written: {error}\n"),
    }
}

/// Writes the cells of an outcome as CSV (place, expected, observed, sigmas) and returns the path,
/// of which `name` is a part; nothing for an outcome without cells.
///
/// # Errors
/// [`Error::File`] if the folder or the file cannot be written.
pub fn write_cells(name: &str, outcome: &Outcome, folder: &Path) -> Result<Option<PathBuf>, Error> {
    if outcome.cells.is_empty() {
        return Ok(None);
    }
    let mut text = String::from("place,expected,observed,sigmas\n");
    for cell in &outcome.cells {
        let _ = writeln!(
            text,
            "\"{}\",{:e},{:e},{:.3}",
            cell.place, cell.expected, cell.observed, cell.sigmas
        );
    }
    let safe_char = |c: char| {
        if c.is_alphanumeric() || c == '-' || c == '.' {
            c
        } else {
            '_'
        }
    };
    let name: String = format!("{name} {}", outcome.name)
        .chars()
        .map(safe_char)
        .collect();
    let path = folder.join(name + ".csv");
    std::fs::create_dir_all(folder).map_err(Error::file("create", folder))?;
    std::fs::write(&path, text).map_err(Error::file("write", &path))?;
    Ok(Some(path))
}
