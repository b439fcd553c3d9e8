//! Tests of the walls through which rays leave a room.

use std::array::from_fn;

use whitefurnace::geometry::bvh::PacketStack;
use whitefurnace::math::real::{Mask, Vector};
use whitefurnace::math::simd::{LANES, Lanes, Lanes3, SINGLES, Singles, Wide};
use whitefurnace::scene::lanes::PacketIntersector;

use crate::prelude::*;

fn without_floor(mut mesh: Mesh) -> Mesh {
    mesh.triangles
        .retain(|&t| !t.iter().all(|&v| mesh.vertices[v as usize].z < 0.0));
    mesh
}

/// Returns rooms: with sharp corners, with floors of more triangles than the lane engine tells
/// apart, of triangles around a point, of overlapping triangles; with a window, with an open side,
/// and with a block inside; and all of them with a globe inside, of so many triangles that rays
/// traverse the hierarchy.
fn rooms() -> Vec<Mesh> {
    let regular = |n: u32| -> Vec<[f64; 2]> {
        (0..n)
            .map(|i| (TAU * f64::from(i) / f64::from(n)).sin_cos().into())
            .collect()
    };
    let narrow = [
        [-4.0, 0.0],
        [0.0, -0.7],
        [1.5, -0.48],
        [1.5, 0.48],
        [0.0, 0.7],
    ];
    let shell = Mesh::room_shell().map(|v| v - DVec3::X);
    let mut rooms = vec![
        Mesh::cube(),
        shell.clone(),
        Mesh::prism(&narrow, [-1.0, 1.0]),
    ];
    rooms.extend([5, 8, 10].map(|n| Mesh::prism(&regular(n), [-1.0, 1.0])));
    let with = |mesh: &Mesh, vertices: &[DVec3], triangles: &[[u32; 3]]| {
        let (mut mesh, first) = (mesh.clone(), mesh.vertices.len() as u32);
        mesh.vertices.extend(vertices);
        mesh.triangles
            .extend(triangles.iter().map(|triangle| triangle.map(|v| first + v)));
        mesh
    };
    let square = |half: f64, z: f64| {
        [[-half, -half], [half, -half], [half, half], [-half, half]]
            .map(|[x, y]| DVec3::new(x, y, z))
    };
    let (cube, carpet) = (Mesh::cube(), [[0, 1, 2], [0, 2, 3]]);
    let floor = |corners: [DVec3; 4], inner: &[DVec3]| [&corners, inner].concat();
    let star = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
    let frame = [
        [0, 1, 5],
        [0, 5, 4],
        [1, 2, 6],
        [1, 6, 5],
        [2, 3, 7],
        [2, 7, 6],
        [3, 0, 4],
        [3, 4, 7],
    ];
    rooms.push(with(&cube, &square(0.5, -1.0), &carpet));
    rooms.push(with(
        &without_floor(cube.clone()),
        &floor(square(1.0, -1.0), &[DVec3::new(0.3, 0.2, -1.0)]),
        &star,
    ));
    rooms.push(with(
        &without_floor(cube.clone()),
        &floor(square(1.0, -1.0), &square(0.4, -1.0)),
        &frame,
    ));
    rooms.push(without_floor(shell.clone()));
    let block = Mesh::cube().map(|v| 0.3 * v + DVec3::new(1.0, 0.5, -0.2));
    rooms.push(with(&shell, &block.vertices, &block.triangles));
    let globe = Mesh::globe(6, 8).map(|v| 0.2 * v + DVec3::new(0.1, 0.2, -0.3));
    let with_globe = |room: &Mesh| with(room, &globe.vertices, &globe.triangles);
    let larger: Vec<Mesh> = rooms.iter().map(with_globe).collect();
    rooms.extend(larger);
    rooms
}

/// Returns a ray towards the walls of a room that was scaled and moved: also to its edges and
/// vertices, along the axes, of any length, from anywhere within, from surfaces and from outside;
/// some have NaN components.
fn at_walls<R: Rng>(rng: &mut R, mesh: &Mesh, scene: &Scene, scale: f64, offset: DVec3) -> Ray {
    let mut aim = || match uniform(rng) {
        u if u < 0.4 => border(rng, mesh),
        u if u < 0.5 => offset,
        _ => offset + scale * in_cube(rng, 1.0),
    };
    let (from, to) = (aim(), aim());
    let wide = uniform(rng) < 0.05;
    let within = offset + scale * 0.9 * in_cube(rng, 1.0);
    let origin = if wide {
        offset + 3.0 * (from - offset)
    } else {
        within
    };
    let direction = match uniform(rng) {
        u if u < 0.05 => [DVec3::X, -DVec3::Y, DVec3::Z][(60.0 * u) as usize],
        u if u < 0.06 => DVec3::new(0.6, f64::NAN, 0.8),
        _ => (to - origin).normalize_or(DVec3::X),
    };
    let ray = Ray::new(origin, direction);
    let ray = match scene.intersect(&ray) {
        Some(hit) if uniform(rng) < 0.6 => {
            let onward = (from - hit.point).normalize_or(DVec3::Z);
            scene.spawn_ray(hit.point, hit.normal, onward)
        }
        _ => ray,
    };
    let length = if uniform(rng) < 0.2 {
        between(rng, -20.0, 20.0).exp()
    } else {
        1.0
    };
    Ray::new(ray.origin, ray.direction * length)
}

/// Compares the hits of lanes with those of single rays, in rooms of these sizes.
fn meet_walls_as_each<R: Wide<N>, const N: usize>(
    name: &str,
    places: &[(f64, DVec3)],
    mut alone: impl FnMut(&Scene, &[Ray; N]) -> [R::Scalar; N],
) {
    let mut rng = rng(name);
    for (mesh, (scale, offset)) in rooms()
        .iter()
        .flat_map(|mesh| places.iter().map(move |place| (mesh, *place)))
    {
        let mesh = mesh.clone().map(|v| scale * v + offset);
        let scene = scene_of(&mesh);
        let mut together = PacketIntersector::<R, N>::new(&scene);
        let is_small = mesh.triangles.len() <= 64;
        for packet in 0..if is_small { 1500 } else { 600 } {
            let mut rays: [Ray; N] = from_fn(|_| at_walls(&mut rng, &mesh, &scene, scale, offset));
            if !is_small && packet % 4 == 0 {
                // A packet of one octant goes through the hierarchy together.
                let octant = rays[0].direction.signum();
                for ray in &mut rays {
                    ray.direction = ray.direction.abs() * octant;
                }
            }
            let ray = Ray::new(
                Vector::from_fn(|i| rays[i].origin),
                Vector::from_fn(|i| rays[i].direction),
            );
            assert_eq!(
                together.closest(&ray).lanes(),
                alone(&scene, &rays),
                "{rays:?}"
            );
        }
    }
}

/// Walls found by where a ray leaves are hit as if all had been tested, with and without a mesh in
/// the room; rays with NaN components hit nothing.
#[test]
fn rays_meet_walls_as_each_meets_them() {
    let far = DVec3::new(1000.0, -2000.0, 500.0);
    let places = [1e-4, 1.0, 1e4]
        .map(|scale| (scale, DVec3::ZERO))
        .into_iter()
        .chain([(1.0, far)]);
    meet_walls_as_each::<Lanes, LANES>("walls", &places.collect::<Vec<_>>(), |scene, rays| {
        rays.map(|ray| {
            scene
                .bvh()
                .closest(&ray, f64::INFINITY)
                .map_or(f64::INFINITY, |hit| hit.t)
        })
    });
}

/// Single-precision lanes hit walls as single rays do, to the last bit.
#[test]
fn rays_meet_walls_as_each_meets_them_in_single_precision() {
    let places = [1e-4, 1.0, 1e4]
        .map(|scale| (scale, DVec3::ZERO))
        .into_iter()
        .chain([(1.0, DVec3::new(8.0, -9.0, 7.0))]);
    let mut stack = PacketStack::default();
    meet_walls_as_each::<Singles, SINGLES>(
        "walls, single",
        &places.collect::<Vec<_>>(),
        |scene, rays| {
            rays.map(|ray| {
                // In all lanes, and in one lane alone, so that no other ray opens a box for it.
                let [origin, direction] =
                    [ray.origin, ray.direction].map(|v| Lanes3::<Singles>::from_fn(|_| v));
                let (ray, first) = (Ray::new(origin, direction), Mask::from_bits(1));
                let hit = scene
                    .bvh()
                    .closest_of_packet::<Singles, SINGLES>(&ray, first, &mut stack);
                hit.t.lanes()[0]
            })
        },
    );
}
