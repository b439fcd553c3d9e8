//! Russian roulette, section 2.6.2: [`crate::equation::ROULETTE`].

use glam::DVec3;

use crate::math::real::{MaskOf, Real, Vector};

/// Returns whether the path continues: r < survival = 1 − α, for r uniform in [0, 1), so with
/// exactly that probability.
#[inline]
pub fn survives<R: Real>(r: R, survival: R) -> R::Mask {
    r.cmplt(survival)
}

/// Returns the factor of a survivor's throughput: 1/(1 − α).
#[inline]
pub fn weight<R: Real>(survival: R) -> R {
    survival.recip()
}

/// Returns the number that decides the next game of a survivor, from the number r that decided this
/// one: r/(1 − α), which is uniform in [0, 1) again, as r is below 1 − α.
#[inline]
pub fn rescaled<R: Real>(r: R, survival: R) -> R {
    (r * survival.recip()).minimum(R::by_precision(
        1.0 - f64::EPSILON / 2.0,
        1.0 - EPSILON_SINGLE / 2.0,
    ))
}

/// Probability of the survivals that one number decides, below which the next game has a new number:
/// so enough digits are left. It is no power of ½, lest rounding decide at albedo ½.
pub const LEAST_SHARE: f64 = 0.02;

/// Machine epsilon of single precision.
const EPSILON_SINGLE: f64 = f32::EPSILON as f64;

/// Maximum survival probability of [`by_throughput`] after early hits: paths between perfect
/// mirrors end, too.
pub const MAX_SURVIVAL: f64 = 0.95;

/// Returns the survival probability of walks: the largest channel of the throughput, at most 1 at
/// `early` hits and [`MAX_SURVIVAL`] at others.
///
/// A survivor's largest channel is then 1 (or the throughput divided by 0.95), so weights stay
/// bounded and the variance finite wherever albedos are at most 0.95. `throughput` is without the
/// radiance factors of refraction, which cancel when the path leaves the glass; the path tracer's
/// is relative to [`REFERENCE_THROUGHPUT`].
#[inline]
pub fn by_throughput<V: Vector>(throughput: V, early: MaskOf<V>) -> V::Real {
    let [one, max] = [1.0, MAX_SURVIVAL].map(V::Real::splat);
    throughput
        .max_element()
        .minimum(V::Real::select(early, one, max))
}

/// Number of first hits of `render`'s path tracer at which survival may reach 1: ending a bright
/// path early makes the remaining paths to the same light brighter. Glass and mirrors on the way to
/// a lamp take two or three.
pub const RR_DEPTH: u32 = 8;

/// Throughput at which survival in the path tracer is 1 (or the maximum); fainter paths survive
/// with probability proportional to it. Paths that have lost little throughput continue, so that
/// their number stays even over the image. Walks whose every vertex is connected to others, and
/// particles, use 1: for them more vertices cost more than they gain.
pub const REFERENCE_THROUGHPUT: f64 = 0.5;

/// Returns the report's survival probability 1 − α, with the absorption α of the surface.
#[inline]
pub fn by_absorption<R: Real>(absorption: R) -> R {
    R::splat(1.0) - absorption
}

/// Replaceable parts of Russian roulette.
pub trait Roulette: Sync {
    /// Returns the survival probability of walks, from the throughput relative to that of certain
    /// survival, at an early hit or not.
    #[inline]
    fn survival_by_throughput(&self, throughput: DVec3, early: bool) -> f64 {
        by_throughput(throughput, early)
    }
    /// Returns the report's survival probability.
    #[inline]
    fn survival_by_absorption(&self, absorption: f64) -> f64 {
        by_absorption(absorption)
    }
    /// Returns whether a path survives.
    #[inline]
    fn survives(&self, r: f64, survival: f64) -> bool {
        survives(r, survival)
    }
    /// Returns the factor of a survivor's throughput.
    #[inline]
    fn roulette_weight(&self, survival: f64) -> f64 {
        weight(survival)
    }
    /// Returns the number that decides the next game of a survivor.
    #[inline]
    fn rescaled(&self, r: f64, survival: f64) -> f64 {
        rescaled(r, survival)
    }
}
