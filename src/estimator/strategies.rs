//! The strategies that make one and the same path from the light to the eye, and their weights.
//!
//! A path x₀ … x_k from an emitter to the eye is made by s vertices from the light and k + 1 − s from the
//! eye. Its densities are functions of the path alone, so all strategies agree on them and the weights
//! sum to one. Survival by Russian roulette is left out of all of them: it depends on the way a path was
//! made, and any weights that sum to one are unbiased.

use glam::DVec3;

use super::Parts;

/// A vertex of a path, as far as densities need it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub point: DVec3,
    /// Unit, to either side.
    pub normal: DVec3,
    /// Mirror or glass: no connection ends here.
    pub specular: bool,
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
    pub light: &'a [Corner],
    /// From the first hit of the camera ray on.
    pub eye: &'a [Corner],
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
    pub fn densities<P: Parts>(&self, parts: &P) -> Vec<Density> {
        let s = self.light.len();
        let vertices = self.light.iter().chain(self.eye.iter().rev());
        let mut path: Vec<Density> = vertices
            .clone()
            .enumerate()
            .map(|(i, x)| Density { light: x.start, eye: 0.0, specular: i > 0 && x.specular })
            .collect();
        let onward = |specular: bool, cosine: f64, squared_index: f64| {
            if specular { squared_index * cosine } else { parts.cosine_hemisphere_pdf(cosine) }
        };
        for (i, (a, b)) in vertices.clone().zip(vertices.skip(1)).enumerate() {
            let [cos_a, cos_b] = [a, b].map(|x| x.cosine(b.point - a.point));
            let distance_squared = a.point.distance_squared(b.point);
            let index = if i + 1 < s { b } else { a }.squared_index;
            path[i + 1].light = onward(path[i].specular, cos_a, index)
                * parts.solid_angle_per_area(cos_b, distance_squared);
            path[i].eye = onward(b.specular, cos_b, index)
                * parts.solid_angle_per_area(cos_a, distance_squared);
        }
        if let (Some(last), Some(density)) =
            (self.eye.first().or(self.light.last()), path.last_mut())
        {
            let cosine = last.cosine(self.origin - last.point);
            let distance_squared = self.origin.distance_squared(last.point);
            density.eye = self.importance * parts.solid_angle_per_area(cosine, distance_squared);
        }
        path
    }
}

impl Corner {
    /// |cos θ| of a direction of any length.
    fn cosine(&self, direction: DVec3) -> f64 {
        self.normal.dot(direction.normalize()).abs()
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
