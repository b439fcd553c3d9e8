//! Tests of many thin triangles, whose bounding boxes overlap pair by pair: fans, rings and slats.

use super::*;

/// Triangles by the corners of each.
type Triangles = Vec<[DVec3; 3]>;

/// Returns the point of a cone of this height over a unit disc, at some turn and distance from the
/// axis.
fn on_cone(height: f64, turn: f64, radius: f64) -> DVec3 {
    let (sin, cos) = (TAU * turn).sin_cos();
    askew() * DVec3::new(radius * cos, radius * sin, height * (1.0 - radius))
}

/// Returns the sectors of a disc, or of a cone.
fn fan(count: usize, height: f64) -> Triangles {
    let corner = |i: usize, radius| on_cone(height, (i % count) as f64 / count as f64, radius);
    (0..count)
        .map(|i| [corner(0, 0.0), corner(i, 1.0), corner(i + 1, 1.0)])
        .collect()
}

/// Returns the sectors of a disc with a hole, two triangles each.
fn ring(count: usize) -> Triangles {
    let corner = |i: usize, radius| on_cone(0.0, (i % count) as f64 / count as f64, radius);
    let both = |i: usize| {
        let [a, b, c, d] = [(i, 0.01), (i, 1.0), (i + 1, 1.0), (i + 1, 0.01)];
        [[a, b, c], [c, d, a]].map(|of| of.map(|(i, radius)| corner(i, radius)))
    };
    (0..count / 2).flat_map(both).collect()
}

/// Returns slats side by side, two triangles each.
fn slats(count: usize) -> Triangles {
    let corner = |i: usize, x| askew() * DVec3::new(x, 2.0 * i as f64 / count as f64 - 1.0, 0.0);
    let both = |i: usize| {
        [
            [corner(i, -1.0), corner(i, 1.0), corner(i + 1, 1.0)],
            [corner(i + 1, 1.0), corner(i + 1, -1.0), corner(i, -1.0)],
        ]
    };
    (0..count / 2).flat_map(both).collect()
}

/// Builds triangles of alternating materials, and others of clay.
fn build_with(triangles: &[[DVec3; 3]], others: &[[DVec3; 3]]) -> Result<Scene, Error> {
    let mut s = SceneBuilder::new("needles");
    let [first, second, third] = [mirror(), lamp(), clay()].map(|surface| s.surface(surface));
    let surfaces = [first, second].into_iter().cycle();
    for (corners, surface) in triangles.iter().zip(surfaces) {
        s.mesh(corners, &[[0, 1, 2]], surface);
    }
    for corners in others {
        s.mesh(corners, &[[0, 1, 2]], third);
    }
    s.build(any_camera())
}

/// Nothing coincides in a fan, a cone, a ring or a row of so many needles that trying all pairs
/// would take half an hour.
#[test]
fn neighbours_in_a_fan_do_not_coincide() {
    const COUNT: usize = 100_000;
    for triangles in [fan(COUNT, 0.0), fan(COUNT, 1.5), ring(COUNT), slats(COUNT)] {
        let scene = build_with(&triangles, &[]).expect("a scene");
        assert_eq!(scene.primitives().count(), COUNT);
    }
}

/// A triangle that lies on one, or across many, of a crowd is found, whichever they are: it is one
/// of the crowd, larger than all, or a small one.
#[test]
fn a_triangle_on_a_fan_is_found() {
    const COUNT: usize = 3000;
    for (triangles, height) in [(fan(COUNT, 0.0), 0.0), (fan(COUNT, 1.5), 1.5)] {
        for k in [0, 1, 777, 1499, 2250, COUNT - 1] {
            let [a, b, c] = triangles[k];
            let small = [a.lerp(b, 0.5), a.lerp(b, 0.5).lerp(c, 0.3), a.lerp(b, 0.6)];
            for other in [[a, c, b], small] {
                let message = build_with(&triangles, &[other]).expect_err("coincident");
                let names = format!("object {} (surface {})", k + 1, k % 2);
                assert!(message.to_string().contains(&names), "{k}: {message}");
            }
            // A turn by a hundredth of a sector, which on a cone is another plane.
            let turned = |i: usize| on_cone(height, (i as f64 + 0.01) / COUNT as f64, 1.0);
            let across = build_with(&triangles, &[[a, turned(k), turned(k + 1)]]);
            assert_eq!(across.is_ok(), height > 0.0, "{k}");
            // Just above.
            let up = 1e-9 * (b - a).cross(c - a).normalize();
            assert!(
                build_with(&triangles, &[[a + up, c + up, b + up]]).is_ok(),
                "{k}"
            );
        }
    }
    let flat = fan(COUNT, 0.0);
    let large = [0.0, 0.3, 0.7].map(|turn| on_cone(0.0, turn, 2.0));
    assert!(build_with(&flat, &[large]).is_err());
    assert!(build_with(&fan(COUNT, 1.5), &[large]).is_ok());
}
