//! Tests of section 2.6.2: Russian roulette.

use std::cell::RefCell;

use whitefurnace::math::real::Real as _;
use whitefurnace::math::simd::FourSingles;
use whitefurnace::sampling::roulette::{
    MAX_SURVIVAL, by_absorption, by_throughput, rescaled, survives,
};

use crate::prelude::*;

#[test]
fn the_share_of_survivors_is_the_survival() {
    // Exactly k of n equally spaced numbers in [0, 1) are below k/n.
    let n = 1024;
    for k in [0, 1, 100, 768, 1023, 1024] {
        let survival = f64::from(k) / f64::from(n);
        assert_eq!(
            (0..n)
                .filter(|&i| survives(f64::from(i) / f64::from(n), survival))
                .count(),
            k as usize
        );
    }
    assert!(!survives(0.0, 0.0), "survival 0 is certain death");
    assert!(
        survives(1.0 - UNIT_ROUNDOFF, 1.0),
        "survival 1 is certain life"
    );
}

#[test]
fn survival_is_the_rest_of_absorption_or_bounds_weights() {
    for (absorption, survival) in [(0.25, 0.75), (0.0, 1.0), (1.0, 0.0)] {
        assert_eq!(by_absorption(absorption), survival);
    }
    assert_eq!(MAX_SURVIVAL, 0.95);
    for (throughput, survival) in [
        ([0.0; 3], 0.0),
        ([0.1, 0.7, 0.3], 0.7),
        ([0.1, 0.2, 7.0], MAX_SURVIVAL),
    ] {
        assert_eq!(by_throughput(DVec3::from(throughput), false), survival);
        assert_eq!(
            by_throughput(DVec3::from(throughput), true),
            throughput[1].max(throughput[2]).min(1.0)
        );
    }
}

#[test]
fn the_number_of_a_survivor_is_uniform_again() {
    // The numbers of survivors, equally spaced from 0 to the survival, are so from 0 to 1 when rescaled.
    let survival = 0.375;
    for i in 0..384 {
        let rescaled = rescaled(f64::from(i) / 1024.0, survival);
        assert_abs_diff_eq!(
            rescaled,
            f64::from(i) / 384.0,
            epsilon = 2.0 * UNIT_ROUNDOFF
        );
    }
    for survival in (1..=1000).map(|i| f64::from(i) / 1000.0) {
        let below = f64::next_down(survival);
        assert!(rescaled(below, survival) < 1.0, "survival {survival}");
        let single = survival as f32;
        let [below, single] =
            [single.next_down(), single].map(|x| FourSingles::splat(f64::from(x)));
        assert!(
            rescaled(below, single).lane(0) < 1.0,
            "survival {survival} in single precision"
        );
    }
}

thread_local! {
    /// Numbers that decided the games of a path in order.
    static NUMBERS: RefCell<Vec<f64>> = const { RefCell::new(Vec::new()) };
}

/// A policy that records the numbers of twelve games, all of which the path survives.
struct NumberRecorder;

default_parts!(NumberRecorder: Scattering, NextEvent, Photons, Bidirectional, FiniteElements);

impl Roulette for NumberRecorder {
    fn survival_by_throughput(&self, _: DVec3, _: bool) -> f64 {
        0.3
    }
    fn survives(&self, r: f64, _: f64) -> bool {
        NUMBERS.with_borrow_mut(|numbers| numbers.push(r));
        NUMBERS.with_borrow(|numbers| numbers.len() < 12)
    }
}

#[test]
fn a_number_decides_games_until_its_digits_are_used_up() {
    let scene = within_sphere(diffuse(0.5).emitting(DVec3::ONE));
    let ray = Ray::new(DVec3::ZERO, DVec3::X);
    let path = Path::new(PathStrategy::Bsdf).with_parts(Parts::replaced(&NumberRecorder));
    let mut random = stream(master(), 0, 0);
    path.radiance(&scene, &ray, scene.intersect(&ray), &mut random);
    let numbers = NUMBERS.take();
    assert_eq!(numbers.len(), 12);
    for (game, pair) in numbers.windows(2).enumerate() {
        // 0.3^3 is above a fiftieth, 0.3^4 below it.
        let is_next = pair[1] == rescaled(pair[0], 0.3);
        assert_eq!(is_next, game % 4 != 3, "game {game}: {numbers:?}");
    }
}

thread_local! {
    /// Arguments of the policy in order: a throughput, and whether the hit was early.
    static ASKED: RefCell<Vec<(f64, bool)>> = const { RefCell::new(Vec::new()) };
}

/// A policy that records its arguments, and ends paths at their fifth hit.
struct PolicyRecorder;

default_parts!(PolicyRecorder: Scattering, NextEvent, Photons, Bidirectional, FiniteElements);

impl Roulette for PolicyRecorder {
    fn survival_by_throughput(&self, throughput: DVec3, early: bool) -> f64 {
        ASKED.with_borrow_mut(|asked| asked.push((throughput.x, early)));
        1.0
    }
    fn survives(&self, _: f64, _: f64) -> bool {
        ASKED.with_borrow(|asked| asked.len() < 5)
    }
}

#[test]
fn the_first_hits_of_a_path_are_early() {
    let scene = within_sphere(diffuse(0.5).emitting(DVec3::ONE));
    let ray = Ray::new(DVec3::ZERO, DVec3::X);
    for early in [0, 2, 9] {
        ASKED.take();
        let path = Path {
            rr_depth: early,
            ..Path::new(PathStrategy::Bsdf).with_parts(Parts::replaced(&PolicyRecorder))
        };
        path.radiance(
            &scene,
            &ray,
            scene.intersect(&ray),
            &mut stream(master(), 0, 0),
        );
        let asked = ASKED.take();
        // Relative to 1/2, the throughput of faint survivors.
        let expected = (1..=5).map(|hit| (2.0 * 0.5f64.powi(hit as i32), hit <= early));
        for ((found, is_early), (throughput, should_be)) in asked.iter().zip(expected) {
            assert_abs_diff_eq!(*found, throughput, epsilon = 1e-12);
            assert_eq!(*is_early, should_be, "{early} hits are early");
        }
        assert_eq!(asked.len(), 5);
    }
}
