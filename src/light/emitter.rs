//! Emitters, and the sampling of points on them.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use crate::geometry::offsets::offset_in;
use crate::geometry::shape::{Sphere, SurfacePoint, triangle_point};
use crate::geometry::solid_angle::{SphericalRectangle, SphericalTriangle, VisibleCap};
use crate::math::real::{Real, Vector};
use crate::sampling::warp;

/// Shape of an emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EmitterShape {
    /// A parallelogram: a corner and the two edges that leave it. It emits along
    /// `edges[0] × edges[1]`.
    Rectangle {
        /// Corner.
        corner: DVec3,
        /// Edges.
        edges: [DVec3; 2],
    },
    /// A triangle; emits to the side from which its vertices run counter-clockwise.
    Triangle([DVec3; 3]),
    /// A sphere or a zone of it; emits to the side of its normal.
    Sphere(Sphere),
}

/// Shape of an emitter as seen from a point.
#[derive(Clone, Copy, Debug)]
pub enum SolidAngleShape {
    /// A rectangle.
    Rectangle(SphericalRectangle),
    /// A triangle.
    Triangle(SphericalTriangle),
    /// A sphere.
    Cap(VisibleCap),
}

impl SolidAngleShape {
    /// Returns the solid angle.
    #[inline]
    pub fn solid_angle(&self) -> f64 {
        match self {
            Self::Rectangle(rectangle) => rectangle.solid_angle,
            Self::Triangle(triangle) => triangle.solid_angle,
            Self::Cap(cap) => cap.solid_angle,
        }
    }

    /// Maps two uniform numbers to a point, uniformly in solid angle.
    #[inline]
    pub fn sample(&self, random: [f64; 2]) -> DVec3 {
        match self {
            Self::Rectangle(rectangle) => rectangle.sample(random),
            Self::Triangle(triangle) => triangle.sample(random),
            Self::Cap(cap) => cap.sample(random),
        }
    }
}

/// A diffuse emitter: uniform radiance in all directions of its front, none behind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emitter {
    /// Shape of the emitter.
    pub shape: EmitterShape,
    /// Radiance L_e, per colour channel.
    pub radiance: DVec3,
    /// Area of the emitter.
    pub area: f64,
    /// Unit normal of the front of a flat shape; unused for spheres.
    normal: DVec3,
    /// Centre of the shape.
    centre: DVec3,
    /// Radius of a sphere, or of the disc with the area of a flat shape.
    radius: f64,
    /// Height above a flat shape below which a point counts as lying on it, within rounding, and
    /// the shape has importance 0.
    margin: f64,
}

/// How shadow rays pick emitters, by [flux](crate::light::light_sampler::PowerLightSampler) unless
/// stated otherwise, and points on them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightSampling {
    /// Uniform with respect to area.
    #[default]
    Area,
    /// Uniform with respect to the solid angle under which the emitter is seen: rectangles,
    /// triangles and whole spheres from outside. All else falls back to area.
    SolidAngle,
    /// Spheres by solid angle, as at least half of a sphere is invisible, and flat emitters by
    /// area.
    SphereAngle,
    /// [`SphereAngle`](Self::SphereAngle), with emitters picked by
    /// [importance](Emitter::importance).
    Importance,
}

impl LightSampling {
    /// Returns whether an emitter is sampled by solid angle, where possible.
    #[inline]
    pub fn by_solid_angle(self, emitter: &Emitter) -> bool {
        match self {
            Self::Area => false,
            Self::SolidAngle => true,
            Self::SphereAngle | Self::Importance => {
                matches!(emitter.shape, EmitterShape::Sphere(_))
            }
        }
    }

    /// Returns whether one of `count` emitters is picked by importance rather than flux.
    #[inline]
    pub fn by_importance(self, count: usize) -> bool {
        self == Self::Importance && count > 1
    }
}

/// A point on an emitter, with the unit normal of the front.
pub type EmitterPoint<V = DVec3> = SurfacePoint<V>;

impl Emitter {
    /// Creates an emitter with this shape and radiance.
    pub fn new(shape: EmitterShape, radiance: DVec3) -> Self {
        let flat = |across: DVec3, area: f64, centre: DVec3| {
            (
                area,
                across.normalize_or_zero(),
                centre,
                (area * FRAC_1_PI).sqrt(),
            )
        };
        let (area, normal, centre, radius) = match shape {
            EmitterShape::Rectangle {
                corner,
                edges: [a, b],
            } => {
                let across = a.cross(b);
                flat(across, across.length(), corner + 0.5 * (a + b))
            }
            EmitterShape::Triangle([a, b, c]) => {
                let across = (b - a).cross(c - a);
                flat(across, 0.5 * across.length(), (a + b + c) / 3.0)
            }
            EmitterShape::Sphere(sphere) => {
                (sphere.area(), DVec3::ZERO, sphere.centre, sphere.radius)
            }
        };
        Self {
            shape,
            radiance,
            area,
            normal,
            centre,
            radius,
            margin: 0.0,
        }
    }

    /// Returns the emitter for a scene whose rays leave surfaces from this height above them.
    pub(crate) fn with_offset(self, offset: f64) -> Self {
        Self {
            margin: 2.0 * offset,
            ..self
        }
    }

    /// Returns the importance for a point, an estimate of its contribution, C of
    /// [`crate::equation::LIGHT_PICK`]: approximately the irradiance of a surface that faces the
    /// emitter, averaged over the colour channels. It is above 0 wherever the emitter's front can
    /// be seen, and 0 on the emitter itself, whether a point there is rounded to either side or a
    /// ray has just left it.
    ///
    /// For a flat emitter of area A and radius a = √(A/π), at distance d from its centre and height
    /// h above its plane, it is L A (h + a)²/(d² + a²)²: π L up close, and far away with the
    /// squared cosine, as a slanted emitter is occluded more often. For a sphere of radius r it is
    /// L A/4 / max(d², r²).
    #[inline]
    pub fn importance<V: Vector>(&self, from: V) -> V::Real {
        let all = V::Real::splat;
        let away = from - V::splat_vector(self.centre);
        let distance_squared = away.length_squared();
        let power = self.power();
        let squared = self.radius * self.radius;
        if let EmitterShape::Sphere(_) = self.shape {
            return all(0.25 * power) / distance_squared.maximum(all(squared));
        }
        let height = away.dot(V::splat_vector(self.normal));
        let slant = (height + self.radius) / (distance_squared + squared);
        V::Real::select(
            height.cmpgt(offset_in(self.margin)),
            slant * slant * power,
            all(0.0),
        )
    }

    /// Returns area times radiance, averaged over the colour channels: flux over π.
    #[inline]
    pub(crate) fn power(&self) -> f64 {
        self.radiance.element_sum() / 3.0 * self.area
    }

    /// Returns the data of a leaf of the light tree: area times radiance, the centre, and
    /// approximately the mean squared distance from it.
    pub(crate) fn tree_leaf(&self) -> (f64, DVec3, f64) {
        (self.power(), self.centre, self.radius * self.radius)
    }

    /// Maps two uniform numbers to a point; its pdf with respect to area is 1/area.
    #[inline(always)]
    pub fn sample<R: Real>(&self, random: [R; 2]) -> EmitterPoint<R::Vector> {
        let all = R::Vector::splat_vector;
        match self.shape {
            EmitterShape::Rectangle {
                corner,
                edges: [a, b],
            } => EmitterPoint {
                point: all(corner) + all(a) * random[0] + all(b) * random[1],
                normal: all(self.normal),
            },
            EmitterShape::Triangle(vertices) => {
                let [u, v] = warp::triangle(random);
                EmitterPoint {
                    point: triangle_point(vertices, u, v),
                    normal: all(self.normal),
                }
            }
            EmitterShape::Sphere(sphere) => {
                let offset = warp::sphere_zone(random, sphere.radius, sphere.heights());
                let point = all(sphere.centre) + offset;
                EmitterPoint {
                    point,
                    normal: sphere.normal(point),
                }
            }
        }
    }

    /// Returns the pdf of [`sample`](Self::sample) with respect to area.
    #[inline]
    pub fn pdf_area(&self) -> f64 {
        1.0 / self.area
    }

    /// Maps two uniform numbers to a point whose direction from `from` is uniform in the solid
    /// angle of the emitter's visible front, and returns its pdf with respect to solid angle, too;
    /// `None` where [`solid_angle_shape`](Self::solid_angle_shape) is.
    #[inline]
    pub fn sample_solid_angle(&self, from: DVec3, random: [f64; 2]) -> Option<(EmitterPoint, f64)> {
        let shape = self.solid_angle_shape(from)?;
        let point = shape.sample(random);
        let normal = match self.shape {
            EmitterShape::Sphere(sphere) => sphere.normal(point),
            EmitterShape::Rectangle { .. } | EmitterShape::Triangle(_) => self.normal,
        };
        Some((EmitterPoint { point, normal }, 1.0 / shape.solid_angle()))
    }

    /// Returns the pdf of [`sample_solid_angle`](Self::sample_solid_angle) with respect to solid
    /// angle.
    #[inline]
    pub fn pdf_solid_angle(&self, from: DVec3) -> Option<f64> {
        Some(1.0 / self.solid_angle_shape(from)?.solid_angle())
    }

    /// Samples as [`sample_solid_angle`](Self::sample_solid_angle) from several points, and returns
    /// the lanes in which it is possible; `None` except for whole spheres, as other shapes are
    /// sampled lane by lane.
    #[inline]
    pub(crate) fn sample_cap<R: Real>(
        &self,
        from: R::Vector,
        random: [R; 2],
    ) -> Option<(R::Mask, EmitterPoint<R::Vector>, R)> {
        let EmitterShape::Sphere(sphere) = self.shape else {
            return None;
        };
        let (cap, exists) = VisibleCap::of(from, &sphere)?;
        let point = cap.sample(random);
        Some((
            exists,
            EmitterPoint {
                point,
                normal: sphere.normal(point),
            },
            cap.solid_angle.recip(),
        ))
    }

    /// Returns the pdf of [`sample_cap`](Self::sample_cap).
    #[inline]
    pub(crate) fn pdf_cap<R: Real>(&self, from: R::Vector) -> Option<(R::Mask, R)> {
        let EmitterShape::Sphere(sphere) = self.shape else {
            return None;
        };
        let (cap, exists) = VisibleCap::of(from, &sphere)?;
        Some((exists, cap.solid_angle.recip()))
    }

    /// Returns the emitter's shape as seen from a point; `None` from behind or within, for zones
    /// and insides of spheres, parallelograms without right angles, and emitters that are too
    /// small.
    #[inline]
    pub fn solid_angle_shape(&self, from: DVec3) -> Option<SolidAngleShape> {
        match self.shape {
            EmitterShape::Rectangle { corner, edges } => {
                SphericalRectangle::new(from, corner, edges).map(SolidAngleShape::Rectangle)
            }
            EmitterShape::Triangle(vertices) => {
                SphericalTriangle::new(from, vertices).map(SolidAngleShape::Triangle)
            }
            EmitterShape::Sphere(ref sphere) => {
                VisibleCap::new(from, sphere).map(SolidAngleShape::Cap)
            }
        }
    }
}
