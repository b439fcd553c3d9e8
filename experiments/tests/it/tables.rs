//! What is said of findings, and of work in progress.

use std::time::Duration;

use experiments::run::Judgement;
use experiments::run::cli::{Ending, conclude};
use experiments::run::progress::state;
use experiments::run::record::{LONGEST_LINE, table, verdicts};

use crate::{folder, outcome, quick};

#[test]
fn lines_of_tables_are_never_too_long() {
    let long = (0..100).map(|i| format!("word{i}")).collect::<Vec<_>>().join(" ");
    let holds = Some(Judgement::Holds);
    let found = outcome(&[("  furnace/sky/path", &long, holds), ("short", "0.5 ± 0.1", Some(Judgement::Fails))]);
    let text = table(&found, "1 s", false);
    let longest = text.lines().map(|line| line.chars().count()).max();
    assert!(longest.is_some_and(|longest| (120..=LONGEST_LINE).contains(&longest)), "{text}");
    let words: Vec<&str> = text.split_whitespace().collect();
    assert!(words.join(" ").contains(&(long + " holds short 0.5 ± 0.1 FAILS")), "{text}");
}

/// Three verdicts, and what is said at the end.
#[test]
fn what_fails_is_named_and_what_is_undecided_counted() {
    use Judgement::{Fails, Holds, Undecided};
    let fine = outcome(&[("fine", "1", Some(Holds)), ("fine", "1", None), ("fine", "1", Some(Holds))]);
    let said = "2 hold, 0 fail, 0 undecided at this tier";
    assert_eq!(verdicts(std::slice::from_ref(&fine)), (said.to_owned(), true));
    let mut failing =
        outcome(&[("fine", "1", Some(Undecided)), ("the claim", "1", Some(Fails)), ("fine", "1", Some(Holds))]);
    // A detail that fails is shown, others on request.
    failing.findings.iter_mut().for_each(|row| row.detail = true);
    let said = "FAILS: room: the claim: 1\n3 hold, 1 fail, 1 undecided at this tier";
    assert_eq!(verdicts(&[fine, failing.clone()]), (said.to_owned(), false));
    let short = table(&failing, "1 s", false);
    assert!(short.contains("the claim  1 FAILS") && !short.contains("fine"), "{short}");
    assert!(short.contains("2 rows more with --rows"), "{short}");
    let long = table(&failing, "1 s", true);
    assert!(long.contains("fine       1 undecided"), "{long}");
}

/// A claim that fails is exit code 1, whether it is found or kept.
#[test]
fn a_failed_claim_is_an_exit_code() {
    let options = quick(folder("exit"), 1);
    let end = |verdict| conclude(&[outcome(&[("a claim", "1", Some(verdict))])], &options);
    assert_eq!(end(Judgement::Holds), Ending::Done);
    assert_eq!(end(Judgement::Undecided), Ending::Done);
    assert_eq!(end(Judgement::Fails), Ending::ClaimFails);
}

#[test]
fn progress_says_rates_and_what_is_left() {
    let after = |done, size, seconds| state(done, size, "samples", Duration::from_secs_f64(seconds));
    assert_eq!(after(13_500_000, 27_000_000, 10.0), "50 % of 27.0 million samples, 1.35 million/s, 10 s left");
    assert_eq!(after(1, 200, 90.0), "0 % of 200 samples, 0.7 per minute, 4 h 58 min left");
    assert_eq!(after(199, 200, 10.0), "99 % of 200 samples, 20/s, 0 s left");
    assert_eq!(after(0, 200, 0.0), "0 % of 200 samples");
    assert_eq!(after(0, 0, 75.0), "1 min 15 s");
}
