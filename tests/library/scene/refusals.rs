//! Tests of what the builder of scenes refuses, and of the borders that it accepts.

use super::*;

/// Asserts that a scene with these additions is refused, in one line that names the scene and
/// contains a hint.
fn assert_refused(hint: &str, add: impl FnOnce(&mut SceneBuilder, SurfaceId)) {
    let (mut scene, surface) = builder();
    add(&mut scene, surface);
    let message = refusal(scene.build(any_camera()), hint);
    assert!(
        message.starts_with("scene broken: ") && message.contains(hint),
        "{message}"
    );
}

#[test]
fn bad_surfaces_are_refused() {
    let nan = f64::NAN;
    let valid = diffuse(0.5);
    let constants = OrenNayar { a: nan, b: 0.0 };
    let (albedo, form) = (DVec3::ONE, OrenNayarForm::Corrected);
    let mut bad = [1.0 + f64::EPSILON, -0.1, nan].map(diffuse).to_vec();
    bad.extend([0.0, -1.5, nan, f64::INFINITY].map(glass));
    bad.extend(
        [0.0, 1.0, nan]
            .map(|index| Surface::new(Bsdf::RoughGlass(RoughGlass { index, alpha: 0.5 }))),
    );
    bad.extend(
        [-0.1, 1.01, nan, f64::INFINITY]
            .map(|roughness| Surface::new(Bsdf::Eon { albedo, roughness })),
    );
    bad.extend([
        reflecting(1.1),
        Surface::new(Bsdf::OrenNayar {
            albedo,
            constants,
            form,
        }),
        Surface::new(Bsdf::oren_nayar(2.0 * albedo, 0.3, form)),
    ]);
    bad.extend(
        [
            DVec3::new(1.0, -1.0, 1.0),
            DVec3::NAN,
            DVec3::INFINITY,
            DVec3::splat(1e31),
        ]
        .map(|light| valid.emitting(light)),
    );
    bad.extend([1.1, -0.1, nan].map(|share| valid.absorbing(share)));
    for surface in bad {
        assert_refused("surface 1", |scene, _| {
            scene.surface(surface);
        });
    }
    for background in [DVec3::NAN, DVec3::new(0.0, -1.0, 0.0), DVec3::INFINITY] {
        assert_refused("background", |scene, _| scene.background(background));
    }
}

#[test]
fn bad_shapes_are_refused() {
    let [o, x, y] = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let nan = DVec3::new(0.0, f64::NAN, 0.0);
    for (vertices, triangle) in [
        ([o, x, 2.0 * x], [0, 1, 2]),
        ([o, o, x], [0, 1, 2]),
        ([o, x, y], [0, 1, 1]),
        ([o, x, nan], [0, 1, 2]),
        ([o, x, y * f64::INFINITY], [0, 1, 2]),
        ([o, x, y], [0, 1, 3]),
        ([o, x, y], [0, 1, u32::MAX]),
    ] {
        let triangles = [[0, 1, 2], triangle];
        assert_refused("triangle", |scene, surface| {
            scene.mesh(&vertices, &triangles, surface);
        });
    }
    for (centre, radius) in [
        (o, 0.0),
        (o, -1.0),
        (o, f64::NAN),
        (o, f64::INFINITY),
        (nan, 1.0),
    ] {
        let sphere = Sphere::new(centre, radius);
        assert_refused("sphere", |scene, surface| scene.sphere(sphere, surface));
        assert_refused("sphere", |scene, _| ball(scene, sphere, lamp(1.0)));
    }
    // Beyond the limits of any scene; messages stay short.
    for (radius, hint) in [(1e-31, "sphere"), (1e31, "reaches to 1e31")] {
        let sphere = Sphere::new(o, radius);
        assert_refused(hint, |scene, surface| scene.sphere(sphere, surface));
    }
    for edges in [[1e-61 * x, y], [1e200 * x, 1e200 * y], [x, 2.0 * x]] {
        assert_refused("triangle", |scene, surface| {
            scene.rectangle(o, edges, surface);
        });
    }
    assert_refused("background", |scene, _| {
        scene.background(DVec3::splat(1e31));
    });
}

#[test]
fn valid_borders_are_accepted() {
    let (mut scene, surface) = builder();
    let eon = [0.0, 1.0].map(|roughness| {
        Surface::new(Bsdf::Eon {
            albedo: DVec3::ONE,
            roughness,
        })
    });
    for surface in [diffuse(0.0), diffuse(1.0), glass(0.5), eon[0], eon[1]] {
        scene.surface(surface.absorbing(1.0));
    }
    for radius in [1e-30, 1e-12, 1e30] {
        scene.sphere(Sphere::new(DVec3::ZERO, radius), surface);
    }
    scene.sphere(
        between_heights(Sphere::new(DVec3::ZERO, 1.0), [-0.5, 2.0]),
        surface,
    );
    assert!(scene.build(any_camera()).is_ok());
    let (empty, _) = builder();
    let empty = empty.build(any_camera()).expect("an empty scene is valid");
    assert_eq!(empty.name(), "broken");
    assert!(empty.intersect(&Ray::new(DVec3::ZERO, DVec3::X)).is_none());
    for albedo in [-0.1, 1.1, f64::NAN] {
        assert!(simple::furnace_box(albedo).is_err());
        assert!(simple::cavity_cap(albedo, Cap::Black).is_err());
    }
}

/// Zones without area, and cameras without a direction, are refused, at once or when set later.
#[test]
fn empty_zones_and_cameras_that_look_nowhere_are_refused() {
    for zone in [
        [0.5, 0.5],
        [0.5, -0.5],
        [1.0, 2.0],
        [f64::NAN, 1.0],
        [-1.0, f64::NAN],
    ] {
        let sphere = between_heights(Sphere::new(DVec3::ZERO, 1.0), zone);
        assert_refused("zone", |scene, surface| scene.sphere(sphere, surface));
    }
    let ([o, x, z], nan) = ([DVec3::ZERO, DVec3::X, DVec3::Z], DVec3::NAN);
    let nowhere = [
        (o, o, z, 1.0),
        (o, z, z, 1.0),
        (o, x, o, 1.0),
        (nan, x, z, 1.0),
        (1e31 * x, o, z, 1.0),
    ]
    .into_iter();
    for (eye, target, up, half) in
        nowhere.chain([0.0, -1.0, 1.1e5, f64::NAN].map(|half| (o, x, z, half)))
    {
        let camera = Camera::new(eye, target, up, half);
        let message = refusal(builder().0.build(camera), "a camera");
        assert!(message.contains("camera"), "{message}");
        let seen = simple::environment().expect("a scene").with_camera(camera);
        assert_eq!(
            refusal(seen, "a camera"),
            message.replace("broken", "environment")
        );
    }
}

/// A ball of radius 1 on a plane, and the sun.
fn under_a_sun(sun: Sphere, eye: DVec3) -> Result<Scene, Error> {
    let mut scene = SceneBuilder::new("sunny");
    let (grey, light) = (scene.surface(diffuse(0.5)), scene.surface(lamp(1e4)));
    scene.rectangle(
        DVec3::new(-50.0, -50.0, 0.0),
        [100.0 * DVec3::X, 100.0 * DVec3::Y],
        grey,
    );
    scene.sphere(Sphere::new(DVec3::Z, 1.0), grey);
    scene.sphere(sun, light);
    let scene = scene.build(Camera::new(eye, DVec3::ZERO, DVec3::Z, 0.5))?;
    scene.check_details().map(|()| scene)
}

/// Under a sun of true size and distance, rays would start 0.14 above the ball. The sun that the
/// message suggests is accepted, and has the same angular size.
#[test]
fn what_is_too_small_for_double_precision_is_refused_with_a_remedy() {
    let (towards, eye) = (
        DVec3::new(0.5, 0.0, 0.75_f64.sqrt()),
        DVec3::new(0.0, -6.0, 4.0),
    );
    let sun = |distance: f64| Sphere::new(eye + distance * towards, 6.96e8 * distance / 1.496e11);
    let message = refusal(under_a_sun(sun(1.496e11), eye), "the sun");
    assert!(message.starts_with("scene sunny: something has a size of 1.0e0, too small"));
    let numbers: Vec<f64> = message
        .split_once("centre [")
        .expect("a centre")
        .1
        .split(|c: char| !"+-.e0123456789".contains(c))
        .filter_map(|word| word.parse().ok())
        .collect();
    let [x, y, z, radius, ..] = numbers[..] else {
        panic!("{message}")
    };
    let nearer = Sphere::new(DVec3::new(x, y, z), radius);
    assert_relative_eq!(
        radius / (nearer.centre - eye).length(),
        6.96e8 / 1.496e11,
        max_relative = 1e-12
    );
    assert_relative_eq!(
        (nearer.centre - eye).normalize().dot(towards),
        1.0,
        max_relative = 1e-12
    );
    assert!(nearer.centre.length() > 1e8);
    let fine = under_a_sun(nearer, eye).expect("accepted");
    // The camera counts, too; then a nearer sun does not help.
    let far = fine.with_camera(Camera::new(1e12 * DVec3::X, DVec3::ZERO, DVec3::Z, 0.5));
    let message = refusal(far.expect("a scene").check_details(), "a far camera");
    assert!(
        message.contains("let nothing, the camera too, be farther than 5.4e8"),
        "{message}"
    );
}
