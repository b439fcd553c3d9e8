//! Radiosity: global illumination of Lambert surfaces by finite elements instead of random paths.
//!
//! Direct light is computed where it is needed. Light that has been reflected at least once is
//! solved for on a mesh, with radiosity constant over each patch and irradiance linear, and read
//! from the mesh. The method is deterministic: its error is that of the mesh, and refining the mesh
//! shows it.

mod direct;
mod mesh;
mod patch;

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

pub use mesh::{Element, Mesh, MeshResolution};
pub use patch::{Patch, SpherePatch, is_near};

use super::{Estimator, NextEvent, Parts, with_parts};
use crate::error::Error;
use crate::geometry::form_factor;
use crate::geometry::form_factor::Polygon;
use crate::geometry::shape::{Hit, Ray, SurfacePoint};
use crate::material::{Scattering, lambert};
use crate::sampling::sampler::Sampler;
use crate::scene::Scene;
use direct::Light;

/// Returns the radiance that leaves a Lambert surface, B/π of [`crate::equation::RADIOSITY`].
#[inline]
pub fn leaving(albedo: DVec3, emitted: DVec3, irradiance: DVec3) -> DVec3 {
    emitted + lambert(albedo) * irradiance
}

/// Largest residual of a converged solution: the deviation of a patch's radiance, relative to the
/// largest radiance.
pub const RESIDUAL: f64 = 1e-6;
/// Maximum number of sweeps without convergence; only needed if the albedo of a closed scene is 1
/// or very close.
const MAX_SWEEPS: u32 = 10_000;
/// Largest memory of the form factors, in bytes.
pub const MAX_MEMORY: u64 = 3 << 30;

/// A form factor from a node to an element.
#[derive(Clone, Copy, Debug)]
struct Link {
    element: u32,
    factor: f32,
}

/// Form factors from every node of a mesh to every element that it sees.
#[derive(Clone, Debug)]
pub struct FormFactors {
    rows: Vec<Box<[Link]>>,
}

impl FormFactors {
    /// Computes the form factors: each pair in closed form where it is flat, times the visibility
    /// of one point in the middle of the visible part. `row_done` is called after each node with 1,
    /// from any thread; if it returns false, the computation stops.
    ///
    /// # Errors
    /// [`Error::Option`] before any work if they may take more than [`MAX_MEMORY`];
    /// [`Error::Interrupted`].
    pub fn new(
        parts: Parts<'_>,
        scene: &Scene,
        mesh: &Mesh,
        row_done: &(dyn Fn(u64) -> bool + Sync),
    ) -> Result<Self, Error> {
        check_memory(mesh)?;
        let rows = mesh
            .nodes
            .par_iter()
            .map(|node| {
                let row = with_parts!(parts, |parts| row(parts, scene, mesh, node));
                row_done(1).then_some(row).ok_or(Error::Interrupted)
            })
            .collect::<Result<_, _>>()?;
        Ok(Self { rows })
    }

    /// Iterates over the elements that a node sees: index and form factor F.
    fn of_node(&self, node: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let pair = |link: &Link| (link.element as usize, f64::from(link.factor));
        self.rows[node].iter().map(pair)
    }

    /// Returns F from an element to every element: the mean over its nodes.
    pub fn of_element(&self, mesh: &Mesh, element: usize) -> Vec<f64> {
        let mut factors = vec![0.0; mesh.elements.len()];
        let nodes = mesh.elements[element].nodes.clone();
        let share = 1.0 / nodes.len() as f64;
        for (other, factor) in nodes.flat_map(|node| self.of_node(node)) {
            factors[other] += share * factor;
        }
        factors
    }

    /// Returns the irradiance at a node from elements with these radiances, divided by π.
    fn gather(&self, node: usize, radiances: &[DVec3]) -> DVec3 {
        self.of_node(node)
            .map(|(element, factor)| factor * radiances[element])
            .sum()
    }
}

fn row<P: FiniteElements + NextEvent + Scattering + ?Sized>(
    parts: &P,
    scene: &Scene,
    mesh: &Mesh,
    node: &SurfacePoint,
) -> Box<[Link]> {
    let link = |(element, view): (u32, patch::PatchView)| {
        parts
            .visible(scene, *node, view.target, false)
            .then_some(Link {
                element,
                factor: view.factor as f32,
            })
    };
    (0..)
        .zip(&mesh.elements)
        .filter_map(|(i, element)| {
            let view = element.patch.view(parts, node.point, node.normal)?;
            link((i, view))
        })
        .collect()
}

/// Refuses a mesh whose form factors may take more than [`MAX_MEMORY`]. Of the four pairs of sides
/// of two patches at most one can see the other, unless a patch is cut by the plane of the other.
///
/// # Errors
/// [`Error::Option`].
pub fn check_memory(mesh: &Mesh) -> Result<(), Error> {
    let [nodes, elements] = [mesh.nodes.len(), mesh.elements.len()].map(|n| n as u64 / 2);
    refuse_memory(nodes, elements)
}

/// Implements [`check_memory`], from the numbers of nodes and elements on one side.
fn refuse_memory(nodes: u64, elements: u64) -> Result<(), Error> {
    let bytes = nodes
        .saturating_mul(elements)
        .saturating_mul(size_of::<Link>() as u64);
    if bytes > MAX_MEMORY {
        return Err(Error::Option(format!(
            "the form factors of {elements} patches take up to {:.1} GiB of memory, more than {:.1}: \
             take fewer patches",
            bytes as f64 / 2f64.powi(30),
            MAX_MEMORY as f64 / 2f64.powi(30)
        )));
    }
    Ok(())
}

/// Where indirect light is evaluated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ReadOut {
    /// At the nodes of the mesh, and interpolated.
    #[default]
    Interpolated,
    /// At the shading point, from every patch that it sees ("final gather"): as expensive as a
    /// node.
    Gathered,
}

/// Radiosity solution of a scene. As an estimator it draws no random numbers; it must be used with
/// the scene for which it was computed.
#[derive(Clone, Debug)]
pub struct Radiosity<'a> {
    parts: Parts<'a>,
    mesh: Mesh,
    lights: Vec<Light>,
    /// Radiance that every element sends to others, without its emission.
    reflected: Vec<DVec3>,
    /// Irradiance at every node: direct, and from other elements.
    direct: Vec<DVec3>,
    indirect: Vec<DVec3>,
    residual: f64,
    sweeps: u32,
    read_out: ReadOut,
}

impl<'a> Radiosity<'a> {
    /// Solves for the light of a scene; `row_done` as for [`FormFactors::new`].
    ///
    /// # Errors
    /// Those of [`Mesh::new`] and [`FormFactors::new`]; [`Error::Scene`] if the solution does not
    /// converge.
    pub fn new(
        parts: Parts<'a>,
        scene: &Scene,
        resolution: MeshResolution,
        row_done: &(dyn Fn(u64) -> bool + Sync),
    ) -> Result<Self, Error> {
        let mesh = Mesh::new(scene, resolution)?;
        let factors = FormFactors::new(parts, scene, &mesh, row_done)?;
        let lights = Light::of(scene, mesh.target);
        let direct = mesh
            .nodes
            .par_iter()
            .map(|node| direct_irradiance(parts, scene, &lights, node))
            .collect();
        let mut solution = Self {
            reflected: vec![DVec3::ZERO; mesh.elements.len()],
            indirect: vec![DVec3::ZERO; mesh.nodes.len()],
            parts,
            mesh,
            lights,
            direct,
            residual: f64::INFINITY,
            sweeps: 0,
            read_out: ReadOut::default(),
        };
        solution.solve(scene, &factors)?;
        Ok(solution)
    }

    /// Returns the same solution with another read-out.
    pub fn read(self, read_out: ReadOut) -> Self {
        Self { read_out, ..self }
    }

    /// Solves by Gauss-Seidel iteration: each sweep updates every element from the newest radiances
    /// of the others. The errors shrink at least as the powers of the largest albedo.
    fn solve(&mut self, scene: &Scene, factors: &FormFactors) -> Result<(), Error> {
        while !self.parts.has_converged(self.residual, self.sweeps) {
            if self.sweeps == MAX_SWEEPS || self.residual.is_nan() {
                return Err(Error::Scene {
                    scene: scene.name().to_owned(),
                    message: "the solution does not converge: some albedo is too close to 1"
                        .to_owned(),
                });
            }
            for i in 0..self.reflected.len() {
                self.reflected[i] =
                    self.updated(i, |node| PI * factors.gather(node, &self.reflected));
            }
            for node in 0..self.indirect.len() {
                self.indirect[node] = PI * factors.gather(node, &self.reflected);
            }
            self.sweeps += 1;
            self.residual = self.largest_residual();
            self.check_numbers()?;
        }
        Ok(())
    }

    /// Refuses irradiances that are NaN, which maxima ignore; overflow is detected by the residual.
    fn check_numbers(&self) -> Result<(), Error> {
        let mut nodes = self.mesh.nodes.iter().zip(&self.direct).zip(&self.indirect);
        match nodes.find(|((_, direct), indirect)| (**direct + **indirect).is_nan()) {
            Some(((node, _), _)) if !self.residual.is_nan() => Err(Error::Radiance {
                value: f64::NAN,
                place: format!(" as the irradiance at {}", node.point),
            }),
            _ => Ok(()),
        }
    }

    /// Returns the radiance that an element sends if its nodes have this irradiance from others;
    /// its irradiance is the mean over the nodes.
    fn updated(&self, element: usize, indirect: impl Fn(usize) -> DVec3) -> DVec3 {
        let Element {
            albedo,
            emission,
            ref nodes,
            ..
        } = self.mesh.elements[element];
        let count = nodes.len() as f64;
        let irradiance: DVec3 = nodes.clone().map(|n| self.direct[n] + indirect(n)).sum();
        let leaving = self.parts.leaving(albedo, emission, irradiance / count);
        self.parts.reflected(leaving, emission)
    }

    fn largest_residual(&self) -> f64 {
        let (mut error, mut largest) = (0.0_f64, 0.0_f64);
        for (i, sent) in self.reflected.iter().enumerate() {
            let updated = self.updated(i, |node| self.indirect[node]);
            error = error.max((updated - *sent).abs().max_element());
            largest = largest.max(sent.max_element());
        }
        match largest {
            // With infinite radiance the relative error is undefined.
            f64::INFINITY => f64::NAN,
            0.0 => 0.0,
            _ => error / largest,
        }
    }

    /// Returns the largest difference between the two sides of (radiosity), relative to the largest
    /// radiance.
    pub fn residual(&self) -> f64 {
        self.residual
    }

    /// Returns the number of sweeps.
    pub fn sweeps(&self) -> u32 {
        self.sweeps
    }

    /// Iterates over both sides of every patch, with their mean irradiance.
    pub fn irradiances(&self) -> impl Iterator<Item = (&Element, DVec3)> {
        self.mesh.elements.iter().map(|element| {
            let nodes = element.nodes.clone();
            let sum: DVec3 = nodes.map(|n| self.direct[n] + self.indirect[n]).sum();
            (element, sum / element.nodes.len() as f64)
        })
    }

    /// Returns the irradiance at a point that a ray hit; zero on black surfaces.
    pub fn irradiance(&self, scene: &Scene, ray: &Ray, hit: &Hit) -> DVec3 {
        let Some((element, weights)) = self.mesh.locate(hit, ray) else {
            return DVec3::ZERO;
        };
        let at = SurfacePoint {
            point: hit.point,
            normal: hit.normal * -hit.normal.dot(ray.direction).signum(),
        };
        let direct = direct_irradiance(self.parts, scene, &self.lights, &at);
        let indirect = match self.read_out {
            ReadOut::Interpolated => {
                let nodes = element.nodes.clone().zip(weights);
                let sum: DVec3 = nodes.map(|(node, w)| w * self.indirect[node]).sum();
                // At light boundaries linear extrapolation from the nodes can fall below zero.
                sum.max(DVec3::ZERO)
            }
            ReadOut::Gathered => {
                let links = with_parts!(self.parts, |parts| row(parts, scene, &self.mesh, &at));
                let sent =
                    |link: &Link| f64::from(link.factor) * self.reflected[link.element as usize];
                PI * links.iter().map(sent).sum::<DVec3>()
            }
        };
        direct + indirect
    }
}

/// Returns the irradiance from all emitters.
fn direct_irradiance(
    parts: Parts<'_>,
    scene: &Scene,
    lights: &[Light],
    at: &SurfacePoint,
) -> DVec3 {
    with_parts!(parts, |parts| lights
        .iter()
        .map(|light| light.irradiance(parts, scene, at))
        .sum())
}

impl Estimator for Radiosity<'_> {
    fn radiance(
        &self,
        scene: &Scene,
        ray: &Ray,
        hit: Option<Hit>,
        _rng: &mut dyn Sampler,
    ) -> DVec3 {
        let Some(hit) = hit else {
            return scene.background().radiance(ray.direction);
        };
        let albedo = scene.surface(&hit).bsdf.albedo();
        let irradiance = self.irradiance(scene, ray, &hit);
        self.parts
            .leaving(albedo, scene.emitted(&hit, ray.direction), irradiance)
    }
}

/// Replaceable parts of radiosity.
pub trait FiniteElements: Sync {
    /// Returns the form factor of a polygon above the horizon, relative to the receiver.
    #[inline]
    fn form_factor(&self, normal: DVec3, corners: &[DVec3]) -> f64 {
        form_factor::polygon(normal, corners)
    }
    /// Returns the weight of a point of an emitter in its visible fraction: the geometry term, from
    /// the receiver's cosine and the solid angle per area.
    #[inline]
    fn visibility_weight(&self, cosine: f64, solid_angle: f64) -> f64 {
        cosine * solid_angle
    }
    /// Returns whether a part of a sphere is so close, for its area, that it is divided.
    #[inline]
    fn is_near(&self, area: f64, distance_squared: f64) -> bool {
        is_near(area, distance_squared)
    }
    /// Returns the part of a polygon above the horizon.
    #[inline]
    fn clip_to_horizon(&self, normal: DVec3, polygon: &Polygon) -> Polygon {
        polygon.clip_to_horizon(normal)
    }
    /// Returns the radiance that leaves a Lambert surface.
    #[inline]
    fn leaving(&self, albedo: DVec3, emitted: DVec3, irradiance: DVec3) -> DVec3 {
        leaving(albedo, emitted, irradiance)
    }
    /// Returns the part of the leaving radiance that patches exchange: all except emission, which
    /// is direct light.
    #[inline]
    fn reflected(&self, leaving: DVec3, emitted: DVec3) -> DVec3 {
        leaving - emitted
    }
    /// Returns whether the solution has converged after this number of sweeps.
    #[inline]
    fn has_converged(&self, residual: f64, _sweeps: u32) -> bool {
        residual <= RESIDUAL
    }
}
