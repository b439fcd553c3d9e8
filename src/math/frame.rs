//! Orthonormal frames and spherical coordinates. Local directions have the normal as z.

use glam::DVec3;

use super::real::{Real, Vector};

/// A right-handed orthonormal frame around a unit normal.
#[derive(Clone, Copy, Debug)]
pub struct Frame<V = DVec3> {
    /// First tangent, local x.
    pub x: V,
    /// Second tangent, local y.
    pub y: V,
    /// The normal, local z.
    pub z: V,
}

impl<V: Vector> Frame<V> {
    /// Creates the frame of a unit normal, without branches or singularities (Duff et al.,
    /// "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017).
    #[inline]
    pub fn new(n: V) -> Self {
        let [x, y, z] = n.components();
        let sign = V::Real::splat(1.0).copysign(z);
        let a = V::Real::splat(-1.0) / (sign + z);
        let b = x * y * a;
        Self {
            x: V::of([sign * x * x * a + 1.0, sign * b, -sign * x]),
            y: V::of([b, sign + y * y * a, -y]),
            z: n,
        }
    }

    /// Converts from world to local coordinates.
    #[inline]
    pub fn local(&self, w: V) -> V {
        V::of([self.x.dot(w), self.y.dot(w), self.z.dot(w)])
    }

    /// Converts from local to world coordinates.
    #[inline]
    pub fn world(&self, w: V) -> V {
        let [x, y, z] = w.components();
        self.x * x + self.y * y + self.z * z
    }
}

/// Returns the unit vector with inclination θ from z and azimuth φ from x, radians.
pub fn from_spherical(theta: f64, phi: f64) -> DVec3 {
    let (sin_theta, cos_theta) = theta.sin_cos();
    let (sin_phi, cos_phi) = phi.sin_cos();
    DVec3::new(sin_theta * cos_phi, sin_theta * sin_phi, cos_theta)
}

/// Returns inclination θ in [0, π] and azimuth φ in [0, 2π) of a unit vector, radians.
pub fn to_spherical(w: DVec3) -> (f64, f64) {
    (w.x.hypot(w.y).atan2(w.z), azimuth(w))
}

/// Returns the azimuth φ in [0, 2π) of a vector, radians; angles just below 0 that would round to a
/// full turn are 0.
pub fn azimuth(w: DVec3) -> f64 {
    let phi = w.y.atan2(w.x);
    if phi >= 0.0 {
        return phi;
    }
    let turned = phi + std::f64::consts::TAU;
    if turned < std::f64::consts::TAU {
        turned
    } else {
        0.0
    }
}
