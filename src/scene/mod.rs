//! Scenes as plain data: surfaces, an indexed triangle mesh, spheres, emitters, a camera.

pub mod file;
pub mod room;
pub mod simple;

use glam::DVec3;

use crate::accel::{Bvh, Primitive, PrimitiveHit};
use crate::bsdf::Bsdf;
use crate::camera::Camera;
use crate::emitter::{Emitter, EmitterShape};
use crate::environment::Environment;
use crate::error::Error;
use crate::real::{Real, Vector};
use crate::shape::{Ray, Sphere};

/// How a surface scatters, emits and, in the report's roulette, absorbs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// How it scatters light, on both sides unless it is glass.
    pub bsdf: Bsdf,
    /// Radiance that its front emits; zero for most.
    pub emission: DVec3,
    /// α of section 2.6.2; used by the report's estimator only.
    pub absorption: f64,
}

impl Surface {
    /// A surface that emits nothing and, in the report's roulette, absorbs nothing.
    pub fn new(bsdf: Bsdf) -> Self {
        Self { bsdf, emission: DVec3::ZERO, absorption: 0.0 }
    }

    /// The same surface with emission.
    pub fn emitting(self, emission: DVec3) -> Self {
        Self { emission, ..self }
    }

    /// The same surface with absorption α.
    pub fn absorbing(self, absorption: f64) -> Self {
        Self { absorption, ..self }
    }
}

/// Where a ray meets the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance from the ray's origin.
    pub t: f64,
    /// The point, on the surface to rounding and inside it by [`EDGE_MARGIN`].
    pub point: DVec3,
    /// Unit geometric normal of the surface's front, whatever side was hit.
    pub normal: DVec3,
    /// Index of the primitive among [`Scene::primitives`].
    pub primitive: u32,
    /// Index of the [`Surface`].
    pub surface: u32,
    /// Index of the [`Emitter`], if the surface emits.
    pub emitter: Option<u32>,
}

/// A hit on a triangle lies at least this far from each edge, as a share of the height over it.
///
/// Rounding can put a point on an edge of a closed room outside the room, where its next ray is lost.
/// The share of points that moves is about 10⁻⁹ of a triangle, by at most 2⁻³¹ of its size: no trial
/// could see it.
pub const EDGE_MARGIN: f64 = 1.0 / 4_294_967_296.0;
/// Rays leave a surface from this far above it, relative to the largest coordinate of the scene: some
/// thousand roundings of a hit point, and a thousandth of [`EDGE_MARGIN`]'s step.
pub const OFFSET: f64 = 1.0 / 1_099_511_627_776.0;
/// The largest coordinate, radiance and image height of a scene: products of a few stay finite.
pub const LARGEST: f64 = 1e30;
/// The smallest area of a triangle or a zone of a sphere, that of a figure of side 1/[`LARGEST`]: its reciprocal, too.
pub const SMALLEST_AREA: f64 = 1e-60;

/// One primitive's place in the scene.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    pub surface: u32,
    pub emitter: Option<u32>,
    pub shape: PartShape,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum PartShape {
    Triangle { vertices: [u32; 3], normal: DVec3 },
    Sphere(Sphere),
}

/// The shape of a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Geometry {
    /// Its corners, counter-clockwise from the front.
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
    parts: Vec<Part>,
    emitters: Vec<Emitter>,
    background: Environment,
    camera: Camera,
    bvh: Bvh,
    offset: f64,
}

impl Scene {
    /// The scene's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The same scene seen by another camera.
    ///
    /// # Errors
    /// [`Error::Scene`] for a camera that looks nowhere.
    pub fn with_camera(self, camera: Camera) -> Result<Self, Error> {
        check_camera(&self.name, &camera)?;
        let offset = self.offset.max(camera.eye.abs().max_element() * OFFSET);
        Ok(Self { camera, offset, ..self })
    }

    /// The camera.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// The emitters that shadow rays can pick.
    pub fn emitters(&self) -> &[Emitter] {
        &self.emitters
    }

    /// What rays see that meet nothing.
    pub fn background(&self) -> &Environment {
        &self.background
    }

    /// The surface of a hit.
    #[inline]
    pub fn surface(&self, hit: &Hit) -> &Surface {
        &self.surfaces[hit.surface as usize]
    }

    /// Every triangle and sphere with its surface.
    pub fn primitives(&self) -> impl Iterator<Item = (Geometry, &Surface)> + '_ {
        self.parts.iter().map(|part| {
            let geometry = match part.shape {
                PartShape::Triangle { vertices, .. } => Geometry::Triangle(self.corners(vertices)),
                PartShape::Sphere(sphere) => Geometry::Sphere(sphere),
            };
            (geometry, &self.surfaces[part.surface as usize])
        })
    }

    /// The parts of which [`primitives`](Self::primitives) tells.
    pub(crate) fn parts(&self) -> &[Part] {
        &self.parts
    }

    #[inline]
    pub(crate) fn corners(&self, vertices: [u32; 3]) -> [DVec3; 3] {
        vertices.map(|v| self.vertices[v as usize])
    }

    /// All surfaces, in the order of [`Hit::surface`].
    pub(crate) fn surfaces(&self) -> &[Surface] {
        &self.surfaces
    }

    /// The acceleration structure, whose brute-force twin tests use.
    pub fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// The nearest hit along a ray with a unit direction.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        Some(self.hit(ray, &self.bvh.closest(ray, f64::INFINITY)?))
    }

    /// What a ray has met, from where.
    #[inline]
    fn hit(&self, ray: &Ray, found: &PrimitiveHit) -> Hit {
        let part = &self.parts[found.primitive as usize];
        let (point, normal) = match &part.shape {
            PartShape::Triangle { vertices, normal } => (inner_point(self.corners(*vertices), found.weights), *normal),
            PartShape::Sphere(sphere) => {
                let normal = sphere.normal(ray.at(found.t));
                let outward = if sphere.inward { -normal } else { normal };
                (sphere.centre + sphere.radius * outward, normal)
            }
        };
        let (surface, emitter) = (part.surface, part.emitter);
        Hit { t: found.t, point, normal, primitive: found.primitive, surface, emitter }
    }

    /// The radiance that an emitter shows to a ray of this direction that hit it; zero for its back and for other
    /// surfaces.
    #[inline]
    pub fn emitted(&self, hit: &Hit, direction: DVec3) -> DVec3 {
        match hit.emitter {
            Some(emitter) if hit.normal.dot(direction) < 0.0 => self.emitters[emitter as usize].radiance,
            _ => DVec3::ZERO,
        }
    }

    /// The ray that leaves a hit in a direction, and what it meets.
    #[inline]
    pub fn onward(&self, here: &Hit, direction: DVec3) -> (Ray, Option<Hit>) {
        let ray = self.leave(here.point, here.normal, direction);
        (ray, self.intersect(&ray))
    }

    /// Whether nothing lies between a surface point with its unit normal and the background in a direction.
    #[inline]
    pub fn sees_background(&self, (point, normal): (DVec3, DVec3), direction: DVec3) -> bool {
        !self.bvh.occluded(&self.leave(point, normal, direction), f64::INFINITY, |_| true)
    }

    /// The ray that leaves a surface point with the given unit normal, from the side that `direction`
    /// points to.
    #[inline]
    pub fn leave<V: Vector>(&self, point: V, normal: V, direction: V) -> Ray<V> {
        let offset = V::Real::splat(self.offset).copysign(normal.dot(direction));
        Ray::new(point + normal * offset, direction)
    }

    /// The segment from one surface point with its unit normal to another, as a ray that ends at t = 1.
    #[inline]
    pub(crate) fn segment<V: Vector>(&self, (x, normal_x): (V, V), (y, normal_y): (V, V)) -> Ray<V> {
        let start = self.leave(x, normal_x, y - x).origin;
        let end = self.leave(y, normal_y, x - y).origin;
        Ray::new(start, end - start)
    }

    /// Whether the segment between two surface points with unit normals is free. Glass blocks it unless
    /// `through_glass`.
    #[inline]
    pub fn visible(&self, x: (DVec3, DVec3), y: (DVec3, DVec3), through_glass: bool) -> bool {
        let segment = self.segment(x, y);
        if through_glass {
            !self.bvh.occluded(&segment, 1.0, |primitive| {
                let surface = self.parts[primitive as usize].surface;
                !self.surfaces[surface as usize].bsdf.is_glass()
            })
        } else {
            !self.bvh.occluded(&segment, 1.0, |_| true)
        }
    }
}

/// The point of a triangle with these barycentric weights, inside by [`EDGE_MARGIN`].
#[inline]
pub(crate) fn inner_point<V: Vector>([a, b, c]: [V; 3], weights: [V::Real; 3]) -> V {
    let weights = weights.map(|weight| weight.at_least(V::Real::splat(EDGE_MARGIN)));
    let scale = (weights[0] + weights[1] + weights[2]).recip();
    (a * weights[0] + b * weights[1] + c * weights[2]) * scale
}

/// Collects a scene's parts; [`build`](Self::build) validates them.
#[derive(Debug)]
pub struct SceneBuilder {
    name: String,
    surfaces: Vec<Surface>,
    vertices: Vec<DVec3>,
    parts: Vec<Part>,
    emitters: Vec<Emitter>,
    background: Environment,
}

/// The index of a surface within its builder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SurfaceId(u32);

impl SceneBuilder {
    /// An empty scene in the dark.
    pub fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            surfaces: Vec::new(),
            vertices: Vec::new(),
            parts: Vec::new(),
            emitters: Vec::new(),
            background: Environment::Uniform(DVec3::ZERO),
        }
    }

    /// Sets the radiance of rays that meet nothing to the same everywhere.
    pub fn background(&mut self, radiance: DVec3) {
        self.environment(Environment::Uniform(radiance));
    }

    /// Sets what rays see that meet nothing.
    pub fn environment(&mut self, environment: Environment) {
        self.background = environment;
    }

    /// Adds a surface.
    pub fn surface(&mut self, surface: Surface) -> SurfaceId {
        self.surfaces.push(surface);
        SurfaceId(self.surfaces.len() as u32 - 1)
    }

    /// Adds an indexed triangle mesh; each emitting triangle is an emitter of its own. Fronts are where
    /// the vertices run counter-clockwise. Neighbours that share an edge must share its indices.
    pub fn mesh(&mut self, vertices: &[DVec3], triangles: &[[u32; 3]], surface: SurfaceId) {
        let first = self.vertices(vertices);
        self.triangles(first, triangles, surface);
    }

    /// Adds vertices; returns the index of the first.
    fn vertices(&mut self, vertices: &[DVec3]) -> u32 {
        let first = self.vertices.len() as u32;
        self.vertices.extend_from_slice(vertices);
        first
    }

    /// Adds triangles whose indices count from the vertex `first`.
    fn triangles(&mut self, first: u32, triangles: &[[u32; 3]], surface: SurfaceId) {
        for triangle in triangles {
            let triangle = triangle.map(|v| first.saturating_add(v));
            // An index that points nowhere is refused by `build`.
            let corner = |v: u32| self.vertices.get(v as usize).copied().unwrap_or(DVec3::NAN);
            let shape = EmitterShape::Triangle(triangle.map(corner));
            let emitter = self.emitter(surface, shape);
            self.triangle(triangle, surface, emitter);
        }
    }

    /// Adds a parallelogram as two triangles and, if it emits, one emitter. Its front is where
    /// `edges[0] × edges[1]` points.
    pub fn rectangle(&mut self, corner: DVec3, edges: [DVec3; 2], surface: SurfaceId) {
        let first = self.vertices.len() as u32;
        let [a, b] = edges;
        self.vertices.extend([corner, corner + a, corner + a + b, corner + b]);
        let emitter = self.emitter(surface, EmitterShape::Rectangle { corner, edges });
        self.triangle([first, first + 1, first + 2], surface, emitter);
        self.triangle([first, first + 2, first + 3], surface, emitter);
    }

    /// Adds a sphere or a zone of one.
    pub fn sphere(&mut self, sphere: Sphere, surface: SurfaceId) {
        let emitter = self.emitter(surface, EmitterShape::Sphere(sphere));
        self.parts.push(Part { surface: surface.0, emitter, shape: PartShape::Sphere(sphere) });
    }

    fn triangle(&mut self, vertices: [u32; 3], surface: SurfaceId, emitter: Option<u32>) {
        self.parts.push(Part {
            surface: surface.0,
            emitter,
            shape: PartShape::Triangle { vertices, normal: DVec3::ZERO },
        });
    }

    fn emitter(&mut self, surface: SurfaceId, shape: EmitterShape) -> Option<u32> {
        let radiance = self.surfaces[surface.0 as usize].emission;
        (radiance != DVec3::ZERO).then(|| {
            self.emitters.push(Emitter::new(shape, radiance));
            self.emitters.len() as u32 - 1
        })
    }

    /// Validates the parts and builds the acceleration structure.
    ///
    /// # Errors
    /// [`Error::Scene`] for a coordinate or radiance that is not finite or beyond [`LARGEST`], an albedo, absorption
    /// or roughness outside [0, 1], a negative radiance, an index that points nowhere, a triangle or a zone of a
    /// sphere of less than [`SMALLEST_AREA`], a camera that looks nowhere.
    pub fn build(mut self, camera: Camera) -> Result<Scene, Error> {
        self.check_surfaces()?;
        check_camera(&self.name, &camera)?;
        let mut primitives = Vec::with_capacity(self.parts.len());
        let mut extent = camera.eye.abs().max_element();
        for (i, part) in self.parts.iter_mut().enumerate() {
            primitives.push(match &mut part.shape {
                PartShape::Triangle { vertices, normal } => {
                    let corner = |v: u32| self.vertices.get(v as usize).copied();
                    let [Some(a), Some(b), Some(c)] = vertices.map(corner) else {
                        return Err(invalid(
                            &self.name,
                            format!(
                                "triangle {i} uses vertices {vertices:?}, but there are only {}",
                                self.vertices.len()
                            ),
                        ));
                    };
                    extent = [a, b, c].iter().fold(extent, |e, v| e.max(v.abs().max_element()));
                    *normal = triangle_normal([a, b, c]).ok_or_else(|| {
                        let corners = [a, b, c].map(|corner| corner.to_array());
                        let message = format!(
                            "triangle {i}, {corners:?}, is not finite or has an area below {SMALLEST_AREA:?}: remove it"
                        );
                        invalid(&self.name, message)
                    })?;
                    Primitive::triangle([a, b, c])
                }
                PartShape::Sphere(sphere) => {
                    let Sphere { centre, radius, .. } = *sphere;
                    if !is_sound(sphere) {
                        return Err(invalid(
                            &self.name,
                            format!(
                                "sphere {i} (centre {:?}, radius {radius:?}, zone {:?}) needs finite numbers, a radius \
                             above 0, and a zone from a lower to a higher z with an area of {SMALLEST_AREA:?} or more",
                                centre.to_array(),
                                sphere.zone
                            ),
                        ));
                    }
                    extent = extent.max((centre.abs() + radius).max_element());
                    Primitive::Sphere(*sphere)
                }
            });
        }
        if extent > LARGEST {
            return Err(invalid(
                &self.name,
                format!("it reaches to {extent:?}, and may to {LARGEST:?}: take another unit"),
            ));
        }
        Ok(Scene {
            bvh: Bvh::new(&primitives),
            name: self.name,
            surfaces: self.surfaces,
            vertices: self.vertices,
            parts: self.parts,
            emitters: self.emitters,
            background: self.background,
            camera,
            offset: extent * OFFSET,
        })
    }

    fn check_surfaces(&self) -> Result<(), Error> {
        let share = |v: DVec3| v.cmpge(DVec3::ZERO).all() && v.cmple(DVec3::ONE).all();
        let radiance = |v: DVec3| v.cmpge(DVec3::ZERO).all() && v.cmple(DVec3::splat(LARGEST)).all();
        if let Environment::Uniform(background) = self.background
            && !radiance(background)
        {
            let message = format!("the background radiance {:?} must be from 0 to {LARGEST:?}", background.to_array());
            return Err(invalid(&self.name, message));
        }
        for (i, surface) in self.surfaces.iter().enumerate() {
            let parameters_valid = match surface.bsdf {
                Bsdf::OrenNayar { constants, .. } => constants.a.is_finite() && constants.b.is_finite(),
                Bsdf::Eon { roughness, .. } => (0.0..=1.0).contains(&roughness),
                Bsdf::Glass { index } => index.is_finite() && index > 0.0,
                Bsdf::RoughGlass(glass) => glass.is_valid(),
                Bsdf::Black | Bsdf::Lambert { .. } | Bsdf::Mirror { .. } | Bsdf::Model(_) => true,
            };
            let valid = share(surface.bsdf.albedo())
                && share(DVec3::splat(surface.absorption))
                && radiance(surface.emission)
                && parameters_valid;
            if !valid {
                return Err(invalid(
                    &self.name,
                    format!(
                        "surface {i} needs albedo, absorption and roughness in [0, 1], a radiance from 0 to \
                     {LARGEST:?} and an index above 0, of rough glass other than 1 and an α above 0: {surface:?}"
                    ),
                ));
            }
        }
        Ok(())
    }
}

/// The unit normal of the front; `None` below [`SMALLEST_AREA`], and for what is not finite.
fn triangle_normal([a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    let scaled = (b - a).cross(c - a);
    let sound = scaled.is_finite() && 0.5 * scaled.length() >= SMALLEST_AREA;
    if sound { scaled.try_normalize() } else { None }
}

/// Whether a sphere is finite and its zone has an area.
fn is_sound(sphere: &Sphere) -> bool {
    let Sphere { centre, radius, .. } = *sphere;
    // Of an empty zone the area is 0 or negative, of NaN not above 0 either.
    centre.is_finite() && radius.is_finite() && radius > 0.0 && sphere.area() >= SMALLEST_AREA
}

/// Vertices and triangles of a closed box along the axes, its fronts inside or outside.
fn cuboid(low: DVec3, high: DVec3, inward: bool) -> ([DVec3; 8], [[u32; 3]; 12]) {
    let vertices = std::array::from_fn(|i| DVec3::select(glam::BVec3::new(i & 1 > 0, i & 2 > 0, i & 4 > 0), high, low));
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = std::array::from_fn(|i| {
        let [a, b, c, d]: [u32; 4] = quads[i / 2];
        let [a, b, c] = if i % 2 == 0 { [a, b, c] } else { [a, c, d] };
        if inward { [a, c, b] } else { [a, b, c] }
    });
    (vertices, triangles)
}

fn check_camera(scene: &str, camera: &Camera) -> Result<(), Error> {
    if camera.is_valid() {
        return Ok(());
    }
    let needs = format!(
        "its camera needs numbers up to {LARGEST:?}, a target away from the eye, an upright that is not the line of \
         sight, and a height above 0"
    );
    Err(invalid(scene, needs))
}

fn invalid(scene: &str, message: String) -> Error {
    Error::Scene { scene: scene.to_owned(), message }
}
