//! Precision in which a subject computes, and how far rounding may move its values.
//!
//! A right function in floating point returns nearly the exact value for nearly the given arguments
//! (backward error analysis: Higham 2002, "Accuracy and Stability of Numerical Algorithms", section
//! 1.5). So its precision explains an error of a few roundings, plus the change of its values where
//! its arguments move by a few roundings.

use std::collections::BTreeSet;

use glam::DVec3;

use super::outcome::Outcome;
use super::pointwise::{LargestError, POINTWISE_TOLERANCE, relative};

/// Unit roundoff of double precision, 2⁻⁵³: the largest relative error of one rounding.
pub const DOUBLE: f64 = f64::EPSILON / 2.0;
/// Unit roundoff of single precision, 2⁻²⁴.
pub const SINGLE: f64 = f32::EPSILON as f64 / 2.0;

/// Largest number of roundings of one value.
const VALUE_ROUNDINGS: f64 = 64.0;
/// Largest error of components of directions, and of cosines, in roundings of 1.
const DIRECTION_ROUNDINGS: f64 = 16.0;
/// Half of an error of one percent. Where rounding may explain a larger relative error, nothing is
/// judged.
pub(crate) const MAX_ROUNDING_ERROR: f64 = 5e-3;
/// Relative change of arguments that shows whether a function computes in double precision: less
/// than single precision can hold.
pub(crate) const ARGUMENT_STEP: f64 = 1e-11;
/// Number of different values that show a precision; fewer may be simple fractions, such as
/// probabilities.
const MIN_DISTINCT_VALUES: usize = 100;

/// Returns whether a quantity is computed in single precision, from its values at different
/// arguments, each with the value for arguments moved by [`ARGUMENT_STEP`]. Either all are numbers
/// of single precision, or most do not change.
fn is_single_precision(values: &[[f64; 2]]) -> bool {
    let nonzero = || {
        values
            .iter()
            .filter(|[value, _]| value.is_finite() && *value != 0.0)
    };
    let distinct: BTreeSet<u64> = nonzero().map(|[value, _]| value.to_bits()).collect();
    let stored = || nonzero().all(|[value, _]| f64::from(*value as f32) == *value);
    let unchanged = || {
        nonzero()
            .filter(|[value, stepped]| value == stepped)
            .count()
            * 10
            >= nonzero().count() * 9
    };
    distinct.len() >= MIN_DISTINCT_VALUES && (stored() || unchanged())
}

/// Returns the unit roundoff in which a subject computes: [`SINGLE`] if the values of one of its
/// quantities show it, else [`DOUBLE`]. Each value stands with that for arguments moved by
/// [`ARGUMENT_STEP`].
pub(crate) fn unit_roundoff(quantities: &[Vec<[f64; 2]>]) -> f64 {
    if quantities.iter().any(|values| is_single_precision(values)) {
        SINGLE
    } else {
        DOUBLE
    }
}

/// Bounds for the values of a subject that computes in some precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RoundoffBounds {
    unit: f64,
}

impl RoundoffBounds {
    /// Creates bounds for a unit roundoff; at least [`DOUBLE`], also for NaN.
    pub fn new(unit: f64) -> Self {
        Self {
            unit: unit.max(DOUBLE),
        }
    }

    /// Returns whether the precision is coarser than double.
    pub fn is_coarse(self) -> bool {
        self.unit > DOUBLE
    }

    /// Returns the unit roundoff.
    pub fn unit(self) -> f64 {
        self.unit
    }

    /// Returns whether a direction is so near to the horizon that rounding may have put it there,
    /// where densities are zero; never in double precision.
    pub fn at_horizon(self, direction: DVec3) -> bool {
        self.is_coarse() && direction.z.abs() <= self.tolerance()
    }

    /// Returns the |z| below which rounding may put directions onto the horizon, or their products
    /// with others round to 0: the root of a rounded 1 − r² is off by as much.
    pub fn horizon(self) -> f64 {
        8.0 * self.unit.sqrt()
    }

    /// Returns the precision in words.
    pub fn words(self) -> String {
        match self.unit {
            DOUBLE => String::from("double precision"),
            SINGLE => String::from("single precision"),
            other => format!("a precision of {other:.1e}"),
        }
    }

    /// Returns the relative error of a value, or the error of a unit vector's length, that rounding
    /// explains whatever the arguments.
    pub fn tolerance(self) -> f64 {
        POINTWISE_TOLERANCE.max(VALUE_ROUNDINGS * self.unit)
    }

    /// Rounds a number of [0, 1) to this precision: down, so that it stays below 1, and above 0 if
    /// it was.
    pub fn round_down(self, uniform: f64) -> f64 {
        if !self.is_coarse() || uniform <= 0.0 {
            return uniform;
        }
        let last_digit = 2.0 * self.unit * uniform.log2().floor().exp2();
        (uniform / last_digit).floor() * last_digit
    }

    /// Returns the difference relative to the larger magnitude; 0 for numbers too small for the
    /// digits of single precision.
    pub fn relative(self, a: f64, b: f64) -> f64 {
        let vanishes =
            self.is_coarse() && a.abs().max(b.abs()) < f64::from(f32::MIN_POSITIVE) / self.unit;
        if vanishes { 0.0 } else { relative(a, b) }
    }

    /// Returns errors of a direction by rounding: each component by 16 roundings of 1, up and down.
    pub fn steps(self) -> [DVec3; 6] {
        let step = DIRECTION_ROUNDINGS * self.unit;
        [
            DVec3::X,
            DVec3::Y,
            DVec3::Z,
            -DVec3::X,
            -DVec3::Y,
            -DVec3::Z,
        ]
        .map(|axis| step * axis)
    }

    /// Returns the relative change of a value where its arguments move as rounding may: directions
    /// by [`steps`](Self::steps), and the cosine to the normal, to the other direction and to its
    /// mirror image by four times as much, as the cosine of a half vector is four times as
    /// sensitive. Infinite if unknown.
    pub fn conditioning(self, wo: DVec3, wi: DVec3, value: &dyn Fn(DVec3, DVec3) -> f64) -> f64 {
        let here = value(wo, wi);
        let step = DIRECTION_ROUNDINGS * self.unit;
        let turns = [DVec3::Z, wo, DVec3::new(-wo.x, -wo.y, wo.z)]
            .into_iter()
            .flat_map(|axis| [4.0 * step, -4.0 * step].map(|change| turned(wi, axis, change)));
        let moved = self
            .steps()
            .into_iter()
            .flat_map(|by| [(wo + by, wi), (wo, wi + by)])
            .chain(turns.map(|turned| (wo, turned)));
        moved
            .map(|(wo, wi)| ((value(wo, wi) - here) / here).abs())
            .fold(0.0, |most, change| {
                if change.is_nan() {
                    f64::INFINITY
                } else {
                    change.max(most)
                }
            })
    }

    /// Scales a relative error so that [`RoundoffBounds::tolerance`] is the largest that rounding
    /// explains, given the conditioning there. `None` where rounding might explain more than
    /// [`MAX_ROUNDING_ERROR`], so that an error of one percent would not be detected.
    pub fn excess(self, error: f64, conditioning: impl FnOnce() -> f64) -> Option<f64> {
        let tolerance = self.tolerance();
        // NaN is judged.
        if !self.is_coarse() || error.is_nan() || error <= tolerance {
            return Some(error);
        }
        let bound = tolerance + conditioning();
        (bound <= MAX_ROUNDING_ERROR).then(|| error * tolerance / bound)
    }

    /// Returns the outcome of an identity by its largest error over `judged` arguments; undecided
    /// if more of them (`skipped`) could not be judged.
    pub fn outcome(self, name: &str, judged: u64, skipped: u64, largest: LargestError) -> Outcome {
        let LargestError { error, place } = largest;
        let outcome = Outcome::identity(name, judged, error, self.tolerance(), place);
        if judged < skipped && outcome.p > 0.0 {
            let why = format!(
                "in {} rounding explains more than half a percent at most places",
                self.words()
            );
            return outcome.undecided(&why, u64::MAX);
        }
        outcome
    }
}

/// Turns a direction in the plane of the axis so that its cosine to the axis changes by `change`,
/// as far as possible.
fn turned(direction: DVec3, axis: DVec3, change: f64) -> DVec3 {
    let cosine = direction.dot(axis);
    let across = (direction - cosine * axis)
        .try_normalize()
        .unwrap_or_else(|| axis.any_orthonormal_vector());
    let cosine = (cosine + change).clamp(-1.0, 1.0);
    cosine * axis + (1.0 - cosine * cosine).sqrt() * across
}
