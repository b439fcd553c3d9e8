//! Tests of scenes: their primitives and orientation, and what the builder refuses.

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

/// Asserts that a scene with these additions is refused, in one line that names the scene and
/// contains a hint.
fn assert_refused(hint: &str, add: impl FnOnce(&mut SceneBuilder, SurfaceId)) {
    let (mut scene, surface) = builder();
    add(&mut scene, surface);
    let message = scene
        .build(any_camera())
        .expect_err("must be refused")
        .to_string();
    assert!(
        message.starts_with("scene broken: ") && message.contains(hint),
        "{message}"
    );
    assert!(!message.contains('\n'), "{message}");
}

#[test]
fn bad_surfaces_are_refused() {
    let nan = f64::NAN;
    let valid = diffuse(0.5);
    let constants = OrenNayar { a: nan, b: 0.0 };
    let (albedo, form) = (DVec3::ONE, OrenNayarForm::Corrected);
    let mut bad = [1.0 + f64::EPSILON, -0.1, nan].map(diffuse).to_vec();
    bad.extend([0.0, -1.5, nan, f64::INFINITY].map(|index| Surface::new(Bsdf::Glass { index })));
    bad.extend(
        [0.0, 1.0, nan]
            .map(|index| Surface::new(Bsdf::RoughGlass(RoughGlass { index, alpha: 0.5 }))),
    );
    bad.extend(
        [-0.1, 1.01, nan, f64::INFINITY]
            .map(|roughness| Surface::new(Bsdf::Eon { albedo, roughness })),
    );
    bad.extend([
        Surface::new(Bsdf::Mirror {
            reflectance: DVec3::splat(1.1),
        }),
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
    let unit = Sphere::new(o, 1.0);
    assert_refused("sphere", |scene, surface| {
        scene.sphere(
            Sphere {
                radius: 1e-31,
                ..unit
            },
            surface,
        );
    });
    assert_refused("triangle", |scene, surface| {
        scene.rectangle(o, [1e-61 * x, DVec3::Y], surface);
    });
    assert_refused("triangle", |scene, surface| {
        scene.rectangle(o, [1e200 * x, 1e200 * DVec3::Y], surface);
    });
    assert_refused("reaches to 1e31", |scene, surface| {
        scene.sphere(
            Sphere {
                radius: 1e31,
                ..unit
            },
            surface,
        );
    });
    assert_refused("background", |scene, _| {
        scene.background(DVec3::splat(1e31));
    });
    assert_refused("triangle", |scene, surface| {
        scene.rectangle(o, [x, 2.0 * x], surface);
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
    for surface in [
        diffuse(0.0),
        diffuse(1.0),
        Surface::new(Bsdf::Glass { index: 0.5 }),
        eon[0],
        eon[1],
    ] {
        scene.surface(surface.absorbing(1.0));
    }
    for radius in [1e-30, 1e-12, 1e30] {
        scene.sphere(Sphere::new(DVec3::ZERO, radius), surface);
    }
    scene.sphere(
        Sphere {
            zone: [-0.5, 2.0],
            ..Sphere::new(DVec3::ZERO, 1.0)
        },
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
        let sphere = Sphere {
            zone,
            ..Sphere::new(DVec3::ZERO, 1.0)
        };
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
        let message = builder().0.build(camera).expect_err("refused").to_string();
        assert!(
            message.contains("camera") && !message.contains('\n'),
            "{message}"
        );
        let seen = simple::environment().expect("a scene").with_camera(camera);
        assert_eq!(
            seen.expect_err("refused").to_string(),
            message.replace("broken", "environment")
        );
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
    let message = under_a_sun(sun(1.496e11), eye)
        .expect_err("refused")
        .to_string();
    assert!(
        message.starts_with("scene sunny: something has a size of 1.0e0, too small")
            && !message.contains('\n')
    );
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
    let message = far
        .expect("a scene")
        .check_details()
        .expect_err("refused")
        .to_string();
    assert!(
        message.contains("let nothing, the camera too, be farther than 5.4e8"),
        "{message}"
    );
}
