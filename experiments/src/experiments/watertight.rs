//! Watertightness: no ray leaves the closed room.

use rand::Rng;
use rand_distr::{Distribution, UnitSphere};
use whitefurnace::scene::Geometry;
use whitefurnace::scene::room::Convention;

use crate::experiments::prelude::*;

pub(super) const WATERTIGHT: Experiment = Experiment {
    id: "watertight",
    title: "rays that leave the closed room, aimed everywhere, at edges and at corners",
    headline: "of {corners.rays %d} rays to corners of a closed room {corners.lost %d} leave it, to edges {edges.lost %d}, elsewhere {anywhere.lost %d}",
    version: 1,
    equations: &[&equation::TRIANGLE_SOLUTION],
    run,
};

/// Target of the first ray of a walk.
#[derive(Clone, Copy)]
enum Target {
    Anywhere,
    Edge,
    Corner,
}

const TARGETS: [(Target, &str); 3] = [
    (Target::Anywhere, "anywhere"),
    (Target::Edge, "edges"),
    (Target::Corner, "corners"),
];
/// Rays of one walk: the first from a random point, each later one from the last hit.
const WALK: u64 = 5;
/// Walks of one random stream.
const BATCH: u64 = 20_000;

fn run(run: &mut Run) -> Result<(), Error> {
    let scene = room::report(Convention::Physical, OrenNayarForm::Corrected)?;
    let rays = run.count(run.by_tier(10_000_000, 100_000_000));
    let batches = rays.div_ceil(3 * WALK * BATCH) as u32;
    let corners = |(geometry, _)| match geometry {
        Geometry::Triangle(corners) => Some(corners),
        Geometry::Sphere(_) => None,
    };
    let triangles: Vec<[DVec3; 3]> = scene.primitives().filter_map(corners).collect();
    for (target, label) in TARGETS {
        let seed = seed_for(run.seed(), label);
        let lost = parallel_map(0..batches, |batch| -> u64 {
            let mut rng = stream(seed, batch, 0);
            (0..BATCH)
                .map(|_| lost_in_walk(&scene, &triangles, target, &mut rng))
                .sum()
        })?;
        let lost: u64 = lost.into_iter().sum();
        let total = u64::from(batches) * BATCH * WALK;
        run.numbers(label, [("rays", total as f64), ("lost", lost as f64)]);
        run.claim(
            &format!("aimed at {label}"),
            format!("{lost} of {total} rays lost"),
            lost == 0,
        );
    }
    Ok(())
}

/// Follows a random walk that continues from each hit into the hemisphere above it; returns the
/// number of lost rays.
fn lost_in_walk<R: Rng>(
    scene: &Scene,
    triangles: &[[DVec3; 3]],
    target: Target,
    rng: &mut R,
) -> u64 {
    let origin = point_inside(rng);
    let target = match target {
        Target::Anywhere => origin + DVec3::from_array(UnitSphere.sample(rng)),
        Target::Edge | Target::Corner => {
            let triangle = triangles[(uniform(rng) * triangles.len() as f64) as usize];
            let corner = (uniform(rng) * 3.0) as usize;
            let along = if matches!(target, Target::Edge) {
                uniform(rng)
            } else {
                0.0
            };
            triangle[corner].lerp(triangle[(corner + 1) % 3], along)
        }
    };
    let mut ray = Ray::new(origin, (target - origin).normalize());
    for rays_left in (1..=WALK).rev() {
        let Some(hit) = scene.intersect(&ray) else {
            return rays_left;
        };
        let oriented = hit.normal * -hit.normal.dot(ray.direction).signum();
        let direction = DVec3::from_array(UnitSphere.sample(rng));
        ray = scene.spawn_ray(
            hit.point,
            hit.normal,
            direction * oriented.dot(direction).signum(),
        );
    }
    0
}

/// Samples a point inside the walls, uniform in volume: the hexagon narrows to a corner at either
/// end.
fn point_inside<R: Rng>(rng: &mut R) -> DVec3 {
    loop {
        let mut between = |low: f64, high: f64| low + (high - low) * uniform(rng);
        let p = DVec3::new(between(-3.0, 13.0), between(-6.0, 6.0), between(-5.0, 5.0));
        let along = 0.5 * p.y.abs();
        if p.x > along - 3.0 && p.x < 13.0 - along {
            return p;
        }
    }
}
