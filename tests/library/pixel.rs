//! Tests of section 2.7: sample positions within a pixel.

use crate::prelude::*;

/// Largest number that the generator returns.
const LAST: f64 = 1.0 - UNIT_ROUNDOFF;

#[test]
fn samples_per_replication() {
    for (strategy, count) in [
        (Centre, 1),
        (Random, 1),
        (Grid(1), 1),
        (Grid(3), 9),
        (Jitter(4), 16),
    ] {
        assert_eq!(strategy.samples_per_replication(), count);
    }
}

#[test]
fn each_sub_pixel_has_one_sample() {
    let random = prop::array::uniform2(prop_oneof![0.0..1.0, Just(0.0), Just(LAST)]);
    property("sub-pixels", 500, &(1u32..40, random), |(n, random)| {
        let side = f64::from(n);
        for strategy in [Grid(n), Jitter(n)] {
            for index in 0..n * n {
                let position = strategy.position(index, random);
                let cell = [index % n, index / n].map(f64::from);
                for axis in 0..2 {
                    let x = position[axis];
                    assert!((0.0..=1.0).contains(&x));
                    // Three roundings of at most n parts, so that a sample may lie on the border.
                    let inside = x * side - cell[axis];
                    let rounding = 3.0 * UNIT_ROUNDOFF * side;
                    assert!(
                        inside >= -rounding && inside <= 1.0 + rounding,
                        "{strategy:?} {x}"
                    );
                    let expected = if strategy == Grid(n) {
                        0.5
                    } else {
                        random[axis]
                    };
                    assert_abs_diff_eq!(inside, expected, epsilon = rounding);
                }
            }
        }
    });
}

#[test]
fn centre_and_random() {
    let random = prop::array::uniform2(0.0..1.0);
    property(
        "whole pixel",
        100,
        &(0u32..100, random),
        |(index, random)| {
            assert_eq!(Centre.position(index, random), [0.5, 0.5]);
            assert_eq!(Random.position(index, random), random);
        },
    );
}
