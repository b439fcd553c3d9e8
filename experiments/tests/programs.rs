//! The programs as a person meets them: bytes, errors, resumption.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use clap::{Args as _, CommandFactory as _};
use experiments::command::Render;
use experiments::{lab, signals};

/// A fresh folder for one test.
fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(test);
    if folder.exists() {
        std::fs::remove_dir_all(&folder).expect("an old test folder can be removed");
    }
    std::fs::create_dir_all(&folder).expect("a test folder can be made");
    folder
}

fn run(program: &str, folder: &Path, options: &str) -> Output {
    Command::new(program)
        .args(options.split_whitespace())
        .current_dir(folder)
        .output()
        .expect("the program starts")
}

fn render(folder: &Path, options: &str) -> Output {
    run(env!("CARGO_BIN_EXE_render"), folder, options)
}

/// Asserts that it renders.
fn renders(folder: &Path, options: &str) {
    let output = render(folder, options);
    assert!(
        output.status.success(),
        "{options}: {}",
        text(&output.stderr)
    );
}

fn reproduce(folder: &Path, options: &str) -> Output {
    run(env!("CARGO_BIN_EXE_reproduce"), folder, options)
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let folder = folder("threads");
    let cases = [
        "--convention physical --pixel random --spp 5",
        "--convention report --pixel jitter --grid 2 --spp 8",
        "--convention published --pixel grid --grid 3 --spp 9",
        "--estimator whitted --pixel centre --spp 3",
        "--scene diffuse-room --spp 3",
        "--scene cornell --light-sampling solid-angle --heuristic power --spp 3",
        "--diffuse eon --sampler sobol --scrambles 2 --spp 8",
        "--estimator photon --photons 3000 --radius 0.5 --spp 3",
        "--estimator photon --photons 3000 --gather no --sampler sobol --spp 16",
        "--estimator sppm --photons 3000 --radius 0.5 --spp 3",
        "--estimator light-tracer --spp 3",
        "--estimator bdpt --spp 2",
        "--scene diffuse-room --estimator radiosity --patches 60 --spp 2",
    ];
    for case in cases {
        let bytes = [1, 2, 16].map(|threads| {
            let out = format!("t{threads}.exr");
            let output = render(
                &folder,
                &format!("{case} --size 40x30 --threads {threads} --out {out}"),
            );
            assert!(output.status.success(), "{case}: {}", text(&output.stderr));
            std::fs::read(folder.join(out)).expect("the EXR is there")
        });
        assert!(
            bytes[0] == bytes[1] && bytes[0] == bytes[2],
            "{case}: threads changed the bytes"
        );
        let output = render(
            &folder,
            &format!("{case} --size 40x30 --seed 2 --out other.exr"),
        );
        assert!(output.status.success());
        let other = std::fs::read(folder.join("other.exr")).expect("the EXR is there");
        assert!(bytes[0] != other, "{case}: the seed changed nothing");
    }
}

#[test]
fn every_scene_renders_with_every_legal_estimator() {
    let folder = folder("scenes");
    for scene in [
        "report",
        "diffuse-room",
        "environment",
        "furnace-box",
        "cavity-cap",
        "glass-cube",
        "cornell",
    ] {
        let lit_by_background = ["environment", "glass-cube"].contains(&scene);
        let particles = (!lit_by_background).then_some("light-tracer");
        for estimator in ["bsdf", "light", "mis", "whitted", "report", "bdpt"]
            .into_iter()
            .chain(particles)
        {
            let options = format!("--scene {scene} --estimator {estimator} --size 16x12 --spp 2");
            renders(&folder, &options);
        }
        let options = format!("--scene {scene} --light-sampling solid-angle --size 16x12 --spp 2");
        renders(&folder, &options);
    }
}

#[test]
fn photons_go_wherever_there_are_lights() {
    let folder = folder("photons");
    for scene in [
        "report",
        "diffuse-room",
        "furnace-box",
        "cavity-cap",
        "cornell",
    ] {
        for estimator in ["photon", "photon --gather no", "sppm"] {
            let options = format!(
                "--scene {scene} --estimator {estimator} --photons 2000 --size 16x12 --spp 2"
            );
            renders(&folder, &options);
        }
    }
}

#[test]
fn radiosity_renders_every_diffuse_scene() {
    let folder = folder("radiosity");
    for scene in ["diffuse-room", "furnace-box", "cavity-cap", "cornell"] {
        let options =
            format!("--scene {scene} --estimator radiosity --patches 60 --size 8x6 --spp 1");
        renders(&folder, &options);
    }
}

#[test]
fn bad_input_gets_one_line_exit_code_two_and_leaves_nothing() {
    let cases = [
        ("--size 0x10", "'--size"),
        ("--size -5x5", "'--size"),
        ("--size 5x-5", "'--size"),
        ("--size 1000000000x1000000000", "'--size"),
        ("--size 60000x60000", "memory"),
        ("--size 10", "WIDTHxHEIGHT"),
        ("--size axb", "WIDTHxHEIGHT"),
        ("--spp 0", "'--spp"),
        ("--spp -1", "1 to 4294967295"),
        ("--threads 0", "1 to 1024"),
        ("--threads -1", "'--threads"),
        ("--pixel grid --spp 10", "multiple"),
        ("--pixel grid --grid 1024 --spp 4294967295", "multiple"),
        ("--exposure nan", "-100 to 100"),
        ("--exposure -inf", "'--exposure"),
        ("--convention report --exposure 1", "--convention physical"),
        ("--convention report --exposure 0", "--exposure"),
        ("--scene cornell --diffuse lambert", "--scene report"),
        ("--scene cornell --diffuse corrected", "--diffuse"),
        ("--convention published --diffuse eon", "published"),
        ("--pixel random --grid 3", "--pixel grid and jitter"),
        ("--grid 4", "--grid"),
        ("--scrambles 4", "--sampler sobol"),
        ("--sampler sobol --scrambles 0", "'--scrambles"),
        ("--sampler sobol --scrambles 3 --spp 8", "multiple"),
        ("--estimator radiosity --patches 0", "'--patches"),
        ("--patches -1", "1 to 4294967295"),
        ("--out out/picture.png", ".exr"),
        ("--out /dev/null/picture.exr", "/dev/null"),
        (
            "--convention published --estimator mis",
            "--estimator report",
        ),
        ("--scene environment --estimator light-tracer", "background"),
        ("--estimator bdpt --pixel centre", "--pixel"),
        ("--estimator bdpt --pixel random", "--pixel"),
        ("--estimator bdpt --sampler sobol --spp 8", "single rays"),
        ("--scene cornell --convention report", "--scene report"),
        ("--rays 4", "--estimator report"),
        ("--rays 1", "--estimator report"),
        (
            "--estimator bsdf --light-sampling solid-angle",
            "--estimator light and mis",
        ),
        ("--estimator light --heuristic power", "--estimator mis"),
        ("--radius 1", "--estimator photon"),
        ("--photons 1000", "--estimator photon"),
        ("--estimator photon --radius 0", "0.000001 to 1000000"),
        ("--estimator photon --radius nan", "'--radius"),
        ("--estimator photon --photons 0", "1 to 4294967295"),
        ("--estimator photon --photons 4e9", "'--photons"),
        ("--estimator photon --photons 4000000000", "GB"),
        ("--estimator photon --caustic-photons 0", "1 to 4294967295"),
        (
            "--estimator photon --caustic-radius -1",
            "'--caustic-radius",
        ),
        ("--estimator sppm --gather no", "--estimator photon"),
        ("--estimator sppm --caustic-radius 1", "--gather yes"),
        (
            "--estimator photon --gather no --caustic-photons 9",
            "--gather yes",
        ),
        ("--estimator photon --scene environment", "background"),
        ("--convention report --rays 0", "1 to 64"),
        ("--estimator radiosity", "mirrors"),
        ("--estimator radiosity --scene environment", "background"),
        (
            "--estimator radiosity --scene cornell --patches 50000",
            "memory",
        ),
        ("--patches 100", "--estimator radiosity"),
        ("--frames 3", "--frames"),
        ("--scene nowhere", "cornell"),
        ("--scene -1", "'--scene"),
        ("--seed -1", "'--seed"),
        ("--seed 18446744073709551616", "0 to 18446744073709551615"),
        ("--spp", "'--spp"),
    ];
    for (options, hint) in cases {
        let folder = folder("errors");
        // An option may be given once only.
        let defaults: String = [("--size", "8x6"), ("--spp", "1")]
            .iter()
            .filter(|(option, _)| !options.contains(option))
            .map(|(option, value)| format!("{option} {value} "))
            .collect();
        let output = render(&folder, &(defaults + options));
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{options}: {message}");
        assert!(
            message.starts_with("error: ") && message.contains(hint),
            "{options}: {message}"
        );
        assert_eq!(
            message.trim_end().lines().count(),
            1,
            "{options}: {message}"
        );
        let left = std::fs::read_dir(&folder)
            .expect("the folder is there")
            .count();
        assert_eq!(left, 0, "{options} left files behind");
    }
}

/// What an option refuses names the range that its help states.
#[test]
fn ranges_stand_in_the_help() {
    let commands = [
        Render::command(),
        lab::Options::augment_args(clap::Command::new("any")),
    ];
    let mut ranged = 0;
    for command in commands {
        for argument in command.get_arguments() {
            let Some(long) = argument.get_long() else {
                continue;
            };
            let help = argument.get_help().expect("a help").to_string();
            let name = format!("--{long}=x/y");
            let refused = command.clone().try_get_matches_from(["program", &name]);
            // Folders and files take any name, flags no value, and names of things are listed.
            let Err(error) = refused else { continue };
            let message = error.to_string();
            assert!(message.contains(&format!("'--{long}")), "{message}");
            if let Some((_, range)) = message.split_once(" number from ") {
                let range = range.lines().next().expect("a line");
                assert!(
                    help.contains(&format!("from {range}")),
                    "--{long}: {help}: {range}"
                );
                ranged += 1;
            }
        }
    }
    assert!(ranged >= 14, "{ranged}");
}

#[test]
fn a_full_disk_is_no_missing_folder() {
    use std::io::ErrorKind;
    use whitefurnace::error::Error;
    let message = |kind: ErrorKind| {
        Error::file("write", Path::new("a.exr"))(std::io::Error::from(kind)).to_string()
    };
    for kind in [ErrorKind::NotFound, ErrorKind::PermissionDenied] {
        assert!(message(kind).contains("folder exists"), "{}", message(kind));
    }
    for kind in [
        ErrorKind::StorageFull,
        ErrorKind::Interrupted,
        ErrorKind::TimedOut,
    ] {
        assert!(!message(kind).contains("folder"), "{}", message(kind));
    }
}

/// Each model makes another white sphere, and the option's older name still says the same.
#[test]
fn the_white_sphere_takes_four_models() {
    let folder = folder("diffuse");
    let image = |options: &str| {
        let output = render(
            &folder,
            &format!("--size 32x24 --spp 2 --out a.exr {options}"),
        );
        assert!(output.status.success(), "{}", text(&output.stderr));
        std::fs::read(folder.join("a.png")).expect("a picture")
    };
    let models = ["lambert", "printed", "corrected", "eon"];
    let images = models.map(|model| image(&format!("--diffuse {model}")));
    for (i, a) in images.iter().enumerate() {
        for b in &images[i + 1..] {
            assert!(a != b);
        }
    }
    assert!(images[1] == image("--oren-nayar printed"));
    assert!(images[2] == image(""));
}

#[test]
fn a_failed_run_keeps_the_file_that_was_there() {
    let folder = folder("keeps");
    std::fs::write(folder.join("a.exr"), "precious").expect("written");
    let output = render(&folder, "--spp 0 --out a.exr");
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(
        std::fs::read_to_string(folder.join("a.exr")).expect("there"),
        "precious"
    );
}

/// A program that is at work, and what it prints on standard error.
#[cfg(unix)]
struct Running {
    child: std::process::Child,
    lines: std::io::Lines<std::io::BufReader<std::process::ChildStderr>>,
}

#[cfg(unix)]
impl Running {
    fn start(command: &mut Command) -> Self {
        use std::io::BufRead as _;
        let mut child = command
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .expect("the program starts");
        let errors = child.stderr.take().expect("a pipe");
        Self {
            child,
            lines: std::io::BufReader::new(errors).lines(),
        }
    }

    /// Waits for a line that says this: however long it takes.
    fn wait_for(&mut self, text: &str) -> String {
        loop {
            let line = self.lines.next().expect("it goes on").expect("a line");
            if line.contains(text) {
                return line;
            }
        }
    }

    fn signal(&self, name: &str) {
        let id = self.child.id().to_string();
        let sent = Command::new("kill").args([name, &id]).status();
        assert!(sent.expect("kill").success());
    }

    fn end(mut self) -> Option<i32> {
        self.child.wait().expect("the program ends").code()
    }
}

/// No machine does so many samples before somebody ends it.
#[cfg(unix)]
const ENDLESS: &str = "--threads 1 --size 64x48 --spp 4000000000 --out a.exr";

#[cfg(unix)]
#[test]
fn signals_write_what_is_done_beside_what_was_finished() {
    let folder = folder("signals");
    for (signal, code) in [("-INT", 130), ("-TERM", 143), ("-HUP", 129)] {
        // Tests that run in the background, or by nohup, hand that on.
        if signals::ignored(code - 128) {
            eprintln!("{signal} is ignored by who started the tests");
            continue;
        }
        renders(&folder, "--size 8x6 --spp 1 --out a.exr");
        let finished =
            ["a.exr", "a.png"].map(|file| std::fs::read(folder.join(file)).expect("there"));
        let mut command = Command::new(env!("CARGO_BIN_EXE_render"));
        command
            .args(ENDLESS.split_whitespace())
            .current_dir(&folder);
        let mut render = Running::start(&mut command);
        let line = render.wait_for("% of 12.3 trillion samples");
        assert!(line.contains("/s") && line.contains("left"), "{line}");
        render.signal(signal);
        render.wait_for("interrupted");
        assert_eq!(render.end(), Some(code), "{signal}");
        let now = ["a.exr", "a.png"].map(|file| std::fs::read(folder.join(file)).expect("there"));
        assert!(now == finished, "{signal} changed what was finished");
        for file in ["a.partial.exr", "a.partial.png"] {
            std::fs::remove_file(folder.join(file)).expect("a partial image");
        }
        let left = std::fs::read_dir(&folder).expect("the folder").count();
        assert_eq!(left, 2, "{signal}");
    }
}

/// As by `nohup`: a hangup is ignored, another signal is not.
#[cfg(unix)]
#[test]
fn a_signal_that_was_ignored_stays_ignored() {
    let folder = folder("nohup");
    let script = format!(
        "trap '' HUP; exec {} {ENDLESS}",
        env!("CARGO_BIN_EXE_render")
    );
    let mut command = Command::new("sh");
    command.args(["-c", &script]).current_dir(&folder);
    let mut render = Running::start(&mut command);
    render.wait_for("% of");
    render.signal("-HUP");
    render.signal("-TERM");
    render.wait_for("interrupted");
    assert_eq!(render.end(), Some(143));
}

/// The files of a folder and their bytes.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).expect("the folder is there");
    let files = entries.map(|entry| {
        let path = entry.expect("an entry").path();
        let name = path
            .file_name()
            .expect("a name")
            .to_string_lossy()
            .into_owned();
        let bytes = std::fs::read(&path).unwrap_or_else(|_| panic!("{name} is a folder"));
        (name, bytes)
    });
    files.collect()
}

/// Runs an experiment whose evidence grows, and again with interruptions: the files are the same. What
/// interrupts is a folder in the way of a file, so that it happens at that place and no other.
fn goes_on(id: &str, size: &str, ledger: &str) {
    let run = |folder: &Path| {
        let output = reproduce(folder, &format!("--only {id} {size} --fresh"));
        let message = text(&output.stderr);
        let error = message.lines().find(|line| line.starts_with("error: "));
        (output.status.code(), error.unwrap_or_default().to_owned())
    };
    let done = (Some(0), String::new());
    let [whole, pieces] = ["whole", "pieces"].map(|name| folder(&format!("{name}-{id}")));
    assert_eq!(run(&whole), done, "{id}");
    let experiment = pieces.join("out").join(id);
    // All is done but the last file; then the ledger is there and cannot be written once more.
    for file in ["result.json", ledger] {
        let path = experiment.join(file);
        let before = std::fs::read(&path).ok();
        drop(std::fs::remove_file(&path));
        std::fs::create_dir_all(&path).expect("a folder in the way");
        let (code, message) = run(&pieces);
        assert!(code == Some(2) && message.contains(file), "{id}: {message}");
        std::fs::remove_dir(&path).expect("removed");
        if let Some(bytes) = before {
            std::fs::write(&path, bytes).expect("restored");
        }
    }
    // As if it had ended amidst the parts: some are not there yet.
    let unfinished = experiment.join("unfinished");
    let parts = files(&unfinished);
    let parts: Vec<&String> = parts
        .keys()
        .filter(|name| name.ends_with(".json"))
        .collect();
    assert!(!parts.is_empty(), "{id} has no parts");
    for part in parts.iter().skip(1).step_by(3) {
        std::fs::remove_file(unfinished.join(part)).expect("removed");
    }
    assert_eq!(run(&pieces), done, "{id}");
    let whole = files(&whole.join("out").join(id));
    assert!(files(&experiment) == whole, "{id} went on otherwise");
}

#[test]
fn calibration_goes_on() {
    goes_on("calibration", "--shrink 64", "calibration.csv");
}

#[test]
#[ignore = "twelve seconds; how they go on is that of calibration and of the toy"]
fn others_go_on() {
    goes_on(
        "false-alarms",
        "--tier full --shrink 100",
        "false-alarms.csv",
    );
    goes_on("agreement", "--shrink 2048", "furnace-box.bdpt.csv");
}

#[test]
fn reproduce_goes_on_where_it_stopped() {
    let folder = folder("resume");
    let options = "--shrink 4096 --only fig9 --only watertight --threads 2";
    let first = reproduce(&folder, options);
    assert!(first.status.success(), "{}", text(&first.stderr));
    let results = folder.join("out/results.json");
    let json: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(&results).expect("results")).expect("JSON");
    let experiments = json["experiments"].as_array().expect("a list");
    assert_eq!(experiments.len(), 2);
    assert_eq!(experiments[1]["numbers"]["edges.lost"], 0.0);
    let bytes = std::fs::read(&results).expect("results");

    let again = reproduce(&folder, options);
    assert_eq!(
        text(&again.stdout)
            .matches("kept from an earlier run")
            .count(),
        2
    );
    assert_eq!(std::fs::read(&results).expect("results"), bytes);
    let kept = |options: &str| {
        let output = reproduce(&folder, options);
        text(&output.stdout)
            .matches("kept from an earlier run")
            .count()
    };
    // A file that is gone or garbled, a new one, other options or --fresh: made again.
    let figure = folder.join("out/fig9/noise.png");
    std::fs::remove_file(&figure).expect("removed");
    assert_eq!((kept(options), kept(options)), (1, 2));
    for file in ["noise.png", "noise.exr"] {
        let path = folder.join("out/fig9").join(file);
        let mut garbled = std::fs::read(&path).expect("a file");
        let middle = garbled.len() / 2;
        garbled[middle] ^= 1;
        std::fs::write(&path, &garbled).expect("written");
        assert_eq!(kept(options), 1, "{file}");
        assert!(std::fs::read(&path).expect("a file") != garbled);
    }
    for changed in [
        format!("{options} --seed 2"),
        format!("{options} --seed 2 --fresh"),
    ] {
        assert_eq!(kept(&changed), 0);
    }
}

/// Its own result among those of others, once.
#[test]
fn results_of_one_experiment_leave_the_others() {
    let folder = folder("results");
    let results = |options: &str| -> Vec<(String, u64, String)> {
        let output = reproduce(&folder, options);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let text = std::fs::read_to_string(folder.join("out/results.json")).expect("results");
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
    let both = results("--shrink 4096 --only watertight --only fig9 --only fig9");
    assert_eq!(both, [row("fig9", 4096), row("watertight", 4096)]);
    let again = results("--shrink 2048 --only fig9");
    assert_eq!(again, [row("fig9", 2048), row("watertight", 4096)]);
}

#[test]
fn reproduce_lists_and_refuses() {
    let folder = folder("list");
    let list = text(&reproduce(&folder, "--list").stdout);
    for id in [
        "fig6",
        "fig7a",
        "fig7b",
        "fig8",
        "fig9",
        "regions",
        "watertight",
    ] {
        assert!(
            list.lines().any(|line| line.starts_with(id)),
            "{id} is not listed"
        );
    }
    let unknown = reproduce(&folder, "--only fig10");
    assert_eq!(unknown.status.code(), Some(2));
    assert!(text(&unknown.stderr).contains("fig9"));
}

#[test]
fn every_experiment_has_a_binary_of_its_own() {
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/bin");
    for experiment in experiments::EXPERIMENTS {
        let file = sources.join(format!("{}.rs", experiment.id));
        assert!(file.is_file(), "{} has no binary", experiment.id);
    }
}
