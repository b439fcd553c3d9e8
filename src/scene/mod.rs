//! Scenes as plain data: surfaces, an indexed triangle mesh, spheres, emitters, a camera.

mod builder;
mod coincident;
mod detail;
#[cfg(feature = "files")]
pub mod file;
pub mod lanes;
#[cfg(feature = "files")]
pub mod room;
#[cfg(feature = "files")]
pub mod simple;
mod solids;
pub mod specular_casters;

use std::any::Any;
use std::sync::OnceLock;

use glam::DVec3;

pub use builder::{SceneBuilder, SurfaceId, cuboid};
pub use coincident::{COINCIDENCE_TOLERANCE, Coincidence, SINGLE_COINCIDENCE_TOLERANCE};
pub use detail::SMALLEST_DETAIL;
use detail::longest_edge;

use crate::camera::Camera;
use crate::error::Error;
use crate::geometry::bvh::{Bvh, Part, PrimitiveHit};
use crate::geometry::hull::Hull;
use crate::geometry::offsets::{
    EDGE_MARGIN, OFFSET, RayOrigin, SINGLE_EDGE_MARGIN, SINGLE_LARGEST_MARGIN, SINGLE_LEAST_OFFSET,
    SINGLE_OFFSET, inner_point, offset_in,
};
use crate::geometry::shape::{Hit, Ray, Sphere, SurfacePoint};
use crate::light::emitter::Emitter;
use crate::light::environment::Environment;
use crate::light::light_sampler::PowerLightSampler;
use crate::light::light_tree::LightTree;
use crate::material::Bsdf;
use crate::math::real::Vector;
use crate::math::simd::Scalar;
use lanes::SceneData;
use specular_casters::SpecularCasters;

/// Scattering, emission and, in the report's roulette, absorption of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Reflection model, on both sides unless it is glass.
    pub bsdf: Bsdf,
    /// Radiance that its front emits; zero for most surfaces.
    pub emission: DVec3,
    /// α of section 2.6.2; used by the report's estimator only.
    pub absorption: f64,
}

impl Surface {
    /// Creates a surface that emits nothing and, in the report's roulette, absorbs nothing.
    pub fn new(bsdf: Bsdf) -> Self {
        Self {
            bsdf,
            emission: DVec3::ZERO,
            absorption: 0.0,
        }
    }

    /// Returns the surface with emission.
    pub fn emitting(self, emission: DVec3) -> Self {
        Self { emission, ..self }
    }

    /// Returns the surface with absorption α.
    pub fn absorbing(self, absorption: f64) -> Self {
        Self { absorption, ..self }
    }
}

/// A primitive of the scene with its surface, emitter and object.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScenePrimitive {
    pub surface: u32,
    pub emitter: Option<u32>,
    /// Index of its object, in the order in which these were added, from 0.
    pub object: u32,
    pub shape: PrimitiveShape,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum PrimitiveShape {
    Triangle { vertices: [u32; 3], normal: DVec3 },
    Sphere(Sphere),
}

/// The shape of a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Geometry {
    /// Corners of a triangle, counter-clockwise from the front.
    Triangle([DVec3; 3]),
    /// A sphere or a zone of one.
    Sphere(Sphere),
}

/// A scene, validated, with its acceleration structure.
#[derive(Debug)]
pub struct Scene {
    name: String,
    surfaces: Vec<Surface>,
    vertices: Vec<DVec3>,
    primitives: Vec<ScenePrimitive>,
    /// Primitives left out because others cover them, each with its index among all.
    redundant_faces: Vec<(usize, ScenePrimitive)>,
    /// Names of the surfaces in messages.
    surface_names: Vec<String>,
    emitters: Vec<Emitter>,
    light_tree: LightTree,
    power_light_sampler: PowerLightSampler,
    specular_casters: SpecularCasters,
    background: Environment,
    camera: Camera,
    bvh: Bvh,
    hull: Option<Hull>,
    offset: f64,
    /// Value of [`smallest_detail`](Scene::smallest_detail).
    smallest_detail: f64,
    /// First pair that coincides in single precision, computed on demand.
    single_coincidence: OnceLock<Option<Coincidence>>,
    /// Scene data for rays in lanes, in double and in single precision, computed on demand.
    lane_data: (OnceLock<SceneData<f64>>, OnceLock<SceneData<f32>>),
}

impl Scene {
    /// Returns the scene's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the scene seen by another camera.
    ///
    /// # Errors
    /// [`Error::Scene`] for an invalid camera, or one that sees surfaces that
    /// [coincide](SceneBuilder::build).
    pub fn with_camera(self, camera: Camera) -> Result<Self, Error> {
        let extent = self.largest_coordinate();
        SceneBuilder::from_scene(self).build_from(camera, extent)
    }

    /// Returns the camera.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Returns the emitters that shadow rays can pick.
    pub fn emitters(&self) -> &[Emitter] {
        &self.emitters
    }

    /// Returns the emitters in groups.
    pub fn light_tree(&self) -> &LightTree {
        &self.light_tree
    }

    /// Returns the distribution of emitters, half by flux and half uniform, for picks that do not
    /// depend on a position.
    pub fn power_light_sampler(&self) -> &PowerLightSampler {
        &self.power_light_sampler
    }

    /// Returns the specular casters: mirrors and glass through which shadow rays are connected.
    pub fn specular_casters(&self) -> &SpecularCasters {
        &self.specular_casters
    }

    /// Returns the environment: the radiance of rays that hit nothing.
    pub fn background(&self) -> &Environment {
        &self.background
    }

    /// Returns the surface of a hit.
    #[inline]
    pub fn surface(&self, hit: &Hit) -> &Surface {
        &self.surfaces[hit.surface as usize]
    }

    /// Iterates over all triangles and spheres with their surfaces.
    pub fn primitives(&self) -> impl Iterator<Item = (Geometry, &Surface)> + '_ {
        self.primitives.iter().map(|primitive| {
            let geometry = match primitive.shape {
                PrimitiveShape::Triangle { vertices, .. } => {
                    Geometry::Triangle(self.corners(vertices))
                }
                PrimitiveShape::Sphere(sphere) => Geometry::Sphere(sphere),
            };
            (geometry, &self.surfaces[primitive.surface as usize])
        })
    }

    /// Returns the data behind [`primitives`](Self::primitives).
    pub(crate) fn scene_primitives(&self) -> &[ScenePrimitive] {
        &self.primitives
    }

    #[inline]
    pub(crate) fn corners(&self, vertices: [u32; 3]) -> [DVec3; 3] {
        vertices.map(|v| self.vertices[v as usize])
    }

    /// Returns all surfaces, in the order of [`Hit::surface`].
    pub(crate) fn surfaces(&self) -> &[Surface] {
        &self.surfaces
    }

    /// Returns the scene data for lanes of a precision, computed when first asked for.
    pub(crate) fn lane_data<T: Scalar>(&self) -> &SceneData<T> {
        let (double, single): (&dyn Any, &dyn Any) = (&self.lane_data.0, &self.lane_data.1);
        let data: &OnceLock<SceneData<T>> = double
            .downcast_ref()
            .or_else(|| single.downcast_ref())
            .expect("one for each precision");
        data.get_or_init(|| SceneData::new(self))
    }

    /// Returns the acceleration structure.
    pub fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    pub(crate) fn hull(&self) -> Option<&Hull> {
        self.hull.as_ref()
    }

    /// Returns the nearest hit along a ray with a unit direction.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        Some(self.hit(ray, &self.bvh.closest(ray, f64::INFINITY)?))
    }

    /// Returns the hit of a ray on a primitive.
    #[inline]
    fn hit(&self, ray: &Ray, found: &PrimitiveHit) -> Hit {
        let primitive = &self.primitives[found.primitive as usize];
        let (point, normal) = match &primitive.shape {
            PrimitiveShape::Triangle { vertices, normal } => (
                inner_point(self.corners(*vertices), found.weights, EDGE_MARGIN),
                *normal,
            ),
            PrimitiveShape::Sphere(sphere) => {
                let normal = sphere.normal(ray.at(found.t));
                let outward = if sphere.inward { -normal } else { normal };
                (sphere.centre + sphere.radius * outward, normal)
            }
        };
        let (surface, emitter) = (primitive.surface, primitive.emitter);
        Hit {
            t: found.t,
            point,
            normal,
            primitive: found.primitive,
            surface,
            emitter,
        }
    }

    /// Returns the radiance that an emitter emits towards the origin of a ray of this direction
    /// that hit it; zero for its back and for other surfaces.
    #[inline]
    pub fn emitted(&self, hit: &Hit, direction: DVec3) -> DVec3 {
        match hit.emitter {
            Some(emitter) if hit.normal.dot(direction) < 0.0 => {
                self.emitters[emitter as usize].radiance
            }
            _ => DVec3::ZERO,
        }
    }

    /// Returns the ray that leaves a hit in a direction, and its hit.
    pub fn spawn_and_trace(&self, here: &Hit, direction: DVec3) -> (Ray, Option<Hit>) {
        let ray = self.spawn_ray(here.point, here.normal, direction);
        (ray, self.intersect(&ray))
    }

    /// Returns whether the background is visible from a surface point in a direction.
    pub fn sees_background(&self, x: SurfacePoint, direction: DVec3) -> bool {
        self.escapes(&self.spawn_ray(x.point, x.normal, direction))
    }

    /// Returns whether a ray hits nothing.
    pub(crate) fn escapes(&self, ray: &Ray) -> bool {
        !self.bvh.occluded(ray, f64::INFINITY, |_| true)
    }

    /// Returns the ray that leaves a surface point with the given unit normal, from the side that
    /// `direction` points to.
    #[inline]
    pub fn spawn_ray(&self, point: DVec3, normal: DVec3, direction: DVec3) -> Ray {
        self.ray_origin(point, normal).spawn_ray(direction)
    }

    /// Returns a surface point with its unit normal, from which rays start at the height of
    /// [`OFFSET`], in single precision of [`SINGLE_END`](crate::geometry::offsets::SINGLE_END).
    #[inline]
    pub(crate) fn ray_origin<V: Vector>(&self, point: V, normal: V) -> RayOrigin<V> {
        RayOrigin {
            point,
            normal,
            offset: offset_in(self.offset),
        }
    }

    /// Returns how far above every surface rays start in double precision.
    pub(crate) fn offset(&self) -> f64 {
        self.offset
    }

    /// Returns the largest magnitude of a coordinate.
    pub(crate) fn largest_coordinate(&self) -> f64 {
        self.offset / OFFSET
    }

    /// Returns the size of the smallest detail: the radius of a sphere, or the height of a zone if
    /// that is less, or the second largest extent along the axes of triangles connected by their
    /// vertices. Infinite without any.
    pub(crate) fn smallest_detail(&self) -> f64 {
        self.smallest_detail
    }

    /// Returns the largest coordinate of a primitive.
    fn max_coordinate(&self, primitive: &ScenePrimitive) -> f64 {
        match primitive.shape {
            PrimitiveShape::Sphere(sphere) => (sphere.centre.abs() + sphere.radius).max_element(),
            PrimitiveShape::Triangle { vertices, .. } => self
                .corners(vertices)
                .map(|corner| corner.abs().max_element())
                .into_iter()
                .fold(0.0, f64::max),
        }
    }

    /// Refuses a scene with a detail smaller than [`SMALLEST_DETAIL`] times the largest coordinate:
    /// rays would start so far above it that its shadows move. Scenes from files pass this check.
    ///
    /// # Errors
    /// [`Error::Scene`] with advice.
    pub fn check_details(&self) -> Result<(), Error> {
        let (extent, detail) = (self.largest_coordinate(), self.smallest_detail);
        if detail >= SMALLEST_DETAIL * extent {
            return Ok(());
        }
        let far = 0.5 * detail / SMALLEST_DETAIL;
        // A distant light such as a sun: all else lies near.
        let beyond: Vec<_> = self
            .primitives
            .iter()
            .enumerate()
            .filter(|(_, primitive)| self.max_coordinate(primitive) > far)
            .collect();
        let sun = match beyond[..] {
            [
                (
                    i,
                    ScenePrimitive {
                        shape: PrimitiveShape::Sphere(sphere),
                        ..
                    },
                ),
            ] if self.camera.eye.abs().max_element() <= far
                && sphere.centre.length() > 2.0 * sphere.radius =>
            {
                Some((i, *sphere))
            }
            _ => None,
        };
        let remedy = match sun {
            Some((i, Sphere { centre, radius, .. })) => {
                let nearer = far / extent;
                let centre = self.camera.eye + (centre - self.camera.eye) * nearer;
                format!(
                    "bring primitive {i}, a sphere, nearer and make it as much smaller: with centre {:?} and radius {:?} it \
                     looks the same from the camera",
                    centre.to_array(),
                    radius * nearer
                )
            }
            None => format!(
                "leave out what is so small, or let nothing, the camera too, be farther than {far:.1e}"
            ),
        };
        let message = format!(
            "something has a size of {detail:.1e}, too small for numbers of double precision where the scene reaches \
             to {extent:.1e}: {remedy}"
        );
        Err(builder::invalid(&self.name, message))
    }

    /// Returns [`SINGLE_EDGE_MARGIN`] as a fraction of the least height of a triangle, at most
    /// [`SINGLE_LARGEST_MARGIN`].
    pub(crate) fn single_edge_margin(&self, primitive: &ScenePrimitive) -> f64 {
        let PrimitiveShape::Triangle { vertices, .. } = primitive.shape else {
            return 0.0;
        };
        let [a, b, c] = self.corners(vertices);
        let height = (b - a).cross(c - a).length() / longest_edge([a, b, c]);
        (SINGLE_EDGE_MARGIN * self.largest_coordinate() / height).min(SINGLE_LARGEST_MARGIN)
    }

    /// Returns how far above a primitive rays leave it in single precision: [`SINGLE_OFFSET`] of
    /// its reach, plus [`SINGLE_LEAST_OFFSET`]. The reach is the largest sum of a point's absolute
    /// coordinates, each times that of the unit normal, as rounding errors along the normal are; 0
    /// for a triangle in a coordinate plane.
    pub(crate) fn single_offset(&self, primitive: &ScenePrimitive) -> f64 {
        let reach = match &primitive.shape {
            PrimitiveShape::Triangle { vertices, normal } => self
                .corners(*vertices)
                .map(|corner| normal.abs().dot(corner.abs()))
                .into_iter()
                .fold(0.0, f64::max),
            PrimitiveShape::Sphere(sphere) => sphere.centre.length() + sphere.radius,
        };
        SINGLE_OFFSET * reach + SINGLE_LEAST_OFFSET * self.largest_coordinate()
    }

    /// Returns whether a primitive is of smooth glass.
    pub(crate) fn is_glass(&self, primitive: u32) -> bool {
        let surface = self.primitives[primitive as usize].surface;
        self.surfaces[surface as usize].bsdf.is_glass()
    }

    /// Returns whether the segment between two surface points is free. Glass
    /// blocks it unless `through_glass`.
    pub fn visible(&self, x: SurfacePoint, y: SurfacePoint, through_glass: bool) -> bool {
        let [from, to] = [x, y].map(|end| self.ray_origin(end.point, end.normal));
        self.is_unoccluded(&from.segment(&to), through_glass)
    }

    /// Returns whether nothing lies on a segment up to t = 1.
    pub(crate) fn is_unoccluded(&self, segment: &Ray, through_glass: bool) -> bool {
        let part = match &self.hull {
            Some(hull) if hull.contains(segment.origin, segment.at(1.0)) => Part::WithoutWalls,
            _ => Part::All,
        };
        if through_glass {
            let blocks = |primitive| !self.is_glass(primitive);
            !self.bvh.occluded_by::<f64>(part, segment, 1.0, blocks)
        } else {
            !self.bvh.occluded_by::<f64>(part, segment, 1.0, |_| true)
        }
    }
}
