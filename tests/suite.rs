//! Every trial and every fault of the registry as a test with its own name: `furnace/sky/path` is a
//! trial on its correct subject, `furnace/sky/path!no-cosine` one of its faults.
//!
//! `cargo test furnace/` runs a group, `cargo test 'bsdf/eon!'` the faults of one trial.
//! `WHITEFURNACE_SHARD=1/4` runs the first of four shards.

use std::collections::HashSet;
use std::process::{Command, ExitCode};
use std::sync::Arc;

use libtest_mimic::{Arguments, Failed, Trial as Test};
use trials::faults::Pair;
use trials::{all, equivalents};
use whitefurnace::harness::outcome::Verdict;
use whitefurnace::harness::trial::{
    Context, Row, Trial, check_control, check_subject, full_name, power_objections,
    required_outcomes, shard_from_environment,
};

/// Returns a failed test with a message on lines of its own.
fn failed(mut message: String) -> Failed {
    message.insert(0, '\n');
    message.into()
}

/// Returns a message for each outcome of a trial that no fault is required to fail; `found` is the
/// trial on its correct subject. In trials with random outcomes the exact ones are left out, as
/// they have tests of their own.
fn without_fault(trial: &Trial, found: &[Row]) -> String {
    let outcomes = || found.iter().map(|row| &row.outcome);
    let names: HashSet<&str> = trial
        .controls
        .iter()
        .flat_map(|control| required_outcomes(&control.rejected_by, outcomes()))
        .map(|outcome| outcome.name.as_str())
        .collect();
    let exact = outcomes().all(|outcome| !outcome.is_random());
    outcomes()
        .filter(|outcome| outcome.is_random() || exact)
        .filter(|outcome| !names.contains(outcome.name.as_str()))
        .map(|outcome| {
            format!(
                "{}: no fault is required to fail its outcome {}\n",
                trial.name, outcome.name
            )
        })
        .collect()
}

/// Checks that a trial holds on its correct subject, and that each of its outcomes must reject a
/// fault.
fn on_its_subject(trial: &Trial, context: &Context) -> Result<(), Failed> {
    let rows = check_subject(trial, context).map_err(failed)?;
    match without_fault(trial, &rows).as_str() {
        "" => Ok(()),
        message => Err(message.into()),
    }
}

/// Checks that a trial accepts an equivalent mutant.
fn accepted(pair: &Pair, context: &Context) -> Result<(), Failed> {
    let name = full_name(&pair.trial, pair.fault.name);
    let context = context.named(&name);
    let outcomes = (pair.run)(&context);
    let mut message = power_objections(&name, &outcomes, &context);
    for outcome in &outcomes {
        let is_green = match outcome.verdict() {
            Verdict::Holds => true,
            Verdict::Fails => false,
            Verdict::Undecided { .. } => context.scale < 1.0,
        };
        if !is_green {
            let wrong = pair.fault.wrong;
            message += &format!("{name}, an equivalent mutant ({wrong}): {outcome:?}\n");
        }
    }
    if message.is_empty() {
        return Ok(());
    }
    Err(failed(message))
}

/// Checks that shards 1/3 to 3/3 partition the tests, and that malformed shards are refused.
fn parts() -> Result<(), Failed> {
    let list = |shard: &str| -> Result<(Option<i32>, Vec<String>, String), Failed> {
        let mut again = Command::new(std::env::current_exe()?);
        let made = again
            .args(["--list", "--format", "terse"])
            .env("WHITEFURNACE_SHARD", shard)
            .output()?;
        let [names, said] =
            [made.stdout, made.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
        Ok((
            made.status.code(),
            names.lines().map(str::to_owned).collect(),
            said,
        ))
    };
    let (_, mut all, _) = list("1/1")?;
    let mut parts = Vec::new();
    for shard in ["1/3", "2/3", "3/3"] {
        let (code, part, _) = list(shard)?;
        if code != Some(0) || part.len().abs_diff(all.len() / 3) > 1 {
            return Err(format!(
                "{} of {} tests in shard {shard}, exit code {code:?}",
                part.len(),
                all.len()
            )
            .into());
        }
        parts.extend(part);
    }
    parts.sort();
    all.sort();
    if parts != all || all.is_empty() {
        return Err("the shards do not add up to all tests".into());
    }
    for wrong in ["", "0/3", "4/3", "3", "1/0", "a/b"] {
        let (code, names, said) = list(wrong)?;
        if code != Some(2)
            || !names.is_empty()
            || said.lines().count() != 1
            || !said.contains("WHITEFURNACE_SHARD is")
        {
            return Err(format!("shard '{wrong}': exit code {code:?}, {said}").into());
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let found =
        Context::from_environment().and_then(|context| Ok((context, shard_from_environment()?)));
    let (context, shard) = match found {
        Ok(found) => found,
        Err(error) => {
            eprintln!("error: {error}");
            return ExitCode::from(2);
        }
    };
    // Faults come last: they are short, so that all threads have work to the end.
    let (mut tests, mut faults) = (Vec::new(), Vec::new());
    for trial in all() {
        let trial = Arc::new(trial);
        for i in 0..trial.controls.len() {
            let (trial, context) = (Arc::clone(&trial), context.clone());
            let name = full_name(&trial.name, trial.controls[i].name);
            faults.push(Test::test(name, move || {
                let checked = check_control(&trial, &trial.controls[i], &context);
                checked.map(drop).map_err(failed)
            }));
        }
        let context = context.clone();
        tests.push(Test::test(trial.name.clone(), move || {
            on_its_subject(&trial, &context)
        }));
    }
    tests.extend(faults);
    for pair in equivalents() {
        let context = context.clone();
        let name = full_name(&pair.trial, pair.fault.name);
        tests.push(Test::test(name, move || accepted(&pair, &context)));
    }
    tests.push(Test::test("suite/parts", parts));
    let mut numbers = 0..;
    tests.retain(|_| numbers.next().is_some_and(|number| shard.contains(number)));
    libtest_mimic::run(&arguments, tests).exit_code()
}
