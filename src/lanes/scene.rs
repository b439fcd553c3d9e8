//! What several rays meet: in a small scene all lanes test the list of what any of them may meet; in a larger one they go
//! through its hierarchy, together or one after the other.

use std::array::from_fn;

use glam::DVec3;

use super::shading::Material;
use crate::accel::{Nearest, PacketHit, PacketStack, PrimitiveHit};
use crate::hull::SMALL;
use crate::real::{LANES, LaneMask, Lanes, Lanes3, Mask, Real};
use crate::scene::{Part, PartShape, Scene};
use crate::shape::{Ray, Sphere};
use crate::watertight::{Projected, Shear, TriangleHit, edge};

/// What lanes need of a primitive that they have hit.
pub(super) struct PrimitiveData {
    /// Of a triangle; the first is the centre of a sphere.
    pub corners: [DVec3; 3],
    /// Of a triangle's front.
    pub normal: DVec3,
    /// 0 of a triangle, negative of a sphere whose normal points to its centre.
    pub radius: f64,
    pub surface: u32,
    pub emitter: Option<u32>,
}

/// A primitive against which the rays of all lanes are tested.
struct Target<T> {
    /// Its place among those of the scene.
    id: u32,
    /// Whether some shadow rays pass it.
    is_glass: bool,
    shape: T,
}

/// A triangle by its vertices among those of the scene, and by its edges.
struct Triangle {
    vertices: [u8; 3],
    /// Opposite to each vertex.
    edges: [u8; 3],
    /// -1 for those that run in the other direction, else 1.
    signs: [f64; 3],
    /// By how many bits the sides of each edge are turned: 8 for those that run in the other direction.
    turns: [u8; 3],
}

/// The triangles of a small scene, or some of them.
#[derive(Default)]
struct Triangles {
    vertices: Vec<DVec3>,
    /// The vertices of each edge, which the triangles on both sides of it share.
    edges: Vec<[u8; 2]>,
    targets: Vec<Target<Triangle>>,
}

/// How it is found out what rays meet. Every way has the same answers.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Search {
    /// Rays are tested together against all primitives.
    List,
    /// They go through the hierarchy together.
    Packets,
    /// Each goes through it alone.
    SingleRays,
}

/// In a scene of more primitives rays that have parted ways may go through the hierarchy faster alone. Measured inside a
/// wavy sphere, the worst case: packets had 1.07 times the speed of single rays among 480 triangles, 0.92 among 2000.
pub(super) const MIDDLING: usize = 1500;

/// A scene as lanes see it.
pub(super) struct LaneScene<'a> {
    pub scene: &'a Scene,
    search: Search,
    // The next three are empty without a list.
    triangles: Triangles,
    /// Those that are no walls of its hull.
    within: Triangles,
    spheres: Vec<Target<Sphere>>,
    /// In the order of the scene's primitives.
    pub parts: Vec<PrimitiveData>,
    /// In the order of the scene's surfaces.
    pub materials: Vec<Material>,
}

/// Vertices and edges as rays see them; one buffer serves all rays. It has as many places as there are indices.
pub(super) struct Seen {
    vertices: [Projected<Lanes>; PLACES],
    edges: [Lanes; PLACES],
    /// Of each vertex the lanes that have it behind them, and in the upper byte those for which it is too far.
    outside: [u16; PLACES],
    /// Of each edge the lanes that pass on its negative side, and in the upper byte those on its positive side.
    sides: [u16; PLACES],
    /// Triangles by their places, and the lanes that may meet them; one more than there can be.
    candidates: [(u8, u8); SMALL + 1],
    /// Of [`Search::Packets`].
    stack: PacketStack,
}

/// How many vertices or edges 8 bits can tell apart; [`SMALL`] triangles have fewer.
const PLACES: usize = 256;

impl<'a> LaneScene<'a> {
    pub fn new(scene: &'a Scene) -> Self {
        let (mut triangles, mut within, mut spheres) = (Triangles::default(), Triangles::default(), Vec::new());
        let search = match scene.parts().len() {
            count if count <= SMALL => Search::List,
            count if count <= MIDDLING => Search::Packets,
            _ => Search::SingleRays,
        };
        for (id, part) in scene.parts().iter().enumerate().take_while(|_| search == Search::List) {
            let is_glass = scene.is_glass(id as u32);
            let is_wall = scene.hull().is_some_and(|hull| hull.is_wall[id]);
            let id = id as u32;
            match part.shape {
                PartShape::Sphere(shape) => spheres.push(Target { id, is_glass, shape }),
                PartShape::Triangle { vertices, .. } => {
                    triangles.add(scene.corners(vertices), id, is_glass);
                    if !is_wall {
                        within.add(scene.corners(vertices), id, is_glass);
                    }
                }
            }
        }
        let parts = scene.parts().iter().map(|part| PrimitiveData::new(scene, part)).collect();
        let materials = scene.surfaces().iter().map(Material::new).collect();
        Self { scene, search, triangles, within, spheres, parts, materials }
    }

    /// The nearest hits of the `active` lanes.
    #[inline]
    pub fn closest(&self, ray: &Ray<Lanes3>, active: LaneMask, seen: &mut Seen) -> PacketHit {
        match self.search {
            Search::List => {}
            Search::Packets => return self.scene.bvh().closest_of_packet(ray, active, &mut seen.stack),
            Search::SingleRays => return self.closest_one_by_one(ray, active),
        }
        let mut nearest = Nearest::new();
        let shear = self.triangles.see(ray, Lanes::splat(f64::INFINITY), seen);
        self.triangles.hits((&shear, seen), (active, false), |ids, hit| nearest.or(ids, hit));
        for sphere in &self.spheres {
            let hit = TriangleHit { t: sphere.shape.distance(ray), weights: [Lanes::splat(0.0); 3] };
            nearest.or(Lanes::splat(f64::from(sphere.id)), &hit);
        }
        nearest.of(active)
    }

    fn closest_one_by_one(&self, ray: &Ray<Lanes3>, active: LaneMask) -> PacketHit {
        let alone = |i: usize| Ray::new(ray.origin.lane(i), ray.direction.lane(i));
        let bits = active.bits();
        let hits: [Option<PrimitiveHit>; LANES] =
            from_fn(|i| if bits >> i & 1 == 1 { self.scene.bvh().closest(&alone(i), f64::INFINITY) } else { None });
        PacketHit {
            met: LaneMask::from_fn(|i| hits[i].is_some()),
            primitive: from_fn(|i| hits[i].map_or(0, |hit| hit.primitive)),
            t: Lanes::new(from_fn(|i| hits[i].map_or(f64::INFINITY, |hit| hit.t))),
            weights: from_fn(|k| Lanes::new(from_fn(|i| hits[i].map_or(0.0, |hit| hit.weights[k])))),
        }
    }

    /// In which of the `active` lanes two surface points with unit normals see each other, as
    /// [`Scene::visible`].
    #[inline]
    pub fn visible(
        &self,
        x: (Lanes3, Lanes3),
        y: (Lanes3, Lanes3),
        through_glass: bool,
        active: LaneMask,
        seen: &mut Seen,
    ) -> LaneMask {
        if self.search == Search::SingleRays {
            let bits = active.bits();
            return LaneMask::from_fn(|i| {
                let end = |(point, normal): (Lanes3, Lanes3)| (point.lane(i), normal.lane(i));
                bits >> i & 1 == 1 && self.scene.visible(end(x), end(y), through_glass)
            });
        }
        let segment = self.scene.segment(x, y);
        if self.search == Search::Packets {
            let blocks = |id: u32| !(through_glass && self.scene.is_glass(id));
            return active & !self.scene.bvh().occluded_of_packet(&segment, active, blocks, &mut seen.stack);
        }
        let one = Lanes::splat(1.0);
        let holds = |point| self.scene.hull().map_or(LaneMask::splat(false), |hull| hull.holds(point));
        let within = active & holds(segment.origin) & holds(segment.at(one));
        let mut free = active;
        for (triangles, asking) in [(&self.within, within), (&self.triangles, active & !within)] {
            if asking.any() {
                let shear = triangles.see(&segment, one, seen);
                triangles.hits((&shear, seen), (asking, through_glass), |_, hit| free = free & !hit.t.below(one));
            }
        }
        for sphere in self.spheres.iter().filter(|sphere| !(through_glass && sphere.is_glass)) {
            free = free & !sphere.shape.distance(&segment).below(one);
        }
        free
    }

    /// Whether all lanes test all of its primitives, and these are triangles.
    pub fn has_few_triangles(&self) -> bool {
        self.search == Search::List && self.spheres.is_empty()
    }

    /// The arithmetic of [`closest`](Self::closest) in one lane, without spheres. Of [`Shear`]: `new` takes 3 operations,
    /// `project` 7 and `distance` 1 per vertex, [`edge`] 3 per edge, and 3 more where a triangle passes the masks;
    /// `hit_within` 14 per portion of hits; one is for the limit.
    pub fn operations(&self, ray: &Ray<Lanes3>, seen: &mut Seen) -> u32 {
        let Triangles { vertices, edges, .. } = &self.triangles;
        let all = (LaneMask::splat(true), false);
        let shear = self.triangles.see(ray, Lanes::splat(f64::INFINITY), seen);
        let mut portions = 0;
        self.triangles.hits((&shear, seen), all, |_, _| portions += 1);
        let tested = self.triangles.list_candidates(all, seen);
        (3 + 1 + 8 * vertices.len() + 3 * edges.len() + 3 * tested + 14 * portions) as u32
    }
}

impl Triangles {
    fn add(&mut self, corners: [DVec3; 3], id: u32, is_glass: bool) {
        let [a, b, c] = corners.map(|corner| place_of(&mut self.vertices, corner));
        let ends = [[c, b], [a, c], [b, a]];
        let edges = ends.map(|[from, to]| place_of(&mut self.edges, [from.min(to), from.max(to)]));
        let reversed = ends.map(|[from, to]| from > to);
        let signs = reversed.map(|turned| if turned { -1.0 } else { 1.0 });
        let turns = reversed.map(|turned| 8 * u8::from(turned));
        let shape = Triangle { vertices: [a, b, c], edges, signs, turns };
        self.targets.push(Target { id, is_glass, shape });
    }

    /// Projects vertices and edges for rays that end at `limit`.
    #[inline]
    fn see(&self, ray: &Ray<Lanes3>, limit: Lanes, seen: &mut Seen) -> Shear<Lanes3> {
        let shear = Shear::new(ray);
        let zero = Lanes::splat(0.0);
        let pair = |first: LaneMask, second: LaneMask| (first.bits() | second.bits() << LANES) as u16;
        // The distance of a hit is a mean of those of the vertices, but for some roundings.
        let limit = limit * (1.0 + 1e-9);
        for ((vertex, projected), outside) in self.vertices.iter().zip(&mut seen.vertices).zip(&mut seen.outside) {
            let [x, y, z] = vertex.to_array().map(Lanes::splat);
            *projected = shear.project(&[x, y, z, zero]);
            let distance = shear.distance(projected[2]);
            *outside = pair(distance.below(zero), distance.above(limit));
        }
        for ((&[a, b], value), sides) in self.edges.iter().zip(&mut seen.edges).zip(&mut seen.sides) {
            *value = edge(&seen.vertices[usize::from(a)], &seen.vertices[usize::from(b)]);
            *sides = pair(value.below(zero), value.above(zero));
        }
        shear
    }

    /// Tells the hits of the `active` lanes, and on which primitives, in portions of at most one per lane.
    #[inline]
    fn hits(
        &self,
        (shear, seen): (&Shear<Lanes3>, &mut Seen),
        (active, through_glass): (LaneMask, bool),
        mut tell: impl FnMut(Lanes, &TriangleHit<Lanes>),
    ) {
        let zero = Lanes::splat(0.0);
        // What has no area is not hit.
        let (mut ids, mut edges, mut depths) = (zero, [zero; 3], [zero; 3]);
        let mut taken = 0;
        let count = self.list_candidates((active, through_glass), seen);
        for &(place, lanes) in &seen.candidates[..count] {
            let Target { id, shape, .. } = &self.targets[usize::from(place)];
            if taken & lanes != 0 {
                tell(ids, &shear.hit_within(edges, depths));
                (edges, taken) = ([zero; 3], 0);
            }
            taken |= lanes;
            let lanes = LaneMask::from_bits(u32::from(lanes));
            ids = Lanes::choose(lanes, Lanes::splat(f64::from(*id)), ids);
            for k in 0..3 {
                edges[k] = Lanes::choose(lanes, seen.edges[usize::from(shape.edges[k])] * shape.signs[k], edges[k]);
                depths[k] = Lanes::choose(lanes, seen.vertices[usize::from(shape.vertices[k])][2], depths[k]);
            }
        }
        if taken != 0 {
            tell(ids, &shear.hit_within(edges, depths));
        }
    }

    /// Lists the triangles that a ray in an `active` lane may meet, and returns how many they are: its line passes
    /// through, and the vertices are neither all behind it nor all too far.
    #[inline]
    fn list_candidates(&self, (active, through_glass): (LaneMask, bool), seen: &mut Seen) -> usize {
        let active = active.bits() as u8;
        let mut count = 0;
        for (place, triangle) in self.targets.iter().enumerate() {
            let asking = if through_glass & triangle.is_glass { 0 } else { active };
            let lanes = asking & !seen.misses(&triangle.shape);
            seen.candidates[count] = (place as u8, lanes);
            count += usize::from(lanes != 0);
        }
        count
    }
}

impl PrimitiveData {
    fn new(scene: &Scene, &Part { surface, emitter, shape }: &Part) -> Self {
        let (corners, normal, radius) = match shape {
            PartShape::Triangle { vertices, normal } => (scene.corners(vertices), normal, 0.0),
            PartShape::Sphere(Sphere { centre, radius, inward, .. }) => {
                ([centre; 3], DVec3::Z, if inward { -radius } else { radius })
            }
        };
        Self { corners, normal, radius, surface, emitter }
    }
}

impl Seen {
    pub fn new() -> Self {
        let zero = Lanes::splat(0.0);
        let (vertices, edges) = ([[zero; 3]; PLACES], [zero; PLACES]);
        let (outside, sides, candidates) = ([0; PLACES], [0; PLACES], [(0, 0); SMALL + 1]);
        Self { vertices, edges, outside, sides, candidates, stack: PacketStack::default() }
    }

    /// The lanes that surely miss a triangle.
    #[inline]
    fn misses(&self, triangle: &Triangle) -> u8 {
        let side = |k: usize| self.sides[usize::from(triangle.edges[k])].rotate_left(u32::from(triangle.turns[k]));
        let [a, b, c] = [side(0), side(1), side(2)];
        let [x, y, z] = triangle.vertices.map(|vertex| self.outside[usize::from(vertex)]);
        let (sides, outside) = (a | b | c, x & y & z);
        ((sides & sides >> 8) | outside | outside >> 8) as u8
    }
}

/// The place of a value in a list to which it is added if it is new.
fn place_of<T: PartialEq>(list: &mut Vec<T>, value: T) -> u8 {
    let place = list.iter().position(|known| *known == value).unwrap_or_else(|| {
        list.push(value);
        list.len() - 1
    });
    place as u8
}
