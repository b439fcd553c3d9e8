//! Tests of the printed findings, and of the progress of runs.

use std::path::Path;
use std::time::Duration;

use experiments::experiments::{EXPERIMENTS, NOT_BY_DEFAULT};
use experiments::run::Judgement;
use experiments::run::cli::{Ending, print_summary};
use experiments::run::progress::state;
use experiments::run::record::{MAX_LINE_LENGTH, recorded_folder, result, table};
use experiments::run::summary::{LINE_WIDTH, headline, summary, verdicts};
use records::results::DEFAULT_RUN;

use crate::{folder, outcome, quick};

#[test]
fn lines_of_tables_are_never_too_long() {
    let long = (0..100)
        .map(|i| format!("word{i}"))
        .collect::<Vec<_>>()
        .join(" ");
    let holds = Some(Judgement::Holds);
    let found = outcome(&[
        ("  furnace/sky/path", &long, holds),
        ("short", "0.5 ± 0.1", Some(Judgement::Fails)),
    ]);
    let text = table(&found, false);
    let longest = text.lines().map(|line| line.chars().count()).max();
    assert!(
        longest.is_some_and(|longest| (120..=MAX_LINE_LENGTH).contains(&longest)),
        "{text}"
    );
    let words: Vec<&str> = text.split_whitespace().collect();
    assert!(
        words
            .join(" ")
            .contains(&(long + " holds short 0.5 ± 0.1 FAILS")),
        "{text}"
    );
}

/// Every experiment summarises its findings in at most two lines of at most a hundred columns, with
/// numbers that it records; the whole output of the default run has at most sixty lines.
#[test]
fn summaries_are_short_and_have_their_numbers() {
    let mut lines = 0;
    for experiment in EXPERIMENTS {
        let found = result(&recorded_folder().join(experiment.id)).expect("a record");
        headline(experiment.headline, &found).expect("numbers that are recorded");
        let label = format!("[34 of 34] {}, 123.4 s", experiment.id);
        let text = summary(experiment, &found, &label, Path::new("out"));
        let longest = text.lines().map(|line| line.chars().count()).max();
        assert!(
            text.lines().count() <= 2 && longest.is_some_and(|longest| longest <= LINE_WIDTH),
            "{text}"
        );
        if !NOT_BY_DEFAULT.contains(&experiment.id) {
            lines += text.lines().count();
        }
    }
    // Verdicts, at most five undecided ones, omitted experiments, where the book begins.
    assert!(lines + 12 <= 60, "{lines} lines");
}

#[test]
fn the_stated_time_of_the_default_run_is_the_recorded_one() {
    let record = result(&recorded_folder().join(DEFAULT_RUN)).expect("a record");
    assert!(record.numbers["threads"] == 2.0, "recorded on two cores");
    let minutes = record.numbers["seconds"] / 60.0;
    assert!(
        (0.6..=1.5).contains(&minutes),
        "--help says about a minute, the record {minutes:.1}"
    );
    assert!(record.numbers["undecided"] <= 5.0);
}

/// Three verdicts, and the closing lines.
#[test]
fn what_fails_is_named_and_what_is_undecided_counted() {
    use Judgement::{Fails, Holds, Undecided};
    let fine = outcome(&[
        ("fine", "1", Some(Holds)),
        ("fine", "1", None),
        ("fine", "1", Some(Holds)),
    ]);
    let said = "2 hold, 0 fail, 0 undecided at this tier";
    assert_eq!(
        verdicts(std::slice::from_ref(&fine)),
        (said.to_owned(), true)
    );
    let mut failing = outcome(&[
        ("fine", "1", Some(Undecided)),
        ("the claim", "1", Some(Fails)),
        ("fine", "1", Some(Holds)),
    ]);
    // A detail that fails is shown, others only on request.
    failing
        .findings
        .iter_mut()
        .for_each(|row| row.detail = true);
    let said = "FAILS: room: the claim: 1\nundecided: room: fine: 1\n3 hold, 1 fail, 1 undecided at this tier";
    assert_eq!(verdicts(&[fine, failing.clone()]), (said.to_owned(), false));
    let short = table(&failing, false);
    assert!(
        short.contains("the claim  1 FAILS") && !short.contains("fine"),
        "{short}"
    );
    assert!(short.contains("2 more rows with --rows"), "{short}");
    let long = table(&failing, true);
    assert!(long.contains("fine       1 undecided"), "{long}");
}

/// A claim that fails gives exit code 1, whether it is new or kept.
#[test]
fn a_failed_claim_is_an_exit_code() {
    let options = quick(folder("exit"), 1);
    let end = |verdict| print_summary(&[outcome(&[("a claim", "1", Some(verdict))])], &options);
    assert_eq!(end(Judgement::Holds), Ending::Done);
    assert_eq!(end(Judgement::Undecided), Ending::Done);
    assert_eq!(end(Judgement::Fails), Ending::ClaimFails);
}

#[test]
fn progress_says_rates_and_what_is_left() {
    let after =
        |done, size, seconds| state(done, size, "samples", Duration::from_secs_f64(seconds));
    assert_eq!(
        after(13_500_000, 27_000_000, 10.0),
        "50 % of 27.0 million samples, 1.35 million/s, 10 s left"
    );
    assert_eq!(
        after(1, 200, 90.0),
        "0 % of 200 samples, 0.7 per minute, 4 h 58 min left"
    );
    assert_eq!(after(199, 200, 10.0), "99 % of 200 samples, 20/s, 0 s left");
    assert_eq!(after(0, 200, 0.0), "0 % of 200 samples");
    assert_eq!(after(0, 0, 75.0), "1 min 15 s");
    assert_eq!(after(12, 0, 75.0), "12 samples, 1 min 15 s");
}
