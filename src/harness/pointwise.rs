//! Random arguments of pointwise checks, and the worst error found over them.

use glam::DVec3;

use crate::math::frame::from_spherical;
use crate::sampling::rng::{Stream, uniform};
use crate::sampling::warp::uniform_hemisphere;

/// Relative tolerance of pointwise identities: a few hundred roundings.
pub const POINTWISE_TOLERANCE: f64 = 1e-9;
/// Cosine below which products of cosines in a BSDF's denominators lose the digits of
/// [`POINTWISE_TOLERANCE`].
pub const MIN_COSINE: f64 = 1e-4;

/// Largest error seen, and where.
#[derive(Default)]
pub struct LargestError {
    /// Largest error.
    pub error: f64,
    /// Place of the largest error, in words.
    pub place: String,
}

impl LargestError {
    /// Keeps the error if it is the largest so far; NaN counts as the largest, and stays.
    pub fn update(&mut self, error: f64, place: impl FnOnce() -> String) {
        if error.is_nan() || error > self.error {
            (self.error, self.place) = (error, place());
        }
    }
}

/// Returns the difference relative to the larger magnitude.
pub fn relative(a: f64, b: f64) -> f64 {
    if a == b {
        0.0
    } else {
        (a - b).abs() / a.abs().max(b.abs())
    }
}

/// Draws three uniform numbers in [0, 1).
pub fn uniform3(rng: &mut Stream) -> [f64; 3] {
    [uniform(rng), uniform(rng), uniform(rng)]
}

/// Samples a uniform direction of the hemisphere, or of the sphere, away from exact grazing.
pub(crate) fn inner_direction(rng: &mut Stream, both_sides: bool) -> DVec3 {
    loop {
        let w = uniform_hemisphere([uniform(rng), uniform(rng)]);
        if w.z > MIN_COSINE {
            return random_side(w, rng, both_sides);
        }
    }
}

/// Returns the direction or, if both sides count, with equal probability its opposite.
fn random_side(w: DVec3, rng: &mut Stream, both_sides: bool) -> DVec3 {
    if both_sides && uniform(rng) < 0.5 {
        -w
    } else {
        w
    }
}

/// Draws a random direction, often a corner: θ at 0, 1e-9 and near 90 degrees, φ at multiples of 45
/// degrees.
pub(crate) fn fuzzed_direction(rng: &mut Stream, both_sides: bool) -> DVec3 {
    const INCLINATIONS: [f64; 4] = [0.0, 1e-9, std::f64::consts::FRAC_PI_4, 1.570_795];
    let pick = (uniform(rng) * 8.0) as usize;
    let theta = INCLINATIONS
        .get(pick)
        .copied()
        .unwrap_or_else(|| uniform(rng) * std::f64::consts::FRAC_PI_2);
    let turn = uniform(rng);
    let phi = std::f64::consts::TAU
        * if pick.is_multiple_of(2) {
            (turn * 8.0).floor() / 8.0
        } else {
            turn
        };
    random_side(from_spherical(theta, phi), rng, both_sides)
}

/// Largest number below 1.
pub(crate) const ONE_MINUS_EPSILON: f64 = 1.0 - f64::EPSILON / 2.0;

/// Draws a number of [0, 1), often 0 or the largest.
pub(crate) fn fuzzed_number(rng: &mut Stream) -> f64 {
    let [pick, r] = [uniform(rng), uniform(rng)];
    if pick < 0.1 {
        0.0
    } else if pick < 0.2 {
        ONE_MINUS_EPSILON
    } else {
        r
    }
}
