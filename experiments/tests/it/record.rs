//! Tests of the results that the book records, and of recording them.

use std::fs;
use std::io::Cursor;
use std::process::Command;

use experiments::experiments::EXPERIMENTS;
use experiments::plot::trial_cells;
use experiments::run::record::{MAX_RECORDED_BYTES, record, recorded_folder, result};
use records::results::DEFAULT_RUN;
use whitefurnace::harness::mean::{Values, mean};
use whitefurnace::harness::outcome::Claim;
use whitefurnace::harness::trial::write_cells;
use whitefurnace::image::write_rgb;

use crate::{folder, refused, run};

#[test]
fn recorded_results_are_those_of_the_code() {
    let book = recorded_folder();
    let mut stale = Vec::new();
    for entry in fs::read_dir(&book).expect("the recorded folder") {
        let path = entry.expect("an entry").path();
        if !path.is_dir() {
            continue;
        }
        let id = path.file_name().expect("a name").to_string_lossy();
        if id == DEFAULT_RUN {
            continue;
        }
        let experiment = EXPERIMENTS.iter().find(|e| e.id == id);
        match (experiment, result(&path)) {
            (None, _) => stale.push(format!("{id}: no such experiment")),
            (_, None) => stale.push(format!("{id}: result.json cannot be read")),
            (Some(e), Some(found)) if (e.id, e.version) != (&found.id, found.version) => {
                stale.push(format!(
                    "{id}: recorded {} version {}, the code has version {}",
                    found.id, found.version, e.version
                ));
            }
            (Some(e), Some(found)) => {
                let lacks = |id: &&str| !found.equations.iter().any(|other| other == id);
                let lacking: Vec<&str> = e.equations.iter().map(|e| e.id).filter(lacks).collect();
                if !lacking.is_empty() {
                    stale.push(format!("{id}: recorded without equations {lacking:?}"));
                }
            }
        }
    }
    assert!(
        stale.is_empty(),
        "{}\nrun cargo run --release -- --tier full --update-book",
        stale.join("\n")
    );
}

#[test]
fn recording_divides_large_pictures_and_leaves_out_large_plots() {
    let folder = folder("record");
    let [from, to] = ["from", "to"].map(|name| folder.join(name));
    fs::create_dir_all(&from).expect("folder");
    fs::create_dir_all(&to).expect("folder");
    fs::write(to.join("old.svg"), "old").expect("file");
    fs::write(from.join("a.svg"), "plot").expect("file");
    fs::write(from.join("b.svg"), vec![0; MAX_RECORDED_BYTES as usize + 1]).expect("file");
    let size = [640, 401];
    let noise: Vec<u8> = (0..3 * size[0] * size[1])
        .map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8 ^ (i.wrapping_mul(i) >> 7) as u8)
        .collect();
    write_rgb(&from.join("c.png"), size, &noise).expect("picture");
    let written = r#"{"id": "demo", "title": "", "version": 1, "tier": "full", "seed": 1, "shrink": 1,
        "command": "", "equations": [], "numbers": {"x": 1.5}, "figures": ["a.svg", "b.svg", "c.png"],
        "findings": [], "fingerprint": "abc"}"#;
    fs::write(from.join("result.json"), written).expect("file");
    assert_eq!(record(&from, &to).expect("recorded"), ["b.svg"]);
    let found = result(&to).expect("a result");
    assert_eq!(found.figures, ["a.svg", "c.png"]);
    assert!(found.fingerprint.is_empty());
    assert!(to.join("a.svg").is_file() && !to.join("b.svg").exists());
    let mut joined = Vec::new();
    for band in (1..).map(|k| to.join(format!("c.band-{k}.png"))) {
        let Ok(bytes) = fs::read(&band) else { break };
        assert!(
            bytes.len() as u64 <= MAX_RECORDED_BYTES,
            "{}",
            band.display()
        );
        let mut reader = png::Decoder::new(Cursor::new(bytes))
            .read_info()
            .expect("a PNG");
        // Except for the last, bands can be shown at a quarter of their size without seams.
        assert!(
            joined.len() % (4 * 3 * size[0] as usize) == 0,
            "{}",
            band.display()
        );
        let mut rows = vec![0; reader.output_buffer_size().expect("a size")];
        reader.next_frame(&mut rows).expect("pixels");
        joined.extend(rows);
    }
    assert!(joined == noise && !to.join("c.png").exists());
    assert!(!to.join("old.svg").exists());
}

#[test]
fn cells_of_a_failed_trial_are_plotted_and_bad_files_refused() {
    let folder = folder("cells");
    let plot = |name: &str, text: &str| {
        fs::write(folder.join(name), text).expect("file");
        run(env!("CARGO_BIN_EXE_plot-cells"), &folder, name)
    };
    let good = plot(
        "good.csv",
        "place,expected,observed,sigmas\n\"u, v\",1e3,1.1e3,3.2\n\"w\",5e2,4.9e2,-0.4\n",
    );
    assert!(good.status.success());
    assert!(
        fs::read_to_string(folder.join("good.svg"))
            .expect("a plot")
            .contains("u, v")
    );
    for (text, line) in [
        ("a,b\n", "line 1"),
        ("place,expected,observed,sigmas\n", "line 2"),
        ("place,expected,observed,sigmas\n\"x\",1,2\n", "line 2"),
    ] {
        refused(&plot("bad.csv", text), line);
    }
}

/// The program plots the data file of a failed mean, as the trial leaves it.
#[test]
fn batches_of_a_mean_are_plotted() {
    let folder = folder("batches");
    let mut i = 0;
    let values = Values::collect(0.0, 1000, || {
        i += 1;
        f64::from(i % 3)
    });
    let outcome = mean("mean, of i", &values, 2.0, Claim::Equal { delta: 0.1 });
    let path = write_cells("toy/mean", &outcome, &folder)
        .expect("written")
        .expect("cells");
    assert_eq!(
        trial_cells::read(&path).expect("a data file").len(),
        outcome.cells.len()
    );
    let plot = Command::new(env!("CARGO_BIN_EXE_plot-cells"))
        .arg(&path)
        .output()
        .expect("the program starts");
    assert!(plot.status.success());
    assert!(
        fs::read_to_string(path.with_extension("svg"))
            .expect("a plot")
            .contains(" (16 values)")
    );
}
