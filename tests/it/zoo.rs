//! Every fault of the zoo under the trials that name it, a test for each group of trials.

use std::collections::BTreeSet;
use std::f64::consts::PI;

use approx::assert_abs_diff_eq;
use glam::DVec3;
use rayon::prelude::*;
use whitefurnace::equation;
use whitefurnace::harness::domain::Domain;
use whitefurnace::harness::outcome::Outcome;
use whitefurnace::harness::trial::{check_control, full_name, group, meant, refused};
use whitefurnace::trials::all;
use whitefurnace::trials::scenes::{
    RECTANGLE, TRIANGLE, WALL, polygon_irradiance, sphere_irradiance,
};
use whitefurnace::zoo::{equivalents, faults};

use crate::support::context;

/// Asserts that every fault that a trial of the group must reject is rejected by the outcomes that it
/// names, and that every outcome is named so; or of the one fault that is asked for, the first.
fn run(name: &str) {
    let context = context("");
    let mut trials = all();
    trials.retain(|trial| group(&trial.name) == name);
    let pairs: Vec<_> = trials
        .iter()
        .flat_map(|trial| trial.controls.iter().map(move |control| (trial, control)))
        .collect();
    let pairs = match context.select(pairs, |(trial, fault)| full_name(&trial.name, fault.name)) {
        Ok(pairs) => pairs,
        Err(error) => panic!("zoo::{name}: {error}"),
    };
    let results: Vec<_> = pairs
        .par_iter()
        .map(|(trial, control)| check_control(trial, control, &context))
        .collect();
    let mut messages = String::new();
    let mut known = BTreeSet::new();
    let mut reached = BTreeSet::new();
    for ((trial, control), result) in pairs.iter().zip(results) {
        match result {
            Ok(rows) => {
                rows.iter().for_each(|row| println!("{}", row.csv()));
                let outcomes = || rows.iter().map(|row| &row.outcome);
                let place = |outcome: &Outcome| (trial.name.clone(), outcome.name.clone());
                reached.extend(
                    meant(&control.rejected_by, outcomes())
                        .into_iter()
                        .map(place),
                );
                // Where chance has a part, exact outcomes beside it have tests of their own.
                let wanted = |outcome: &&Outcome| outcome.is_random() || trial.assertions == 0;
                known.extend(outcomes().filter(wanted).map(place));
            }
            Err(message) => messages += &message,
        }
    }
    if context.only.is_none() {
        for (trial, outcome) in known.difference(&reached) {
            messages +=
                &format!("{trial}: no control is to be rejected by its outcome {outcome}\n");
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
fn equivalent_mutants_are_accepted() {
    let messages: Vec<String> = equivalents()
        .par_iter()
        .filter_map(|pair| {
            let name = format!("{}!{}", pair.trial, pair.fault.name);
            let context = context(&name);
            let outcomes = (pair.run)(&context);
            let red = |o: &&Outcome| match o.verdict().word() {
                "holds" => false,
                "undecided" => context.scale >= 1.0,
                _ => true,
            };
            let red: Vec<_> = outcomes.iter().filter(red).collect();
            let refused = refused(&name, &outcomes, &context);
            (!red.is_empty() || !refused.is_empty())
                .then(|| format!("{name} ({}): {red:?} {refused}", pair.fault.wrong))
        })
        .collect();
    assert!(messages.is_empty(), "{messages:#?}");
}

/// Names are unique within families, every fault names a trial of its family that exists, and every
/// trial's group has its test.
#[test]
fn the_zoo_is_well_formed() {
    let trials = all();
    let known: BTreeSet<&str> = trials.iter().map(|trial| trial.name.as_str()).collect();
    let mut names = BTreeSet::new();
    for fault in faults() {
        assert!(names.insert((fault.family, fault.name)), "{fault:?} twice");
        assert!(!fault.caught_by.is_empty(), "{fault:?} names no trial");
        for trial in &fault.caught_by {
            assert!(known.contains(trial), "{trial} of {fault:?} does not exist");
            assert!(GROUPS.contains(&group(trial)), "no test runs {trial}");
        }
    }
}

#[test]
fn the_zoo_is_large_enough_and_covers_every_equation() {
    let faults: Vec<_> = faults().into_iter().filter(|f| !f.equivalent).collect();
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
            "the zoo holds no fault of {}",
            equation.id
        );
    }
}

/// The references of the trials through scenes, by a second route: quadrature over the light.
#[test]
fn polygon_and_sphere_irradiance_agree_with_quadrature() {
    let up = |x: DVec3| x.normalize().z.max(0.0);
    let over = |corner: DVec3, a: DVec3, b: DVec3, normal: DVec3| {
        let f = |p: DVec3| {
            let y = corner + p.x * a + p.y * b;
            up(y) * normal.dot(-y.normalize()).max(0.0) / y.length_squared()
        };
        Domain::Square.integrate_all(1e-9, &f).value * a.cross(b).length()
    };
    let [a, b, _, d] = RECTANGLE;
    let square = over(a, b - a, d - a, -DVec3::Z);
    assert_abs_diff_eq!(square, polygon_irradiance(&RECTANGLE), epsilon = 1e-7);
    assert_abs_diff_eq!(square, 0.752_274_688_454_107_5, epsilon = 1e-7);
    let [a, b, _, d] = WALL;
    let wall = over(a, b - a, d - a, -DVec3::Y);
    assert_abs_diff_eq!(wall, polygon_irradiance(&WALL), epsilon = 1e-7);
    let [a, b, c] = TRIANGLE;
    let normal = (b - a).cross(c - a);
    let f = |p: DVec3| {
        let y = a + p.x * (b - a) + p.y * (c - a);
        up(y) * normal.normalize().dot(-y.normalize()).max(0.0) / y.length_squared()
    };
    let triangle = Domain::Triangle.integrate_all(1e-9, &f).value * normal.length();
    assert_abs_diff_eq!(triangle, polygon_irradiance(&TRIANGLE), epsilon = 1e-7);
    // The solid angle of a sphere is a cone around the zenith with sin θ = R/d.
    let cone = PI * 0.25_f64.powi(2);
    assert_abs_diff_eq!(cone, sphere_irradiance(0.5, 2.0, 1.0), epsilon = 1e-15);
}
