//! The registry's trials on their right subjects, a test for each group. (The zoo runs the faults.)

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;
use whitefurnace::harness::trial::{Context, Row, check_subject, group};
use whitefurnace::trials::all;

/// Runs every trial of a group, prints the verdict table, and fails with all messages at once.
fn run(name: &str) {
    let context = Context::from_environment().expect("WHITEFURNACE_SEED and WHITEFURNACE_SCALE");
    let trials: Vec<_> = all()
        .into_iter()
        .filter(|trial| group(&trial.name) == name)
        .collect();
    assert!(!trials.is_empty(), "no trial in the group {name}");
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

/// Says so if a mean's δ is below its minimum detectable effect: then *undecided* would come up more
/// often than the error budget allows. (Cells and distribution functions have no single such number.)
fn too_weak(row: &Row, context: &Context) -> String {
    let outcome = &row.outcome;
    let [found, size] = [outcome.minimum_detectable_effect(), outcome.claim.size()];
    let is_mean = ["t", "z", "Welch", "variance ratio"].contains(&outcome.statistic);
    if is_mean && context.scale >= 1.0 && found > size {
        format!(
            "{}: {} detects {found:.3e}, more than δ = {size:.3e}; needs {:.0} samples\n",
            row.trial,
            outcome.name,
            outcome.n as f64 * (found / size).powi(2)
        )
    } else {
        String::new()
    }
}

macro_rules! groups {
    ($($name:ident)*) => {
        const GROUPS: &[&str] = &[$(stringify!($name)),*];
        $(#[test] fn $name() { run(stringify!($name)); })*
    };
}

groups! { hemisphere fresnel bsdf roulette streams convergence geometry emitter accumulator furnace irradiance glass images cie radiosity }

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
