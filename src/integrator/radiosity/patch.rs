//! Patches and the form factors from points to them.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use super::FiniteElements;
use crate::geometry::form_factor::Polygon;
use crate::geometry::shape::SurfacePoint;
use crate::integrator::NextEvent;
use crate::material::Scattering;

/// One side of a piece of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Patch {
    /// A polygon, counter-clockwise seen from its side.
    Flat {
        /// Corners.
        polygon: Polygon,
        /// Unit normal of its side.
        normal: DVec3,
    },
    /// A part of a sphere.
    Curved(SpherePatch),
}

/// A part of a sphere between two circles of latitude and two meridians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpherePatch {
    /// Centre of the sphere.
    pub centre: DVec3,
    /// Radius of the sphere.
    pub radius: f64,
    /// Upper and lower height above the centre as fractions of the radius.
    pub heights: [f64; 2],
    /// Azimuths of the meridians, radians.
    pub azimuths: [f64; 2],
    /// Whether this is the outer side.
    pub outward: bool,
}

/// Unoccluded view of a patch from a point.
pub(super) struct PatchView {
    /// Form factor.
    pub factor: f64,
    /// A point in the middle of the visible part.
    pub target: SurfacePoint,
}

/// The parts of a sphere's patch that have been added up.
struct PartialView {
    /// Sum of the form factors.
    factor: f64,
    /// Largest form factor of a part.
    largest: f64,
    /// Midpoint of that part.
    target: SurfacePoint,
}

/// Distance from a patch's plane, relative to the point's distance, below which a point is in the
/// plane.
const PLANE_TOLERANCE: f64 = 1e-9;
/// Form factors below this are rounding errors of slivers at the horizon.
const MIN_FORM_FACTOR: f64 = 1e-12;
/// Ratio of area to squared distance above which parts of a sphere's patch are divided.
const SUBDIVISION_RATIO: f64 = 1.0 / 16.0;
/// Returns whether a part with this area at this squared distance is divided.
#[inline]
pub fn is_near(area: f64, distance_squared: f64) -> bool {
    area > SUBDIVISION_RATIO * distance_squared
}

/// Maximum depth of division; closer parts are integrated coarsely.
const MAX_SUBDIVISIONS: u32 = 3;

impl Patch {
    /// Creates the front (or back) of a triangle or a parallelogram.
    pub(super) fn flat<const N: usize>(mut corners: [DVec3; N], front: bool) -> Self {
        if !front {
            corners.reverse();
        }
        let normal = (corners[1] - corners[0])
            .cross(corners[2] - corners[0])
            .normalize();
        Self::Flat {
            polygon: Polygon::new(&corners),
            normal,
        }
    }

    /// Returns the unit normal at a point of the patch.
    pub fn normal(&self, point: DVec3) -> DVec3 {
        match self {
            Self::Flat { normal, .. } => *normal,
            Self::Curved(patch) => patch.normal(point),
        }
    }

    /// Returns the area; for a sphere's patch that of the curved surface.
    pub fn area(&self) -> f64 {
        match self {
            Self::Flat { polygon, .. } => {
                let corners = polygon.corners();
                let pairs = corners.iter().zip(corners.iter().cycle().skip(1));
                0.5 * pairs.map(|(a, b)| a.cross(*b)).sum::<DVec3>().length()
            }
            Self::Curved(patch) => patch.area(),
        }
    }

    /// Returns the unoccluded view of the patch from a point with a unit normal; `None` if one is
    /// behind the other.
    #[inline]
    pub(super) fn view<P: FiniteElements + NextEvent + Scattering + ?Sized>(
        &self,
        parts: &P,
        point: DVec3,
        normal: DVec3,
    ) -> Option<PatchView> {
        match self {
            Self::Flat {
                polygon,
                normal: own,
            } => {
                let offset = polygon.corners()[0] - point;
                if -offset.dot(*own) <= PLANE_TOLERANCE * offset.length() {
                    return None;
                }
                let seen = parts.clip_to_horizon(normal, &polygon.relative_to(point));
                if seen.corners().len() < 3 {
                    return None;
                }
                let factor = parts.form_factor(normal, seen.corners());
                // NaN must not count as faint.
                let faint = factor <= MIN_FORM_FACTOR;
                (!faint).then(|| PatchView {
                    factor,
                    target: SurfacePoint::new(point + seen.centroid(), *own),
                })
            }
            Self::Curved(patch) => patch.view(parts, point, normal),
        }
    }
}

impl SpherePatch {
    fn normal(&self, point: DVec3) -> DVec3 {
        let outward = (point - self.centre) / self.radius;
        if self.outward { outward } else { -outward }
    }

    /// Returns R² times height times azimuth (Archimedes).
    fn area(&self) -> f64 {
        let [high, low] = self.heights;
        let [from, to] = self.azimuths;
        self.radius * self.radius * (high - low) * (to - from)
    }

    /// Returns the point at fractions of the height (from above) and of the azimuth, uniform in
    /// area.
    fn point(&self, down: f64, around: f64) -> DVec3 {
        let [high, low] = self.heights;
        let [from, to] = self.azimuths;
        let z = high + down * (low - high);
        let (sin, cos) = (from + around * (to - from)).sin_cos();
        let rho = (1.0 - z * z).max(0.0).sqrt();
        self.centre + self.radius * DVec3::new(rho * cos, rho * sin, z)
    }

    /// Returns the 2 × 2 Gauss points.
    pub(super) fn nodes(&self) -> [DVec3; 4] {
        let [low, high] = gauss();
        [[low, low], [low, high], [high, low], [high, high]].map(|[s, t]| self.point(s, t))
    }

    /// Returns the nodes' weights of bilinear interpolation at a height and azimuth.
    pub(super) fn weights(&self, height: f64, azimuth: f64) -> [f64; 4] {
        let share = |[from, to]: [f64; 2], x: f64| (x - from) / (to - from);
        let [low, high] = gauss();
        let linear = |x: f64| [(high - x) / (high - low), (x - low) / (high - low)];
        let down = linear(share(self.heights, height));
        let around = linear(share(self.azimuths, azimuth));
        [
            down[0] * around[0],
            down[0] * around[1],
            down[1] * around[0],
            down[1] * around[1],
        ]
    }

    /// Splits the patch into four parts of equal area.
    fn quarters(&self) -> [Self; 4] {
        let middle = |[a, b]: [f64; 2]| 0.5 * (a + b);
        let [z, phi] = [middle(self.heights), middle(self.azimuths)];
        let halves = |[a, b]: [f64; 2], m: f64| [[a, m], [m, b]];
        let [upper, lower] = halves(self.heights, z);
        let [left, right] = halves(self.azimuths, phi);
        [(upper, left), (upper, right), (lower, left), (lower, right)].map(|(heights, azimuths)| {
            Self {
                heights,
                azimuths,
                ..*self
            }
        })
    }

    /// Computes the form factor by the midpoint rule, exact from the sphere's own inside, where the
    /// integrand is constant.
    fn view<P: FiniteElements + NextEvent + Scattering + ?Sized>(
        &self,
        parts: &P,
        point: DVec3,
        normal: DVec3,
    ) -> Option<PatchView> {
        let distance = (point - self.centre).length();
        if self.outward && distance <= self.radius * (1.0 + PLANE_TOLERANCE) {
            return None;
        }
        let mut found = PartialView {
            factor: 0.0,
            largest: 0.0,
            target: SurfacePoint::new(DVec3::ZERO, DVec3::ZERO),
        };
        self.add(parts, point, normal, MAX_SUBDIVISIONS, &mut found);
        let PartialView { factor, target, .. } = found;
        (factor > MIN_FORM_FACTOR).then_some(PatchView { factor, target })
    }

    /// Adds the form factor of a part, which is divided if it is near.
    fn add<P: FiniteElements + NextEvent + Scattering + ?Sized>(
        &self,
        parts: &P,
        point: DVec3,
        normal: DVec3,
        divisions: u32,
        found: &mut PartialView,
    ) {
        let y = self.point(0.5, 0.5);
        let area = self.area();
        let offset = y - point;
        let distance_squared = offset.length_squared();
        if divisions > 0 && parts.is_near(area, distance_squared) {
            for quarter in self.quarters() {
                quarter.add(parts, point, normal, divisions - 1, found);
            }
            return;
        }
        let direction = offset / distance_squared.sqrt();
        let own = self.normal(y);
        let cosine = parts.cosine(normal, direction);
        let across = parts.cosine(own, -direction);
        let factor =
            cosine * parts.solid_angle_per_area(across, distance_squared) * area * FRAC_1_PI;
        found.factor += factor;
        if factor > found.largest {
            found.largest = factor;
            found.target = SurfacePoint::new(y, own);
        }
    }
}

/// Returns the two Gauss points in [0, 1].
fn gauss() -> [f64; 2] {
    let half = 0.5 / 3f64.sqrt();
    [0.5 - half, 0.5 + half]
}
