//! Tests of equations (17)-(19): cosine-weighted directions, points on emitters.

use whitefurnace::sampling::warp::{
    cosine_hemisphere_inverse, hemisphere_printed, uniform_hemisphere_inverse,
    uniform_hemisphere_pdf, uniform_phi, uniform_theta,
};

use crate::prelude::*;

type Square = [f64; 2];

/// Generates numbers as the generator does: multiples of 2⁻⁵³ in [0, 1), its ends included.
fn random() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => 0u64..1 << 53,
        1 => 0u64..1000,
        1 => (1u64 << 53) - 1000..1 << 53,
    ]
    .prop_map(|n| n as f64 * UNIT_ROUNDOFF)
}

fn square() -> impl Strategy<Value = Square> {
    [random(), random()]
}

/// Returns the shortest distance on a circle of circumference 1.
fn apart(a: f64, b: f64) -> f64 {
    let d = (a - b).abs();
    d.min(1.0 - d)
}

#[test]
fn fast_map_is_equations_18_and_19() {
    property("angles", 2000, &square(), |[r1, r2]| {
        let (theta, phi) = (uniform_theta(r1), uniform_phi(r2));
        assert!((0.0..=PI / 2.0).contains(&theta) && (0.0..TAU).contains(&phi));
        assert_abs_diff_eq!(theta.cos(), 1.0 - r1, epsilon = 4.0 * UNIT_ROUNDOFF);
        assert_eq!(phi, TAU * r2);
        // 1 − r is exact for the generator's numbers; arc cosine, sine and root each lose at most
        // 2 U of a value of at most 1, the products 1 U.
        let difference = uniform_hemisphere([r1, r2]) - from_spherical(theta, phi);
        assert!(
            difference.abs().max_element() <= 8.0 * UNIT_ROUNDOFF,
            "{difference}"
        );
    });
    assert_eq!(uniform_hemisphere([0.0, 0.3]), DVec3::Z);
    assert_eq!(uniform_hemisphere([1.0, 0.0]), DVec3::X);
    assert_eq!(uniform_hemisphere([0.5, 0.0]).z, 0.5);
    assert_eq!(uniform_hemisphere_pdf(0.5), 0.5 / PI);
    assert_eq!(
        cosine_hemisphere([0.75, 0.0]),
        DVec3::new(0.75f64.sqrt(), 0.0, 0.5)
    );
    assert_eq!(cosine_hemisphere([0.0, 0.3]), DVec3::Z);
}

#[test]
fn inverses_undo_the_maps() {
    type Map = (fn(Square) -> DVec3, fn(DVec3) -> Square);
    let maps: [Map; 2] = [
        (uniform_hemisphere, uniform_hemisphere_inverse),
        (cosine_hemisphere, cosine_hemisphere_inverse),
    ];
    property("inverse", 2000, &square(), |[r1, r2]| {
        for (map, inverse) in maps {
            let w = map([r1, r2]);
            let [s1, s2] = inverse(w);
            assert_abs_diff_eq!(s1, r1, epsilon = 8.0 * UNIT_ROUNDOFF);
            assert!((0.0..1.0).contains(&s2), "azimuth {s2}");
            // The azimuth is undefined at the pole. Elsewhere its error is that of a quotient of
            // components, and of sine and cosine near zero: TAU r₂ is rounded by U of up to a full
            // turn.
            if r1 > 0.0 {
                assert!(apart(s2, r2) <= 8.0 * UNIT_ROUNDOFF, "{s2} for {r2}");
            }
            // The inverse maps back to the direction: the roots of r₁ near 0 and 1 divide its error
            // by themselves.
            assert!(
                (map([s1, s2]) - w).length()
                    <= 64.0 * UNIT_ROUNDOFF / r1.min(1.0 - r1).max(UNIT_ROUNDOFF).sqrt()
            );
        }
    });
}

#[test]
fn azimuth_is_below_a_full_turn() {
    for y in [-1e-20, -1e-300, -f64::MIN_POSITIVE, -0.0, 0.0, 1e-300] {
        let w = DVec3::new(1.0, y, 0.0);
        for inverse in [uniform_hemisphere_inverse, cosine_hemisphere_inverse] {
            let turn = inverse(w)[1];
            assert!((0.0..1.0).contains(&turn), "{turn} of a turn for y = {y:e}");
        }
        let phi = to_spherical(w).1;
        assert!((0.0..TAU).contains(&phi), "{phi} for y = {y:e}");
    }
}

#[test]
fn one_number_for_both_angles_is_a_spiral() {
    property("spiral", 500, &random(), |r| {
        let w = hemisphere_printed(r);
        assert_abs_diff_eq!(w.z, 1.0 - r, epsilon = 4.0 * UNIT_ROUNDOFF);
        if r > 0.0 {
            // The azimuth depends on the inclination: a curve, not a surface.
            assert!(apart(uniform_hemisphere_inverse(w)[1], 1.0 - w.z) <= 16.0 * UNIT_ROUNDOFF);
        }
    });
}

#[test]
fn emitter_points_lie_on_the_emitter() {
    let corner = DVec3::new(3.0, -1.0, 5.0);
    let edges = [2.0 * DVec3::Y, 2.0 * DVec3::X];
    let light = Emitter::new(EmitterShape::Rectangle { corner, edges }, DVec3::ONE);
    assert_eq!(light.area, 4.0);
    assert_eq!(light.pdf_area(), 0.25);
    let sample = light.sample([0.25, 0.75]);
    assert_eq!(sample.point, DVec3::new(4.5, -0.5, 5.0));
    assert_eq!(sample.normal, -DVec3::Z);
    let triangle = Emitter::new(
        EmitterShape::Triangle([DVec3::ZERO, DVec3::X, DVec3::Y]),
        DVec3::ONE,
    );
    assert_eq!(triangle.area, 0.5);
    assert_eq!(
        triangle.sample([0.25, 0.5]).point,
        DVec3::new(0.25, 0.5, 0.0)
    );
    assert_eq!(
        triangle.sample([0.75, 0.5]).point,
        DVec3::new(0.25, 0.5, 0.0)
    );
    assert_eq!(triangle.sample([0.25, 0.5]).normal, DVec3::Z);
    // Six tenths up the upper half of a sphere of radius 5 about a centre that is not the origin.
    let sphere = between_heights(
        Sphere::new(DVec3::new(1.0, -2.0, 3.0), 5.0),
        [0.0, f64::INFINITY],
    );
    let cap = Emitter::new(EmitterShape::Sphere(sphere), DVec3::ONE);
    assert_relative_eq!(cap.area, 50.0 * PI, max_relative = 4.0 * UNIT_ROUNDOFF);
    assert_relative_eq!(
        cap.pdf_area(),
        1.0 / (50.0 * PI),
        max_relative = 4.0 * UNIT_ROUNDOFF
    );
    let inward = Emitter::new(EmitterShape::Sphere(inward(sphere)), DVec3::ONE);
    assert_eq!(
        inward.sample([0.6, 0.0]).normal,
        -cap.sample([0.6, 0.0]).normal
    );
    let sample = cap.sample([0.6, 0.0]);
    assert!(sample.point.distance(DVec3::new(5.0, -2.0, 6.0)) <= 16.0 * UNIT_ROUNDOFF);
    assert!(sample.normal.distance(DVec3::new(0.8, 0.0, 0.6)) <= 16.0 * UNIT_ROUNDOFF);
}
