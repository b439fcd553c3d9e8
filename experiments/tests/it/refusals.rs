//! Tests of refusals and their messages.

use std::path::Path;

use clap::{Args as _, CommandFactory as _};
use experiments::experiments::EXPERIMENTS;
use experiments::render::command::Render;
use experiments::run;

use crate::{folder, refused, refuses, render, renders, reproduce, text};

#[test]
fn bad_input_gets_one_line_exit_code_two_and_leaves_nothing() {
    for case in include_str!("refusals.txt").lines() {
        let folder = folder("errors");
        refuses(case, |options| {
            // An option may be given once only.
            let defaults: String = [("--size", "8x6"), ("--spp", "1")]
                .iter()
                .filter(|(option, _)| !options.contains(option))
                .map(|(option, value)| format!("{option} {value} "))
                .collect();
            render(&folder, &(defaults + options))
        });
        let left = std::fs::read_dir(&folder)
            .expect("the folder is there")
            .count();
        assert_eq!(left, 0, "{case} left files behind");
    }
}

#[test]
fn scene_files_are_refused_by_line_and_told_apart() {
    let folder = folder("scene-files");
    let pyramid = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 1 2\n";
    let scene = "background = 1\ncamera = { eye = [0, 0, 5], target = [0, 0, 0], up = [0, 1, 0], fov_deg = 40 }\n\
                 materials.clay = { model = \"lambert\", albedo = 0.5 }\n\
                 objects = [{ shape = \"obj\", material = \"clay\", file = \"one.obj\" }]\n";
    std::fs::write(folder.join("one.obj"), pyramid).expect("written");
    std::fs::write(folder.join("good.toml"), scene).expect("written");
    std::fs::write(folder.join("bad.toml"), scene.replace("albedo", "albdo")).expect("written");
    let small = "--size 4x3 --spp 2";
    let rendered = |options: &str| render(&folder, &format!("{small} {options}"));
    for case in [
        "--scene bad.toml => scene bad.toml, line 3: materials.clay has no key \"albdo\"; did you mean \"albedo\"?",
        "--scene none.toml => cannot read none.toml",
        "--scene good.toml --convention report => --scene good.toml is defined under --convention physical only",
        "--scene good.toml --diffuse eon => --scene report",
        "--scene good.toml --estimator radiosity => background",
        "--scene good.toml --estimator light-tracer => --scene good.toml is lit by its background",
    ] {
        refuses(case, rendered);
    }
    // Single precision where its error would be visible, before anything is rendered.
    let far = scene.replace("[0, 0, 5]", "[0, 0, 50000]");
    let far = far
        .replace("\"obj\"", "\"sphere\"")
        .replace("file = \"one.obj\"", "centre = [0, 0, 0], radius = 0.5");
    std::fs::write(folder.join("far.toml"), far).expect("written");
    let said = "--precision single: the scene has something of size 5.0e-1, too small for single precision where the scene reaches \
                to 50000.0, more than 4096 times as far; take --precision double";
    refused(&rendered("--scene far.toml --precision single"), said);
    // Estimators that cannot handle rough glass, the report's own included.
    let frosted = scene.replace(
        "\"lambert\", albedo = 0.5",
        "\"rough-glass\", index = 1.5, alpha = 0.3",
    );
    std::fs::write(folder.join("frosted.toml"), frosted).expect("written");
    for estimator in [
        "report",
        "whitted",
        "light-tracer",
        "bdpt",
        "bdpt-ends",
        "photon",
        "sppm",
        "radiosity",
    ] {
        let said = format!(
            "--estimator {estimator} does not take rough glass, of which the material \"clay\" of frosted.toml is"
        );
        let options = format!("--scene frosted.toml --estimator {estimator}");
        refused(&rendered(&options), &said);
    }
    for estimator in ["mis", "bsdf", "light"] {
        for precision in ["double", "single"] {
            let options = format!(
                "--scene frosted.toml --estimator {estimator} --precision {precision} --out frosted.exr"
            );
            renders(&folder, &format!("{small} {options}"));
        }
    }
    // A name that the header cannot hold unchanged.
    std::fs::copy(folder.join("good.toml"), folder.join("房.toml")).expect("copied");
    renders(&folder, &format!("{small} --scene 房.toml --out d.exr"));
    assert!(
        text(&std::fs::read(folder.join("d.exr")).expect("there"))
            .contains("\nscene=\\u{623f}.toml\n")
    );
    let bytes = |file: &str| {
        let output = rendered(&format!("--scene good.toml --out {file}"));
        assert!(output.status.success());
        let note = "note: one.obj: 1 of 2 triangles have no area and are left out\n";
        assert_eq!(text(&output.stderr).replace('\r', ""), note);
        text(&std::fs::read(folder.join(file)).expect("there"))
    };
    let exported = crate::run(
        env!("CARGO_BIN_EXE_export"),
        &folder,
        "--scene good.toml --to mitsuba",
    );
    assert_eq!(
        text(&exported.stderr)
            .matches("note: one.obj: 1 of 2 triangles")
            .count(),
        1
    );
    // A sun that is too bright for any image.
    std::fs::write(
        folder.join("sun.toml"),
        scene.replace("background = 1", "background = 2e7"),
    )
    .expect("written");
    let said = "an image holds finite values from 0 to 16777216: the scene is too bright: multiply every emission and the \
                background";
    refused(&rendered("--scene sun.toml"), said);
    let first = bytes("a.exr");
    assert!(
        first.contains("scene=good.toml\nscene-sha256="),
        "the file says what it shows"
    );
    assert_eq!(first, bytes("b.exr"));
    std::fs::write(
        folder.join("one.obj"),
        format!("{pyramid}# the same, and yet another file"),
    )
    .expect("written");
    assert_ne!(first, bytes("c.exr"));
}

/// The error of an option names the range that its help states.
#[test]
fn ranges_stand_in_the_help() {
    let commands = [
        Render::command(),
        run::Options::augment_args(clap::Command::new("any")),
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
            // Folders and files accept any name, flags no value, and values with names are listed.
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
fn what_mends_an_error_fits_it() {
    use std::io::ErrorKind;
    use whitefurnace::error::Error;
    for (action, kind, hint) in [
        ("write", ErrorKind::NotFound, "folder exists"),
        ("write", ErrorKind::PermissionDenied, "folder exists"),
        ("write", ErrorKind::StorageFull, "make room"),
        ("read", ErrorKind::NotFound, "check its name"),
        ("read", ErrorKind::PermissionDenied, "may be read"),
    ] {
        let message =
            Error::file(action, Path::new("a.exr"))(std::io::Error::from(kind)).to_string();
        assert!(message.contains(hint), "{message}");
        assert!(
            message.contains("folder") == hint.contains("folder"),
            "{message}"
        );
    }
}

/// For radiance from 3·10⁻³¹ to 3·10⁶, errors above a ten-thousandth are noted. Their size is
/// tested in the library.
#[test]
fn images_too_faint_for_the_film_are_noted() {
    let folder = folder("faint");
    let said = |background: f64| {
        let scene = format!(
            "background = {background:e}\ncamera = {{ eye = [0, 0, 5], target = [0, 0, 0], up = [0, 1, 0], fov_deg = 40 }}\n\
             materials.clay = {{ model = \"lambert\", albedo = 0.5 }}\nobjects = [{{ shape = \"sphere\", material = \"clay\", \
             centre = [0, 0, -90], radius = 0.5 }}]\n"
        );
        std::fs::write(folder.join("faint.toml"), scene).expect("written");
        let output = render(
            &folder,
            "--scene faint.toml --size 8x6 --spp 4 --out faint.exr",
        );
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stderr)
    };
    for exponent in -30..=7 {
        let background = 3.0 * 10_f64.powi(exponent - 1);
        let note = said(background);
        let faint = background < 1e-6;
        assert_eq!(
            note.contains("note: the image is black"),
            background < 1e-10,
            "{background:e}: {note}"
        );
        assert_eq!(
            note.contains("note: the mean of the image is"),
            faint && background > 1e-10,
            "{background:e}: {note}"
        );
    }
}

#[test]
fn a_failed_run_keeps_the_file_that_was_there() {
    let folder = folder("keeps");
    std::fs::write(folder.join("a.exr"), "precious").expect("written");
    assert_eq!(
        render(&folder, "--spp 0 --out a.exr").status.code(),
        Some(2)
    );
    assert_eq!(
        std::fs::read_to_string(folder.join("a.exr")).expect("there"),
        "precious"
    );
}

#[test]
fn only_full_runs_are_recorded() {
    for options in [
        "--update-book --only fig9",
        "--update-book --tier full --shrink 2",
    ] {
        refused(&reproduce(&folder("refuse"), options), "--tier full");
    }
    let earlier = folder("against-record");
    std::fs::create_dir_all(earlier.join("out")).expect("a folder");
    std::fs::write(earlier.join("out/results.json"), "[]").expect("written");
    let again = reproduce(&earlier, "--fresh --against-record --out out");
    refused(&again, "results.json is of an earlier run");
}

#[test]
fn every_experiment_is_listed_and_has_a_program() {
    let folder = folder("list");
    let list = text(&reproduce(&folder, "--list").stdout);
    let ids = list
        .lines()
        .map(|line| line.split(' ').next().expect("a name"));
    assert!(
        ids.eq(EXPERIMENTS.iter().map(|experiment| experiment.id)),
        "{list}"
    );
    refused(
        &reproduce(&folder, "--only lihgts"),
        "did you mean \"lights\"?",
    );
    let programs = Path::new(env!("CARGO_MANIFEST_DIR")).join("programs/src/bin");
    for id in EXPERIMENTS.iter().map(|experiment| experiment.id) {
        assert!(
            programs.join(format!("{id}.rs")).is_file(),
            "{id} has no program"
        );
    }
}
