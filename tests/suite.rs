//! Every trial and every fault of the registry as a test with its own name: `furnace/sky/path` is a trial
//! on its right subject, `furnace/sky/path!no-cosine` one of its faults.
//!
//! `cargo test furnace/` runs a group, `cargo test 'bsdf/eon!'` the faults of one trial.

use std::collections::HashSet;
use std::process::ExitCode;
use std::sync::Arc;

use libtest_mimic::{Arguments, Failed, Trial as Test};
use registry::all;
use registry::equivalents;
use registry::faults::Pair;
use whitefurnace::harness::outcome::Verdict;
use whitefurnace::harness::trial::{Context, Row, Trial, check_control, check_subject, full_name, meant, refused};

/// The message, for a test that is red.
fn report(result: Result<Vec<Row>, String>) -> Result<(), Failed> {
    match result {
        Ok(_) => Ok(()),
        Err(message) => Err(Failed::from(format!("\n{message}"))),
    }
}

/// The outcomes of a trial on its right subject that no fault must be rejected by, a line each. Where chance
/// has a part, exact outcomes beside it have tests of their own.
fn without_fault(trial: &Trial, found: &[Row]) -> String {
    let outcomes = || found.iter().map(|row| &row.outcome);
    let names: HashSet<&str> = trial
        .controls
        .iter()
        .flat_map(|control| meant(&control.rejected_by, outcomes()))
        .map(|outcome| outcome.name.as_str())
        .collect();
    let exact = outcomes().all(|outcome| !outcome.is_random());
    outcomes()
        .filter(|outcome| outcome.is_random() || exact)
        .filter(|outcome| !names.contains(outcome.name.as_str()))
        .map(|outcome| format!("{}: no fault is to be rejected by its outcome {}\n", trial.name, outcome.name))
        .collect()
}

/// Whether a trial holds on its right subject, and each of its outcomes rejects a fault.
fn on_its_subject(trial: &Trial, context: &Context) -> Result<(), Failed> {
    let rows = check_subject(trial, context).map_err(|message| format!("\n{message}"))?;
    match without_fault(trial, &rows).as_str() {
        "" => report(Ok(rows)),
        message => Err(Failed::from(message)),
    }
}

/// Whether a mutant that is as right as the right subject is accepted.
fn accepted(pair: &Pair, context: &Context) -> Result<(), Failed> {
    let name = full_name(&pair.trial, pair.fault.name);
    let context = context.named(&name);
    let outcomes = (pair.run)(&context);
    let mut message = refused(&name, &outcomes, &context);
    for outcome in &outcomes {
        let green = match outcome.verdict() {
            Verdict::Holds => true,
            Verdict::Fails => false,
            Verdict::Undecided { .. } => context.scale < 1.0,
        };
        if !green {
            message += &format!("{name}, which is right ({}): {outcome:?}\n", pair.fault.wrong);
        }
    }
    if message.is_empty() {
        return Ok(());
    }
    Err(Failed::from(format!("\n{message}")))
}

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let context = match Context::from_environment() {
        Ok(context) => context,
        Err(error) => {
            eprintln!("error: {error}");
            return ExitCode::from(2);
        }
    };
    let mut tests = Vec::new();
    for trial in all() {
        let trial = Arc::new(trial);
        for i in 0..trial.controls.len() {
            let (trial, context) = (Arc::clone(&trial), context.clone());
            let name = full_name(&trial.name, trial.controls[i].name);
            tests.push(Test::test(name, move || report(check_control(&trial, &trial.controls[i], &context))));
        }
        let context = context.clone();
        tests.push(Test::test(trial.name.clone(), move || on_its_subject(&trial, &context)));
    }
    for pair in equivalents() {
        let context = context.clone();
        let name = full_name(&pair.trial, pair.fault.name);
        tests.push(Test::test(name, move || accepted(&pair, &context)));
    }
    libtest_mimic::run(&arguments, tests).exit_code()
}
