//! Lists of triangles that all lanes test together.

use std::ops::Range;

use glam::DVec3;

use crate::geometry::hull::MAX_PRIMITIVES;
use crate::geometry::watertight::{LaneShear, Projected, TriangleHit, edge, in_bounds};
use crate::math::real::{Mask, Real};
use crate::math::simd::{Scalar, Wide, map_array};

/// A primitive in a list that all lanes test.
pub(super) struct ListedPrimitive<T, S> {
    /// Index among the primitives of the scene.
    pub(super) id: T,
    /// Whether it is glass, which some shadow rays ignore.
    pub(super) is_glass: bool,
    pub(super) shape: S,
}

/// Indices of a triangle's vertices and edges.
pub(super) struct Triangle<T> {
    pub(super) vertices: [u8; 3],
    /// Edges opposite to each vertex.
    pub(super) edges: [u8; 3],
    /// -1 for edges stored in the opposite direction, else 1.
    pub(super) signs: [T; 3],
    /// Rotation of the side masks of each edge: half a word for edges stored in the opposite
    /// direction, else 0.
    pub(super) rotations: [u8; 3],
}

/// Triangles of a small scene with shared vertices and edges.
#[derive(Default)]
pub(super) struct Triangles<T> {
    pub(super) vertices: Vec<[T; 3]>,
    /// Vertices of each edge, shared by the triangles on both sides.
    pub(super) edges: Vec<[u8; 2]>,
    pub(super) list: Vec<ListedPrimitive<T, Triangle<T>>>,
}

/// Vertices and edges projected along rays; as many entries as 8-bit indices.
pub(super) struct ProjectedScene<R, const N: usize> {
    pub(super) vertices: Box<[Projected<R>; MAX_INDICES]>,
    pub(super) edges: Box<[R; MAX_INDICES]>,
    /// Bits of the lanes that have each vertex behind them, and `N` bits higher those for which it
    /// is too far.
    pub(super) out_of_range: [u32; MAX_INDICES],
    /// Bits of the lanes that pass each edge on its negative side, and half a word higher those on
    /// its positive side.
    pub(super) side_masks: [u32; MAX_INDICES],
    /// Triangles that rays may hit, with bits of these lanes; one entry more than needed.
    pub(super) candidates: [(u8, u32); MAX_PRIMITIVES + 1],
}

/// Number of vertices or edges that 8 bits can index; [`MAX_PRIMITIVES`] triangles have fewer.
pub(super) const MAX_INDICES: usize = 256;
/// Half the bits of a side mask, at least one for each lane.
const HALF_WORD: u32 = u32::BITS / 2;

impl<T: Scalar> Triangles<T> {
    pub(super) fn add(&mut self, corners: [DVec3; 3], id: T, is_glass: bool) {
        let rounded = |corner: DVec3| corner.to_array().map(T::rounded);
        let [a, b, c] = corners.map(|corner| index_of(&mut self.vertices, rounded(corner)));
        let ends = [[c, b], [a, c], [b, a]];
        let edges = ends.map(|[from, to]| index_of(&mut self.edges, [from.min(to), from.max(to)]));
        let reversed = ends.map(|[from, to]| from > to);
        let signs = reversed.map(|turned| T::rounded(if turned { -1.0 } else { 1.0 }));
        let rotations = reversed.map(|turned| if turned { HALF_WORD as u8 } else { 0 });
        let shape = Triangle {
            vertices: [a, b, c],
            edges,
            signs,
            rotations,
        };
        self.list.push(ListedPrimitive {
            id,
            is_glass,
            shape,
        });
    }

    /// Projects vertices and edges along rays, which may end at `limit`.
    #[inline]
    pub(super) fn project<R: Wide<N, Scalar = T>, const N: usize>(
        &self,
        shear: &LaneShear<R>,
        limit: Option<R>,
        projected: &mut ProjectedScene<R, N>,
    ) {
        let zero = R::splat(0.0);
        // The distance of a hit is a weighted mean of its vertices' distances, up to rounding.
        let limit = limit.map(|limit| limit * R::by_precision(1.0 + 1e-9, 1.0 + 1e-5));
        for ((vertex, projected), out_of_range) in self
            .vertices
            .iter()
            .zip(projected.vertices.iter_mut())
            .zip(&mut projected.out_of_range)
        {
            *projected = shear.project(map_array(*vertex, R::splat_scalar));
            let distance = shear.distance(projected[2]);
            *out_of_range = distance.cmplt(zero).bits();
            if let Some(limit) = limit {
                *out_of_range |= distance.cmpgt(limit).bits() << N;
            }
        }
        let vertices = &*projected.vertices;
        for ((&[a, b], value), side_masks) in self
            .edges
            .iter()
            .zip(projected.edges.iter_mut())
            .zip(&mut projected.side_masks)
        {
            *value = edge(&vertices[usize::from(a)], &vertices[usize::from(b)]);
            *side_masks = value.cmplt(zero).bits() | value.cmpgt(zero).bits() << HALF_WORD;
        }
    }

    /// Calls `on_hit` with the primitives and hits of the `active` lanes, in batches of at most one
    /// hit per lane.
    #[inline]
    pub(super) fn hits<R: Wide<N, Scalar = T>, const N: usize>(
        &self,
        shear: &LaneShear<R>,
        projected: &mut ProjectedScene<R, N>,
        active: R::Mask,
        through_glass: bool,
        mut on_hit: impl FnMut(R, &TriangleHit<R>),
    ) {
        let (zero, all) = (R::splat(0.0), R::Mask::splat(true));
        // Triangles without area are not hit.
        let (mut ids, mut edges, mut depths) = (zero, [zero; 3], [zero; 3]);
        let (mut taken, mut first) = (0, 0);
        let count = self.list_candidates(active, through_glass, projected);
        for (place, &(index, lanes)) in projected.candidates[..count].iter().enumerate() {
            let ListedPrimitive { id, shape, .. } = &self.list[usize::from(index)];
            if taken & lanes != 0 {
                let in_bounds = || self.in_bounds(projected, first..place);
                on_hit(ids, &shear.hit_inside(all, edges, depths, in_bounds));
                (edges, taken, first) = ([zero; 3], 0, place);
            }
            taken |= lanes;
            let lanes = R::Mask::from_bits(lanes);
            ids = R::select(lanes, R::splat_scalar(*id), ids);
            for k in 0..3 {
                edges[k] = R::select(
                    lanes,
                    projected.edges[usize::from(shape.edges[k])] * R::splat_scalar(shape.signs[k]),
                    edges[k],
                );
                depths[k] = R::select(
                    lanes,
                    projected.vertices[usize::from(shape.vertices[k])][2],
                    depths[k],
                );
            }
        }
        if taken != 0 {
            let in_bounds = || self.in_bounds(projected, first..count);
            on_hit(ids, &shear.hit_inside(all, edges, depths, in_bounds));
        }
    }

    /// Returns the lanes whose ray is [`in_bounds`] of the triangle that it may hit among these
    /// candidates.
    #[cold]
    fn in_bounds<R: Wide<N, Scalar = T>, const N: usize>(
        &self,
        projected: &ProjectedScene<R, N>,
        batch: Range<usize>,
    ) -> R::Mask {
        let none = R::Mask::splat(false);
        projected.candidates[batch]
            .iter()
            .fold(none, |within, &(index, lanes)| {
                let vertices = self.list[usize::from(index)].shape.vertices;
                let vertices =
                    map_array(vertices, |vertex| projected.vertices[usize::from(vertex)]);
                within | R::Mask::from_bits(lanes) & in_bounds(vertices)
            })
    }

    /// Lists the triangles that a ray in an `active` lane may hit, and returns their number: the
    /// ray's line passes through, and the vertices are neither all behind it nor all beyond its
    /// limit.
    #[inline]
    pub(super) fn list_candidates<R: Wide<N, Scalar = T>, const N: usize>(
        &self,
        active: R::Mask,
        through_glass: bool,
        projected: &mut ProjectedScene<R, N>,
    ) -> usize {
        let active = active.bits();
        let mut count = 0;
        for (index, triangle) in self.list.iter().enumerate() {
            let asking = if through_glass & triangle.is_glass {
                0
            } else {
                active
            };
            let lanes = asking & !projected.misses(&triangle.shape);
            projected.candidates[count] = (index as u8, lanes);
            count += usize::from(lanes != 0);
        }
        count
    }
}

impl<R: Real, const N: usize> ProjectedScene<R, N> {
    pub(super) fn new() -> Self {
        let zero = R::splat(0.0);
        Self {
            vertices: boxed([zero; 3]),
            edges: boxed(zero),
            out_of_range: [0; MAX_INDICES],
            side_masks: [0; MAX_INDICES],
            candidates: [(0, 0); MAX_PRIMITIVES + 1],
        }
    }

    /// Returns bits of the lanes that certainly miss a triangle.
    #[inline]
    pub(super) fn misses<T>(&self, triangle: &Triangle<T>) -> u32 {
        let side = |k: usize| {
            let masks = self.side_masks[usize::from(triangle.edges[k])];
            masks.rotate_left(triangle.rotations[k].into())
        };
        let [a, b, c] = [side(0), side(1), side(2)];
        let [x, y, z] = triangle
            .vertices
            .map(|vertex| self.out_of_range[usize::from(vertex)]);
        let (side_masks, out_of_range) = (a | b | c, x & y & z);
        (side_masks & side_masks >> HALF_WORD) | out_of_range | out_of_range >> N
    }
}

/// Fills an array where it lies: `Box::new` would copy it from the stack.
fn boxed<T: Clone>(value: T) -> Box<[T; MAX_INDICES]> {
    let array = vec![value; MAX_INDICES].into_boxed_slice().try_into();
    array.unwrap_or_else(|_| unreachable!("the slice has this length"))
}

/// Returns the index of a value in a list, to which it is added if missing.
pub(super) fn index_of<T: PartialEq>(list: &mut Vec<T>, value: T) -> u8 {
    let index = list
        .iter()
        .position(|known| *known == value)
        .unwrap_or_else(|| {
            list.push(value);
            list.len() - 1
        });
    index as u8
}
