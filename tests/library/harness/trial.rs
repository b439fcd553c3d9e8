//! Tests of trials: contexts, shares of the budget, rows, verdicts, messages, data files.

mod reject; // faults on parts of the sample

use std::process::Command;
use std::sync::{Arc, Mutex};

use whitefurnace::harness::trial::{
    CSV_HEADER, DEFAULT_SEED, NegativeControl, Row, Run, Trial, assert_holds, check, check_control,
    check_subject, command, control_is_green, full_name, group, reject, run_control, run_trial,
    trial_is_green, write_cells,
};

use super::*;

fn context(scale: f64) -> Context {
    Context::new(7, scale).expect("a valid scale")
}

/// Returns a random outcome with this verdict.
fn random(name: &str, verdict: Verdict) -> Outcome {
    let (p, delta) = match verdict {
        Verdict::Holds => (1.0, 1.0),
        Verdict::Fails => (0.0, 1.0),
        Verdict::Undecided { .. } => (1.0, 0.125),
    };
    Outcome {
        p,
        ..outcome(0.5, 0.25, Claim::Equal { delta })
    }
    .named(name)
}

const UNDECIDED: Verdict = Verdict::Undecided { needed: 1600 };

/// Returns a trial whose outcomes have these verdicts, with one control whose outcomes have those.
fn trial(verdicts: Vec<Verdict>, control: Vec<Verdict>) -> Trial {
    let run = |verdicts: Vec<Verdict>| {
        move |_: &Context| {
            let outcome = |(i, &verdict)| random(&format!("outcome {i}"), verdict);
            verdicts.iter().enumerate().map(outcome).collect()
        }
    };
    Trial {
        name: String::from("toy/verdicts"),
        property: String::from("it is so"),
        consequence: String::from("all is lost"),
        source: "estimator",
        subject: "toy",
        statistic: "t",
        run: Box::new(run(verdicts)),
        controls: vec![NegativeControl::new("wrong", "it is not so", run(control))],
    }
}

#[test]
fn contexts_scale_sizes_and_name_streams() {
    assert_eq!(
        [1000, 7, 3, 1, 0].map(|n| context(0.5).n(n)),
        [500, 4, 2, 2, 2]
    );
    assert_eq!(context(16.0).n(1000), 16_000);
    let named = context(0.5).named("some trial");
    assert_eq!(
        (named.seed, named.scale, named.name.as_str()),
        (7, 0.5, "some trial")
    );
    let seed = seed_for(seed_for(7, "some trial"), "part");
    assert_eq!(named.seed_of("part"), seed);
    assert_eq!(named.rng("part").next_u64(), stream(seed, 0, 0).next_u64());
    for scale in [0.0, -1.0, f64::INFINITY] {
        assert!(Context::new(7, scale).is_err(), "{scale}");
    }
}

/// Variable that marks the process in which a test runs itself again.
const AGAIN: &str = "WHITEFURNACE_TEST_AGAIN";

#[test]
fn the_environment_is_read() {
    if std::env::var_os(AGAIN).is_some() {
        match Context::from_environment() {
            Ok(found) => println!("found {} {}.", found.seed, found.scale),
            Err(error) => println!("refused: {error}."),
        }
        return;
    }
    let found = |variables: &[(&str, &str)]| {
        let mut again = Command::new(std::env::current_exe().expect("this program"));
        again.args([
            "--exact",
            "harness::trial::the_environment_is_read",
            "--nocapture",
        ]);
        for name in ["SEED", "SCALE"] {
            again.env_remove(format!("WHITEFURNACE_{name}"));
        }
        again.env(AGAIN, "1").envs(variables.iter().copied());
        String::from_utf8_lossy(&again.output().expect("it starts").stdout).into_owned()
    };
    let text = found(&[]);
    assert!(text.contains("found 2019 1."), "{text}");
    let text = found(&[("WHITEFURNACE_SEED", " 5 "), ("WHITEFURNACE_SCALE", "0.25")]);
    assert!(text.contains("found 5 0.25."), "{text}");
    let [seeds, scales] = [
        "five -1 1.5 18446744073709551616 ",
        "x 0 -1 nan inf 1e300 1e-300 ",
    ];
    for (name, values, range) in [
        ("SEED", seeds, "0 to 18446744073709551615"),
        ("SCALE", scales, "0.0001 to 256"),
    ] {
        let name = format!("WHITEFURNACE_{name}");
        // The last is empty.
        for value in values.split(' ') {
            let text = found(&[(&name, value)]);
            let says = |part: &str| text.contains(part);
            assert!(
                says("refused: ") && says(&name) && says(range),
                "{name}={value}: {text}"
            );
        }
    }
}

fn row(verdict: Verdict) -> Row {
    run_trial(&trial(vec![verdict], Vec::new()), &context(1.0))
        .into_iter()
        .next()
        .expect("one outcome")
}

#[test]
fn rows_say_what_was_found() {
    let found = trial(vec![Verdict::Holds, UNDECIDED], vec![Verdict::Fails]);
    let rows = run_trial(&found, &context(1.0));
    let verdicts: Vec<Verdict> = rows.iter().map(|row| row.verdict).collect();
    assert_eq!(verdicts, [Verdict::Holds, UNDECIDED]);
    assert_eq!(rows[0].seed, 7);
    assert_eq!(
        rows[1].csv(),
        "toy/verdicts,,estimator,\"outcome 1\",t,100,5e-1,5e-1,2.5e-1,7.5e-1,1e0,undecided,1.25e-1,0e0,\
         1 - 0.0e0,7"
    );
    assert_eq!(
        CSV_HEADER.split(',').count(),
        rows[1].csv().split(',').count()
    );
    let control = run_control(&found, &found.controls[0], &context(1.0));
    assert_eq!(control.len(), 1);
    assert_eq!(
        (control[0].control.as_str(), control[0].verdict),
        ("wrong", Verdict::Fails)
    );
    assert_eq!(control[0].property, "it is so");
}

#[test]
fn undecided_is_red_at_full_scale_only() {
    let (holds, fails, undecided) = (row(Verdict::Holds), row(Verdict::Fails), row(UNDECIDED));
    for (scale, open) in [(0.5, true), (1.0, false), (2.0, false)] {
        let green = |rows: &[&Row]| {
            let rows: Vec<Row> = rows.iter().map(|&row| row.clone()).collect();
            let context = context(scale);
            let control = NegativeControl::new("wrong", "it is not so", |_| Vec::new());
            (
                trial_is_green(&rows, &context),
                control_is_green(&control, &rows, &context),
            )
        };
        assert_eq!(green(&[]), (false, false));
        assert_eq!(green(&[&holds]), (true, false));
        assert_eq!(green(&[&fails]), (false, true));
        assert_eq!(green(&[&undecided]), (open, open));
        // Which of two outcomes must fail would have to be stated.
        assert_eq!(green(&[&holds, &fails]), (false, false));
        assert_eq!(green(&[&holds, &undecided]), (open, false));
    }
}

/// A control counts if the outcomes that it names reject it, with numbers. With another seed than
/// the default the guard could refuse a right row by chance.
#[test]
fn the_guard_is_asked_where_sizes_are_planned() {
    let small = |verdict| {
        let sensitivity = normal(0.1, 1e4);
        Outcome {
            sensitivity,
            n: 10_000,
            ..random("small", verdict)
        }
    };
    let run = move |verdict| move |_: &Context| vec![small(verdict)];
    let small = Trial {
        run: Box::new(run(Verdict::Holds)),
        controls: vec![NegativeControl::new(
            "wrong",
            "it is not so",
            run(Verdict::Fails),
        )],
        ..trial(Vec::new(), Vec::new())
    };
    for (seed, scale, refuses) in [
        (DEFAULT_SEED, 1.0, true),
        (DEFAULT_SEED, 16.0, true),
        (DEFAULT_SEED, 0.5, false),
        (7, 1.0, false),
    ] {
        let context = Context::new(seed, scale).expect("a valid scale");
        assert_eq!(context.guard_applies(), refuses);
        let found = check_subject(&small, &context);
        assert_eq!(
            found
                .as_ref()
                .is_err_and(|why| why.contains("too small for the error budget")),
            refuses,
            "{found:?}"
        );
        assert_eq!(found.is_ok(), !refuses);
    }
}

#[test]
fn a_control_is_rejected_by_the_outcomes_that_it_names() {
    let outcome = |name: &str, verdict| Row {
        outcome: random(name, verdict),
        ..row(verdict)
    };
    let green = |names: &[&'static str], rows: &[Row]| {
        let control = NegativeControl {
            rejected_by: names.to_vec(),
            ..NegativeControl::new("wrong", "it is not so", |_| Vec::new())
        };
        control_is_green(&control, rows, &context(1.0))
    };
    let [holds, fails] = [Verdict::Holds, Verdict::Fails];
    let rows = [
        outcome("a", holds),
        outcome("b", fails),
        outcome("c", fails),
    ];
    assert!(green(&["b"], &rows) && green(&["b", "c"], &rows));
    assert!(!green(&["a"], &rows) && !green(&["a", "b"], &rows));
    assert!(!green(&["d"], &rows) && !green(&["b", "d"], &rows) && !green(&[], &rows));
    // The only random outcome is meant if none is named.
    let exact = |error| Row {
        outcome: Outcome::identity("exact", 1, error, 1e-9, ""),
        ..row(holds)
    };
    assert!(green(&[], &[exact(0.0), outcome("a", fails)]));
    assert!(!green(&[], &[exact(1.0), outcome("a", holds)]));
    assert!(green(&["exact"], &[exact(1.0), outcome("a", holds)]));
    assert!(green(&[], &[exact(1.0)]) && !green(&[], &[exact(1.0), exact(0.0)]));
    // NaN and infinity prove nothing.
    assert!(!green(&["exact"], &[exact(f64::NAN)]));
    assert!(!green(&["exact"], &[exact(f64::INFINITY)]));
    let mut nan = outcome("a", fails);
    nan.outcome.p = f64::NAN;
    assert_eq!(nan.outcome.verdict(), fails);
    assert!(!green(&[], &[nan]));
}

#[test]
fn messages_speak_of_what_is_red() {
    let full = context(1.0);
    let mut right = trial(vec![Verdict::Holds], vec![Verdict::Holds, Verdict::Fails]);
    right.controls[0].rejected_by = vec!["outcome 1"];
    assert_eq!(check(&right, &full).map(|rows| rows.len()), Ok(1));
    assert_eq!(check_subject(&right, &full).map(|rows| rows.len()), Ok(1));
    let control = check_control(&right, &right.controls[0], &full);
    assert_eq!(control.map(|rows| rows.len()), Ok(2));
    // A red trial lists the outcomes that do not hold; a control without rejection lists all.
    let red = trial(
        vec![Verdict::Holds, Verdict::Fails],
        vec![Verdict::Holds; 2],
    );
    let message = check(&red, &full).expect_err("both are red");
    let lines = |what: &str| message.lines().filter(|line| line.contains(what)).count();
    let verdicts = [
        "toy/verdicts: fails",
        "toy/verdicts: holds",
        "wrong was not rejected",
    ]
    .map(lines);
    assert_eq!(
        (verdicts, ["t of outcome 0:", "t of outcome 1:"].map(lines)),
        ([1, 2, 1], [1, 2]),
        "{message}"
    );
    assert!(message.find("fails") < message.find("was not rejected"));
    // The message has the claim, its subject and equation, and how to repeat it.
    let repeat = "WHITEFURNACE_SEED=7 cargo test -- --exact 'harness::trial::messages_speak";
    let symptom = "\n  if this fails: all is lost\n";
    for part in ["it is so", symptom, "estimator (16)", "toy", repeat] {
        assert!(message.contains(part), "{part} is not in\n{message}");
    }
    // A source that is not an equation's id is printed as it is.
    let undecided = Trial {
        source: "Veach 1997, 9.2",
        ..trial(vec![UNDECIDED], vec![Verdict::Fails])
    };
    let message = check(&undecided, &full).expect_err("undecided is red");
    assert!(
        message.contains("undecided, needs about")
            && message.contains("source     Veach 1997, 9.2"),
        "{message}"
    );
    let row = run_trial(&undecided, &full).remove(0).csv();
    assert!(
        row.starts_with("toy/verdicts,,\"Veach 1997, 9.2\",\"outcome 0\",t,"),
        "{row}"
    );
    let blind = trial(vec![Verdict::Holds], vec![Verdict::Holds]);
    let message = check(&blind, &full).expect_err("the control is not rejected");
    assert!(
        message.starts_with("toy/verdicts: the negative control wrong"),
        "{message}"
    );
}

#[test]
fn names_and_commands_lead_back() {
    assert_eq!(
        (group("furnace/sky/path"), group("furnace")),
        ("furnace", "furnace")
    );
    assert_eq!(full_name("a/b", ""), "a/b");
    assert_eq!(full_name("a/b", "fault"), "a/b!fault");
    let scaled = command(&context(0.25), "a/b", "");
    assert!(scaled.contains(" WHITEFURNACE_SCALE=0.25 "), "{scaled}");
    // A test function is repeated by its own name; other trials are repeated by the trial's name.
    let own =
        "WHITEFURNACE_SEED=7 cargo test -- --exact 'harness::trial::names_and_commands_lead_back'";
    assert_eq!(command(&context(1.0), "a/b", "fault"), own);
    let unnamed = std::thread::spawn(|| command(&context(1.0), "a/b", "fault"));
    let unnamed = unnamed.join().expect("it does not panic");
    assert_eq!(
        unnamed,
        "WHITEFURNACE_SEED=7 cargo test -- --exact 'a/b!fault'"
    );
}

#[test]
fn data_files_hold_the_cells() {
    let folder = folder();
    let mut row = row(Verdict::Fails);
    assert_eq!(
        write_cells("toy/verdicts wrong", &row.outcome, &folder).ok(),
        Some(None)
    );
    row.outcome.name = String::from("x² at 1.5, half-way");
    row.outcome.cells = vec![Cell {
        place: String::from("here"),
        expected: 1000.0,
        observed: 1250.0,
        sigmas: 7.9057,
    }];
    let path = write_cells("toy/verdicts wrong", &row.outcome, &folder)
        .ok()
        .flatten()
        .expect("a file");
    // Letters, digits, dots and hyphens are kept.
    let name = path
        .file_name()
        .map(|name| name.to_string_lossy().into_owned());
    assert_eq!(
        name.as_deref(),
        Some("toy_verdicts_wrong_x²_at_1.5__half-way.csv")
    );
    let text = std::fs::read_to_string(&path).expect("the file");
    assert_eq!(
        text,
        "place,expected,observed,sigmas\n\"here\",1e3,1.25e3,7.906\n"
    );
}

/// Assertions print nothing about outcomes that hold, and all that is needed to act on the others.
#[test]
fn assertions_say_what_does_not_hold() {
    let [holds, fails] = [Verdict::Holds, Verdict::Fails].map(|verdict| random("mean", verdict));
    let cell = Cell {
        place: String::from("here"),
        expected: 1.0,
        observed: 2.0,
        sigmas: 9.0,
    };
    let fails = Outcome {
        cells: vec![cell],
        ..fails
    };
    assert_holds(std::slice::from_ref(&holds));
    let message = |outcomes: Vec<Outcome>| {
        let unwound = std::panic::catch_unwind(|| assert_holds(&outcomes));
        *unwound
            .expect_err("it does not hold")
            .downcast::<String>()
            .expect("a message")
    };
    let red = message(vec![holds, fails]);
    let line =
        "\nmean: fails; 0.5 in [0.25, 0.75], should be 0.5 ± 1 (t = 0, n = 100, p = 0.0e0)\n";
    assert!(red.starts_with(line), "{red}");
    let file = "target/trials/harness__trial__assertions_say_what_does_not_hold_mean.csv";
    assert!(
        red.contains(file) && red.contains("--bin plot-cells -- 'target"),
        "{red}"
    );
    assert_eq!(red.lines().count(), 4, "{red}");
    let undecided = message(vec![random("mean", UNDECIDED)]);
    assert!(undecided.contains("mean: undecided;"), "{undecided}");
    assert!(
        undecided.contains("\n  needs about 1600 samples\n"),
        "{undecided}"
    );
    assert!(std::panic::catch_unwind(|| assert_holds(&[])).is_err());
}
