//! Photon mapping by direct lookup, by final gathering and progressively, where any two features
//! meet.

use whitefurnace::integrator::{Lookup, PhotonMapping};

use super::bidirectional::{by_means, passes_of};
use super::*;

/// Lookup radius. Photons are lost where discs reach beyond edges: the most for a scene of small
/// boxes.
const RADIUS: f64 = 0.06;
/// Largest relative bias of an image's mean by these discs: twice the largest difference measured.
const MARGIN: f64 = 0.06;
/// Particles of each of the images, whose number is that of samples.
const PARTICLES: u32 = 1250;
/// Largest relative standard error of a comparison, half as large again as the largest measured: with
/// the margin, an error of 46 % is detected, and in most scenes one of 20 %.
pub const MAX_RELATIVE_ERROR: f64 = 0.044;

/// Returns whether photons make up all light of a row: that of a background is missing.
pub fn supports_photons(row: &Row) -> bool {
    supports_images(row) && row.get("background").starts_with("closed")
}

/// How photons are looked up.
pub const LOOKUPS: Factor = ("lookup", &["direct", "gather", "progressive"]);

fn by_maps(scene: &Scene, lookup: Lookup, seed: u64) -> Measured {
    let mean = |index: u32| {
        let estimator = PhotonMapping::new(
            DefaultParts,
            scene,
            lookup,
            PARTICLES,
            RADIUS,
            (seed, index),
        );
        let renderer = RayRenderer {
            estimator: estimator.expect("a map"),
            sampling: Sampling {
                pixel: Random,
                numbers: SamplerKind::Independent,
                seed: seed_for(seed, &format!("eye {index}")),
                silhouettes: false,
            },
        };
        by_pixel(&film(scene, &renderer, 1)).mean
    };
    by_means((0..samples()).map(mean), MARGIN)
}

#[test]
fn photons_are_right_where_any_two_features_meet() {
    assert_right(
        "photons",
        factors(&[LOOKUPS]),
        supports_photons,
        |row, scene, seed| {
            let gather = Lookup::FinalGather {
                caustic_particles: PARTICLES,
                caustic_radius: RADIUS,
            };
            let measured = match row.get("lookup") {
                "direct" => by_maps(scene, Lookup::DirectVisualization, seed),
                "gather" => by_maps(scene, gather, seed),
                _ => {
                    let sppm = Sppm {
                        parts: DefaultParts,
                        particles: PARTICLES,
                        radius: 2.0 * RADIUS,
                    };
                    Measured {
                        bias: MARGIN,
                        ..passes_of(&sppm, scene, seed)
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
