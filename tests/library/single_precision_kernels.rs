//! Tests of the single-precision lane functions, each within a stated number of roundings of its
//! value in double precision.

use std::array::from_fn;

use whitefurnace::math::real::{Real, sin_cos_of_turn};
use whitefurnace::math::simd::{EightSingles, LANES, SINGLES, Scalar, Singles, Wide};

use crate::lanes::kernels::{Kernel, Question, of_every_kernel};
use crate::prelude::*;

/// Unit roundoff of single precision.
const UNIT_ROUNDOFF_F32: f64 = 1.0 / 16_777_216.0;

/// Number of roundings that a kernel may be off by: in each argument, relative to the largest of
/// them or 1, and in each result. Kernels are some tens of operations long; few of their errors
/// have the same sign.
const ROUNDINGS: f64 = 16.0;

/// Results below this have errors relative to it: a vanishing reflectance is the square of a
/// difference of rounded numbers.
const MIN_ERROR_SCALE: f64 = 1e-3;

/// Compares every kernel with its value in double precision; the bound is the change of that value
/// when arguments change by [`ROUNDINGS`], one by one. Where the value jumps, at the edge of total
/// reflection or of a triangle, or where it is steep, the bound is wide; only a limited share of
/// all results may be so.
struct Near<'a> {
    arguments: &'a [[f64; 16]; SINGLES],
    found: &'a mut Vec<Found>,
}

/// Errors of a kernel: number of results, number of those with a wide bound, and the largest error
/// in units of its bound.
struct Found {
    name: String,
    results: u32,
    wide: u32,
    worst: f64,
}

/// Bounds above this, relative to the value or absolute, say nothing.
const WIDE_BOUND: f64 = 1e-3;

/// Maps arguments into the domain of a kernel.
fn domain(name: &str, x: &mut [f64; 16]) {
    let share = |x: f64| (x.abs() / 1.2).min(1.0 - UNIT_ROUNDOFF_F32);
    let index = |x: f64| 1.0 + x.abs();
    match name {
        "Turns" | "Directions" | "Triangle" | "Emitters" => {
            (x[0], x[1]) = (share(x[0]), share(x[1]));
        }
        "Interface" => (x[0], x[1], x[2]) = (share(x[0]), index(x[1]), index(x[2])),
        "Refracted" => {
            (x[6], x[7]) = (index(x[6]), index(x[7]));
            // Towards the front.
            if x[0] * x[3] + x[1] * x[4] + x[2] * x[5] > 0.0 {
                x[..3].iter_mut().for_each(|x| *x = -*x);
            }
        }
        "Cameras" => (x[0], x[1]) = (40.0 * share(x[0]), 30.0 * share(x[1])),
        "Picks" => (x[0], x[4]) = (share(x[0]), 3.0 * share(x[4])),
        _ => {}
    }
    *x = x.map(|x| f64::from(x as f32));
}

impl Question for Near<'_> {
    fn ask<K: Kernel>(&mut self, name: &str) {
        let arguments = self.arguments.map(|mut x| {
            domain(name, &mut x);
            x
        });
        let together = K::run(&from_fn::<_, 16, _>(|i| {
            Singles::from_lanes(|lane| arguments[lane][i])
        }));
        for first in [0, LANES] {
            let eight = K::run(&from_fn::<_, 16, _>(|i| {
                EightSingles::from_lanes(|lane| arguments[first + lane][i])
            }));
            for (i, (eight, sixteen)) in eight.iter().zip(&together).enumerate() {
                let sixteen = &sixteen.lanes()[first..][..LANES];
                let same =
                    |(a, b): (&f32, &f32)| a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan();
                assert!(
                    eight.lanes().iter().zip(sixteen).all(same),
                    "{name}: result {i}: {eight:?}, {sixteen:?}"
                );
            }
        }
        let place = self
            .found
            .iter()
            .position(|found| found.name == name)
            .unwrap_or_else(|| {
                self.found.push(Found {
                    name: name.to_owned(),
                    results: 0,
                    wide: 0,
                    worst: 0.0,
                });
                self.found.len() - 1
            });
        let found = &mut self.found[place];
        for (lane, x) in arguments.iter().enumerate() {
            let exact = K::run(x);
            let mut bounds: Vec<f64> = exact
                .iter()
                .map(|value| ROUNDINGS * UNIT_ROUNDOFF_F32 * value.abs().max(MIN_ERROR_SCALE))
                .collect();
            let scale = x[..8].iter().fold(1.0_f64, |scale, x| scale.max(x.abs()));
            for (i, sign) in (0..8).flat_map(|i| [(i, 1.0), (i, -1.0)]) {
                let mut moved = *x;
                moved[i] += sign * ROUNDINGS * UNIT_ROUNDOFF_F32 * scale;
                for ((bound, value), moved) in bounds.iter_mut().zip(&exact).zip(K::run(&moved)) {
                    *bound += (moved - value).abs();
                }
            }
            for (i, (&value, bound)) in exact.iter().zip(bounds).enumerate() {
                found.results += 1;
                let narrow = bound <= WIDE_BOUND * value.abs().max(1.0);
                let single = together[i].lane(lane);
                if single == value || single.is_nan() && value.is_nan() {
                    continue;
                }
                if !narrow {
                    found.wide += 1;
                    continue;
                }
                let error = (single - value).abs() / bound;
                found.worst = found.worst.max(error);
                assert!(
                    error <= 1.0,
                    "{name}: result {i} is {single:e}, {value:e} in double precision, bound {bound:e}, at {x:?}"
                );
            }
        }
    }
}

#[test]
fn kernels_are_within_their_roundings() {
    let mut rng = rng("singles");
    let mut found = Vec::new();
    for round in 0..400 {
        let arguments = from_fn(|_| {
            let mut x = [0.0; 16].map(|_: f64| between(&mut rng, -1.2, 1.2));
            if round % 2 == 1 {
                let [a, b] = [unit_vector(&mut rng), unit_vector(&mut rng)];
                x[..3].copy_from_slice(&a.to_array());
                x[3..6].copy_from_slice(&b.to_array());
            }
            x
        });
        of_every_kernel(&mut Near {
            arguments: &arguments,
            found: &mut found,
        });
    }
    for Found {
        name,
        results,
        wide,
        worst,
    } in &found
    {
        println!("{name}: {worst:.2} of the bound; {wide} of {results} are ill-conditioned");
        assert!(
            f64::from(*wide) <= 0.01 * f64::from(*results),
            "{name}: {wide} of {results} say nothing"
        );
    }
}

/// Tests the whole domain: every number of 22 bits, and random numbers between them.
#[test]
fn sines_of_turns_are_within_their_bound_in_single_precision() {
    let mut rng = rng("single turns");
    let mut worst = 0.0_f64;
    for block in 0..=(1 << 22) / SINGLES {
        let even = Singles::from_lanes(|lane| {
            ((block * SINGLES + lane) as f64 / f64::from(1 << 22)).min(1.0)
        });
        let numbers: [f64; SINGLES] = from_fn(|_| uniform(&mut rng));
        let random = Singles::from_lanes(|lane| numbers[lane]);
        for shares in if block % 4 == 0 {
            [even, random]
        } else {
            [even; 2]
        } {
            let (sin, cos) = sin_cos_of_turn(shares);
            for lane in 0..SINGLES {
                let (s, c) = sin_cos_of_turn(shares.lane(lane));
                worst = worst
                    .max((sin.lane(lane) - s).abs())
                    .max((cos.lane(lane) - c).abs());
            }
        }
    }
    println!("{worst:.2e}");
    assert!(worst <= 2e-7, "{worst:e}");
}

/// Compares the uniform numbers of the same 64 bits in both precisions.
#[test]
fn uniform_numbers_lie_below_one_and_near() {
    let mut rng = rng("single numbers");
    let words = (0..64)
        .map(|shift| u64::MAX >> shift)
        .chain((0..64).map(|shift| u64::MAX << shift));
    for word in words.chain((0..100_000).map(|_| rng.next_u64())) {
        let (single, double) = (f64::from(f32::unit(word)), f64::unit(word));
        assert!(
            (0.0..1.0).contains(&single) && single <= double && double - single < UNIT_ROUNDOFF_F32,
            "{word:x}"
        );
    }
    assert_eq!(
        (f32::unit(u64::MAX), f32::unit(0)),
        (1.0 - f32::EPSILON / 2.0, 0.0)
    );
}
