//! Tests of orthonormal frames and spherical coordinates.

use crate::prelude::*;

/// Normals of all directions, more of them near the poles and the equator, where signs change.
fn normals() -> impl Strategy<Value = DVec3> {
    let near = |theta: f64| {
        (-16.0..-1.0, 0.0..TAU)
            .prop_map(move |(e, phi): (f64, f64)| from_spherical(theta + 10f64.powf(e), phi))
    };
    prop_oneof![unit(), near(0.0), near(PI), near(PI / 2.0), near(-PI)]
}

/// Bound on the error of entries of at most 2 with some six roundings, for normals that are unit to
/// 3 U, which the denominator 1 + |z| ≥ 1 does not enlarge.
const BOUND: f64 = 16.0 * UNIT_ROUNDOFF;

fn check(n: DVec3) {
    let Frame { x, y, z } = Frame::new(n);
    assert_eq!(z, n);
    for (a, b, expected) in [
        (x, x, 1.0),
        (y, y, 1.0),
        (z, z, 1.0),
        (x, y, 0.0),
        (y, z, 0.0),
        (z, x, 0.0),
    ] {
        assert_abs_diff_eq!(a.dot(b), expected, epsilon = BOUND);
    }
    assert!((x.cross(y) - z).length() <= BOUND, "right-handed");
}

#[test]
fn frames_are_orthonormal() {
    property("frames", 3000, &(normals(), point(3.0)), |(n, w)| {
        check(n);
        let frame = Frame::new(n);
        let bound = 2.0 * BOUND * w.length();
        assert!((frame.world(frame.local(w)) - w).length() <= bound);
        assert!((frame.local(frame.world(w)) - w).length() <= bound);
        assert_abs_diff_eq!(frame.local(w).z, n.dot(w), epsilon = bound);
        assert_eq!(frame.world(DVec3::Z), n);
    });
    for n in DVec3::AXES {
        check(n);
        check(-n);
    }
    check(DVec3::new(1.0, 0.0, -0.0));
    check(DVec3::new(-1e-160, 1e-160, -1.0));
}

#[test]
fn spherical_coordinates_undo_each_other() {
    property("to angles and back", 2000, &normals(), |w| {
        let (theta, phi) = to_spherical(w);
        assert!((0.0..=PI).contains(&theta) && (0.0..TAU).contains(&phi));
        // Angles of up to 2π are rounded by U of themselves, in either direction.
        assert!((from_spherical(theta, phi) - w).length() <= 16.0 * UNIT_ROUNDOFF);
    });
    property(
        "to vector and back",
        2000,
        &(0.0..=PI, 0.0..TAU),
        |(theta, phi)| {
            let (theta_back, phi_back) = to_spherical(from_spherical(theta, phi));
            assert_abs_diff_eq!(theta_back, theta, epsilon = 8.0 * UNIT_ROUNDOFF);
            if theta.sin() > 1e-3 {
                let d = (phi_back - phi).abs();
                assert!(d.min(TAU - d) <= 16.0 * UNIT_ROUNDOFF);
            }
        },
    );
    assert_eq!(to_spherical(DVec3::Y), (PI / 2.0, PI / 2.0));
    assert_eq!(to_spherical(-DVec3::Z).0, PI);
    assert_eq!(to_spherical(DVec3::Z).0, 0.0);
    assert_eq!(from_spherical(0.0, 1.0), DVec3::Z);
}
