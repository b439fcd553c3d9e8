//! Emission of particles.

use glam::DVec3;

use super::NextEvent;
use super::light_sampling::{pick_point, point_pdf};
use crate::geometry::shape::Ray;
use crate::light::emitter::EmitterPoint;
use crate::material::Scattering;
use crate::math::frame::Frame;
use crate::sampling::rng::uniform2;
use crate::sampling::sampler::Sampler;
use crate::scene::Scene;

/// Emits one particle: picks an emitter, a point on it and a cosine-weighted direction. Returns the
/// ray along which it leaves and L_e cos θ / (p_A p_ω) of [`crate::equation::PHOTON_FLUX`], the flux
/// of all emitters if there were no other particle; `None` if there are no emitters or it carries
/// nothing.
#[inline]
pub(super) fn emit<P: NextEvent + Scattering + ?Sized, R: Sampler>(
    parts: &P,
    scene: &Scene,
    rng: &mut R,
) -> Option<(Ray, DVec3)> {
    let (index, light) = pick_point(parts, scene, rng)?;
    emit_from(parts, scene, index, &light, rng)
}

/// Emits one particle from a point that [`pick_point`] returned.
#[inline]
pub(super) fn emit_from<P: NextEvent + Scattering + ?Sized, R: Sampler>(
    parts: &P,
    scene: &Scene,
    index: usize,
    light: &EmitterPoint,
    rng: &mut R,
) -> Option<(Ray, DVec3)> {
    let wo = parts.cosine_hemisphere(uniform2(rng));
    let pdf = point_pdf(parts, scene, index) * parts.cosine_hemisphere_pdf(wo.z);
    if pdf == 0.0 {
        return None;
    }
    let direction = Frame::new(light.normal).world(wo);
    Some((
        scene.spawn_ray(light.point, light.normal, direction),
        scene.emitters()[index].radiance * (parts.cosine(DVec3::Z, wo) / pdf),
    ))
}
