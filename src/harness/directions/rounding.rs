//! Precision of a subject's numbers, and the directions that may round to a given one.

use glam::DVec3;
use rand::Rng;

use super::density::Density;
use crate::math::frame::{Frame, from_spherical};
use crate::sampling::rng::uniform;

/// Rounding of a number when it was computed or written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rounding {
    /// Half a unit of the last decimal, or the error of a computation; at least 0.
    pub absolute: f64,
    /// Half a unit of the last digit of the significand, for a significand in [1, `base`).
    pub relative: f64,
    /// Base of the significand: 2, or 10 for printed numbers.
    pub base: f64,
}

impl Rounding {
    /// Numbers computed in double precision.
    pub const DOUBLE: Self = Self {
        absolute: 0.0,
        relative: 0.5 * f64::EPSILON,
        base: 2.0,
    };
    /// Numbers computed in single precision, with errors of a few roundings: 2⁻²² absolute and
    /// relative.
    pub const SINGLE: Self = Self {
        absolute: SINGLE_ERROR,
        relative: SINGLE_ERROR,
        base: 2.0,
    };
    /// Numbers stored in half precision, with 11 bits.
    pub const HALF: Self = Self {
        absolute: SINGLE_ERROR,
        relative: 1.0 / 2048.0,
        base: 2.0,
    };

    /// Numbers printed with `decimals` decimals, the largest with `digits` significant digits.
    pub fn printed(decimals: i32, digits: i32) -> Self {
        Self {
            absolute: 0.5 * 10f64.powi(-decimals),
            relative: 0.5 * 10f64.powi(1 - digits),
            base: 10.0,
        }
    }

    /// Returns how far the exact number may be from `value`.
    pub fn half_width(&self, value: f64) -> f64 {
        if value == 0.0 {
            return self.absolute;
        }
        let exponent = (value.abs().ln() / self.base.ln() + 1e-12).floor();
        self.absolute.max(self.relative * self.base.powf(exponent))
    }
}

/// Precision of a sampler's output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Precision {
    /// Precision of the components of directions.
    pub direction: Rounding,
    /// Precision of weights.
    pub weight: Rounding,
    /// Precision of reported pdfs.
    pub pdf: Rounding,
}

impl Precision {
    /// All numbers computed in double precision.
    pub const DOUBLE: Self = Self {
        direction: Rounding::DOUBLE,
        weight: Rounding::DOUBLE,
        pdf: Rounding::DOUBLE,
    };
    /// All numbers computed in single precision.
    pub const SINGLE: Self = Self {
        direction: Rounding::SINGLE,
        weight: Rounding::SINGLE,
        pdf: Rounding::SINGLE,
    };

    /// Returns whether directions are so exact that rounding matters only at the border of the
    /// density's support.
    fn is_fine(&self) -> bool {
        self.direction.half_width(0.75) < FINE_ROUNDING
    }

    /// Returns how far the length of a direction may be from 1.
    pub fn length_tolerance(&self) -> f64 {
        1e-4f64.max(1.01 * 3f64.sqrt() * self.direction.half_width(0.99))
    }
}

/// Error of a component computed in single precision: four halves of its last bit.
const SINGLE_ERROR: f64 = 1.0 / 4_194_304.0;
/// Rounding below which directions are taken as they are.
const FINE_ROUNDING: f64 = 1e-8;
/// Number of directions rounding to the same numbers among which one is drawn from the density.
const CANDIDATES: usize = 8;
/// Number of attempts to find these candidates, and number of attempts within three times the
/// distance before the density counts as zero at a sample.
const MAX_ATTEMPTS: [usize; 2] = [200, 2000];

/// Draws from the density a direction among those that round to `raw`, so that rounded samples of
/// the density follow it exactly. `None` if the density is zero within the rounding, and, where
/// `thorough`, within three times as much.
pub(super) fn unrounded(
    density: &Density,
    precision: &Precision,
    raw: DVec3,
    thorough: bool,
    rng: &mut impl Rng,
) -> Option<DVec3> {
    let unit = raw.normalize();
    let weight = |w: DVec3| {
        let pdf = density.pdf(w);
        if pdf > 0.0 && pdf.is_finite() && density.fine_grid.contains(w) {
            pdf
        } else {
            0.0
        }
    };
    let fine = precision.is_fine();
    if fine && weight(unit) > 0.0 {
        return Some(unit);
    }
    let half = DVec3::from_array(
        raw.to_array()
            .map(|value| precision.direction.half_width(value).max(SINGLE_ERROR)),
    );
    let disc = DirectionDisc {
        unit,
        radius: half.length() + raw.distance(unit),
    };
    let (mut chosen, mut total, mut found) = (None, 0.0, 0);
    for _ in 0..MAX_ATTEMPTS[0] {
        let turned = disc.sample_meridian(rng);
        let candidate = disc.sample(turned, 1.0, rng);
        if (candidate - raw - (turned - unit)).abs().cmple(half).all() {
            let pdf = weight(candidate);
            total += pdf;
            if pdf > 0.0 && uniform(rng) * total < pdf {
                chosen = Some(candidate);
            }
            found += 1;
        }
        if found == CANDIDATES {
            break;
        }
    }
    let further = if thorough { MAX_ATTEMPTS[1] } else { 0 };
    chosen.or_else(|| {
        (0..further)
            .map(|_| disc.sample(disc.sample_meridian(rng), 3.0, rng))
            .find(|&w| weight(w) > 0.0)
    })
}

/// Returns the least and the largest density within the rounding of a direction.
pub(super) fn density_range(density: &Density, precision: &Precision, raw: DVec3) -> [f64; 2] {
    let unit = raw.normalize();
    let half = raw
        .to_array()
        .map(|value| precision.direction.half_width(value));
    // The circle about the box, enlarged a little, as only few places are tried.
    let radius = 1.1 * (DVec3::from_array(half).length() + raw.distance(unit));
    let disc = DirectionDisc { unit, radius };
    let meridian = if precision.is_fine() {
        vec![unit]
    } else {
        [-1.0, 0.0, 1.0].map(|t| disc.turned(t, 0.0)).to_vec()
    };
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    for centre in meridian {
        let rim =
            (0..8).map(|i| disc.offset(centre, radius, std::f64::consts::TAU * f64::from(i) / 8.0));
        for w in rim.chain([centre]) {
            let pdf = density.pdf(w);
            range = [range[0].min(pdf), range[1].max(pdf)];
        }
    }
    range
}

/// Disc of directions near another one.
struct DirectionDisc {
    unit: DVec3,
    radius: f64,
}

impl DirectionDisc {
    /// Returns the direction with z moved by `share` of the error of single precision: samplers
    /// round the cosine first, which near the poles moves a direction by more than rounding its
    /// components would.
    fn turned(&self, share: f64, azimuth_at_pole: f64) -> DVec3 {
        let z = (self.unit.z + 0.5 * SINGLE_ERROR * share).clamp(-1.0, 1.0);
        let (x, y) = (self.unit.x, self.unit.y);
        let squared = x * x + y * y;
        if squared == 0.0 {
            return from_spherical(z.acos(), azimuth_at_pole);
        }
        let scale = ((1.0 - z * z) / squared).sqrt();
        DVec3::new(scale * x, scale * y, z)
    }

    fn sample_meridian(&self, rng: &mut impl Rng) -> DVec3 {
        let [share, turn] = [2.0 * uniform(rng) - 1.0, uniform(rng)];
        self.turned(share, std::f64::consts::TAU * turn)
    }

    /// Samples uniformly a disc of `radii` radii about a direction.
    fn sample(&self, centre: DVec3, radii: f64, rng: &mut impl Rng) -> DVec3 {
        let [r, turn] = [uniform(rng), uniform(rng)];
        self.offset(
            centre,
            radii * self.radius * r.sqrt(),
            std::f64::consts::TAU * turn,
        )
    }

    fn offset(&self, centre: DVec3, distance: f64, angle: f64) -> DVec3 {
        let frame = Frame::new(centre);
        let (sin, cos) = angle.sin_cos();
        (centre + distance * (cos * frame.x + sin * frame.y)).normalize()
    }
}
