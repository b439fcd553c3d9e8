//! Form factors: the fraction of a point's irradiance, under a hemisphere of radiance 1, that comes
//! from a surface of that radiance.
//!
//! Points are relative to the receiver.

use std::f64::consts::TAU;

use glam::DVec3;

/// A flat polygon of at most five corners: a rectangle after one cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polygon {
    corners: [DVec3; Self::MAX_CORNERS],
    count: usize,
}

impl Polygon {
    /// Largest number of corners.
    pub const MAX_CORNERS: usize = 5;

    /// Creates a polygon from its corners in order; those beyond [`MAX_CORNERS`](Self::MAX_CORNERS)
    /// are left out.
    pub fn new(corners: &[DVec3]) -> Self {
        let mut polygon = Self {
            corners: [DVec3::ZERO; Self::MAX_CORNERS],
            count: 0,
        };
        corners.iter().for_each(|&corner| polygon.push(corner));
        polygon
    }

    fn push(&mut self, corner: DVec3) {
        if let Some(place) = self.corners.get_mut(self.count) {
            *place = corner;
            self.count += 1;
        }
    }

    /// Returns the corners in order.
    pub fn corners(&self) -> &[DVec3] {
        &self.corners[..self.count]
    }

    /// Returns the polygon with its corners relative to a point.
    pub(crate) fn relative_to(&self, point: DVec3) -> Self {
        let mut polygon = *self;
        let corners = polygon.corners[..self.count].iter_mut();
        corners.for_each(|corner| *corner -= point);
        polygon
    }

    /// Returns the mean of the corners: a point of the polygon if it is convex and not empty.
    pub fn centroid(&self) -> DVec3 {
        self.corners().iter().sum::<DVec3>() / self.count as f64
    }

    /// Returns the part of a convex polygon of at most four corners above the plane through the
    /// receiver with this normal (Sutherland and Hodgman, CACM 17(1), 1974).
    pub fn clip_to_horizon(&self, normal: DVec3) -> Self {
        let corners = self.corners();
        let mut part = Self::new(&[]);
        for (i, &a) in corners.iter().enumerate() {
            let b = corners[(i + 1) % corners.len()];
            let [height_a, height_b] = [a, b].map(|v| normal.dot(v));
            if height_a >= 0.0 {
                part.push(a);
            }
            if (height_a >= 0.0) != (height_b >= 0.0) {
                part.push(a + (b - a) * (height_a / (height_a - height_b)));
            }
        }
        part
    }
}

/// Returns F from a point with a unit normal to a polygon above its horizon,
/// [`crate::equation::FORM_FACTOR`]: in [0, 1], positive if the corners run counter-clockwise as
/// seen from the point, negative otherwise. The irradiance from radiance L is πLF.
pub fn polygon(normal: DVec3, corners: &[DVec3]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    let sum: f64 = corners
        .iter()
        .zip(next)
        .map(|(a, b)| {
            let across = a.cross(*b);
            let length = across.length();
            // An edge that contains the point, or is seen end on, adds nothing.
            if length == 0.0 {
                return 0.0;
            }
            length.atan2(a.dot(*b)) * across.dot(normal) / length
        })
        .sum();
    sum / -TAU
}
