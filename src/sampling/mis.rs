//! Multiple importance sampling: strategies for direct light, and how their samples are weighted.

use crate::math::real::Real;

/// How direct light at a diffuse surface is sampled. Each strategy counts it once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Strategy {
    /// BSDF sampling: paths hit emitters by chance.
    Bsdf,
    /// Next-event estimation with points on emitters. With points uniform in area its variance is
    /// infinite in corners of emitting rooms: the geometry term has no bound.
    Light,
    /// Both, weighted by a [`Heuristic`].
    #[default]
    Mis,
}

/// Heuristic of multiple importance sampling; none changes the mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Heuristic {
    /// [`NextEvent::mis_weight`](crate::integrator::NextEvent::mis_weight).
    #[default]
    Balance,
    /// [`NextEvent::mis_power_weight`](crate::integrator::NextEvent::mis_power_weight).
    Power,
}

/// Returns the weight of a sample by the balance heuristic of [`crate::equation::MIS`]: it was
/// drawn with `pdf`, and another strategy would draw it with `other`, with respect to the same
/// measure.
#[inline]
pub fn balance<R: Real>(pdf: R, other: R) -> R {
    (ratio(other, pdf) + 1.0).recip()
}

/// Returns the weight of a sample by the power heuristic with exponent 2,
/// [`crate::equation::MIS_POWER`], with arguments as in [`balance`]. The ratio is squared, not the
/// pdfs, so that none overflows.
#[inline]
pub fn power<R: Real>(pdf: R, other: R) -> R {
    let ratio = ratio(other, pdf);
    (ratio * ratio + 1.0).recip()
}

/// Returns a/b in [0, ∞] for a, b in [0, ∞], where 0/0 and ∞/∞ are 1, so that weights sum to one
/// there, too.
#[inline]
fn ratio<R: Real>(a: R, b: R) -> R {
    R::select(a.cmpeq(b), R::splat(1.0), a / b)
}
