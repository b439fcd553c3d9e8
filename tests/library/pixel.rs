//! Section 2.7: where in a pixel the rays go, and what edges make of it.

use approx::assert_abs_diff_eq;
use proptest::prelude::*;
use whitefurnace::pixel::PixelSampling::{self, Centre, Grid, Jitter, Random};
use whitefurnace::rng::uniform2;

use crate::helpers::{U, between};
use crate::support::{property, rng};

/// The largest number that the generator makes.
const LAST: f64 = 1.0 - U;

#[test]
fn samples_per_replication() {
    for (strategy, count) in [(Centre, 1), (Random, 1), (Grid(1), 1), (Grid(3), 9), (Jitter(4), 16)]
    {
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
                    // Three roundings of at most n parts: the border itself may be met.
                    let inside = x * side - cell[axis];
                    let rounding = 3.0 * U * side;
                    assert!(inside >= -rounding && inside <= 1.0 + rounding, "{strategy:?} {x}");
                    let expected = if strategy == Grid(n) { 0.5 } else { random[axis] };
                    assert_abs_diff_eq!(inside, expected, epsilon = rounding);
                }
            }
        }
    });
}

#[test]
fn centre_and_random() {
    property(
        "whole pixel",
        100,
        &(0u32..100, prop::array::uniform2(0.0..1.0)),
        |(index, random)| {
            assert_eq!(Centre.position(index, random), [0.5, 0.5]);
            assert_eq!(Random.position(index, random), random);
            assert_eq!(Grid(1).position(0, random), [0.5, 0.5]);
            assert_eq!(Jitter(1).position(0, random), random);
        },
    );
    assert_eq!(Grid(2).position(1, [0.0; 2]), [0.75, 0.25]);
    assert_eq!(Grid(2).position(2, [0.0; 2]), [0.25, 0.75]);
    assert_eq!(Jitter(4).position(6, [0.5, 0.25]), [0.625, 0.3125]);
}

/// Area of the unit square where a x + b y < c, by clipping the square.
fn coverage(a: f64, b: f64, c: f64) -> f64 {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let level = |[x, y]: [f64; 2]| a * x + b * y - c;
    let mut inside = Vec::new();
    for i in 0..4 {
        let (p, q) = (corners[i], corners[(i + 1) % 4]);
        let (f, g) = (level(p), level(q));
        if f < 0.0 {
            inside.push(p);
        }
        if (f < 0.0) != (g < 0.0) {
            let s = f / (f - g);
            inside.push([p[0] + s * (q[0] - p[0]), p[1] + s * (q[1] - p[1])]);
        }
    }
    let twice: f64 = (0..inside.len())
        .map(|i| {
            let (p, q) = (inside[i], inside[(i + 1) % inside.len()]);
            p[0] * q[1] - p[1] * q[0]
        })
        .sum();
    0.5 * twice
}

/// Share of a replication's samples where a x + b y < c.
fn share(
    strategy: PixelSampling,
    [a, b, c]: [f64; 3],
    random: &mut impl FnMut() -> [f64; 2],
) -> f64 {
    let n = strategy.samples_per_replication();
    let covered = (0..n)
        .filter(|&index| {
            let [x, y] = strategy.position(index, random());
            a * x + b * y < c
        })
        .count();
    covered as f64 / f64::from(n)
}

#[test]
fn edges_are_met_within_their_cells() {
    // A line crosses at most 2n − 1 of n² cells. A cell's centre decides it with an error of at most
    // half of it, a random point with at most the whole.
    let mut rng = rng("edges");
    let mut random = || uniform2(&mut rng);
    assert_abs_diff_eq!(coverage(1.0, 1.0, 1.0), 0.5, epsilon = U);
    assert_abs_diff_eq!(coverage(1.0, 2.0, 1.0), 0.25, epsilon = U);
    for _ in 0..2000 {
        let [s, t] = random();
        let (sin, cos) = (std::f64::consts::TAU * s).sin_cos();
        let edge = [cos, sin, between_ends(cos, sin, t)];
        let exact = coverage(edge[0], edge[1], edge[2]);
        for n in [1u32, 2, 4, 8] {
            let cell = 1.0 / f64::from(n * n);
            let crossed = f64::from(2 * n - 1) * cell;
            let grid = (share(Grid(n), edge, &mut random) - exact).abs();
            assert!(grid <= 0.5 * crossed + 64.0 * U, "grid {n}: off by {grid} at {edge:?}");
            let jitter = (share(Jitter(n), edge, &mut random) - exact).abs();
            assert!(jitter <= crossed + 64.0 * U, "jitter {n}: off by {jitter} at {edge:?}");
        }
    }
}

/// A level between the smallest and the largest of a x + b y on the square.
fn between_ends(a: f64, b: f64, t: f64) -> f64 {
    let low = a.min(0.0) + b.min(0.0);
    low + t * (a.max(0.0) + b.max(0.0) - low)
}

#[test]
fn a_grid_errs_in_the_same_way_along_an_axis_aligned_edge() {
    // An edge at x = (k + s)/n covers k columns or k + 1: the error is s or 1 − s of a column, up to
    // half of one, and no sample in y averages it out.
    let mut rng = rng("aligned edges");
    for n in [2u32, 4, 8] {
        for _ in 0..100 {
            let edge = between(&mut rng, 0.0, 1.0);
            let columns = edge * f64::from(n);
            let rounded = (columns - 0.5).ceil();
            let found = share(Grid(n), [1.0, 0.0, edge], &mut || [0.0; 2]);
            assert_abs_diff_eq!(found * f64::from(n), rounded, epsilon = 4.0 * U * f64::from(n));
            assert!((found - edge).abs() <= 0.5 / f64::from(n) + U);
        }
    }
}
