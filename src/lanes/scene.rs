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
    /// Opposite to each vertex, and whether they run in the other direction.
    edges: [(u8, bool); 3],
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
        for triangle in self.triangles.candidates(active, false, seen) {
            nearest.or(triangle.id, &seen.hit(&shear, &triangle.shape));
        }
        for sphere in &self.spheres {
            nearest.or(sphere.id, &TriangleHit { t: sphere.shape.distance(ray), weights: [Lanes::splat(0.0); 3] });
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
                for triangle in triangles.candidates(asking, through_glass, seen) {
                    free = free & !(asking & seen.hit(&shear, &triangle.shape).t.below(one));
                }
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
    /// `project` 7 and `distance` 1 per vertex, [`edge`] 3 per edge, `hit_within` 14 per triangle that passes the masks;
    /// one is for the limit.
    pub fn operations(&self, ray: &Ray<Lanes3>, seen: &mut Seen) -> u32 {
        let Triangles { vertices, edges, .. } = &self.triangles;
        self.triangles.see(ray, Lanes::splat(f64::INFINITY), seen);
        let tested = self.triangles.candidates(LaneMask::splat(true), false, seen).count();
        (3 + 1 + 8 * vertices.len() + 3 * edges.len() + 14 * tested) as u32
    }
}

impl Triangles {
    fn add(&mut self, corners: [DVec3; 3], id: u32, is_glass: bool) {
        let [a, b, c] = corners.map(|corner| place_of(&mut self.vertices, corner));
        let mut edge = |from: u8, to: u8| (place_of(&mut self.edges, [from.min(to), from.max(to)]), from > to);
        let shape = Triangle { vertices: [a, b, c], edges: [edge(c, b), edge(a, c), edge(b, a)] };
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

    /// The triangles that a ray in an `active` lane may meet: its line passes through, and the vertices are neither
    /// all behind it nor all too far.
    #[inline]
    fn candidates(
        &self,
        active: LaneMask,
        through_glass: bool,
        seen: &Seen,
    ) -> impl Iterator<Item = &Target<Triangle>> {
        let active = active.bits() as u8;
        let triangles = self.targets.iter().enumerate();
        let mut set = triangles.fold(0_u64, |set, (place, triangle)| {
            let counts = active & !seen.misses(&triangle.shape) != 0 && !(through_glass & triangle.is_glass);
            set | u64::from(counts) << place
        });
        std::iter::from_fn(move || {
            let next = self.targets.get(set.trailing_zeros() as usize)?;
            set &= set - 1;
            Some(next)
        })
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
        Self { vertices, edges, outside: [0; PLACES], sides: [0; PLACES], stack: PacketStack::default() }
    }

    /// The lanes that surely miss a triangle.
    #[inline]
    fn misses(&self, triangle: &Triangle) -> u8 {
        let side = |(edge, reversed): (u8, bool)| self.sides[usize::from(edge)].rotate_left(8 * u32::from(reversed));
        let [a, b, c] = triangle.edges.map(side);
        let [x, y, z] = triangle.vertices.map(|vertex| self.outside[usize::from(vertex)]);
        let (sides, outside) = (a | b | c, x & y & z);
        ((sides & sides >> 8) | outside | outside >> 8) as u8
    }

    #[inline(always)]
    fn hit(&self, shear: &Shear<Lanes3>, triangle: &Triangle) -> TriangleHit<Lanes> {
        let edge = |(place, reversed): (u8, bool)| {
            let edge = self.edges[usize::from(place)];
            if reversed { -edge } else { edge }
        };
        let depth = |vertex: u8| self.vertices[usize::from(vertex)][2];
        shear.hit_within(triangle.edges.map(edge), triangle.vertices.map(depth))
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
