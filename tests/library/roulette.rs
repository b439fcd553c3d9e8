//! Section 2.6.2: Russian roulette.

use whitefurnace::roulette::{HIGHEST_SURVIVAL, by_absorption, by_throughput, survives, weight};

use crate::prelude::*;

#[test]
fn survivors_stand_for_all() {
    property("weight", 1000, &(1e-6..=1.0), |survival| {
        assert_abs_diff_eq!(weight(survival) * survival, 1.0, epsilon = 2.0 * U);
    });
    assert_eq!(weight(0.25), 4.0);
}

#[test]
fn the_share_of_survivors_is_the_survival() {
    // Of n equally spaced numbers in [0, 1), exactly k are below k/n.
    let n = 1024;
    for k in [0, 1, 100, 768, 1023, 1024] {
        let survival = f64::from(k) / f64::from(n);
        assert_eq!((0..n).filter(|&i| survives(f64::from(i) / f64::from(n), survival)).count(), k as usize);
    }
    assert!(!survives(0.0, 0.0), "survival 0 is certain death");
    assert!(survives(1.0 - U, 1.0), "survival 1 is certain life");
}

#[test]
fn survival_is_the_rest_of_absorption_or_bounds_weights() {
    for (absorption, survival) in [(0.25, 0.75), (0.0, 1.0), (1.0, 0.0)] {
        assert_eq!(by_absorption(absorption), survival);
    }
    assert_eq!(HIGHEST_SURVIVAL, 0.95);
    for (throughput, survival) in [([0.0; 3], 0.0), ([0.1, 0.7, 0.3], 0.7), ([0.1, 0.2, 7.0], HIGHEST_SURVIVAL)] {
        assert_eq!(by_throughput(DVec3::from(throughput)), survival);
    }
}
