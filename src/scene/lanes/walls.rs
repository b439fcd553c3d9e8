//! Walls as half-spaces: of the triangles in the surface of a scene's convex hull a ray from within
//! can meet one alone, which its exit from the hull tells.
//!
//! Rays that leave near to where two walls, or two triangles of one, meet are not decided here. How
//! near that is lies so far above all roundings that the one triangle is hit or missed as it is
//! where all triangles are tested.

use glam::DVec3;

use super::PrimitiveData;
use crate::geometry::hull::{Hull, Slab};
use crate::geometry::offsets::{OFFSET, SINGLE_EDGE_MARGIN};
use crate::geometry::shape::Ray;
use crate::geometry::watertight::{LaneShear, TriangleHit};
use crate::math::real::{Mask, Real, Vector};
use crate::math::simd::{Row, Scalar, Wide};
use crate::scene::{PartShape, Scene};

/// How near to an edge a ray may leave the hull and still be decided, relative to the largest
/// coordinate of the scene; much more than rounding can move it, if it leaves at [`STEEP`] or
/// steeper.
const MARGIN: f64 = OFFSET;
/// The same in single precision, 2⁻¹⁵.
const SINGLE_MARGIN: f64 = 2.0 * SINGLE_EDGE_MARGIN;
/// The least cosine between a ray and the normal of a wall that is decided.
const STEEP: f64 = 1.0 / 32.0;
/// To test fewer triangles one by one takes as long.
const WORTH: usize = 12;
/// How many triangles of a wall are told apart.
const MOST: usize = 4;

/// The walls of a small scene.
pub(super) struct Walls<T> {
    walls: Vec<Wall<T>>,
    /// The largest coordinate of the scene.
    extent: f64,
}

/// Triangles in a plane, told apart by lines: what lies on the negative side of the first line may
/// be in the first triangle alone, what of the rest lies on the negative side of the second line in
/// the second, and so on.
///
/// Normals and heights of three lines, then four triangles by their places among the scene's
/// primitives.
struct Wall<T>(Row<T, 16>);

/// A triangle of a wall: its place among the scene's primitives, and its corners.
type Piece = (usize, [DVec3; 3]);

/// A line in a wall: its normal, and its height along that.
type Line = (DVec3, f64);

/// Where rays leave the hull.
pub(super) struct Exit<R: Real> {
    /// The rays of which this is certain.
    pub decided: R::Mask,
    /// The triangle there.
    pub primitive: R,
    /// How they hit it, if they do.
    pub hit: TriangleHit<R>,
}

impl<T: Scalar> Walls<T> {
    /// The walls of a scene with this hull, and which of its primitives they are; `None` if these
    /// are too few. Triangles that overlap with those of a wall, or are too many, are left out.
    pub fn new(scene: &Scene, hull: &Hull) -> Option<(Self, Vec<bool>)> {
        let (mut walls, mut is_told) = (Vec::new(), vec![false; scene.parts().len()]);
        for slab in &hull.slabs {
            for side in [0, 1] {
                let corners = scene.parts().iter().map(|part| match part.shape {
                    PartShape::Triangle { vertices, .. } => Some(scene.corners(vertices)),
                    PartShape::Sphere(_) => None,
                });
                let pieces = corners
                    .enumerate()
                    .filter_map(|(id, corners)| Some((id, corners?)));
                let told = tell_apart(
                    pieces
                        .filter(|(_, corners)| slab.is_in_end(side, corners))
                        .collect(),
                    slab,
                );
                told.iter().for_each(|&((id, _), _)| is_told[id] = true);
                walls.push(Wall::new(&told));
            }
        }
        let count = is_told.iter().filter(|is_told| **is_told).count();
        (count >= WORTH).then(|| {
            (
                Self {
                    walls,
                    extent: scene.extent(),
                },
                is_told,
            )
        })
    }

    /// Where the `active` rays leave the hull, of walls whose data are among the `parts` of the
    /// scene; `None` if none of them starts within.
    #[inline]
    pub fn exit<R: Wide<N, Scalar = T>, const N: usize>(
        &self,
        hull: &Hull,
        parts: &[PrimitiveData<T>],
        ray: &Ray<R::Vector>,
        (shear, active): (&LaneShear<R>, R::Mask),
    ) -> Option<Exit<R>> {
        let within = active & hull.holds(ray.origin);
        if !within.any() {
            return None;
        }
        let (zero, never) = (R::splat(0.0), R::splat(f64::INFINITY));
        let margin = R::by_precision(self.extent * MARGIN, self.extent * SINGLE_MARGIN);
        let [x, y, z] = ray.direction.components().map(R::abs);
        let scale = x.at_least(y).at_least(z);
        let steep = scale * STEEP;
        // Between `early` and `late` it leaves by the `wall`, and by no other before `other`.
        let (mut wall, mut early, mut late, mut other) = (zero, never, never, never);
        for (number, slab) in hull.slabs.iter().enumerate() {
            let normal = R::Vector::splat_vector(slab.normal);
            let (height, rise) = (normal.dot(ray.origin), normal.dot(ray.direction));
            let falls = rise.below(zero);
            let [top, bottom] = slab.ends.map(R::splat);
            let distance = R::choose(falls, bottom + height, top - height);
            let speed = rise.abs();
            let inverse = speed.at_least(steep).recip();
            let begin = (distance - margin) * inverse;
            let end = R::choose(speed.above(steep), (distance + margin) * inverse, never);
            let nearer = end.below(late);
            other = other.at_most(R::choose(nearer, early, begin));
            early = R::choose(nearer, begin, early);
            late = R::choose(nearer, end, late);
            let here = (2 * number) as f64;
            wall = R::choose(
                nearer,
                R::choose(falls, R::splat(here + 1.0), R::splat(here)),
                wall,
            );
        }
        let point = ray.at((early + late) * 0.5);
        let width = (late - early) * scale;
        let [a, b, c, d, e, f, g, h, i, j, k, l, triangles @ ..] =
            R::of_rows(wall.whole().map(|place| &self.walls[place as usize].0));
        let (mut primitive, mut clear) = (triangles[3], zero.equals(zero));
        for (n, line) in [[a, b, c, d], [e, f, g, h], [i, j, k, l]]
            .into_iter()
            .enumerate()
            .rev()
        {
            let [x, y, z, height] = line;
            let above = R::Vector::of([x, y, z]).dot(point) - height;
            primitive = R::choose(above.below(zero), triangles[n], primitive);
            clear = clear & above.abs().above(width);
        }
        let numbers = R::of_rows(
            primitive
                .whole()
                .map(|place| &parts[place as usize].numbers),
        );
        let corner =
            |k: usize| shear.project([numbers[3 * k], numbers[3 * k + 1], numbers[3 * k + 2]]);
        let mut hit = shear.hit([&corner(0), &corner(1), &corner(2)]);
        let decided = within & other.above(late) & clear;
        hit.t = R::choose(decided, hit.t, never);
        Some(Exit {
            decided,
            primitive,
            hit,
        })
    }
}

impl<T: Scalar> Wall<T> {
    /// Of at most [`MOST`] triangles, each with the line that tells it from those after it.
    fn new(told: &[(Piece, Line)]) -> Self {
        let mut numbers = [T::rounded(0.0); 16];
        for line in 0..MOST - 1 {
            // What lies on the negative side of a line at infinity is everything.
            let (normal, height) = told
                .get(line)
                .map_or((DVec3::ZERO, f64::INFINITY), |&(_, line)| line);
            let [x, y, z] = normal.to_array();
            numbers[4 * line..][..4].copy_from_slice(&[x, y, z, height].map(T::rounded));
        }
        for (number, ((id, _), _)) in numbers[4 * (MOST - 1)..].iter_mut().zip(told) {
            *number = T::rounded(*id as f64);
        }
        Self(Row(numbers))
    }
}

/// At most [`MOST`] of these triangles in a plane that lines tell apart, the largest first, with
/// those lines.
fn tell_apart(mut pieces: Vec<Piece>, slab: &Slab) -> Vec<(Piece, Line)> {
    let area = |(_, [a, b, c]): &Piece| (b - a).cross(c - a).length();
    pieces.sort_by(|a, b| area(b).total_cmp(&area(a)));
    let mut told = Vec::new();
    for piece in pieces {
        let more: Vec<Piece> = told
            .iter()
            .map(|&(piece, _)| piece)
            .chain([piece])
            .collect();
        if more.len() <= MOST
            && let Some(apart) = in_order(more, slab)
        {
            told = apart;
        }
    }
    told
}

/// The triangles in an order in which each has an edge with all that come after on its other side;
/// the last needs none.
fn in_order(mut pieces: Vec<Piece>, slab: &Slab) -> Option<Vec<(Piece, Line)>> {
    let mut order = Vec::new();
    while pieces.len() > 1 {
        let of = |i: usize| {
            let (_, corners) = pieces[i];
            let others = || {
                pieces
                    .iter()
                    .enumerate()
                    .filter(move |&(k, _)| k != i)
                    .flat_map(|(_, (_, corners))| corners)
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
                separates.then_some((i, (across, height)))
            })
        };
        let (first, line) = (0..pieces.len()).find_map(of)?;
        order.push((pieces.swap_remove(first), line));
    }
    order.extend(
        pieces
            .pop()
            .map(|last| (last, (DVec3::ZERO, f64::INFINITY))),
    );
    Some(order)
}
