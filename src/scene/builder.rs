//! Construction and validation of scenes.

use std::sync::OnceLock;

use glam::DVec3;

use super::coincident::{CLOSE_FRACTION, COINCIDENCE_TOLERANCE};
use super::detail::smallest_detail;
use super::solids::Shapes;
use super::specular_casters::SpecularCasters;
use super::{PrimitiveShape, Scene, ScenePrimitive, Surface};
use crate::camera::{Camera, MAX_HALF_HEIGHT};
use crate::error::Error;
use crate::geometry::bvh::{Bvh, Primitive};
use crate::geometry::hull::Hull;
use crate::geometry::offsets::{LARGEST, OFFSET, SMALLEST_AREA};
use crate::geometry::shape::Sphere;
use crate::light::emitter::{Emitter, EmitterShape};
use crate::light::environment::Environment;
use crate::light::light_sampler::PowerLightSampler;
use crate::light::light_tree::LightTree;
use crate::material::Bsdf;

/// Collects a scene's parts; [`build`](Self::build) validates them.
#[derive(Debug)]
pub struct SceneBuilder {
    name: String,
    surfaces: Vec<Surface>,
    vertices: Vec<DVec3>,
    primitives: Vec<ScenePrimitive>,
    emitters: Vec<Emitter>,
    background: Environment,
    /// Names of the surfaces in messages.
    surface_names: Vec<String>,
    /// Number of objects.
    objects: u32,
}

/// Index of a surface within its builder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SurfaceId(u32);

impl SceneBuilder {
    /// Creates an empty scene with a black background.
    pub fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            surfaces: Vec::new(),
            vertices: Vec::new(),
            primitives: Vec::new(),
            emitters: Vec::new(),
            background: Environment::Uniform(DVec3::ZERO),
            surface_names: Vec::new(),
            objects: 0,
        }
    }

    /// Returns the builder of a scene.
    pub(super) fn from_scene(scene: Scene) -> Self {
        let mut primitives = scene.primitives;
        for (index, primitive) in scene.redundant_faces {
            primitives.insert(index, primitive);
        }
        Self {
            name: scene.name,
            surfaces: scene.surfaces,
            vertices: scene.vertices,
            objects: primitives.last().map_or(0, |last| last.object + 1),
            primitives,
            emitters: scene.emitters,
            background: scene.background,
            surface_names: scene.surface_names,
        }
    }

    /// Sets the radiance of rays that hit nothing to the same everywhere.
    pub fn background(&mut self, radiance: DVec3) {
        self.environment(Environment::Uniform(radiance));
    }

    /// Sets the environment: the radiance of rays that hit nothing.
    pub fn environment(&mut self, environment: Environment) {
        self.background = environment;
    }

    /// Adds a surface.
    pub fn surface(&mut self, surface: Surface) -> SurfaceId {
        self.named_surface(format!("surface {}", self.surfaces.len()), surface)
    }

    /// Adds a surface with a name for messages.
    pub(super) fn named_surface(&mut self, name: String, surface: Surface) -> SurfaceId {
        self.surface_names.push(name);
        self.surfaces.push(surface);
        SurfaceId(self.surfaces.len() as u32 - 1)
    }

    /// Begins an object: primitives belong to it until the next one begins.
    pub(super) fn begin_object(&mut self) {
        self.objects += 1;
    }

    /// Adds an indexed triangle mesh; each emitting triangle is an emitter of its own. Fronts are
    /// where the vertices run counter-clockwise. Neighbours that share an edge must share its
    /// indices.
    pub fn mesh(&mut self, vertices: &[DVec3], triangles: &[[u32; 3]], surface: SurfaceId) {
        self.begin_object();
        let first = self.vertices(vertices);
        self.triangles(first, triangles, surface);
    }

    /// Adds vertices; returns the index of the first.
    pub(super) fn vertices(&mut self, vertices: &[DVec3]) -> u32 {
        let first = self.vertices.len() as u32;
        self.vertices.extend_from_slice(vertices);
        first
    }

    /// Adds triangles whose indices count from the vertex `first`.
    pub(super) fn triangles(&mut self, first: u32, triangles: &[[u32; 3]], surface: SurfaceId) {
        for triangle in triangles {
            let triangle = triangle.map(|v| first.saturating_add(v));
            // `build` refuses invalid indices.
            let corner = |v: u32| self.vertices.get(v as usize).copied().unwrap_or(DVec3::NAN);
            let shape = EmitterShape::Triangle(triangle.map(corner));
            let emitter = self.emitter(surface, shape);
            self.triangle(triangle, surface, emitter);
        }
    }

    /// Adds a parallelogram as two triangles and, if it emits, one emitter. Its front is where
    /// `edges[0] × edges[1]` points.
    pub fn rectangle(&mut self, corner: DVec3, edges: [DVec3; 2], surface: SurfaceId) {
        self.begin_object();
        let first = self.vertices.len() as u32;
        let [a, b] = edges;
        self.vertices
            .extend([corner, corner + a, corner + a + b, corner + b]);
        let emitter = self.emitter(surface, EmitterShape::Rectangle { corner, edges });
        self.triangle([first, first + 1, first + 2], surface, emitter);
        self.triangle([first, first + 2, first + 3], surface, emitter);
    }

    /// Adds a sphere or a zone of one.
    pub fn sphere(&mut self, sphere: Sphere, surface: SurfaceId) {
        self.begin_object();
        let emitter = self.emitter(surface, EmitterShape::Sphere(sphere));
        self.add_primitive(surface, emitter, PrimitiveShape::Sphere(sphere));
    }

    fn triangle(&mut self, vertices: [u32; 3], surface: SurfaceId, emitter: Option<u32>) {
        let normal = DVec3::ZERO;
        let shape = PrimitiveShape::Triangle { vertices, normal };
        self.add_primitive(surface, emitter, shape);
    }

    fn add_primitive(&mut self, surface: SurfaceId, emitter: Option<u32>, shape: PrimitiveShape) {
        self.primitives.push(ScenePrimitive {
            surface: surface.0,
            emitter,
            object: self.objects.saturating_sub(1),
            shape,
        });
    }

    fn emitter(&mut self, surface: SurfaceId, shape: EmitterShape) -> Option<u32> {
        let radiance = self.surfaces[surface.0 as usize].emission;
        (radiance != DVec3::ZERO).then(|| {
            self.emitters.push(Emitter::new(shape, radiance));
            self.emitters.len() as u32 - 1
        })
    }

    /// Validates the primitives and builds the acceleration structure.
    ///
    /// Surfaces that coincide, up to [`COINCIDENCE_TOLERANCE`] of the largest coordinate, are
    /// refused if it is visible which of them a ray meets. It is not visible if both have the same
    /// surface, which emits nothing and is neither mirror nor glass, nor between two closed opaque
    /// bodies. Where a closed body stands on an opaque sheet that is neither mirror nor light and
    /// covers its face wholly, that face is left out: the sheet is visible there.
    ///
    /// # Errors
    /// [`Error::Scene`] for a coordinate or radiance that is not finite or beyond [`LARGEST`], an
    /// albedo, absorption or roughness outside [0, 1], a negative radiance, an index that points
    /// nowhere, a triangle or a zone of a sphere of less than [`SMALLEST_AREA`], a camera that
    /// looks nowhere, surfaces that coincide.
    pub fn build(self, camera: Camera) -> Result<Scene, Error> {
        self.build_from(camera, 0.0)
    }

    /// Validates and builds as [`build`](Self::build), with a largest coordinate of at least
    /// `extent`.
    pub(super) fn build_from(mut self, camera: Camera, extent: f64) -> Result<Scene, Error> {
        self.check_surfaces()?;
        check_camera(&self.name, &camera)?;
        let mut geometry = Vec::with_capacity(self.primitives.len());
        let mut extent = camera.eye.abs().max_element().max(extent);
        for (i, primitive) in self.primitives.iter_mut().enumerate() {
            geometry.push(match &mut primitive.shape {
                PrimitiveShape::Triangle { vertices, normal } => {
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
                    Primitive::Triangle([a, b, c])
                }
                PrimitiveShape::Sphere(sphere) => {
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
                format!("it reaches to {extent:?}, farther than {LARGEST:?}: take another unit"),
            ));
        }
        let offset = extent * OFFSET;
        let mut hull = Hull::new(&geometry, offset);
        let mut bvh = hierarchy(&geometry, hull.as_ref());
        let shapes = Shapes {
            primitives: &self.primitives,
            surfaces: &self.surfaces,
            vertices: &self.vertices,
            bvh: &bvh,
            eye: camera.eye,
            tolerance: extent * COINCIDENCE_TOLERANCE,
            close_fraction: CLOSE_FRACTION,
        };
        let redundant_faces = shapes.redundant_faces().map_err(|overlap| {
            let message = shapes.describe(&overlap, &self.surface_names).to_string();
            invalid(&self.name, message)
        })?;
        let redundant_faces: Vec<(usize, ScenePrimitive)> = redundant_faces
            .into_iter()
            .map(|(face, _)| (face as usize, self.primitives[face as usize]))
            .collect();
        if !redundant_faces.is_empty() {
            let mut stays = vec![true; self.primitives.len()];
            redundant_faces
                .iter()
                .for_each(|(index, _)| stays[*index] = false);
            retain(&mut self.primitives, &stays);
            retain(&mut geometry, &stays);
            hull = Hull::new(&geometry, offset);
            bvh = hierarchy(&geometry, hull.as_ref());
        }
        Ok(Scene {
            bvh,
            redundant_faces,
            surface_names: self.surface_names,
            smallest_detail: smallest_detail(&self.primitives, &self.vertices),
            hull,
            specular_casters: SpecularCasters::new(&self.primitives, &self.surfaces, |corners| {
                corners.map(|v| self.vertices[v as usize])
            }),
            name: self.name,
            surfaces: self.surfaces,
            vertices: self.vertices,
            primitives: self.primitives,
            light_tree: LightTree::new(&self.emitters),
            power_light_sampler: PowerLightSampler::new(
                &self.emitters.iter().map(Emitter::power).collect::<Vec<_>>(),
            ),
            emitters: self
                .emitters
                .into_iter()
                .map(|emitter| emitter.with_offset(offset))
                .collect(),
            background: self.background,
            camera,
            offset,
            single_coincidence: OnceLock::new(),
            lane_data: (OnceLock::new(), OnceLock::new()),
        })
    }

    fn check_surfaces(&self) -> Result<(), Error> {
        let share = |v: DVec3| v.cmpge(DVec3::ZERO).all() && v.cmple(DVec3::ONE).all();
        let radiance =
            |v: DVec3| v.cmpge(DVec3::ZERO).all() && v.cmple(DVec3::splat(LARGEST)).all();
        if let Environment::Uniform(background) = self.background
            && !radiance(background)
        {
            let message = format!(
                "the background radiance {:?} must be from 0 to {LARGEST:?}",
                background.to_array()
            );
            return Err(invalid(&self.name, message));
        }
        for (i, surface) in self.surfaces.iter().enumerate() {
            let parameters_valid = match surface.bsdf {
                Bsdf::OrenNayar { constants, .. } => {
                    constants.a.is_finite() && constants.b.is_finite()
                }
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

/// Builds the hierarchy over the primitives of a scene with this hull.
fn hierarchy(primitives: &[Primitive], hull: Option<&Hull>) -> Bvh {
    match hull {
        Some(hull) => Bvh::with_walls(primitives, |id| hull.is_wall[id as usize]),
        None => Bvh::new(primitives),
    }
}

/// Keeps the items of a list that stay.
fn retain<T>(list: &mut Vec<T>, stays: &[bool]) {
    let mut stays = stays.iter();
    list.retain(|_| stays.next() == Some(&true));
}

/// Returns the unit normal of the front; `None` below [`SMALLEST_AREA`], and for vertices that are
/// not finite.
pub(super) fn triangle_normal([a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    let scaled = (b - a).cross(c - a);
    let sound = scaled.is_finite() && 0.5 * scaled.length() >= SMALLEST_AREA;
    if sound { scaled.try_normalize() } else { None }
}

/// Returns whether a sphere is finite and its zone has an area.
pub(super) fn is_sound(sphere: &Sphere) -> bool {
    let Sphere { centre, radius, .. } = *sphere;
    // An empty zone has an area of 0 or below, NaN is not above 0 either.
    centre.is_finite() && radius.is_finite() && radius > 0.0 && sphere.area() >= SMALLEST_AREA
}

/// Returns vertices and triangles of a closed axis-parallel box, its fronts inside or outside: two
/// consecutive triangles for each of its six faces.
pub fn cuboid(low: DVec3, high: DVec3, inward: bool) -> ([DVec3; 8], [[u32; 3]; 12]) {
    let vertices = std::array::from_fn(|i| {
        DVec3::select(glam::BVec3::new(i & 1 > 0, i & 2 > 0, i & 4 > 0), high, low)
    });
    let quads = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
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
         sight, and half of a height above 0 and up to {MAX_HALF_HEIGHT:?}"
    );
    Err(invalid(scene, needs))
}

pub(super) fn invalid(scene: &str, message: String) -> Error {
    Error::Scene {
        scene: scene.to_owned(),
        message,
    }
}
