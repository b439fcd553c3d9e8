//! Corner cases that no built-in scene has: lights without a solid angle to sample, no light at
//! all, limits of zero, no photons or too many.

use whitefurnace::sampling::roulette::MAX_SURVIVAL;

use crate::prelude::*;
use crate::rng::Constant;

const ALBEDO: f64 = 0.6;
const LIGHT: f64 = 5.0;
const FRAME: [u32; 2] = [6, 5];

/// A white floor of half side `half` at the origin, seen from above, and the things that `add`
/// adds.
fn over_floor(half: f64, add: impl FnOnce(&mut SceneBuilder)) -> Scene {
    scene_from(
        Camera::new(DVec3::new(0.0, -0.1, 0.3), DVec3::ZERO, DVec3::Z, 0.1),
        |scene| {
            square(scene, half, 0.0, true, diffuse(ALBEDO));
            add(scene);
        },
    )
}

/// A small floor, and the lights that `add` puts above or around it.
fn lit(add: impl FnOnce(&mut SceneBuilder, SurfaceId)) -> Scene {
    over_floor(0.5, |scene| {
        let light = lamp(LIGHT);
        let light = scene.surface(light);
        add(scene, light);
    })
}

/// Estimates direct light at the origin with shadow rays alone, one estimate per stream.
fn shadow_rays(scene: &Scene, lights: LightSampling, count: u32) -> Vec<f64> {
    let path = Path {
        lights,
        ..Path::new(PathStrategy::Light)
    };
    let down = DVec3::new(0.1, 0.2, -1.0).normalize();
    let ray = Ray::new(-0.05 * down, down);
    let estimate = |i| {
        path.radiance(scene, &ray, scene.intersect(&ray), &mut stream(5, i, 0))
            .x
    };
    (0..count).map(estimate).collect()
}

/// Emitters that cannot be sampled by solid angle from some point are sampled uniformly by area
/// there: the same paths to the bit.
#[test]
fn without_solid_angles_lights_are_sampled_by_area() {
    let whole = Sphere::new(DVec3::new(0.1, 0.0, 0.2), 2.0);
    let zone = between_heights(Sphere::new(DVec3::new(0.2, 0.3, 1.0), 0.5), [-0.4, 0.3]);
    let ball = |sphere| lit(|scene, light| scene.sphere(sphere, light));
    let flat = |corner, edges| lit(|scene, light| scene.rectangle(corner, edges, light));
    let [x, y, z] = DVec3::AXES;
    let scenes = [
        ("inward", ball(inward(whole)), true),
        ("zone", ball(zone), true),
        (
            "skewed",
            flat(z - x - y, [2.0 * y, 2.0 * x + 0.5 * y]),
            true,
        ),
        ("too small", flat(z, [5e-4 * y, 5e-4 * x]), true),
        ("outward from within", ball(whole), false),
        ("behind", flat(z, [x, y]), false),
        ("in the plane", flat(x, [y, x]), false),
    ];
    for (name, scene, shines) in &scenes {
        let [area, angle] = [LightSampling::Area, LightSampling::SolidAngle]
            .map(|lights| shadow_rays(scene, lights, 200));
        assert_eq!(area, angle, "{name}");
        assert_eq!(area.iter().any(|v| *v > 0.0), *shines, "{name}");
        assert!(area.iter().all(|v| v.is_finite()), "{name}");
    }
}

#[test]
fn by_shape_spheres_are_sampled_by_solid_angle_and_flat_lights_by_area() {
    let by = |scene, lights| shadow_rays(scene, lights, 50);
    let ball = lit(|scene, light| scene.sphere(Sphere::new(DVec3::new(0.2, 0.3, 1.0), 0.5), light));
    let flat = lit(|scene, light| scene.rectangle(DVec3::Z, [DVec3::Y, DVec3::X], light));
    for (scene, same, other) in [
        (&ball, LightSampling::SolidAngle, LightSampling::Area),
        (&flat, LightSampling::Area, LightSampling::SolidAngle),
    ] {
        let found = by(scene, LightSampling::SphereAngle);
        assert_eq!(found, by(scene, same));
        assert_ne!(found, by(scene, other));
    }
}

fn radiance(scene: &Scene, estimator: &dyn Estimator) -> Vec<DVec3> {
    let look = |i: u32| {
        let ray = scene.camera().ray(FRAME, f64::from(i % FRAME[0]), 2.5);
        estimator.radiance(scene, &ray, scene.intersect(&ray), &mut stream(9, i, 0))
    };
    (0..60).map(look).collect()
}

/// Where nothing emits, every estimator finds no light; a background is seen only by those that
/// follow paths to it.
#[test]
fn without_emitters_it_is_dark() {
    let dark = over_floor(5.0, |_| {});
    let sky = over_floor(5.0, |scene| scene.background(DVec3::ONE));
    let photons = |scene: &Scene, lookup| {
        PhotonMapping::new(
            Parts::default(),
            scene,
            lookup,
            10,
            0.1,
            ImagePass::independent(1, 0),
        )
        .expect("a map")
    };
    let gather = final_gather(10, 0.1);
    let none = |found: Vec<DVec3>| assert!(found.iter().all(|v| *v == DVec3::ZERO), "{found:?}");
    for scene in [&dark, &sky] {
        none(radiance(
            scene,
            &photons(scene, Lookup::DirectVisualization),
        ));
        none(radiance(scene, &photons(scene, gather)));
        none(radiance(scene, &Whitted::new(TransportRules::PHYSICAL)));
        none(
            sppm(Parts::default(), 10, 0.1)
                .pass(scene, FRAME, 1, 0)
                .expect("legal values"),
        );
        none(
            LightTracer::default()
                .pass(scene, FRAME, 1, 0)
                .expect("legal values"),
        );
        assert_eq!(
            PhotonMap::new(
                Parts::default(),
                scene,
                PhotonMapKind::All,
                5,
                ImagePass::independent(1, 0)
            )
            .expect("a map")
            .photons()
            .count(),
            0
        );
    }
    let bdpt = Bdpt::new(Parts::default());
    let pass = |scene| bdpt.pass(scene, FRAME, 1, 0).expect("legal values");
    none(pass(&dark));
    none(radiance(&dark, &Path::default()));
    none(radiance(&dark, &Report::default()));
    none(radiance(&dark, &Published::default()));
    let resolution = resolution(3, 0);
    none(radiance(
        &dark,
        &Radiosity::new(Parts::default(), &dark, resolution, &|_| true).expect("a solution"),
    ));
    // A plane under a uniform sky reflects its albedo, and a survivor of roulette carries this
    // much.
    let path = (radiance(&sky, &Path::default()), ALBEDO / MAX_SURVIVAL);
    for (found, brought) in [(pass(&sky), 1.0), path] {
        assert!(found.iter().any(|v| v.x > 0.0));
        for v in found {
            assert_abs_diff_eq!(v.x * (v.x - brought), 0.0, epsilon = 1e-9);
        }
    }
}

/// With no sample rays, or with a first segment alone, the report's estimator and Whitted's tree
/// return direct light.
#[test]
fn limits_of_zero_mean_direct_light() {
    let scene = simple::cornell().expect("a scene");
    let report = |rays, segments| {
        radiance(
            &scene,
            &Report {
                parts: Parts::default(),
                rays,
                segments,
                rules: TransportRules::PHYSICAL,
            },
        )
    };
    let whitted = |segments| {
        let whole = Whitted::new(TransportRules::PHYSICAL);
        radiance(&scene, &Whitted { segments, ..whole })
    };
    let direct = whitted(7);
    assert!(direct.iter().any(|v| *v != DVec3::ZERO));
    for found in [
        report(0, 7),
        report(1, 1),
        report(1, 0),
        report(0, 0),
        whitted(1),
        whitted(0),
    ] {
        assert_eq!(found, direct);
    }
}

/// No photons, and radii in which none can lie, are refused instead of rendered black.
#[test]
fn photons_without_number_or_radius_are_refused() {
    let scene = simple::cornell().expect("a scene");
    let map = |lookup, particles, radius| {
        PhotonMapping::new(
            Parts::default(),
            &scene,
            lookup,
            particles,
            radius,
            ImagePass::independent(1, 0),
        )
    };
    assert_option_refused(map(Lookup::DirectVisualization, 0, 0.1), "at least 1");
    for radius in [0.0, -0.1, f64::NAN, f64::INFINITY] {
        assert_option_refused(
            map(Lookup::DirectVisualization, 10, radius),
            "radius above 0",
        );
        let gather = final_gather(10, radius);
        assert_option_refused(map(gather, 10, 0.1), "radius above 0");
        assert_option_refused(
            sppm(Parts::default(), 10, radius).pass(&scene, FRAME, 1, 0),
            "radius above 0",
        );
    }
    let gather = final_gather(0, 0.1);
    assert_option_refused(map(gather, 10, 0.1), "at least 1");
    let sppm = sppm(Parts::default(), 0, 0.1);
    assert_option_refused(sppm.pass(&scene, FRAME, 1, 0), "at least 1");
}

/// Tests a wall that absorbs everything: it shows its emission and what each quirk leaves of it,
/// and survival 0 never becomes 0/0. A shadow ray within a sphere finds albedo · L exactly.
#[test]
fn the_reconstruction_ends_at_walls_that_absorb_all() {
    let wall = diffuse(ALBEDO).emitting(DVec3::splat(LIGHT));
    let scene = within_sphere(wall.absorbing(1.0));
    let ray = Ray::new(0.3 * DVec3::X, DVec3::Y);
    for bits in 0..8 {
        let published = published(bits);
        let direct = if published.quirks.end_loses_direct {
            0.0
        } else {
            ALBEDO * LIGHT
        };
        let hit = scene.intersect(&ray);
        let mut found = vec![
            published
                .radiance(&scene, &ray, hit, &mut Constant::default())
                .x,
        ];
        let stream = |i| {
            published
                .radiance(&scene, &ray, hit, &mut stream(3, i, 0))
                .x
        };
        found.extend((0..20).map(stream));
        for radiance in found {
            assert_relative_eq!(radiance, 1.0 + direct, max_relative = 1e-12);
        }
    }
}
