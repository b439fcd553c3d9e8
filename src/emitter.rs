//! Surfaces that emit, and how shadow rays pick points on them.

use glam::DVec3;

use crate::sampling;
use crate::shape::{Sphere, triangle_point};

/// The shape of an emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EmitterShape {
    /// A parallelogram: a corner and the two edges that leave it. It emits along `edges[0] × edges[1]`.
    Rectangle {
        /// The corner.
        corner: DVec3,
        /// The edges.
        edges: [DVec3; 2],
    },
    /// A triangle; emits to the side from which its vertices run counter-clockwise.
    Triangle([DVec3; 3]),
    /// A sphere or a zone of it; emits to the side of its normal.
    Sphere(Sphere),
}

/// A diffuse emitter: the same radiance in all directions of its front, nothing behind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emitter {
    /// Its shape.
    pub shape: EmitterShape,
    /// Radiance L_e, per colour channel.
    pub radiance: DVec3,
    /// Its area.
    pub area: f64,
    /// The unit normal of the front of a flat shape; not used for spheres.
    normal: DVec3,
}

/// A point on an emitter, uniform with respect to area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmitterPoint {
    /// The point.
    pub point: DVec3,
    /// The unit normal of its front.
    pub normal: DVec3,
}

impl Emitter {
    /// An emitter of the given shape and radiance.
    pub fn new(shape: EmitterShape, radiance: DVec3) -> Self {
        let (area, normal) = match shape {
            EmitterShape::Rectangle { edges: [a, b], .. } => {
                let across = a.cross(b);
                (across.length(), across.normalize_or_zero())
            }
            EmitterShape::Triangle([a, b, c]) => {
                let across = (b - a).cross(c - a);
                (0.5 * across.length(), across.normalize_or_zero())
            }
            EmitterShape::Sphere(sphere) => (sphere.area(), DVec3::ZERO),
        };
        Self {
            shape,
            radiance,
            area,
            normal,
        }
    }

    /// Maps two uniform numbers to a point; its pdf with respect to area is 1/area.
    #[inline]
    pub fn sample(&self, random: [f64; 2]) -> EmitterPoint {
        match self.shape {
            EmitterShape::Rectangle { corner, edges } => EmitterPoint {
                point: corner + random[0] * edges[0] + random[1] * edges[1],
                normal: self.normal,
            },
            EmitterShape::Triangle(vertices) => {
                let [u, v] = sampling::triangle(random);
                EmitterPoint {
                    point: triangle_point(vertices, u, v),
                    normal: self.normal,
                }
            }
            EmitterShape::Sphere(sphere) => {
                let offset = sampling::sphere_zone(random, sphere.radius, sphere.heights());
                let point = sphere.centre + offset;
                EmitterPoint {
                    point,
                    normal: sphere.normal(point),
                }
            }
        }
    }

    /// The pdf of [`sample`](Self::sample) with respect to area.
    #[inline]
    pub fn pdf_area(&self) -> f64 {
        1.0 / self.area
    }
}
