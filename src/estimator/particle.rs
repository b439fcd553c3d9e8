//! Particles: how they leave the emitters, where they come by, and what of them the eye sees.

use glam::DVec3;

use super::emission::{Emission, emit_from};
use super::next_event::{pick_point, point_pdf};
use super::strategies::{Bidirectional, PathVertex};
use super::walk::Walk;
use super::{NextEvent, Walking};
use crate::bsdf::Scattering;
use crate::error::Error;
use crate::sampler::{LIGHT, Sampler};
use crate::scene::Scene;

/// Sends one particle from an emitter and shows every place where it is, the emitter first. It carries
/// flux, which refraction does not change.
pub(super) fn particle<'a, P: Walking + Bidirectional, R: Sampler>(
    parts: &P,
    scene: &'a Scene,
    rng: &mut R,
    mut visit: impl FnMut(PathVertex<'a>) -> Result<(), Error>,
) -> Result<(), Error> {
    rng.block(LIGHT);
    let Some((index, light)) = pick_point(parts, scene, rng) else {
        return Ok(());
    };
    let carried = scene.emitters()[index].radiance / point_pdf(parts, scene, index);
    visit(PathVertex::emitting(&light, carried, index))?;
    let Some(Emission { ray, flux }) = emit_from(parts, scene, (index, &light), rng) else {
        return Ok(());
    };
    let mut walk = Walk::new(scene, (ray, scene.intersect(&ray)), LIGHT);
    while let Some(step) = walk.arrive(rng) {
        if step.endless {
            return Err(Error::Radiance { value: f64::NAN, place: String::new() });
        }
        let at = step.vertex();
        visit(step.path_vertex(at, flux * step.throughput * parts.flux_factor(step.factor)))?;
        walk.scatter(parts, &at, rng);
    }
    Ok(())
}

/// What the eye sees of one particle among as many as the image has pixels.
pub(super) struct Splat {
    /// Column and row.
    pub pixel: [u32; 2],
    /// What it adds to the pixel's radiance, before any weight.
    pub value: DVec3,
    /// The pdf of the camera ray that would have found the place, as in
    /// [`WholePath`](super::strategies::WholePath).
    pub importance: f64,
}

/// Connects a place to the eye; `None` if the eye sees nothing of it.
#[inline]
pub(super) fn connect_to_eye<P: Scattering + NextEvent + Bidirectional>(
    parts: &P,
    scene: &Scene,
    frame: [u32; 2],
    place: &PathVertex<'_>,
) -> Option<Splat> {
    let (point, normal) = (place.at.point, place.normal());
    let camera = scene.camera();
    let seen = camera.project(frame, point)?;
    let cosine = parts.cosine(normal, seen.to_eye);
    let leaving = place.leaving(parts, seen.to_eye);
    if cosine <= 0.0
        || leaving == DVec3::ZERO
        || !parts.visible(scene, (camera.eye, -seen.to_eye), (point, normal), false)
    {
        return None;
    }
    let importance = importance_per_particle(parts, scene, frame, -seen.to_eye);
    Some(Splat {
        pixel: seen.pixel,
        value: leaving * parts.solid_angle_per_area(cosine, seen.distance_squared) * importance,
        importance,
    })
}

/// W(ω) of a pixel, shared among as many particles as the image has pixels.
#[inline]
pub(super) fn importance_per_particle<P: Bidirectional>(
    parts: &P,
    scene: &Scene,
    frame: [u32; 2],
    direction: DVec3,
) -> f64 {
    let particles = f64::from(frame[0]) * f64::from(frame[1]);
    parts.importance(scene.camera(), frame, direction) / particles
}
