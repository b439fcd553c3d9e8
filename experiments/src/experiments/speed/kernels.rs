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
    let bounces = bounces(run, &scene);
    let light = SurfacePoint {
        point: DVec3::new(4.0, 0.0, 4.99),
        normal: DVec3::NEG_Z,
    };
    query(run, "closest", &bounces, |bounce| {
        black_box(scene.bvh().closest(&bounce.ray, f64::INFINITY));
        1
    })?;
    query(run, "occluded", &bounces, |bounce| {
        black_box(scene.visible(bounce.from, light, false));
        1
    })
}

/// Records millions of rays per second that are intersected eight at a time in the Cornell box.
pub(super) fn eight_rays(run: &mut Run) -> Result<(), Error> {
    let scene = cornell()?;
    let mut eight = EightRayIntersector::new(&scene);
    let packets: Vec<Ray<Lanes3>> = bounces(run, &scene)
        .chunks_exact(LANES)
        .map(packet)
        .collect();
    query(run, "eight", &packets, |ray| {
        black_box(eight.closest_of_eight(ray));
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

/// A diffuse bounce.
struct Bounce {
    from: SurfacePoint,
    ray: Ray,
}

/// Returns diffuse bounces off the first hits of camera rays through random places of the image.
fn bounces(run: &Run, scene: &Scene) -> Vec<Bounce> {
    let seed = seed_for(run.seed(), "speed rays");
    let bounced = |i| {
        let rng = &mut stream(seed, 0, i);
        let [x, y] = uniform2(rng);
        let hit = scene.intersect(&scene.camera().ray([4, 3], 4.0 * x, 3.0 * y))?;
        let direction = Frame::new(hit.normal).world(cosine_hemisphere(uniform2(rng)));
        Some(Bounce {
            from: SurfacePoint {
                point: hit.point,
                normal: hit.normal,
            },
            ray: scene.spawn_ray(hit.point, hit.normal, direction),
        })
    };
    (0..1024).filter_map(bounced).collect()
}

fn packet(bounces: &[Bounce]) -> Ray<Lanes3> {
    Ray::new(
        Lanes3::from_fn(|i| bounces[i].ray.origin),
        Lanes3::from_fn(|i| bounces[i].ray.direction),
    )
}
