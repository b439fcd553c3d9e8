//! Tests of adaptive quadrature over rectangles: exact for polynomials, where it stops, at its
//! limit.

use whitefurnace::harness::quadrature::{Rectangle, integrate};

use super::*;

#[test]
fn quadrature_is_exact_for_polynomials_and_adapts_to_kinks() {
    let unit = Rectangle {
        x: [-1.0, 2.0],
        y: [0.0, 3.0],
    };
    let power =
        |p: i32, [a, b]: [f64; 2]| (f64::powi(b, p + 1) - f64::powi(a, p + 1)) / f64::from(p + 1);
    for (i, j) in [(0, 0), (3, 12), (22, 0), (7, 20)] {
        let found = integrate(unit, 1e300, &mut |x, y| x.powi(i) * y.powi(j));
        assert_relative_eq!(
            found.value,
            power(i, unit.x) * power(j, unit.y),
            max_relative = 1e-12
        );
    }
    let kink = integrate(unit, 1e-9, &mut |x, _| (x - 0.3).abs());
    assert_relative_eq!(
        kink.value,
        3.0 * (1.3 * 1.3 + 1.7 * 1.7) / 2.0,
        epsilon = 1e-8
    );
    assert!(integrate(unit, 1e-9, &mut |_, _| f64::NAN).value.is_nan());
}

#[test]
fn quadrature_ends_where_nothing_is_left_to_refine_and_at_its_limit() {
    let unit = Rectangle {
        x: [0.0, 1.0],
        y: [0.0, 1.0],
    };
    let evaluations = |f: &dyn Fn(f64) -> f64| {
        let mut n = 0;
        let found = integrate(unit, 0.0, &mut |x, _| {
            n += 1;
            f(x)
        });
        (n, found.error > 0.0)
    };
    assert_eq!(evaluations(&|_| 0.0), (225, false));
    // A kink is refined until only rounding is left.
    let (n, inexact) = evaluations(&|x| (x - 0.3).abs());
    assert!(inexact && n < 225 * 2 * 1024, "{n}");
    // A step across the square leaves half of its error to twice as many rectangles: each of 20 000
    // but the first is one half of another.
    let mut n = 0;
    let step = integrate(unit, 0.0, &mut |x, y| {
        n += 1;
        f64::from(x + y < 0.7)
    });
    assert!(step.error > 0.0);
    assert_eq!(n, 225 * (2 * 20_000 - 1));
}
