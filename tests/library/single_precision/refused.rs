//! Tests of scenes that single precision refuses: where the error would be visible, and no others.

use super::*;

/// Returns a ball of radius 1 on a plane under a bright sky, seen from near; the plane extends to
/// `reach`.
fn ball_on_a_plane(reach: f64) -> Scene {
    scene_from(
        Camera::new(DVec3::new(0.0, -8.0, 1.5), 0.5 * DVec3::Z, DVec3::Z, 0.35),
        |scene| {
            scene.background(DVec3::ONE);
            let grey = scene.surface(diffuse(0.7));
            scene.rectangle(
                DVec3::new(-reach, -reach, 0.0),
                [2.0 * reach * DVec3::X, 2.0 * reach * DVec3::Y],
                grey,
            );
            ball(scene, Sphere::new(DVec3::Z, 1.0), diffuse(0.7));
        },
    )
}

/// Compares the part of the ball near the plane: where rays start behind the plane, its underside
/// shines. Accepted scenes are off by less than a thousandth in the mean, refused ones by more than
/// a hundredth.
#[test]
fn what_is_refused_is_wrong_and_what_is_taken_is_right() {
    for (reach, taken) in [(16.0, true), (1000.0, true), (4000.0, true), (1e6, false)] {
        let scene = ball_on_a_plane(reach);
        let estimator = LaneEstimator::Path(Path::new(PathStrategy::Bsdf));
        assert_eq!(check_single_precision(&scene).is_ok(), taken, "{reach}");
        let [double, single] = [Precision::Double, Precision::UncheckedSingle].map(|precision| {
            let lanes = lanes(estimator, plain(master()), precision);
            let film = filled(&lanes, &scene, [32, 24], 0..8);
            film.expect("legal values").mean()
        });
        let off = (single / double - 1.0).abs();
        println!("{reach}: {off:e}");
        assert!(
            if taken { off < 1e-3 } else { off > 1e-2 },
            "{reach}: {off:e}"
        );
    }
}

#[test]
fn what_single_precision_would_show_is_refused() {
    let path = |strategy| LaneEstimator::Path(Path::new(strategy));
    let of = |size: f64, detail: f64, surface| {
        scene(|scene| {
            ball(scene, Sphere::new(DVec3::ZERO, size), diffuse(0.5));
            ball(scene, Sphere::new(DVec3::ZERO, detail), surface);
        })
    };
    for size in [2e6, 1e-7, 1e12] {
        assert_option_refused(
            check_single_precision(&of(size, 0.5 * size, diffuse(0.5))),
            "the scene reaches to",
        );
    }
    let assert_too_small = |scene: &Scene| {
        let found = check_single_precision(scene);
        assert_option_refused(found, "too small for single precision");
    };
    for size in [1e-6, 1.0, 1e6] {
        assert_too_small(&of(size, size / 4097.0, diffuse(0.5)));
        check_single_precision(&of(size, size / 4095.0, diffuse(0.5))).expect("coarse enough");
    }
    // Objects far from the camera, and zones, are refused, too.
    let camera = Camera::new(5000.0 * DVec3::X, DVec3::ZERO, DVec3::Z, 0.1);
    let far = of(1.0, 0.5, diffuse(0.5)).with_camera(camera);
    assert_too_small(&far.expect("a camera"));
    let ring = between_heights(Sphere::new(DVec3::ZERO, 1.0), [0.0, 2e-4]);
    let ring = scene(|scene| ball(scene, ring, diffuse(0.5)));
    assert_too_small(&ring);
    // Connected triangles are one object, however fine; an object that is thin in two directions is
    // small.
    let of_mesh = |mesh: &Mesh, scale: DVec3| {
        scene(|scene| {
            let grey = scene.surface(diffuse(0.5));
            ball(scene, Sphere::new(DVec3::ZERO, 1.0), diffuse(0.5));
            scene.mesh(
                &mesh.clone().map(|v| v * scale).vertices,
                &mesh.triangles,
                grey,
            );
        })
    };
    for (scale, taken) in [
        (DVec3::ONE, true),
        (DVec3::new(1.0, 1.0, 1e-5), true),
        (DVec3::new(1e-5, 1.0, 1e-5), false),
        (DVec3::splat(1e-4), false),
    ] {
        let fine = of_mesh(&Mesh::globe(60, 60), scale);
        assert_eq!(check_single_precision(&fine).is_ok(), taken, "{scale}");
    }
    let sliver = scene(|scene| {
        let grey = scene.surface(diffuse(0.5));
        scene.mesh(
            &[DVec3::ZERO, DVec3::X, DVec3::new(0.5, 2e-4, 0.0)],
            &[[0, 1, 2]],
            grey,
        );
    });
    assert_too_small(&sliver);
    // Refused scenes are not rendered.
    let rendered = filled(
        &singles(path(PathStrategy::Bsdf), plain(1)),
        &sliver,
        [2, 2],
        0..1,
    );
    assert_option_refused(rendered, "too small for single precision");
    for built_in in [
        room::report(Convention::Physical, OrenNayarForm::Corrected),
        room::diffuse(),
        simple::environment(),
        simple::cornell(),
        simple::cavity_cap(0.75, Cap::Black),
        simple::glass_cube(false),
        simple::glass_cube(true),
        simple::furnace_box(0.75),
    ] {
        let built_in = built_in.expect("a scene");
        check_single_precision(&built_in).expect("accepted");
    }
}

/// Replaced parts are evaluated lane by lane in double precision; single precision, which has none,
/// refuses them instead of rendering with the default ones.
#[test]
fn replaced_parts_are_not_rendered_in_single_precision() {
    let scene = ball_on_a_plane(16.0);
    for precision in [Precision::Single, Precision::UncheckedSingle] {
        let path = Path::new(PathStrategy::Bsdf).with_parts(Parts::replaced(&ScalarParts));
        let lanes = lanes(LaneEstimator::Path(path), plain(master()), precision);
        assert_option_refused(
            lanes.prepare(&scene, [32, 24]).map(|_| ()),
            "replaced parts",
        );
    }
}
