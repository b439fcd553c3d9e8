//! Tests of environment maps: their radiance by hand, the density of their directions, and
//! refusals.

use whitefurnace::harness::domain::Domain;
use whitefurnace::light::environment::{Environment, EnvironmentMap};

use crate::prelude::*;

/// A map of four columns and three rows, with one pixel black in all channels between others that
/// are not.
fn uneven() -> EnvironmentMap {
    let pixels = (0..12)
        .map(|i| DVec3::new(f64::from(i), 1.0, 0.5) * f64::from(i % 5))
        .collect();
    EnvironmentMap::new(
        [4, 3],
        pixels,
        DVec3::new(0.0, 0.0, 2.0),
        DVec3::new(3.0, 0.0, 1.0),
    )
    .expect("a map")
}

/// Returns the direction of a place in an image whose top is z and whose middle is x; to the right
/// is −y.
fn direction_at(u: f64, v: f64) -> DVec3 {
    let (azimuth, inclination) = (TAU * (u - 0.5), PI * v);
    DVec3::new(
        inclination.sin() * azimuth.cos(),
        -inclination.sin() * azimuth.sin(),
        inclination.cos(),
    )
}

#[test]
fn centres_show_their_pixels_and_what_is_between_is_linear() {
    let map = uneven();
    let pixel =
        |x: usize, y: usize| DVec3::new((4 * y + x) as f64, 1.0, 0.5) * ((4 * y + x) % 5) as f64;
    let shown = |u: f64, v: f64| map.radiance(direction_at(u, v));
    for (u, v, expected) in [
        (0.125, 0.5, pixel(0, 1)),
        (0.625, 1.0 / 6.0, pixel(2, 0)),
        (0.875, 5.0 / 6.0, pixel(3, 2)),
        // Halfway to the right, a quarter down; across the edge; beyond the centres of the outer
        // rows.
        (0.5, 0.5, 0.5 * (pixel(1, 1) + pixel(2, 1))),
        (0.375, 0.25, 0.75 * pixel(1, 0) + 0.25 * pixel(1, 1)),
        (1e-12, 0.5, 0.5 * (pixel(3, 1) + pixel(0, 1))),
        (0.625, 0.01, pixel(2, 0)),
        (0.625, 0.999, pixel(2, 2)),
    ] {
        assert_abs_diff_eq!(shown(u, v), expected, epsilon = 1e-9);
    }
    assert_eq!(
        Environment::Map(map.clone()).radiance(-DVec3::Z),
        map.radiance(-DVec3::Z)
    );
}

/// Every pixel gets the share of directions that follows from its mean radiance and solid angle,
/// with weights 6/8 for itself and 1/8 for each neighbour along each axis; within the pixel they
/// are uniform in azimuth and height.
#[test]
fn directions_are_shared_by_radiance_and_solid_angle() {
    const N: u32 = 200;
    let map = uneven();
    let mut counts = [0u32; 12];
    for k in 0..N * N {
        let random =
            [f64::from(k % N) + 0.5, f64::from(k / N) + 0.5].map(|number| number / f64::from(N));
        let (direction, pdf) = map.sample(random);
        assert_relative_eq!(direction.length(), 1.0, max_relative = 1e-12);
        assert_relative_eq!(pdf, map.pdf(direction), max_relative = 1e-9);
        let (u, v) = (
            0.5 - direction.y.atan2(direction.x) / TAU,
            direction.z.acos() / PI,
        );
        counts[4 * (3.0 * v) as usize + (4.0 * u) as usize] += 1;
    }
    let mean = |i: i32| f64::from(i + 1) + 0.5;
    let weight = |x: i32, y: i32| {
        let kernel = [(-1, 0.125), (0, 0.75), (1, 0.125)];
        let pixel = |x: i32, y: i32| {
            let i = 4 * y.clamp(0, 2) + x.rem_euclid(4);
            mean(i) * f64::from(i % 5)
        };
        let parts = kernel.iter().flat_map(|(dy, b)| {
            kernel
                .iter()
                .map(move |(dx, a)| a * b * pixel(x + dx, y + dy))
        });
        let band = [1.0, 0.5, -0.5, -1.0];
        parts.sum::<f64>() * (band[y as usize] - band[y as usize + 1])
    };
    let weights: Vec<f64> = (0..12).map(|i| weight(i % 4, i / 4)).collect();
    let all: f64 = weights.iter().sum();
    for (count, weight) in counts.iter().zip(&weights) {
        let share = f64::from(*count) / f64::from(N * N);
        assert_abs_diff_eq!(share, weight / all, epsilon = 1.0 / f64::from(N));
    }
    // The last row and column are reached to their ends.
    for edge in DVec3::AXES
        .into_iter()
        .flat_map(|axis| [axis, -axis, axis.with_x(-0.0), (-axis).with_y(-0.0)])
    {
        assert!(map.pdf(edge) > 0.0, "{edge}");
    }
    let spread = Domain::Sphere.integrate_all(1e-3, &|w| map.pdf(w)).value;
    assert_abs_diff_eq!(spread, 1.0, epsilon = 1e-2);
}

#[test]
fn what_is_no_map_is_refused() {
    let map = |size, pixels: Vec<DVec3>, front| EnvironmentMap::new(size, pixels, DVec3::Z, front);
    for (wrong, hint) in [
        (
            map([2, 2], vec![DVec3::ONE; 3], DVec3::X),
            "which are not 2 × 2",
        ),
        (map([0, 0], vec![], DVec3::X), "which are not 0 × 0"),
        (
            map([1, 2], vec![DVec3::ONE, DVec3::NAN], DVec3::X),
            "pixel (0, 1) is [NaN, NaN, NaN]",
        ),
        (map([1, 1], vec![-DVec3::ONE], DVec3::X), "no radiance"),
        (
            map([1, 1], vec![DVec3::ZERO], DVec3::X),
            "all pixels are black",
        ),
        (map([1, 1], vec![DVec3::ONE], -DVec3::Z), "along one line"),
    ] {
        let message = wrong.expect_err(hint);
        assert!(message.contains(hint), "{message}");
    }
}

/// Lanes return the bits of single rays under a map, with and without lamps.
#[test]
fn lanes_follow_a_map() {
    let scene = |lit: bool| {
        scene_from(
            Camera::new(DVec3::new(0.0, -4.0, 1.0), DVec3::ZERO, DVec3::Z, 0.6),
            |s| {
                ball(s, Sphere::new(DVec3::ZERO, 1.0), diffuse(0.7));
                ball(s, Sphere::new(DVec3::new(1.0, -1.0, 0.0), 0.3), glass(1.5));
                if lit {
                    ball(s, Sphere::new(DVec3::new(-1.5, 0.0, 1.5), 0.3), lamp(5.0));
                }
                s.environment(Environment::Map(uneven()));
            },
        )
    };
    let sampling = sampling(Random, SamplerKind::Independent, master());
    for (lit, strategy) in [false, true].into_iter().flat_map(|lit| {
        [PathStrategy::Bsdf, PathStrategy::Light, PathStrategy::Mis].map(|strategy| (lit, strategy))
    }) {
        let scene = scene(lit);
        let path = Path::new(strategy);
        let alone = path.with_parts(Parts::replaced(&ScalarParts));
        let rays = rendered(&scene, &alone, [16, 12], sampling, &[0..4]).expect("legal values");
        let together = lanes(LaneEstimator::Path(path), sampling, Precision::Double);
        let together = filled(&together, &scene, [16, 12], 0..4).expect("legal values");
        assert_eq!(together, rays);
        assert!(rays.mean() > 0.1);
    }
}
