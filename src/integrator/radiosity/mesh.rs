//! Radiosity mesh: every triangle and sphere of a scene divided into patches with two sides.

use std::f64::consts::TAU;
use std::ops::Range;

use glam::DVec3;

use super::patch::{Patch, SpherePatch};
use crate::error::Error;
use crate::geometry::shape::{Hit, Ray, Sphere, SurfacePoint};
use crate::material::Bsdf;
use crate::math::frame::azimuth;
use crate::scene::{Geometry, Scene, Surface};

/// Resolution of the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshResolution {
    /// Approximate number of patches over all surfaces; each primitive has at least one, a sphere
    /// at least six.
    pub patches: u32,
    /// Number of times that the sides of all these patches are halved.
    pub halvings: u32,
}

impl Default for MeshResolution {
    /// 2000 patches, not halved.
    fn default() -> Self {
        Self {
            patches: 2000,
            halvings: 0,
        }
    }
}

/// One side of a patch.
#[derive(Clone, Debug)]
pub struct Element {
    /// Shape of the patch.
    pub patch: Patch,
    /// Albedo ρ.
    pub albedo: DVec3,
    /// Emitted radiance; zero for backs.
    pub emission: DVec3,
    /// Area of the patch.
    pub area: f64,
    pub(super) nodes: Range<usize>,
}

/// Division of a primitive; the elements of the front start at index `first`, followed by those of
/// the back.
#[derive(Clone, Debug)]
enum Division {
    /// Black: arriving light is absorbed.
    Black,
    Triangle {
        corners: [DVec3; 3],
        /// Number of parts of each edge.
        parts: u32,
        first: usize,
    },
    Sphere {
        sphere: Sphere,
        /// Number of columns and first element of each band, from the upper end.
        bands: Vec<(usize, usize)>,
        /// Number of elements of one side.
        count: usize,
    },
}

/// Patches of a scene.
#[derive(Clone, Debug)]
pub struct Mesh {
    pub(super) elements: Vec<Element>,
    /// Points at which irradiance is computed.
    pub(super) nodes: Vec<SurfacePoint>,
    divisions: Vec<Division>,
    /// Target area of patches.
    pub(super) target: f64,
}

impl Mesh {
    /// Divides the reflecting surfaces of a scene. Triangles are divided into n² equal ones,
    /// spheres along circles of latitude and meridians. Nodes are the points at which the mean of a
    /// quadratic over the patch is exact: three of a triangle (Hammer and Stroud 1956), 2 × 2 Gauss
    /// points of a sphere's patch in height and azimuth.
    ///
    /// # Errors
    /// [`Error::Scene`] for mirrors, glass, Oren-Nayar surfaces and a background that emits;
    /// [`Error::Option`] for no patches.
    pub fn new(scene: &Scene, resolution: MeshResolution) -> Result<Self, Error> {
        check(scene, resolution)?;
        let reflects = |surface: &Surface| surface.bsdf.albedo() != DVec3::ZERO;
        let total: f64 = scene
            .primitives()
            .map(|(geometry, _)| area(&geometry))
            .sum();
        let target = total / f64::from(resolution.patches);
        let mut mesh = Self {
            elements: Vec::new(),
            nodes: Vec::new(),
            divisions: Vec::new(),
            target: target * 0.25f64.powi(resolution.halvings as i32),
        };
        for (geometry, surface) in scene.primitives() {
            let division = if reflects(surface) {
                mesh.divide(&geometry, surface, target, resolution.halvings)
            } else {
                Division::Black
            };
            mesh.divisions.push(division);
        }
        Ok(mesh)
    }

    /// Returns both sides of all patches.
    pub fn elements(&self) -> &[Element] {
        &self.elements
    }

    /// Returns the number of points at which irradiance is computed.
    pub fn nodes(&self) -> usize {
        self.nodes.len()
    }

    fn divide(
        &mut self,
        geometry: &Geometry,
        surface: &Surface,
        target: f64,
        halvings: u32,
    ) -> Division {
        match *geometry {
            Geometry::Triangle(corners) => {
                let parts = ((area(geometry) / target).sqrt().ceil() as u32).max(1) << halvings;
                let first = self.elements.len();
                for front in [true, false] {
                    for corners in split(corners, parts) {
                        let nodes = triangle_nodes(corners);
                        let patch = Patch::flat(corners, front);
                        self.push(patch, &nodes, surface, front);
                    }
                }
                Division::Triangle {
                    corners,
                    parts,
                    first,
                }
            }
            Geometry::Sphere(sphere) => {
                let first = self.elements.len();
                for front in [true, false] {
                    for patch in sphere_patches(&sphere, front, target, halvings).concat() {
                        self.push(Patch::Curved(patch), &patch.nodes(), surface, front);
                    }
                }
                let bands = sphere_patches(&sphere, true, target, halvings);
                let mut start = first;
                let place = |band: &Vec<SpherePatch>| {
                    let place = (band.len(), start);
                    start += band.len();
                    place
                };
                Division::Sphere {
                    sphere,
                    bands: bands.iter().map(place).collect(),
                    count: (self.elements.len() - first) / 2,
                }
            }
        }
    }

    fn push(&mut self, patch: Patch, points: &[DVec3], surface: &Surface, front: bool) {
        let start = self.nodes.len();
        self.nodes.extend(points.iter().map(|&point| SurfacePoint {
            point,
            normal: patch.normal(point),
        }));
        self.elements.push(Element {
            area: patch.area(),
            patch,
            albedo: surface.bsdf.albedo(),
            emission: if front { surface.emission } else { DVec3::ZERO },
            nodes: start..self.nodes.len(),
        });
    }

    /// Returns the element that a ray hit, and the interpolation weights of its nodes at the point:
    /// linear on triangles, bilinear in height and azimuth on spheres. `None` on black surfaces.
    pub(super) fn locate(&self, hit: &Hit, ray: &Ray) -> Option<(&Element, [f64; 4])> {
        let front = hit.normal.dot(ray.direction) < 0.0;
        match &self.divisions[hit.primitive as usize] {
            Division::Black => None,
            Division::Triangle {
                corners,
                parts,
                first,
            } => {
                let (place, weights) = locate_in_triangle(*corners, *parts, hit.point);
                let back = if front { 0 } else { (parts * parts) as usize };
                Some((&self.elements[first + back + place], weights))
            }
            Division::Sphere {
                sphere,
                bands,
                count,
            } => {
                let offset = (hit.point - sphere.centre) / sphere.radius;
                let [top, bottom] = inclinations(sphere);
                let down = (offset.z.clamp(-1.0, 1.0).acos() - top) / (bottom - top);
                let band = ((down * bands.len() as f64) as usize).min(bands.len() - 1);
                let (columns, first) = bands[band];
                let turn = azimuth(offset) / TAU * columns as f64;
                let column = (turn as usize).min(columns - 1);
                let back = if front { 0 } else { *count };
                let element = &self.elements[first + back + column];
                let Patch::Curved(patch) = &element.patch else {
                    return None;
                };
                Some((element, patch.weights(offset.z, azimuth(offset))))
            }
        }
    }
}

/// Number of patches above which a mesh is refused before it is built.
const MAX_PATCHES: u64 = 100_000;

/// Refuses scenes and meshes that radiosity does not support.
fn check(scene: &Scene, resolution: MeshResolution) -> Result<(), Error> {
    if resolution.patches == 0 || resolution.halvings > 8 {
        return Err(Error::Option(format!(
            "{} patches halved {} times: a mesh needs at least one patch and at most 8 halvings",
            resolution.patches, resolution.halvings
        )));
    }
    // Far beyond this limit the mesh itself would not fit: a patch has about half a node of its
    // own.
    let patches = u64::from(resolution.patches) << (2 * resolution.halvings);
    if patches > MAX_PATCHES {
        crate::integrator::radiosity::refuse_memory(patches / 2, patches)?;
    }
    let refuse = |what: &str| {
        Err(Error::Scene {
            scene: scene.name().to_owned(),
            message: format!(
                "radiosity supports only Lambert and black surfaces and a black background; this scene has {what}"
            ),
        })
    };
    if !scene.background().is_black() {
        return refuse("a background that emits");
    }
    for (_, surface) in scene.primitives() {
        match surface.bsdf {
            Bsdf::Mirror { .. } => return refuse("mirrors"),
            Bsdf::Glass { .. } => return refuse("glass"),
            Bsdf::Black | Bsdf::Lambert { .. } => {}
            _ => return refuse("rough surfaces"),
        }
    }
    Ok(())
}

fn area(geometry: &Geometry) -> f64 {
    match geometry {
        Geometry::Triangle([a, b, c]) => 0.5 * (b - a).cross(c - a).length(),
        Geometry::Sphere(sphere) => sphere.area(),
    }
}

/// Returns the inclinations of the upper and lower end of a sphere's zone.
fn inclinations(sphere: &Sphere) -> [f64; 2] {
    let [low, high] = sphere.heights().map(|z| z / sphere.radius);
    [high.acos(), low.acos()]
}

/// Divides the front (or back) of a sphere's zone into patches of about the area `target`, in bands
/// from the upper end, and halves both sides of each the given number of times.
pub(super) fn sphere_patches(
    sphere: &Sphere,
    front: bool,
    target: f64,
    halvings: u32,
) -> Vec<Vec<SpherePatch>> {
    let side = target.sqrt();
    let [top, bottom] = inclinations(sphere);
    let coarse = ((sphere.radius * (bottom - top) / side).ceil() as u32).max(2);
    let bands = coarse << halvings;
    let inclination = |share: f64| top + (bottom - top) * share;
    let height = |band: u32| inclination(f64::from(band) / f64::from(bands)).cos();
    let band = |band: u32| {
        // The number of columns of the band that was halved.
        let middle = inclination((f64::from(band >> halvings) + 0.5) / f64::from(coarse));
        let around = TAU * sphere.radius * middle.sin();
        let columns = ((around / side).ceil() as u32).max(3) << halvings;
        let turn = |column: u32| TAU * f64::from(column) / f64::from(columns);
        let patch = |column: u32| SpherePatch {
            centre: sphere.centre,
            radius: sphere.radius,
            heights: [height(band), height(band + 1)],
            azimuths: [turn(column), turn(column + 1)],
            outward: front != sphere.inward,
        };
        (0..columns).map(patch).collect()
    };
    (0..bands).map(band).collect()
}

/// Splits a triangle into n² equal parts, row by row along its second edge.
fn split([a, b, c]: [DVec3; 3], n: u32) -> Vec<[DVec3; 3]> {
    let step = |k: u32| f64::from(k) / f64::from(n);
    let corner = move |i: u32, j: u32| a + step(i) * (b - a) + step(j) * (c - a);
    let mut parts = Vec::new();
    for i in 0..n {
        for j in 0..n - i {
            parts.push([corner(i, j), corner(i + 1, j), corner(i, j + 1)]);
            if i + j + 1 < n {
                parts.push([corner(i + 1, j + 1), corner(i, j + 1), corner(i + 1, j)]);
            }
        }
    }
    parts
}

/// Returns the index of the part that contains a point, in the order of [`split`], and the weights
/// of its nodes.
fn locate_in_triangle([a, b, c]: [DVec3; 3], n: u32, point: DVec3) -> (usize, [f64; 4]) {
    let across = (b - a).cross(c - a);
    let squared = across.length_squared();
    let [u, v] = [(point - a).cross(c - a), (b - a).cross(point - a)]
        .map(|part| (part.dot(across) / squared).max(0.0) * f64::from(n));
    let i = (u as u32).min(n - 1);
    let j = (v as u32).min(n - 1 - i);
    let [s, t] = [u - f64::from(i), v - f64::from(j)];
    let upper = s + t > 1.0 && i + j + 1 < n;
    let [i, j, n] = [i, j, n].map(|k| k as usize);
    let place = 2 * n * i - i * i + 2 * j + usize::from(upper);
    let barycentric = if upper {
        [s + t - 1.0, 1.0 - s, 1.0 - t]
    } else {
        [1.0 - s - t, s, t]
    };
    // Linear, 1 at the node near its corner and 0 at the other two.
    let [w0, w1, w2] = barycentric.map(|w| 2.0 * w - 1.0 / 3.0);
    (place, [w0, w1, w2, 0.0])
}

fn triangle_nodes([a, b, c]: [DVec3; 3]) -> [DVec3; 3] {
    let sixth = (a + b + c) / 6.0;
    [a, b, c].map(|corner| sixth + 0.5 * corner)
}
