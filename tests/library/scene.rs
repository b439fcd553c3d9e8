//! Scenes: what they contain, which way it faces, what the builder refuses.

use approx::{assert_abs_diff_eq, assert_relative_eq};
use glam::DVec3;
use std::f64::consts::PI;
use whitefurnace::bsdf::{Bsdf, OrenNayar, OrenNayarForm};
use whitefurnace::scene::room::{self, Convention};
use whitefurnace::scene::simple::{self, Cap};
use whitefurnace::scene::{EDGE_MARGIN, OFFSET, Scene, SceneBuilder, Surface, SurfaceId};
use whitefurnace::shape::{Ray, Sphere};

use crate::helpers::{U, any_camera, in_cube, unit_vector};
use crate::support::rng;

/// The floor of the room, as the report's scene was measured: counter-clockwise from above.
pub const OUTLINE: [[f64; 2]; 6] =
    [[-3.0, 0.0], [0.0, -6.0], [10.0, -6.0], [13.0, 0.0], [10.0, 6.0], [0.0, 6.0]];

fn report(convention: Convention) -> Scene {
    room::report(convention, OrenNayarForm::Corrected).expect("the room")
}

fn lambert(albedo: f64) -> Bsdf {
    Bsdf::Lambert { albedo: DVec3::splat(albedo) }
}

fn close(a: DVec3, b: DVec3) -> bool {
    (a - b).abs().max_element() <= 4.0 * U
}

#[test]
fn walls_have_their_colours() {
    let scene = report(Convention::Physical);
    // From a free point of the room, towards the middle of each surface.
    let eye = DVec3::new(6.5, 0.0, 1.0);
    for (target, colour) in [
        ((5.0, -6.0, 1.0), [1.0, 0.25, 0.25]),
        ((5.0, 6.0, 1.0), [0.0, 1.0, 1.0]),
        ((-1.5, -3.0, 1.0), [0.157, 0.208, 0.576]),
        ((-1.5, 3.0, 4.0), [1.0, 1.0, 0.0]),
        ((11.5, -3.0, 1.0), [0.0, 1.0, 0.5]),
        ((11.5, 3.0, 1.0), [1.0, 0.0, 1.0]),
        ((8.0, 0.5, -5.0), [1.0, 1.0, 1.0]),
        ((8.0, 0.5, 5.0), [1.0, 1.0, 1.0]),
    ] {
        let target = DVec3::from(target);
        let hit = scene.intersect(&Ray::new(eye, (target - eye).normalize())).expect("a wall");
        assert!((hit.point - target).length() <= 1e-14 * 16.0, "{target} is hidden");
        let surface = scene.surface(&hit);
        assert!(close(surface.bsdf.albedo(), DVec3::from_array(colour) * 0.75));
        assert!(matches!(surface.bsdf, Bsdf::Lambert { .. }));
        assert_eq!(surface.absorption, 0.25);
        assert_eq!(surface.emission, DVec3::ZERO);
    }
}

#[test]
fn the_light_is_one_rectangle() {
    let scene = report(Convention::Physical);
    let [light] = scene.emitters() else {
        panic!("{} emitters", scene.emitters().len());
    };
    assert_eq!(light.area, 4.0);
    assert_eq!(light.radiance, DVec3::splat(50.0));
    for random in [[0.0, 0.0], [1.0, 1.0], [0.25, 0.5]] {
        let sample = light.sample(random);
        let p = sample.point;
        assert!((3.0..=5.0).contains(&p.x) && (-1.0..=1.0).contains(&p.y));
        assert_eq!((p.z, sample.normal), (4.999, -DVec3::Z));
    }
    let up = Ray::new(DVec3::new(4.0, 0.5, 3.0), DVec3::Z);
    let hit = scene.intersect(&up).expect("the light");
    assert_eq!(hit.emitter, Some(0));
    assert_eq!(scene.surface(&hit).bsdf, Bsdf::Black);
    assert_eq!(scene.background(), DVec3::ZERO);
}

#[test]
fn objects_are_in_their_places() {
    for (convention, albedo, sigma) in [
        (Convention::Physical, 0.55, 0.3),
        (Convention::Report, 0.55, 0.3),
        (Convention::Published, 1.0, 0.0),
    ] {
        let scene = report(convention);
        // Each seen from a free point to its side.
        for (centre, radius, from, bsdf) in [
            (
                DVec3::new(2.5, 4.0, -2.0),
                2.0,
                DVec3::new(9.0, 1.0, 2.0),
                Bsdf::Mirror { reflectance: DVec3::ONE },
            ),
            (
                DVec3::new(3.25, -0.5, -3.0),
                2.0,
                DVec3::new(9.0, 0.0, 2.0),
                Bsdf::Glass { index: 1.5 },
            ),
            (
                DVec3::new(0.0, 1.5, 0.0),
                1.5,
                DVec3::new(6.0, 0.0, 4.0),
                Bsdf::oren_nayar(DVec3::splat(albedo), sigma, OrenNayarForm::Corrected),
            ),
        ] {
            let to = centre - from;
            let hit = scene.intersect(&Ray::new(from, to.normalize())).expect("a sphere");
            assert_eq!(scene.surface(&hit).bsdf, bsdf, "{convention:?}");
            assert_eq!(scene.surface(&hit).absorption, 0.0);
            assert_abs_diff_eq!(hit.t, to.length() - radius, epsilon = 64.0 * U * to.length());
            let surface_point = centre - radius * to.normalize();
            assert!((hit.point - surface_point).length() <= 64.0 * U * 12.0);
        }
    }
}

#[test]
fn the_tetrahedron_is_a_corner_cut_off() {
    let scene = report(Convention::Physical);
    let corner = DVec3::new(0.0, -6.0, -5.0);
    // The slanted face is the plane with x + y + z = 4 from the corner: its middle, seen squarely.
    let middle = corner + DVec3::splat(4.0 / 3.0);
    let normal = DVec3::ONE / 3f64.sqrt();
    let hit = scene.intersect(&Ray::new(middle + normal, -normal)).expect("the face");
    assert!(matches!(scene.surface(&hit).bsdf, Bsdf::Mirror { .. }));
    assert!((hit.point - middle).length() <= 64.0 * U * 8.0);
    assert!(close(hit.normal, normal));
    // Seen from inside, all four normals point away.
    let inside = corner + DVec3::splat(0.5);
    for outward in [normal, -DVec3::X, -DVec3::Y, -DVec3::Z] {
        let hit = scene.intersect(&Ray::new(inside, outward)).expect("a face");
        assert!(close(hit.normal, outward) || hit.normal == -outward, "{}", hit.normal);
    }
}

#[test]
fn diffuse_room_is_all_lambert() {
    let scene = room::diffuse().expect("the room");
    let mut rng = rng("diffuse room");
    for _ in 0..5000 {
        let ray = Ray::new(DVec3::new(12.5, 0.0, 0.0), unit_vector(&mut rng));
        let hit = scene.intersect(&ray).expect("closed");
        let bsdf = scene.surface(&hit).bsdf;
        assert!(hit.emitter.is_some() || matches!(bsdf, Bsdf::Lambert { .. }));
    }
    for (centre, albedo) in [
        ((2.5, 4.0, -2.0), 0.5),
        ((3.25, -0.5, -3.0), 0.5),
        ((0.0, 1.5, 0.0), 0.55),
        ((1.0, -5.0, -4.0), 0.5),
    ] {
        let from = DVec3::new(9.0, -0.5, 2.0);
        let ray = Ray::new(from, (DVec3::from(centre) - from).normalize());
        let hit = scene.intersect(&ray).expect("an object");
        assert_eq!(scene.surface(&hit).bsdf, lambert(albedo), "{centre:?}");
    }
}

/// Fires rays from a point of which every surface must show its front (or its back).
fn assert_facing(scene: &Scene, eye: DVec3, front: bool) {
    let mut rng = rng(scene.name());
    for _ in 0..2000 {
        let ray = Ray::new(eye, unit_vector(&mut rng));
        if let Some(hit) = scene.intersect(&ray) {
            let facing = hit.normal.dot(ray.direction) < 0.0;
            assert_eq!(facing, front, "{}: {hit:?}", scene.name());
        }
    }
}

#[test]
fn fronts_face_where_light_is() {
    assert_facing(&report(Convention::Physical), DVec3::new(12.5, 0.0, 0.0), true);
    assert_facing(&room::diffuse().expect("a scene"), DVec3::new(7.0, 0.0, 4.0), true);
    assert_facing(&simple::furnace_box(0.5).expect("a scene"), DVec3::splat(0.3), true);
    for cap in [Cap::Black, Cap::Reflecting] {
        let scene = simple::cavity_cap(0.5, cap).expect("a scene");
        assert_facing(&scene, DVec3::splat(0.3), true);
    }
    assert_facing(&simple::glass_cube(true).expect("a scene"), DVec3::ZERO, false);
    assert_facing(&simple::glass_cube(false).expect("a scene"), DVec3::splat(3.0), true);
    assert_facing(&simple::environment().expect("a scene"), DVec3::splat(3.0), true);
    // The Cornell box is open to the camera and convex but for its blocks, which face outward.
    assert_facing(&simple::cornell().expect("a scene"), DVec3::new(2.78, 4.5, 0.5), true);
}

#[test]
fn emitters_have_their_areas() {
    let area = |scene: &Scene| scene.emitters().iter().map(|e| e.area).sum::<f64>();
    let furnace = simple::furnace_box(0.75).expect("a scene");
    assert_relative_eq!(area(&furnace), 24.0, max_relative = 16.0 * U);
    let cavity = simple::cavity_cap(0.75, Cap::Black).expect("a scene");
    assert_relative_eq!(area(&cavity), simple::CAP_SHARE * 4.0 * PI, max_relative = 8.0 * U);
    let cornell = simple::cornell().expect("a scene");
    assert_relative_eq!(area(&cornell), 1.3 * 1.05, max_relative = 64.0 * U);
    assert_eq!(cornell.emitters()[0].radiance, DVec3::new(17.0, 12.0, 4.0));
    assert_eq!(simple::environment().expect("a scene").emitters().len(), 0);
    assert_eq!(simple::environment().expect("a scene").background(), DVec3::ONE);
    assert_eq!(simple::glass_cube(true).expect("a scene").background(), DVec3::ONE);
}

#[test]
fn furnaces_are_uniform() {
    let mut rng = rng("furnaces");
    let furnace = simple::furnace_box(0.75).expect("a scene");
    let cavity = simple::cavity_cap(0.75, Cap::Black).expect("a scene");
    for _ in 0..2000 {
        let direction = unit_vector(&mut rng);
        let hit = furnace.intersect(&Ray::new(DVec3::ZERO, direction)).expect("closed");
        let surface = furnace.surface(&hit);
        assert_eq!((surface.bsdf, surface.emission), (lambert(0.75), DVec3::ONE));
        assert!(hit.emitter.is_some());
        // The cap is all within 60° of the upper pole, whose cosine is 1/2.
        let hit = cavity.intersect(&Ray::new(DVec3::ZERO, direction)).expect("closed");
        if (direction.z - 0.5).abs() > 1e-9 {
            assert_eq!(hit.emitter.is_some(), direction.z > 0.5);
        }
    }
}

#[test]
fn hit_points_keep_off_edges() {
    let scene = simple::furnace_box(0.5).expect("a scene");
    let mut rng = rng("hit points");
    for i in 0..3000 {
        let eye = 0.9 * in_cube(&mut rng, 1.0);
        let corner = in_cube(&mut rng, 1.0).signum();
        let mut target = corner;
        if i % 3 > 0 {
            target[i % 3] = in_cube(&mut rng, 1.0).x;
        }
        let hit = scene.intersect(&Ray::new(eye, (target - eye).normalize())).expect("closed");
        // The face's own coordinate is met to rounding, the others stay inside: a margin of 2⁻³² of
        // each weight moves a face of width 2 by half of that at least.
        let axis = hit.normal.abs().max_position();
        assert_abs_diff_eq!(hit.point[axis].abs(), 1.0, epsilon = 8.0 * U);
        for other in [(axis + 1) % 3, (axis + 2) % 3] {
            assert!(hit.point[other].abs() <= 1.0 - EDGE_MARGIN, "{}", hit.point);
        }
        let moved = (hit.point - (eye + hit.t * (target - eye).normalize())).length();
        assert!(moved <= 8.0 * EDGE_MARGIN, "moved by {moved:e}");
    }
}

#[test]
fn rays_leave_on_the_side_they_go_to() {
    let scene = simple::furnace_box(0.5).expect("a scene");
    let point = DVec3::new(0.2, 0.3, -1.0);
    for (direction, sign) in [(DVec3::ONE, 1.0), (-DVec3::ONE, -1.0)] {
        let ray = scene.leave(point, DVec3::Z, direction);
        assert_eq!(ray.origin, point + sign * OFFSET * DVec3::Z);
        assert_eq!(ray.direction, direction);
    }
}

#[test]
fn visibility_is_symmetric_and_stops_at_surfaces() {
    let scene = report(Convention::Physical);
    let light = (DVec3::new(4.0, 0.5, 4.999), -DVec3::Z);
    let floor = |x: f64, y: f64| (DVec3::new(x, y, -5.0), DVec3::Z);
    for (point, free, through_glass) in [
        (floor(9.0, 0.0), true, true),
        // In the shadow of the mirror sphere; below the glass sphere.
        (floor(2.3, 4.9), false, false),
        (floor(3.2, -0.6), false, true),
        ((DVec3::new(5.0, -6.0, 0.0), DVec3::Y), true, true),
    ] {
        assert_eq!(scene.visible(point, light, false), free, "{point:?}");
        assert_eq!(scene.visible(light, point, false), free, "{point:?}");
        assert_eq!(scene.visible(point, light, true), through_glass, "{point:?}");
        assert_eq!(scene.visible(light, point, true), through_glass, "{point:?}");
    }
}

/// A builder with one valid surface.
fn builder() -> (SceneBuilder, SurfaceId) {
    let mut scene = SceneBuilder::new("broken");
    let surface = scene.surface(Surface::new(lambert(0.5)));
    (scene, surface)
}

/// The message with which the scene is refused: one line that names the scene.
fn refusal(scene: SceneBuilder) -> String {
    let message = scene.build(any_camera()).expect_err("must be refused").to_string();
    assert!(message.starts_with("scene broken: "), "{message}");
    assert!(!message.contains('\n'), "{message}");
    message
}

#[test]
fn bad_surfaces_are_refused() {
    let nan = f64::NAN;
    let valid = Surface::new(lambert(0.5));
    let mirror = |r: f64| Bsdf::Mirror { reflectance: DVec3::splat(r) };
    let constants = OrenNayar { a: nan, b: 0.0 };
    let albedo = DVec3::ONE;
    let form = OrenNayarForm::Corrected;
    for surface in [
        Surface::new(lambert(1.0 + f64::EPSILON)),
        Surface::new(lambert(-0.1)),
        Surface::new(lambert(nan)),
        Surface::new(mirror(1.1)),
        Surface::new(Bsdf::Glass { index: 0.0 }),
        Surface::new(Bsdf::Glass { index: -1.5 }),
        Surface::new(Bsdf::Glass { index: nan }),
        Surface::new(Bsdf::Glass { index: f64::INFINITY }),
        Surface::new(Bsdf::OrenNayar { albedo, constants, form }),
        Surface::new(Bsdf::oren_nayar(2.0 * albedo, 0.3, form)),
        valid.emitting(DVec3::new(1.0, -1.0, 1.0)),
        valid.emitting(DVec3::splat(nan)),
        valid.emitting(DVec3::splat(f64::INFINITY)),
        valid.absorbing(1.1),
        valid.absorbing(-0.1),
        valid.absorbing(nan),
    ] {
        let (mut scene, _) = builder();
        scene.surface(surface);
        let message = refusal(scene);
        assert!(message.contains("surface 1"), "{message}");
    }
    for background in [DVec3::splat(nan), DVec3::new(0.0, -1.0, 0.0), DVec3::INFINITY] {
        let (mut scene, _) = builder();
        scene.background(background);
        assert!(refusal(scene).contains("background"));
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
        let (mut scene, surface) = builder();
        scene.mesh(&vertices, &[[0, 1, 2], triangle], surface);
        assert!(refusal(scene).contains("triangle"));
    }
    for (centre, radius) in [(o, 0.0), (o, -1.0), (o, f64::NAN), (o, f64::INFINITY), (nan, 1.0)] {
        let (mut scene, surface) = builder();
        scene.sphere(Sphere::new(centre, radius), surface);
        assert!(refusal(scene).contains("sphere"));
    }
    let (mut scene, surface) = builder();
    scene.rectangle(o, [x, 2.0 * x], surface);
    refusal(scene);
}

#[test]
fn valid_borders_are_accepted() {
    let (mut scene, surface) = builder();
    for bsdf in [lambert(0.0), lambert(1.0), Bsdf::Glass { index: 0.5 }] {
        scene.surface(Surface::new(bsdf).absorbing(1.0));
    }
    scene.sphere(Sphere::new(DVec3::ZERO, 1e-12), surface);
    assert!(scene.build(any_camera()).is_ok());
    let (empty, _) = builder();
    let empty = empty.build(any_camera()).expect("nothing is wrong with nothing");
    assert_eq!(empty.name(), "broken");
    assert!(empty.intersect(&Ray::new(DVec3::ZERO, DVec3::X)).is_none());
    for albedo in [-0.1, 1.1, f64::NAN] {
        assert!(simple::furnace_box(albedo).is_err());
        assert!(simple::cavity_cap(albedo, Cap::Black).is_err());
    }
}

#[test]
fn meshes_keep_their_own_vertices() {
    // Indices count within each mesh, wherever it comes in the scene.
    let (mut scene, surface) = builder();
    for z in [1.0, 2.0] {
        let vertices = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|v| v + z * DVec3::Z);
        scene.mesh(&vertices, &[[0, 1, 2]], surface);
    }
    let scene = scene.build(any_camera()).expect("valid");
    for (z, direction) in [(0.0, DVec3::Z), (3.0, -DVec3::Z)] {
        let ray = Ray::new(DVec3::new(0.25, 0.25, z), direction);
        let hit = scene.intersect(&ray).expect("a triangle");
        assert_abs_diff_eq!(hit.t, 1.0, epsilon = 8.0 * U);
        assert_eq!(hit.normal, DVec3::Z);
    }
}
