//! The rules that trials and faults as data follow.

use std::collections::{BTreeMap, BTreeSet};

use trials::symptoms;
use trials::{all, all_faults, families};
use whitefurnace::equation;

#[test]
fn every_trial_has_a_claim_a_control_and_its_own_name() {
    let mut names = BTreeSet::new();
    for trial in &all() {
        assert!(names.insert(trial.name.clone()), "{} twice", trial.name);
        assert!(!trial.property.is_empty(), "{} claims nothing", trial.name);
        assert!(!trial.controls.is_empty(), "{} without control", trial.name);
        let mut controls = BTreeSet::new();
        for control in &trial.controls {
            let fresh = controls.insert(control.name);
            assert!(fresh, "{}!{} twice", trial.name, control.name);
        }
    }
}

/// A consequence says more than the property, in a clause of its own family.
#[test]
fn consequences_say_what_a_user_would_see() {
    let mut owners = BTreeMap::new();
    for (family, trials) in families().iter().map(|family| family.trials()).enumerate() {
        for trial in trials {
            let (name, text) = (trial.name, trial.consequence);
            let is_clause = text.split_whitespace().count() >= 5 && !text.ends_with('.');
            assert!(is_clause, "{name}: \"{text}\" is no clause");
            let repeats = text.contains(&trial.property) || trial.property.contains(&text);
            assert!(!repeats, "{name}: \"{text}\" repeats the property");
            let owner = owners.entry(text.clone()).or_insert(family);
            assert_eq!(*owner, family, "{name}: \"{text}\" is of another family");
        }
    }
}

/// Names are unique within families, and every fault names a trial of its family that exists.
#[test]
fn faults_name_trials_that_exist() {
    let trials = all();
    let known: BTreeSet<&str> = trials.iter().map(|trial| trial.name.as_str()).collect();
    let mut names = BTreeSet::new();
    for fault in all_faults() {
        assert!(names.insert((fault.family, fault.name)), "{fault:?} twice");
        assert!(!fault.rejected_by.is_empty(), "{fault:?} names no trial");
        for trial in &fault.rejected_by {
            assert!(known.contains(trial), "{trial} of {fault:?} does not exist");
        }
    }
}

#[test]
fn faults_are_many_and_break_every_equation() {
    let faults: Vec<_> = all_faults().into_iter().filter(|f| !f.equivalent).collect();
    let whole = faults.iter().filter(|f| f.whole_estimator).count();
    assert!(faults.len() >= 60, "{} faults", faults.len());
    assert!(
        whole >= 20 && 3 * whole >= faults.len(),
        "{whole} of {} faults act through a whole estimator",
        faults.len()
    );
    for equation in equation::ALL {
        assert!(
            faults.iter().any(|f| f.equation.id == equation.id),
            "no fault breaks {}",
            equation.id
        );
    }
}

/// Symptoms have names of their own, and their mistakes change the image of the same seed.
#[test]
fn symptoms_show_their_mistakes() {
    let mut keys = BTreeSet::new();
    for symptom in symptoms::all() {
        let key = symptom.key;
        assert!(keys.insert(key), "{key} twice");
        // Of four samples, some repeat others where streams are shared.
        let [right, wrong] = [symptom.right(1, 4), symptom.wrong(1, 4)];
        let (right, wrong) = (right.expect("an image"), wrong.expect("an image"));
        assert_ne!(right, wrong, "{key}");
    }
    assert!(keys.len() >= 15, "{} symptoms", keys.len());
}
