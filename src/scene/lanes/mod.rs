//! Packet intersection: hull exit walls where the hull decides which of its triangles is hit, and
//! for the rest linear lists of primitives in small scenes, and in others traversal of the
//! hierarchy, as a packet or ray by ray.

mod data;
pub(crate) mod material;
mod rays;
mod triangles;
mod walls;

use std::array::from_fn;
use std::fmt;

use glam::DVec3;

use super::{PrimitiveShape, Scene, ScenePrimitive};
use crate::geometry::bvh::{Nearest, PacketHit, PacketStack, Part, sphere_hit};
use crate::geometry::hull::MAX_PRIMITIVES;
use crate::geometry::offsets::{EDGE_MARGIN, RayOrigin};
use crate::geometry::shape::{Ray, Sphere};
use crate::geometry::watertight::Shear;
use crate::math::real::{Mask, Real, Vector};
use crate::math::simd::{Scalar, Wide, lanes_of, map_array};
use walls::HullWalls;

pub(crate) use data::{CasterData, PrimitiveData};
pub use rays::{EightRayIntersector, PacketIntersector};

use data::RayMargins;
use triangles::{ListedPrimitive, ProjectedScene, Triangles};

/// Scene data in the precision of the lanes.
pub(crate) struct SceneData<T> {
    /// Whether rays are tested against lists of all primitives, not through the hierarchy.
    is_small: bool,
    // The next three are empty unless `is_small`.
    triangles: Triangles<T>,
    /// Triangles that are not walls of the hull.
    non_walls: Triangles<T>,
    spheres: Vec<ListedPrimitive<T, Sphere>>,
    walls: Option<HullWalls<T>>,
    /// Triangles that `walls` does not resolve: all of a small scene, the walls of others.
    unresolved: Triangles<T>,
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
    projected: Option<ProjectedScene<R, N>>,
    /// Stack of packet traversal.
    stack: Option<Box<PacketStack<N>>>,
}

impl<T: Scalar> SceneData<T> {
    pub fn new(scene: &Scene) -> Self {
        let [mut triangles, mut non_walls, mut unresolved] = from_fn(|_| Triangles::default());
        let mut spheres = Vec::new();
        let is_small = scene.scene_primitives().len() <= MAX_PRIMITIVES;
        let walls = scene.hull().and_then(|hull| HullWalls::new(scene, hull));
        for (id, primitive) in scene.scene_primitives().iter().enumerate() {
            let is_wall = scene.hull().is_some_and(|hull| hull.is_wall[id]);
            if !is_small && !is_wall {
                continue;
            }
            let is_glass = scene.is_glass(id as u32);
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
                    if is_small {
                        triangles.add(scene.corners(vertices), id, is_glass);
                        if !is_wall {
                            non_walls.add(scene.corners(vertices), id, is_glass);
                        }
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
        let mut nearest = Nearest::new();
        if N == 1 {
            let undecided = R::Mask::splat(false);
            return self.closest_in_hierarchy(ray, active, undecided, nearest, scratch);
        }
        let shear = Shear::new(ray);
        let mut decided = R::Mask::splat(false);
        if let (Some(walls), Some(hull)) = (&data.walls, scene.hull())
            && let Some(exit) = walls.exit(hull, &data.primitives, ray, &shear, active)
        {
            decided = exit.decided;
            nearest.take_nearer(exit.primitive, &exit.hit);
            let projected = scratch.projected();
            data.unresolved.project(&shear, None, projected);
            data.unresolved
                .hits(&shear, projected, decided, false, |ids, hit| {
                    nearest.take_nearer(ids, hit);
                });
        }
        if !data.is_small {
            return self.closest_in_hierarchy(ray, active, decided, nearest, scratch);
        }
        let left = active & !decided;
        if left.any() {
            let projected = scratch.projected();
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

    /// Finds the nearest hits of the `active` lanes by the hierarchy, as a packet or one by one. In
    /// the `decided` lanes, hits on walls are known.
    fn closest_in_hierarchy(
        self,
        ray: &Ray<R::Vector>,
        active: R::Mask,
        decided: R::Mask,
        mut nearest: Nearest<R>,
        scratch: &mut IntersectionScratch<R, N>,
    ) -> PacketHit<R, N> {
        let bvh = self.scene.bvh();
        let parts = [
            (Part::WithoutWalls, active & decided),
            (Part::All, active & !decided),
        ];
        if N > 1 && is_coherent::<R, N>(ray.direction, active) {
            for (part, lanes) in parts.into_iter().filter(|(_, lanes)| lanes.any()) {
                bvh.nearest_of_packet(part, ray, lanes, &mut nearest, scratch.stack());
            }
            return nearest.of(active);
        }
        let (rays, mut hits) = (rays::<R, N>(ray), nearest.hits());
        for (part, lanes) in parts {
            for lane in lanes_of(lanes.bits()) {
                hits[lane] = bvh.nearest_with::<R::Scalar>(part, &rays[lane], hits[lane]);
            }
        }
        PacketHit {
            hit_mask: active & R::Mask::from_fn(|i| hits[i].t < f64::INFINITY),
            primitive: hits.map(|hit| hit.primitive),
            t: R::from_lanes(|i| hits[i].t),
            weights: from_fn(|k| R::from_lanes(|i| hits[i].weights[k])),
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
            let free = |i: usize| scene.is_unoccluded(&segment.lane(i), through_glass);
            return R::Mask::from_fn(|i| active.lane(i) && free(i));
        }
        let blocks = |id: u32| !(through_glass && scene.is_glass(id));
        let one = R::splat(1.0);
        let within = scene.hull().map_or(R::Mask::splat(false), |hull| {
            active & hull.contains(segment.origin, segment.at(one))
        });
        if !data.is_small {
            let bvh = scene.bvh();
            let parts = [(Part::WithoutWalls, within), (Part::All, active & !within)];
            // A ray that is blocked has ended, but not its packet: alone it is faster.
            let rays = rays::<R, N>(&segment);
            let mut free = 0;
            for (part, lanes) in parts {
                for lane in lanes_of(lanes.bits()) {
                    let is_free = !bvh.occluded_by::<R::Scalar>(part, &rays[lane], 1.0, blocks);
                    free |= u32::from(is_free) << lane;
                }
            }
            return R::Mask::from_bits(free);
        }
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
                    free = free & !hit.t.cmplt(one);
                });
            }
        }
        for sphere in data
            .spheres
            .iter()
            .filter(|sphere| !(through_glass && sphere.is_glass))
        {
            free = free & !sphere.shape.distance(&segment).cmplt(one);
        }
        free
    }
}

/// Returns whether rays that ask for the nearest hit traverse a hierarchy as a packet. This is
/// usually faster if their directions agree in sign along two of three axes.
#[inline]
fn is_coherent<R: Wide<N>, const N: usize>(direction: R::Vector, active: R::Mask) -> bool {
    let (active, zero): (u32, R) = (active.bits(), R::splat(0.0));
    let is_even = |component: &R| {
        let back = component.cmplt(zero).bits() & active;
        back == 0 || back == active
    };
    direction
        .components()
        .iter()
        .filter(|component| is_even(component))
        .count()
        >= 2
}

/// Returns the ray of each lane.
#[inline]
fn rays<R: Wide<N>, const N: usize>(ray: &Ray<R::Vector>) -> [Ray; N] {
    let [origins, directions] = map_array([ray.origin, ray.direction], |v| {
        map_array(v.components(), R::lanes)
    });
    let of = |components: [[R::Scalar; N]; 3], i: usize| {
        DVec3::from_array(map_array(components, |lanes| lanes[i].into()))
    };
    from_fn(|i| Ray::new(of(origins, i), of(directions, i)))
}

impl<R: Real, const N: usize> IntersectionScratch<R, N> {
    pub fn new() -> Self {
        Self {
            projected: None,
            stack: None,
        }
    }

    fn projected(&mut self) -> &mut ProjectedScene<R, N> {
        self.projected.get_or_insert_with(ProjectedScene::new)
    }

    fn stack(&mut self) -> &mut PacketStack<N> {
        self.stack.get_or_insert_with(Box::default)
    }
}
