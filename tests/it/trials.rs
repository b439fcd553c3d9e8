//! The registry's trials on their right subjects, a test for each group. (The zoo runs the faults.)

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;
use whitefurnace::harness::trial::{check_subject, group};
use whitefurnace::trials::all;

use crate::support::context;

/// Runs the trials of a group, or the one that is asked for, prints the verdict table, and fails with
/// all messages at once.
fn run(name: &str) {
    let context = context("");
    let mut trials = all();
    trials.retain(|trial| group(&trial.name) == name);
    assert!(!trials.is_empty(), "no trial in the group {name}");
    let trials = match context.select(trials, |trial| trial.name.clone()) {
        Ok(trials) => trials,
        Err(error) => panic!("trials::{name}: {error}"),
    };
    let checked: Vec<_> = trials
        .par_iter()
        .map(|trial| check_subject(trial, &context))
        .collect();
    let mut messages = String::new();
    for result in checked {
        match result {
            Ok(rows) => rows.iter().for_each(|row| println!("{}", row.csv())),
            Err(message) => messages += &message,
        }
    }
    assert!(messages.is_empty(), "\n{messages}");
}

macro_rules! groups {
    ($($name:ident)*) => {
        const GROUPS: &[&str] = &[$(stringify!($name)),*];
        $(#[test] fn $name() { run(stringify!($name)); })*
    };
}

groups! { hemisphere fresnel bsdf roulette streams sampler convergence geometry emitter accumulator furnace irradiance glass images photon bidirectional cie radiosity }

#[test]
fn every_trial_has_a_test_a_control_and_its_own_name() {
    let trials = all();
    let mut names = BTreeSet::new();
    for trial in &trials {
        assert!(names.insert(&trial.name), "{} twice", trial.name);
        assert!(GROUPS.contains(&group(&trial.name)), "{}", trial.name);
        assert!(!trial.controls.is_empty(), "{} without control", trial.name);
        let mut controls = BTreeMap::new();
        for control in &trial.controls {
            assert!(
                controls.insert(control.name, ()).is_none(),
                "{}!{} twice",
                trial.name,
                control.name
            );
        }
    }
}
