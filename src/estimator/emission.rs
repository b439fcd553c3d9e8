//! How particles leave the emitters.

use glam::DVec3;

use super::Parts;
use crate::frame::Frame;
use crate::rng::{uniform, uniform2};
use crate::sampler::Sampler;
use crate::scene::Scene;
use crate::shape::Ray;

/// A particle that leaves an emitter.
pub(super) struct Emission {
    /// Its way.
    pub ray: Ray,
    /// L_e cos θ / (p_A p_ω) of [`crate::equation::PHOTON_FLUX`], the flux of all emitters if there were no
    /// other particle.
    pub flux: DVec3,
}

/// Sends one particle from an emitter: which one, a point on it, a cosine-weighted direction. `None` if
/// there are no emitters or the particle carries nothing.
#[inline]
pub(super) fn emit<P: Parts, R: Sampler>(
    parts: &P,
    scene: &Scene,
    rng: &mut R,
) -> Option<Emission> {
    let emitters = scene.emitters();
    if emitters.is_empty() {
        return None;
    }
    let emitter = &emitters[parts.pick_emitter(uniform(rng), emitters.len())];
    let light = parts.sample_emitter(emitter, uniform2(rng));
    let wi = parts.cosine_hemisphere(uniform2(rng));
    let pdf =
        parts.emitter_pdf_area(emitter) / emitters.len() as f64 * parts.cosine_hemisphere_pdf(wi.z);
    if pdf == 0.0 {
        return None;
    }
    let direction = Frame::new(light.normal).world(wi);
    Some(Emission {
        ray: scene.leave(light.point, light.normal, direction),
        flux: emitter.radiance * (parts.cosine(DVec3::Z, wi) / pdf),
    })
}
