//! Numbers and vectors that equations are written over: those of one ray, or of eight rays at once.
//!
//! An equation is written once, as a function of any [`Real`] or [`Vector`]. Each operation rounds as that of
//! `f64` does, lane by lane, and no two are ever fused, so a function has the same bits for a ray alone and
//! for the same ray in a lane; `tests/library/lanes.rs` compares them.

use std::fmt::Debug;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use glam::DVec3;
use wide::f64x8;

/// How many rays a [`Lanes`] number is of.
pub const LANES: usize = 8;

/// A number for each of [`LANES`] rays.
pub type Lanes = f64x8;

/// A yes or no for one ray or for each of several.
pub trait Mask: Copy + Debug + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// Whether it is yes for any.
    fn any(self) -> bool;
}

/// A real number of one ray, or one for each of several.
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
    /// What a comparison says.
    type Mask: Mask;
    /// Three of them.
    type Vector: Vector<Real = Self>;

    /// The same number for every ray.
    fn splat(value: f64) -> Self;
    /// The square root, correctly rounded.
    fn sqrt(self) -> Self;
    /// The magnitude.
    fn abs(self) -> Self;
    /// The magnitude of this number with the sign of another.
    fn copysign(self, sign: Self) -> Self;
    /// The largest whole number that is not above.
    fn floor(self) -> Self;
    /// Whether self < other; false for NaN.
    fn below(self, other: Self) -> Self::Mask;
    /// Whether self = other; false for NaN.
    fn equals(self, other: Self) -> Self::Mask;
    /// `yes` where the mask says so, else `no`.
    fn choose(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// Whether self > other; false for NaN.
    #[inline]
    fn above(self, other: Self) -> Self::Mask {
        other.below(self)
    }
    /// This number, but not below `bound`; the bound for NaN.
    #[inline]
    fn at_least(self, bound: Self) -> Self {
        Self::choose(self.above(bound), self, bound)
    }
    /// This number, but not above `bound`; the bound for NaN.
    #[inline]
    fn at_most(self, bound: Self) -> Self {
        Self::choose(self.below(bound), self, bound)
    }
    /// 1/self.
    #[inline]
    fn recip(self) -> Self {
        Self::splat(1.0) / self
    }
}

/// A vector of three numbers of one ray, or of each of several.
pub trait Vector:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + Mul<Self::Real, Output = Self>
{
    /// Its numbers.
    type Real: Real;

    /// From its components.
    fn of(components: [Self::Real; 3]) -> Self;
    /// Its components.
    fn components(self) -> [Self::Real; 3];

    /// The same vector for every ray.
    #[inline]
    fn splat_vector(value: DVec3) -> Self {
        Self::of(value.to_array().map(Real::splat))
    }
    /// The scalar product.
    #[inline]
    fn dot(self, other: Self) -> Self::Real {
        let [[a, b, c], [x, y, z]] = [self.components(), other.components()];
        a * x + b * y + c * z
    }
    /// ‖v‖².
    #[inline]
    fn length_squared(self) -> Self::Real {
        self.dot(self)
    }
    /// v/‖v‖.
    #[inline]
    fn normalize(self) -> Self {
        self * self.length_squared().sqrt().recip()
    }
    /// The largest component.
    #[inline]
    fn max_element(self) -> Self::Real {
        let [x, y, z] = self.components();
        x.at_least(y.at_least(z))
    }
    /// `yes` where the mask says so, else `no`.
    #[inline]
    fn choose(mask: <Self::Real as Real>::Mask, yes: Self, no: Self) -> Self {
        let [[a, b, c], [x, y, z]] = [yes.components(), no.components()];
        Self::of([Real::choose(mask, a, x), Real::choose(mask, b, y), Real::choose(mask, c, z)])
    }
}

impl Mask for bool {
    #[inline]
    fn any(self) -> bool {
        self
    }
}

impl Real for f64 {
    type Mask = bool;
    type Vector = DVec3;

    #[inline]
    fn splat(value: f64) -> Self {
        value
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
    fn below(self, other: Self) -> bool {
        self < other
    }
    #[inline]
    fn equals(self, other: Self) -> bool {
        self == other
    }
    #[inline]
    fn choose(mask: bool, yes: Self, no: Self) -> Self {
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
}

/// A yes or no for each of [`LANES`] rays.
#[derive(Clone, Copy, Debug)]
pub struct LaneMask(Lanes);

impl LaneMask {
    /// From one bit for each lane, the first is the lowest.
    #[inline]
    pub fn from_bits(bits: u32) -> Self {
        Self::from_fn(|i| bits >> i & 1 == 1)
    }

    /// The same for all lanes.
    #[inline]
    pub fn splat(all: bool) -> Self {
        Self::from_fn(|_| all)
    }

    /// From a yes or no for each lane.
    #[inline]
    pub fn from_fn(lane: impl Fn(usize) -> bool) -> Self {
        let number = |i: usize| if lane(i) { f64::from_bits(u64::MAX) } else { 0.0 };
        Self(Lanes::new([0, 1, 2, 3, 4, 5, 6, 7].map(number)))
    }

    /// All bits set for a lane of yes, none for one of no.
    #[inline]
    pub fn words(self) -> [u64; LANES] {
        self.0.to_array().map(f64::to_bits)
    }

    /// One bit for each lane, the first is the lowest.
    #[inline]
    pub fn bits(self) -> u32 {
        self.0.to_bitmask()
    }
}

impl BitAnd for LaneMask {
    type Output = Self;

    #[inline]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl BitOr for LaneMask {
    type Output = Self;

    #[inline]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl Not for LaneMask {
    type Output = Self;

    #[inline]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

impl Mask for LaneMask {
    #[inline]
    fn any(self) -> bool {
        self.0.any()
    }
}

impl Real for Lanes {
    type Mask = LaneMask;
    type Vector = Lanes3;

    #[inline]
    fn splat(value: f64) -> Self {
        f64x8::splat(value)
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
        let bit = f64x8::splat(-0.0);
        (self & !bit) | (sign & bit)
    }
    #[inline]
    fn floor(self) -> Self {
        self.floor()
    }
    #[inline]
    fn below(self, other: Self) -> LaneMask {
        LaneMask(self.simd_lt(other))
    }
    #[inline]
    fn above(self, other: Self) -> LaneMask {
        LaneMask(self.simd_gt(other))
    }
    // On this architecture these are single instructions, which take the bound for NaN and of two equal numbers.
    #[cfg(target_arch = "x86_64")]
    #[inline]
    fn at_least(self, bound: Self) -> Self {
        self.fast_max(bound)
    }
    #[cfg(target_arch = "x86_64")]
    #[inline]
    fn at_most(self, bound: Self) -> Self {
        self.fast_min(bound)
    }
    #[inline]
    fn equals(self, other: Self) -> LaneMask {
        LaneMask(self.simd_eq(other))
    }
    #[inline]
    fn choose(mask: LaneMask, yes: Self, no: Self) -> Self {
        mask.0.select(yes, no)
    }
}

/// A vector for each of [`LANES`] rays.
#[derive(Clone, Copy, Debug)]
pub struct Lanes3 {
    /// First components.
    pub x: Lanes,
    /// Second components.
    pub y: Lanes,
    /// Third components.
    pub z: Lanes,
}

impl Lanes3 {
    /// From the vector of each lane.
    #[inline]
    pub fn from_fn(lane: impl Fn(usize) -> DVec3) -> Self {
        let all = [0, 1, 2, 3, 4, 5, 6, 7].map(lane);
        Self::of([all.map(|v| v.x), all.map(|v| v.y), all.map(|v| v.z)].map(Lanes::new))
    }

    /// The vector of one lane.
    #[inline]
    pub fn lane(self, lane: usize) -> DVec3 {
        DVec3::from_array(self.components().map(|component| component.as_array()[lane]))
    }
}

impl Vector for Lanes3 {
    type Real = Lanes;

    #[inline]
    fn of([x, y, z]: [Lanes; 3]) -> Self {
        Self { x, y, z }
    }
    #[inline]
    fn components(self) -> [Lanes; 3] {
        [self.x, self.y, self.z]
    }
}

impl Add for Lanes3 {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl Sub for Lanes3 {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl Mul for Lanes3 {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        Self { x: self.x * other.x, y: self.y * other.y, z: self.z * other.z }
    }
}

impl Mul<Lanes> for Lanes3 {
    type Output = Self;

    #[inline]
    fn mul(self, factor: Lanes) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
}

impl Neg for Lanes3 {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}

/// sin and cos of 2π times a share of a turn in [0, 1], in any lane the same; within 4·10⁻¹⁶ of the true values.
///
/// The share less the nearest quarter turn is exact and at most 1/8. Of that angle, at most π/4, the Taylor
/// series are cut where what follows is below 5·10⁻¹⁷.
#[inline]
pub fn sin_cos_of_turn<R: Real>(share: R) -> (R, R) {
    let quarter = (share * 4.0 + 0.5).floor();
    let x = (share - quarter * 0.25) * std::f64::consts::TAU;
    let x2 = x * x;
    let series = |terms: &[f64]| terms.iter().fold(R::splat(0.0), |sum, &term| sum * x2 + term);
    let sin = x * (series(&SIN) * x2 + 1.0);
    let cos = series(&COS) * x2 + 1.0;
    // After an odd number of quarter turns they change places; signs change in the second half of each.
    let odd = (quarter - (quarter * 0.5).floor() * 2.0).above(R::splat(0.5));
    let half = |turned: R| (turned - (turned * 0.25).floor() * 4.0).above(R::splat(1.5));
    let signed = |value: R, negative: R::Mask| R::choose(negative, -value, value);
    (signed(R::choose(odd, cos, sin), half(quarter)), signed(R::choose(odd, sin, cos), half(quarter + 1.0)))
}

/// (−1)ᵏ/(2k + 1)! from k = 7 down to 1.
const SIN: [f64; 7] = [
    -1.0 / 1_307_674_368_000.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 39_916_800.0,
    1.0 / 362_880.0,
    -1.0 / 5_040.0,
    1.0 / 120.0,
    -1.0 / 6.0,
];

/// (−1)ᵏ/(2k)! from k = 8 down to 1.
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
