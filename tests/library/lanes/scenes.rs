//! Scenes with every surface, light and shape, for every way of intersection in lanes.

use whitefurnace::material::ggx::Ggx;

use crate::prelude::*;

/// Builds the scene, seen along y.
fn from_the_front(scene: SceneBuilder) -> Scene {
    let camera = Camera::new(DVec3::new(0.0, -3.5, 0.0), DVec3::ZERO, DVec3::Z, 0.4);
    scene.build(camera).expect("a legal scene")
}

/// Adds a triangle.
fn triangle(s: &mut SceneBuilder, corners: [DVec3; 3], surface: SurfaceId) {
    s.mesh(&corners, &[[0, 1, 2]], surface);
}

/// Returns a room with every kind of surface and light: the report's walls, mirror and glass, a
/// rough metal, EON, a triangular light, a spherical light, and a background through a gap.
pub fn room_of_all_materials() -> Scene {
    let mut s = SceneBuilder::new("crowded");
    s.background(DVec3::new(0.1, 0.2, 0.3));
    let walls = [
        Bsdf::Lambert {
            albedo: DVec3::new(0.7, 0.5, 0.3),
        },
        Bsdf::oren_nayar(DVec3::splat(0.8), 0.5, OrenNayarForm::Corrected),
        Bsdf::oren_nayar(DVec3::splat(0.6), 0.3, OrenNayarForm::Printed),
        Bsdf::Eon {
            albedo: DVec3::new(0.9, 0.8, 0.2),
            roughness: 0.7,
        },
        Bsdf::Black,
    ];
    let [x, y, z] = DVec3::AXES.map(|axis| 2.0 * axis);
    let corners = [
        (-DVec3::ONE, [x, y]),
        (-DVec3::ONE, [y, z]),
        (DVec3::new(-1.0, 1.0, -1.0), [x, z]),
        (DVec3::new(1.0, -1.0, -1.0), [z, y]),
        (DVec3::new(-1.0, -1.0, 1.0), [0.5 * x, y]),
    ];
    for (bsdf, (corner, edges)) in walls.into_iter().zip(corners) {
        let surface = s.surface(Surface::new(bsdf));
        s.rectangle(corner, edges, surface);
    }
    let light = s.surface(Surface::new(Bsdf::Black).emitting(DVec3::new(9.0, 8.0, 7.0)));
    let corners = [[0.2, 0.0, 0.9], [0.2, 0.4, 0.9], [0.6, 0.0, 0.8]];
    triangle(&mut s, corners.map(DVec3::from), light);
    s.sphere(Sphere::new(DVec3::new(-0.6, 0.5, 0.5), 0.1), light);
    s.rectangle(DVec3::new(0.4, 0.7, 0.2), [0.1 * x, 0.1 * z], light);
    // It stands in front of a light.
    let blind = s.surface(Surface::new(walls[0]));
    let corners = [[0.2, 0.1, 0.8], [0.2, 0.4, 0.8], [0.5, 0.1, 0.7]];
    triangle(&mut s, corners.map(DVec3::from), blind);
    let metal = Bsdf::model(Ggx {
        reflectance: DVec3::new(0.9, 0.6, 0.3),
        alpha: 0.3,
    });
    for (x, surface) in [
        (-0.5, reflecting(0.9)),
        (0.1, glass(1.5)),
        (0.6, Surface::new(metal)),
    ] {
        let sphere = Sphere::new(DVec3::new(x, -0.1, -0.6), 0.28);
        ball(&mut s, sphere, surface);
    }
    from_the_front(s)
}

/// Returns a ball of so many emitting triangles that they are grouped, and a lamp.
fn mesh_light() -> Scene {
    let mut s = SceneBuilder::new("glowing");
    let glow = s.surface(lamp(0.5));
    let at = |i: u32, j: u32| {
        let [theta, phi] = [PI * f64::from(i) / 6.0, TAU * f64::from(j) / 10.0];
        0.5 * from_spherical(theta, phi)
    };
    let vertices: Vec<DVec3> = (0..=6)
        .flat_map(|i| (0..10).map(move |j| at(i, j)))
        .collect();
    let face = |i: u32, j: u32| {
        let [a, b] = [10 * i + j, 10 * i + (j + 1) % 10];
        if i == 0 {
            vec![[a, a + 10, b + 10]]
        } else {
            vec![[a, a + 10, b], [b, a + 10, b + 10]]
        }
    };
    let faces: Vec<[u32; 3]> = (0..5)
        .flat_map(|i| (0..10).flat_map(move |j| face(i, j)))
        .collect();
    s.mesh(&vertices, &faces, glow);
    square(&mut s, 1.0, -1.0, true, diffuse(0.6));
    square(&mut s, 0.3, 1.0, false, lamp(9.0));
    from_the_front(s)
}

/// Returns so many triangles that lanes use the hierarchy, and a ball of glass.
fn many(count: u32) -> Scene {
    let mut s = SceneBuilder::new("many");
    let grey = s.surface(diffuse(0.6));
    let lens = Sphere::new(DVec3::new(0.1, 0.0, 0.7), 0.35);
    ball(&mut s, lens, glass(1.5));
    let (mut rng, size) = (rng("many"), 3.0 / f64::from(count).sqrt());
    for _ in 0..count {
        let corner = in_cube(&mut rng, 1.0);
        let [a, b] = [(); 2].map(|()| corner + size * in_cube(&mut rng, 1.0));
        triangle(&mut s, [corner, a, b], grey);
    }
    let light = Sphere::new(DVec3::new(0.0, 0.0, 1.5), 0.4);
    ball(&mut s, light, lamp(4.0));
    from_the_front(s)
}

/// Returns a net of triangles with different emission, whose edges and vertices are hit by the rays
/// through the centres of pixels. A sphere, before or after them in the scene, touches it at the
/// vertex that the middle ray hits.
fn emitting_grid(sphere_first: bool) -> Scene {
    let mut s = SceneBuilder::new("net");
    let grey = s.surface(diffuse(0.5));
    let touching = Sphere::new(DVec3::new(0.0, 0.5, 0.0), 0.5);
    if sphere_first {
        s.sphere(touching, grey);
    }
    let place = |i: u32| f64::from(i) / 8.0 - 0.25;
    let vertices: Vec<DVec3> = (0..36)
        .map(|i| DVec3::new(place(i % 6), 0.0, place(i / 6)))
        .collect();
    for (cell, shine) in (0..36).filter(|cell| cell % 6 < 5 && cell / 6 < 5).zip(1..) {
        for (triangle, more) in [
            ([cell, cell + 1, cell + 7], 0.0),
            ([cell, cell + 7, cell + 6], 0.5),
        ] {
            let surface = s.surface(lamp(f64::from(shine) + more));
            s.mesh(&vertices, &[triangle], surface);
        }
    }
    if !sphere_first {
        s.sphere(touching, grey);
    }
    s.build(Camera::new(
        DVec3::new(0.0, -1.0, 0.0),
        DVec3::ZERO,
        DVec3::Z,
        8.5 / 16.0,
    ))
    .expect("a legal scene")
}

/// Returns lights that are seen in mirrors that face each other, in one that emits, and in a
/// sphere.
fn mirrors() -> Scene {
    let mut s = SceneBuilder::new("mirrors");
    s.background(DVec3::new(0.1, 0.2, 0.3));
    let light = s.surface(Surface::new(Bsdf::Black).emitting(DVec3::new(3.0, 2.0, 1.0)));
    let grey = s.surface(diffuse(0.5));
    let mirror = |r: f64| {
        Surface::new(Bsdf::Mirror {
            reflectance: DVec3::new(r, 0.9, 0.8),
        })
    };
    let [dark, bright] =
        [mirror(0.7), mirror(0.9).emitting(DVec3::splat(0.2))].map(|surface| s.surface(surface));
    let across = [4.0 * DVec3::X, 2.0 * DVec3::Z];
    s.rectangle(DVec3::new(-2.0, 1.5, -1.0), across, dark);
    s.rectangle(DVec3::new(-2.0, -1.5, -1.0), across, dark);
    s.rectangle(
        DVec3::new(-2.0, -1.5, -1.0),
        [4.0 * DVec3::X, 3.0 * DVec3::Y],
        grey,
    );
    s.rectangle(DVec3::new(1.0, -0.5, -1.0), [DVec3::Y, DVec3::Z], bright);
    s.rectangle(
        DVec3::new(-0.4, -1.0, 0.9),
        [0.8 * DVec3::Y, 0.7 * DVec3::X],
        light,
    );
    s.sphere(Sphere::new(DVec3::new(-0.6, 0.9, -0.6), 0.4), dark);
    s.build(Camera::new(
        DVec3::new(0.1, -0.2, 0.0),
        DVec3::Y,
        DVec3::Z,
        0.8,
    ))
    .expect("a legal scene")
}

/// Returns mirrors and glass balls of every kind that specular next-event estimation handles,
/// lights of two shapes, and `count` splinters among them.
pub fn specular_casters(count: u32) -> Scene {
    let mut s = SceneBuilder::new("bodies");
    let grey = s.surface(Surface::new(Bsdf::oren_nayar(
        DVec3::new(0.7, 0.5, 0.6),
        0.4,
        OrenNayarForm::Corrected,
    )));
    let [glass, dense] = [1.5, 2.2].map(|index| s.surface(glass(index)));
    let mirror = s.surface(Surface::new(Bsdf::Mirror {
        reflectance: DVec3::new(0.9, 0.8, 0.7),
    }));
    let lamp = s.surface(diffuse(0.3).emitting(DVec3::new(8.0, 9.0, 7.0)));
    simple::closed_cube(&mut s, 1.0, true, grey);
    s.sphere(Sphere::new(DVec3::new(0.3, 0.2, -0.6), 0.35), glass);
    s.sphere(Sphere::new(DVec3::new(-0.5, 0.4, 0.1), 0.2), dense);
    s.sphere(Sphere::new(DVec3::new(-0.5, -0.2, -0.7), 0.25), mirror);
    s.sphere(Sphere::new(DVec3::new(0.1, 0.1, 0.5), 0.15), lamp);
    s.rectangle(
        DVec3::new(-0.99, -0.3, -0.2),
        [0.5 * DVec3::Y, 0.5 * DVec3::Z],
        lamp,
    );
    s.rectangle(
        DVec3::new(0.6, 0.95, -0.8),
        [DVec3::new(0.3, -0.3, 0.0), 0.7 * DVec3::Z],
        mirror,
    );
    let mut rng = rng("splinters");
    for _ in 0..count {
        let corner = in_cube(&mut rng, 0.9);
        let [a, b] = [(); 2].map(|()| corner + 0.03 * in_cube(&mut rng, 1.0));
        triangle(&mut s, [corner, a, b], grey);
    }
    let camera = Camera::new(
        DVec3::new(0.0, -0.9, 0.1),
        DVec3::new(0.0, 0.2, -0.2),
        DVec3::Z,
        1.0,
    );
    s.build(camera).expect("a legal scene")
}

/// Returns a closed room with a lamp and splinters inside and smaller ones around it, seen from
/// outside, where only the sky shines.
fn from_outside() -> Scene {
    let mut s = SceneBuilder::new("closed");
    s.background(DVec3::splat(0.1));
    let (grey, lamp) = (s.surface(diffuse(0.6)), s.surface(lamp(9.0)));
    simple::closed_cube(&mut s, 0.6, true, grey);
    s.sphere(Sphere::new(DVec3::ZERO, 0.2), lamp);
    let mut rng = rng("splinters, closed");
    for (half, size) in [(0.5, 0.1), (1.0, 0.05)].into_iter().cycle().take(200) {
        let corner = in_cube(&mut rng, half);
        let edges = [(); 2].map(|()| size * unit_vector(&mut rng));
        triangle(&mut s, [corner, corner + edges[0], corner + edges[1]], grey);
    }
    from_the_front(s)
}

/// Returns scenes with every surface, light and shape, for every way of intersection in lanes.
pub fn scenes() -> Vec<Scene> {
    vec![
        room_of_all_materials(),
        many(100),
        mesh_light(),
        emitting_grid(false),
        emitting_grid(true),
        mirrors(),
        specular_casters(0),
        specular_casters(100),
        from_outside(),
        room::report(Convention::Physical, OrenNayarForm::Corrected).expect("a scene"),
        room::diffuse().expect("a scene"),
        simple::environment().expect("a scene"),
        simple::cornell().expect("a scene"),
        simple::cavity_cap(0.75, Cap::Reflecting).expect("a scene"),
        simple::glass_cube(false).expect("a scene"),
        simple::furnace_box(0.75).expect("a scene"),
    ]
}
