//! Manufactured solutions: the answer is chosen and what leads to it derived, so that it is known
//! for each surface and channel.
//!
//! `zones` chooses the radiance of walls that all see each other alike, `glossy` the light
//! around a glossy patch, and `balance` a measurement whose answer is the emission of one wall.

mod balance;
mod glossy;
pub mod patch;
mod zones;

use crate::prelude::*;
use crate::scenes::ball;

/// Adds the part of a cavity of radius 1 between two heights. The poles belong to the outermost
/// zones.
fn add_zone(builder: &mut SceneBuilder, [low, high]: [f64; 2], surface: Surface) {
    let low = if low == -1.0 { f64::NEG_INFINITY } else { low };
    let high = if high == 1.0 { f64::INFINITY } else { high };
    let sphere = Sphere {
        zone: [low, high],
        inward: true,
        ..Sphere::new(DVec3::ZERO, 1.0)
    };
    ball(builder, sphere, surface);
}

/// Returns a BRDF with the albedo that `altered` gives the diffuse wall with one of these albedos;
/// other surfaces keep theirs.
fn with_altered_albedo(bsdf: &Bsdf, walls: &[DVec3], altered: impl FnOnce(usize) -> DVec3) -> Bsdf {
    if let Bsdf::Lambert { albedo } = *bsdf
        && let Some(wall) = walls.iter().position(|of_wall| *of_wall == albedo)
    {
        let albedo = altered(wall);
        return Bsdf::Lambert { albedo };
    }
    *bsdf
}

/// Trials and faults of manufactured solutions.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    let trials = [zones::trials(), glossy::trials(), balance::trials()];
    let faults = [zones::faults(), glossy::faults(), balance::faults()];
    vec![Box::new(Family {
        trials: trials.into_iter().flatten().collect(),
        faults: faults.into_iter().flatten().collect(),
        ..Family::whole("manufactured", STANDARD)
    })]
}
