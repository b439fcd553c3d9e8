//! Trials as data: a property, a statistic, a size, and functions that run it on the right subject and
//! on faulty ones.

use std::fmt::Write as _;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use super::guard;
use super::outcome::{Outcome, Verdict};
use crate::equation::Equation;
use crate::error::Error;
use crate::rng::{Stream, seed_for, stream};

/// The master seed if `WHITEFURNACE_SEED` is not set.
pub const DEFAULT_SEED: u64 = 2019;

/// The scales that `WHITEFURNACE_SCALE` takes: below, statistics are undefined; above, samples outnumber the
/// streams.
pub const SCALES: RangeInclusive<f64> = 1e-4..=256.0;

/// What a run of trials shares: master seed, scale of sample sizes, folder for data files, and which
/// trial alone is wanted.
#[derive(Clone, Debug, PartialEq)]
pub struct Context {
    /// Every trial's stream is derived from this and the trial's name.
    pub seed: u64,
    /// Sample sizes are multiplied by this.
    pub scale: f64,
    /// Where data files of failures go; made when needed.
    pub folder: PathBuf,
    /// The one trial ("furnace/sky/path") or fault of a trial ("furnace/sky/path!no-cosine") to run;
    /// all of them if there is none.
    pub only: Option<String>,
    /// The trial (and subject) whose streams these are.
    pub name: String,
}

impl Context {
    /// A context with the given seed and scale (positive and finite).
    ///
    /// # Errors
    /// [`Error::Option`] for a scale that makes no sense.
    pub fn new(seed: u64, scale: f64) -> Result<Self, Error> {
        if !(scale.is_finite() && scale > 0.0) {
            return Err(Error::Option(format!(
                "the scale of sample sizes is {scale}; it must be a positive number such as 16 or 0.25"
            )));
        }
        Ok(Self {
            seed,
            scale,
            folder: PathBuf::from("target/trials"),
            only: None,
            name: String::new(),
        })
    }

    /// Reads `WHITEFURNACE_SEED` (default [`DEFAULT_SEED`]), `WHITEFURNACE_SCALE` (default 1) and
    /// `WHITEFURNACE_ONLY` (the name of one trial or fault, as in [`only`](Self::only); default all).
    /// The only place in the library that reads the environment.
    ///
    /// # Errors
    /// [`Error::Option`] if one of them is not a number, or the scale is not among [`SCALES`].
    pub fn from_environment() -> Result<Self, Error> {
        fn read<T: std::str::FromStr>(
            name: &str,
            default: T,
            (expected, fits): (&str, impl Fn(&T) -> bool),
        ) -> Result<T, Error> {
            let Some(text) = std::env::var_os(name) else {
                return Ok(default);
            };
            let value = text.to_str().and_then(|text| text.trim().parse().ok());
            value.filter(fits).ok_or_else(|| {
                Error::Option(format!(
                    "{name} is '{}': set it to {expected}, or unset it",
                    text.display()
                ))
            })
        }
        let seeds = "a whole number from 0 to 18446744073709551615, such as 2019";
        let scales = format!(
            "a number from {} to {}, such as 16",
            SCALES.start(),
            SCALES.end()
        );
        let context = Self::new(
            read("WHITEFURNACE_SEED", DEFAULT_SEED, (seeds, |_: &u64| true))?,
            read(
                "WHITEFURNACE_SCALE",
                1.0,
                (&scales, |scale| SCALES.contains(scale)),
            )?,
        )?;
        let only = std::env::var_os("WHITEFURNACE_ONLY");
        Ok(Self {
            only: only.map(|name| name.to_string_lossy().into_owned()),
            ..context
        })
    }

    /// Those of `items` that are wanted: all, or the one whose name is [`only`](Self::only).
    ///
    /// # Errors
    /// [`Error::Option`] if none has that name.
    pub fn select<T>(&self, items: Vec<T>, name: impl Fn(&T) -> String) -> Result<Vec<T>, Error> {
        let Some(only) = &self.only else {
            return Ok(items);
        };
        let wanted: Vec<T> = items
            .into_iter()
            .filter(|item| name(item) == *only)
            .collect();
        if wanted.is_empty() {
            return Err(Error::Option(format!(
                "WHITEFURNACE_ONLY is {only}, which is none of this test's trials or faults; correct \
                 the name, or unset it"
            )));
        }
        Ok(wanted)
    }

    /// The same context for the trial or test with this name.
    pub fn named(&self, name: &str) -> Self {
        Self {
            name: name.to_owned(),
            ..self.clone()
        }
    }

    /// The seed of a part of this trial; independent for different trials and parts.
    pub fn seed_of(&self, part: &str) -> u64 {
        seed_for(seed_for(self.seed, &self.name), part)
    }

    /// The random stream of a part of this trial.
    pub fn rng(&self, part: &str) -> Stream {
        stream(self.seed_of(part), 0, 0)
    }

    /// A sample size at this scale, at least 2.
    pub fn n(&self, samples: u64) -> u64 {
        ((samples as f64 * self.scale).round() as u64).max(2)
    }

    /// How many arguments an exact identity is tried on: as many as asked for also where sample sizes are
    /// reduced, for no power is lost by a smaller sample that an identity could tell of.
    pub fn arguments(&self, count: u64) -> u64 {
        (count as f64 * self.scale.max(1.0)).round() as u64
    }
}

/// What a trial does: takes its random numbers and sizes from the context, returns what it found.
pub type Run = Box<dyn Fn(&Context) -> Vec<Outcome> + Send + Sync>;

/// A faulty subject on which the same trial must fail.
pub struct Control {
    /// A short name, unique within its trial.
    pub name: &'static str,
    /// What is wrong, in one line.
    pub wrong: &'static str,
    /// The outcomes that must all reject it, by name. May be empty where the trial leaves no choice:
    /// see [`meant`].
    pub rejected_by: Vec<&'static str>,
    /// The trial's function with the faulty subject.
    pub run: Run,
}

impl Control {
    /// A control that the trial's only outcome rejects.
    pub fn new(
        name: &'static str,
        wrong: &'static str,
        run: impl Fn(&Context) -> Vec<Outcome> + Send + Sync + 'static,
    ) -> Self {
        Self {
            name,
            wrong,
            rejected_by: Vec::new(),
            run: Box::new(run),
        }
    }
}

/// A property on trial.
///
/// Its power follows from what its outcomes vary ([`Outcome::miss`]); the tests assert that each random
/// outcome misses an effect of its δ with probability at most [`ALPHA`](super::outcome::ALPHA).
pub struct Trial {
    /// Unique name, words joined by '-', parts by '/': "hemisphere/uniform/chi-square". The first part
    /// is the [`group`].
    pub name: String,
    /// The statement that is true or false.
    pub property: String,
    /// The equation or claim that the property belongs to.
    pub equation: &'static Equation,
    /// What is examined: the path of the function.
    pub subject: &'static str,
    /// Which statistic.
    pub statistic: &'static str,
    /// Sample size at scale 1 (arguments tried, for an exact trial).
    pub samples: u64,
    /// The largest δ among its claims: an effect of this size is seen, with that power.
    pub delta: f64,
    /// How many of its outcomes chance can turn: its shares of the error budget.
    pub assertions: usize,
    /// The function on the right subject.
    pub run: Run,
    /// The same function on faulty subjects; at least one.
    pub controls: Vec<Control>,
}

impl Trial {
    /// The shares of the error budget that the right subject uses: one for each random outcome, as what is
    /// rejected and what is not concluded are one event where δ is the minimum detectable effect; and one
    /// for an identity that is tried on random arguments.
    pub fn budget(&self) -> usize {
        self.assertions.max(1)
    }

    /// How many rejections of faults it takes. Each is held by the [`guard`] to a miss of
    /// [`guard::FAR_MISS`], a thousandth of a share.
    pub fn rejections(&self) -> usize {
        let names = |control: &Control| control.rejected_by.len().max(1);
        self.controls.iter().map(names).sum()
    }
}

/// One line of the report: what one outcome of a trial says.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The trial's name.
    pub trial: String,
    /// The control's name; empty for the trial itself.
    pub control: String,
    /// The trial's property.
    pub property: String,
    /// The equation's id.
    pub equation: &'static str,
    /// What was found.
    pub outcome: Outcome,
    /// The verdict on it.
    pub verdict: Verdict,
    /// The master seed.
    pub seed: u64,
}

/// The columns of [`Row::csv`].
pub const CSV_HEADER: &str = "trial,control,equation,measure,statistic,n,estimate,reference,low,high,\
     p,verdict,delta,minimum_detectable_effect,power,seed";

impl Row {
    /// The row with the columns of [`CSV_HEADER`].
    pub fn csv(&self) -> String {
        let o = &self.outcome;
        format!(
            "{},{},{},\"{}\",{},{},{:e},{:e},{:e},{:e},{:e},{},{:e},{:e},{},{}",
            self.trial,
            self.control,
            self.equation,
            o.name,
            o.statistic,
            o.n,
            o.estimate,
            o.reference,
            o.interval[0],
            o.interval[1],
            o.p,
            self.verdict.word(),
            o.claim.size(),
            o.minimum_detectable_effect(),
            o.power(),
            self.seed
        )
    }
}

/// Runs a trial on its subject.
pub fn run_trial(trial: &Trial, context: &Context) -> Vec<Row> {
    rows(trial, "", &trial.run, context)
}

/// Runs a trial on a faulty subject, with random numbers of its own.
pub fn run_control(trial: &Trial, control: &Control, context: &Context) -> Vec<Row> {
    rows(trial, control.name, &control.run, context)
}

fn rows(trial: &Trial, control: &str, run: &Run, context: &Context) -> Vec<Row> {
    run(&context.named(&full_name(&trial.name, control)))
        .into_iter()
        .map(|outcome| Row {
            trial: trial.name.clone(),
            control: control.to_owned(),
            property: trial.property.clone(),
            equation: trial.equation.id,
            verdict: outcome.verdict(),
            outcome,
            seed: context.seed,
        })
        .collect()
}

/// Whether a trial's rows are green: every outcome holds; *undecided* is green below scale 1 only.
pub fn trial_is_green(rows: &[Row], context: &Context) -> bool {
    !rows.is_empty()
        && rows.iter().all(|row| match row.verdict {
            Verdict::Holds => true,
            Verdict::Fails => false,
            Verdict::Undecided { .. } => context.scale < 1.0,
        })
}

/// The outcomes that must reject a control: those that it names or, where it names none, the only
/// random one or, where nothing is random, all of them. Nothing if there is none of a name, or a choice is
/// left.
pub fn meant<'a>(
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

/// Whether a control is rejected for the reason that it states: every outcome that is [`meant`] fails,
/// and not for a NaN or an infinite estimate. Below scale 1 *undecided* will do.
pub fn control_is_green(control: &Control, rows: &[Row], context: &Context) -> bool {
    let meant = meant(&control.rejected_by, rows.iter().map(|row| &row.outcome));
    !meant.is_empty()
        && meant.iter().all(|outcome| match outcome.verdict() {
            Verdict::Fails => outcome.p.is_finite() && outcome.estimate.is_finite(),
            Verdict::Undecided { .. } => context.scale < 1.0,
            Verdict::Holds => false,
        })
}

/// Puts a trial and all of its controls to the test. The error is a message to act on, one paragraph
/// for the trial and each control that is red; data files are written to the context's folder.
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

/// Puts a trial to the test on its right subject alone.
///
/// # Errors
/// The message, if it is red.
pub fn check_subject(trial: &Trial, context: &Context) -> Result<Vec<Row>, String> {
    let mut message = String::new();
    let found = run_trial(trial, context);
    let random = found.iter().filter(|row| row.outcome.is_random()).count();
    if random != trial.assertions {
        let _ = writeln!(
            message,
            "{} declares {} random outcomes and has {random}: correct `assertions`",
            trial.name, trial.assertions
        );
    }
    if !trial_is_green(&found, context) {
        message += &explain(trial, &found, context);
    }
    // Below scale 1 effects of that size need not be seen.
    for row in found.iter().filter(|_| context.scale >= 1.0) {
        for graded in &row.outcome.graded {
            if !graded.is_answered() {
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
    message += &refused(&trial.name, found.iter().map(|row| &row.outcome), context);
    if message.is_empty() {
        Ok(found)
    } else {
        Err(message)
    }
}

/// What the [`guard`] has against outcomes that are to hold, a line each; nothing below scale 1.
pub fn refused<'a>(
    name: &str,
    outcomes: impl IntoIterator<Item = &'a Outcome>,
    context: &Context,
) -> String {
    outcomes
        .into_iter()
        .filter(|_| context.scale >= 1.0)
        .filter_map(guard::may_not_hold)
        .map(|why| format!("{name}: too small for the error budget: {why}\n"))
        .collect()
}

/// Puts a trial to the test on one of its faulty subjects.
///
/// # Errors
/// The message, if the fault is not rejected.
pub fn check_control(
    trial: &Trial,
    control: &Control,
    context: &Context,
) -> Result<Vec<Row>, String> {
    let rows = run_control(trial, control, context);
    if control_is_green(control, &rows, context) {
        let outcomes = rows.iter().map(|row| &row.outcome);
        let near = meant(&control.rejected_by, outcomes)
            .into_iter()
            .filter_map(guard::may_hold);
        let message: String = near
            .filter(|_| context.scale >= 1.0)
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
    let by = match control.rejected_by.as_slice() {
        [] => String::from("the trial's only random outcome (where there are several, name which)"),
        names => names.join(", "),
    };
    Err(format!(
        "{}: the negative control {} was not rejected\n  what is wrong with it: {}\n  to be rejected, \
         with finite numbers, by: {by}\n{}",
        trial.name,
        control.name,
        control.wrong,
        explain(trial, &rows, context)
    ))
}

/// What a person needs in order to act on a verdict.
fn explain(trial: &Trial, rows: &[Row], context: &Context) -> String {
    let mut text = String::new();
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
            "{}: {verdict}\n  property   {}\n  equation   {} ({}), {}\n  subject    {}\n  \
             statistic  {} of {}: {:.6}, n = {}, p = {:.3e}\n  estimate   {:.9} in [{:.9}, {:.9}], \
             should be {:.9} ± {:.3e}\n  power      {} at that size, detects {:.3e}\n  worst      {}\n  repeat     {}",
            row.trial,
            trial.property,
            trial.equation.id,
            trial.equation.number,
            trial.equation.title,
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
        match write_cells(row, &context.folder) {
            Ok(Some(path)) => {
                let _ = writeln!(
                    text,
                    "  data       {0}\n  plot       cargo run --release --bin plot-cells -- '{0}'",
                    path.display()
                );
            }
            Ok(None) => {}
            Err(error) => {
                let _ = writeln!(text, "  data       not written: {error}");
            }
        }
    }
    text
}

/// The name of a trial, or of a fault (control) under it: "trial!fault".
pub fn full_name(trial: &str, control: &str) -> String {
    if control.is_empty() {
        trial.to_owned()
    } else {
        format!("{trial}!{control}")
    }
}

/// The shell command that repeats this trial alone, or this fault under it: the integration test of its
/// group, restricted by name.
pub fn command(context: &Context, trial: &str, control: &str) -> String {
    let module = if control.is_empty() { "trials" } else { "zoo" };
    let scale = if context.scale == 1.0 {
        String::new()
    } else {
        format!("WHITEFURNACE_SCALE={} ", context.scale)
    };
    format!(
        "WHITEFURNACE_SEED={} {scale}WHITEFURNACE_ONLY='{}' cargo test -p whitefurnace --test it -- \
         --exact {module}::{}",
        context.seed,
        full_name(trial, control),
        group(trial)
    )
}

/// The part of a trial's name before the first '/': the name of its integration test.
pub fn group(trial: &str) -> &str {
    trial.split('/').next().unwrap_or(trial)
}

/// Writes the cells of a row as CSV (place, expected, observed, sigmas) and returns the path; nothing
/// for an outcome without cells.
///
/// # Errors
/// [`Error::File`] if the folder or the file cannot be written.
pub fn write_cells(row: &Row, folder: &Path) -> Result<Option<PathBuf>, Error> {
    if row.outcome.cells.is_empty() {
        return Ok(None);
    }
    let mut text = String::from("place,expected,observed,sigmas\n");
    for cell in &row.outcome.cells {
        let _ = writeln!(
            text,
            "\"{}\",{:e},{:e},{:.3}",
            cell.place, cell.expected, cell.observed, cell.sigmas
        );
    }
    let name: String = format!("{} {} {}", row.trial, row.control, row.outcome.name)
        .chars()
        .map(|c| {
            if c.is_alphanumeric() || c == '-' || c == '.' {
                c
            } else {
                '_'
            }
        })
        .collect();
    let path = folder.join(name + ".csv");
    std::fs::create_dir_all(folder).map_err(Error::file("create", folder))?;
    std::fs::write(&path, text).map_err(Error::file("write", &path))?;
    Ok(Some(path))
}
