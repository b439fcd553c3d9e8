//! Pairs of features of scenes that have no comparison, and why.

use super::bidirectional::supports_particles;
use super::photons::supports_photons;
use super::radiosity::{EMISSIONS, MATERIALS, supports_radiosity};
use super::table::Pair;
use super::*;

type Excuse = fn(&Pair) -> bool;

fn has(pair: &Pair, feature: &str) -> bool {
    pair.iter().any(|other| other == feature)
}

/// Returns whether a pair is of an emitter and one of these backgrounds.
fn is_emitter_in(pair: &Pair, backgrounds: &[&str]) -> bool {
    let of_emitter = |feature: &String| {
        feature.starts_with("emission ")
            || feature.starts_with("emitter ") && feature != "emitter none"
    };
    pair.iter().any(of_emitter) && is_before(pair, backgrounds)
}

fn is_before(pair: &Pair, backgrounds: &[&str]) -> bool {
    backgrounds
        .iter()
        .any(|background| has(pair, &format!("background {background}")))
}

/// Emitters alone would leave too much noise in the reference.
const DARK: Excuse = |pair| is_emitter_in(pair, &["dark"]);
/// Light of a background is missing by design.
const OPEN: Excuse = |pair| is_before(pair, &["dark", "constant", "map"]);
const EMITTER_IN_OPEN: Excuse = |pair| is_emitter_in(pair, &["dark", "constant", "map"]);
/// In the corners of a box that emits, points uniform in area have infinite variance.
const CLOSED_BOX: Excuse = |pair| is_before(pair, &["closed box"]);
/// Estimators of whole images refuse it.
const ROUGH_GLASS: Excuse = |pair| has(pair, "material rough glass");
/// Radiosity handles Lambert surfaces only, and is compared with closed forms.
const NOT_DIFFUSE: Excuse = |pair| {
    pair.iter().any(|feature| match feature.split_once(' ') {
        Some(("material", of)) => !MATERIALS.contains(&of),
        Some(("emission", of)) => !EMISSIONS.contains(&of),
        Some(("caster" | "nesting", which)) => which != "none",
        Some(("eye", at)) => at != "outside",
        _ => false,
    })
};

/// The pairs that an estimator's table lacks are those with one of its reasons, and no others.
#[test]
fn pairs_that_are_left_out_are_named() {
    let all = required(&SCENE, |_| true);
    let tables: [(&str, fn(&Row) -> bool, &[Excuse]); 6] = [
        ("path", supports_paths, &[DARK]),
        ("bdpt", supports_images, &[DARK, ROUGH_GLASS]),
        ("whitted, report", by_area, &[DARK, ROUGH_GLASS, CLOSED_BOX]),
        (
            "light tracer",
            supports_particles,
            &[EMITTER_IN_OPEN, ROUGH_GLASS],
        ),
        ("photons", supports_photons, &[OPEN, ROUGH_GLASS]),
        ("radiosity", supports_radiosity, &[OPEN, NOT_DIFFUSE]),
    ];
    for (name, supports, excuses) in tables {
        let compared = required(&SCENE, supports);
        println!("{name}: {} of {} pairs", compared.len(), all.len());
        for pair in &all {
            let is_excused = excuses.iter().any(|excuse| excuse(pair));
            assert_eq!(compared.contains(pair), !is_excused, "{name}: {pair:?}");
        }
    }
}
