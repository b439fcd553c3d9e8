//! SIMD numbers of several rays: eight in double precision, sixteen in single precision.

use std::array::from_fn;
use std::fmt::Debug;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use glam::DVec3;
use wide::{f32x4, f32x8, f32x16, f64x4, f64x8};

pub use super::lanes3::{Axes, Lanes3, PermuteAxes};
use super::real::{Mask, Real, Vector};

/// Number of rays in [`Lanes`].
pub const LANES: usize = 8;

/// A number for each of [`LANES`] rays, in double precision.
pub type Lanes = f64x8;

/// A number for each of [`FOUR`] triangles that one ray is tested against, in double precision.
pub type Four = f64x4;

/// Number of triangles in [`Four`].
pub const FOUR: usize = 4;

/// Number of rays in [`Singles`].
pub const SINGLES: usize = 16;

/// Numbers of `N` rays.
pub trait Wide<const N: usize>: Real<Vector: PermuteAxes> {
    /// Number type of a single lane.
    type Scalar: Scalar;
    /// Numbers in single precision with the same lane count, if there are several lanes.
    type Single: Wide<N>;

    /// Creates a number from those of all lanes.
    fn from_array(lanes: [Self::Scalar; N]) -> Self;
    /// Returns the numbers of all lanes.
    fn lanes(self) -> [Self::Scalar; N];

    /// Returns each lane as an integer; the lanes are integers below 2³¹.
    fn to_u32(self) -> [u32; N];
    /// Creates a number that is the same in each lane.
    #[inline]
    fn splat_scalar(number: Self::Scalar) -> Self {
        Self::from_array([number; N])
    }
    /// Transposes a row of numbers for each lane; the length is a multiple of eight.
    fn transpose<const K: usize>(rows: [&AlignedArray<Self::Scalar, K>; N]) -> [Self; K];
    /// Rounds to single precision.
    #[inline]
    fn single(self) -> Self::Single {
        Self::Single::from_array(
            self.lanes()
                .map(|number| Scalar::from_single(number.single())),
        )
    }
}

/// Applies a function to each of at least one element, as [`array::map`], which is not always
/// inlined.
#[inline]
pub(crate) fn map_array<T: Copy, U: Copy, const N: usize>(
    array: [T; N],
    f: impl Fn(T) -> U,
) -> [U; N] {
    let mut mapped = [f(array[0]); N];
    let mut i = 1;
    while i < N {
        mapped[i] = f(array[i]);
        i += 1;
    }
    mapped
}

/// Cache-line-aligned array: the row of one lane is gathered with a few loads.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct AlignedArray<T, const K: usize>(pub [T; K]);

/// A number of one lane.
pub trait Scalar: Copy + Debug + Default + Into<f64> + PartialEq + Send + Sync + 'static {
    /// A number for each of [`FOUR`] triangles that one ray is tested against.
    type Four: Wide<FOUR, Scalar = Self>;

    /// Whether the type is of single precision.
    const IS_SINGLE: bool;

    /// Rounds to the nearest number of this type.
    fn rounded(number: f64) -> Self;
    /// Returns the number in [0, 1) that a generator makes of 64 bits.
    fn unit(word: u64) -> Self;
    /// Converts to single precision.
    fn single(self) -> f32;
    /// Converts from single precision.
    fn from_single(number: f32) -> Self;
}

/// A single ray.
impl Wide<1> for f64 {
    type Scalar = Self;
    type Single = Self;

    #[inline]
    fn from_array([number]: [Self; 1]) -> Self {
        number
    }
    #[inline]
    fn lanes(self) -> [Self; 1] {
        [self]
    }
    #[inline]
    fn to_u32(self) -> [u32; 1] {
        [self as u32]
    }
    #[inline]
    fn transpose<const K: usize>([row]: [&AlignedArray<Self, K>; 1]) -> [Self; K] {
        row.0
    }
}

impl Scalar for f64 {
    type Four = Four;

    const IS_SINGLE: bool = false;

    #[inline]
    fn rounded(number: f64) -> Self {
        number
    }
    #[inline]
    fn unit(word: u64) -> Self {
        (word >> 11) as Self * (1.0 / (1u64 << 53) as Self)
    }
    #[inline]
    fn single(self) -> f32 {
        self as f32
    }
    #[inline]
    fn from_single(number: f32) -> Self {
        number.into()
    }
}

impl Scalar for f32 {
    type Four = FourSingles;

    const IS_SINGLE: bool = true;

    #[inline]
    fn rounded(number: f64) -> Self {
        number as Self
    }
    #[inline]
    fn unit(word: u64) -> Self {
        (word >> 40) as Self * (1.0 / (1u64 << 24) as Self)
    }
    #[inline]
    fn single(self) -> f32 {
        self
    }
    #[inline]
    fn from_single(number: f32) -> Self {
        number
    }
}

/// Converts an integer-valued number below 2³² to an integer: the last bits of this sum. A
/// conversion would first test the range.
#[inline]
fn last_bits(number: f64) -> u32 {
    (number + (1u64 << 52) as f64).to_bits() as u32
}

/// Implements [`Real`] and [`Wide`] for a double- or single-precision type of `wide`, and its mask.
macro_rules! lanes {
    ($number:ty, $wrap:expr, $inner:expr, $wide:ty, $scalar:ty, $bits:ty, $count:literal, $single:ty,
     $mask:ident, $is_single:literal, $part:ty, $to_u32:expr) => {
        /// A boolean for each of several rays.
        #[derive(Clone, Copy, Debug)]
        pub struct $mask($wide);

        impl BitAnd for $mask {
            type Output = Self;

            #[inline]
            fn bitand(self, other: Self) -> Self {
                Self(self.0 & other.0)
            }
        }

        impl BitOr for $mask {
            type Output = Self;

            #[inline]
            fn bitor(self, other: Self) -> Self {
                Self(self.0 | other.0)
            }
        }

        impl Not for $mask {
            type Output = Self;

            #[inline]
            fn not(self) -> Self {
                Self(!self.0)
            }
        }

        impl Mask for $mask {
            #[inline]
            fn any(self) -> bool {
                self.0.any()
            }
            #[inline]
            fn from_fn(lane: impl Fn(usize) -> bool) -> Self {
                let mut numbers = [0.0; $count];
                for i in 0..$count {
                    if lane(i) {
                        numbers[i] = <$scalar>::from_bits(<$bits>::MAX);
                    }
                }
                Self(<$wide>::new(numbers))
            }
            #[inline]
            fn bits(self) -> u32 {
                self.0.to_bitmask()
            }
            #[inline]
            fn from_bits(bits: u32) -> Self {
                // Numbers in [1, 2), of which each lane compares its own bit.
                const ONE: $bits = (1.0 as $scalar).to_bits();
                const OWN_BITS: $wide = {
                    let (mut lanes, mut i) = ([0.0; $count], 0);
                    while i < $count {
                        lanes[i] = <$scalar>::from_bits(ONE | 1 << i);
                        i += 1;
                    }
                    <$wide>::new(lanes)
                };
                let all = <$wide>::splat(<$scalar>::from_bits(ONE | <$bits>::from(bits)));
                Self((all & OWN_BITS).simd_eq(OWN_BITS))
            }
        }

        impl Real for $number {
            type Mask = $mask;
            type Vector = Lanes3<Self>;

            const IS_SINGLE: bool = $is_single;

            #[inline]
            fn splat(value: f64) -> Self {
                $wrap(<$wide>::splat(value as $scalar))
            }
            #[inline]
            fn from_lanes(lane: impl Fn(usize) -> f64) -> Self {
                let mut numbers = [0.0; $count];
                for i in 0..$count {
                    numbers[i] = <$scalar>::rounded(lane(i));
                }
                Self::from_array(numbers)
            }
            #[inline]
            fn vector_from_lanes(lane: impl Fn(usize) -> DVec3) -> Lanes3<Self> {
                let mut components = [[0.0; $count]; 3];
                for i in 0..$count {
                    let vector = lane(i);
                    for k in 0..3 {
                        components[k][i] = <$scalar>::rounded(vector[k]);
                    }
                }
                Lanes3::of(map_array(components, Self::from_array))
            }
            #[inline]
            fn lane(self, lane: usize) -> f64 {
                self.lanes()[lane].into()
            }
            #[inline]
            fn sqrt(self) -> Self {
                $wrap($inner(self).sqrt())
            }
            #[inline]
            fn abs(self) -> Self {
                $wrap($inner(self).abs())
            }
            #[inline]
            fn copysign(self, sign: Self) -> Self {
                let bit = <$wide>::splat(-0.0);
                $wrap(($inner(self) & !bit) | ($inner(sign) & bit))
            }
            #[inline]
            fn floor(self) -> Self {
                $wrap($inner(self).floor())
            }
            #[inline]
            fn cmplt(self, other: Self) -> $mask {
                $mask($inner(self).simd_lt($inner(other)))
            }
            #[inline]
            fn cmpgt(self, other: Self) -> $mask {
                $mask($inner(self).simd_gt($inner(other)))
            }
            // On this architecture these are single instructions, which return the bound for NaN
            // and for two equal numbers.
            #[cfg(target_arch = "x86_64")]
            #[inline]
            fn maximum(self, bound: Self) -> Self {
                $wrap($inner(self).fast_max($inner(bound)))
            }
            #[cfg(target_arch = "x86_64")]
            #[inline]
            fn minimum(self, bound: Self) -> Self {
                $wrap($inner(self).fast_min($inner(bound)))
            }
            #[inline]
            fn cmpeq(self, other: Self) -> $mask {
                $mask($inner(self).simd_eq($inner(other)))
            }
            #[inline]
            fn select(mask: $mask, yes: Self, no: Self) -> Self {
                $wrap(mask.0.select($inner(yes), $inner(no)))
            }
        }

        impl Wide<$count> for $number {
            type Scalar = $scalar;
            type Single = $single;

            #[inline]
            fn from_array(lanes: [$scalar; $count]) -> Self {
                $wrap(<$wide>::new(lanes))
            }
            #[inline]
            fn lanes(self) -> [$scalar; $count] {
                $inner(self).to_array()
            }
            #[inline]
            fn to_u32(self) -> [u32; $count] {
                $to_u32($inner(self))
            }
            #[inline]
            fn transpose<const K: usize>(rows: [&AlignedArray<$scalar, K>; $count]) -> [Self; K] {
                const PART: usize = size_of::<$part>() / size_of::<$scalar>();
                const { assert!(K.is_multiple_of(PART)) }
                let mut columns = [[<$part>::splat(0.0); $count / PART]; K];
                // Squares of columns are transposed in registers.
                for (square, columns) in columns.as_chunks_mut::<PART>().0.iter_mut().enumerate() {
                    for part in 0..$count / PART {
                        let row =
                            |i: usize| <$part>::new(rows[part * PART + i].0.as_chunks().0[square]);
                        let transposed = <$part>::transpose(from_fn(row));
                        for i in 0..PART {
                            columns[i][part] = transposed[i];
                        }
                    }
                }
                map_array(columns, |parts| $wrap(bytemuck::cast(parts)))
            }
        }
    };
}

/// Defines a single-precision number type on top of a type of `wide`.
macro_rules! singles {
    ($(#[$what:meta])* $number:ident, $wide:ty, $count:literal, $mask:ident, $part:ty) => {
        $(#[$what])*
        #[derive(Clone, Copy, Debug)]
        pub struct $number($wide);

        lanes!($number, $number, (|number: $number| number.0), $wide, f32, u32, $count, $number, $mask, true, $part,
            (|number: $wide| map_array(number.fast_trunc_int().to_array(), i32::cast_unsigned)));

        singles!(operator $number, Add, add, +);
        singles!(operator $number, Sub, sub, -);
        singles!(operator $number, Mul, mul, *);
        singles!(operator $number, Div, div, /);

        impl Neg for $number {
            type Output = Self;

            #[inline]
            fn neg(self) -> Self {
                Self(-self.0)
            }
        }
    };
    (operator $number:ident, $trait:ident, $name:ident, $sign:tt) => {
        impl $trait for $number {
            type Output = Self;

            #[inline]
            fn $name(self, other: Self) -> Self {
                Self(self.0 $sign other.0)
            }
        }

        impl $trait<f64> for $number {
            type Output = Self;

            #[inline]
            fn $name(self, other: f64) -> Self {
                self $sign Self::splat(other)
            }
        }
    };
}

lanes!(
    Lanes,
    (|number| number),
    (|number: Lanes| number),
    f64x8,
    f64,
    u64,
    8,
    EightSingles,
    LaneMask,
    false,
    f64x4,
    (|number: Lanes| map_array(number.lanes(), last_bits))
);
lanes!(
    Four,
    (|number| number),
    (|number: Four| number),
    f64x4,
    f64,
    u64,
    4,
    FourSingles,
    FourMask,
    false,
    f64x4,
    (|number: Four| map_array(number.lanes(), last_bits))
);

singles! {
    /// A number for each of [`SINGLES`] rays, in single precision.
    Singles, f32x16, 16, SinglesMask, f32x8
}

singles! {
    /// A number for each of [`LANES`] rays, in single precision.
    EightSingles, f32x8, 8, EightSinglesMask, f32x8
}

singles! {
    /// A number for each of [`FOUR`] triangles, in single precision.
    FourSingles, f32x4, 4, FourSinglesMask, f32x4
}

/// The lanes whose bits are set.
#[inline]
pub(crate) fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (lane < 32).then_some(lane)
    })
}
