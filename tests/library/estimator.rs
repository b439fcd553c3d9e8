//! Tests of estimators, path by path, in scenes where every path has the same value or zero.

use whitefurnace::integrator::Quirks;
use whitefurnace::sampling::roulette::{REFERENCE_THROUGHPUT, by_throughput};

use crate::budget::assert_enough_compared;
use crate::prelude::*;

const LIGHTS: [LightSampling; 2] = [LightSampling::Area, LightSampling::SolidAngle];

/// Roulette without its weight: a path has the value that it would have without roulette, or zero.
#[derive(Clone, Copy, Debug, Default)]
struct Unweighted;

default_parts!(Unweighted: Scattering, NextEvent, Photons, Bidirectional, FiniteElements);

impl Roulette for Unweighted {
    fn roulette_weight(&self, _: f64) -> f64 {
        1.0
    }
}

/// Returns the values of paths from the scene's camera through random points of the image.
fn values(name: &str, scene: &Scene, estimator: &dyn Estimator, count: usize) -> Vec<DVec3> {
    let mut rng = rng(name);
    (0..count)
        .map(|_| {
            let [x, y] = uniform2(&mut rng);
            let ray = scene.camera().ray([1, 1], x, y);
            estimator.radiance(scene, &ray, scene.intersect(&ray), &mut rng)
        })
        .collect()
}

/// Asserts that every value is 0 or `expected`, and more than half are the latter. A path of up to
/// fifty bounces rounds its throughput eight times per bounce.
fn assert_all_or_nothing(name: &str, values: &[DVec3], expected: f64) {
    let full = |v: &DVec3| (*v - expected).abs().max_element() <= 400.0 * UNIT_ROUNDOFF * expected;
    for value in values {
        assert!(
            *value == DVec3::ZERO || full(value),
            "{value} is not {expected}"
        );
    }
    assert_enough_compared(name, values.iter().filter(|v| full(v)).count());
}

#[test]
fn paths_in_a_uniform_environment_see_it() {
    let path = Path::new(PathStrategy::Mis).with_parts(Parts::replaced(&Unweighted));
    let scene = simple::environment().expect("a scene");
    assert_all_or_nothing("around", &values("environment", &scene, &path, 5000), 1.0);
    let scene = simple::glass_cube(false).expect("a scene");
    assert_all_or_nothing(
        "through glass",
        &values("glass-cube", &scene, &path, 5000),
        1.0,
    );
}

#[test]
fn paths_inside_glass_see_the_squared_index() {
    // Rays that meet the faces at right angles leave at once, except for R = 4 %.
    let path = Path::new(PathStrategy::Mis).with_parts(Parts::replaced(&Unweighted));
    let scene = simple::glass_cube(true).expect("a scene");
    let mut rng = rng("inside glass");
    let values: Vec<_> = (0..3000)
        .map(|i| {
            let tilt = 0.1 * unit_vector(&mut rng);
            let ray = Ray::new(DVec3::ZERO, (DVec3::AXES[i % 3] + tilt).normalize());
            path.radiance(&scene, &ray, scene.intersect(&ray), &mut rng)
        })
        .collect();
    assert_all_or_nothing("inside glass", &values, 2.25);
    // Only the camera's half of the bidirectional paths: nothing but the background emits.
    let bdpt = Bdpt::new(Parts::replaced(&Unweighted));
    let pass = |index| bdpt.pass(&scene, [16, 12], master(), index);
    let values: Vec<_> = (0..16)
        .flat_map(|index| pass(index).expect("an image"))
        .collect();
    assert_all_or_nothing("inside glass, bidirectional", &values, 2.25);
}

/// A glass sphere around the origin in a uniform environment.
fn glass_sphere(index: f64) -> Scene {
    scene(|scene| {
        scene.background(DVec3::ONE);
        ball(scene, Sphere::new(DVec3::ZERO, 1.0), glass(index));
    })
}

#[test]
fn whitted_trees_lose_only_what_the_limit_cuts() {
    // From the centre a ray meets the sphere at right angles: n² (1 − R) Σ R^k over the inner
    // segments, with the segment after the last hit one of seven. The report's rules have no
    // radiance factor.
    for index in [1.2, 1.5, 2.4] {
        let scene = glass_sphere(index);
        let mut rng = rng("whitted");
        let ray = Ray::new(DVec3::ZERO, unit_vector(&mut rng));
        let r: f64 = ((index - 1.0) / (index + 1.0)).powi(2);
        for (rules, factor) in [
            (TransportRules::PHYSICAL, index * index),
            (TransportRules::REPORT, 1.0),
        ] {
            let found = Whitted::new(rules).radiance(&scene, &ray, scene.intersect(&ray), &mut rng);
            let expected = factor * (1.0 - r.powi(6));
            assert!((found - expected).abs().max_element() <= 100.0 * UNIT_ROUNDOFF * factor);
        }
    }
}

#[test]
fn emitters_are_seen_under_each_rule() {
    let eye = DVec3::new(12.5, 0.0, 0.0);
    let front = Ray::new(eye, (DVec3::new(4.0, 0.0, 4.999) - eye).normalize());
    // Between the light and the ceiling, looking down at its back.
    let back = Ray::new(DVec3::new(4.0, 0.0, 4.9995), -DVec3::Z);
    let mut rng = rng("emitters");
    let scene = room::report(Convention::Physical, OrenNayarForm::Corrected).expect("the room");
    let path = Path::new(PathStrategy::Mis).with_parts(Parts::replaced(&Unweighted));
    let whitted = Whitted::new(TransportRules::PHYSICAL);
    let report = Report::default();
    for (ray, radiance, shown) in [(front, 50.0, 1.0), (back, 0.0, 0.0)] {
        let hit = scene.intersect(&ray);
        assert!(hit.is_some_and(|hit| hit.emitter == Some(0)));
        assert_eq!(
            path.radiance(&scene, &ray, hit, &mut rng),
            DVec3::splat(radiance)
        );
        assert_eq!(
            whitted.radiance(&scene, &ray, hit, &mut rng),
            DVec3::splat(radiance)
        );
        assert_eq!(
            report.radiance(&scene, &ray, hit, &mut rng),
            DVec3::splat(shown)
        );
    }
}

#[test]
fn facing_mirrors_end() {
    // Between perfect mirrors only roulette, or the limit on segments, ends a path: radiance is 0.
    let scene = within_sphere(reflecting(1.0));
    let mut found = values(
        "facing mirrors",
        &scene,
        &Path::new(PathStrategy::Mis).with_parts(Parts::replaced(&Unweighted)),
        1000,
    );
    found.extend(values("facing mirrors", &scene, &Report::default(), 100));
    assert!(found.iter().all(|v| *v == DVec3::ZERO));
}

#[test]
fn direct_light_of_whitted_is_f_cos_over_pdf() {
    // One emitter far above a floor; the point that the shadow ray samples is known from the
    // stream.
    let albedo = DVec3::new(0.2, 0.5, 0.8);
    let scene = scene(|scene| {
        square(
            scene,
            5.0,
            0.0,
            true,
            Surface::new(Bsdf::Lambert { albedo }),
        );
        square(scene, 1.0, 2.0, false, lamp(3.0));
    });
    let ray = Ray::new(
        DVec3::new(4.0, 0.0, 1.0),
        DVec3::new(-1.0, 0.0, -1.0).normalize(),
    );
    let hit = scene.intersect(&ray).expect("the floor");
    let mut rng = rng("direct light");
    for _ in 0..200 {
        let mut copy = rng.clone();
        let found =
            Whitted::new(TransportRules::PHYSICAL).radiance(&scene, &ray, Some(hit), &mut rng);
        // The draws: first which emitter, then the point on it.
        let _ = uniform(&mut copy);
        let [s, t] = uniform2(&mut copy);
        let y = DVec3::new(-1.0 + 2.0 * t, -1.0 + 2.0 * s, 2.0);
        let d2 = (y - hit.point).length_squared();
        let expected = albedo / PI * 3.0 * 4.0 * (2.0 * 2.0) / (d2 * d2);
        assert!((found - expected).abs().max_element() <= 64.0 * UNIT_ROUNDOFF);
    }
}

/// A floor under, or within, one lamp of a shape: the stream says which points shadow rays sample
/// and in which direction paths continue, and the two pdfs give the MIS weights.
#[test]
fn each_strategy_finds_its_share_of_direct_light() {
    let (albedo, light) = (0.6, 5.0);
    let within = EmitterShape::Sphere(inward(Sphere::new(DVec3::ZERO, 2.0)));
    let ball = EmitterShape::Sphere(Sphere::new(DVec3::new(0.3, 0.2, 1.0), 0.6));
    let flat = EmitterShape::Rectangle {
        corner: DVec3::new(-1.0, -0.7, 0.8),
        edges: [2.0 * DVec3::Y, 2.0 * DVec3::X],
    };
    let strategies = [
        (PathStrategy::Bsdf, Heuristic::Balance, 1),
        (PathStrategy::Light, Heuristic::Balance, 1),
        (PathStrategy::Mis, Heuristic::Balance, 1),
        (PathStrategy::Mis, Heuristic::Power, 2),
    ];
    for (shape, lights) in [within, ball, flat]
        .into_iter()
        .flat_map(|s| LIGHTS.map(|lights| (s, lights)))
    {
        let scene = scene(|scene| {
            square(scene, 0.5, 0.0, true, diffuse(albedo));
            let lamp = scene.surface(lamp(light));
            match shape {
                EmitterShape::Rectangle { corner, edges } => scene.rectangle(corner, edges, lamp),
                EmitterShape::Sphere(sphere) => scene.sphere(sphere, lamp),
                EmitterShape::Triangle(_) => unreachable!("none"),
            }
        });
        let emitter = scene.emitters()[0];
        let ray = Ray::new(DVec3::new(0.2, 0.1, 0.3), -DVec3::Z);
        let floor = scene.intersect(&ray).expect("the floor");
        // The pdf, by solid angle, with which a shadow ray samples this point.
        let pdf = |point: DVec3, normal: DVec3| {
            let to = point - floor.point;
            let by_angle = (lights == LightSampling::SolidAngle)
                .then(|| emitter.pdf_solid_angle(floor.point))
                .flatten();
            by_angle.unwrap_or(to.length().powi(3) / (emitter.area * normal.dot(-to)))
        };
        for ((strategy, heuristic, power), i) in strategies
            .into_iter()
            .flat_map(|s| (0..100).map(move |i| (s, i)))
        {
            let path = Path {
                lights,
                heuristic,
                ..Path::new(strategy).with_parts(Parts::replaced(&Unweighted))
            };
            let mut rng = stream(master(), i, 0);
            let found = path.radiance(&scene, &ray, Some(floor), &mut rng.clone()).x;
            let share = |pdf: f64, other: f64| match strategy {
                PathStrategy::Mis => 1.0 / (1.0 + (other / pdf).powi(power)),
                _ => 1.0,
            };
            let mut expected = 0.0;
            if strategy != PathStrategy::Bsdf {
                let _ = uniform(&mut rng);
                let random = uniform2(&mut rng);
                let by_angle = emitter
                    .sample_solid_angle(floor.point, random)
                    .filter(|_| lights != LightSampling::Area);
                let point = by_angle.map_or_else(|| emitter.sample(random), |(point, _)| point);
                let to = point.point - floor.point;
                let cosine = to.normalize().z;
                if cosine > 0.0 && point.normal.dot(to) < 0.0 {
                    let pdf = pdf(point.point, point.normal);
                    expected +=
                        share(pdf, cosine * FRAC_1_PI) * albedo * FRAC_1_PI * light * cosine / pdf;
                }
            }
            let way = cosine_hemisphere::<f64>(uniform2(&mut rng));
            let lamp = scene
                .spawn_and_trace(&floor, Frame::new(DVec3::Z).world(way))
                .1
                .filter(|hit| hit.normal.z < 0.0);
            if strategy != PathStrategy::Light
                && uniform(&mut rng)
                    < by_throughput(DVec3::splat(albedo / REFERENCE_THROUGHPUT), false)
            {
                let found = |lamp: Hit| {
                    share(way.z * FRAC_1_PI, pdf(lamp.point, lamp.normal)) * albedo * light
                };
                expected += lamp.map_or(0.0, found);
            }
            assert_abs_diff_eq!(found, expected, epsilon = 1e-6);
        }
    }
}

/// A small floor in the middle of a sphere that emits, where a shadow ray contributes 4 L ρ cos θ:
/// for every set of quirks the stream determines the reconstruction's value.
#[test]
fn quirks_do_what_they_say() {
    let (albedo, light, survival) = (0.6, 5.0, 0.75);
    let lambert = Bsdf::Lambert {
        albedo: DVec3::splat(albedo),
    };
    let rough = Bsdf::oren_nayar(DVec3::splat(albedo), 0.4, OrenNayarForm::Corrected);
    for (bsdf, is_non_delta) in [(lambert, false), (rough, true)] {
        let scene = scene(|scene| {
            square(
                scene,
                0.5,
                0.0,
                true,
                Surface::new(bsdf).absorbing(1.0 - survival),
            );
            ball(scene, inward(Sphere::new(DVec3::ZERO, 2.0)), lamp(light));
        });
        let ray = Ray::new(DVec3::Z, -DVec3::Z);
        for (bits, i) in (0..8).flat_map(|bits| (0..50).map(move |i| (bits, i))) {
            let published = published(bits);
            let Quirks {
                roulette_by_cosine,
                end_loses_direct,
                extra_cosine,
            } = published.quirks;
            let mut rng = stream(master(), i, 0);
            let found = published
                .radiance(&scene, &ray, scene.intersect(&ray), &mut rng.clone())
                .x;
            let way: DVec3 = uniform_hemisphere(uniform2(&mut rng));
            let number = if roulette_by_cosine {
                way.z
            } else {
                uniform(&mut rng)
            };
            let ends = number >= survival;
            let extra = if is_non_delta && extra_cosine {
                way.z
            } else {
                1.0
            };
            let colour = |divided: bool| if divided { albedo / survival } else { albedo };
            let _ = uniform(&mut rng);
            let [height, _] = uniform2(&mut rng);
            let direct =
                extra * colour(end_loses_direct) * 4.0 * light * (2.0 * height - 1.0).max(0.0);
            // The lamp counts as 1, whatever it emits.
            let onward = extra * colour(roulette_by_cosine) * 2.0 * way.z / survival;
            let expected = match (ends, end_loses_direct) {
                (true, true) => 0.0,
                (true, false) => direct,
                (false, _) => direct + onward,
            };
            assert_abs_diff_eq!(found, expected, epsilon = 100.0 * EDGE_MARGIN);
        }
    }
}

/// Sample rays of the report's estimator from a floor under a uniform sky: each survivor
/// contributes 2 ρ cos θ/(N q).
#[test]
fn sample_rays_of_the_report_share_the_sky() {
    let (albedo, survival) = (0.6, 0.75);
    let scene = scene(|scene| {
        scene.background(DVec3::ONE);
        square(
            scene,
            0.5,
            0.0,
            true,
            diffuse(albedo).absorbing(1.0 - survival),
        );
    });
    let ray = Ray::new(DVec3::Z, -DVec3::Z);
    for (rays, i) in (0..4).flat_map(|rays| (0..50).map(move |i| (rays, i))) {
        let report = Report {
            rays,
            segments: 2,
            ..Report::default()
        };
        let mut rng = stream(master(), i, 0);
        let found = report
            .radiance(&scene, &ray, scene.intersect(&ray), &mut rng.clone())
            .x;
        let mut expected = 0.0;
        for _ in 0..rays {
            if uniform(&mut rng) < survival {
                let way: DVec3 = uniform_hemisphere(uniform2(&mut rng));
                expected += 2.0 * albedo * way.z / (f64::from(rays) * survival);
            }
        }
        assert_abs_diff_eq!(found, expected, epsilon = 1e-12);
    }
}

/// A white floor under a black light, with or without a sphere of index 1 between them, and a black
/// ceiling that ends all paths.
fn light_behind_nothing(sphere: bool) -> Scene {
    scene(|scene| {
        square(scene, 5.0, 0.0, true, diffuse(1.0).absorbing(0.25));
        square(scene, 5.0, 2.5, false, lamp(3.0));
        if sphere {
            ball(scene, Sphere::new(1.3 * DVec3::Z, 1.0), glass(1.0));
        }
    })
}

#[test]
fn the_report_counts_light_behind_index_matched_glass_once() {
    // One diffuse hit: a shadow ray and a sample ray, whose random numbers are drawn before those
    // of glass. Which of the two finds the light depends on the rules alone.
    let [open, glass] = [false, true].map(light_behind_nothing);
    let ray = Ray::new(
        DVec3::new(1.5, 0.2, 0.2),
        DVec3::new(-1.4, -0.1, -0.2).normalize(),
    );
    let report = |shadows_pass_glass, caustics| Report {
        rules: TransportRules {
            shadows_pass_glass,
            caustics,
            ..TransportRules::PHYSICAL
        },
        ..Report::default()
    };
    let mut rng = rng("behind nothing");
    let mut kinds = [0; 2];
    for _ in 0..2000 {
        let value = |scene: &Scene, report: Report| {
            report
                .radiance(scene, &ray, scene.intersect(&ray), &mut rng.clone())
                .x
        };
        let [passing, passing_caustics, blocked, caustics] =
            [(true, false), (true, true), (false, false), (false, true)]
                .map(|(passes, caustics)| value(&glass, report(passes, caustics)));
        let sampled = value(&open, report(false, true));
        // Shadow rays that pass through glass have seen the light: hits through it do not count
        // again.
        assert!((passing - sampled).abs() <= 64.0 * UNIT_ROUNDOFF * sampled);
        assert!((passing_caustics - sampled).abs() <= 64.0 * UNIT_ROUNDOFF * sampled);
        // Shadow rays that stop at glass have not: hits through it count, each 2 cos θ L / 0.75 of
        // a sample ray.
        let through = caustics - blocked;
        assert!(blocked <= passing && (0.0..=8.0).contains(&through));
        kinds[0] += usize::from(blocked < passing);
        kinds[1] += usize::from(through > 0.0);
        let _ = uniform2(&mut rng);
    }
    for count in kinds {
        assert_enough_compared("behind nothing", count);
    }
}
