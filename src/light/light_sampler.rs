//! Which emitter a particle starts from, by flux, and which one a shadow ray looks for: each with a
//! share of the picks in proportion to what it may contribute, and some of them evenly,
//! [`crate::equation::LIGHT_PICK`].

use crate::math::real::Real;

/// So many emitters at most are asked one by one what they may contribute at a vertex; more are in
/// [groups](crate::light::light_tree) of fewer.
pub const MOST: usize = 64;
/// This part of all picks is even among the emitters that may contribute at all: what they do
/// contribute hangs on what stands between, too.
pub const EVEN: f64 = 0.2;
/// Contributions are taken as within these bounds, so that neither their sum nor its inverse
/// overflows.
const BOUNDS: [f64; 2] = [1e-280, 1e280];
/// The same in single precision.
const SINGLE_BOUNDS: [f64; 2] = [1e-30, 1e30];

/// Picks of emitters that do not depend on a place: one half in proportion to their flux, as most
/// light is then followed, the other half evenly among those that have any, as little light near
/// the eye may matter more.
#[derive(Clone, Debug)]
pub struct FluxPicks {
    /// The share of all picks that an emitter has together with those before it.
    up_to: Vec<f64>,
}

impl FluxPicks {
    /// Of emitters with these fluxes, in any unit.
    pub fn new(fluxes: &[f64]) -> Self {
        let largest = fluxes.iter().copied().fold(0.0, f64::max).min(f64::MAX);
        // Without any flux at all they are as good as each other.
        let shines = |flux: f64| flux > 0.0 || largest == 0.0;
        let relative = |flux: f64| {
            if largest > 0.0 {
                flux.min(largest) / largest
            } else {
                1.0
            }
        };
        let sum: f64 = fluxes.iter().map(|&flux| relative(flux)).sum();
        let shining = fluxes.iter().filter(|&&flux| shines(flux)).count() as f64;
        let mut up_to = Vec::with_capacity(fluxes.len());
        let mut last = 0.0;
        for &flux in fluxes {
            last += relative(flux) / sum + if shines(flux) { 1.0 / shining } else { 0.0 };
            up_to.push(last);
        }
        up_to.iter_mut().for_each(|share| *share /= last);
        Self { up_to }
    }

    /// The number of the emitter that a uniform number in [0, 1) picks.
    #[inline]
    pub fn pick(&self, r: f64) -> usize {
        self.up_to.partition_point(|&share| share <= r)
    }

    /// The probability of that.
    #[inline]
    pub fn probability(&self, index: usize) -> f64 {
        self.up_to[index]
            - index
                .checked_sub(1)
                .map_or(0.0, |before| self.up_to[before])
    }
}

/// What turns contributions into shares.
#[derive(Clone, Copy)]
struct Scale<R> {
    proportional: R,
    even: R,
}

impl<R: Real> Scale<R> {
    /// Of all contributions, each handed on as it is bounded.
    #[inline]
    fn new(
        count: usize,
        contribution: impl Fn(usize) -> R,
        mut each: impl FnMut(usize, R),
    ) -> Self {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let (mut sum, mut positive) = (zero, zero);
        for i in 0..count {
            let contribution = contribution(i);
            let some = contribution.above(zero);
            let [low, high] = [0, 1].map(|end| R::by_precision(BOUNDS[end], SINGLE_BOUNDS[end]));
            let bounded = contribution.at_least(low).at_most(high);
            let bounded = R::choose(some, bounded, zero);
            sum = sum + bounded;
            positive = positive + R::choose(some, one, zero);
            each(i, bounded);
        }
        Self {
            proportional: R::splat(1.0 - EVEN) / sum,
            even: R::splat(EVEN) / positive,
        }
    }

    #[inline]
    fn share(self, contribution: R) -> R {
        let zero = R::splat(0.0);
        R::choose(
            contribution.above(zero),
            contribution * self.proportional + self.even,
            zero,
        )
    }
}

/// The shares of `shares.len()` emitters, which sum to 1, from what each may contribute; all are 0
/// if none may.
#[inline]
pub fn share_all<R: Real>(contribution: impl Fn(usize) -> R, shares: &mut [R]) {
    let scale = Scale::new(shares.len(), contribution, |i, contribution| {
        shares[i] = contribution;
    });
    shares
        .iter_mut()
        .for_each(|share| *share = scale.share(*share));
}

/// The share of one of `count` emitters.
#[inline]
pub fn share<R: Real>(contribution: impl Fn(usize) -> R, count: usize, index: R) -> R {
    let mut wanted = R::splat(0.0);
    let each = |i: usize, contribution| {
        wanted = R::choose(index.equals(R::splat(i as f64)), contribution, wanted);
    };
    let scale = Scale::new(count, contribution, each);
    scale.share(wanted)
}

/// The number of the emitter that a uniform number in [0, 1) picks by shares, and its share; 0 and
/// 0 if none has any.
#[inline]
pub fn pick<R: Real>(shares: &[R], r: R) -> (R, R) {
    let zero = R::splat(0.0);
    let (mut index, mut picked, mut left) = (zero, zero, r);
    for (i, &share) in shares.iter().enumerate() {
        // Where rounding leaves some of `r`, the last one with a share has it.
        let here = share.above(zero) & !left.below(zero);
        index = R::choose(here, R::splat(i as f64), index);
        picked = R::choose(here, share, picked);
        left = left - share;
    }
    (index, picked)
}
