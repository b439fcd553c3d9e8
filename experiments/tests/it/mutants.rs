//! Tests of the record of cargo-mutants.

use std::fs;
use std::path::Path;
use std::process::Command;

use experiments::run::record::recorded_folder;
use records::mutants::{Counts, FILE, Record};

use crate::folder;

/// Writes a run of cargo-mutants with these outcomes of mutants in two files.
fn outcomes(mutants: &[(&str, &str, &str)]) -> String {
    let outcome = |(file, what, summary): &(&str, &str, &str)| {
        format!(
            r#"{{"scenario": {{"Mutant": {{"name": "{file}:{what}", "file": "{file}", "replacement": "-"}}}},
                "summary": "{summary}", "phase_results": []}}"#
        )
    };
    let mutants: Vec<String> = mutants.iter().map(outcome).collect();
    format!(
        r#"{{"cargo_mutants_version": "27.1.0", "total_mutants": 9,
            "outcomes": [{{"scenario": "Baseline", "summary": "Success"}}, {}]}}"#,
        mutants.join(", ")
    )
}

#[test]
fn mutants_are_recorded_with_the_reasons_of_survivors() {
    let folder = folder("mutants");
    let record = |runs: &[String]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_record-mutants"));
        for (i, run) in runs.iter().enumerate() {
            let path = folder.join(format!("{i}.json"));
            fs::write(&path, run).expect("file");
            command.arg(path);
        }
        let output = command
            .arg("--folder")
            .arg(&folder)
            .output()
            .expect("the program starts");
        (
            output.status.code(),
            String::from_utf8_lossy(&output.stdout).into_owned(),
        )
    };
    let first = outcomes(&[
        ("src/a.rs", "1:5: replace + with -", "CaughtMutant"),
        ("src/a.rs", "2:5: replace | with ^", "MissedMutant"),
        ("src/a.rs", "3:5: replace * with /", "MissedMutant"),
        ("src/b.rs", "9:9: replace f with ()", "Timeout"),
        ("src/b.rs", "9:9: replace f with 1", "Unviable"),
    ]);
    // The second run tests survivors again.
    let (code, text) = record(&[
        first,
        outcomes(&[("src/a.rs", "3:5: replace * with /", "CaughtMutant")]),
    ]);
    assert_eq!(code, Some(0));
    assert!(
        text.contains("no reason yet: src/a.rs:2:5: replace | with ^"),
        "{text}"
    );
    assert!(text.contains("all: 3 of 4 killed"), "{text}");
    let mut found = Record::read(&folder).expect("a record");
    assert_eq!(
        found.files["src/a.rs"],
        Counts {
            caught: 2,
            missed: 1,
            ..Counts::default()
        }
    );
    assert_eq!(
        (
            found.files["src/b.rs"].timeout,
            found.files["src/b.rs"].unviable
        ),
        (1, 1)
    );
    // A reason stays with its mutant when lines move; other files are unchanged.
    found.survivors[0].reason = "the bits do not overlap".to_owned();
    let text = serde_json::to_string(&found).expect("json");
    fs::write(folder.join(FILE), text).expect("file");
    let (code, text) = record(&[outcomes(&[(
        "src/a.rs",
        "7:5: replace | with ^",
        "MissedMutant",
    )])]);
    assert_eq!((code, text.contains("no reason yet")), (Some(0), false));
    let found = Record::read(&folder).expect("a record");
    assert_eq!(found.survivors.len(), 1);
    assert_eq!(found.survivors[0].mutant, "src/a.rs:7:5: replace | with ^");
    assert_eq!(found.survivors[0].reason, "the bits do not overlap");
    assert_eq!(found.total().viable(), 2);
    let (code, _) = record(&[outcomes(&[("src/a.rs", "1:1: x", "Failure")])]);
    assert_eq!(code, Some(2));
}

#[test]
fn every_recorded_mutant_that_survives_has_a_reason() {
    let known = Record::read(&recorded_folder()).expect("a record");
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for file in known.files.keys() {
        assert!(
            root.join(file).is_file(),
            "{file} is recorded, but not there"
        );
    }
    assert_eq!(known.survivors.len(), known.total().missed);
    for survivor in &known.survivors {
        assert!(
            !survivor.reason.is_empty(),
            "{} has no reason",
            survivor.mutant
        );
    }
}
