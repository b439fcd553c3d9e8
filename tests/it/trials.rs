//! The registry's trials on their right subjects, a test for each group. (The zoo runs the faults.)

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;
use whitefurnace::harness::outcome::Claim;
use whitefurnace::harness::trial::{Context, Row, check_subject, group};
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
            Ok(rows) => rows.iter().for_each(|row| {
                println!("{}", row.csv());
                messages += &too_weak(row, &context);
            }),
            Err(message) => messages += &message,
        }
    }
    assert!(messages.is_empty(), "\n{messages}");
}

/// Says so if an outcome's δ is below its minimum detectable effect: the power stated for a trial is
/// 1 - 1e-9, and *undecided* must not come up more often than the error budget allows.
fn too_weak(row: &Row, context: &Context) -> String {
    let outcome = &row.outcome;
    let [found, size] = [outcome.minimum_detectable_effect(), outcome.claim.size()];
    let no_size = outcome.claim == Claim::Test && found.is_finite();
    if context.scale < 1.0 || !outcome.is_random() || no_size || found <= size {
        return String::new();
    }
    format!(
        "{}: {} detects {found:.3e}, not δ = {size:.3e}; power {}; needs {:.0} samples\n",
        row.trial,
        outcome.name,
        outcome.power(),
        outcome.n as f64 * (found / size).powi(2)
    )
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
