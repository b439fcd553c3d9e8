//! Tests of the table of defaults: help and command line state and do what it says.

use clap::CommandFactory as _;
use experiments::render::command::Render;
use experiments::render::defaults::{
    BASE, DEPENDENT, MAX_POINTS_PER_SCRAMBLE, MIN_ADAPTIVE_SPP, MIN_SCRAMBLES,
};
use experiments::render::{AdaptiveName, Job};

use crate::job;

/// Returns the recorded value of an option.
fn recorded(job: &Job, option: &str) -> Option<String> {
    let text = job.provenance(&job.camera().expect("a camera"), true);
    text.lines()
        .find_map(|line| line.strip_prefix(&format!("{option}=")))
        .map(str::to_owned)
}

#[test]
fn help_states_the_default_of_every_option_that_decides_pixels() {
    let command = Render::command();
    // Options of the run, whose defaults stand in their help.
    let others = [
        "threads",
        "exposure",
        "time",
        "target-error",
        "resume",
        "shard",
        "preview",
        "tev",
        "out",
    ];
    for argument in command.get_arguments() {
        let Some(option) = argument
            .get_long()
            .filter(|option| !others.contains(option))
        else {
            continue;
        };
        let help = argument
            .get_help()
            .map(ToString::to_string)
            .unwrap_or_default();
        let stated = argument
            .get_default_values()
            .first()
            .filter(|_| !argument.is_hide_default_value_set());
        let dependent = DEPENDENT.iter().find(|default| default.option == option);
        match (dependent, stated) {
            (Some(default), None) => {
                let text = format!(" [default: {}]", default.text);
                assert!(help.ends_with(&text), "--{option}: {help}");
                assert_eq!(help.matches("[default").count(), 1, "--{option}: {help}");
            }
            // Clap adds this one to the help.
            (None, Some(_)) => assert!(!help.contains("[default"), "--{option}: {help}"),
            _ => panic!("--{option} has no default, or two"),
        }
    }
    for default in DEPENDENT {
        let is_option = |argument: &clap::Arg| argument.get_long() == Some(default.option);
        assert!(command.get_arguments().any(is_option), "{}", default.option);
    }
}

#[test]
fn defaults_stated_by_clap_are_those_of_the_table() {
    let command = Render::command().try_get_matches_from(["render"]);
    let command = command.expect("no option is required");
    let parsed = <Render as clap::FromArgMatches>::from_arg_matches(&command).expect("options");
    assert_eq!(format!("{:?}", parsed.job), format!("{BASE:?}"));
    assert_eq!(format!("{:?}", Job::default()), format!("{BASE:?}"));
}

#[test]
fn the_base_is_what_its_documentation_says() {
    for (option, value) in [
        ("scene", "report"),
        ("convention", "physical"),
        ("estimator", "mis"),
        ("sampler", "independent"),
        ("silhouettes", "no"),
        ("heuristic", "power"),
        ("specular-nee", "yes"),
        ("light-sampler", "importance"),
    ] {
        assert_eq!(recorded(&BASE, option).as_deref(), Some(value), "{option}");
    }
    assert_eq!(BASE.adaptive, AdaptiveName::No);
}

#[test]
fn dependent_defaults_do_what_their_texts_say() {
    let rows = [
        ("convention", "", "physical"),
        ("convention", "--estimator report", "report"),
        (
            "convention",
            "--estimator report --scene cornell",
            "physical",
        ),
        ("estimator", "", "mis"),
        ("estimator", "--convention report", "report"),
        ("estimator", "--convention published", "report"),
        ("sampler", "", "sobol"),
        (
            "sampler",
            "--estimator report --scene cornell",
            "independent",
        ),
        ("sampler", "--pixel grid", "independent"),
        ("sampler", "--pixel jitter", "independent"),
        ("sampler", "--pixel centre", "sobol"),
        ("sampler", "--estimator bdpt", "sobol"),
        ("silhouettes", "", "yes"),
        ("silhouettes", "--pixel jitter", "yes"),
        ("silhouettes", "--estimator photon", "yes"),
        ("silhouettes", "--pixel grid", ""),
        ("silhouettes", "--estimator sppm", ""),
        ("silhouettes", "--convention report", ""),
        ("adaptive", "--spp 32", "yes"),
        ("adaptive", "--spp 31", "no"),
        ("adaptive", "--estimator bsdf", "yes"),
        ("adaptive", "--estimator light", "yes"),
        ("adaptive", "--estimator whitted", ""),
        ("adaptive", "--sampler independent", ""),
        ("bounces", "", ""),
        ("scrambles", "", "4"),
        ("scrambles", "--spp 30", "5"),
        ("scrambles", "--spp 4096", "4"),
        ("scrambles", "--spp 8192", "8"),
        ("caustic-photons", "--estimator photon --photons 7", "7"),
        ("caustic-radius", "--estimator photon --radius 7", "7"),
    ];
    for (option, others, value) in rows {
        let found = recorded(&job(&format!("render {others}")), option);
        assert_eq!(found.unwrap_or_default(), value, "--{option} with {others}");
    }
    for default in DEPENDENT {
        assert!(
            rows.iter().any(|row| row.0 == default.option),
            "{}",
            default.option
        );
    }
    let text = |option| {
        DEPENDENT
            .iter()
            .find(|default| default.option == option)
            .expect("one")
            .text
    };
    assert_eq!(
        text("adaptive"),
        format!("yes with these from {MIN_ADAPTIVE_SPP} samples on")
    );
    let scrambles = format!(
        "the fewest from {MIN_SCRAMBLES} on that divide --spp into at most {MAX_POINTS_PER_SCRAMBLE} points each"
    );
    assert_eq!(text("scrambles"), scrambles);
}

/// An option that is given is not replaced by its default.
#[test]
fn given_options_stay() {
    for (option, value) in [
        ("convention", "physical"),
        ("estimator", "bsdf"),
        ("sampler", "independent"),
        ("silhouettes", "no"),
        ("adaptive", "no"),
        ("scrambles", "2"),
    ] {
        let found = recorded(&job(&format!("render --{option} {value}")), option);
        assert_eq!(found.as_deref(), Some(value));
    }
    let found = job("render --estimator report --convention physical");
    assert_eq!(recorded(&found, "convention").as_deref(), Some("physical"));
}
