//! Packet intersection: linear lists of primitives in small scenes, hull exit walls where the hull
//! decides which triangle is hit, and otherwise traversal of the hierarchy, as a packet or ray by
//! ray.

pub(crate) mod material;
mod rays;
mod walls;

use std::array::from_fn;
use std::fmt;

use glam::DVec3;

use super::{PrimitiveShape, Scene, ScenePrimitive};
use crate::film::FixedPointFeatures;
use crate::geometry::bvh::{Nearest, PacketHit, PacketStack, PrimitiveHit, sphere_hit};
use crate::geometry::hull::MAX_PRIMITIVES;
use crate::geometry::offsets::{EDGE_MARGIN, RayOrigin};
use crate::geometry::shape::{Ray, Sphere};
use crate::geometry::specular_connection::{Caster, CasterKind};
use crate::geometry::watertight::{LaneShear, Projected, Shear, TriangleHit, edge};
use crate::math::real::{Mask, Real, Vector};
use crate::math::simd::{AlignedArray, Scalar, Wide};
use material::{EMITTER, Material, SPHERE};
use walls::HullWalls;

pub use rays::{EightRays, LaneRays};

/// Intersection and shading data of a primitive.
pub(crate) struct PrimitiveData<T> {
    /// Three corners of a triangle, the first of which is the centre of a sphere; the normal of a
    /// triangle's front; the margin of a triangle for
    /// [`inner_point`](crate::geometry::offsets::inner_point), or the radius of a sphere, negative
    /// if its normal points to its centre; the colour and the numbers of its [`Material`]; the
    /// height above it at which rays start. The remaining entries are padding.
    pub numbers: AlignedArray<T, 24>,
    /// Kinds of its material, with [`EMITTER`] and [`SPHERE`].
    pub kinds: u16,
    /// Features of a triangle, for the film.
    pub features: Option<FixedPointFeatures>,
    pub surface: u32,
    pub emitter: Option<u32>,
    /// Indices of the [specular casters](Scene::specular_casters) by which it reflects and
    /// refracts.
    pub casters: [u8; 2],
}

/// Distances that rays keep from a primitive and its edges.
#[derive(Clone, Copy)]
struct RayMargins {
    /// Margin at the edges of a triangle: [`EDGE_MARGIN`], or its counterpart in single precision.
    margin: f64,
    /// Height above the primitive at which rays start.
    offset: f64,
}

/// A primitive in a list that all lanes test.
struct ListedPrimitive<T, S> {
    /// Index among the primitives of the scene.
    id: T,
    /// Whether it is glass, which some shadow rays ignore.
    is_glass: bool,
    shape: S,
}

/// Indices of a triangle's vertices and edges.
struct Triangle<T> {
    vertices: [u8; 3],
    /// Edges opposite to each vertex.
    edges: [u8; 3],
    /// -1 for edges stored in the opposite direction, else 1.
    signs: [T; 3],
    /// Whether each edge is stored in the opposite direction.
    reversed: [bool; 3],
}

/// Triangles of a small scene with shared vertices and edges.
#[derive(Default)]
struct Triangles<T> {
    vertices: Vec<[T; 3]>,
    /// Vertices of each edge, shared by the triangles on both sides.
    edges: Vec<[u8; 2]>,
    list: Vec<ListedPrimitive<T, Triangle<T>>>,
}

/// A specular caster in the precision of the lanes.
pub(crate) struct CasterData<T> {
    pub kind: CasterKind,
    pub numbers: AlignedArray<T, 16>,
}

impl<T: Scalar> CasterData<T> {
    pub fn new(kind: CasterKind, caster: &Caster<DVec3>) -> Self {
        let [a, b, c] = [caster.centre, caster.normal, caster.reflectance].map(|v| v.to_array());
        let numbers = [
            a,
            b,
            c,
            [caster.radius, caster.area, caster.selection_weight],
            [caster.relative_ior, caster.index, 0.0],
            [0.0; 3],
        ];
        Self {
            kind,
            numbers: AlignedArray(from_fn(|i| T::rounded(numbers[i / 3][i % 3]))),
        }
    }
}

/// Scene data in the precision of the lanes.
pub(crate) struct SceneData<T> {
    /// Whether rays are tested against lists of all primitives, not through the hierarchy.
    is_small: bool,
    // The next five are empty unless `is_small`.
    triangles: Triangles<T>,
    /// Triangles that are not walls of the hull.
    non_walls: Triangles<T>,
    walls: Option<HullWalls<T>>,
    /// Triangles that `walls` does not resolve.
    unresolved: Triangles<T>,
    spheres: Vec<ListedPrimitive<T, Sphere>>,
    /// Data of the scene's primitives, in their order.
    primitives: Vec<PrimitiveData<T>>,
    /// Union of the kinds of all primitives.
    pub(crate) kinds: u16,
    /// Data of the scene's specular casters, in their order.
    pub casters: Vec<CasterData<T>>,
}

impl<T> fmt::Debug for SceneData<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SceneData").finish_non_exhaustive()
    }
}

/// A scene with its data for lanes.
#[derive(Clone, Copy)]
pub(crate) struct LaneScene<'a, R: Wide<N>, const N: usize> {
    pub scene: &'a Scene,
    pub data: &'a SceneData<R::Scalar>,
}

/// Buffers for intersection, allocated when first needed.
pub(crate) struct IntersectionScratch<R, const N: usize> {
    /// Projected vertices and edges of small scenes.
    projected: Option<Box<ProjectedScene<R, N>>>,
    /// Stack of packet traversal.
    stack: Option<Box<PacketStack<N>>>,
}

/// Vertices and edges projected along rays; as many entries as 8-bit indices.
struct ProjectedScene<R, const N: usize> {
    vertices: [Projected<R>; MAX_INDICES],
    edges: [R; MAX_INDICES],
    /// Bits of the lanes that have each vertex behind them, and `N` bits higher those for which it
    /// is too far.
    out_of_range: [u32; MAX_INDICES],
    /// Bits of the lanes that pass each edge on its negative side, and `N` bits higher those on its
    /// positive side; then both for the opposite direction of the edge.
    side_masks: [[u32; 2]; MAX_INDICES],
    /// Triangles that rays may hit, with bits of these lanes; one entry more than needed.
    candidates: [(u8, u32); MAX_PRIMITIVES + 1],
}

/// Number of vertices or edges that 8 bits can index; [`MAX_PRIMITIVES`] triangles have fewer.
const MAX_INDICES: usize = 256;

impl<T: Scalar> SceneData<T> {
    pub fn new(scene: &Scene) -> Self {
        let [mut triangles, mut non_walls, mut unresolved] = from_fn(|_| Triangles::default());
        let mut spheres = Vec::new();
        let is_small = scene.scene_primitives().len() <= MAX_PRIMITIVES;
        let walls = scene.hull().and_then(|hull| HullWalls::new(scene, hull));
        for (id, primitive) in scene
            .scene_primitives()
            .iter()
            .enumerate()
            .take_while(|_| is_small)
        {
            let is_glass = scene.is_glass(id as u32);
            let is_wall = scene.hull().is_some_and(|hull| hull.is_wall[id]);
            let is_resolved = walls
                .as_ref()
                .is_some_and(|(_, is_resolved)| is_resolved[id]);
            let id = T::rounded(id as f64);
            match primitive.shape {
                PrimitiveShape::Sphere(shape) => spheres.push(ListedPrimitive {
                    id,
                    is_glass,
                    shape,
                }),
                PrimitiveShape::Triangle { vertices, .. } => {
                    triangles.add(scene.corners(vertices), id, is_glass);
                    if !is_wall {
                        non_walls.add(scene.corners(vertices), id, is_glass);
                    }
                    if !is_resolved {
                        unresolved.add(scene.corners(vertices), id, is_glass);
                    }
                }
            }
        }
        let margins = |primitive: &ScenePrimitive| {
            if T::IS_SINGLE {
                RayMargins {
                    margin: scene.single_edge_margin(primitive),
                    offset: scene.single_offset(primitive),
                }
            } else {
                RayMargins {
                    margin: EDGE_MARGIN,
                    offset: scene.offset(),
                }
            }
        };
        let primitives: Vec<_> = (0..)
            .zip(scene.scene_primitives())
            .map(|(id, primitive)| PrimitiveData::new(scene, id, primitive, margins(primitive)))
            .collect();
        let kinds = primitives
            .iter()
            .fold(0, |kinds, primitive| kinds | primitive.kinds);
        let casters = scene
            .specular_casters()
            .all()
            .iter()
            .map(|caster| CasterData::new(caster.kind, &caster.parameters))
            .collect();
        let walls = walls.map(|(walls, _)| walls);
        Self {
            is_small,
            triangles,
            non_walls,
            walls,
            unresolved,
            spheres,
            primitives,
            kinds,
            casters,
        }
    }
}

impl<'a, R: Wide<N>, const N: usize> LaneScene<'a, R, N> {
    pub fn new(scene: &'a Scene) -> Self {
        Self {
            scene,
            data: scene.lane_data(),
        }
    }

    /// Returns the primitive with this index.
    #[inline]
    pub(crate) fn primitive(self, number: u32) -> &'a PrimitiveData<R::Scalar> {
        &self.data.primitives[number as usize]
    }

    /// Finds the nearest hits of the `active` lanes.
    #[inline]
    pub fn closest(
        self,
        ray: &Ray<R::Vector>,
        active: R::Mask,
        scratch: &mut IntersectionScratch<R, N>,
    ) -> PacketHit<R, N> {
        let (scene, data) = (self.scene, self.data);
        if N == 1 || !data.is_small {
            return if N > 1 && is_coherent::<R, N>(ray.direction, active) {
                scene
                    .bvh()
                    .closest_of_packet::<R, N>(ray, active, scratch.stack())
            } else {
                self.closest_per_lane(ray, active)
            };
        }
        let mut nearest = Nearest::new();
        let shear = Shear::new(ray);
        let projected = scratch.projected();
        let mut left = active;
        if let (Some(walls), Some(hull)) = (&data.walls, scene.hull())
            && let Some(exit) = walls.exit(hull, &data.primitives, ray, &shear, active)
        {
            left = active & !exit.decided;
            nearest.take_nearer(exit.primitive, &exit.hit);
            data.unresolved.project(&shear, None, projected);
            data.unresolved
                .hits(&shear, projected, exit.decided, false, |ids, hit| {
                    nearest.take_nearer(ids, hit);
                });
        }
        if left.any() {
            data.triangles.project(&shear, None, projected);
            data.triangles
                .hits(&shear, projected, left, false, |ids, hit| {
                    nearest.take_nearer(ids, hit);
                });
        }
        for sphere in &data.spheres {
            nearest.take_nearer(R::splat_scalar(sphere.id), &sphere_hit(&sphere.shape, ray));
        }
        nearest.of(active)
    }

    fn closest_per_lane(self, ray: &Ray<R::Vector>, active: R::Mask) -> PacketHit<R, N> {
        let (bits, rays) = (active.bits(), rays::<R, N>(ray));
        let closest = |i: usize| self.scene.bvh().closest(&rays[i], f64::INFINITY);
        let hits: [Option<PrimitiveHit>; N] =
            from_fn(|i| if bits >> i & 1 == 1 { closest(i) } else { None });
        PacketHit {
            hit_mask: R::Mask::from_fn(|i| hits[i].is_some()),
            primitive: from_fn(|i| hits[i].map_or(0, |hit| hit.primitive)),
            t: R::from_lanes(|i| hits[i].map_or(f64::INFINITY, |hit| hit.t)),
            weights: from_fn(|k| R::from_lanes(|i| hits[i].map_or(0.0, |hit| hit.weights[k]))),
        }
    }

    /// Returns the `active` lanes in which two surface points with unit normals are mutually
    /// visible, as [`Scene::visible`].
    #[inline]
    pub fn visible(
        self,
        x: &RayOrigin<R::Vector>,
        y: &RayOrigin<R::Vector>,
        through_glass: bool,
        active: R::Mask,
        scratch: &mut IntersectionScratch<R, N>,
    ) -> R::Mask {
        let (scene, data, segment) = (self.scene, self.data, x.segment(y));
        if N == 1 {
            let free = |i: usize| {
                let [origin, direction] = [segment.origin, segment.direction].map(|v| v.lane(i));
                scene.is_unoccluded(&Ray::new(origin, direction), through_glass)
            };
            return R::Mask::from_fn(|i| active.lane(i) && free(i));
        }
        let blocks = |id: u32| !(through_glass && scene.is_glass(id));
        if !data.is_small {
            return if is_coherent::<R, N>(segment.direction, active) {
                active
                    & !scene.bvh().occluded_of_packet::<R, N>(
                        &segment,
                        active,
                        blocks,
                        scratch.stack(),
                    )
            } else {
                let (bits, rays) = (active.bits(), rays::<R, N>(&segment));
                R::Mask::from_fn(|i| {
                    bits >> i & 1 == 1 && !scene.bvh().occluded(&rays[i], 1.0, blocks)
                })
            };
        }
        let one = R::splat(1.0);
        let contains = |point| {
            scene
                .hull()
                .map_or(R::Mask::splat(false), |hull| hull.contains(point))
        };
        let within = active & contains(segment.origin) & contains(segment.at(one));
        let mut free = active;
        let shear = Shear::new(&segment);
        let projected = scratch.projected();
        for (triangles, asking) in [
            (&data.non_walls, within),
            (&data.triangles, active & !within),
        ] {
            if asking.any() {
                triangles.project(&shear, Some(one), projected);
                triangles.hits(&shear, projected, asking, through_glass, |_, hit| {
                    free = free & !hit.t.below(one);
                });
            }
        }
        for sphere in data
            .spheres
            .iter()
            .filter(|sphere| !(through_glass && sphere.is_glass))
        {
            free = free & !sphere.shape.distance(&segment).below(one);
        }
        free
    }

    /// Returns whether all lanes test a list of all primitives, and these are triangles.
    pub fn has_few_triangles(self) -> bool {
        self.data.is_small && self.data.spheres.is_empty()
    }
}

/// Returns whether rays traverse a hierarchy as a packet. This is usually faster if their
/// directions agree in sign along two of three axes. In single precision they always do: single
/// rays are traced in double precision, and a ray's hit must not depend on the other rays.
#[inline]
fn is_coherent<R: Wide<N>, const N: usize>(direction: R::Vector, active: R::Mask) -> bool {
    let (active, zero): (u32, R) = (active.bits(), R::splat(0.0));
    let is_even = |component: &R| {
        let back = component.below(zero).bits() & active;
        back == 0 || back == active
    };
    R::IS_SINGLE
        || direction
            .components()
            .iter()
            .filter(|component| is_even(component))
            .count()
            >= 2
}

/// Returns the ray of each lane.
#[inline]
fn rays<R: Wide<N>, const N: usize>(ray: &Ray<R::Vector>) -> [Ray; N] {
    let [origins, directions] = [ray.origin, ray.direction].map(|v| v.components().map(R::lanes));
    let of = |components: [[R::Scalar; N]; 3], i: usize| {
        DVec3::from_array(components.map(|lanes| lanes[i].into()))
    };
    from_fn(|i| Ray::new(of(origins, i), of(directions, i)))
}

impl<T: Scalar> Triangles<T> {
    fn add(&mut self, corners: [DVec3; 3], id: T, is_glass: bool) {
        let rounded = |corner: DVec3| corner.to_array().map(T::rounded);
        let [a, b, c] = corners.map(|corner| index_of(&mut self.vertices, rounded(corner)));
        let ends = [[c, b], [a, c], [b, a]];
        let edges = ends.map(|[from, to]| index_of(&mut self.edges, [from.min(to), from.max(to)]));
        let reversed = ends.map(|[from, to]| from > to);
        let signs = reversed.map(|turned| T::rounded(if turned { -1.0 } else { 1.0 }));
        let shape = Triangle {
            vertices: [a, b, c],
            edges,
            signs,
            reversed,
        };
        self.list.push(ListedPrimitive {
            id,
            is_glass,
            shape,
        });
    }

    /// Projects vertices and edges along rays, which may end at `limit`.
    #[inline]
    fn project<R: Wide<N, Scalar = T>, const N: usize>(
        &self,
        shear: &LaneShear<R>,
        limit: Option<R>,
        projected: &mut ProjectedScene<R, N>,
    ) {
        let zero = R::splat(0.0);
        let pair = |first: R::Mask, second: R::Mask| first.bits() | second.bits() << N;
        // The distance of a hit is a weighted mean of its vertices' distances, up to rounding.
        let limit = limit.map(|limit| limit * R::by_precision(1.0 + 1e-9, 1.0 + 1e-5));
        for ((vertex, projected), out_of_range) in self
            .vertices
            .iter()
            .zip(&mut projected.vertices)
            .zip(&mut projected.out_of_range)
        {
            *projected = shear.project(vertex.map(R::splat_scalar));
            let distance = shear.distance(projected[2]);
            *out_of_range = distance.below(zero).bits();
            if let Some(limit) = limit {
                *out_of_range |= distance.above(limit).bits() << N;
            }
        }
        for ((&[a, b], value), side_masks) in self
            .edges
            .iter()
            .zip(&mut projected.edges)
            .zip(&mut projected.side_masks)
        {
            *value = edge(
                &projected.vertices[usize::from(a)],
                &projected.vertices[usize::from(b)],
            );
            let [negative, positive] = [value.below(zero), value.above(zero)];
            *side_masks = [pair(negative, positive), pair(positive, negative)];
        }
    }

    /// Calls `on_hit` with the primitives and hits of the `active` lanes, in batches of at most one
    /// hit per lane.
    #[inline]
    fn hits<R: Wide<N, Scalar = T>, const N: usize>(
        &self,
        shear: &LaneShear<R>,
        projected: &mut ProjectedScene<R, N>,
        active: R::Mask,
        through_glass: bool,
        mut on_hit: impl FnMut(R, &TriangleHit<R>),
    ) {
        let zero = R::splat(0.0);
        // Triangles without area are not hit.
        let (mut ids, mut edges, mut depths) = (zero, [zero; 3], [zero; 3]);
        let mut taken = 0;
        let count = self.list_candidates(active, through_glass, projected);
        for &(index, lanes) in &projected.candidates[..count] {
            let ListedPrimitive { id, shape, .. } = &self.list[usize::from(index)];
            if taken & lanes != 0 {
                on_hit(ids, &shear.hit_within(edges, depths));
                (edges, taken) = ([zero; 3], 0);
            }
            taken |= lanes;
            let lanes = R::Mask::from_bits(lanes);
            ids = R::choose(lanes, R::splat_scalar(*id), ids);
            for k in 0..3 {
                edges[k] = R::choose(
                    lanes,
                    projected.edges[usize::from(shape.edges[k])] * R::splat_scalar(shape.signs[k]),
                    edges[k],
                );
                depths[k] = R::choose(
                    lanes,
                    projected.vertices[usize::from(shape.vertices[k])][2],
                    depths[k],
                );
            }
        }
        if taken != 0 {
            on_hit(ids, &shear.hit_within(edges, depths));
        }
    }

    /// Lists the triangles that a ray in an `active` lane may hit, and returns their number: the
    /// ray's line passes through, and the vertices are neither all behind it nor all beyond its
    /// limit.
    #[inline]
    fn list_candidates<R: Wide<N, Scalar = T>, const N: usize>(
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

impl<T: Scalar> PrimitiveData<T> {
    fn new(
        scene: &Scene,
        id: u32,
        &ScenePrimitive {
            surface,
            emitter,
            shape,
            ..
        }: &ScenePrimitive,
        margins: RayMargins,
    ) -> Self {
        let ([a, b, c], normal, radius) = match shape {
            PrimitiveShape::Triangle { vertices, normal } => {
                (scene.corners(vertices), normal, margins.margin)
            }
            PrimitiveShape::Sphere(Sphere {
                centre,
                radius,
                inward,
                ..
            }) => ([centre; 3], DVec3::Z, if inward { -radius } else { radius }),
        };
        let is_sphere = matches!(shape, PrimitiveShape::Sphere(_));
        let of = &scene.surfaces()[surface as usize];
        let (material, colour) = (Material::new(of), of.bsdf.albedo());
        let kind = |kind: u16, is: bool| if is { kind } else { 0 };
        let kinds = material.kinds | kind(EMITTER, emitter.is_some()) | kind(SPHERE, is_sphere);
        let mut numbers = [T::default(); 24];
        let all = [a, b, c, normal]
            .into_iter()
            .flat_map(|vector| vector.to_array());
        let all = all
            .chain([radius])
            .chain(colour.to_array())
            .chain(material.numbers)
            .chain([margins.offset]);
        numbers
            .iter_mut()
            .zip(all)
            .for_each(|(number, value)| *number = T::rounded(value));
        let features = if is_sphere {
            None
        } else {
            FixedPointFeatures::new(colour, normal)
        };
        Self {
            numbers: AlignedArray(numbers),
            kinds,
            features,
            surface,
            emitter,
            casters: scene.specular_casters().casters_of_primitive(id),
        }
    }
}

impl<R: Real, const N: usize> IntersectionScratch<R, N> {
    pub fn new() -> Self {
        Self {
            projected: None,
            stack: None,
        }
    }

    fn projected(&mut self) -> &mut ProjectedScene<R, N> {
        self.projected
            .get_or_insert_with(|| Box::new(ProjectedScene::new()))
    }

    fn stack(&mut self) -> &mut PacketStack<N> {
        self.stack.get_or_insert_with(Box::default)
    }
}

impl<R: Real, const N: usize> ProjectedScene<R, N> {
    fn new() -> Self {
        let zero = R::splat(0.0);
        let (vertices, edges) = ([[zero; 3]; MAX_INDICES], [zero; MAX_INDICES]);
        let (out_of_range, side_masks, candidates) = (
            [0; MAX_INDICES],
            [[0; 2]; MAX_INDICES],
            [(0, 0); MAX_PRIMITIVES + 1],
        );
        Self {
            vertices,
            edges,
            out_of_range,
            side_masks,
            candidates,
        }
    }

    /// Returns bits of the lanes that certainly miss a triangle.
    #[inline]
    fn misses<T>(&self, triangle: &Triangle<T>) -> u32 {
        let side = |k: usize| {
            self.side_masks[usize::from(triangle.edges[k])][usize::from(triangle.reversed[k])]
        };
        let [a, b, c] = [side(0), side(1), side(2)];
        let [x, y, z] = triangle
            .vertices
            .map(|vertex| self.out_of_range[usize::from(vertex)]);
        let (side_masks, out_of_range) = (a | b | c, x & y & z);
        (side_masks & side_masks >> N) | out_of_range | out_of_range >> N
    }
}

/// Returns the index of a value in a list, to which it is added if missing.
fn index_of<T: PartialEq>(list: &mut Vec<T>, value: T) -> u8 {
    let index = list
        .iter()
        .position(|known| *known == value)
        .unwrap_or_else(|| {
            list.push(value);
            list.len() - 1
        });
    index as u8
}
