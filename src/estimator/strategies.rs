//! The strategies that make one and the same path from the light to the eye, and their weights.
//!
//! A path x₀ … x_k from an emitter to the eye is made by s vertices from the light and k + 1 − s from the
//! eye. Its densities are functions of the path alone, so all strategies agree on them and the weights
//! sum to one. Survival by Russian roulette is left out of all of them: it depends on the way a path was
//! made, and any weights that sum to one are unbiased.

use glam::DVec3;

use crate::bsdf::{Bsdf, Scattering};
use crate::camera::Camera;
use crate::frame::Frame;

use super::NextEvent;

/// A vertex of a path, as far as densities need it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner<'a> {
    pub point: DVec3,
    /// Unit, to the side to which the path leads.
    pub normal: DVec3,
    /// `None` where a particle starts, by the cosine.
    pub bsdf: Option<&'a Bsdf>,
    /// n² of the medium through which its own walk came here, relative to where that began.
    pub squared_index: f64,
    /// The pdf, with respect to area, of a path that starts here; 0 where nothing emits.
    pub start: f64,
}

/// How dense a vertex of a whole path is, with respect to area, given the rest of the walk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Density {
    /// p_L: for a walk that comes from the light.
    pub light: f64,
    /// p_E: for a walk that comes from the eye.
    pub eye: f64,
    /// Whether no connection can end here.
    pub specular: bool,
}

/// A path in the two pieces that were connected.
#[derive(Clone, Copy)]
pub(super) struct WholePath<'a> {
    /// From the emitter on.
    pub light: &'a [Corner<'a>],
    /// From the first hit of the camera ray on.
    pub eye: &'a [Corner<'a>],
    /// Where the eye is.
    pub origin: DVec3,
    /// The pdf of the camera ray with respect to solid angle, among as many camera rays as particles.
    pub importance: f64,
}

impl WholePath<'_> {
    /// The densities of all vertices but the eye, from the emitter on.
    ///
    /// Of a mirror or glass there is one direction on either side, and the Dirac distributions of the two
    /// walks have the ratio of their n² cos θ, which stands for each (Veach 1997, 5.2).
    pub fn densities<P: Scattering + NextEvent>(&self, parts: &P) -> Vec<Density> {
        let s = self.light.len();
        let count = s + self.eye.len();
        let vertex = |i: usize| if i < s { &self.light[i] } else { &self.eye[count - 1 - i] };
        let mut path: Vec<Density> = (0..count)
            .map(|i| (i, vertex(i)))
            .map(|(i, x)| Density { light: x.start, eye: 0.0, specular: i > 0 && x.is_specular() })
            .collect();
        // Each way from vertex to vertex, the last one to the eye, as unit direction and squared length.
        let way = |i: usize| {
            let end = if i + 1 < count { vertex(i + 1).point } else { self.origin };
            let offset = end - vertex(i).point;
            (offset.normalize(), offset.length_squared())
        };
        let mut came = None;
        let mut next = way(0);
        for i in 0..count {
            let (onward, distance_squared) = next;
            let a = vertex(i);
            let cos_a = a.normal.dot(onward).abs();
            if i + 1 < count {
                let b = vertex(i + 1);
                next = way(i + 1);
                let cos_b = b.normal.dot(onward).abs();
                let index = if i + 1 < s { b } else { a }.squared_index;
                path[i + 1].light = a.density(parts, came, onward, path[i].specular, index)
                    * parts.solid_angle_per_area(cos_b, distance_squared);
                path[i].eye = b.density(parts, Some(next.0), -onward, b.is_specular(), index)
                    * parts.solid_angle_per_area(cos_a, distance_squared);
            } else {
                path[i].eye = self.importance * parts.solid_angle_per_area(cos_a, distance_squared);
            }
            came = Some(-onward);
        }
        path
    }
}

impl Corner<'_> {
    /// Mirror or glass: no connection ends here.
    fn is_specular(&self) -> bool {
        self.bsdf.is_some_and(Bsdf::is_specular)
    }

    /// How dense, with respect to solid angle, walks go on from here in a unit direction that `came` from the way
    /// in another (`None` if they start here). `specular` stands for the Dirac distribution of a mirror or glass.
    #[inline]
    fn density<P: Scattering>(
        &self,
        parts: &P,
        came: Option<DVec3>,
        onward: DVec3,
        specular: bool,
        squared_index: f64,
    ) -> f64 {
        let above = |direction: DVec3| {
            let local = Frame::new(self.normal).local(direction);
            local.with_z(local.z.abs())
        };
        match (self.bsdf, came) {
            _ if specular => squared_index * self.normal.dot(onward).abs(),
            (Some(bsdf), Some(came)) => parts.pdf(bsdf, above(came), above(onward)),
            _ => parts.cosine_hemisphere_pdf(self.normal.dot(onward).abs()),
        }
    }
}

/// w_s of [`crate::equation::PATH_DENSITY`], the balance heuristic: the weight of the strategy with `s`
/// light vertices on the path whose vertices but the eye have these densities, in the order from the
/// light. Strategies that connect at mirror or glass do not exist.
pub fn weight(path: &[Density], s: usize) -> f64 {
    let exists = |s: usize| {
        s == 0 || (!path[s - 1].specular && path.get(s).is_none_or(|next| !next.specular))
    };
    let mut sum = 1.0;
    let mut ratio = 1.0;
    for (i, vertex) in path.iter().enumerate().skip(s) {
        ratio *= vertex.light / vertex.eye;
        sum += if exists(i + 1) { ratio } else { 0.0 };
    }
    ratio = 1.0;
    for (i, vertex) in path.iter().enumerate().take(s).rev() {
        ratio *= vertex.eye / vertex.light;
        sum += if exists(i) { ratio } else { 0.0 };
    }
    1.0 / sum
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
