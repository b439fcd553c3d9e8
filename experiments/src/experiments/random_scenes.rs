//! Random scenes under metamorphic relations: how many were tried, and how many scenes it takes to
//! find each fault of an estimator.

use std::collections::BTreeMap;

use ::trials::metamorphic::{Case, Found, RELATIONS, faults, test_scene};
use serde::{Deserialize, Serialize};

use crate::experiments::prelude::*;

pub(super) const RANDOM_SCENES: Experiment = Experiment {
    id: "random-scenes",
    title: "random scenes under relations that need no reference, and how soon they find faults",
    headline: "random scenes: {cases %d} relations tested on {scenes %d} scenes, {broken %d} broken; {faults.found %d} of {faults.all %d} seeded faults found, {faults.first %d} by the first scene",
    version: 3,
    equations: &[&equation::RENDERING],
    run,
};

/// Number of scenes after which a fault counts as not found.
const MOST_SCENES: u32 = 6;
/// Number of scenes tested at once.
const PART: u64 = 20;
/// Least number of faults that the scenes must find.
const LEAST_FOUND: usize = 10;

/// Counts of a relation's cases.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
struct Counts {
    tested: u64,
    refused: u64,
    broken: u64,
}

/// The first relation that a fault breaks.
#[derive(Clone, Serialize, Deserialize)]
struct Detected {
    scenes: u32,
    relation: String,
    technique: String,
}

fn run(run: &mut Run) -> Result<(), Error> {
    let scenes = run.count(run.by_tier(4, 100));
    let counts = correct(run, scenes)?;
    let mut rows = Vec::new();
    let mut all = Counts::default();
    for relation in &RELATIONS {
        let of = counts.get(relation.name).copied().unwrap_or_default();
        rows.push(format!(
            "{},\"{}\",{},{},{}",
            relation.name, relation.about, of.tested, of.refused, of.broken
        ));
        run.number(&format!("tested.{}", relation.name), of.tested as f64);
        all.tested += of.tested;
        all.broken += of.broken;
        run.detail(
            &format!("{}: {}", relation.name, relation.about),
            format!("{} of {} scenes break it", of.broken, of.tested),
            of.broken == 0,
        );
    }
    run.csv(
        "relations.csv",
        "relation,about,tested,refused,broken",
        &rows,
    )?;
    run.number("scenes", scenes as f64);
    run.number("cases", all.tested as f64);
    run.number("broken", all.broken as f64);
    run.claim(
        "relations on random scenes",
        format!("{} of {} broken", all.broken, all.tested),
        all.broken == 0,
    );
    faulty(run)
}

/// Tests the correct estimators.
fn correct(run: &Run, scenes: u64) -> Result<BTreeMap<String, Counts>, Error> {
    let mut counts = BTreeMap::<String, Counts>::new();
    for first in (0..scenes).step_by(PART as usize) {
        let indices: Vec<u64> = (first..scenes.min(first + PART)).collect();
        let key = format!("scenes {first} of {scenes}");
        let part: BTreeMap<String, Counts> = run.part(&key, || {
            let seed = |index| seed_for(run.seed(), &format!("random scene {index}"));
            let results = parallel_map(&indices, |index| {
                test_scene(seed(*index), Parts::default(), |_| true)
            })?;
            let mut part = BTreeMap::<String, Counts>::new();
            for (case, found) in results.into_iter().flatten() {
                let of = part.entry(case.relation.name.to_owned()).or_default();
                match found {
                    Found::NotApplicable => {}
                    Found::Refused(_) => of.refused += 1,
                    Found::Holds | Found::Undecided => of.tested += 1,
                    Found::Fails(_) => {
                        of.tested += 1;
                        of.broken += 1;
                    }
                }
            }
            Ok(part)
        })?;
        for (name, of) in part {
            let sum = counts.entry(name).or_default();
            sum.tested += of.tested;
            sum.refused += of.refused;
            sum.broken += of.broken;
        }
    }
    Ok(counts)
}

/// Looks for each fault in scene after scene.
fn faulty(run: &mut Run) -> Result<(), Error> {
    let faults = faults();
    let most = run.by_tier(1, MOST_SCENES);
    let search = |index: &usize| -> Option<Detected> {
        let fault = &faults[*index];
        (1..=most).find_map(|scenes| {
            let seed = seed_for(run.seed(), &format!("{} {scenes}", fault.name));
            let results = test_scene(seed, Parts::replaced(&fault.parts), Case::uses_parts);
            let broken = |(case, found): (Case, Found)| {
                matches!(found, Found::Fails(_)).then(|| Detected {
                    scenes,
                    relation: case.relation.name.to_owned(),
                    technique: case.technique.name.to_owned(),
                })
            };
            results.into_iter().find_map(broken)
        })
    };
    let indices: Vec<usize> = (0..faults.len()).collect();
    let mut detected = Vec::new();
    for part in indices.chunks(PART as usize) {
        let key = format!("faults {}, {most} scenes", part[0]);
        let found: Vec<Option<Detected>> = run.part(&key, || parallel_map(part, search))?;
        detected.extend(found);
    }
    let row = |(fault, found): (&::trials::metamorphic::FaultyParts, &Option<Detected>)| {
        let wrong = fault.wrong.replace('"', "'");
        match found {
            Some(of) => format!(
                "{},\"{wrong}\",{},{},{}",
                fault.name, of.scenes, of.relation, of.technique
            ),
            None => format!("{},\"{wrong}\",,,", fault.name),
        }
    };
    let rows: Vec<String> = faults.iter().zip(&detected).map(row).collect();
    run.csv("faults.csv", "fault,wrong,scenes,relation,technique", &rows)?;
    let scenes: Vec<u32> = detected.iter().flatten().map(|of| of.scenes).collect();
    let within = |most: u32| scenes.iter().filter(|count| **count <= most).count();
    run.numbers(
        "faults",
        [
            ("all", faults.len() as f64),
            ("found", scenes.len() as f64),
            ("first", within(1) as f64),
            ("most", f64::from(most)),
        ],
    );
    for relation in &RELATIONS {
        let by = detected.iter().flatten();
        let count = by.filter(|of| of.relation == relation.name).count();
        run.number(&format!("by.{}", relation.name), count as f64);
    }
    for (fault, found) in faults.iter().zip(&detected) {
        let value = match found {
            Some(of) => format!(
                "found in scene {} by {} ({})",
                of.scenes, of.relation, of.technique
            ),
            None => format!("not found in {most} scenes"),
        };
        run.note(fault.name, value);
    }
    run.claim(
        "faults that random scenes find",
        format!(
            "{} of {}, at least {LEAST_FOUND} asked",
            scenes.len(),
            faults.len()
        ),
        scenes.len() >= LEAST_FOUND,
    );
    let points = (0..=most).map(|count| [f64::from(count), within(count) as f64]);
    let chart = Chart::new(
        "Faults found by random scenes under metamorphic relations",
        ["scenes tried", "faults found"],
        [[0.0, f64::from(most)], [0.0, faults.len() as f64]],
        vec![
            Series::new("found", 0, Mark::Points, points),
            Series::curve("all faults", 1, [0.0, f64::from(most)], 1, |_| {
                faults.len() as f64
            }),
        ],
    );
    charts(
        run,
        "found.svg",
        "Number of seeded faults found against the number of random scenes tried.",
        480,
        &[chart],
    )
}
