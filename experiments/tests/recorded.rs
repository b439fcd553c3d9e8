//! Results that the book keeps, and how they get there.

use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use book::mutants::{Counts, FILE, Record};
use experiments::cli::{Ending, conclude};
use experiments::lab::{Experiment, Finding, Judgement, Options, Tier};
use experiments::ledger::{Ledger, level_of_look};
use experiments::plot::map::{Map, diverging, maps};
use experiments::progress::state;
use experiments::record::{
    LARGEST_RECORDED, LONGEST_LINE, record, recorded, recorded_folder, run_all, table, verdicts,
};
use experiments::{EXPERIMENTS, cells};
use whitefurnace::error::Error;
use whitefurnace::harness::mean::{Values, mean};
use whitefurnace::harness::outcome::Claim;
use whitefurnace::harness::trial::{Row, write_cells};
use whitefurnace::image::write_rgb;

fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(test);
    if folder.exists() {
        fs::remove_dir_all(&folder).expect("an old test folder can be removed");
    }
    fs::create_dir_all(&folder).expect("a test folder can be made");
    folder
}

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
        let experiment = EXPERIMENTS.iter().find(|e| e.id == id);
        match (experiment, recorded(&book, &id)) {
            (None, _) => stale.push(format!("{id}: no such experiment")),
            (_, None) => stale.push(format!("{id}: result.json cannot be read")),
            (Some(e), Some(found)) if (e.id, e.version) != (&found.id, found.version) => {
                stale.push(format!(
                    "{id}: recorded {} version {}, the code has version {}",
                    found.id, found.version, e.version
                ));
            }
            _ => {}
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
    fs::write(from.join("b.svg"), vec![0; LARGEST_RECORDED as usize + 1]).expect("file");
    let size = [640, 401];
    let noise: Vec<u8> = (0..3 * size[0] * size[1])
        .map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8 ^ (i.wrapping_mul(i) >> 7) as u8)
        .collect();
    write_rgb(&from.join("c.png"), size, &noise).expect("picture");
    let result = r#"{"id": "demo", "title": "", "version": 1, "tier": "full", "seed": 1,
        "command": "", "equations": [], "numbers": {"x": 1.5}, "figures": ["a.svg", "b.svg", "c.png"],
        "findings": [], "fingerprint": "abc"}"#;
    fs::write(from.join("result.json"), result).expect("file");
    assert_eq!(record(&from, &to).expect("recorded"), ["b.svg"]);
    let found = recorded(&folder, "to").expect("a result");
    assert_eq!(found.figures, ["a.svg", "c.png"]);
    assert!(found.fingerprint.is_empty());
    assert!(to.join("a.svg").is_file() && !to.join("b.svg").exists());
    let mut joined = Vec::new();
    for band in (1..).map(|k| to.join(format!("c.band-{k}.png"))) {
        let Ok(bytes) = fs::read(&band) else { break };
        assert!(bytes.len() as u64 <= LARGEST_RECORDED, "{}", band.display());
        let mut reader = png::Decoder::new(Cursor::new(bytes))
            .read_info()
            .expect("a PNG");
        let mut rows = vec![0; reader.output_buffer_size().expect("a size")];
        reader.next_frame(&mut rows).expect("pixels");
        joined.extend(rows);
    }
    assert!(joined == noise && !to.join("c.png").exists());
    assert!(!to.join("old.svg").exists());
}

#[test]
fn only_full_runs_are_recorded() {
    for options in ["--update-book", "--update-book --tier full --shrink 2"] {
        let output = Command::new(env!("CARGO_BIN_EXE_reproduce"))
            .args(options.split(' '))
            .current_dir(folder("refuse"))
            .output()
            .expect("the program starts");
        assert_eq!(output.status.code(), Some(2), "{options}");
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(message.lines().count(), 1, "{message}");
        assert!(message.contains("--tier full"), "{message}");
    }
}

#[test]
fn cells_of_a_failed_trial_are_plotted_and_bad_files_refused() {
    let folder = folder("cells");
    let plot = |name: &str, text: &str| {
        fs::write(folder.join(name), text).expect("file");
        Command::new(env!("CARGO_BIN_EXE_plot-cells"))
            .arg(name)
            .current_dir(&folder)
            .output()
            .expect("the program starts")
    };
    let good = plot(
        "good.csv",
        "place,expected,observed,sigmas\n\"u, v\",1e3,1.1e3,3.2\n\"w\",5e2,4.9e2,-0.4\n",
    );
    assert!(good.status.success());
    let svg = fs::read_to_string(folder.join("good.svg")).expect("a plot");
    assert!(svg.contains("u, v"));
    for (text, line) in [
        ("a,b\n", "line 1"),
        ("place,expected,observed,sigmas\n", "line 2"),
        ("place,expected,observed,sigmas\n\"x\",1,2\n", "line 2"),
    ] {
        let bad = plot("bad.csv", text);
        assert_eq!(bad.status.code(), Some(2));
        let message = String::from_utf8_lossy(&bad.stderr);
        assert_eq!(message.lines().count(), 1, "{message}");
        assert!(message.contains(line), "{message}");
    }
}

#[test]
fn looks_at_a_ledger_spend_the_level_once() {
    // 6/π² Σ 1/k² = 1, and the rest after K terms lies between 6/π²/(K + 1) and 6/π²/K.
    let spent = |looks: u32| (1..=looks).map(|k| level_of_look(1e-3, k)).sum::<f64>();
    let share = 6.0 / (std::f64::consts::PI * std::f64::consts::PI);
    for looks in [1, 10, 10_000] {
        let rest = (1.0 - spent(looks) / 1e-3) / share;
        let k = f64::from(looks);
        assert!(1.0 / (k + 1.0) < rest && rest < 1.0 / k, "{looks}: {rest}");
    }
    let path = folder("ledger").join("a.csv");
    for look in 1..=3 {
        let mut ledger = Ledger::open(path.clone(), "seed 1", "replication,p");
        assert_eq!(
            (ledger.looks(), ledger.next()),
            (look - 1, u64::from(look - 1))
        );
        assert_eq!(ledger.look(0.01), level_of_look(0.01, look));
        ledger.push(ledger.next(), &[String::from("0.5")]);
        ledger.write().expect("a ledger");
    }
    let text = fs::read_to_string(&path).expect("the ledger");
    assert_eq!(
        text,
        "# seed 1\n# looks: 3\nreplication,p\n0,0.5\n1,0.5\n2,0.5\n"
    );
    // Other numbers are other evidence, at which nobody has looked.
    for (key, columns) in [("seed 2", "replication,p"), ("seed 1", "replication,q")] {
        let other = Ledger::open(path.clone(), key, columns);
        assert_eq!((other.looks(), other.rows().len()), (0, 0));
    }
}

/// The data file of a failed mean, as the trial leaves it, is one that the program plots.
#[test]
fn batches_of_a_mean_are_plotted() {
    let folder = folder("batches");
    let values = Values::collect(0.0, 1000, {
        let mut i = 0;
        move || {
            i += 1;
            f64::from(i % 3)
        }
    });
    let outcome = mean("mean, of i", &values, 2.0, Claim::Exact { delta: 0.1 });
    let row = Row {
        trial: String::from("toy/mean"),
        control: String::new(),
        property: String::new(),
        equation: "estimator",
        verdict: outcome.verdict(),
        outcome,
        seed: 1,
    };
    let path = write_cells(&row, &folder).expect("written").expect("cells");
    let found = cells::read(&path).expect("a data file");
    assert_eq!(found.len(), row.outcome.cells.len());
    let plot = Command::new(env!("CARGO_BIN_EXE_plot-cells"))
        .arg(&path)
        .output()
        .expect("the program starts");
    assert!(plot.status.success());
    let svg = fs::read_to_string(path.with_extension("svg")).expect("a plot");
    assert!(svg.contains(" (16 values)"));
}

#[test]
fn maps_hold_their_cells_in_colours_of_equal_weight() {
    let grey = diverging(0.0);
    assert!(grey[0] > 235 && grey.iter().all(|&channel| channel.abs_diff(grey[0]) <= 1));
    assert_eq!(diverging(-3.0), diverging(-1.0));
    // Relative luminance (ITU-R BT.709, linear) of both ends is about the same.
    let luminance = |share: f64| -> f64 {
        let linear = |channel: u8| (f64::from(channel) / 255.0).powf(2.2);
        let weights = [0.2126, 0.7152, 0.0722];
        let products = diverging(share).into_iter().zip(weights);
        products
            .map(|(channel, weight)| weight * linear(channel))
            .sum()
    };
    assert!((luminance(1.0) - luminance(-1.0)).abs() < 0.03);
    assert!(luminance(-1.0) < luminance(-0.5) && luminance(-0.5) < luminance(0.0));

    let path = folder("maps").join("map.svg");
    let map = Map {
        title: String::from("toy"),
        axes: [String::from("x"), String::from("y")],
        ranges: [[0.0, 1.0]; 2],
        size: [2, 1],
        values: vec![-1.0, 5.0],
        bound: 2.0,
        unit: String::from("residual (σ)"),
    };
    maps(
        &path,
        "two cells",
        [400, 300],
        1,
        std::slice::from_ref(&map),
    )
    .expect("a map");
    let svg = fs::read_to_string(&path).expect("a map");
    // The first bytes of every PNG.
    assert!(svg.contains("href=\"data:image/png;base64,iVBORw0KGgo"));
    assert!(svg.trim_end().ends_with("</svg>"));
    let short = Map {
        values: vec![0.0],
        ..map
    };
    assert!(maps(&path, "two cells", [400, 300], 1, &[short]).is_err());
}

#[test]
fn lines_of_tables_are_never_too_long() {
    let finding = |what: &str, value: String, holds: bool| Finding {
        what: what.to_owned(),
        value,
        verdict: Some(holds.into()),
        detail: false,
    };
    let mut outcome = recorded(&recorded_folder(), "room").expect("a recorded result");
    let long = (0..100)
        .map(|i| format!("word{i}"))
        .collect::<Vec<_>>()
        .join(" ");
    outcome.findings = vec![
        finding("  furnace/sky/path", long.clone(), true),
        finding("short", String::from("0.5 ± 0.1"), false),
    ];
    let text = table(&outcome, "1 s", false);
    let longest = text.lines().map(|line| line.chars().count()).max();
    assert!(
        longest.is_some_and(|longest| (120..=LONGEST_LINE).contains(&longest)),
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

/// A run of cargo-mutants with these ends of mutants of two files.
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
        let command = command.arg("--folder").arg(&folder);
        let output = command.output().expect("the program starts");
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
    // The second run tries survivors again.
    let second = outcomes(&[("src/a.rs", "3:5: replace * with /", "CaughtMutant")]);
    let (code, text) = record(&[first, second]);
    assert_eq!(code, Some(0));
    assert!(
        text.contains("no reason yet: src/a.rs:2:5: replace | with ^"),
        "{text}"
    );
    assert!(text.contains("all: 3 of 4 killed"), "{text}");
    let mut found = Record::read(&folder).expect("a record");
    let counts = Counts {
        caught: 2,
        timeout: 0,
        missed: 1,
        unviable: 0,
    };
    assert_eq!(found.files["src/a.rs"], counts);
    assert_eq!(
        (
            found.files["src/b.rs"].timeout,
            found.files["src/b.rs"].unviable
        ),
        (1, 1)
    );
    // A reason stays with its mutant when the lines move; other files stay as they are.
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

/// Three verdicts, old records among them, and what is said at the end.
#[test]
fn what_fails_is_named_and_what_is_undecided_counted() {
    let read = |verdict: &str| -> Finding {
        let text = format!(r#"{{"what": "w", "value": "v"{verdict}}}"#);
        serde_json::from_str(&text).expect("a finding")
    };
    for (text, verdict) in [
        (r#", "holds": true"#, Some(Judgement::Holds)),
        (r#", "holds": false"#, Some(Judgement::Fails)),
        (r#", "holds": null"#, None),
        ("", None),
        (r#", "verdict": "undecided""#, Some(Judgement::Undecided)),
        (r#", "verdict": null"#, None),
    ] {
        assert_eq!(read(text).verdict, verdict, "{text}");
        let again = serde_json::to_string(&read(text)).expect("JSON");
        let again: Finding = serde_json::from_str(&again).expect("a finding");
        assert_eq!(again.verdict, verdict, "{text}");
    }
    let mut outcome = recorded(&recorded_folder(), "room").expect("a recorded result");
    outcome.findings = [Some(true), None, Some(true)]
        .map(|holds| Finding {
            what: String::from("fine"),
            value: String::from("1"),
            verdict: holds.map(Judgement::from),
            detail: false,
        })
        .to_vec();
    let fine = outcome.clone();
    assert_eq!(
        verdicts(std::slice::from_ref(&fine)),
        (
            String::from("2 hold, 0 fail, 0 undecided at this tier"),
            true
        )
    );
    outcome.findings[0].verdict = Some(Judgement::Undecided);
    outcome.findings[1].verdict = Some(Judgement::Fails);
    outcome.findings[1].what = String::from("the claim");
    // A detail that fails is shown, others on request.
    outcome
        .findings
        .iter_mut()
        .for_each(|row| row.detail = true);
    assert_eq!(
        verdicts(&[fine, outcome.clone()]),
        (
            String::from("FAILS: room: the claim: 1\n3 hold, 1 fail, 1 undecided at this tier"),
            false
        )
    );
    let short = table(&outcome, "1 s", false);
    assert!(
        short.contains("the claim  1 FAILS") && !short.contains("fine"),
        "{short}"
    );
    assert!(short.contains("2 rows more with --rows"), "{short}");
    let long = table(&outcome, "1 s", true);
    assert!(long.contains("fine       1 undecided"), "{long}");
}

/// A claim that fails is exit code 1, whether it is found or kept.
#[test]
fn a_failed_claim_is_an_exit_code() {
    let outcome = recorded(&recorded_folder(), "room").expect("a recorded result");
    let options = Options {
        tier: Tier::Quick,
        out: folder("exit"),
        seed: 1,
        threads: None,
        shrink: 1,
        rows: false,
    };
    assert_eq!(
        conclude(std::slice::from_ref(&outcome), &options),
        Ending::Done
    );
    let mut failing = outcome;
    failing.findings.push(Finding {
        what: String::from("a claim"),
        value: String::from("1"),
        verdict: Some(Judgement::Fails),
        detail: false,
    });
    assert_eq!(conclude(&[failing], &options), Ending::ClaimFails);
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
}

/// At which of its parts the toy is interrupted.
static STOP: AtomicU64 = AtomicU64::new(u64::MAX);

/// Evidence that grows by four rows a run.
const TOY: Experiment = Experiment {
    id: "toy",
    title: "a toy",
    version: 1,
    equations: &[],
    run: |lab| {
        let mut ledger = lab.ledger("toy.csv", "key", "replication,value")?;
        let first = ledger.next();
        for k in 0..4 {
            let value = lab.part(&format!("part-{k}"), || {
                if k == STOP.load(Ordering::Relaxed) {
                    return Err(Error::Interrupted);
                }
                // What no file can round.
                Ok(((first + k) as f64 + 0.1).sin())
            })?;
            ledger.push(first + k, &[format!("{value:e}")]);
        }
        let level = ledger.look(1e-3);
        ledger.write()?;
        lab.number("level", level);
        lab.note("rows", ledger.rows().len().to_string());
        let [none, odd] = [-1.0 / 0.0, f64::NAN];
        lab.note(
            "no number",
            format!("order {none:.2}, ± {odd:.1} %; information"),
        );
        Ok(())
    },
};

/// Three runs, and three that are interrupted at every place: the files are the same. So it is with every
/// ledger, since there is no other way to one.
#[test]
fn interrupted_and_continued_is_uninterrupted() {
    let go = |out: &Path| {
        let options = Options {
            tier: Tier::Quick,
            out: out.to_owned(),
            seed: 1,
            threads: None,
            shrink: 1,
            rows: false,
        };
        run_all(&[&TOY], &options, true).is_ok()
    };
    let files = |out: &Path| {
        let read = |file: &str| fs::read_to_string(out.join("toy").join(file)).expect("a file");
        ["toy.csv", "result.json"].map(read)
    };
    let [whole, pieces] = ["toy-whole", "toy-pieces"].map(folder);
    let mut last = None;
    for round in 0..3 {
        assert!(go(&whole));
        for stop in 0..4 {
            STOP.store(stop, Ordering::Relaxed);
            assert!(!go(&pieces));
        }
        STOP.store(u64::MAX, Ordering::Relaxed);
        // Neither the ledger nor the result can be written.
        for file in ["toy.csv", "result.json"] {
            let path = pieces.join("toy").join(file);
            let aside = pieces.join("aside");
            let was = path.exists();
            if was {
                fs::rename(&path, &aside).expect("moved");
            }
            fs::create_dir(&path).expect("a folder in the way");
            assert!(!go(&pieces), "{file}");
            fs::remove_dir(&path).expect("removed");
            if was {
                fs::rename(&aside, &path).expect("moved");
            }
        }
        assert!(go(&pieces));
        let found = files(&pieces);
        assert_eq!(found, files(&whole), "round {round}");
        assert!(found[1].contains("order unknown, ± unknown %; information"));
        assert!(found[0].contains(&format!("# looks: {}\n", round + 1)));
        assert!(last.replace(found.clone()) != Some(found));
        assert!(!pieces.join("toy/unfinished").exists());
    }
}
