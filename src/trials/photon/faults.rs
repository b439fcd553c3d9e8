//! Faults of photon mapping, each through the whole estimator.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use crate::equation::{COSINE_HEMISPHERE, PHOTON_DENSITY, PHOTON_FLUX, PHOTON_RADIUS, ROULETTE};
use crate::estimator::photon_map::{density, flux_share};
use crate::sampling::uniform_hemisphere;
use crate::trials::subject::{RIGHT, Subject, Table, parts};
use crate::zoo::{Mutant, mutant};

pub(super) fn faults() -> Vec<Mutant<Subject>> {
    let mut faults = densities();
    faults.extend(maps());
    faults.extend(particles());
    faults
}

/// Half of every photon.
pub(super) const HALVED: Table = Table {
    photon_density: |brdf, flux, _, r2| density(0.5 * brdf, flux, r2),
    ..RIGHT
};

fn densities() -> Vec<Mutant<Subject>> {
    vec![
        mutant(
            "radius-for-its-square",
            &PHOTON_DENSITY,
            "the disc's area is πr",
            parts(Table {
                photon_density: |brdf, flux, _, r2| density(brdf, flux, r2.sqrt()),
                ..RIGHT
            }),
            &["photon/furnace", "photon/passes"],
        ),
        mutant(
            "disc-without-pi",
            &PHOTON_DENSITY,
            "the disc's area is r²",
            parts(Table {
                photon_density: |brdf, flux, _, r2| density(brdf, flux, r2 * FRAC_1_PI),
                ..RIGHT
            }),
            &["photon/disc"],
        ),
        mutant(
            "cosine-twice",
            &PHOTON_DENSITY,
            "flux is multiplied by the cosine, which it has met already",
            parts(Table {
                photon_density: |brdf, flux, wi, r2| density(brdf * wi.z, flux, r2),
                ..RIGHT
            }),
            &["photon/disc", "photon/furnace"],
        ),
        mutant(
            "brdf-over-hemisphere",
            &PHOTON_DENSITY,
            "albedo/2π for the BRDF of photons",
            parts(HALVED),
            &["photon/disc", "photon/gather"],
        ),
        mutant(
            "all-sides",
            &PHOTON_DENSITY,
            "photons count wherever they lie in the ball",
            parts(Table {
                same_side: |_, _| true,
                ..RIGHT
            }),
            &["photon/behind", "photon/corner"],
        ),
        mutant(
            "either-side",
            &PHOTON_DENSITY,
            "normals are compared up to their sign: light leaks through a floor",
            parts(Table {
                same_side: |a, b| a.dot(b).abs() > 0.9,
                ..RIGHT
            }),
            &["photon/behind"],
        ),
        mutant(
            "round-corners",
            &PHOTON_DENSITY,
            "photons of a wall count on the floor",
            parts(Table {
                same_side: |a, b| a.dot(b) > -0.5,
                ..RIGHT
            }),
            &["photon/corner"],
        ),
        mutant(
            "radius-kept",
            &PHOTON_RADIUS,
            "the radius never shrinks",
            parts(Table {
                pass_radius_squared: |first, _| first,
                ..RIGHT
            }),
            &["photon/passes"],
        ),
        mutant(
            "radius-too-fast",
            &PHOTON_RADIUS,
            "α = 0: the area is that of pass 1 over i, and the variance never falls",
            parts(Table {
                pass_radius_squared: |first, index| first / f64::from(index + 1),
                ..RIGHT
            }),
            &["photon/passes"],
        ),
    ]
}

fn maps() -> Vec<Mutant<Subject>> {
    vec![
        mutant(
            "direct-light-twice",
            &PHOTON_DENSITY,
            "the caustic map keeps light that came straight, which shadow rays bring as well",
            parts(Table {
                is_caustic: |_| true,
                ..RIGHT
            }),
            &["photon/shadow-rays", "photon/flux-through-glass"],
        ),
        mutant(
            "no-caustics",
            &PHOTON_DENSITY,
            "no light is a caustic: what mirrors and glass bring is lost",
            parts(Table {
                is_caustic: |_| false,
                ..RIGHT
            }),
            &["photon/index-matched"],
        ),
        mutant(
            "emitters-gathered",
            &PHOTON_DENSITY,
            "gathering rays count the emitters that they hit: direct light and caustics twice",
            parts(Table {
                gathers_emission: || true,
                ..RIGHT
            }),
            &["photon/index-matched", "photon/gather"],
        ),
    ]
}

fn particles() -> Vec<Mutant<Subject>> {
    vec![
        mutant(
            "shared-by-stored",
            &PHOTON_FLUX,
            "flux is divided by the photons stored in place of the particles emitted",
            parts(Table {
                photon_flux: |flux, _, stored| flux / stored.max(1) as f64,
                ..RIGHT
            }),
            &["photon/furnace", "photon/gather"],
        ),
        mutant(
            "channels-exchanged",
            &PHOTON_FLUX,
            "red and blue of the flux are exchanged",
            parts(Table {
                photon_flux: |flux, emitted, _| {
                    flux_share(DVec3::new(flux.z, flux.y, flux.x), emitted)
                },
                ..RIGHT
            }),
            &["photon/disc", "photon/index-matched", "photon/passes"],
        ),
        mutant(
            "survivors-unpaid",
            &ROULETTE,
            "particles that survive roulette carry no more than before",
            parts(Table {
                roulette_weight: |_| 1.0,
                ..RIGHT
            }),
            &["photon/flux-balance", "photon/furnace"],
        ),
        mutant(
            "particles-uniform",
            &COSINE_HEMISPHERE,
            "particles and gathering rays leave uniformly, with the cosine's pdf",
            parts(Table {
                cosine_hemisphere: uniform_hemisphere,
                ..RIGHT
            }),
            &["photon/disc", "photon/gather"],
        ),
    ]
}
