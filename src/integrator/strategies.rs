//! The strategies that make one and the same path from the light to the eye, and their weights.
//!
//! A path x₀ … x_k from an emitter to the eye is made by s vertices from the light and k + 1 − s
//! from the eye. Its densities are functions of the path alone, so all strategies agree on them and
//! the weights sum to one. Survival by Russian roulette is left out of all of them: it depends on
//! the way a path was made, and any weights that sum to one are unbiased.

use glam::DVec3;

use crate::camera::Camera;
use crate::light::emitter::EmitterPoint;
use crate::material::{Bsdf, Scattering, Vertex};

use super::light_sampling::point_pdf;
use super::next_event::picked_pdf;
use super::{NextEvent, Walking};
use crate::scene::Scene;

/// A vertex of a path from a light or from the eye.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathVertex<'a> {
    /// Where it is; the normal is on the side to which the path leads.
    pub at: Vertex,
    /// `None` where a particle starts, by the cosine.
    pub bsdf: Option<&'a Bsdf>,
    /// What a particle carries: radiance per pdf of its emitter's point, or flux that arrives at
    /// the surface.
    pub carried: DVec3,
    /// n² of the medium through which its own walk came here, relative to where that began.
    pub squared_index: f64,
    /// The emitter that is here, by its number in the scene.
    pub emitter: Option<u32>,
    /// [`picked_pdf`] of a particle's start from its next vertex, once that is known.
    pub picked: Option<f64>,
    /// The edge to the vertex before in its own walk, if there is one.
    edge: Option<Edge>,
}

/// The straight way from a vertex of a path to a neighbour.
#[derive(Clone, Copy, Debug)]
struct Edge {
    onward: DVec3,
    /// Between it and the normals at both ends.
    cosines: [f64; 2],
    /// Solid angle per area: of the first end as the other sees it, and of the other.
    per_area: [f64; 2],
}

impl Edge {
    #[inline]
    fn new<P: NextEvent>(parts: &P, a: &PathVertex<'_>, b: &PathVertex<'_>) -> Self {
        let offset = b.at.point - a.at.point;
        let (onward, distance_squared) = (offset.normalize(), offset.length_squared());
        let cosines = [a, b].map(|x| x.normal().dot(onward).abs());
        let per_area = cosines.map(|cosine| parts.solid_angle_per_area(cosine, distance_squared));
        Self {
            onward,
            cosines,
            per_area,
        }
    }

    #[inline]
    fn reversed(self) -> Self {
        let Self {
            onward,
            cosines: [a, b],
            per_area: [c, d],
        } = self;
        Self {
            onward: -onward,
            cosines: [b, a],
            per_area: [d, c],
        }
    }
}

/// How dense a vertex of a whole path is, with respect to area, given the rest of the walk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Density {
    /// p_L: for a walk that comes from the light.
    pub light: f64,
    /// p_E: for a walk that comes from the eye.
    pub eye: f64,
    /// 0 if no strategy joins its two walks between this vertex and the next towards the eye, else
    /// 1; at the emitter, how densely a shadow ray from the next vertex picks this one, relative to
    /// walks that start here.
    pub joined: f64,
}

/// A path in the two pieces that were connected.
#[derive(Clone, Copy)]
pub(super) struct WholePath<'a> {
    /// From the emitter on.
    pub light: &'a [PathVertex<'a>],
    /// From the first hit of the camera ray on.
    pub eye: &'a [PathVertex<'a>],
    /// Where the eye is.
    pub origin: DVec3,
    /// The pdf of the camera ray with respect to solid angle, among as many camera rays as
    /// particles.
    pub importance: f64,
}

impl WholePath<'_> {
    /// The densities of all vertices but the eye, from the emitter on.
    ///
    /// Of a mirror or glass there is one direction on either side, and the Dirac distributions of
    /// the two walks have the ratio of their n² cos θ, which stands for each (Veach 1997, 5.2).
    pub fn densities<P: Walking>(&self, parts: &P, scene: &Scene, path: &mut Vec<Density>) {
        let (s, count) = (self.light.len(), self.light.len() + self.eye.len());
        let vertex = |i: usize| {
            if i < s {
                &self.light[i]
            } else {
                &self.eye[count - 1 - i]
            }
        };
        // An emitter is where a walk starts, whatever it is made of.
        let specular = |i: usize, x: &PathVertex<'_>| i > 0 && x.is_specular();
        let joined = |i| f64::from(!specular(i, vertex(i)));
        let density = |joined| Density {
            light: 0.0,
            eye: 0.0,
            joined,
        };
        path.clear();
        path.extend((0..count).map(joined).map(density));
        if let Some((x, index)) = (count > 0)
            .then(|| vertex(0))
            .and_then(|x| Some((x, x.emitter? as usize)))
        {
            path[0].light = point_pdf(parts, scene, index);
            if path.len() > 1 {
                let picked = || picked_pdf(parts, scene, index, &x.at, self.point(1));
                path[0].joined = x.picked.unwrap_or_else(picked) / path[0].light;
            }
        }
        for i in 0..count.saturating_sub(1) {
            let (a, b) = (vertex(i), vertex(i + 1));
            // The walks have measured all edges but the one that joins them.
            let known = if i + 1 < s {
                b.edge.map(Edge::reversed)
            } else {
                a.edge.filter(|_| i >= s)
            };
            let Edge {
                onward,
                cosines: [cos_a, cos_b],
                per_area,
            } = known.unwrap_or_else(|| Edge::new(parts, a, b));
            let index = if i + 1 < s { b } else { a }.squared_index;
            let before = || i.checked_sub(1).map(|i| self.point(i));
            let after = || Some(self.point(i + 2));
            path[i].joined *= f64::from(!b.is_specular());
            path[i + 1].light =
                a.density(parts, specular(i, a), (onward, cos_a), index, before) * per_area[1];
            path[i].eye =
                b.density(parts, b.is_specular(), (-onward, cos_b), index, after) * per_area[0];
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
                self.importance * parts.solid_angle_per_area(cosine, offset.length_squared())
            };
        }
    }

    /// The point of a vertex, counted from the emitter; the last is the eye.
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
    /// A point on the emitter of this number, from which a particle carries so much.
    #[inline]
    pub fn emitting(point: &EmitterPoint, carried: DVec3, emitter: usize) -> Self {
        let at = Vertex::emitting(point.point, point.normal);
        Self {
            at,
            bsdf: None,
            carried,
            squared_index: 1.0,
            emitter: Some(emitter as u32),
            picked: None,
            edge: None,
        }
    }

    /// The same after the last of these, from which its walk came here.
    #[inline]
    pub fn after<P: NextEvent>(self, parts: &P, walk: &[Self]) -> Self {
        Self {
            edge: walk.last().map(|before| Edge::new(parts, &self, before)),
            ..self
        }
    }

    /// A hit that does not start a path.
    #[inline]
    pub fn hit(
        at: Vertex,
        bsdf: &'a Bsdf,
        (carried, squared_index): (DVec3, f64),
        emitter: Option<u32>,
    ) -> Self {
        Self {
            at,
            bsdf: Some(bsdf),
            carried,
            squared_index,
            emitter,
            picked: None,
            edge: None,
        }
    }

    /// Unit, on the side to which the path leads.
    #[inline]
    pub fn normal(&self) -> DVec3 {
        self.at.frame.z
    }

    /// The radiance that leaves in a unit direction, per density of particles on the area.
    #[inline]
    pub fn leaving<P: Scattering>(&self, parts: &P, direction: DVec3) -> DVec3 {
        match self.bsdf {
            None => self.carried,
            Some(bsdf) => {
                self.carried * parts.brdf(bsdf, self.at.frame.local(direction), self.at.wo)
            }
        }
    }

    /// Mirror or glass: no connection ends here.
    #[inline]
    fn is_specular(&self) -> bool {
        self.bsdf.is_some_and(Bsdf::is_specular)
    }

    /// How dense, with respect to solid angle, walks go on from here in a unit direction with this
    /// cosine, if they come from a point (`None` if they start here). `specular` stands for the
    /// Dirac distribution of a mirror or glass.
    #[inline]
    fn density<P: Scattering>(
        &self,
        parts: &P,
        specular: bool,
        (onward, cosine): (DVec3, f64),
        squared_index: f64,
        from: impl FnOnce() -> Option<DVec3>,
    ) -> f64 {
        if specular {
            return squared_index * cosine;
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
                above(onward),
            );
        }
        parts.cosine_hemisphere_pdf(cosine)
    }
}

/// w_s of [`crate::equation::PATH_DENSITY`], the balance heuristic: the weight of the strategy with
/// `s` light vertices on the path whose vertices but the eye have these densities, from the light
/// on.
pub fn weight(path: &[Density], s: usize) -> f64 {
    let joined = |s: usize| if s == 0 { 1.0 } else { path[s - 1].joined };
    let mut sum = joined(s);
    let mut ratio = 1.0;
    for (i, vertex) in path.iter().enumerate().skip(s) {
        ratio = times(ratio, vertex.light, vertex.eye);
        sum += times(ratio, joined(i + 1), 1.0);
    }
    ratio = 1.0;
    for (i, vertex) in path.iter().enumerate().take(s).rev() {
        ratio = times(ratio, vertex.eye, vertex.light);
        sum += times(ratio, joined(i), 1.0);
    }
    joined(s) / sum
}

/// The product of a ratio with that of two densities. Where an edge lies in a surface, densities at
/// both its ends are 0, and 0 · ∞ would say nothing: a density of 0 is that of no walk.
#[inline]
fn times(ratio: f64, density: f64, other: f64) -> f64 {
    if density == 0.0 || ratio == 0.0 {
        0.0
    } else {
        ratio * (density / other)
    }
}

/// The replaceable parts of connecting paths from the lights with paths from the eye.
pub trait Bidirectional: Sync {
    /// What refraction does to the flux of a particle: nothing, whatever the factor of radiance.
    #[inline]
    fn flux_factor(&self, _radiance_factor: f64) -> f64 {
        1.0
    }
    /// W(ω) of the pixel through which a direction leaves the eye.
    #[inline]
    fn importance(&self, camera: &Camera, size: [u32; 2], direction: DVec3) -> f64 {
        camera.importance(size, direction)
    }
    /// The weight of the strategy with `s` light vertices among all that make the same path.
    #[inline]
    fn strategy_weight(&self, path: &[Density], s: usize) -> f64 {
        weight(path, s)
    }
}
