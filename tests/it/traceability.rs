//! From every equation to its code, trial, experiment and chapter: one line per hole.

#[path = "../../book/src/trace.rs"]
mod trace;

use std::path::Path;

use whitefurnace::trials::all;

#[test]
fn nothing_is_missing_between_equation_and_chapter() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let sources = trace::Sources::read(root).expect("the sources can be read");
    assert!(!sources.experiments().is_empty(), "no experiment found");
    let holes = sources.holes(&all());
    assert!(
        holes.is_empty(),
        "{} holes:\n{}",
        holes.len(),
        holes.join("\n")
    );
}
