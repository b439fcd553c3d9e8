//! Surfaces that lie in the same place, so that rounding would decide which of them a ray meets.

mod crowds;

use std::collections::BTreeMap;
use std::fmt;

use arrayvec::ArrayVec;
use glam::DVec3;
use rayon::prelude::*;

use super::detail::longest_edge;
use super::solids::{Shapes, Solids};
use super::{PrimitiveShape, Scene, ScenePrimitive, Surface};
use crate::geometry::offsets::{OFFSET, SINGLE_END};
use crate::geometry::shape::Sphere;
use crate::material::Bsdf;
use crowds::Member;

/// Distance, as a fraction of the scene's largest coordinate, up to which surfaces coincide: a ray
/// that leaves one of them from [`OFFSET`] above it, and a segment that ends as far above the
/// other, need some room between them.
pub const COINCIDENCE_TOLERANCE: f64 = 4.0 * OFFSET;
/// Distance up to which surfaces coincide in single precision, as a fraction of the largest
/// coordinate: 2⁻¹⁶.
pub const SINGLE_COINCIDENCE_TOLERANCE: f64 = 4.0 * SINGLE_END;
/// Fraction of the way across their overlap over which two surfaces must be that near to coincide:
/// planes that cross at an angle are near to each other along a line only.
pub(super) const CLOSE_FRACTION: f64 = 1e-3;
/// [`CLOSE_FRACTION`] in single precision, where the faces of a sharp edge are that near to each
/// other over more of their width.
const SINGLE_CLOSE_FRACTION: f64 = 1.0 / 16.0;
/// Overlap of neighbours that is tolerated, as a fraction of the smaller one's height: files round
/// coordinates.
const SLIVER_FRACTION: f64 = 1e-5;
/// Number of primitives whose bounding boxes meet that of a triangle, above which it belongs to a
/// crowd: as many as a large triangle may have among well-shaped ones.
const MAX_NEIGHBOURS: usize = 256;
/// Least absolute cosine between the normals of triangles that coincide.
const MIN_PARALLEL_COSINE: f64 = 0.99;

/// Two surfaces that coincide where it is visible which of them a ray meets.
#[derive(Clone, Debug, PartialEq)]
pub struct Coincidence {
    /// Indices of the two primitives among [`Scene::primitives`], in ascending order.
    pub primitives: [u32; 2],
    /// Objects that they belong to, by number and material.
    pub objects: [String; 2],
    /// A point of both surfaces.
    pub at: DVec3,
    /// Distance up to which surfaces coincide.
    pub tolerance: f64,
}

impl fmt::Display for Coincidence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            objects: [a, b],
            at,
            tolerance,
            ..
        } = self;
        if a == b {
            write!(f, "two faces of {a}")?;
        } else {
            write!(f, "{a} and {b}")?;
        }
        write!(
            f,
            " lie in the same place near {:?}, and rounding would decide which of them light meets: move one of them by \
             {:.0e} or more, remove one, or cut a hole for the other",
            at.to_array(),
            2.0 * tolerance
        )
    }
}

/// Two primitives that coincide, in ascending order, and where.
#[derive(Clone, Copy)]
pub(super) struct Overlap {
    pub pair: [u32; 2],
    at: DVec3,
    area: f64,
}

impl Scene {
    /// Returns the first two surfaces that are at most `tolerance` apart, a length, if it is
    /// visible which of them a ray meets: `None` if there are none, or if it makes no difference.
    /// No scene has any at [`COINCIDENCE_TOLERANCE`] times its largest coordinate; single precision
    /// needs more.
    pub fn coincident(&self, tolerance: f64) -> Option<Coincidence> {
        self.coincident_over(tolerance, CLOSE_FRACTION)
    }

    /// Returns the first two surfaces that coincide for rays in single precision: those that are at
    /// most [`SINGLE_COINCIDENCE_TOLERANCE`] times the largest coordinate apart over a sixteenth of
    /// the way across their overlap or more.
    pub fn coincident_in_singles(&self) -> Option<&Coincidence> {
        let tolerance = SINGLE_COINCIDENCE_TOLERANCE * self.largest_coordinate();
        let find = || self.coincident_over(tolerance, SINGLE_CLOSE_FRACTION);
        self.single_coincidence.get_or_init(find).as_ref()
    }

    fn coincident_over(&self, tolerance: f64, close_fraction: f64) -> Option<Coincidence> {
        let shapes = Shapes {
            primitives: &self.primitives,
            surfaces: &self.surfaces,
            vertices: &self.vertices,
            bvh: &self.bvh,
            eye: self.camera.eye,
            tolerance,
            close_fraction,
        };
        let found = shapes
            .redundant_faces()
            .map_or_else(Some, |faces| faces.first().map(|(_, overlap)| *overlap));
        found.map(|overlap| shapes.describe(&overlap, &self.surface_names))
    }
}

impl Shapes<'_> {
    /// Returns the faces of closed bodies that sheets cover wholly, as a floor covers that of a box
    /// which stands on it, each with a sheet that covers it: such a face can be left out, and then
    /// the sheet is visible there from either side.
    ///
    /// # Errors
    /// The first two that coincide otherwise, if it is visible which of them a ray meets.
    pub fn redundant_faces(&self) -> Result<Vec<(u32, Overlap)>, Overlap> {
        let overlaps = self.overlaps();
        if overlaps.iter().all(|overlap| self.are_alike(overlap.pair)) {
            return Ok(Vec::new());
        }
        let solids = Solids::new(self);
        let covered_face = |[i, j]: [u32; 2]| match [solids.hidden_side(i), solids.hidden_side(j)] {
            [Some(_), None] => self.may_cover(j, i).then_some(i),
            [None, Some(_)] => self.may_cover(i, j).then_some(j),
            _ => None,
        };
        // Surfaces between two bodies are hidden.
        let is_visible = |[i, j]: [u32; 2]| match [solids.hidden_side(i), solids.hidden_side(j)] {
            [Some((a, hidden_by_a)), Some((b, hidden_by_b))] => {
                a == b || hidden_by_a.dot(hidden_by_b) > 0.0
            }
            _ => true,
        };
        let mut faces: BTreeMap<u32, Overlap> = BTreeMap::new();
        for overlap in &overlaps {
            if !self.are_alike(overlap.pair) && is_visible(overlap.pair) {
                faces
                    .entry(covered_face(overlap.pair).ok_or(*overlap)?)
                    .or_insert(*overlap);
            }
        }
        let mut areas: BTreeMap<u32, f64> = BTreeMap::new();
        for overlap in &overlaps {
            *areas
                .entry(covered_face(overlap.pair).unwrap_or(u32::MAX))
                .or_default() += overlap.area;
        }
        // Neighbours overlap, or leave gaps, by up to a sliver at each edge.
        let is_whole = |face: u32| {
            areas[&face]
                >= (1.0 - 8.0 * SLIVER_FRACTION) * self.triangle(face).map_or(0.0, |t| t.area)
        };
        let checked = |(face, overlap)| match is_whole(face) {
            true => Ok((face, overlap)),
            false => Err(overlap),
        };
        faces.into_iter().map(checked).collect()
    }

    /// Returns an overlap as reported to the user.
    pub fn describe(&self, overlap: &Overlap, names: &[String]) -> Coincidence {
        let object = |i: u32| {
            let ScenePrimitive {
                object, surface, ..
            } = self.primitives[i as usize];
            format!("object {} ({})", object + 1, names[surface as usize])
        };
        Coincidence {
            primitives: overlap.pair,
            objects: overlap.pair.map(object),
            at: overlap.at,
            tolerance: self.tolerance,
        }
    }

    fn surface(&self, primitive: u32) -> &Surface {
        &self.surfaces[self.primitives[primitive as usize].surface as usize]
    }

    /// Returns whether both look the same from either side, and neither is a light or a specular
    /// caster.
    fn are_alike(&self, [i, j]: [u32; 2]) -> bool {
        let surface = self.surface(i);
        surface == self.surface(j) && is_opaque_two_sided(surface)
    }

    /// Returns whether a face can be left out where a sheet covers it.
    fn may_cover(&self, sheet: u32, face: u32) -> bool {
        is_opaque_two_sided(self.surface(sheet)) && self.surface(face).emission == DVec3::ZERO
    }

    /// Returns all primitives that coincide, in ascending order.
    fn overlaps(&self) -> Vec<Overlap> {
        let count = self.primitives.len() as u32;
        let each = || (0..count).into_par_iter().with_min_len(1024);
        let of = |i: u32| match self.neighbours(i, MAX_NEIGHBOURS) {
            Some(others) => (false, self.overlaps_with(i, &others, |j| j > i)),
            None => (true, Vec::new()),
        };
        let (crowded, found): (Vec<bool>, Vec<Vec<Overlap>>) = each().map(of).unzip();
        let mut found = found.concat();
        let of = |i: u32, wanted: &dyn Fn(u32) -> bool| {
            let others = self.neighbours(i, usize::MAX).unwrap_or_default();
            self.overlaps_with(i, &others, wanted)
        };
        let crowd: Vec<u32> = (0..count).filter(|i| crowded[*i as usize]).collect();
        if crowd.len() <= MAX_NEIGHBOURS {
            found.extend(crowd.iter().flat_map(|&i| of(i, &|j| j > i)));
        } else {
            let member = |&i: &u32| Some(Member::new(i, self.triangle(i)?, self.tolerance));
            let mut members: Vec<Member> = crowd.iter().filter_map(member).collect();
            self.overlaps_within(&mut members, &mut found);
            let others = each().filter(|i| !crowded[*i as usize]);
            found.par_extend(others.flat_map_iter(|i| of(i, &|j| j < i && crowded[j as usize])));
        }
        found.par_sort_unstable_by_key(|overlap| overlap.pair);
        found
    }

    /// Returns the primitives that may coincide with one, as their bounding boxes overlap, and some
    /// others; `None` for a triangle that has more than `most`.
    fn neighbours(&self, i: u32, most: usize) -> Option<Vec<u32>> {
        let (low, high, most) = match self.primitives[i as usize].shape {
            PrimitiveShape::Triangle { vertices, .. } => {
                let [a, b, c] = vertices.map(|v| self.vertices[v as usize]);
                let (low, high) = (a.min(b).min(c), a.max(b).max(c));
                (low - self.tolerance, high + self.tolerance, most)
            }
            PrimitiveShape::Sphere(sphere) => {
                // Spheres that coincide have nearly the same pole.
                let pole = sphere.centre + sphere.radius * DVec3::Z;
                let reach = DVec3::splat(2.0 * self.tolerance / self.close_fraction);
                (pole - reach, pole + reach, usize::MAX)
            }
        };
        // Room for those of most primitives, so that it need not grow.
        let mut others = Vec::with_capacity(64);
        self.bvh.overlapping(low, high, |j| {
            others.push(j);
            others.len() <= most
        });
        (others.len() <= most).then_some(others)
    }

    /// Returns the overlaps of a primitive with those of `others` that are `wanted`.
    fn overlaps_with(&self, i: u32, others: &[u32], wanted: impl Fn(u32) -> bool) -> Vec<Overlap> {
        let triangle = self.triangle(i);
        let pair = |&j: &u32| {
            if i < j {
                self.overlap([i, j], triangle.as_ref())
            } else {
                self.overlap([j, i], self.triangle(j).as_ref())
            }
        };
        let mut found: Vec<Overlap> = others
            .iter()
            .filter(|j| wanted(**j))
            .filter_map(pair)
            .collect();
        found.sort_unstable_by_key(|overlap| overlap.pair);
        found
    }

    /// Returns the overlap of a pair, whose first primitive may be this triangle.
    fn overlap(&self, pair: [u32; 2], triangle: Option<&Triangle>) -> Option<Overlap> {
        let (at, area) = match (triangle, pair.map(|i| &self.primitives[i as usize].shape)) {
            (Some(a), [_, PrimitiveShape::Triangle { normal, .. }]) => {
                if a.normal.dot(*normal).abs() < MIN_PARALLEL_COSINE {
                    return None;
                }
                let b = self.triangle(pair[1])?;
                if a.area <= b.area {
                    a.overlap(&b, self)?
                } else {
                    b.overlap(a, self)?
                }
            }
            (None, [PrimitiveShape::Sphere(a), PrimitiveShape::Sphere(b)]) => {
                (self.spheres_overlap(a, b)?, 0.0)
            }
            _ => return None,
        };
        Some(Overlap { pair, at, area })
    }

    /// Returns whether two surfaces whose distance varies from `low` to `high` across their overlap
    /// are near each other in more of it than where they cross.
    fn are_close(&self, [low, high]: [f64; 2]) -> bool {
        let close = high.min(self.tolerance) - low.max(-self.tolerance);
        close >= 0.0 && close >= self.close_fraction * (high - low)
    }

    /// Returns a point of the overlap of two nearly equal spheres or zones.
    fn spheres_overlap(&self, a: &Sphere, b: &Sphere) -> Option<DVec3> {
        let (apart, wider) = ((b.centre - a.centre).length(), b.radius - a.radius);
        if !self.are_close([wider - apart, wider + apart]) {
            return None;
        }
        let [[a_low, a_high], [b_low, b_high]] = [a, b].map(Sphere::heights);
        let (low, high) = (a_low.max(b_low), a_high.min(b_high));
        let margin = self
            .tolerance
            .max(SLIVER_FRACTION * (a_high - a_low).min(b_high - b_low));
        let (z, radius) = (0.5 * (low + high), a.radius);
        (high - low > margin)
            .then(|| a.centre + DVec3::new((radius * radius - z * z).max(0.0).sqrt(), 0.0, z))
    }

    /// Returns a triangle by its corners; `None` for a sphere.
    pub fn triangle(&self, primitive: u32) -> Option<Triangle> {
        match self.primitives[primitive as usize].shape {
            PrimitiveShape::Triangle { vertices, normal } => {
                let corners = vertices.map(|v| self.vertices[v as usize]);
                let [a, b, c] = corners;
                Some(Triangle {
                    corners,
                    normal,
                    area: 0.5 * (b - a).cross(c - a).length(),
                })
            }
            PrimitiveShape::Sphere(_) => None,
        }
    }
}

/// Returns whether a surface is opaque, emits nothing, looks the same from both sides, and is no
/// specular caster.
fn is_opaque_two_sided(surface: &Surface) -> bool {
    surface.emission == DVec3::ZERO
        && !matches!(
            surface.bsdf,
            Bsdf::Mirror { .. } | Bsdf::Glass { .. } | Bsdf::RoughGlass(_)
        )
}

/// Corners of a convex polygon.
type Polygon = ArrayVec<DVec3, 24>;

/// A triangle, its unit normal and its area.
pub(super) struct Triangle {
    pub corners: [DVec3; 3],
    normal: DVec3,
    pub area: f64,
}

impl Triangle {
    /// Returns the distance from its edges over which others must reach to overlap it.
    fn margin(&self, tolerance: f64) -> f64 {
        tolerance.max(SLIVER_FRACTION * 2.0 * self.area / longest_edge(self.corners))
    }

    /// Returns a point and the area of the overlap with another triangle of the same plane.
    fn overlap(&self, other: &Self, shapes: &Shapes<'_>) -> Option<(DVec3, f64)> {
        let tolerance = shapes.tolerance;
        let height = |p: &DVec3| (*p - self.corners[0]).dot(self.normal);
        let range = |points: &[DVec3]| {
            let heights = points.iter().map(height);
            heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], h| {
                [low.min(h), high.max(h)]
            })
        };
        let [low, high] = range(&other.corners);
        if low > tolerance || high < -tolerance {
            return None;
        }
        // Most are apart.
        let [a, b, c] = self.corners;
        let outside = |from: DVec3, to: DVec3| {
            let inward = self.normal.cross(to - from);
            other.corners.iter().all(|p| (*p - from).dot(inward) <= 0.0)
        };
        if outside(a, b) || outside(b, c) || outside(c, a) {
            return None;
        }
        let inner = self.clipped(other, self.margin(tolerance))?;
        if !shapes.are_close(range(&inner)) {
            return None;
        }
        let whole = self.clipped(other, -tolerance)?;
        let fan = whole[1..]
            .windows(2)
            .map(|edge| 0.5 * (edge[0] - whole[0]).cross(edge[1] - whole[0]).length());
        Some((inner.iter().sum::<DVec3>() / inner.len() as f64, fan.sum()))
    }

    /// Returns the polygon of another triangle that lies above or below this one, at least `margin`
    /// within its edges; `None` if there is none (Sutherland and Hodgman 1974). Rounding may double
    /// its corners at each edge.
    fn clipped(&self, other: &Self, margin: f64) -> Option<Polygon> {
        let mut polygon = Polygon::from_iter(other.corners);
        for i in 0..3 {
            let (from, to) = (self.corners[i], self.corners[(i + 1) % 3]);
            let inward = self.normal.cross(to - from).normalize();
            let depth = |p: DVec3| (p - from).dot(inward) - margin;
            let mut kept = Polygon::new();
            for (k, &here) in polygon.iter().enumerate() {
                let next = polygon[(k + 1) % polygon.len()];
                let [d, e] = [depth(here), depth(next)];
                if d >= 0.0 {
                    kept.push(here);
                }
                if (d < 0.0) != (e < 0.0) {
                    kept.push(here.lerp(next, d / (d - e)));
                }
            }
            polygon = kept;
            if polygon.len() < 3 {
                return None;
            }
        }
        Some(polygon)
    }
}
