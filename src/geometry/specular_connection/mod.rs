//! Specular connections between two points through one caster, and their geometry terms.

mod sphere;

use glam::DVec3;

use crate::geometry::shape::SurfacePoint;
use crate::math::real::{Mask, MaskOf, Real, Vector};
pub use sphere::SphereConnections;
use sphere::geometry_term_of_sphere;

/// Kinds of specular scattering at a caster.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CasterKind {
    /// Reflection at the front of a flat mirror.
    Flat,
    /// Reflection at the outside of a sphere of mirror or glass.
    Reflection,
    /// Refraction through a sphere of glass.
    Refraction,
}

impl CasterKind {
    /// Returns the number of scattering events at the caster.
    pub fn bounces(self) -> u32 {
        if self == Self::Refraction { 2 } else { 1 }
    }
}

/// Parameters of a specular caster, for one ray or one per lane.
#[derive(Clone, Copy, Debug)]
pub struct Caster<V: Vector> {
    /// Centre of a sphere, or of a flat mirror.
    pub centre: V,
    /// Radius of a sphere.
    pub radius: V::Real,
    /// Area of a flat mirror.
    pub area: V::Real,
    /// Unit normal of the front of a flat mirror; zero for spheres.
    pub normal: V,
    /// 1/n (sine inside over sine outside) for refraction; else zero.
    pub inverse_ior: V::Real,
    /// Refractive index n of glass; 0 for mirrors.
    pub index: V::Real,
    /// Reflectance of mirrors.
    pub reflectance: V,
    /// Selection weight of the caster, before its solid angle.
    pub selection_weight: V::Real,
}

impl<V: Vector> Caster<V> {
    /// Returns the same caster for every ray.
    #[inline]
    pub fn splat(caster: &Caster<DVec3>) -> Self {
        let (vector, all) = (V::splat_vector, V::Real::splat);
        Self {
            centre: vector(caster.centre),
            radius: all(caster.radius),
            area: all(caster.area),
            normal: vector(caster.normal),
            inverse_ior: all(caster.inverse_ior),
            index: all(caster.index),
            reflectance: vector(caster.reflectance),
            selection_weight: all(caster.selection_weight),
        }
    }
}

/// A specular connection from x through a caster to y.
#[derive(Clone, Copy, Debug)]
pub struct SpecularConnection<V: Vector> {
    /// Whether the connection exists, apart from occlusion.
    pub exists: MaskOf<V>,
    /// Unit direction at x.
    pub direction: V,
    /// Unit direction of arrival at y.
    pub arriving: V,
    /// First point on the caster.
    pub first: SurfacePoint<V>,
    /// Last point on the caster; for reflections equal to `first`.
    pub last: SurfacePoint<V>,
    /// cos α ≥ 0, between the normal and the connection outside.
    pub cosine: V::Real,
    /// Generalized geometry term dω/dA⊥ of [`crate::equation::SPECULAR_SPREAD`]: solid angle at x
    /// per perpendicular area at y.
    pub geometry_term: V::Real,
}

impl<V: Vector> SpecularConnection<V> {
    /// Returns the connection of a lane.
    pub(crate) fn lane(&self, lane: usize) -> SpecularConnection<DVec3> {
        SpecularConnection {
            exists: self.exists.lane(lane),
            direction: self.direction.lane(lane),
            arriving: self.arriving.lane(lane),
            first: self.first.lane(lane),
            last: self.last.lane(lane),
            cosine: self.cosine.lane(lane),
            geometry_term: self.geometry_term.lane(lane),
        }
    }

    /// Collects the connections of all lanes; `None` means that a lane has none.
    pub(crate) fn from_lanes(
        connection: impl Fn(usize) -> Option<SpecularConnection<DVec3>>,
    ) -> Self {
        let vector = |of: fn(&SpecularConnection<DVec3>) -> DVec3| {
            V::from_fn(|i| connection(i).map_or(DVec3::Z, |connection| of(&connection)))
        };
        let number = |of: fn(&SpecularConnection<DVec3>) -> f64| {
            V::Real::from_lanes(|i| connection(i).map_or(1.0, |connection| of(&connection)))
        };
        Self {
            exists: Mask::from_fn(|i| connection(i).is_some_and(|connection| connection.exists)),
            direction: vector(|connection| connection.direction),
            arriving: vector(|connection| connection.arriving),
            first: SurfacePoint::new(
                vector(|connection| connection.first.point),
                vector(|connection| connection.first.normal),
            ),
            last: SurfacePoint::new(
                vector(|connection| connection.last.point),
                vector(|connection| connection.last.normal),
            ),
            cosine: number(|connection| connection.cosine),
            geometry_term: number(|connection| connection.geometry_term),
        }
    }

    /// Returns `yes` in the lanes of the mask, and `no` elsewhere.
    #[inline]
    pub(crate) fn select(mask: MaskOf<V>, yes: Self, no: Self) -> Self {
        Self {
            exists: (mask & yes.exists) | (!mask & no.exists),
            direction: V::select(mask, yes.direction, no.direction),
            arriving: V::select(mask, yes.arriving, no.arriving),
            first: SurfacePoint::select(mask, yes.first, no.first),
            last: SurfacePoint::select(mask, yes.last, no.last),
            cosine: V::Real::select(mask, yes.cosine, no.cosine),
            geometry_term: V::Real::select(mask, yes.geometry_term, no.geometry_term),
        }
    }
}

/// Connects two points by reflection at the front of a flat mirror, assumed to be infinite.
#[inline]
pub fn mirror_connection<V: Vector>(
    caster: &Caster<V>,
    x: V,
    y: V,
    active: MaskOf<V>,
) -> SpecularConnection<V> {
    let zero = V::Real::splat(0.0);
    let normal = caster.normal;
    let [height_x, height_y] = [x, y].map(|v| (v - caster.centre).dot(normal));
    let (foot_x, foot_y) = (x - normal * height_x, y - normal * height_y);
    let between = (height_x + height_y).recip();
    let point = (foot_x * height_y + foot_y * height_x) * between;
    let from_image = y - (foot_x - normal * height_x);
    let geometry_term = from_image.length_squared().recip();
    let direction = (point - x).normalize();
    let exists = active & height_x.cmpgt(zero) & height_y.cmpgt(zero);
    let (first, cosine) = (SurfacePoint::new(point, normal), -direction.dot(normal));
    SpecularConnection {
        exists,
        direction,
        arriving: (y - point).normalize(),
        first,
        last: first,
        cosine,
        geometry_term,
    }
}

/// Returns dω/dA⊥ at y of the connection that leaves x in a direction, 0 if there is none, and the
/// cosine at the caster.
#[inline]
pub fn geometry_term<V: Vector>(
    caster: &Caster<V>,
    kind: CasterKind,
    x: V,
    direction: V,
    y: V,
) -> (V::Real, V::Real) {
    if kind == CasterKind::Flat {
        let image = x - caster.normal * ((x - caster.centre).dot(caster.normal) * 2.0);
        return (
            (y - image).length_squared().recip(),
            -direction.dot(caster.normal),
        );
    }
    geometry_term_of_sphere(caster, x, direction, y)
}
