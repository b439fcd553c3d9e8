//! What a red trial says: a message to act on, a command that repeats that trial alone, a data file.

use std::path::Path;

use whitefurnace::equation::ESTIMATOR;
use whitefurnace::harness::mean::{Values, mean};
use whitefurnace::harness::outcome::{Claim, Outcome};
use whitefurnace::harness::trial::{
    Context, Control, Trial, assert_holds, check, run_trial, write_cells,
};
use whitefurnace::rng::uniform;

fn toy(centre: f64) -> Trial {
    let run = |centre: f64| {
        move |context: &Context| {
            let mut rng = context.rng("toy");
            let values =
                Values::collect(0.5, context.n(1_000_000), || uniform(&mut rng) + centre - 0.5);
            vec![mean("mean", &values, 0.5, Claim::Exact { delta: 0.005 })]
        }
    };
    Trial {
        name: String::from("toy/mean"),
        property: String::from("the mean is 1/2"),
        equation: &ESTIMATOR,
        subject: "rng::uniform",
        statistic: "t",
        run: Box::new(run(centre)),
        controls: vec![Control::new("moved", "the mean is 0.51", run(0.51))],
    }
}

/// How many verdicts on toys chance could turn, in this module: a right toy with its control, a wrong one
/// with its control, one with a blind control, two that are too small, one that leaves a data file, three in a test of one's own.
pub const TOYS: usize = 2 + 2 + 2 + 2 + 1 + 3;

#[test]
fn a_failure_says_what_to_do() {
    let context = Context::new(7, 1.0).expect("a valid scale");
    assert!(check(&toy(0.5), &context).is_ok());
    let message = check(&toy(0.49), &context).expect_err("the mean is wrong");
    for part in [
        "toy/mean: fails",
        "the mean is 1/2",
        "estimator (16)",
        "rng::uniform",
        "WHITEFURNACE_SEED=7 cargo test -- --exact 'failures::a_failure_says_what_to_do'",
    ] {
        assert!(message.contains(part), "{part} is not in\n{message}");
    }
    // A control that is right is a hole in the trial.
    let blind = Trial {
        controls: vec![Control::new("none", "nothing is wrong", toy(0.5).run)],
        ..toy(0.5)
    };
    let message = check(&blind, &context).expect_err("the control is not rejected");
    assert!(message.contains("none was not rejected"), "{message}");
    // Too few samples: undecided, which is red at full scale and green below.
    let few = |scale| Context::new(7, scale).expect("a valid scale");
    let weak = Trial {
        run: Box::new(move |_| (toy(0.5).run)(&few(0.001).named("weak"))),
        controls: Vec::new(),
        ..toy(0.5)
    };
    let message = check(&weak, &few(1.0)).expect_err("undecided is red");
    assert!(message.contains("undecided, needs about"), "{message}");
    assert!(check(&weak, &few(0.5)).is_ok());
    assert!(Context::new(1, 0.0).is_err() && Context::new(1, f64::NAN).is_err());
}

/// The data file of a mean holds its batches, and they are as far off as the mean is.
#[test]
fn a_mean_leaves_its_batches_in_a_data_file() {
    let context = Context::new(7, 1.0).expect("a valid scale");
    let rows = run_trial(&toy(0.49), &context);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cells");
    let path = write_cells("toy", &rows[0].outcome, &folder).expect("a folder to write to");
    let text = std::fs::read_to_string(path.expect("cells")).expect("the file");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "place,expected,observed,sigmas");
    // A million values fill 61 batches of 2^14.
    assert_eq!(lines.len(), 1 + 61);
    assert!(lines[1].starts_with("\"batch 1 (16384 values)\",5e-1,4."), "{}", lines[1]);
    let batches = rows[0].outcome.cells.iter().map(|cell| cell.observed);
    let whole = batches.sum::<f64>() / 61.0;
    // The last 576 values are in no batch: they move the mean by less than 576/1e6.
    assert!((whole - rows[0].outcome.estimate).abs() < 576e-6);
}

/// A test of one's own: silent about what holds; of what does not, all that it takes to act.
#[test]
fn assertions_say_what_does_not_hold() {
    let outcome = |centre| {
        let context = Context::new(7, 1.0).expect("a valid scale").named("own");
        (toy(centre).run)(&context)
    };
    assert_holds(&outcome(0.5));
    let message = |outcomes: Vec<Outcome>| {
        let unwound = std::panic::catch_unwind(|| assert_holds(&outcomes));
        *unwound.expect_err("it does not hold").downcast::<String>().expect("a message")
    };
    let fails = message([outcome(0.5), outcome(0.49)].concat());
    assert_eq!(fails.matches("mean: fails").count(), 1, "{fails}");
    assert!(!fails.contains("holds") && fails.contains("should be 0.5 ± 0.005 (t = "), "{fails}");
    let file = "target/trials/failures__assertions_say_what_does_not_hold_mean.csv";
    assert!(fails.contains(file) && fails.contains("--bin plot-cells"), "{fails}");
    let undecided = Outcome { n: 10, valid_from: 20, ..outcome(0.5).remove(0) };
    let undecided = message(vec![undecided]);
    assert!(undecided.contains("undecided") && undecided.contains("needs about 20 samples"));
    let nothing = std::panic::catch_unwind(|| assert_holds(&[]));
    assert!(nothing.is_err());
}
