//! Walls that cast no shadow: triangles in the surface of a scene's convex hull. Nothing lies
//! behind them, so none of them is between two points within the hull.

use glam::DVec3;

use super::bvh::{Bvh, Primitive};
use super::offsets::OFFSET;
use crate::math::real::{Mask as _, MaskOf, Real, Vector};

/// Maximum number of primitives of a small scene; in larger ones the hierarchy is as fast.
pub(crate) const MAX_PRIMITIVES: usize = 64;
/// Maximum number of slabs; testing points against more costs more than it saves.
const MAX_SLABS: usize = 8;

/// Distance from the walls, relative to the largest coordinate, that points within keep in single
/// precision: 2⁻²², four rounding errors.
const SINGLE_MARGIN: f64 = 1.0 / 4_194_304.0;

/// Convex hull of a scene, as far as walls form its surface.
#[derive(Debug)]
pub(crate) struct Hull {
    /// Slabs whose intersection contains the hull.
    pub slabs: Vec<Slab>,
    /// Whether each primitive is a wall.
    pub is_wall: Vec<bool>,
    /// Hierarchy of all other primitives.
    pub within: Bvh,
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
    /// Finds the hull of a small scene with walls, whose rays leave surfaces from this height above
    /// them.
    pub fn new(primitives: &[Primitive], offset: f64) -> Option<Self> {
        if primitives.len() > MAX_PRIMITIVES {
            return None;
        }
        let mut slabs: Vec<Slab> = Vec::new();
        let is_wall: Vec<bool> = primitives
            .iter()
            .map(|primitive| {
                let Primitive::Triangle([a, b, c]) = *primitive else {
                    return false;
                };
                if slabs
                    .iter_mut()
                    .any(|slab| slab.try_close([a, b, c], primitives))
                {
                    return true;
                }
                let mut slab = Slab {
                    normal: (b - a).cross(c - a).normalize_or_zero(),
                    ends: [f64::INFINITY; 2],
                    inner_ends: [f64::INFINITY; 2],
                    inner_ends_single: [f64::INFINITY; 2],
                    offset,
                };
                let is_wall = slab.try_close([a, b, c], primitives);
                if is_wall {
                    slabs.push(slab);
                }
                is_wall
            })
            .collect();
        let within = Bvh::over_subset(primitives, |id| !is_wall[id as usize]);
        (1..=MAX_SLABS).contains(&slabs.len()).then_some(Self {
            slabs,
            is_wall,
            within,
        })
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

    /// Returns whether a triangle lies in one of the planes, which then bounds the slab: the whole
    /// scene lies on its inner side.
    fn try_close(&mut self, corners: [DVec3; 3], primitives: &[Primitive]) -> bool {
        [0, 1].into_iter().any(|side| {
            let normal = self.outward(side);
            let farthest = primitives
                .iter()
                .map(|primitive| max_height(primitive, normal))
                .fold(f64::NEG_INFINITY, f64::max);
            let open = std::mem::replace(&mut self.ends[side], farthest);
            let lies = self.contains_on_plane(side, &corners);
            if lies {
                let single = self.offset * (SINGLE_MARGIN / OFFSET);
                self.inner_ends[side] = farthest - self.offset / 4.0;
                self.inner_ends_single[side] = f64::from(farthest as f32 - single as f32);
            } else {
                self.ends[side] = open;
            }
            lies
        })
    }
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
