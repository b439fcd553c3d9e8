//! Faults of photon mapping, each through the whole estimator.

use glam::Vec3Swizzles;
use whitefurnace::integrator::photon::photon_map::{density, flux_share};
use whitefurnace::sampling::warp::uniform_hemisphere;

use crate::prelude::*;

/// Photons that count half.
pub(super) const HALVED: PartTable = PartTable {
    photon_density: |brdf, flux, _, r2| density(0.5 * brdf, flux, r2),
    ..CORRECT
};

pub(crate) fn faults() -> Vec<Fault<EstimatorSubject>> {
    vec![
        // Densities.
        fault!("radius-for-its-square", PHOTON_DENSITY, "the disc's area is πr",
            { photon_density: |brdf, flux, _, r2| density(brdf, flux, r2.sqrt()) }, "photon/furnace",
            "photon/passes", "photon/sobol"),
        fault!("disc-without-pi", PHOTON_DENSITY, "the disc's area is r²",
            { photon_density: |brdf, flux, _, r2| density(brdf, flux, r2 * FRAC_1_PI) }, "photon/disc"),
        fault!("cosine-twice", PHOTON_DENSITY, "flux is multiplied by the cosine, which it has met already",
            { photon_density: |brdf, flux, wi, r2| density(brdf * wi.z, flux, r2) }, "photon/disc",
            "photon/furnace"),
        fault!("brdf-over-hemisphere", PHOTON_DENSITY, "albedo/2π for the BRDF of photons",
            = parts(HALVED), "photon/disc", "photon/gather"),
        fault!("all-sides", PHOTON_DENSITY, "photons count wherever they lie in the ball",
            { same_side: |_, _| true }, "photon/behind", "photon/corner"),
        fault!("either-side", PHOTON_DENSITY,
            "normals are compared up to their sign: light leaks through a floor",
            { same_side: |a, b| a.dot(b).abs() > 0.9 }, "photon/behind"),
        fault!("round-corners", PHOTON_DENSITY, "photons of a wall count on the floor",
            { same_side: |a, b| a.dot(b) > -0.5 }, "photon/corner"),
        fault!("radius-kept", PHOTON_RADIUS, "the radius never shrinks",
            { pass_radius_squared: |first, _| first }, "photon/passes", "photon/sobol"),
        fault!("radius-too-fast", PHOTON_RADIUS,
            "α = 0: the area is that of pass 1 over i, and the variance never falls",
            { pass_radius_squared: |first, index| first / f64::from(index + 1) }, "photon/passes", "photon/sobol"),
        // Maps.
        fault!("direct-light-twice", PHOTON_DENSITY,
            "the caustic map keeps light that came straight, which shadow rays bring as well",
            { is_caustic: |_| true }, "photon/shadow-rays", "photon/flux-through-glass"),
        fault!("no-caustics", PHOTON_DENSITY, "no light is a caustic: what mirrors and glass bring is lost",
            { is_caustic: |_| false }, "photon/index-matched"),
        fault!("emitters-gathered", PHOTON_DENSITY,
            "gathering rays count the emitters that they hit: direct light and caustics twice",
            { gathers_emission: || true }, "photon/index-matched", "photon/gather"),
        // Particles.
        fault!("shared-by-stored", PHOTON_FLUX,
            "flux is divided by the photons stored in place of the particles emitted",
            { photon_flux: |flux, _, stored| flux / stored.max(1) as f64 }, "photon/furnace",
            "photon/gather"),
        fault!("channels-exchanged", PHOTON_FLUX, "red and blue of the flux are exchanged",
            { photon_flux: |flux, emitted, _| flux_share(flux.zyx(), emitted) },
            "photon/disc", "photon/index-matched", "photon/passes", "photon/sobol"),
        fault!("survivors-unpaid", ROULETTE, "particles that survive roulette carry no more than before",
            { roulette_weight: |_| 1.0 }, "photon/flux-balance", "photon/furnace"),
        fault!("particles-uniform", COSINE_HEMISPHERE,
            "particles and gathering rays leave uniformly, with the cosine's pdf",
            { cosine_hemisphere: uniform_hemisphere }, "photon/disc", "photon/gather"),
    ]
}
