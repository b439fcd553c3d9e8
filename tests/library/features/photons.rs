//! Photon mapping by direct lookup, by final gathering and progressively, where any two features
//! meet.

use super::bidirectional::{by_means, passes_of};
use super::*;

/// Lookup radius. Photons are lost where discs reach beyond edges: the most for a scene of small
/// boxes.
const RADIUS: f64 = 0.06;
/// Largest relative bias of an image's mean by these discs: twice the largest difference measured.
const MARGIN: f64 = 0.06;
/// Particles of each of the images, whose number is that of samples.
const PARTICLES: u32 = 1250;
/// Largest relative standard error of a comparison, half as large again as the largest measured:
/// with the margin, an error of 24 % is detected.
pub const MAX_RELATIVE_ERROR: f64 = 0.02;

/// Returns whether photons make up all light of a row, as that of a background is missing, and its
/// variance is finite: shadow rays of final gathering have none in the corners of a box that emits.
pub fn supports_photons(row: &Row) -> bool {
    let corners = row.is("background", "closed box") && row.is("lookup", "gather");
    supports_images(row) && row.get("background").starts_with("closed") && !corners
}

/// How photons are looked up.
pub const LOOKUPS: Factor = ("lookup", &["direct", "gather", "progressive"]);

fn by_maps(parts: Parts<'_>, scene: &Scene, lookup: Lookup, seed: u64, maps: u32) -> Measured {
    let mean = |index: u32| {
        let estimator = PhotonMapping::new(
            parts,
            scene,
            lookup,
            PARTICLES,
            RADIUS,
            ImagePass::independent(seed, index),
        );
        let renderer = RayRenderer {
            estimator: estimator.expect("a map"),
            sampling: sampling(
                Random,
                SamplerKind::Independent,
                seed_for(seed, &format!("eye {index}")),
            ),
        };
        by_pixel(&film(scene, &renderer, 1)).mean
    };
    by_means((0..maps).map(mean), MARGIN)
}

#[test]
fn photons_are_right_where_any_two_features_meet() {
    assert_right(
        "photons",
        factors(&[LOOKUPS]),
        supports_photons,
        |row, scene, seed| {
            let by_maps = |lookup| by_maps(Parts::default(), scene, lookup, seed, samples());
            let measured = match row.get("lookup") {
                "direct" => by_maps(Lookup::DirectVisualization),
                "gather" => by_maps(final_gather(PARTICLES, RADIUS)),
                _ => {
                    let sppm = sppm(Parts::default(), PARTICLES, 2.0 * RADIUS);
                    Measured {
                        bias: MARGIN,
                        ..passes_of(&sppm, scene, seed, samples())
                    }
                }
            };
            (
                exact(row).is_none().then_some(Light::All(u32::MAX)),
                measured,
            )
        },
    );
}

/// Photons of half the flux are detected.
#[test]
fn photons_that_are_wrong_are_seen() {
    struct Halved;
    default_parts!(Halved: Scattering, Roulette, NextEvent, Bidirectional, FiniteElements);

    impl Photons for Halved {
        fn photon_density(&self, brdf: DVec3, flux: DVec3, wi: DVec3, square: f64) -> DVec3 {
            0.5 * DefaultParts.photon_density(brdf, flux, wi, square)
        }
    }
    let rows = table(factors(&[LOOKUPS]), supports_photons);
    let exact_rows = rows.iter().filter(|row| exact(row).is_some());
    let rows: Vec<Row> = exact_rows
        .map(|row| row.with("lookup", "direct"))
        .take(4)
        .collect();
    let is_seen = |row: &&Row| {
        let scene = scene_of(row);
        let measured = by_maps(
            Parts::replaced(&Halved),
            &scene,
            Lookup::DirectVisualization,
            master(),
            few_samples(),
        );
        Found::new(row, &scene, None, measured, master())
            .objection()
            .is_some_and(|text| text.starts_with("differs"))
    };
    let seen = rows.par_iter().filter(is_seen).count();
    assert!(
        !rows.is_empty() && seen == rows.len(),
        "{seen} of {}",
        rows.len()
    );
}

/// Photons and particles come from emitters alone: no background changes a bit of their images.
#[test]
fn particles_know_nothing_of_the_background() {
    let takes =
        |row: &Row| supports_images(row) && ["constant", "map"].contains(&row.get("background"));
    for row in table(&SCENE, takes)
        .iter()
        .filter(|row| !row.is("emitter", "none"))
    {
        let scenes = [row.clone(), row.with("background", "dark")].map(|row| scene_of(&row));
        let [lit, dark] = scenes.each_ref().map(|scene| {
            let tracer = LightTracer::default();
            let sppm = sppm(Parts::default(), 300, 0.3);
            [
                tracer.pass(scene, [9, 5], 1, 0),
                sppm.pass(scene, [9, 5], 1, 0),
            ]
            .map(|image| image.expect("legal values"))
        });
        assert!(lit == dark, "{row}");
    }
}
