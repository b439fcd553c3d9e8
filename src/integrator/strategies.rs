//! Strategies of bidirectional path tracing that sample the same path, and their MIS weights.
//!
//! A path x₀ … x_k from an emitter to the eye is made by s vertices from the light and k + 1 − s
//! from the eye. Its densities are functions of the path alone, so all strategies agree on them and
//! the weights sum to one. Survival by Russian roulette is left out of all of them: it depends on
//! how a path was sampled, and any weights that sum to one are unbiased.

use glam::DVec3;

use crate::camera::Camera;
use crate::light::emitter::EmitterPoint;
use crate::material::{Bsdf, Scattering, Vertex};

use super::direct_light::light_sampling_pdf;
use super::light_sampling::point_pdf;
use super::{NextEvent, PathParts};
use crate::scene::Scene;

/// A vertex of a light path or an eye path.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathVertex<'a> {
    /// Vertex with its normal on the side to which the path continues.
    pub at: Vertex,
    /// BSDF of the surface; `None` where a particle starts, by the cosine.
    pub bsdf: Option<&'a Bsdf>,
    /// Throughput of a particle: radiance per pdf of its point on the emitter, or flux that arrives
    /// at the surface. Zero on eye paths, which do not use it.
    pub throughput: DVec3,
    /// n² of the medium of the incoming edge, relative to the medium in which the subpath began.
    pub eta_squared: f64,
    /// Index of the emitter at this vertex, if there is one.
    pub emitter: Option<u32>,
    /// [`light_sampling_pdf`] of a particle's start from its next vertex, once that is known.
    pub sampling_pdf: Option<f64>,
    /// Edge to the previous vertex of its own subpath, if there is one.
    edge: Option<Edge>,
}

/// Straight segment between a vertex and a neighbour.
#[derive(Clone, Copy, Debug)]
struct Edge {
    direction: DVec3,
    /// Cosines between the segment and the normals at both ends.
    cosines: [f64; 2],
    /// Solid angle per area: of the first end seen from the second, and of the second from the
    /// first.
    per_area: [f64; 2],
}

impl Edge {
    #[inline]
    fn new<P: NextEvent + ?Sized>(parts: &P, a: &PathVertex<'_>, b: &PathVertex<'_>) -> Self {
        let offset = b.at.point - a.at.point;
        let (direction, distance_squared) = (offset.normalize(), offset.length_squared());
        let cosines = [a, b].map(|x| x.normal().dot(direction).abs());
        let per_area = cosines.map(|cosine| parts.solid_angle_per_area(cosine, distance_squared));
        Self {
            direction,
            cosines,
            per_area,
        }
    }

    #[inline]
    fn reversed(self) -> Self {
        let ([a, b], [c, d]) = (self.cosines, self.per_area);
        Self {
            direction: -self.direction,
            cosines: [b, a],
            per_area: [d, c],
        }
    }
}

/// Area densities of a vertex of a full path, given the rest of the subpath.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Density {
    /// p_L: density of the vertex on a subpath from the light.
    pub light: f64,
    /// p_E: density of the vertex on a subpath from the eye.
    pub eye: f64,
    /// 0 if no strategy connects this vertex and the next towards the eye, else 1; at the emitter,
    /// the density with which a shadow ray from the next vertex picks this one, relative to
    /// subpaths that start here.
    pub connectible: f64,
}

/// A full path as the two subpaths that were connected.
#[derive(Clone, Copy)]
pub(super) struct FullPath<'a> {
    /// Vertices of the light path, from the emitter on.
    pub light: &'a [PathVertex<'a>],
    /// Vertices of the eye path, from the first hit of the camera ray on.
    pub eye: &'a [PathVertex<'a>],
    /// Position of the eye.
    pub origin: DVec3,
    /// Pdf of the camera ray with respect to solid angle, with as many camera rays as particles.
    pub camera_pdf: f64,
}

impl FullPath<'_> {
    /// Computes the densities of all vertices except the eye, from the emitter on.
    ///
    /// The Dirac distributions of the two subpaths at a mirror or glass have the ratio of their n²
    /// cos θ, which stands for each (Veach 1997, 5.2).
    pub fn densities<P: PathParts + ?Sized>(
        &self,
        parts: &P,
        scene: &Scene,
        path: &mut Vec<Density>,
    ) {
        let (s, count) = (self.light.len(), self.light.len() + self.eye.len());
        let vertex = |i: usize| {
            if i < s {
                &self.light[i]
            } else {
                &self.eye[count - 1 - i]
            }
        };
        path.clear();
        if count == 0 {
            return;
        }
        let mut a = vertex(0);
        // An emitter is where a light path starts, whatever its BSDF.
        let mut a_is_specular = false;
        let mut start = Density {
            light: 0.0,
            eye: 0.0,
            connectible: 1.0,
        };
        if let Some(emitter) = a.emitter {
            let emitter = emitter as usize;
            start.light = point_pdf(parts, scene, emitter);
            if count > 1 {
                let sampling_pdf =
                    || light_sampling_pdf(parts, scene, emitter, &a.at, self.point(1));
                start.connectible = a.sampling_pdf.unwrap_or_else(sampling_pdf) / start.light;
            }
        }
        path.push(start);
        for i in 0..count - 1 {
            let b = vertex(i + 1);
            let b_is_specular = b.is_specular();
            // The subpaths have measured all edges but the connection.
            let known = if i + 1 < s {
                b.edge.map(Edge::reversed)
            } else {
                a.edge.filter(|_| i >= s)
            };
            let edge = known.unwrap_or_else(|| Edge::new(parts, a, b));
            let (direction, [cos_a, cos_b], per_area) =
                (edge.direction, edge.cosines, edge.per_area);
            let index = if i + 1 < s { b } else { a }.eta_squared;
            let before = || i.checked_sub(1).map(|i| self.point(i));
            let after = || Some(self.point(i + 2));
            path[i].connectible *= f64::from(!b_is_specular);
            path[i].eye =
                b.density(parts, b_is_specular, -direction, cos_b, index, after) * per_area[0];
            path.push(Density {
                light: a.density(parts, a_is_specular, direction, cos_a, index, before)
                    * per_area[1],
                eye: 0.0,
                connectible: f64::from(!b_is_specular),
            });
            (a, a_is_specular) = (b, b_is_specular);
        }
        if let (Some(last), Some(density)) =
            (self.eye.first().or(self.light.last()), path.last_mut())
        {
            let offset = self.origin - last.at.point;
            // Where an eye lies within an emitter, rays may meet it at the eye itself, which no
            // particle finds.
            density.eye = if offset == DVec3::ZERO {
                f64::INFINITY
            } else {
                let cosine = last.normal().dot(offset.normalize()).abs();
                self.camera_pdf * parts.solid_angle_per_area(cosine, offset.length_squared())
            };
        }
    }

    /// Returns the position of a vertex, counted from the emitter; the last is the eye.
    fn point(&self, i: usize) -> DVec3 {
        let s = self.light.len();
        match self.light.get(i) {
            Some(vertex) => vertex.at.point,
            None if i < s + self.eye.len() => self.eye[s + self.eye.len() - 1 - i].at.point,
            None => self.origin,
        }
    }
}

impl<'a> PathVertex<'a> {
    /// Creates the vertex on an emitter where a particle with this throughput starts.
    #[inline]
    pub fn emitting(point: &EmitterPoint, throughput: DVec3, emitter: usize) -> Self {
        let at = Vertex::emitting(point.point, point.normal);
        Self::new(at, None, throughput, 1.0, Some(emitter as u32))
    }

    /// Returns this vertex with its edge to the last vertex of its subpath.
    #[inline]
    pub fn after<P: NextEvent + ?Sized>(self, parts: &P, walk: &[Self]) -> Self {
        Self {
            edge: walk.last().map(|before| Edge::new(parts, &self, before)),
            ..self
        }
    }

    /// Creates a vertex without an edge.
    #[inline]
    pub fn new(
        at: Vertex,
        bsdf: Option<&'a Bsdf>,
        throughput: DVec3,
        eta_squared: f64,
        emitter: Option<u32>,
    ) -> Self {
        Self {
            at,
            bsdf,
            throughput,
            eta_squared,
            emitter,
            sampling_pdf: None,
            edge: None,
        }
    }

    /// Returns the unit normal on the side to which the path continues.
    #[inline]
    pub fn normal(&self) -> DVec3 {
        self.at.frame.z
    }

    /// Returns the radiance in a unit direction, per density of particles on the area.
    #[inline]
    pub fn outgoing_radiance<P: Scattering + ?Sized>(&self, parts: &P, direction: DVec3) -> DVec3 {
        match self.bsdf {
            None => self.throughput,
            Some(bsdf) => {
                self.throughput * parts.brdf(bsdf, self.at.frame.local(direction), self.at.wo)
            }
        }
    }

    /// Returns whether the vertex is on a mirror or glass, where no connection ends.
    #[inline]
    fn is_specular(&self) -> bool {
        self.bsdf.is_some_and(Bsdf::is_specular)
    }

    /// Returns the density, with respect to solid angle, with which subpaths continue in a unit
    /// direction with this cosine, if they come from a point (`None` if they start here).
    /// `specular` stands for the Dirac distribution of a mirror or glass.
    #[inline]
    fn density<P: Scattering + ?Sized>(
        &self,
        parts: &P,
        specular: bool,
        direction: DVec3,
        cosine: f64,
        eta_squared: f64,
        from: impl FnOnce() -> Option<DVec3>,
    ) -> f64 {
        if specular {
            return eta_squared * cosine;
        }
        if let Some(bsdf) = self.bsdf.filter(|bsdf| !bsdf.is_sampled_by_cosine())
            && let Some(from) = from()
        {
            let above = |direction: DVec3| {
                let local = self.at.frame.local(direction);
                local.with_z(local.z.abs())
            };
            return parts.pdf(
                bsdf,
                above((from - self.at.point).normalize()),
                above(direction),
            );
        }
        parts.cosine_hemisphere_pdf(cosine)
    }
}

/// Returns w_s of [`crate::equation::PATH_DENSITY`], the balance heuristic: the weight of the
/// strategy with `s` light vertices, given the densities of all path vertices except the eye, from
/// the light on.
pub fn weight(path: &[Density], s: usize) -> f64 {
    let connectible = |s: usize| if s == 0 { 1.0 } else { path[s - 1].connectible };
    let mut sum = connectible(s);
    let mut ratio = 1.0;
    for (i, vertex) in path.iter().enumerate().skip(s) {
        ratio = times(ratio, vertex.light, vertex.eye);
        sum += times(ratio, connectible(i + 1), 1.0);
    }
    ratio = 1.0;
    for (i, vertex) in path.iter().enumerate().take(s).rev() {
        ratio = times(ratio, vertex.eye, vertex.light);
        sum += times(ratio, connectible(i), 1.0);
    }
    connectible(s) / sum
}

/// Multiplies `ratio` by the ratio of two densities. Where an edge lies in a surface, densities at
/// both its ends are 0, and 0 · ∞ would be undefined: a density of 0 makes the result 0.
#[inline]
fn times(ratio: f64, density: f64, other: f64) -> f64 {
    if density == 0.0 || ratio == 0.0 {
        0.0
    } else {
        ratio * (density / other)
    }
}

/// Replaceable parts of bidirectional path tracing.
pub trait Bidirectional: Sync {
    /// Returns the factor by which refraction scales the flux of a particle: 1, unlike for
    /// radiance.
    #[inline]
    fn flux_factor(&self, _radiance_factor: f64) -> f64 {
        1.0
    }
    /// Returns the importance W(ω) of the pixel through which a direction leaves the eye.
    #[inline]
    fn importance(&self, camera: &Camera, size: [u32; 2], direction: DVec3) -> f64 {
        camera.importance(size, direction)
    }
    /// Returns the MIS weight of the strategy with `s` light vertices among all that sample the
    /// same path.
    #[inline]
    fn strategy_weight(&self, path: &[Density], s: usize) -> f64 {
        weight(path, s)
    }
}
