//! Traces every equation to its code, trial, experiment and chapter, and lists each gap in one
//! line.

use book::Options;
use book::trace::Sources;
use records::readme::with_numbers;
use records::results::Results;
use trials::all;

#[test]
fn nothing_is_missing_between_equation_and_chapter() {
    let options = Options::default();
    let sources = Sources::read(&options.sources).expect("the sources can be read");
    let results = Results::load(&options.results).expect("the recorded results can be read");
    let missing_links = sources.missing_links(&all(), &results);
    assert!(
        missing_links.is_empty(),
        "{} missing links:\n{}",
        missing_links.len(),
        missing_links.join("\n")
    );
}

#[test]
fn the_readme_says_what_was_recorded() {
    let options = Options::default();
    let text =
        std::fs::read_to_string(options.sources.join("README.md")).expect("the README can be read");
    let results = Results::load(&options.results).expect("the recorded results can be read");
    assert!(text.contains("<!--errata."), "no number is left");
    let again = "`cargo run --release -- --tier full --only errata --update-book` writes it anew";
    assert_eq!(with_numbers(&text, &results).as_ref(), Ok(&text), "{again}");
    let found = |text: &str| with_numbers(text, &results);
    assert_eq!(
        found("so <!--errata.sphere.single.1e2 %.1%-->9<!----> far"),
        found("so <!--errata.sphere.single.1e2 %.1%--><!----> far")
    );
    for broken in [
        "<!--errata.nothing-->1<!---->",
        "<!--errata.divided",
        "<!--errata.divided-->1",
        "<!--errata.divided %x-->1<!---->",
    ] {
        assert!(found(broken).is_err(), "{broken}");
    }
}
