//! From every equation to its code, trial, experiment and chapter: one line per hole.

use std::path::Path;

use book::trace::Sources;
use registry::all;

#[test]
fn nothing_is_missing_between_equation_and_chapter() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
    let sources = Sources::read(root).expect("the sources can be read");
    assert!(!sources.experiments().is_empty(), "no experiment found");
    let holes = sources.holes(&all());
    assert!(holes.is_empty(), "{} holes:\n{}", holes.len(), holes.join("\n"));
}
