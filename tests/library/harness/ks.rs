//! Tests of the Kolmogorov-Smirnov test with the distances of regular points.

use whitefurnace::harness::tails::{kolmogorov_sf, kolmogorov_upper};

use super::*;

#[test]
fn distribution_functions_are_compared_at_every_value() {
    // Midpoints of 256 equal intervals, exact in binary: D = 1/512 everywhere, first at the first.
    let midpoint = |i: u32| (f64::from(i) + 0.5) / 256.0;
    let mut values: Vec<f64> = (0..256).rev().map(midpoint).collect();
    let found = kolmogorov_smirnov("grid", &mut values, |x| x, 0.5);
    assert_eq!((found.n, found.estimate), (256, 1.0 / 512.0));
    assert_relative_eq!(found.value, 16.0 / 512.0, max_relative = 1e-12);
    assert_eq!(found.p, kolmogorov_sf(256, 1.0 / 512.0));
    let radius = kolmogorov_upper(256, ALPHA);
    assert_eq!(found.interval, [0.0, 1.0 / 512.0 + radius]);
    assert_eq!(
        found.worst,
        "distribution functions differ by 0.00195 at 0.001953"
    );
    // Every fourth of 256 points is kept, each with its own binomial spread.
    assert_eq!(found.cells.len(), 64);
    let mut values: Vec<f64> = (0..256).map(midpoint).collect();
    let squares = kolmogorov_smirnov("squares", &mut values, |x| x * x, 0.5);
    let x = midpoint(40);
    let spread = (x * x * (1.0 - x * x) / 256.0).sqrt();
    let cell = &squares.cells[10];
    assert_cell(cell, &cell.place, [x * x, x, (x - x * x) / spread]);
    // x − x² is largest at 1/2, just after or just before a value.
    assert_relative_eq!(squares.estimate, 0.25 + 1.0 / 512.0, max_relative = 1e-2);
    assert_eq!(squares.interval[0], (squares.estimate - radius).max(0.0));
    assert!(squares.estimate > radius);
    // And √x − x at 1/4, with the sides exchanged.
    let roots = kolmogorov_smirnov("roots", &mut values, f64::sqrt, 0.5);
    assert_relative_eq!(roots.estimate, 0.25 + 1.0 / 512.0, max_relative = 1e-2);
    let mut ten = [0.5; 10];
    assert_eq!(
        kolmogorov_smirnov("ten", &mut ten, |x| x, 0.5).cells.len(),
        10
    );
}
