//! Effect of rounding on (4) and (7).

use whitefurnace::geometry::shape::{moller_trumbore, sphere_distances, sphere_distances_printed};
use whitefurnace::sampling::warp::sphere_zone;

use super::size;
use crate::experiments::prelude::*;

/// (4): rays aimed at the common edge of two triangles.
pub(super) fn edges(run: &mut Run) {
    let rays = run.count(run.by_tier(200_000, 5_000_000));
    let mut rng = stream(seed_for(run.seed(), "errata edges"), 0, 0);
    let (mut lost, mut twice) = (0u64, 0u64);
    for _ in 0..rays {
        let mut point = || {
            let [x, y] = uniform2(&mut rng);
            DVec3::new(x, y, uniform(&mut rng)) * 2.0 - 1.0
        };
        let [a, b, c, d, from] = [point(), point(), point(), point(), point() * 5.0];
        let target = a + uniform(&mut rng) * (b - a);
        let ray = Ray::new(from, (target - from).normalize());
        // The two lie on different sides of the edge as seen along the ray, or the ray may rightly
        // miss.
        let side = |p: DVec3| (b - a).cross(p - a).dot(ray.direction);
        let other = if side(c) * side(d) < 0.0 {
            d
        } else {
            2.0 * target - c
        };
        // Neighbours of a mesh run along their edge in opposite directions, from any corner.
        let mut neighbour = [b, a, other];
        neighbour.rotate_left((3.0 * uniform(&mut rng)) as usize);
        let met = [[a, b, c], neighbour].map(|t| moller_trumbore(&ray, t).is_some());
        lost += u64::from(met == [false, false]);
        twice += u64::from(met == [true, true]);
    }
    let what = "of rays aimed at a shared edge miss both triangles by (4)";
    size(run, "edge.lost", lost as f64 / rays as f64, what);
    let what = "of rays aimed at a shared edge meet both triangles by (4)";
    size(run, "edge.twice", twice as f64 / rays as f64, what);
    // P · E₁ is the product of the legs of a right triangle that the ray hits perpendicularly.
    let what = "long are the legs of the right triangle whose divisor is 1e-8 at most";
    size(run, "determinant.leg", 1e-8f64.sqrt(), what);
}

/// (7): the printed root against the stable one, for a unit sphere at growing distance.
pub(super) fn far_spheres(run: &mut Run) {
    let rays = run.count(100_000);
    for exponent in [2, 4, 6] {
        let distance = 10f64.powi(exponent);
        let mut rng = stream(seed_for(run.seed(), "errata sphere"), 0, exponent as u32);
        let (mut worst, mut single) = (0f64, 0f64);
        for _ in 0..rays {
            let target = sphere_zone(uniform2(&mut rng), 0.9, [-0.9, 0.9]);
            let from = distance * sphere_zone(uniform2(&mut rng), 1.0, [-1.0, 1.0]);
            let ray = Ray::new(from, (target - from).normalize());
            let printed = sphere_distances_printed(&ray, DVec3::ZERO, 1.0);
            let stable = sphere_distances(&ray, DVec3::ZERO, 1.0);
            if let (Some(printed), Some(stable)) = (printed, stable) {
                worst = worst.max((printed[0] - stable[0]).abs());
                single = single.max((single_precision(&ray) - stable[0]).abs());
            }
        }
        if exponent == 2 {
            size(
                run,
                "sphere.single.1e2",
                single,
                "radii: the same in single precision",
            );
        }
        let what =
            "radii: the largest error of the printed (7) at that many radii, in double precision";
        size(run, &format!("sphere.error.1e{exponent}"), worst, what);
    }
}

/// Returns the nearer root of the printed (7) for the unit sphere around the origin, in single
/// precision; NaN where its radicand is negative.
fn single_precision(ray: &Ray) -> f64 {
    let [o, l] = [ray.origin, ray.direction].map(|v| v.to_array().map(|x| x as f32));
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let half = dot(l, o);
    f64::from(-half - (half * half - (dot(o, o) - 1.0)).sqrt())
}
