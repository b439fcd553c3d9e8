//! Numbers and vectors for which equations are written: of a single ray, or of several rays in SIMD
//! lanes.
//!
//! An equation is written once, as a function of any [`Real`] or [`Vector`]. Each operation of
//! [`Lanes`](super::simd::Lanes) rounds as that of `f64` does, lane by lane, and no two are ever
//! fused, so a function has the same bits for a ray alone and for the same ray in a lane;
//! `tests/library/lanes` compares them. [`Singles`](super::simd::Singles) round to single
//! precision, [`crate::equation::SINGLE_PRECISION`]; `tests/library/single_precision.rs` bounds the
//! error.

use std::fmt::Debug;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use glam::DVec3;

/// A boolean for one ray or for each lane.
pub trait Mask:
    Copy + Debug + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self>
{
    /// Returns whether any lane is set.
    fn any(self) -> bool;
    /// Creates a mask from a function of the lane.
    fn from_fn(lane: impl Fn(usize) -> bool) -> Self;
    /// Returns one bit for each lane; the first is the lowest.
    fn bits(self) -> u32;

    /// Creates a mask from one bit for each lane; the first is the lowest.
    #[inline]
    fn from_bits(bits: u32) -> Self {
        Self::from_fn(|i| bits >> i & 1 == 1)
    }
    /// Creates a mask with all lanes set or none.
    #[inline]
    fn splat(all: bool) -> Self {
        Self::from_fn(|_| all)
    }
    /// Returns the boolean of a lane.
    #[inline]
    fn lane(self, lane: usize) -> bool {
        self.bits() >> lane & 1 == 1
    }
}

/// A real number of one ray, or one for each lane.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
{
    /// Result of comparisons.
    type Mask: Mask;
    /// Vector of three numbers.
    type Vector: Vector<Real = Self>;

    /// Whether operations round to single precision rather than double.
    const IS_SINGLE: bool;

    /// Returns the first number in double precision, the second in single precision.
    #[inline]
    fn by_precision(double: f64, single: f64) -> Self {
        Self::splat(if Self::IS_SINGLE { single } else { double })
    }
    /// Creates a number that is the same for every ray.
    fn splat(value: f64) -> Self;
    /// Creates a number from a function of the lane, rounded.
    fn from_lanes(lane: impl Fn(usize) -> f64) -> Self;
    /// Creates a vector from a function of the lane, rounded.
    fn vector_from_lanes(lane: impl Fn(usize) -> DVec3) -> Self::Vector;
    /// Returns the number of a lane.
    fn lane(self, lane: usize) -> f64;
    /// Returns the square root, correctly rounded.
    fn sqrt(self) -> Self;
    /// Returns the magnitude.
    fn abs(self) -> Self;
    /// Returns the magnitude of this number with the sign of another.
    fn copysign(self, sign: Self) -> Self;
    /// Returns the largest integer that is not above.
    fn floor(self) -> Self;
    /// Returns whether self < other; false for NaN.
    fn cmplt(self, other: Self) -> Self::Mask;
    /// Returns whether self = other; false for NaN.
    fn cmpeq(self, other: Self) -> Self::Mask;
    /// Returns `yes` in the lanes of the mask, and `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// Returns whether self > other; false for NaN.
    #[inline]
    fn cmpgt(self, other: Self) -> Self::Mask {
        other.cmplt(self)
    }
    /// Returns the maximum of this number and `bound`; the bound for NaN.
    #[inline]
    fn maximum(self, bound: Self) -> Self {
        Self::select(self.cmpgt(bound), self, bound)
    }
    /// Returns the minimum of this number and `bound`; the bound for NaN.
    #[inline]
    fn minimum(self, bound: Self) -> Self {
        Self::select(self.cmplt(bound), self, bound)
    }
    /// Returns 1/self.
    #[inline]
    fn recip(self) -> Self {
        Self::splat(1.0) / self
    }
}

/// Mask of the lanes of a vector.
pub type MaskOf<V> = <<V as Vector>::Real as Real>::Mask;

/// A vector of three numbers of one ray, or one vector for each lane.
pub trait Vector:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + Mul<Self::Real, Output = Self>
{
    /// Number type of the components.
    type Real: Real;

    /// Creates a vector from its components.
    fn of(components: [Self::Real; 3]) -> Self;
    /// Returns the components.
    fn components(self) -> [Self::Real; 3];
    /// Creates a vector from a function of the lane, rounded.
    fn from_fn(lane: impl Fn(usize) -> DVec3) -> Self;

    /// Returns the third component.
    #[inline]
    fn z(self) -> Self::Real {
        let [_, _, z] = self.components();
        z
    }
    /// Returns the vector of a lane.
    #[inline]
    fn lane(self, lane: usize) -> DVec3 {
        let [x, y, z] = self.components();
        DVec3::new(x.lane(lane), y.lane(lane), z.lane(lane))
    }

    /// Creates a vector that is the same for every ray.
    #[inline]
    fn splat_vector(value: DVec3) -> Self {
        let [x, y, z] = value.to_array();
        Self::of([Real::splat(x), Real::splat(y), Real::splat(z)])
    }
    /// Returns the vector whose components are 0.
    #[inline]
    fn zero() -> Self {
        Self::splat_vector(DVec3::ZERO)
    }
    /// Returns whether all components are 0.
    #[inline]
    fn is_zero(self) -> MaskOf<Self> {
        let zero = Self::Real::splat(0.0);
        let [x, y, z] = self.components();
        x.cmpeq(zero) & y.cmpeq(zero) & z.cmpeq(zero)
    }
    /// Returns the scalar product.
    #[inline]
    fn dot(self, other: Self) -> Self::Real {
        let [[a, b, c], [x, y, z]] = [self.components(), other.components()];
        a * x + b * y + c * z
    }
    /// Returns ‖v‖².
    #[inline]
    fn length_squared(self) -> Self::Real {
        self.dot(self)
    }
    /// Returns v/‖v‖.
    #[inline]
    fn normalize(self) -> Self {
        self * self.length_squared().sqrt().recip()
    }
    /// Returns the largest component.
    #[inline]
    fn max_element(self) -> Self::Real {
        let [x, y, z] = self.components();
        x.maximum(y.maximum(z))
    }
    /// Returns `yes` in the lanes of the mask, and `no` elsewhere.
    #[inline]
    fn select(mask: MaskOf<Self>, yes: Self, no: Self) -> Self {
        let [[a, b, c], [x, y, z]] = [yes.components(), no.components()];
        Self::of([
            Real::select(mask, a, x),
            Real::select(mask, b, y),
            Real::select(mask, c, z),
        ])
    }
}

impl Mask for bool {
    #[inline]
    fn any(self) -> bool {
        self
    }
    #[inline]
    fn from_fn(lane: impl Fn(usize) -> bool) -> Self {
        lane(0)
    }
    #[inline]
    fn bits(self) -> u32 {
        self.into()
    }
}

impl Real for f64 {
    type Mask = bool;
    type Vector = DVec3;

    const IS_SINGLE: bool = false;

    #[inline]
    fn splat(value: f64) -> Self {
        value
    }
    #[inline]
    fn from_lanes(lane: impl Fn(usize) -> f64) -> Self {
        lane(0)
    }
    #[inline]
    fn vector_from_lanes(lane: impl Fn(usize) -> DVec3) -> DVec3 {
        lane(0)
    }
    #[inline]
    fn lane(self, _: usize) -> f64 {
        self
    }
    #[inline]
    fn sqrt(self) -> Self {
        self.sqrt()
    }
    #[inline]
    fn abs(self) -> Self {
        self.abs()
    }
    #[inline]
    fn copysign(self, sign: Self) -> Self {
        self.copysign(sign)
    }
    #[inline]
    fn floor(self) -> Self {
        self.floor()
    }
    #[inline]
    fn cmplt(self, other: Self) -> bool {
        self < other
    }
    #[inline]
    fn cmpeq(self, other: Self) -> bool {
        self == other
    }
    #[inline]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
}

impl Vector for DVec3 {
    type Real = f64;

    #[inline]
    fn of(components: [f64; 3]) -> Self {
        Self::from_array(components)
    }
    #[inline]
    fn components(self) -> [f64; 3] {
        self.to_array()
    }
    #[inline]
    fn from_fn(lane: impl Fn(usize) -> DVec3) -> Self {
        lane(0)
    }
}

/// Returns sin and cos of 2π times a fraction of a turn in [0, 1], the same in any lane; within
/// 4·10⁻¹⁶ of the true values, in single precision within 2·10⁻⁷.
///
/// The fraction minus the nearest quarter turn is exact and at most 1/8. The Taylor series of that
/// angle, at most π/4, are truncated where the remainder is below 5·10⁻¹⁷, in single precision
/// 2·10⁻⁹.
#[inline]
pub fn sin_cos_of_turn<R: Real>(share: R) -> (R, R) {
    let quarter = (share * 4.0 + 0.5).floor();
    let x = (share - quarter * 0.25) * std::f64::consts::TAU;
    let x2 = x * x;
    let series = |terms: &[f64]| {
        terms
            .iter()
            .fold(R::splat(0.0), |sum, &term| sum * x2 + term)
    };
    let left_out = if R::IS_SINGLE { 3 } else { 0 };
    let sin = x * (series(&SIN[left_out..]) * x2 + 1.0);
    let cos = series(&COS[left_out..]) * x2 + 1.0;
    // After an odd number of quarter turns sin and cos are swapped; signs change in the second half
    // of each.
    let odd = (quarter - (quarter * 0.5).floor() * 2.0).cmpgt(R::splat(0.5));
    let half = |turned: R| (turned - (turned * 0.25).floor() * 4.0).cmpgt(R::splat(1.5));
    let signed = |value: R, negative: R::Mask| R::select(negative, -value, value);
    (
        signed(R::select(odd, cos, sin), half(quarter)),
        signed(R::select(odd, sin, cos), half(quarter + 1.0)),
    )
}

/// Coefficients (−1)ᵏ/(2k + 1)! from k = 7 down to 1.
const SIN: [f64; 7] = [
    -1.0 / 1_307_674_368_000.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 39_916_800.0,
    1.0 / 362_880.0,
    -1.0 / 5_040.0,
    1.0 / 120.0,
    -1.0 / 6.0,
];

/// Coefficients (−1)ᵏ/(2k)! from k = 8 down to 1.
const COS: [f64; 8] = [
    1.0 / 20_922_789_888_000.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 479_001_600.0,
    -1.0 / 3_628_800.0,
    1.0 / 40_320.0,
    -1.0 / 720.0,
    1.0 / 24.0,
    -1.0 / 2.0,
];
