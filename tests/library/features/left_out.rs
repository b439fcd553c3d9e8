//! Pairs of features of scenes that have no comparison, and why.

use std::collections::BTreeSet;

use super::bidirectional::supports_particles;
use super::photons::supports_photons;
use super::radiosity::DIFFUSE;
use super::table::{Feature, Pair};
use super::*;

type Excuse = fn(&Pair) -> bool;

fn has(pair: &Pair, kind: &'static str, level: &'static str) -> bool {
    pair.contains(&Feature { kind, level })
}

/// Returns whether a pair is of an emitter and one of these backgrounds.
fn is_emitter_in(pair: &Pair, backgrounds: &[&'static str]) -> bool {
    let of_emitter = |feature: &Feature| {
        feature.kind == "emission" || feature.kind == "emitter" && feature.level != "none"
    };
    pair.iter().any(of_emitter) && is_before(pair, backgrounds)
}

fn is_before(pair: &Pair, backgrounds: &[&'static str]) -> bool {
    backgrounds
        .iter()
        .any(|background| has(pair, "background", background))
}

/// Emitters alone would leave too much noise in the reference.
const DARK: Excuse = |pair| is_emitter_in(pair, &["dark"]);
/// Light of a background is missing by design.
const OPEN: Excuse = |pair| is_before(pair, &["dark", "constant", "map"]);
const EMITTER_IN_OPEN: Excuse = |pair| is_emitter_in(pair, &["dark", "constant", "map"]);
/// In the corners of a box that emits, points uniform in area have infinite variance.
const CLOSED_BOX: Excuse = |pair| is_before(pair, &["closed box"]);
/// Estimators of whole images refuse it.
const ROUGH_GLASS: Excuse = |pair| has(pair, "material", "rough glass");
/// Radiosity handles Lambert surfaces only, and is compared with closed forms.
const NOT_DIFFUSE: Excuse = |pair| {
    let has_factor = |feature: &Feature| {
        let has_kind = |name: &str| name.rsplit(' ').next() == Some(feature.kind);
        let handled = |(name, levels): &Factor| has_kind(name) && levels.contains(&feature.level);
        DIFFUSE.iter().any(handled)
    };
    !pair.iter().all(has_factor)
};

/// The pairs that an estimator's table lacks are those with one of its reasons, and no others.
#[test]
fn pairs_that_are_left_out_are_named() {
    let all = required(&SCENE, |_| true);
    let scenes = |supports: fn(&Row) -> bool| required(&SCENE, supports);
    let tables: [(&str, BTreeSet<Pair>, &[Excuse]); 6] = [
        ("path", scenes(supports_paths), &[DARK]),
        ("bdpt", scenes(supports_images), &[DARK, ROUGH_GLASS]),
        (
            "whitted, report",
            scenes(by_area),
            &[DARK, ROUGH_GLASS, CLOSED_BOX],
        ),
        (
            "light tracer",
            scenes(supports_particles),
            &[EMITTER_IN_OPEN, ROUGH_GLASS],
        ),
        ("photons", scenes(supports_photons), &[OPEN, ROUGH_GLASS]),
        ("radiosity", required(&DIFFUSE, |_| true), &[NOT_DIFFUSE]),
    ];
    for (name, compared, excuses) in tables {
        println!("{name}: {} of {} pairs", compared.len(), all.len());
        for pair in &all {
            let is_excused = excuses.iter().any(|excuse| excuse(pair));
            assert_eq!(compared.contains(pair), !is_excused, "{name}: {pair:?}");
        }
    }
}
