//! Russian roulette, section 2.6.2: [`crate::equation::ROULETTE`].

use glam::DVec3;

use crate::math::real::{Real, Vector};

/// The path goes on if r < survival = 1 − α, for r uniform in [0, 1): exactly with that
/// probability.
#[inline]
pub fn survives<R: Real>(r: R, survival: R) -> R::Mask {
    r.below(survival)
}

/// What a survivor's throughput is multiplied by: 1/(1 − α).
#[inline]
pub fn weight<R: Real>(survival: R) -> R {
    survival.recip()
}

/// The highest survival of [`by_throughput`], but at early hits: paths between perfect mirrors end,
/// too.
pub const HIGHEST_SURVIVAL: f64 = 0.95;

/// The survival policy of walks: the largest channel of the throughput, at most 1 at `early` hits
/// and [`HIGHEST_SURVIVAL`] at others.
///
/// A survivor's largest channel is then 1 (or the throughput divided by 0.95), so weights stay
/// bounded and the variance finite wherever albedos are at most 0.95. `throughput` is without the
/// radiance factors of refraction, which cancel when the path leaves the glass; the path tracer's
/// is relative to [`RAISED`].
#[inline]
pub fn by_throughput<V: Vector>(throughput: V, early: <V::Real as Real>::Mask) -> V::Real {
    let [one, highest] = [1.0, HIGHEST_SURVIVAL].map(V::Real::splat);
    throughput
        .max_element()
        .at_most(V::Real::choose(early, one, highest))
}

/// So many hits of `render`'s path tracer are early: a bright path that is ended there for nothing
/// makes the others that find the same light brighter. Glass and mirrors on the way to a lamp make
/// two or three.
pub const EARLY: u32 = 8;

/// The throughput to which the path tracer raises the survivors among fainter paths: those that are
/// hardly fainter than they began go on, so that their number stays even over the image. Walks
/// whose every vertex is joined to others, and particles, raise theirs to 1: for them more vertices
/// cost more than they gain.
pub const RAISED: f64 = 0.5;

/// The report's policy: survival 1 − α with the absorption α of the surface.
#[inline]
pub fn by_absorption<R: Real>(absorption: R) -> R {
    R::splat(1.0) - absorption
}

/// The replaceable parts of Russian roulette.
pub trait Roulette: Sync {
    /// The survival policy of walks, of a throughput relative to what faint survivors are raised
    /// to, at an early hit or not.
    #[inline]
    fn survival_by_throughput(&self, throughput: DVec3, early: bool) -> f64 {
        by_throughput(throughput, early)
    }
    /// The report's survival policy.
    #[inline]
    fn survival_by_absorption(&self, absorption: f64) -> f64 {
        by_absorption(absorption)
    }
    /// Whether a path survives.
    #[inline]
    fn survives(&self, r: f64, survival: f64) -> bool {
        survives(r, survival)
    }
    /// What a survivor is multiplied by.
    #[inline]
    fn roulette_weight(&self, survival: f64) -> f64 {
        weight(survival)
    }

    /// Roulette by such a throughput with one uniform number; `None` if the path ends here, else
    /// what the survivor's throughput is multiplied by.
    #[inline]
    fn survive(&self, throughput: DVec3, early: bool, r: f64) -> Option<f64> {
        let survival = self.survival_by_throughput(throughput, early);
        self.survives(r, survival)
            .then(|| self.roulette_weight(survival))
    }
}
