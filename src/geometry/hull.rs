//! Walls that cast no shadow: triangles in the surface of the convex hull of a scene's largest
//! primitives. None of them lies between two points within the hull.

use glam::DVec3;

use super::bvh::Primitive;
use super::offsets::OFFSET;
use crate::math::real::{Mask as _, MaskOf, Real, Vector};

/// Maximum number of primitives of a small scene; in larger ones the hierarchy is as fast.
pub(crate) const MAX_PRIMITIVES: usize = 64;
/// Largest opening between the walls, relative to their area, in scenes that are not small: a room
/// that lacks one of six walls is faster with its hull, a scene with nothing but a ground slower.
const MAX_OPENING: f64 = 0.25;
/// Maximum number of walls in scenes that are not small: if there are more, they are likely divided
/// so finely that most of their triangles are not among the largest.
const MAX_WALLS: usize = MAX_PRIMITIVES / 2;
/// Maximum number of slabs; testing points against more costs more than it saves.
const MAX_SLABS: usize = 8;

/// Distance from the walls, relative to the largest coordinate, that points within keep in single
/// precision: 2⁻²², four rounding errors.
const SINGLE_MARGIN: f64 = 1.0 / 4_194_304.0;

/// Convex hull of the [`MAX_PRIMITIVES`] largest primitives of a scene, as far as walls form its
/// surface. In larger scenes other primitives may lie outside.
#[derive(Debug)]
pub(crate) struct Hull {
    /// Slabs whose intersection contains the hull.
    pub slabs: Vec<Slab>,
    /// Whether each primitive is a wall.
    pub is_wall: Vec<bool>,
}

/// The space between two parallel planes, n · p < `ends[0]` and −n · p < `ends[1]`; an end without
/// a wall is infinite.
#[derive(Debug)]
pub(crate) struct Slab {
    pub normal: DVec3,
    pub ends: [f64; 2],
    /// The ends less a margin of `offset`/4, and in single precision of [`SINGLE_MARGIN`].
    inner_ends: [f64; 2],
    inner_ends_single: [f64; 2],
    offset: f64,
}

impl Hull {
    /// Finds the hull of a scene with walls, whose rays leave surfaces from this height above them.
    pub fn new(primitives: &[Primitive], offset: f64) -> Option<Self> {
        let largest = largest(primitives);
        let mut slabs: Vec<Slab> = Vec::new();
        let mut is_wall = vec![false; primitives.len()];
        // Twice the area of the walls, and of their opening: area vectors of a closed surface cancel.
        let (mut area, mut opening) = (0.0, DVec3::ZERO);
        for &(id, primitive) in &largest {
            let Primitive::Triangle(corners) = primitive else {
                continue;
            };
            let close = |slab: &mut Slab| slab.try_close(corners, &largest);
            let [a, b, c] = corners;
            let normal = (b - a).cross(c - a);
            let outward = slabs.iter_mut().find_map(close).or_else(|| {
                let mut slab = Slab {
                    normal: normal.normalize_or_zero(),
                    ends: [f64::INFINITY; 2],
                    inner_ends: [f64::INFINITY; 2],
                    inner_ends_single: [f64::INFINITY; 2],
                    offset,
                };
                let outward = close(&mut slab)?;
                slabs.push(slab);
                Some(outward)
            });
            if let Some(outward) = outward {
                is_wall[id] = true;
                area += normal.length();
                opening += normal.length() * outward;
            }
        }
        let walls = is_wall.iter().filter(|is_wall| **is_wall).count();
        let is_small = primitives.len() <= MAX_PRIMITIVES;
        let is_useful = is_small || walls <= MAX_WALLS && opening.length() <= MAX_OPENING * area;
        ((1..=MAX_SLABS).contains(&slabs.len()) && is_useful).then_some(Self { slabs, is_wall })
    }

    /// Returns whether both points are within, at least some rounding errors away from the walls.
    #[inline]
    pub fn contains<V: Vector>(&self, x: V, y: V) -> MaskOf<V> {
        let all = MaskOf::<V>::splat(true);
        self.slabs.iter().fold(all, |within, slab| {
            let normal = V::splat_vector(slab.normal);
            within & slab.contains(normal.dot(x)) & slab.contains(normal.dot(y))
        })
    }
}

impl Slab {
    /// Returns whether a point at a height along the normal is between the planes, at least some
    /// rounding errors away from them.
    #[inline]
    pub fn contains<R: Real>(&self, height: R) -> R::Mask {
        let end = |side| R::by_precision(self.inner_ends[side], self.inner_ends_single[side]);
        height.cmplt(end(0)) & (-height).cmplt(end(1))
    }

    /// Returns the distance from a plane within which a point lies in it: some tens of rounding
    /// errors. The origin of a ray that leaves a wall is within the slab, a point on the wall is
    /// not.
    pub fn tolerance(&self) -> f64 {
        self.offset / 64.0
    }

    /// Returns the outward normal of one of the planes.
    fn outward(&self, side: usize) -> DVec3 {
        if side == 0 { self.normal } else { -self.normal }
    }

    /// Returns whether all these points lie in one of the planes.
    pub fn contains_on_plane(&self, side: usize, points: &[DVec3]) -> bool {
        let normal = self.outward(side);
        points
            .iter()
            .all(|point| normal.dot(*point) >= self.ends[side] - self.tolerance())
    }

    /// Returns the outward normal of the plane in which a triangle lies, if this is one of the two
    /// planes. It then bounds the slab: all these primitives lie on its inner side.
    fn try_close(
        &mut self,
        corners: [DVec3; 3],
        primitives: &[(usize, Primitive)],
    ) -> Option<DVec3> {
        [0, 1].into_iter().find_map(|side| {
            let normal = self.outward(side);
            let farthest = primitives
                .iter()
                .map(|(_, primitive)| max_height(primitive, normal))
                .fold(f64::NEG_INFINITY, f64::max);
            let open = std::mem::replace(&mut self.ends[side], farthest);
            if !self.contains_on_plane(side, &corners) {
                self.ends[side] = open;
                return None;
            }
            let single = self.offset * (SINGLE_MARGIN / OFFSET);
            self.inner_ends[side] = farthest - self.offset / 4.0;
            self.inner_ends_single[side] = f64::from(farthest as f32 - single as f32);
            Some(normal)
        })
    }
}

/// Returns the [`MAX_PRIMITIVES`] largest triangles, or all primitives of a small scene, in the order
/// of the list with their indices.
fn largest(primitives: &[Primitive]) -> Vec<(usize, Primitive)> {
    let area = |id: usize| match primitives[id] {
        Primitive::Triangle([a, b, c]) => (b - a).cross(c - a).length(),
        Primitive::Sphere(_) => f64::NEG_INFINITY,
    };
    let mut largest: Vec<usize> = (0..primitives.len()).collect();
    if largest.len() > MAX_PRIMITIVES {
        largest.select_nth_unstable_by(MAX_PRIMITIVES, |&a, &b| {
            area(b).total_cmp(&area(a)).then(a.cmp(&b))
        });
        largest.truncate(MAX_PRIMITIVES);
        largest.sort_unstable();
    }
    largest.into_iter().map(|id| (id, primitives[id])).collect()
}

/// Returns the largest n · p over a primitive's points.
fn max_height(primitive: &Primitive, normal: DVec3) -> f64 {
    match primitive {
        Primitive::Triangle(corners) => corners
            .iter()
            .map(|&corner| normal.dot(corner))
            .fold(f64::NEG_INFINITY, f64::max),
        Primitive::Sphere(sphere) => normal.dot(sphere.centre) + sphere.radius,
    }
}
