//! Sizes of the smallest details of a scene.

use glam::DVec3;

use super::{PrimitiveShape, ScenePrimitive};
use crate::geometry::offsets::OFFSET;

/// Least radius of a sphere, height of a zone of one, and longest edge of a triangle, relative to
/// the largest coordinate: a thousand times the [`OFFSET`] from which rays start.
pub const SMALLEST_DETAIL: f64 = 1024.0 * OFFSET;

/// Returns the length of the longest edge of a triangle.
pub(super) fn longest_edge([a, b, c]: [DVec3; 3]) -> f64 {
    [b - a, c - b, a - c]
        .map(DVec3::length)
        .into_iter()
        .fold(0.0, f64::max)
}

/// Returns [`Scene::smallest_detail`](super::Scene::smallest_detail) of these primitives.
pub(super) fn smallest_detail(primitives: &[ScenePrimitive], vertices: &[DVec3]) -> f64 {
    // Union-find: each vertex names an earlier one of the same component, or itself.
    let mut parents: Vec<u32> = (0..vertices.len() as u32).collect();
    fn find_root(parents: &mut [u32], mut vertex: u32) -> u32 {
        while parents[vertex as usize] != vertex {
            parents[vertex as usize] = parents[parents[vertex as usize] as usize];
            vertex = parents[vertex as usize];
        }
        vertex
    }
    let mut smallest = f64::INFINITY;
    for primitive in primitives {
        match primitive.shape {
            PrimitiveShape::Sphere(sphere) => {
                let [low, high] = sphere.heights();
                smallest = smallest.min(sphere.radius).min(high - low);
            }
            PrimitiveShape::Triangle {
                vertices: corners, ..
            } => {
                let roots = corners.map(|corner| find_root(&mut parents, corner));
                let first = roots.into_iter().fold(u32::MAX, u32::min);
                roots
                    .into_iter()
                    .for_each(|of| parents[of as usize] = first);
            }
        }
    }
    let mut boxes = vec![[DVec3::INFINITY, DVec3::NEG_INFINITY]; vertices.len()];
    for primitive in primitives {
        if let PrimitiveShape::Triangle {
            vertices: corners, ..
        } = primitive.shape
        {
            let of = &mut boxes[find_root(&mut parents, corners[0]) as usize];
            for corner in corners.map(|corner| vertices[corner as usize]) {
                *of = [of[0].min(corner), of[1].max(corner)];
            }
        }
    }
    let second = |[low, high]: [DVec3; 2]| {
        let mut extents = (high - low).to_array();
        extents.sort_by(f64::total_cmp);
        extents[1]
    };
    boxes
        .into_iter()
        .filter(|[low, high]| low.x <= high.x)
        .map(second)
        .fold(smallest, f64::min)
}
