//! Tests of the programs as a user meets them, and of the files that experiments leave.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use clap::CommandFactory as _;
use experiments::render::Job;
use experiments::render::command::Render;
use experiments::run::record::{recorded_folder, result};
use experiments::run::{ExperimentResult, Finding, Judgement, Options, Tier};

#[cfg(unix)]
mod checkpoints;
mod commands;
mod compare;
mod compare_files; // files as other programs write them
mod compare_noise;
mod compare_without_noise;
mod defaults;
mod densities;
mod export;
mod figures;
mod graded;
mod judge;
mod metamorphic;
mod moments;
mod mutants;
mod numbers;
mod options;
#[cfg(unix)]
mod preview;
mod record;
mod refusals;
mod rendering;
mod resumption;
#[cfg(unix)]
mod signals;
mod tables;

/// Returns an empty folder for one test.
fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(test);
    if folder.exists() {
        std::fs::remove_dir_all(&folder).expect("an old test folder can be removed");
    }
    std::fs::create_dir_all(&folder).expect("a test folder can be made");
    folder
}

/// Returns the output of a program that runs in a folder.
fn run(program: &str, folder: &Path, options: &str) -> Output {
    Command::new(program)
        .args(options.split_whitespace())
        .current_dir(folder)
        .output()
        .expect("the program starts")
}

fn render(folder: &Path, options: &str) -> Output {
    run(env!("CARGO_BIN_EXE_render"), folder, options)
}

/// Parses a command line of `render` into its job.
fn job(words: &str) -> Job {
    let matches = Render::command().try_get_matches_from(words.split_whitespace());
    Render::from_matches(&matches.expect("options"))
        .expect("options")
        .job
}

/// Asserts that `render` succeeds.
fn renders(folder: &Path, options: &str) {
    let output = render(folder, options);
    assert!(
        output.status.success(),
        "{options}: {}",
        text(&output.stderr)
    );
}

fn reproduce(folder: &Path, options: &str) -> Output {
    run(env!("CARGO_BIN_EXE_reproduce"), folder, options)
}

/// Asserts exit code 2 and, except for notes on a scene file, one line on standard error that
/// contains the hint.
fn refused(output: &Output, hint: &str) {
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    let lines: Vec<&str> = message
        .lines()
        .filter(|line| !line.starts_with("note: "))
        .collect();
    assert!(
        matches!(lines[..], [line] if line.starts_with("error: ") && line.contains(hint)),
        "{hint}: {message}"
    );
}

/// Asserts that a program refuses the options of a case, which stand before `=>` and the hint.
fn refuses(case: &str, run: impl Fn(&str) -> Output) {
    let (options, hint) = case.split_once(" => ").expect("a hint");
    refused(&run(options), hint);
}

/// Splits a case of a table: an exit code, options, and after `=>` a part of the output.
fn case(text: &str) -> (i32, &str, &str) {
    let (command, hint) = text.split_once(" => ").expect("a hint");
    let (code, options) = command.split_once(' ').expect("options");
    (code.parse().expect("an exit code"), options, hint)
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Returns options of a small run into a folder.
fn quick(out: PathBuf, shrink: u32) -> Options {
    Options {
        tier: Tier::Quick,
        out,
        seed: 1,
        threads: None,
        shrink,
        rows: false,
    }
}

/// Returns a recorded result with other findings: text, value, and verdict.
fn outcome(findings: &[(&str, &str, Option<Judgement>)]) -> ExperimentResult {
    let mut outcome = result(&recorded_folder().join("room")).expect("a recorded result");
    let finding = |&(what, value, verdict): &(&str, &str, Option<Judgement>)| Finding {
        what: what.to_owned(),
        value: value.to_owned(),
        verdict,
        detail: false,
    };
    outcome.findings = findings.iter().map(finding).collect();
    outcome
}
