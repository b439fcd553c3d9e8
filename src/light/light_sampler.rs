//! Light samplers: emitters are picked half by flux and half uniformly for particles, and by
//! estimated importance, with a fraction of the picks uniform, for shadow rays, [`crate::equation::LIGHT_PICK`].

use crate::math::real::Real;

/// Maximum number of emitters whose importances are evaluated individually at a vertex; more are
/// picked through [groups](crate::light::light_tree).
pub const MAX_EXACT_LIGHTS: usize = 64;
/// Fraction of picks that is uniform among the emitters with an importance above 0, as occlusion
/// may change the importances.
pub const UNIFORM_FRACTION: f64 = 0.2;
/// Bounds to which importances are clamped, so that neither their sum nor its inverse overflows.
const IMPORTANCE_BOUNDS: [f64; 2] = [1e-280, 1e280];
/// [`IMPORTANCE_BOUNDS`] in single precision.
const SINGLE_IMPORTANCE_BOUNDS: [f64; 2] = [1e-30, 1e30];

/// Picks emitters independently of a position. Unlike pbrt's sampler of this name it makes only half
/// of the picks in proportion to flux, and the other half uniformly among the emitters with flux, as
/// dim lights near the eye may matter more.
#[derive(Clone, Debug)]
pub struct PowerLightSampler {
    /// Cumulative selection probabilities.
    cdf: Vec<f64>,
}

impl PowerLightSampler {
    /// Creates the distribution for these fluxes, in any unit.
    pub fn new(fluxes: &[f64]) -> Self {
        let largest = fluxes.iter().copied().fold(0.0, f64::max).min(f64::MAX);
        // Without any flux all emitters have the same probability.
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
        let mut cdf = Vec::with_capacity(fluxes.len());
        let mut last = 0.0;
        for &flux in fluxes {
            last += relative(flux) / sum + if shines(flux) { 1.0 / shining } else { 0.0 };
            cdf.push(last);
        }
        cdf.iter_mut().for_each(|probability| *probability /= last);
        Self { cdf }
    }

    /// Returns the index of the emitter that a uniform number in [0, 1) picks.
    #[inline]
    pub fn pick(&self, r: f64) -> usize {
        self.cdf.partition_point(|&probability| probability <= r)
    }

    /// Returns the selection probability of an emitter.
    #[inline]
    pub fn probability(&self, index: usize) -> f64 {
        self.cdf[index] - index.checked_sub(1).map_or(0.0, |before| self.cdf[before])
    }
}

/// Factors that turn importances into selection probabilities.
#[derive(Clone, Copy)]
struct Scale<R> {
    proportional: R,
    uniform: R,
}

impl<R: Real> Scale<R> {
    /// Computes the factors from all importances, and passes each clamped importance to `each`.
    #[inline]
    fn new(count: usize, importance: impl Fn(usize) -> R, mut each: impl FnMut(usize, R)) -> Self {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let (mut sum, mut positive) = (zero, zero);
        for i in 0..count {
            let importance = importance(i);
            let some = importance.cmpgt(zero);
            let [low, high] = [0, 1]
                .map(|end| R::by_precision(IMPORTANCE_BOUNDS[end], SINGLE_IMPORTANCE_BOUNDS[end]));
            let bounded = importance.maximum(low).minimum(high);
            let bounded = R::select(some, bounded, zero);
            sum = sum + bounded;
            positive = positive + R::select(some, one, zero);
            each(i, bounded);
        }
        Self {
            proportional: R::splat(1.0 - UNIFORM_FRACTION) / sum,
            uniform: R::splat(UNIFORM_FRACTION) / positive,
        }
    }

    #[inline]
    fn probability(self, importance: R) -> R {
        let zero = R::splat(0.0);
        R::select(
            importance.cmpgt(zero),
            importance * self.proportional + self.uniform,
            zero,
        )
    }
}

/// Turns importances into the selection probabilities of `probabilities.len()` emitters, which sum
/// to 1; all are 0 if no emitter has importance.
#[inline]
pub fn probabilities<R: Real>(importance: impl Fn(usize) -> R, probabilities: &mut [R]) {
    let scale = Scale::new(probabilities.len(), importance, |i, importance| {
        probabilities[i] = importance;
    });
    probabilities
        .iter_mut()
        .for_each(|probability| *probability = scale.probability(*probability));
}

/// Returns the selection probability of one of `count` emitters.
#[inline]
pub fn probability<R: Real>(importance: impl Fn(usize) -> R, count: usize, index: R) -> R {
    let mut wanted = R::splat(0.0);
    let each = |i: usize, importance| {
        wanted = R::select(index.cmpeq(R::splat(i as f64)), importance, wanted);
    };
    let scale = Scale::new(count, importance, each);
    scale.probability(wanted)
}

/// Returns the index that a uniform number in [0, 1) picks by these probabilities, and its
/// probability; 0 and 0 if all are 0.
#[inline]
pub fn pick<R: Real>(probabilities: &[R], r: R) -> (R, R) {
    let zero = R::splat(0.0);
    let (mut index, mut picked, mut left) = (zero, zero, r);
    for (i, &probability) in probabilities.iter().enumerate() {
        // If rounding leaves a rest of `r`, the last index with a probability above 0 is picked.
        let here = probability.cmpgt(zero) & !left.cmplt(zero);
        index = R::select(here, R::splat(i as f64), index);
        picked = R::select(here, probability, picked);
        left = left - probability;
    }
    (index, picked)
}
