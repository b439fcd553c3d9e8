//! Tests that closed meshes do not leak: rays aimed at edges and vertices, from inside and from
//! surfaces.

use whitefurnace::geometry::shape::triangle_point;
use whitefurnace::sampling::warp;

use crate::prelude::*;

const SCALES: [f64; 3] = [1e-4, 1.0, 1e4];

/// Returns closed convex meshes around the origin, with the half width of a cube inside.
fn meshes() -> Vec<(Mesh, f64)> {
    vec![
        (Mesh::cube(), 0.99),
        (Mesh::globe(13, 17), 0.5),
        (Mesh::room_shell().map(|v| v - DVec3::X), 1.0),
    ]
}

/// Returns the ray from a hit's surface into the half space that it was hit from.
fn onward(scene: &Scene, hit: &Hit, arrived: DVec3, local: DVec3) -> Ray {
    let oriented = hit.normal * -hit.normal.dot(arrived).signum();
    scene.spawn_ray(hit.point, hit.normal, Frame::new(oriented).world(local))
}

/// Tests rays from inside closed meshes of any size, and far from the origin.
#[test]
fn rays_from_inside_meet_every_edge_and_vertex() {
    let mut rng = rng("aimed from inside");
    let far = DVec3::new(1000.0, -2000.0, 500.0);
    let places = SCALES.map(|scale| (scale, DVec3::ZERO, 20_000));
    for (scale, offset, count) in places.into_iter().chain([(1.0, far, 10_000)]) {
        for (mesh, half) in meshes() {
            let mesh = mesh.map(|v| v * scale + offset);
            let scene = scene_of(&mesh);
            for _ in 0..count {
                let origin = offset + scale * half * in_cube(&mut rng, 1.0);
                let target = border(&mut rng, &mesh);
                // As exact as the numbers allow: not normalised.
                let exact = Ray::new(origin, target - origin);
                assert!(
                    scene.bvh().closest(&exact, f64::INFINITY).is_some(),
                    "lost {exact:?}"
                );
                let ray = Ray::new(origin, (target - origin).normalize());
                assert!(scene.intersect(&ray).is_some(), "lost {ray:?}");
            }
        }
    }
}

#[test]
fn rays_from_edges_and_vertices_stay_inside() {
    let mut rng = rng("from borders");
    for scale in SCALES {
        for (mesh, half) in meshes() {
            let mesh = mesh.map(|v| v * scale);
            let scene = scene_of(&mesh);
            for _ in 0..20_000 {
                let eye = scale * half * in_cube(&mut rng, 1.0);
                let aim = (border(&mut rng, &mesh) - eye).normalize();
                let hit = scene.intersect(&Ray::new(eye, aim)).expect("inside");
                let ray = onward(&scene, &hit, aim, uniform_hemisphere(uniform2(&mut rng)));
                assert!(scene.intersect(&ray).is_some(), "lost {ray:?} from {hit:?}");
                // The ray continues to another edge or vertex, if it is on this side.
                let to = (border(&mut rng, &mesh) - hit.point).normalize_or_zero();
                if hit.normal.dot(to) * hit.normal.dot(aim) < 0.0 {
                    let ray = scene.spawn_ray(hit.point, hit.normal, to);
                    assert!(scene.intersect(&ray).is_some(), "lost {ray:?} from {hit:?}");
                }
            }
        }
    }
}

#[test]
fn rays_from_surfaces_do_not_hit_their_own_triangle() {
    let mut rng = rng("own triangle");
    for scale in SCALES {
        let mesh = Mesh::cube().map(|v| v * scale);
        let scene = scene_of(&mesh);
        for i in 0..20_000 {
            let triangle = mesh.corners(mesh.triangles[i % mesh.triangles.len()]);
            let [u, v] = warp::triangle(uniform2(&mut rng));
            let target = triangle_point(triangle, u, v);
            let hit = scene
                .intersect(&Ray::new(DVec3::ZERO, target.normalize()))
                .expect("inside");
            let ray = onward(&scene, &hit, target, uniform_hemisphere(uniform2(&mut rng)));
            let next = scene.intersect(&ray).expect("inside");
            // Faces of a cube are flat: a ray that leaves one meets another.
            assert_ne!(next.normal, hit.normal, "{ray:?} from {hit:?}");
        }
    }
}

/// Follows a walk that sometimes starts anew, so that no trap hides other leaks.
fn assert_closed(scene: &Scene, start: DVec3, bounces: u32, rng: &mut impl Rng) {
    let mut ray = Ray::new(start, DVec3::X);
    for bounce in 0..bounces {
        if bounce % 50 == 0 {
            ray = Ray::new(start, unit_vector(rng));
        }
        let hit = scene
            .intersect(&ray)
            .unwrap_or_else(|| panic!("{}: lost {ray:?}", scene.name()));
        ray = onward(
            scene,
            &hit,
            ray.direction,
            uniform_hemisphere(uniform2(rng)),
        );
    }
}

#[test]
fn no_ray_leaves_the_closed_scenes() {
    for scene in [
        room::diffuse(),
        simple::furnace_box(0.75),
        simple::cavity_cap(0.75, Cap::Black),
    ] {
        let scene = scene.expect("a valid scene");
        assert_closed(&scene, scene.camera().eye, 200_000, &mut rng(scene.name()));
    }
}
