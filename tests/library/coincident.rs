//! Tests of coincident surfaces: which are refused, and which of two permitted ones is visible.

mod fans;
mod permitted;
mod refused;

use glam::DQuat;
use whitefurnace::material::rough_glass::RoughGlass;
use whitefurnace::scene::file::Description;
use whitefurnace::scene::{COINCIDENCE_TOLERANCE, cuboid};

use crate::prelude::*;

/// A shape that can be added to a scene, rotated and scaled.
#[derive(Clone, Copy, Debug)]
enum Shape {
    /// A horizontal square around (x, y, z), by half its side and whether its front faces up.
    Square([f64; 3], f64, bool),
    /// A horizontal triangle, half of such a square.
    Triangle([f64; 3], f64, bool),
    /// A closed box, by two opposite corners and whether its fronts face inwards.
    Cuboid([f64; 3], [f64; 3], bool),
    /// A closed box of six rectangles, by two opposite corners.
    SixRectangles([f64; 3], [f64; 3]),
    /// A ball, by centre and radius.
    Ball([f64; 3], f64),
    /// The part of a ball between two heights.
    Zone([f64; 3], f64, [f64; 2]),
}
use Shape::{Ball, Cuboid, SixRectangles, Square, Triangle, Zone};

/// A rotation that changes every coordinate.
fn askew() -> DQuat {
    DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.7).normalize(), 0.83)
}

/// Builds a scene of shapes in order, seen from (0.3, −2.1, 0.4), rotated, then scaled; the largest
/// coordinate is about 3.
fn build_placed(shapes: &[(Shape, Surface)], turn: DQuat, scale: f64) -> Result<Scene, Error> {
    let mut s = SceneBuilder::new("things");
    let at = |p: [f64; 3]| turn * DVec3::from_array(p) * scale;
    for &(shape, surface) in shapes {
        let surface = s.surface(surface);
        let square = |[x, y, z]: [f64; 3], half: f64, up: bool| {
            let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
            let corners = corners.map(|[a, b]| at([x + half * a, y + half * b, z]));
            if up {
                corners
            } else {
                [corners[0], corners[3], corners[2], corners[1]]
            }
        };
        match shape {
            Square(centre, half, up) => {
                let [a, b, _, d] = square(centre, half, up);
                s.rectangle(a, [b - a, d - a], surface);
            }
            Triangle(centre, half, up) => s.mesh(&square(centre, half, up), &[[0, 1, 2]], surface),
            Cuboid(low, high, inward) => {
                let (corners, triangles) = cuboid(low.into(), high.into(), inward);
                s.mesh(
                    &corners.map(|corner| at(corner.into())),
                    &triangles,
                    surface,
                );
            }
            SixRectangles(low, high) => {
                let [x, y, z] = [0, 1, 2].map(|k| {
                    let mut edge = [0.0; 3];
                    edge[k] = high[k] - low[k];
                    at(edge)
                });
                for (corner, sides) in [
                    (low, [[y, x], [x, z], [z, y]]),
                    (high, [[-x, -y], [-z, -x], [-y, -z]]),
                ] {
                    sides
                        .into_iter()
                        .for_each(|edges| s.rectangle(at(corner), edges, surface));
                }
            }
            Ball(centre, radius) => s.sphere(Sphere::new(at(centre), radius * scale), surface),
            Zone(centre, radius, zone) => {
                let zone = zone.map(|z| z * scale);
                s.sphere(
                    between_heights(Sphere::new(at(centre), radius * scale), zone),
                    surface,
                );
            }
        }
    }
    s.build(Camera::new(
        at([0.3, -2.1, 0.4]),
        DVec3::ZERO,
        turn * DVec3::Z,
        0.5,
    ))
}

/// Returns whether shapes can be built, in either order, however they are rotated and scaled.
fn is_built(shapes: &[(Shape, Surface)]) -> bool {
    let reversed: Vec<_> = shapes.iter().rev().copied().collect();
    let mut found = Vec::new();
    for shapes in [shapes, &reversed] {
        for turn in [DQuat::IDENTITY, askew()] {
            // Zones cannot be rotated.
            if turn != DQuat::IDENTITY && shapes.iter().any(|(shape, _)| matches!(shape, Zone(..)))
            {
                continue;
            }
            found.extend([1.0, 1e-6, 1e6].map(|scale| build_placed(shapes, turn, scale).is_ok()));
        }
    }
    assert!(
        found.iter().all(|ok| *ok == found[0]),
        "{found:?} of {shapes:?}"
    );
    found[0]
}

fn clay() -> Surface {
    diffuse(0.5)
}

fn chalk() -> Surface {
    diffuse(0.8)
}

fn lamp() -> Surface {
    crate::helpers::lamp(10.0)
}

fn mirror() -> Surface {
    reflecting(1.0)
}

fn glass() -> Surface {
    crate::helpers::glass(1.5)
}

fn rough_glass() -> Surface {
    Surface::new(Bsdf::RoughGlass(RoughGlass {
        index: 1.5,
        alpha: 0.3,
    }))
}

/// A closed room around the camera.
const ROOM: Shape = Cuboid([-2.5, -2.5, -1.0], [2.5, 2.5, 1.0], true);
/// A point of its ceiling.
const CENTRE: [f64; 3] = [0.1, 0.2, 1.0];
/// A small square in the ceiling, its front up or down.
const PANEL_UP: Shape = Square(CENTRE, 0.3, true);
const PANEL_DOWN: Shape = Square(CENTRE, 0.3, false);
/// A large sheet, and a closed block that stands on it.
const SHEET: Shape = Square([0.0; 3], 2.0, true);
const BLOCK: Shape = Cuboid([-0.5, -0.5, 0.0], [0.5; 3], false);

/// Surfaces up to the tolerance apart coincide, whatever their kinds.
#[test]
fn a_pair_coincides_up_to_the_tolerance() {
    // The camera has the largest coordinate.
    let extent = 2.1;
    for (surface, other) in [
        (lamp(), clay()),
        (clay(), lamp()),
        (mirror(), mirror()),
        (glass(), clay()),
    ] {
        for (share, built) in [
            (0.0, false),
            (0.99, false),
            (-0.99, false),
            (1.01, true),
            (-1.01, true),
        ] {
            let apart = share * COINCIDENCE_TOLERANCE * extent;
            let sheets = [
                (Square([0.1, 0.2, 0.0], 0.3, true), surface),
                (Square([0.1, 0.2, apart], 0.3, true), other),
            ];
            let balls = [
                (Ball([0.1, 0.2, 0.0], 0.3), surface),
                (Ball([0.1, 0.2, 0.0], 0.3 + apart), other),
            ];
            for shapes in [sheets, balls] {
                let found = build_placed(&shapes, DQuat::IDENTITY, 1.0);
                assert_eq!(found.is_ok(), built, "{share} of {shapes:?}");
            }
        }
    }
}

/// A larger tolerance, as for single precision, finds surfaces that are farther apart.
#[test]
fn a_scene_tells_what_coincides_farther_apart() {
    let apart = [
        (Square([0.1, 0.2, 0.0], 0.3, true), clay()),
        (Square([0.1, 0.2, 1e-8], 0.3, false), lamp()),
    ];
    let scene = build_placed(&apart, askew(), 1.0).expect("a scene");
    assert_eq!(scene.coincident(0.9e-8), None);
    let found = scene.coincident(1.1e-8).expect("two sheets");
    assert_eq!(
        found.objects,
        ["object 1 (surface 0)", "object 2 (surface 1)"]
    );
    assert!(
        (found.at - askew() * DVec3::new(0.1, 0.2, 0.0)).length() < 0.5,
        "{found:?}"
    );
    let surfaces: Vec<_> = scene
        .primitives()
        .map(|(_, surface)| surface.emission)
        .collect();
    assert_eq!(
        found.primitives.map(|i| surfaces[i as usize].x),
        [0.0, 10.0]
    );
}

/// A floor is visible from below a block that stands on it, in either order of the two, also after
/// the camera has moved.
#[test]
fn a_sheet_is_seen_where_it_covers_a_block() {
    let floor = (SHEET, clay());
    for block in [BLOCK, Cuboid([-0.5, -0.5, 0.0], [0.5; 3], true)] {
        for shapes in [[floor, (block, chalk())], [(block, chalk()), floor]] {
            let scene = build_placed(&shapes, askew(), 1.0).expect("a scene");
            let camera = Camera::new(
                askew() * DVec3::new(0.0, 0.5, -1.0),
                DVec3::ZERO,
                DVec3::Z,
                0.5,
            );
            let below = build_placed(&shapes, askew(), 1.0)
                .expect("a scene")
                .with_camera(camera)
                .expect("a scene");
            for scene in [scene, below] {
                let mut rng = rng("coincident/covered");
                assert_eq!(scene.primitives().count(), 2 + 10);
                for _ in 0..1000 {
                    let target = DVec3::new(uniform(&mut rng) - 0.5, uniform(&mut rng) - 0.5, 0.0);
                    let origin = DVec3::new(uniform(&mut rng), uniform(&mut rng), -1.0);
                    let ray = Ray::new(askew() * origin, askew() * (target - origin).normalize());
                    let hit = scene.intersect(&ray).expect("the floor");
                    assert_eq!(scene.surface(&hit).bsdf, clay().bsdf);
                }
            }
        }
    }
}

/// A camera within a block sees coincident surfaces that one outside did not.
#[test]
fn another_camera_asks_again() {
    let tower = [
        (Cuboid([-0.5, -0.5, -1.0], [0.5, 0.5, -0.5], false), chalk()),
        (Cuboid([-0.3, -0.8, -0.5], [0.7, 0.2, 0.0], false), clay()),
    ];
    let scene = build_placed(&tower, askew(), 1.0).expect("a scene");
    let from = |z| {
        Camera::new(
            askew() * DVec3::new(0.1, 0.1, z),
            DVec3::ZERO,
            DVec3::Z,
            0.5,
        )
    };
    let inside = scene.with_camera(from(-0.25));
    assert!(inside.is_err());
    assert!(
        build_placed(&tower, askew(), 1.0)
            .expect("a scene")
            .with_camera(from(0.25))
            .is_ok()
    );
}

#[test]
fn the_message_names_both_objects_as_the_file_does() {
    let text = |z: &str| {
        format!(
            r#"
            camera = {{ eye = [0, -0.9, 0.5], target = [0, 1, 0.9], up = [0, 0, 1], fov_deg = 90 }}
            materials.wall = {{ model = "lambert", albedo = 0.5 }}
            materials.lamp = {{ model = "black", emission = 10 }}
            objects = [
              {{ shape = "box", material = "wall", corners = [[-1, -1, 0], [1, 1, 1]], inward = true }},
              {{ shape = "rectangle", material = "lamp", corner = [-0.3, -0.3, {z}], edges = [[0, 0.6, 0], [0.6, 0, 0]] }},
            ]"#
        )
    };
    let build = |z| {
        Description::parse("room", &text(z))
            .expect("a description")
            .build()
    };
    let message = refusal(build("1"), "coincident");
    let start = "scene room: object 1 (material wall) and object 2 (material lamp) lie in the same place near [";
    let end = "move one of them by 7e-12 or more, remove one, or cut a hole for the other";
    assert!(
        message.starts_with(start) && message.ends_with(end),
        "{message}"
    );
    // The suggested height is accepted.
    assert!(build("0.999999999993").is_ok());
}

/// Neighbouring triangles are not taken for coincident surfaces, and large meshes are not searched
/// pair by pair.
#[test]
fn meshes_of_many_triangles_are_built() {
    const N: u32 = 60;
    let vertex = |i: u32, j: u32| askew() * DVec3::new(f64::from(i) / 7.0, f64::from(j) / 7.0, 0.0);
    let mut s = SceneBuilder::new("mosaic");
    let colours = [mirror(), lamp(), glass(), clay()].map(|surface| s.surface(surface));
    for k in 0..N * N {
        let (i, j) = (k / N, k % N);
        let corners = [
            vertex(i, j),
            vertex(i + 1, j),
            vertex(i + 1, j + 1),
            vertex(i, j + 1),
        ];
        s.mesh(
            &corners,
            &[[0, 1, 2], [2, 3, 0]],
            colours[(k % 7 % 4) as usize],
        );
    }
    let scene = s.build(any_camera()).expect("a scene");
    assert_eq!(scene.coincident(1e-5), None);
}
