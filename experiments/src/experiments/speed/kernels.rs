//! What rays cost, and what share of the processor's arithmetic the lane engine uses.

use std::array::from_fn;
use std::hint::black_box;

use whitefurnace::frame::Frame;
use whitefurnace::lanes::EightRays;
use whitefurnace::real::{LANES, Lanes, Lanes3, Vector as _};
use whitefurnace::scene::simple::cornell;

use super::least_seconds;
use crate::experiments::prelude::*;

/// Records millions of rays per second on one thread: the nearest hit and the shadow ray, from where
/// camera rays hit the room.
pub(super) fn rays(run: &mut Run) -> Result<(), Error> {
    let scene = room::diffuse()?;
    let bounced = bounced_rays(run, &scene);
    let light = DVec3::new(4.0, 0.0, 4.99);
    let shadow: Vec<Ray> = bounced.iter().map(|ray| Ray::new(ray.origin, light - ray.origin)).collect();
    query(run, "closest", &bounced, |ray| {
        black_box(scene.bvh().closest(ray, f64::INFINITY));
        1
    })?;
    query(run, "occluded", &shadow, |ray| {
        black_box(scene.bvh().occluded(ray, 1.0, |_| true));
        1
    })?;
    Ok(())
}

/// Records the most that one thread computes and reads per second, and what the lane engine's search for the nearest
/// hit reaches in the Cornell box: the operations of [`EightRays::operations`], times the rays per second.
///
/// The processor's most is measured, and without fused multiply-adds, which round once where the engine rounds twice.
/// All that the search reads and writes is some ten kilobytes and stays in the nearest cache: it needs nothing of the
/// bandwidth, so its roof is the arithmetic.
pub(super) fn roofline(run: &mut Run) -> Result<(), Error> {
    let peak = arithmetic(run)?;
    let bandwidth = bandwidth(run)?;
    let scene = cornell()?;
    let Some(mut eight) = EightRays::new(&scene) else {
        return Ok(());
    };
    let packets: Vec<Ray<Lanes3>> = bounced_rays(run, &scene).chunks_exact(LANES).map(packet).collect();
    let operations: f64 = packets.iter().map(|ray| f64::from(eight.operations(ray))).sum();
    let operations = operations / packets.len() as f64;
    let rate = query(run, "eight", &packets, |ray| {
        black_box(eight.closest(ray));
        LANES
    })?;
    let reached = rate * operations;
    run.numbers(
        "roofline",
        [
            ("peak", peak / 1e9),
            ("bandwidth", bandwidth / 1e9),
            ("operations", operations),
            ("reached", reached / 1e9),
            ("share", reached / peak),
        ],
    );
    let value = format!(
        "{:.1} of {:.1} thousand million operations/s, {operations:.0} a ray; memory {:.1} GB/s",
        reached / 1e9,
        peak / 1e9,
        bandwidth / 1e9
    );
    run.note("roofline", value);
    Ok(())
}

/// Records how many millions of these rays, again and again, are asked for per second; returns how many. `ask` says
/// for how many it has asked.
fn query<R>(run: &mut Run, key: &str, rays: &[R], mut ask: impl FnMut(&R) -> usize) -> Result<f64, Error> {
    let count = run.count(run.by_tier(100_000, 1_000_000)) as usize;
    let (asked, seconds) =
        least_seconds(run, || Ok(rays.iter().cycle().take(count).map(|ray| ask(black_box(ray))).sum::<usize>()))?;
    let rate = asked as f64 / seconds;
    run.number(&format!("rays.{key}"), rate / 1e6);
    run.note(&format!("rays.{key}"), format!("{:.2} million rays/s", rate / 1e6));
    Ok(rate)
}

/// Diffuse bounces off the first surfaces that camera rays through random places of the image meet.
fn bounced_rays(run: &Run, scene: &Scene) -> Vec<Ray> {
    let seed = seed_for(run.seed(), "speed rays");
    let bounced = |i| {
        let rng = &mut stream(seed, 0, i);
        let [x, y] = uniform2(rng);
        let hit = scene.intersect(&scene.camera().ray([4, 3], 4.0 * x, 3.0 * y))?;
        let direction = Frame::new(hit.normal).world(cosine_hemisphere(uniform2(rng)));
        Some(scene.leave(hit.point, hit.normal, direction))
    };
    (0..1024).filter_map(bounced).collect()
}

fn packet(rays: &[Ray]) -> Ray<Lanes3> {
    Ray::new(Lanes3::from_fn(|i| rays[i].origin), Lanes3::from_fn(|i| rays[i].direction))
}

/// The most additions and multiplications per second of one thread, on numbers in registers.
fn arithmetic(run: &Run) -> Result<f64, Error> {
    // How many chains hide the wait for results without more numbers than registers depends on the processor.
    let rates = [chains::<2>(run)?, chains::<4>(run)?, chains::<6>(run)?, chains::<8>(run)?, chains::<12>(run)?];
    Ok(rates.into_iter().fold(0.0, f64::max))
}

/// The same by N chains x ← ax + b, each of [`LANES`] numbers.
fn chains<const N: usize>(run: &Run) -> Result<f64, Error> {
    let steps = run.count(run.by_tier(1_000_000, 20_000_000));
    let [a, b] = [0.999, 0.001].map(|value| Lanes::splat(black_box(value)));
    let ((), seconds) = least_seconds(run, || {
        let mut x: [Lanes; N] = from_fn(|i| Lanes::splat(black_box(i as f64)));
        for _ in 0..steps {
            x = x.map(|x| x * a + b);
        }
        black_box(x);
        Ok(())
    })?;
    Ok((2 * N * LANES) as f64 * steps as f64 / seconds)
}

/// The most bytes per second that one thread reads from memory: from an array far larger than caches, in order.
fn bandwidth(run: &Run) -> Result<f64, Error> {
    const SUMS: usize = 8;
    let numbers = vec![1.0; 1 << 25];
    let ((), seconds) = least_seconds(run, || {
        let mut sums = [Lanes::splat(0.0); SUMS];
        for block in numbers.chunks_exact(SUMS * LANES) {
            for (sum, part) in sums.iter_mut().zip(block.chunks_exact(LANES)) {
                *sum += Lanes::new(from_fn(|i| part[i]));
            }
        }
        black_box(sums);
        Ok(())
    })?;
    Ok(size_of_val(&numbers[..]) as f64 / seconds)
}
