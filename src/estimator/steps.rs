//! Steps that the estimators share: what an emitter shows, and the way on.

use glam::DVec3;

use super::LightRules;
use crate::scene::{Hit, Scene};
use crate::shape::Ray;

/// What an emitter shows along a ray that hit it; zero for its back and for other surfaces.
#[inline]
pub(super) fn emitted(scene: &Scene, hit: &Hit, ray: &Ray) -> DVec3 {
    match hit.emitter {
        Some(emitter) if hit.normal.dot(ray.direction) < 0.0 => scene.emitters()[emitter as usize].radiance,
        _ => DVec3::ZERO,
    }
}

/// [`emitted`] under light rules that show every emitter alike.
#[inline]
pub(super) fn seen(scene: &Scene, hit: &Hit, ray: &Ray, rules: &LightRules) -> DVec3 {
    let radiance = emitted(scene, hit, ray);
    match rules.seen {
        Some(shown) if radiance != DVec3::ZERO => DVec3::splat(shown),
        _ => radiance,
    }
}

/// The ray that leaves a hit in a direction, and what it meets.
#[inline]
pub(super) fn onward(scene: &Scene, here: &Hit, direction: DVec3) -> (Ray, Option<Hit>) {
    let ray = scene.leave(here.point, here.normal, direction);
    (ray, scene.intersect(&ray))
}

/// Radiance that arrives at a hit from a direction, by `arriving` with one of the `segments` fewer; zero
/// where none is left. The first is always followed, even of none.
#[inline]
pub(super) fn next(
    scene: &Scene,
    here: &Hit,
    direction: DVec3,
    segments: u32,
    arriving: impl FnOnce(&Ray, Option<Hit>, u32) -> DVec3,
) -> DVec3 {
    if segments <= 1 {
        return DVec3::ZERO;
    }
    let (ray, hit) = onward(scene, here, direction);
    arriving(&ray, hit, segments - 1)
}
