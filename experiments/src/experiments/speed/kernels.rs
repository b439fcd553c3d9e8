//! Rays per second, alone and eight at a time.

use std::hint::black_box;

use whitefurnace::math::frame::Frame;
use whitefurnace::math::real::Vector as _;
use whitefurnace::math::simd::{LANES, Lanes3};
use whitefurnace::scene::lanes::EightRayIntersector;
use whitefurnace::scene::simple::cornell;

use super::least_seconds;
use crate::experiments::prelude::*;

/// Records millions of rays per second on one thread: the nearest hit and the shadow ray, from the
/// first hits of camera rays in the room.
pub(super) fn rays(run: &mut Run) -> Result<(), Error> {
    let scene = room::diffuse()?;
    let bounced = bounced_rays(run, &scene);
    let light = DVec3::new(4.0, 0.0, 4.99);
    let shadow: Vec<Ray> = bounced
        .iter()
        .map(|ray| Ray::new(ray.origin, light - ray.origin))
        .collect();
    query(run, "closest", &bounced, |ray| {
        black_box(scene.bvh().closest(ray, f64::INFINITY));
        1
    })?;
    query(run, "occluded", &shadow, |ray| {
        black_box(scene.bvh().occluded(ray, 1.0, |_| true));
        1
    })
}

/// Records millions of rays per second that are intersected eight at a time in the Cornell box.
pub(super) fn eight_rays(run: &mut Run) -> Result<(), Error> {
    let scene = cornell()?;
    let Some(mut eight) = EightRayIntersector::new(&scene) else {
        return Ok(());
    };
    let packets: Vec<Ray<Lanes3>> = bounced_rays(run, &scene)
        .chunks_exact(LANES)
        .map(packet)
        .collect();
    query(run, "eight", &packets, |ray| {
        black_box(eight.closest(ray));
        LANES
    })
}

/// Records how many millions of these rays are intersected per second, in a loop. `ask` returns the
/// number of rays it has processed.
fn query<R>(
    run: &mut Run,
    key: &str,
    rays: &[R],
    mut ask: impl FnMut(&R) -> usize,
) -> Result<(), Error> {
    let count = run.count(run.by_tier(100_000, 1_000_000)) as usize;
    let (asked, seconds) = least_seconds(run, || {
        Ok(rays
            .iter()
            .cycle()
            .take(count)
            .map(|ray| ask(black_box(ray)))
            .sum::<usize>())
    })?;
    let rate = asked as f64 / seconds;
    run.number(&format!("rays.{key}"), rate / 1e6);
    run.note(
        &format!("rays.{key}"),
        format!("{:.2} million rays/s", rate / 1e6),
    );
    Ok(())
}

/// Returns diffuse bounces off the first hits of camera rays through random places of the image.
fn bounced_rays(run: &Run, scene: &Scene) -> Vec<Ray> {
    let seed = seed_for(run.seed(), "speed rays");
    let bounced = |i| {
        let rng = &mut stream(seed, 0, i);
        let [x, y] = uniform2(rng);
        let hit = scene.intersect(&scene.camera().ray([4, 3], 4.0 * x, 3.0 * y))?;
        let direction = Frame::new(hit.normal).world(cosine_hemisphere(uniform2(rng)));
        Some(scene.spawn_ray(hit.point, hit.normal, direction))
    };
    (0..1024).filter_map(bounced).collect()
}

fn packet(rays: &[Ray]) -> Ray<Lanes3> {
    Ray::new(
        Lanes3::from_fn(|i| rays[i].origin),
        Lanes3::from_fn(|i| rays[i].direction),
    )
}
