//! What several rays meet: every lane tests every primitive of a small scene, and one ray after the other goes
//! through the hierarchy of a large one.

use std::array::from_fn;

use glam::DVec3;

use crate::accel::PrimitiveHit;
use crate::bsdf::Bsdf;
use crate::real::{LANES, LaneMask, Lanes, Lanes3, Mask, Real, Vector};
use crate::scene::{Geometry, Hit, Scene};
use crate::shape::{Ray, Sphere};
use crate::watertight::{Projected, Shear, TriangleHit, edge};

/// The most primitives that all lanes test.
const SMALL: usize = 64;

/// A vector of one lane.
#[inline]
pub(super) fn lane3(vector: Lanes3, lane: usize) -> DVec3 {
    DVec3::from_array(vector.components().map(|component| component.as_array()[lane]))
}

/// Vectors of all lanes, from each of them.
#[inline]
pub(super) fn gather3(of: impl Fn(usize) -> DVec3) -> Lanes3 {
    let all: [DVec3; LANES] = from_fn(of);
    Lanes3::of([all.map(|v| v.x), all.map(|v| v.y), all.map(|v| v.z)].map(Lanes::new))
}

/// The rays of one lane.
#[inline]
pub(super) fn lane_ray(ray: &Ray<Lanes3>, lane: usize) -> Ray {
    Ray::new(lane3(ray.origin, lane), lane3(ray.direction, lane))
}

enum Part {
    /// By its vertices among those of the scene, and by its edges: opposite to each vertex, in either direction.
    Triangle {
        vertices: [usize; 3],
        edges: [(usize, bool); 3],
    },
    Sphere(Sphere),
}

/// A scene as lanes see it.
pub(super) struct LaneScene<'a> {
    pub scene: &'a Scene,
    vertices: Vec<[Lanes; 4]>,
    /// The vertices of each edge, which the triangles on both sides of it share.
    edges: Vec<[usize; 2]>,
    /// In the order of the scene's primitives, with whether shadow rays may pass; empty in a large scene.
    parts: Vec<(Part, bool)>,
}

/// Vertices and edges as rays see them; one buffer serves all rays.
#[derive(Default)]
pub(super) struct Seen {
    vertices: Vec<Projected<Lanes>>,
    edges: Vec<Lanes>,
}

impl<'a> LaneScene<'a> {
    pub fn new(scene: &'a Scene) -> Self {
        let (mut vertices, mut edges, mut parts) = (Vec::new(), Vec::new(), Vec::new());
        if scene.primitives().count() <= SMALL {
            for (geometry, surface) in scene.primitives() {
                let part = match geometry {
                    Geometry::Sphere(sphere) => Part::Sphere(sphere),
                    Geometry::Triangle(corners) => {
                        let [a, b, c] = corners.map(|corner| place_of(&mut vertices, corner));
                        let mut edge =
                            |from: usize, to: usize| (place_of(&mut edges, [from.min(to), from.max(to)]), from > to);
                        Part::Triangle { vertices: [a, b, c], edges: [edge(c, b), edge(a, c), edge(b, a)] }
                    }
                };
                parts.push((part, matches!(surface.bsdf, Bsdf::Glass { .. })));
            }
        }
        let vertices = vertices.iter().map(|v: &DVec3| [v.x, v.y, v.z, 0.0].map(Lanes::splat)).collect();
        Self { scene, vertices, edges, parts }
    }

    /// The nearest hits; `None` in lanes that are not `active` and where a ray meets nothing.
    #[inline]
    pub fn closest(&self, ray: &Ray<Lanes3>, active: LaneMask, seen: &mut Seen) -> [Option<Hit>; LANES] {
        let bits = active.bits();
        if self.parts.is_empty() {
            return from_fn(|i| if bits >> i & 1 == 1 { self.scene.intersect(&lane_ray(ray, i)) } else { None });
        }
        let shear = self.see(ray, seen);
        let mut t = Lanes::splat(f64::INFINITY);
        let mut primitive = Lanes::splat(-1.0);
        let mut weights = [Lanes::splat(0.0); 3];
        for (id, (part, _)) in self.parts.iter().enumerate() {
            match part {
                Part::Triangle { vertices, edges } => {
                    let hit = seen.hit(&shear, vertices, edges);
                    let nearer = hit.t.below(t);
                    if nearer.any() {
                        t = Lanes::choose(nearer, hit.t, t);
                        primitive = Lanes::choose(nearer, Lanes::splat(id as f64), primitive);
                        weights = from_fn(|i| Lanes::choose(nearer, hit.weights[i], weights[i]));
                    }
                }
                Part::Sphere(sphere) => {
                    let distance = sphere.distance(ray);
                    let nearer = distance.below(t);
                    t = Lanes::choose(nearer, distance, t);
                    primitive = Lanes::choose(nearer, Lanes::splat(id as f64), primitive);
                }
            }
        }
        let [t, primitive] = [t.to_array(), primitive.to_array()];
        let weights = weights.map(|w| w.to_array());
        from_fn(|i| {
            (bits >> i & 1 == 1 && primitive[i] >= 0.0).then(|| {
                let found = PrimitiveHit { primitive: primitive[i] as u32, t: t[i], weights: weights.map(|w| w[i]) };
                self.scene.hit(&lane_ray(ray, i), &found)
            })
        })
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
        if self.parts.is_empty() {
            let bits = active.bits();
            return LaneMask::from_fn(|i| {
                let end = |(point, normal)| (lane3(point, i), lane3(normal, i));
                bits >> i & 1 == 1 && self.scene.visible(end(x), end(y), through_glass)
            });
        }
        let segment = self.scene.segment(x, y);
        let shear = self.see(&segment, seen);
        let one = Lanes::splat(1.0);
        let mut free = active;
        for (part, is_glass) in &self.parts {
            if through_glass && *is_glass {
                continue;
            }
            let t = match part {
                Part::Triangle { vertices, edges } => seen.hit(&shear, vertices, edges).t,
                Part::Sphere(sphere) => sphere.distance(&segment),
            };
            free = free & !t.below(one);
            if !free.any() {
                break;
            }
        }
        free
    }

    #[inline]
    fn see(&self, ray: &Ray<Lanes3>, seen: &mut Seen) -> Shear<Lanes3> {
        let shear = Shear::new(ray);
        seen.vertices.clear();
        seen.vertices.extend(self.vertices.iter().map(|vertex| shear.project(vertex)));
        seen.edges.clear();
        seen.edges.extend(self.edges.iter().map(|&[a, b]| edge(&seen.vertices[a], &seen.vertices[b])));
        shear
    }
}

impl Seen {
    #[inline(always)]
    fn hit(&self, shear: &Shear<Lanes3>, vertices: &[usize; 3], edges: &[(usize, bool); 3]) -> TriangleHit<Lanes> {
        let edge = |(place, reversed): (usize, bool)| if reversed { -self.edges[place] } else { self.edges[place] };
        let ([u, v, w], [a, b, c]) = (*edges, *vertices);
        let depth = |vertex: usize| self.vertices[vertex][2];
        shear.hit_within([edge(u), edge(v), edge(w)], [depth(a), depth(b), depth(c)])
    }
}

/// The place of a value in a list to which it is added if it is new.
fn place_of<T: PartialEq>(list: &mut Vec<T>, value: T) -> usize {
    list.iter().position(|known| *known == value).unwrap_or_else(|| {
        list.push(value);
        list.len() - 1
    })
}
