//! Walls as half-spaces: a ray from within the convex hull can hit only one of the triangles in the
//! hull's surface, determined by where it leaves the hull.
//!
//! Rays that leave close to an edge between walls, or between triangles of one wall, are left to
//! the general test. The margin lies far above all rounding errors, so that a decided triangle is
//! hit or missed exactly as if all triangles were tested.

use glam::DVec3;

use super::PrimitiveData;
use crate::geometry::hull::{Hull, MAX_PRIMITIVES, Slab};
use crate::geometry::offsets::{OFFSET, SINGLE_EDGE_MARGIN};
use crate::geometry::shape::Ray;
use crate::geometry::watertight::{LaneShear, TriangleHit};
use crate::math::real::{Mask, Real, Vector};
use crate::math::simd::{AlignedArray, Scalar, Wide, map_array};
use crate::scene::{PrimitiveShape, Scene};

/// Distance from edges below which an exit is not decided, relative to the largest coordinate of
/// the scene; far above rounding errors of rays that leave at a cosine of [`MIN_COSINE`] or more.
const MARGIN: f64 = OFFSET;
/// [`MARGIN`] in single precision, 2⁻¹⁵.
const SINGLE_MARGIN: f64 = 2.0 * SINGLE_EDGE_MARGIN;
/// Least cosine between a ray and the normal of a wall at which an exit is decided.
const MIN_COSINE: f64 = 1.0 / 32.0;
/// Least number of resolved triangles of a small scene; for fewer a list of all is as fast. In other
/// scenes it is half the walls, as lanes test lists of those unresolved.
const MIN_TRIANGLES: usize = 12;
/// Maximum number of triangles resolved per wall.
const MAX_TRIANGLES: usize = 4;

/// Hull walls of a small scene.
pub(super) struct HullWalls<T> {
    walls: Vec<Wall<T>>,
    /// Largest coordinate of the scene.
    extent: f64,
}

/// Triangles in a plane, separated by lines: a point on the negative side of the first line can
/// only lie in the first triangle, otherwise one on the negative side of the second line only in
/// the second, and so on.
///
/// Stores normals and heights of three lines, then the indices of four triangles among the scene's
/// primitives.
struct Wall<T>(AlignedArray<T, 16>);

/// A triangle of a wall.
#[derive(Clone, Copy)]
struct Triangle {
    /// Index among the scene's primitives.
    id: usize,
    corners: [DVec3; 3],
}

/// A line in a wall.
#[derive(Clone, Copy)]
struct Line {
    normal: DVec3,
    /// Height along the normal.
    height: f64,
}

impl Line {
    /// A line at infinity, which has every point on its negative side.
    const INFINITE: Self = Self {
        normal: DVec3::ZERO,
        height: f64::INFINITY,
    };
}

/// A triangle, and the line that separates it from the triangles after it.
#[derive(Clone, Copy)]
struct Separated {
    triangle: Triangle,
    line: Line,
}

/// Exits of rays from the hull.
pub(super) struct HullExit<R: Real> {
    /// Lanes whose exit is decided.
    pub decided: R::Mask,
    /// Index of the only triangle that the ray can hit.
    pub primitive: R,
    /// Hits on these triangles; infinite distance for a miss.
    pub hit: TriangleHit<R>,
}

impl<T: Scalar> HullWalls<T> {
    /// Builds the walls of a scene with this hull, and returns which of its primitives they
    /// resolve; `None` if these are too few. Triangles that overlap others of a wall, or exceed
    /// [`MAX_TRIANGLES`], are left out.
    pub fn new(scene: &Scene, hull: &Hull) -> Option<(Self, Vec<bool>)> {
        let (mut walls, mut is_resolved) =
            (Vec::new(), vec![false; scene.scene_primitives().len()]);
        let mut triangles = Vec::new();
        let primitives = scene.scene_primitives();
        for (id, primitive) in primitives.iter().enumerate() {
            if let PrimitiveShape::Triangle { vertices, .. } = primitive.shape
                && hull.is_wall[id]
            {
                let corners = scene.corners(vertices);
                triangles.push(Triangle { id, corners });
            }
        }
        for slab in &hull.slabs {
            for side in [0, 1] {
                let on_side = |of: &&Triangle| slab.contains_on_plane(side, &of.corners);
                let resolved = separate(triangles.iter().filter(on_side).copied().collect(), slab);
                resolved
                    .iter()
                    .for_each(|of| is_resolved[of.triangle.id] = true);
                walls.push(Wall::new(&resolved));
            }
        }
        let count = is_resolved
            .iter()
            .filter(|is_resolved| **is_resolved)
            .count();
        let extent = scene.largest_coordinate();
        let least = if primitives.len() <= MAX_PRIMITIVES {
            MIN_TRIANGLES
        } else {
            triangles.len().div_ceil(2)
        };
        (count >= least).then_some((Self { walls, extent }, is_resolved))
    }

    /// Finds where the `active` rays leave the hull; `primitives` are the data of the scene's
    /// primitives. `None` if no ray starts within.
    #[inline]
    pub fn exit<R: Wide<N, Scalar = T>, const N: usize>(
        &self,
        hull: &Hull,
        primitives: &[PrimitiveData<T>],
        ray: &Ray<R::Vector>,
        shear: &LaneShear<R>,
        active: R::Mask,
    ) -> Option<HullExit<R>> {
        let (zero, never) = (R::splat(0.0), R::splat(f64::INFINITY));
        let margin = R::by_precision(self.extent * MARGIN, self.extent * SINGLE_MARGIN);
        let [x, y, z] = map_array(ray.direction.components(), R::abs);
        let scale = x.maximum(y).maximum(z);
        let steep = scale * MIN_COSINE;
        // Each ray leaves through `wall` between `begin_exit` and `end_exit`, and through no other
        // before `next_exit`.
        let (mut wall, mut begin_exit, mut end_exit, mut next_exit) = (zero, never, never, never);
        let mut within = active;
        for (number, slab) in hull.slabs.iter().enumerate() {
            let normal = R::Vector::splat_vector(slab.normal);
            let (height, rise) = (normal.dot(ray.origin), normal.dot(ray.direction));
            within = within & slab.contains(height);
            let falls = rise.cmplt(zero);
            let [top, bottom] = map_array(slab.ends, R::splat);
            let distance = R::select(falls, bottom + height, top - height);
            let speed = rise.abs();
            let inverse = speed.maximum(steep).recip();
            let begin = (distance - margin) * inverse;
            let end = R::select(speed.cmpgt(steep), (distance + margin) * inverse, never);
            let nearer = end.cmplt(end_exit);
            next_exit = next_exit.minimum(R::select(nearer, begin_exit, begin));
            begin_exit = R::select(nearer, begin, begin_exit);
            end_exit = R::select(nearer, end, end_exit);
            let here = (2 * number) as f64;
            wall = R::select(
                nearer,
                R::select(falls, R::splat(here + 1.0), R::splat(here)),
                wall,
            );
        }
        if !within.any() {
            return None;
        }
        let point = ray.at((begin_exit + end_exit) * 0.5);
        let width = (end_exit - begin_exit) * scale;
        let [a, b, c, d, e, f, g, h, i, j, k, l, triangles @ ..] =
            R::transpose(map_array(wall.to_u32(), |place| {
                &self.walls[place as usize].0
            }));
        let (mut primitive, mut clear) = (triangles[3], zero.cmpeq(zero));
        for (n, line) in [[a, b, c, d], [e, f, g, h], [i, j, k, l]]
            .into_iter()
            .enumerate()
            .rev()
        {
            let [x, y, z, height] = line;
            let above = R::Vector::of([x, y, z]).dot(point) - height;
            primitive = R::select(above.cmplt(zero), triangles[n], primitive);
            clear = clear & above.abs().cmpgt(width);
        }
        let numbers = R::transpose(map_array(primitive.to_u32(), |place| {
            &primitives[place as usize].numbers
        }));
        let corner =
            |k: usize| shear.project([numbers[3 * k], numbers[3 * k + 1], numbers[3 * k + 2]]);
        let mut hit = shear.hit([&corner(0), &corner(1), &corner(2)]);
        let decided = within & next_exit.cmpgt(end_exit) & clear;
        hit.t = R::select(decided, hit.t, never);
        Some(HullExit {
            decided,
            primitive,
            hit,
        })
    }
}

impl<T: Scalar> Wall<T> {
    /// Packs at most [`MAX_TRIANGLES`] triangles, each with the line that separates it from those
    /// after it.
    fn new(resolved: &[Separated]) -> Self {
        let mut numbers = [T::rounded(0.0); 16];
        for line in 0..MAX_TRIANGLES - 1 {
            let Line { normal, height } = resolved.get(line).map_or(Line::INFINITE, |of| of.line);
            let [x, y, z] = normal.to_array();
            numbers[4 * line..][..4].copy_from_slice(&[x, y, z, height].map(T::rounded));
        }
        for (number, of) in numbers[4 * (MAX_TRIANGLES - 1)..].iter_mut().zip(resolved) {
            *number = T::rounded(of.triangle.id as f64);
        }
        Self(AlignedArray(numbers))
    }
}

/// Selects at most [`MAX_TRIANGLES`] triangles of a plane that lines can separate, largest first,
/// and returns them with these lines.
fn separate(mut triangles: Vec<Triangle>, slab: &Slab) -> Vec<Separated> {
    let area = |triangle: &Triangle| {
        let [a, b, c] = triangle.corners;
        (b - a).cross(c - a).length()
    };
    triangles.sort_by(|a, b| area(b).total_cmp(&area(a)));
    let mut resolved: Vec<Separated> = Vec::new();
    for triangle in triangles {
        let more: Vec<Triangle> = resolved
            .iter()
            .map(|of| of.triangle)
            .chain([triangle])
            .collect();
        if more.len() <= MAX_TRIANGLES
            && let Some(apart) = separating_order(more, slab)
        {
            resolved = apart;
        }
    }
    resolved
}

/// Orders triangles so that all later ones lie beyond an edge of each; the last needs no line.
/// `None` if there is no such order.
fn separating_order(mut triangles: Vec<Triangle>, slab: &Slab) -> Option<Vec<Separated>> {
    let mut order = Vec::new();
    while triangles.len() > 1 {
        let of = |i: usize| {
            let Triangle { corners, .. } = triangles[i];
            let others = || {
                triangles
                    .iter()
                    .enumerate()
                    .filter(move |&(k, _)| k != i)
                    .flat_map(|(_, other)| &other.corners)
            };
            (0..3).find_map(|k| {
                let [from, to, opposite] = [corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]];
                let across = slab.normal.cross(to - from).normalize_or_zero();
                let across = if across.dot(opposite - from) < 0.0 {
                    across
                } else {
                    -across
                };
                let height = across.dot(from);
                let separates =
                    others().all(|corner| across.dot(*corner) >= height - slab.tolerance());
                let line = Line {
                    normal: across,
                    height,
                };
                separates.then_some((i, line))
            })
        };
        let (first, line) = (0..triangles.len()).find_map(of)?;
        let triangle = triangles.swap_remove(first);
        order.push(Separated { triangle, line });
    }
    order.extend(triangles.pop().map(|triangle| Separated {
        triangle,
        line: Line::INFINITE,
    }));
    Some(order)
}
