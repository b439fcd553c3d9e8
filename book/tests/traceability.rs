//! From every equation to its code, trial, experiment and chapter: one line per hole.

use book::Options;
use book::results::Results;
use book::trace::Sources;
use registry::all;

#[test]
fn nothing_is_missing_between_equation_and_chapter() {
    let options = Options::default();
    let sources = Sources::read(&options.sources).expect("the sources can be read");
    let results = Results::load(&options.results).expect("the recorded results can be read");
    let holes = sources.holes(&all(), &results);
    assert!(holes.is_empty(), "{} holes:\n{}", holes.len(), holes.join("\n"));
}
