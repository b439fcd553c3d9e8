//! Closed opaque bodies, and which side of their faces is hidden from the camera.

use std::collections::HashMap;
use std::f64::consts::PI;

use glam::DVec3;

use super::{PrimitiveShape, ScenePrimitive, Surface};
use crate::geometry::bvh::Bvh;
use crate::material::Bsdf;

/// Primitives of a scene that are searched for coincident ones.
pub(super) struct Shapes<'a> {
    pub primitives: &'a [ScenePrimitive],
    pub surfaces: &'a [Surface],
    pub vertices: &'a [DVec3],
    pub bvh: &'a Bvh,
    pub eye: DVec3,
    /// Distance up to which surfaces coincide.
    pub tolerance: f64,
    /// Fraction of the way across their overlap over which they must be that near.
    pub close_fraction: f64,
}

/// Closed bodies of triangles.
pub(super) struct Solids {
    /// Body of each primitive, and the vector, ± its normal, to the side that the body hides from
    /// the camera.
    hidden_sides: Vec<Option<(u32, DVec3)>>,
}

/// Edge between two vertices, the lower index first, of a triangle that runs along it or, negative,
/// against it.
#[derive(Clone, Copy)]
struct Edge {
    ends: [u32; 2],
    object: u32,
    triangle: u32,
    sign: i32,
}

/// Sums over the triangles of a body.
#[derive(Default)]
struct Sums {
    /// Whether there are edges with triangles on one side only, or triangles that transmit light.
    is_open: bool,
    area: f64,
    /// Six times the volume, negative if the fronts are inside.
    volume: f64,
    /// Solid angle around the camera: ±4π if it is inside.
    angle: f64,
}

/// Union-find: the set of a number is the tree below a number that is its own link.
struct UnionFind(Vec<u32>);

impl UnionFind {
    fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    fn find(&mut self, mut i: u32) -> u32 {
        while self.0[i as usize] != i {
            self.0[i as usize] = self.0[self.0[i as usize] as usize];
            i = self.0[i as usize];
        }
        i
    }

    fn join(&mut self, i: u32, j: u32) {
        let (i, j) = (self.find(i), self.find(j));
        self.0[i as usize] = j;
    }
}

impl Solids {
    /// Finds the bodies of a scene.
    pub fn new(shapes: &Shapes) -> Self {
        let mut vertices = weld_vertices(shapes);
        let mut edges = Vec::with_capacity(3 * shapes.primitives.len());
        for (triangle, primitive) in (0..).zip(shapes.primitives) {
            if let PrimitiveShape::Triangle {
                vertices: corners, ..
            } = primitive.shape
            {
                let [a, b, c] = corners.map(|v| vertices.find(v));
                for (from, to) in [(a, b), (b, c), (c, a)] {
                    let (ends, sign) = if from < to {
                        ([from, to], 1)
                    } else {
                        ([to, from], -1)
                    };
                    edges.push(Edge {
                        ends,
                        object: primitive.object,
                        triangle,
                        sign,
                    });
                }
            }
        }
        edges.sort_unstable_by_key(|edge| (edge.ends, edge.object, edge.triangle));
        let mut bodies = UnionFind::new(shapes.primitives.len());
        let is_closed = |edges: &[Edge]| edges.iter().map(|edge| edge.sign).sum::<i32>() == 0;
        // Edges that close within an object are not matched with those of others that touch it
        // there.
        let of_object = edges.chunk_by(|a, b| (a.ends, a.object) == (b.ends, b.object));
        let (closed, left): (Vec<&[Edge]>, Vec<&[Edge]>) =
            of_object.partition(|edges| is_closed(edges));
        let left: Vec<Edge> = left.concat();
        let left = left.chunk_by(|a, b| a.ends == b.ends);
        for edges in closed.into_iter().chain(left.clone()) {
            edges
                .iter()
                .for_each(|edge| bodies.join(edge.triangle, edges[0].triangle));
        }
        let mut sums: HashMap<u32, Sums> = HashMap::new();
        for edges in left.filter(|edges| !is_closed(edges)) {
            sums.entry(bodies.find(edges[0].triangle))
                .or_default()
                .is_open = true;
        }
        for (i, primitive) in (0..).zip(shapes.primitives) {
            let Some(triangle) = shapes.triangle(i) else {
                continue;
            };
            let [a, b, c] = triangle.corners.map(|corner| corner - shapes.eye);
            let body = sums.entry(bodies.find(i)).or_default();
            body.is_open |= matches!(
                shapes.surfaces[primitive.surface as usize].bsdf,
                Bsdf::Glass { .. } | Bsdf::RoughGlass(_)
            );
            body.area += triangle.area;
            let volume = a.dot(b.cross(c));
            let [x, y, z] = [a, b, c].map(DVec3::length);
            body.volume += volume;
            // Solid angle by van Oosterom and Strackee 1983.
            body.angle +=
                2.0 * volume.atan2(x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y);
        }
        let hidden_side = |(i, primitive): (u32, &ScenePrimitive)| match primitive.shape {
            PrimitiveShape::Triangle { normal, .. } => {
                let body = bodies.find(i);
                sums.get(&body)?
                    .hidden_sign(shapes.tolerance)
                    .map(|side| (body, side * normal))
            }
            PrimitiveShape::Sphere(_) => None,
        };
        Self {
            hidden_sides: (0..).zip(shapes.primitives).map(hidden_side).collect(),
        }
    }

    /// Returns the closed opaque body to which a triangle belongs, if any, and the vector, ± its
    /// normal, to the side that the body hides from the camera.
    pub fn hidden_side(&self, primitive: u32) -> Option<(u32, DVec3)> {
        self.hidden_sides[primitive as usize]
    }
}

impl Sums {
    /// Returns 1 if the fronts of a closed body are hidden, -1 if the backs are; `None` for an open
    /// body, or one as thin as surfaces that coincide.
    fn hidden_sign(&self, tolerance: f64) -> Option<f64> {
        let is_thin = self.volume.abs() <= 6.0 * tolerance * self.area;
        let turns = (self.angle / (4.0 * PI)).round();
        let outward = self.volume.signum();
        let side = if turns == 0.0 { -outward } else { outward };
        (!self.is_open && !is_thin && (turns == 0.0 || turns == outward)).then_some(side)
    }
}

/// Joins the vertices that lie in one place.
fn weld_vertices(shapes: &Shapes) -> UnionFind {
    let cell = 4.0 * shapes.tolerance;
    let mut sets = UnionFind::new(shapes.vertices.len());
    let mut first = HashMap::new();
    for (i, vertex) in (0..).zip(shapes.vertices) {
        // The cells of a grid that a small cube around the vertex meets: one, or several where it
        // lies at their bounds.
        let ends = [-0.25, 0.25].map(|aside| (*vertex / cell + aside).floor().to_array());
        for corner in 0..8 {
            let key = [0, 1, 2].map(|axis| ends[corner >> axis & 1][axis] as i64);
            sets.join(i, *first.entry(key).or_insert(i));
        }
    }
    sets
}
