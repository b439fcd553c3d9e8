//! Tests of scenes: their primitives and orientation, and what the builder refuses.

mod refusals;

use glam::DQuat;
use whitefurnace::geometry::offsets::OFFSET;
use whitefurnace::material::rough_glass::RoughGlass;

use crate::prelude::*;

/// Floor of the report's room, counter-clockwise from above, as measured in the report.
pub const OUTLINE: [[f64; 2]; 6] = [
    [-3.0, 0.0],
    [0.0, -6.0],
    [10.0, -6.0],
    [13.0, 0.0],
    [10.0, 6.0],
    [0.0, 6.0],
];

fn report(convention: Convention) -> Scene {
    room::report(convention, OrenNayarForm::Corrected).expect("the room")
}

/// Returns whether an emitter is a whole primitive, or a rectangle of which the primitive is one
/// half.
fn is_emitter_of(geometry: Geometry, emitter: &Emitter) -> bool {
    match (geometry, emitter.shape) {
        (Geometry::Triangle(corners), EmitterShape::Triangle(other)) => corners == other,
        (
            Geometry::Triangle(corners),
            EmitterShape::Rectangle {
                corner,
                edges: [a, b],
            },
        ) => {
            let rectangle = [corner, corner + a, corner + a + b, corner + b];
            corners.iter().all(|v| rectangle.contains(v))
        }
        (Geometry::Sphere(sphere), EmitterShape::Sphere(other)) => sphere == other,
        _ => false,
    }
}

/// Rays from either side hit each primitive of every built-in scene where it is, with its own
/// front, surface and emitter. (Their values are tested in `scene_tables`.) Two sides of the room's
/// tetrahedron lie in walls.
#[test]
fn rays_meet_what_they_are_aimed_at() {
    let scenes = [
        report_room(),
        report(Convention::Published),
        room::diffuse().expect("the room"),
        simple::environment().expect("a scene"),
        furnace(0.75),
        simple::cavity_cap(0.75, Cap::Black).expect("a scene"),
        simple::glass_cube(true).expect("a scene"),
        simple::cornell().expect("a scene"),
    ];
    for scene in scenes {
        let mut hidden = 0;
        for (i, (geometry, surface)) in (0..).zip(scene.primitives()) {
            let (target, normal) = match geometry {
                Geometry::Triangle([a, b, c]) => (
                    0.2 * a + 0.3 * b + 0.5 * c,
                    (b - a).cross(c - a).normalize(),
                ),
                Geometry::Sphere(sphere) => {
                    let z = if sphere.heights()[1] > 0.64 * sphere.radius {
                        0.64
                    } else {
                        -0.64
                    };
                    let outward = DVec3::new(0.48, 0.6, z);
                    let normal = if sphere.inward { -outward } else { outward };
                    (sphere.centre + sphere.radius * outward, normal)
                }
            };
            for side in [1.0, -1.0] {
                let ray = Ray::new(target + side * 1e-4 * normal, -side * normal);
                let hit = scene.intersect(&ray).expect("a primitive");
                assert!(
                    (hit.point - target).length() < 1e-8,
                    "{}: {hit:?}",
                    scene.name()
                );
                assert_abs_diff_eq!(hit.t, 1e-4, epsilon = 256.0 * UNIT_ROUNDOFF);
                if hit.primitive != i {
                    hidden += 1;
                    continue;
                }
                assert!(
                    (hit.normal - normal).length() <= 64.0 * UNIT_ROUNDOFF,
                    "{}: {hit:?}",
                    scene.name()
                );
                assert_eq!(scene.surface(&hit), surface);
                let emitter = hit
                    .emitter
                    .map(|emitter| scene.emitters()[emitter as usize]);
                assert_eq!(emitter.is_some(), surface.emission != DVec3::ZERO);
                assert!(emitter.is_none_or(|emitter| {
                    is_emitter_of(geometry, &emitter) && emitter.radiance == surface.emission
                }));
            }
        }
        let coincident = if matches!(scene.name(), "report" | "diffuse-room") {
            4
        } else {
            0
        };
        assert!(hidden <= coincident, "{}: {hidden} hidden", scene.name());
    }
}

#[test]
fn hit_points_keep_off_edges() {
    let scene = furnace(0.5);
    let mut rng = rng("hit points");
    for i in 0..3000 {
        let eye = 0.9 * in_cube(&mut rng, 1.0);
        let corner = in_cube(&mut rng, 1.0).signum();
        let mut target = corner;
        if i % 3 > 0 {
            target[i % 3] = in_cube(&mut rng, 1.0).x;
        }
        let hit = scene
            .intersect(&Ray::new(eye, (target - eye).normalize()))
            .expect("closed");
        // The face's own coordinate is exact up to rounding; the others stay inside: a margin of
        // 2⁻³² of each weight moves a face of width 2 by at least half of that.
        let axis = hit.normal.abs().max_position();
        assert_abs_diff_eq!(hit.point[axis].abs(), 1.0, epsilon = 8.0 * UNIT_ROUNDOFF);
        for other in [(axis + 1) % 3, (axis + 2) % 3] {
            assert!(hit.point[other].abs() <= 1.0 - EDGE_MARGIN, "{}", hit.point);
        }
        let moved = (hit.point - (eye + hit.t * (target - eye).normalize())).length();
        assert!(moved <= 8.0 * EDGE_MARGIN, "moved by {moved:e}");
    }
}

#[test]
fn rays_leave_on_the_side_they_go_to() {
    let scene = furnace(0.5);
    let point = DVec3::new(0.2, 0.3, -1.0);
    for (direction, sign) in [(DVec3::ONE, 1.0), (-DVec3::ONE, -1.0)] {
        let ray = scene.spawn_ray(point, DVec3::Z, direction);
        assert_eq!(ray.origin, point + sign * OFFSET * DVec3::Z);
        assert_eq!(ray.direction, direction);
    }
}

#[test]
fn visibility_is_symmetric_and_stops_at_surfaces() {
    let scene = report_room();
    let light = SurfacePoint::new(DVec3::new(4.0, 0.5, 4.999), -DVec3::Z);
    let floor = |x: f64, y: f64| SurfacePoint::new(DVec3::new(x, y, -5.0), DVec3::Z);
    for (point, free, through_glass) in [
        (floor(9.0, 0.0), true, true),
        // In the shadow of the mirror sphere; below the glass sphere.
        (floor(2.3, 4.9), false, false),
        (floor(3.2, -0.6), false, true),
        (
            SurfacePoint::new(DVec3::new(5.0, -6.0, 0.0), DVec3::Y),
            true,
            true,
        ),
    ] {
        for (glass, seen) in [(false, free), (true, through_glass)] {
            let found = [
                scene.visible(point, light, glass),
                scene.visible(light, point, glass),
            ];
            assert_eq!(found, [seen; 2], "{point:?}");
        }
    }
}

/// Returns a builder with one valid surface.
fn builder() -> (SceneBuilder, SurfaceId) {
    let mut scene = SceneBuilder::new("broken");
    let surface = scene.surface(diffuse(0.5));
    (scene, surface)
}

#[test]
fn meshes_keep_their_own_vertices() {
    // Indices count within each mesh, wherever it is in the scene.
    let (mut scene, surface) = builder();
    for z in [1.0, 2.0] {
        let vertices = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|v| v + z * DVec3::Z);
        scene.mesh(&vertices, &[[0, 1, 2]], surface);
    }
    let scene = scene.build(any_camera()).expect("valid");
    for (z, direction) in [(0.0, DVec3::Z), (3.0, -DVec3::Z)] {
        let hit = scene
            .intersect(&Ray::new(DVec3::new(0.25, 0.25, z), direction))
            .expect("a triangle");
        assert_abs_diff_eq!(hit.t, 1.0, epsilon = 8.0 * UNIT_ROUNDOFF);
        assert_eq!(hit.normal, DVec3::Z);
    }
}

/// The camera counts for the offset of rays from surfaces, whether it is set first or later.
#[test]
fn a_later_camera_is_like_the_first() {
    let build = |camera| {
        scene_from(camera, |scene| {
            ball(
                scene,
                Sphere::new(DVec3::ZERO, 1.0),
                Surface::new(Bsdf::Black),
            );
        })
    };
    let far = Camera::new(1e6 * DVec3::X, DVec3::ZERO, DVec3::Z, 1.0);
    let left = |scene: Scene| scene.spawn_ray(DVec3::ZERO, DVec3::Z, DVec3::Z).origin.z;
    let later = build(any_camera()).with_camera(far).expect("a scene");
    let (later, first) = (left(later), left(build(far)));
    assert_eq!(later, first);
    assert!(first > 1e5 * left(build(any_camera())));
}

/// The extent of a sphere counts for the offset of rays from surfaces.
#[test]
fn rays_leave_spheres_by_their_extent() {
    let left = |x: f64| {
        let sphere = Sphere::new(x * DVec3::X, 50.0);
        scene(|scene| ball(scene, sphere, diffuse(0.5)))
            .spawn_ray(DVec3::ZERO, DVec3::Z, DVec3::Z)
            .origin
            .z
    };
    assert_relative_eq!(
        left(300.0) / left(-100.0),
        350.0 / 150.0,
        max_relative = 4.0 * UNIT_ROUNDOFF
    );
}

/// Shadow rays between points within the hull of a scene skip its walls; the result is that of
/// testing all primitives, from any point.
#[test]
fn walls_change_no_shadow() {
    let mut rng = rng("walls");
    let mut found = [[0; 2]; 2];
    for case in 0..200 {
        let (axis, angle, shift) = (
            unit_vector(&mut rng),
            between(&mut rng, 0.0, TAU),
            in_cube(&mut rng, 5.0),
        );
        let place = |v: DVec3| DQuat::from_axis_angle(axis, angle) * v + shift;
        let room = Mesh::cube().map(place);
        let scene = scene(|s| {
            let (white, clear) = (s.surface(diffuse(0.5)), s.surface(glass(1.5)));
            // Closed, open on one side, or with a hole.
            let walls = if case % 3 == 1 {
                &room.triangles[2..]
            } else {
                &room.triangles
            };
            s.mesh(&room.vertices, walls, white);
            let reach = if case % 3 == 2 { 3.0 } else { 0.9 };
            let corners = [(); 3].map(|()| place(in_cube(&mut rng, reach)));
            s.mesh(&corners, &[[0, 1, 2]], clear);
            s.sphere(Sphere::new(place(in_cube(&mut rng, 0.5)), 0.3), white);
            if case % 2 == 1 {
                // So many triangles that the scene is not small.
                let at = in_cube(&mut rng, 0.7);
                let globe = Mesh::globe(6, 8).map(|v| place(at + 0.2 * v));
                s.mesh(&globe.vertices, &globe.triangles, white);
            }
        });
        let clear: Vec<bool> = scene
            .primitives()
            .map(|(_, s)| matches!(s.bsdf, Bsdf::Glass { .. }))
            .collect();
        let end = |rng: &mut _| {
            let (origin, direction) = (place(in_cube(rng, 1.5)), unit_vector(rng));
            let hit = scene
                .intersect(&Ray::new(origin, direction))
                .filter(|_| uniform(rng) < 0.8);
            hit.map_or(SurfacePoint::new(origin, direction), |hit| {
                SurfacePoint::new(hit.point, hit.normal)
            })
        };
        for _ in 0..200 {
            let (x, y) = (end(&mut rng), end(&mut rng));
            let start = scene.spawn_ray(x.point, x.normal, y.point - x.point).origin;
            let segment = Ray::new(
                start,
                scene.spawn_ray(y.point, y.normal, x.point - y.point).origin - start,
            );
            for glass in [false, true] {
                let blocks = |id: u32| !(glass && clear[id as usize]);
                let free = !scene.bvh().occluded(&segment, 1.0, blocks);
                assert_eq!(
                    scene.visible(x, y, glass),
                    free,
                    "case {case}: {x:?} to {y:?}"
                );
                found[usize::from(glass)][usize::from(free)] += 1;
            }
        }
    }
    assert!(
        found.as_flattened().iter().all(|&count| count > 1000),
        "{found:?}"
    );
}
