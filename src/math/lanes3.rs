//! Vectors of several rays, and the order of the axes along rays.

use std::fmt::Debug;
use std::ops::{Add, Mul, Neg, Sub};

use glam::DVec3;
use wide::f64x8;

use super::real::{Real, Vector};

/// An order of the axes in which the one nearest to a ray's direction is the last, and the frame
/// right-handed.
pub trait Axes<R>: Copy + Debug {
    /// Returns the components in this order.
    fn permuted(self, components: [R; 3]) -> [R; 3];
}

/// Axis order of one ray, as indices.
impl<R: Copy> Axes<R> for [usize; 3] {
    #[inline]
    fn permuted(self, components: [R; 3]) -> [R; 3] {
        self.map(|axis| components[axis])
    }
}

/// Axis order of several rays: masks of those whose last axis is the first, or the second.
impl<R: Real> Axes<R> for [R::Mask; 2] {
    #[inline]
    fn permuted(self, [x, y, z]: [R; 3]) -> [R; 3] {
        let [is_x, is_y] = self;
        let pick = |if_x, if_y, if_z| R::select(is_x, if_x, R::select(is_y, if_y, if_z));
        [pick(y, z, x), pick(z, x, y), pick(x, y, z)]
    }
}

/// Vectors whose axes can be permuted so that the one nearest to a direction is the last.
pub trait PermuteAxes: Vector {
    /// Type of the axis order.
    type Axes: Axes<Self::Real>;

    /// Returns the axis order for a direction.
    fn axes(direction: Self) -> Self::Axes;
}

impl PermuteAxes for DVec3 {
    type Axes = [usize; 3];

    #[inline]
    fn axes(direction: Self) -> Self::Axes {
        let [x, y, z] = direction.to_array().map(f64::abs);
        let last = if x > y && x > z {
            0
        } else if y > z {
            1
        } else {
            2
        };
        let next = |axis| if axis == 2 { 0 } else { axis + 1 };
        [next(last), next(next(last)), last]
    }
}

impl<R: Real<Vector = Self>> PermuteAxes for Lanes3<R> {
    type Axes = [R::Mask; 2];

    #[inline]
    fn axes(direction: Self) -> Self::Axes {
        let [x, y, z] = direction.components().map(Real::abs);
        let is_x = x.cmpgt(y) & x.cmpgt(z);
        [is_x, !is_x & y.cmpgt(z)]
    }
}

/// A vector for each of several rays.
#[derive(Clone, Copy, Debug)]
pub struct Lanes3<R = f64x8> {
    /// First components.
    pub x: R,
    /// Second components.
    pub y: R,
    /// Third components.
    pub z: R,
}

impl<R: Real<Vector = Self>> Vector for Lanes3<R> {
    type Real = R;

    #[inline]
    fn of([x, y, z]: [R; 3]) -> Self {
        Self { x, y, z }
    }
    #[inline]
    fn components(self) -> [R; 3] {
        [self.x, self.y, self.z]
    }
    #[inline]
    fn from_fn(lane: impl Fn(usize) -> DVec3) -> Self {
        R::vector_from_lanes(lane)
    }
}

impl<R: Real> Add for Lanes3<R> {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self {
            x: self.x + other.x,
            y: self.y + other.y,
            z: self.z + other.z,
        }
    }
}

impl<R: Real> Sub for Lanes3<R> {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        Self {
            x: self.x - other.x,
            y: self.y - other.y,
            z: self.z - other.z,
        }
    }
}

impl<R: Real> Mul for Lanes3<R> {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        Self {
            x: self.x * other.x,
            y: self.y * other.y,
            z: self.z * other.z,
        }
    }
}

impl<R: Real> Mul<R> for Lanes3<R> {
    type Output = Self;

    #[inline]
    fn mul(self, factor: R) -> Self {
        Self {
            x: self.x * factor,
            y: self.y * factor,
            z: self.z * factor,
        }
    }
}

impl<R: Real> Neg for Lanes3<R> {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self {
            x: -self.x,
            y: -self.y,
            z: -self.z,
        }
    }
}
