//! The programs as a person meets them: bytes, errors, resumption.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

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
        ("--size 0x10", "at least 1"),
        ("--size 1000000000x1000000000", "smaller"),
        ("--size 60000x60000", "memory"),
        ("--spp 0", "at least 1"),
        ("--threads 0", "between 1 and 1024"),
        ("--pixel grid --spp 10", "multiple"),
        ("--exposure nan", "finite"),
        ("--exposure inf", "finite"),
        ("--out out/picture.png", ".exr"),
        ("--out /dev/null/picture.exr", "/dev/null"),
        (
            "--convention published --estimator mis",
            "--estimator report",
        ),
        ("--scene environment --estimator light-tracer", "background"),
        ("--estimator bdpt --pixel centre", "--pixel"),
        ("--estimator bdpt --sampler sobol --spp 8", "single rays"),
        ("--scene cornell --convention report", "--scene report"),
        ("--rays 4", "--estimator report"),
        (
            "--estimator bsdf --light-sampling solid-angle",
            "--estimator light and mis",
        ),
        ("--estimator light --heuristic power", "--estimator mis"),
        ("--radius 1", "--estimator photon"),
        ("--estimator photon --radius 0", "above 0"),
        ("--estimator photon --photons 0", "at least 1"),
        ("--estimator photon --photons 4000000000", "GB"),
        ("--estimator sppm --gather no", "--estimator photon"),
        ("--estimator sppm --caustic-radius 1", "--gather yes"),
        ("--estimator photon --scene environment", "background"),
        ("--convention report --rays 0", "between 1 and 64"),
        ("--estimator radiosity", "mirrors"),
        ("--estimator radiosity --scene environment", "background"),
        (
            "--estimator radiosity --scene cornell --patches 50000",
            "memory",
        ),
        ("--patches 100", "--estimator radiosity"),
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
    for (options, hint) in [
        ("--size 10", "WIDTHxHEIGHT"),
        ("--size axb", "WIDTHxHEIGHT"),
        ("--frames 3", "--frames"),
        ("--scene nowhere", "cornell"),
        ("--seed -1", "--seed"),
    ] {
        let output = render(&folder("usage"), options);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{options}");
        assert!(message.contains(hint), "{options}: {message}");
        assert_eq!(
            message.trim_end().lines().count(),
            1,
            "{options}: {message}"
        );
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

#[cfg(unix)]
#[test]
fn ctrl_c_writes_what_is_done() {
    let folder = folder("interrupt");
    let child = Command::new(env!("CARGO_BIN_EXE_render"))
        .args("--size 64x48 --spp 4000000 --out a.exr".split_whitespace())
        .current_dir(&folder)
        .stdout(std::process::Stdio::piped())
        .spawn()
        .expect("the program starts");
    // Long after the program has its handler, long before its 12 milliard samples are done.
    std::thread::sleep(std::time::Duration::from_millis(1500));
    let sent = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .expect("kill");
    assert!(sent.success());
    let output = child.wait_with_output().expect("the program ends");
    assert!(output.status.success());
    assert!(
        text(&output.stdout).contains("interrupted"),
        "{}",
        text(&output.stdout)
    );
    assert!(folder.join("a.exr").is_file() && folder.join("a.png").is_file());
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
    // A figure that is gone, other options or --fresh: made again.
    std::fs::remove_file(folder.join("out/fig9/noise.png")).expect("removed");
    let partly = reproduce(&folder, options);
    assert_eq!(
        text(&partly.stdout)
            .matches("kept from an earlier run")
            .count(),
        1
    );
    for changed in [
        format!("{options} --seed 2"),
        format!("{options} --seed 2 --fresh"),
    ] {
        let output = reproduce(&folder, &changed);
        assert_eq!(
            text(&output.stdout)
                .matches("kept from an earlier run")
                .count(),
            0
        );
    }
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
