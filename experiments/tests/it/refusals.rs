//! What is refused, and in which words.

use std::path::Path;

use clap::{Args as _, CommandFactory as _};
use experiments::experiments::EXPERIMENTS;
use experiments::render::command::Render;
use experiments::run;

use crate::{folder, refused, render, reproduce, text};

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
        ("--convention published --estimator mis", "--estimator report"),
        ("--scene environment --estimator light-tracer", "background"),
        ("--estimator bdpt --pixel centre", "--pixel"),
        ("--estimator bdpt --pixel random", "--pixel"),
        ("--estimator bdpt --sampler sobol --spp 8", "single rays"),
        ("--scene cornell --convention report", "--scene report"),
        ("--rays 4", "--estimator report"),
        ("--rays 1", "--estimator report"),
        ("--estimator bsdf --light-sampling solid-angle", "--estimator light and mis"),
        ("--estimator light --heuristic power", "--estimator mis"),
        ("--radius 1", "--estimator photon"),
        ("--photons 1000", "--estimator photon"),
        ("--estimator photon --radius 0", "0.000001 to 1000000"),
        ("--estimator photon --radius nan", "'--radius"),
        ("--estimator photon --photons 0", "1 to 4294967295"),
        ("--estimator photon --photons 4e9", "'--photons"),
        ("--estimator photon --photons 4000000000", "GB"),
        ("--estimator photon --caustic-photons 0", "1 to 4294967295"),
        ("--estimator photon --caustic-radius -1", "'--caustic-radius"),
        ("--estimator sppm --gather no", "--estimator photon"),
        ("--estimator sppm --caustic-radius 1", "--gather yes"),
        ("--estimator photon --gather no --caustic-photons 9", "--gather yes"),
        ("--estimator photon --scene environment", "background"),
        ("--convention report --rays 0", "1 to 64"),
        ("--estimator radiosity", "mirrors"),
        ("--estimator radiosity --scene environment", "background"),
        ("--estimator radiosity --scene cornell --patches 50000", "memory"),
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
        refused(&output, hint);
        let left = std::fs::read_dir(&folder).expect("the folder is there").count();
        assert_eq!(left, 0, "{options} left files behind");
    }
}

/// What an option refuses names the range that its help states.
#[test]
fn ranges_stand_in_the_help() {
    let commands = [Render::command(), run::Options::augment_args(clap::Command::new("any"))];
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
                assert!(help.contains(&format!("from {range}")), "--{long}: {help}: {range}");
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
    let message = |kind: ErrorKind| Error::file("write", Path::new("a.exr"))(std::io::Error::from(kind)).to_string();
    for kind in [ErrorKind::NotFound, ErrorKind::PermissionDenied] {
        assert!(message(kind).contains("folder exists"), "{}", message(kind));
    }
    for kind in [ErrorKind::StorageFull, ErrorKind::Interrupted, ErrorKind::TimedOut] {
        assert!(!message(kind).contains("folder"), "{}", message(kind));
    }
}

#[test]
fn a_failed_run_keeps_the_file_that_was_there() {
    let folder = folder("keeps");
    std::fs::write(folder.join("a.exr"), "precious").expect("written");
    let output = render(&folder, "--spp 0 --out a.exr");
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(std::fs::read_to_string(folder.join("a.exr")).expect("there"), "precious");
}

#[test]
fn only_full_runs_are_recorded() {
    for options in ["--update-book", "--update-book --tier full --shrink 2"] {
        refused(&reproduce(&folder("refuse"), options), "--tier full");
    }
}

#[test]
fn every_experiment_is_listed_and_has_a_program() {
    let folder = folder("list");
    let list = text(&reproduce(&folder, "--list").stdout);
    let ids = list.lines().map(|line| line.split(' ').next().expect("a name"));
    assert!(ids.eq(EXPERIMENTS.iter().map(|experiment| experiment.id)), "{list}");
    refused(&reproduce(&folder, "--only fig10"), "fig9");
    let programs = Path::new(env!("CARGO_MANIFEST_DIR")).join("programs");
    let manifest = std::fs::read_to_string(programs.join("Cargo.toml")).expect("a manifest");
    for id in EXPERIMENTS.iter().map(|experiment| experiment.id) {
        assert!(programs.join(format!("src/bin/{id}.rs")).is_file(), "{id} has no program");
        assert!(manifest.contains(&format!("{{ name = \"{id}\", test = false }}")), "{id} is linked as a test");
    }
}
