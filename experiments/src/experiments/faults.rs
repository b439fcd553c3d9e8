//! Matrix of trials and the faults that they reject.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use trials::faults::Pair;
use whitefurnace::harness::guard::MAX_FAULT_MISS;
use whitefurnace::harness::trial::reject;

use crate::experiments::prelude::*;
use crate::plot::matrix::{Detection, matrix};

pub(super) const FAULTS: Experiment = Experiment {
    id: "faults",
    title: "fault × trial: which trials reject which faults",
    headline: "faults by trials: {rejected %d} of {pairs %d} pairs rejected, {not_rejected %d} missed that must be rejected",
    version: 2,
    equations: &[],
    run,
};

/// Scale of pairs that the suite does not assert.
const UNASSERTED: f64 = 1.0 / 128.0;

fn run(run: &mut Run) -> Result<(), Error> {
    run.add_equations_of(&trials::all());
    // Quick: the pairs that the suite asserts. Full: every fault under every trial of its family;
    // pairs that the suite does not assert at a reduced size, where faults of small effect stay
    // undecided.
    let mut pairs = trials::matrix();
    pairs.retain(|pair| !pair.fault.equivalent);
    if run.tier() == Tier::Quick {
        pairs.retain(|pair| pair.required);
    }
    let scales = [run.scale(UNASSERTED), suite::scale(run)];
    let [reduced, asserted] = scales.map(|scale| Context::new(run.seed(), scale));
    let (reduced, asserted) = (reduced?, asserted?);
    let seen = parallel_map(&pairs, |pair| {
        let name = format!("{}!{}", pair.trial, pair.fault.name);
        if pair.required {
            let found = reject(&pair.run, &pair.rejected_by, &asserted.named(&name));
            judge(&required_outcomes(&pair.rejected_by, &found.outcomes))
        } else {
            let outcomes = (pair.run)(&reduced.named(&name));
            judge(&outcomes.iter().collect::<Vec<_>>())
        }
    })?;
    let table: Vec<String> = pairs
        .iter()
        .zip(&seen)
        .map(|(pair, seen)| {
            let wrong = pair.fault.wrong.replace('"', "'");
            format!("{},{},{},\"{wrong}\"", label(pair), pair.trial, seen.word())
        })
        .collect();
    run.csv("faults.csv", "fault,trial,verdict,wrong", &table)?;
    draw(run, &pairs, &seen)?;
    for (pair, seen) in pairs.iter().zip(&seen) {
        if pair.required && *seen == Detection::Missed {
            run.claim(
                &format!("{} in {}", label(pair), pair.trial),
                "not rejected".to_owned(),
                false,
            );
        }
    }
    totals(run, &pairs, &seen, scales);
    Ok(())
}

/// Returns a fault's row of the matrix: faults of different families may have one name.
fn label(pair: &Pair) -> String {
    format!("{}: {}", pair.fault.family, pair.fault.name)
}

/// Judges a pair: rejected if any outcome fails (where the fault names outcomes of the trial, any
/// of those); missed if every outcome holds.
fn judge(outcomes: &[&Outcome]) -> Detection {
    let any =
        |wanted: fn(Verdict) -> bool| outcomes.iter().any(|outcome| wanted(outcome.verdict()));
    if any(|verdict| verdict == Verdict::Fails) {
        Detection::Rejected
    } else if any(|verdict| matches!(verdict, Verdict::Undecided { .. })) {
        Detection::Undecided
    } else {
        Detection::Missed
    }
}

fn totals(run: &mut Run, pairs: &[Pair], seen: &[Detection], [reduced, scale]: [f64; 2]) {
    let mut counts = Vec::new();
    for kind in Detection::ALL {
        let count = seen.iter().filter(|&&s| s == kind).count();
        run.number(&kind.word().replace(' ', "_"), count as f64);
        counts.push(format!("{count} {}", kind.word()));
    }
    run.number("pairs", pairs.len() as f64);
    let named = || pairs.iter().zip(seen).filter(|(pair, _)| pair.required);
    let missed = named()
        .filter(|(_, seen)| **seen == Detection::Missed)
        .count();
    let (all, asserted, counts) = (pairs.len(), named().count(), counts.join(", "));
    let value = format!(
        "{all} pairs, those that the suite asserts ({asserted}) at scale {scale} or a part of it that is enough, \
         others at {reduced}: {counts}; at scale 1 a correct build misses an asserted one with probability at most \
         {MAX_FAULT_MISS:e}"
    );
    if scale >= 1.0 || missed > 0 {
        let rejected = named().all(|(_, seen)| *seen == Detection::Rejected);
        run.claim("every fault is rejected by its trial", value, rejected);
    } else {
        run.note("faults rejected by their trials", value);
    }
}

/// Figures that show several families; each other family has a figure of its own name. Each has few
/// enough names to be readable at the width of a page.
const FAMILIES_BY_FIGURE: [(&str, &str); 8] = [
    ("scattering", "uniform, cosine, fresnel, bsdf, eon"),
    ("roulette", "roulette, survival"),
    (
        "numbers",
        "streams, render streams, sobol, sobol error bars, variance, grid, random, jitter, accumulator",
    ),
    ("geometry", "geometry, points, solid-angle"),
    ("microfacets", "ggx, rough-glass"),
    (
        "paths",
        "whole paths, path weights, long-walks, long-particles, equilibrium-in-glass, photons-in-glass",
    ),
    ("references", "references, cornell, published"),
    ("images", "outlines, adaptation, singles"),
];

/// Returns the figure that shows a pair. Whole estimators have more trials than fit one figure:
/// theirs are divided by the tested quantity.
fn figure(pair: &Pair) -> String {
    let family = pair.fault.family;
    let name = match family {
        "estimator" if pair.trial.starts_with("furnace/") => "furnace",
        "estimator" if pair.trial.starts_with("irradiance/") => "irradiance",
        "estimator" => "glass",
        "photon-equivalence" => "photon",
        other => {
            let holds = |families: &str| families.split(", ").any(|family| family == other);
            FAMILIES_BY_FIGURE
                .iter()
                .find(|(_, families)| holds(families))
                .map_or(other, |(name, _)| name)
        }
    };
    format!("faults-{}.svg", name.replace(' ', "-"))
}

fn draw(run: &mut Run, pairs: &[Pair], seen: &[Detection]) -> Result<(), Error> {
    let mut figures: BTreeMap<String, Vec<(&Pair, Detection)>> = BTreeMap::new();
    for (pair, &seen) in pairs.iter().zip(seen) {
        figures.entry(figure(pair)).or_default().push((pair, seen));
    }
    for (file, pairs) in figures {
        let families = unique(pairs.iter().map(|(pair, _)| pair.fault.family.to_owned()));
        let row = |pair: &Pair| match families.len() {
            1 => pair.fault.name.to_owned(),
            _ => label(pair),
        };
        let rows = unique(pairs.iter().map(|(pair, _)| row(pair)));
        let columns = unique(pairs.iter().map(|(pair, _)| pair.trial.clone()));
        let cells: HashMap<(String, &str), Detection> = pairs
            .iter()
            .map(|(pair, seen)| ((row(pair), pair.trial.as_str()), *seen))
            .collect();
        let stem = file.trim_end_matches(".svg");
        let title = format!(
            "Which trials reject which faults: {}",
            stem.replacen("faults-", "", 1)
        );
        let description = "A row for each fault, a column for each trial; a dark cell where the trial rejects it.";
        matrix(
            &run.figure(&file),
            &title,
            description,
            &rows,
            &columns,
            |row, column| {
                cells
                    .get(&(rows[row].clone(), columns[column].as_str()))
                    .copied()
            },
        )?;
    }
    Ok(())
}

/// Returns each name once, in the order of first occurrence.
fn unique(names: impl Iterator<Item = String>) -> Vec<String> {
    let mut seen = BTreeSet::new();
    names.filter(|name| seen.insert(name.clone())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn families_of_figures_exist() {
        let families: BTreeSet<&str> = trials::all_faults()
            .iter()
            .map(|fault| fault.family)
            .collect();
        for (figure, listed) in FAMILIES_BY_FIGURE {
            for family in listed.split(", ") {
                assert!(families.contains(family), "{figure}: {family}");
            }
        }
    }
}
