//! Tests that interrupted runs resume, finished runs are kept, and accumulated evidence is judged
//! once.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::sync::atomic::{AtomicU64, Ordering};

use experiments::experiments::EXPERIMENTS;
use experiments::experiments::agreement::AGREEMENT;
use experiments::experiments::suite_seeds::SHARED_BY;
use experiments::run::Experiment;
use experiments::run::accumulated::{Accumulated, level_of_look};
use experiments::run::record::run_all;
use whitefurnace::error::Error;

use crate::{folder, quick, refuses, reproduce, text};

/// Part of the toy experiment at which it is interrupted.
static STOP: AtomicU64 = AtomicU64::new(u64::MAX);

/// An experiment whose evidence grows by four rows per run.
const TOY: Experiment = Experiment {
    id: "toy",
    title: "a toy",
    headline: "it ran",
    version: 1,
    equations: &[],
    run: |run| {
        let mut accumulated = run.accumulated("toy.csv", "key", "replication,value")?;
        let first = accumulated.next();
        let shared = run.shared("toys", "key")?;
        for k in 0..4 {
            let make = || {
                if k == STOP.load(Ordering::Relaxed) {
                    return Err(Error::Interrupted);
                }
                // A value that needs all its digits in a file.
                Ok(((first + k) as f64 + 0.1).sin())
            };
            let value = if k % 2 == 0 {
                run.part(&format!("part-{k}"), make)
            } else {
                shared.part(&format!("part-{}", first + k), make)
            }?;
            accumulated.push(first + k, &[format!("{value:e}")]);
        }
        let level = accumulated.look(1e-3);
        accumulated.write()?;
        run.number("level", level);
        run.note("rows", accumulated.rows().len().to_string());
        let [none, odd] = [-1.0 / 0.0, f64::NAN];
        run.note(
            "no number",
            format!("order {none:.2}, ± {odd:.1} %; information"),
        );
        Ok(())
    },
};

/// Three runs give the same files as three that are interrupted at every place. This covers every
/// file of accumulated rows, as all are written by the same code.
#[test]
fn interrupted_and_continued_is_uninterrupted() {
    let go = |out: &Path| run_all(&[&TOY], &quick(out.to_owned(), 1), true).is_ok();
    let files = |out: &Path| {
        ["toy.csv", "result.json"]
            .map(|file| fs::read_to_string(out.join("toy").join(file)).expect("a file"))
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
        // Neither the rows nor the result can be written.
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

/// Returns the files below a folder and their bytes.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let files = book::check::files(folder).expect("the folder is there");
    let relative = |file: &Path| file.strip_prefix(folder).expect("below").to_owned();
    files
        .iter()
        .map(|file| (relative(file), fs::read(file).expect("a file")))
        .collect()
}

/// The experiment with the most parts and accumulated rows gives the same files in one run and when
/// interrupted before its last file, with a third of its parts missing.
#[test]
fn agreement_goes_on() {
    let go = |out: &Path| run_all(&[&AGREEMENT], &quick(out.to_owned(), 4096), true).map(drop);
    let [whole, pieces] = ["whole", "pieces"].map(|name| folder(&format!("agreement-{name}")));
    go(&whole).expect("a run");
    let made = pieces.join("agreement");
    // A folder in place of the file interrupts the run.
    let result = made.join("result.json");
    fs::create_dir_all(&result).expect("a folder in the way");
    assert!(go(&pieces).is_err_and(|error| error.to_string().contains("result.json")));
    fs::remove_dir(&result).expect("removed");
    let unfinished = files(&made.join("unfinished"));
    let is_part = |name: &&PathBuf| name.extension().is_some_and(|e| e == "json");
    let parts: Vec<&PathBuf> = unfinished.keys().filter(is_part).collect();
    assert!(parts.len() > 9, "{parts:?}");
    for part in parts.iter().step_by(3) {
        fs::remove_file(made.join("unfinished").join(part)).expect("removed");
    }
    go(&pieces).expect("a continued run");
    assert!(
        files(&made) == files(&whole.join("agreement")),
        "it went on otherwise"
    );
}

/// Counts the experiments that a run kept from an earlier one.
fn kept(output: &Output) -> usize {
    text(&output.stdout)
        .matches("kept from an earlier run")
        .count()
}

#[test]
fn reproduce_goes_on_where_it_stopped() {
    let folder = folder("resume");
    let options = "--shrink 4096 --only fig9 --only watertight --threads 2";
    let first = reproduce(&folder, options);
    assert!(first.status.success(), "{}", text(&first.stderr));
    let results = folder.join("out/results.json");
    let json: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(&results).expect("results")).expect("JSON");
    let experiments = json["experiments"].as_array().expect("a list");
    assert_eq!(experiments.len(), 2);
    assert_eq!(experiments[1]["numbers"]["edges.lost"], 0.0);
    let bytes = fs::read(&results).expect("results");

    let kept = |options: &str| kept(&reproduce(&folder, options));
    assert_eq!(kept(options), 2);
    assert_eq!(fs::read(&results).expect("results"), bytes);
    // A missing or damaged file, a new one, other options or --fresh: the result is made again.
    let figure = folder.join("out/fig9/noise.png");
    fs::remove_file(&figure).expect("removed");
    assert_eq!((kept(options), kept(options)), (1, 2));
    for file in ["noise.png", "noise.exr"] {
        let path = folder.join("out/fig9").join(file);
        let mut garbled = fs::read(&path).expect("a file");
        let middle = garbled.len() / 2;
        garbled[middle] ^= 1;
        fs::write(&path, &garbled).expect("written");
        assert_eq!(kept(options), 1, "{file}");
        assert!(fs::read(&path).expect("a file") != garbled);
    }
    for changed in [
        format!("{options} --seed 2"),
        format!("{options} --seed 2 --fresh"),
    ] {
        let before = fs::read(&figure).expect("a figure");
        assert_eq!(kept(&changed), 0);
        // The seed affects the figure.
        assert_eq!(
            fs::read(&figure).expect("a figure") == before,
            changed.ends_with("--fresh")
        );
    }
}

/// A result is inserted among those of other experiments, once.
#[test]
fn results_of_one_experiment_leave_the_others() {
    let folder = folder("results");
    let results = |options: &str| -> Vec<(String, u64, String)> {
        let output = reproduce(&folder, options);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let text = fs::read_to_string(folder.join("out/results.json")).expect("results");
        let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        assert!(json["shrink"].is_u64());
        let found = json["experiments"].as_array().expect("a list").iter();
        let found = found.map(|experiment| {
            let word = |key: &str| experiment[key].as_str().expect("a text").to_owned();
            (
                word("id"),
                experiment["shrink"].as_u64().expect("a number"),
                word("command"),
            )
        });
        found.collect()
    };
    let command = |id: &str, shrink: u32| {
        format!("cargo run --release --bin {id} -- --tier quick --seed 1 --shrink {shrink}")
    };
    let row = |id: &str, shrink: u32| (id.to_owned(), u64::from(shrink), command(id, shrink));
    let both = results("--shrink 4096 --only watertight,fig9 --only fig9");
    assert_eq!(both, [row("fig9", 4096), row("watertight", 4096)]);
    let again = results("--shrink 2048 --only fig9");
    assert_eq!(again, [row("fig9", 2048), row("watertight", 4096)]);
}

/// Shards run at once, into one folder.
#[test]
fn shards_of_reproduce_are_the_whole() {
    let [parts, whole] = ["shards-parts", "shards-whole"].map(folder);
    let options = "--shrink 4096 --only fig9 --only watertight --only room";
    let shard = |i: u32| reproduce(&parts, &format!("{options} --shard {i}/2"));
    let made = std::thread::scope(|scope| {
        [1, 2]
            .map(|i| scope.spawn(move || shard(i)))
            .map(|made| made.join().expect("it ran"))
    });
    for (made, share) in made.iter().zip([2, 1]) {
        assert!(made.status.success(), "{}", text(&made.stderr));
        assert_eq!(
            text(&made.stdout)
                .lines()
                .filter(|line| line.starts_with('['))
                .count(),
            share
        );
    }
    assert!(
        !parts.join("out/results.json").exists(),
        "a shard does not know the others"
    );
    assert_eq!(kept(&reproduce(&parts, options)), 3);
    assert!(reproduce(&whole, options).status.success());
    assert!(files(&parts.join("out")) == files(&whole.join("out")));

    // With the largest number of shards, each experiment is in one, and experiments that share a
    // folder are in the same.
    let list = |shard: &str| -> Vec<String> {
        let listed = text(&reproduce(&whole, &format!("--list --shard {shard}")).stdout);
        listed
            .lines()
            .map(|line| line.split(' ').next().expect("a name").to_owned())
            .collect()
    };
    let shards: Vec<Vec<String>> = (1..EXPERIMENTS.len())
        .map(|i| list(&format!("{i}/{}", EXPERIMENTS.len() - 1)))
        .collect();
    assert!(
        shards
            .iter()
            .all(|shard| shard.len() == 1 || *shard == SHARED_BY)
    );
    let all: BTreeSet<&String> = shards.iter().flatten().collect();
    assert_eq!(
        (all.len(), shards.iter().flatten().count()),
        (EXPERIMENTS.len(), EXPERIMENTS.len())
    );
    for case in [
        "--shard 2/1 => i/n",
        "--shard -1/2 => i/n",
        "--only fig9 --shard 1/2 => --shard 1/2: the experiments are 1 parts",
        "--shard 1/2 --update-book --tier full => '--update-book'",
    ] {
        refuses(case, |options| reproduce(&whole, options));
    }
}

#[test]
fn looks_at_accumulated_rows_spend_the_level_once() {
    // 6/π² Σ 1/k² = 1, and the rest after K terms lies between 6/π²/(K + 1) and 6/π²/K.
    let spent = |looks: u32| (1..=looks).map(|k| level_of_look(1e-3, k)).sum::<f64>();
    let share = 6.0 / (std::f64::consts::PI * std::f64::consts::PI);
    for looks in [1, 10, 10_000] {
        let rest = (1.0 - spent(looks) / 1e-3) / share;
        let k = f64::from(looks);
        assert!(1.0 / (k + 1.0) < rest && rest < 1.0 / k, "{looks}: {rest}");
    }
    let path = folder("accumulated").join("a.csv");
    for look in 1..=3 {
        let mut accumulated =
            Accumulated::continued(&path, path.clone(), "seed 1", "replication,p");
        assert_eq!(
            (accumulated.looks(), accumulated.next()),
            (look - 1, u64::from(look - 1))
        );
        assert_eq!(accumulated.look(0.01), level_of_look(0.01, look));
        accumulated.push(accumulated.next(), &[String::from("0.5")]);
        accumulated.write().expect("written");
    }
    let text = fs::read_to_string(&path).expect("the rows");
    assert_eq!(
        text,
        "# seed 1\n# looks: 3\nreplication,p\n0,0.5\n1,0.5\n2,0.5\n"
    );
    // Other random numbers are other evidence, which has not been looked at.
    for (key, columns) in [("seed 2", "replication,p"), ("seed 1", "replication,q")] {
        let other = Accumulated::continued(&path, path.clone(), key, columns);
        assert_eq!((other.looks(), other.rows().len()), (0, 0));
    }
}
