//! Tests of the silhouettes of lights: the pixels that they cross, the sample points there, and
//! images.

use std::collections::BTreeSet;

use whitefurnace::render::silhouette::{
    MAX_MIRRORS, POINTS_PER_SAMPLE, PrimaryRay, mirrored_silhouette_pixels, points,
    silhouette_pixels, with_supersampled_emission,
};

use crate::prelude::*;

/// Emitters seen from the origin along y by pixels of side 1/16 at distance 1.
fn lights(shapes: &[EmitterShape]) -> Scene {
    let mut s = SceneBuilder::new("lights");
    let light = s.surface(Surface::new(Bsdf::Black).emitting(DVec3::new(1.0, 2.0, 4.0)));
    for shape in shapes {
        match *shape {
            EmitterShape::Triangle(corners) => s.mesh(&corners, &[[0, 1, 2]], light),
            EmitterShape::Rectangle { corner, edges } => s.rectangle(corner, edges, light),
            EmitterShape::Sphere(sphere) => s.sphere(sphere, light),
        }
    }
    from_origin(s)
}

/// Builds the scene, seen from the origin.
fn from_origin(scene: SceneBuilder) -> Scene {
    let camera = Camera::new(DVec3::ZERO, DVec3::Y, DVec3::Z, 0.25);
    scene.build(camera).expect("a legal scene")
}

/// Corners of a light at distance 1.
const TRIANGLE: [DVec3; 3] = [
    DVec3::new(-0.2, 1.0, -0.1),
    DVec3::new(0.25, 1.0, -0.15),
    DVec3::new(0.1, 1.0, 0.2),
];

const FRAME: [u32; 2] = [12, 8];

/// Compares with the centres of many small squares: a pixel that shows emitters through some but
/// not all of them is crossed. Marked pixels touch or neighbour such a pixel.
fn assert_marked(name: &str, scene: &Scene) {
    let marked = silhouette_pixels(scene, FRAME);
    let fine = 64;
    let share = |x: u32, y: u32| {
        let sees = |i: u32| {
            let at = |pixel: u32, i: u32| f64::from(pixel) + (f64::from(i) + 0.5) / f64::from(fine);
            let ray = scene.camera().ray(FRAME, at(x, i % fine), at(y, i / fine));
            scene
                .intersect(&ray)
                .is_some_and(|hit| hit.emitter.is_some())
        };
        (0..fine * fine).filter(|&i| sees(i)).count() as f64 / f64::from(fine * fine)
    };
    let shares: Vec<f64> = (0..FRAME[1])
        .flat_map(|y| (0..FRAME[0]).map(move |x| share(x, y)))
        .collect();
    let at = |x: i64, y: i64| {
        let inside = (0..12).contains(&x) && (0..8).contains(&y);
        inside.then(|| shares[(y * 12 + x) as usize])
    };
    for y in 0..8 {
        for x in 0..12 {
            let near = (-1..=1).flat_map(|dy| (-1..=1).filter_map(move |dx| at(x + dx, y + dy)));
            let near: Vec<f64> = near.collect();
            let [low, high] = [
                near.iter().copied().fold(1.0, f64::min),
                near.iter().copied().fold(0.0, f64::max),
            ];
            let (share, marked) = (shares[(y * 12 + x) as usize], marked[(y * 12 + x) as usize]);
            assert!(
                marked || share == 0.0 || share == 1.0,
                "{name}: ({x}, {y}) shows {share} and is not marked"
            );
            assert!(
                !marked || low < high,
                "{name}: ({x}, {y}) is marked, and all around it is alike"
            );
        }
    }
    assert!(marked.contains(&true) && marked.contains(&false), "{name}");
}

#[test]
fn pixels_that_silhouettes_cross_are_marked() {
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let rectangle = |corner, a, b| EmitterShape::Rectangle {
        corner,
        edges: [a, b],
    };
    for (name, shape) in [
        ("triangle", EmitterShape::Triangle(TRIANGLE)),
        (
            "rectangle",
            rectangle(at(-0.3, 1.5, -0.2), at(0.35, 0.2, 0.1), at(0.0, 0.3, 0.3)),
        ),
        (
            "beyond the border",
            rectangle(at(-3.0, 2.0, -0.1), at(2.7, 0.0, 0.1), at(0.1, 0.0, 3.0)),
        ),
        (
            "floor through the eye's plane",
            rectangle(at(-0.2, -1.0, -0.1), at(0.5, 0.0, 0.0), at(0.1, 4.0, 0.0)),
        ),
        (
            "sphere",
            EmitterShape::Sphere(Sphere::new(at(0.2, 2.0, 0.1), 0.25)),
        ),
    ] {
        assert_marked(name, &lights(&[shape]));
    }
    let around = [EmitterShape::Sphere(inward(Sphere::new(DVec3::ZERO, 3.0)))];
    assert!(!silhouette_pixels(&lights(&around), FRAME).contains(&true));
    let behind = [rectangle(
        at(-1.0, -2.0, -1.0),
        at(2.0, 0.0, 0.0),
        at(0.0, 0.0, 2.0),
    )];
    assert!(!silhouette_pixels(&lights(&behind), FRAME).contains(&true));
}

/// A light at distance 1, seen from the origin in a mirror at distance 1/4 with this reflectance.
fn light_in_mirror(corners: [DVec3; 3], reflectance: DVec3) -> Scene {
    let mut s = SceneBuilder::new("mirror");
    let light = s.surface(Surface::new(Bsdf::Black).emitting(DVec3::new(1.0, 2.0, 4.0)));
    let mirror = s.surface(Surface::new(Bsdf::Mirror { reflectance }));
    let [a, b, c] = corners.map(|corner| DVec3::new(corner.x, 0.5 - corner.y, corner.z));
    s.mesh(&[a, c, b], &[[0, 1, 2]], light);
    s.rectangle(
        DVec3::new(-1.0, 0.25, -1.0),
        [2.0 * DVec3::X, 2.0 * DVec3::Z],
        mirror,
    );
    from_origin(s)
}

/// In a mirror a light looks as it would at its mirror image, times the reflectance.
#[test]
fn lights_in_mirrors_have_silhouettes_and_no_noise() {
    let reflectance = DVec3::new(0.25, 0.5, 1.0);
    let (scene, twin) = (
        light_in_mirror(TRIANGLE, reflectance),
        lights(&[EmitterShape::Triangle(TRIANGLE)]),
    );
    let frame = FRAME.map(|n| 4 * n);
    let emitted = |x: f64, y: f64| {
        let ray = twin.camera().ray(frame, x, y);
        reflectance
            * twin
                .intersect(&ray)
                .map_or(DVec3::ZERO, |hit| twin.emitted(&hit, ray.direction))
    };
    let marked = mirrored_silhouette_pixels(&scene, frame);
    let sampling = Sampling {
        silhouettes: true,
        ..sampling(Random, SamplerKind::Independent, master())
    };
    let path = Path::new(PathStrategy::Mis);
    let film = rendered(&scene, &path, frame, sampling, &[0..16]).expect("legal values");
    for (here, (&marked, pixel)) in marked.iter().zip(film.pixels()).enumerate() {
        let [x, y] = [here as u32 % frame[0], here as u32 / frame[0]].map(f64::from);
        let corners =
            [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(|[u, v]| emitted(x + u, y + v));
        assert_eq!(
            marked,
            corners.iter().any(|corner| *corner != corners[0]),
            "({x}, {y})"
        );
        let mean_of = |replication: u32| {
            if marked {
                points(master(), here as u32, replication, 0)
                    .map(|[u, v]| emitted(x + u, y + v) / 8.0)
                    .into_iter()
                    .sum()
            } else {
                let [u, v] = uniform2(&mut stream(master(), here as u32, replication));
                emitted(x + u, y + v)
            }
        };
        let expected = (0..16).map(mean_of).sum::<DVec3>() / 16.0;
        assert!(
            pixel.mean().abs_diff_eq(expected, 1e-12),
            "({x}, {y}): {} is not {expected}",
            pixel.mean()
        );
    }
    assert!(
        marked.contains(&true)
            && mirrored_silhouette_pixels(&twin, frame)
                .iter()
                .all(|marked| !marked)
    );
    // An estimator with a limit on path length does not follow mirrors first.
    let report = Report {
        segments: 1,
        rules: TransportRules::PHYSICAL,
        ..Report::default()
    };
    let film = rendered(&scene, &report, frame, sampling, &[0..1]).expect("legal values");
    assert_eq!(film.mean(), 0.0);
    // Nor does one with a bounce limit.
    for (bounces, sees) in [(0, false), (1, true)] {
        let path = Path {
            bounces: Some(bounces),
            ..path
        };
        let alone = rendered(&scene, &path, frame, sampling, &[0..1]);
        let lanes = lanes(LaneEstimator::Path(path), sampling, Precision::Double);
        for film in [alone, filled(&lanes, &scene, frame, 0..1)] {
            let found = film.expect("legal values").mean() > 0.0;
            assert_eq!(found, sees, "{bounces} bounces");
        }
    }
}

#[test]
fn rays_follow_so_many_mirrors_and_none_that_emits() {
    let room = |front: Surface| {
        let mut s = SceneBuilder::new("facing mirrors");
        for (y, surface) in [(1.0, front), (-1.0, reflecting(0.5))] {
            let corner = DVec3::new(-1.0, y, -1.0);
            panel(&mut s, corner, [2.0 * DVec3::X, 2.0 * DVec3::Z], surface);
        }
        from_origin(s)
    };
    let view = |scene: &Scene| {
        let ray = Ray::new(DVec3::ZERO, DVec3::Y);
        PrimaryRay::new(ray, scene.intersect(&ray)).follow_mirrors(scene)
    };
    let endless = view(&room(reflecting(0.5)));
    assert_eq!(
        (endless.mirrors, endless.weight),
        (MAX_MIRRORS, DVec3::splat(0.5f64.powi(MAX_MIRRORS as i32)))
    );
    assert!(endless.hit.is_some());
    let emits = view(&room(reflecting(0.5).emitting(DVec3::ONE)));
    assert_eq!((emits.mirrors, emits.weight), (0, DVec3::ONE));
}

/// Returns as many points along a closed line through corners.
fn line(corners: &[DVec3]) -> Vec<DVec3> {
    let edges = corners.iter().zip(corners.iter().cycle().skip(1));
    edges
        .flat_map(|(a, b)| (0..4000).map(move |i| a.lerp(*b, f64::from(i) / 4000.0)))
        .collect()
}

/// Pixels that contain points of a silhouette are marked, and no others except near it.
#[test]
fn pixels_are_marked_along_silhouettes_alone() {
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let triangle = |corners: [DVec3; 3]| (EmitterShape::Triangle(corners), line(&corners));
    let rectangle = |corner: DVec3, a: DVec3, b: DVec3| {
        let shape = EmitterShape::Rectangle {
            corner,
            edges: [a, b],
        };
        (
            shape,
            line(&[corner, corner + a, corner + a + b, corner + b]),
        )
    };
    let sphere = |centre: DVec3, radius: f64| {
        // Points where tangents from the origin touch it.
        let distance = centre.length();
        let axis = -centre / distance;
        let across = axis.cross(DVec3::X).normalize();
        let (cosine, sine) = (
            radius / distance,
            (1.0 - (radius / distance).powi(2)).sqrt(),
        );
        let around = |turn: f64| turn.cos() * across + turn.sin() * axis.cross(across);
        let touched = |turn| centre + radius * (cosine * axis + sine * around(turn));
        let circle = (0..8000)
            .map(|i| touched(TAU * f64::from(i) / 8000.0))
            .collect();
        (EmitterShape::Sphere(Sphere::new(centre, radius)), circle)
    };
    for (shape, outline) in [
        triangle(TRIANGLE),
        triangle([
            at(0.3, 1.0, 0.21),
            at(-0.31, 0.9, 0.13),
            at(0.17, 1.2, -0.19),
        ]),
        // An edge beyond the border, whose continuation crosses pixels.
        triangle([at(-0.45, 1.0, 0.0), at(0.3, 1.0, 0.2), at(-0.9, 1.0, 0.03)]),
        rectangle(at(-0.3, 1.5, -0.2), at(0.35, 0.2, 0.1), at(0.0, 0.3, 0.3)),
        rectangle(at(-3.0, 2.0, -0.1), at(2.7, 0.0, 0.1), at(0.1, 0.0, 3.0)),
        rectangle(at(-0.2, -1.0, -0.1), at(0.5, 0.0, 0.0), at(0.1, 4.0, 0.0)),
        rectangle(at(-0.15, -2.0, 0.05), at(-0.1, 5.0, 0.1), at(0.3, 0.1, 0.1)),
        rectangle(at(-9.0, 3.0, -0.33), at(18.0, 0.2, 0.0), at(0.0, 0.0, 9.0)),
        sphere(at(0.2, 2.0, 0.1), 0.25),
        sphere(at(-0.3, 1.0, -0.2), 0.3),
        sphere(at(0.6, 4.0, -0.3), 0.9),
    ] {
        let marked = silhouette_pixels(&lights(&[shape]), FRAME);
        let (mut on, mut near) = (BTreeSet::new(), BTreeSet::new());
        for point in outline.iter().filter(|point| point.y > 0.0) {
            let [x, y] = [
                6.0 + 16.0 * point.x / point.y,
                4.0 - 16.0 * point.z / point.y,
            ];
            let pixels = [-0.02, 0.02]
                .map(|dx| [-0.02, 0.02].map(|dy| [(x + dx).floor(), (y + dy).floor()]));
            let pixels = pixels
                .concat()
                .into_iter()
                .filter(|[x, y]| (0.0..12.0).contains(x) && (0.0..8.0).contains(y));
            let pixels: Vec<_> = pixels.map(|[x, y]| y as usize * 12 + x as usize).collect();
            near.extend(&pixels);
            if pixels.len() == 4 && pixels.iter().all(|pixel| *pixel == pixels[0]) {
                on.insert(pixels[0]);
            }
        }
        let marked: BTreeSet<usize> = (0..marked.len()).filter(|&pixel| marked[pixel]).collect();
        assert!(
            on.len() > 5 && on.is_subset(&marked),
            "{shape:?}: {:?}",
            on.difference(&marked)
        );
        assert!(
            marked.is_subset(&near),
            "{shape:?}: {:?}",
            marked.difference(&near)
        );
    }
}

#[test]
fn what_points_show_replaces_what_a_sample_found() {
    let shown = std::array::from_fn(|i| DVec3::new(i as f64, 1.0, 2.0 * i as f64));
    let found =
        with_supersampled_emission(DVec3::new(5.0, 6.0, 7.0), DVec3::new(1.0, 4.0, 0.5), shown);
    assert_eq!(found, DVec3::new(4.0 + 3.5, 2.0 + 1.0, 6.5 + 7.0));
}

#[test]
fn points_are_nets_of_their_own() {
    let boxes = |points: &[[f64; 2]], across: f64, down: f64| {
        let of = |&[x, y]: &[f64; 2]| ((x * across) as u32, (y * down) as u32);
        points.iter().map(of).collect::<BTreeSet<_>>().len()
    };
    for replication in 0..20 {
        // The eight points of a sample have one in each elementary interval of area 1/8, and the 64
        // points of a replication one in each cell of 8 × 8.
        let eight = points(master(), 3, replication, 5);
        for (across, down) in [(8.0, 1.0), (4.0, 2.0), (2.0, 4.0), (1.0, 8.0)] {
            assert_eq!(boxes(&eight, across, down), POINTS_PER_SAMPLE);
        }
        let all: Vec<_> = (0..8)
            .flat_map(|index| points(master(), 3, replication, index))
            .collect();
        assert_eq!(boxes(&all, 8.0, 8.0), 64);
    }
    // The leading bits, which come from the sequence, differ between seeds, pixels and
    // replications, and where a new sequence begins.
    let leading = |seed: u64, pixel: u32, replication: u32, index: u32| {
        points(seed, pixel, replication, index).map(|point| point.map(|x| (x * 65536.0) as u32))
    };
    for seed in (0..16).map(|i| master().wrapping_add(2 * i)) {
        let first = leading(seed, 3, 0, 0);
        for (seed, pixel, replication, index) in [
            (seed ^ 1, 3, 0, 0),
            (seed, 4, 0, 0),
            (seed, 3, 1, 0),
            (seed, 3, 0, 8192),
        ] {
            assert_ne!(first, leading(seed, pixel, replication, index));
        }
    }
}

/// The film is as defined, and much nearer to the fraction of the pixel that a light covers than
/// with camera samples alone.
#[test]
fn films_take_the_points() {
    let scene = lights(&[EmitterShape::Triangle(TRIANGLE)]);
    let frame = FRAME.map(|n| 4 * n);
    let path = Path::new(PathStrategy::Mis);
    let sampling = |silhouettes| Sampling {
        silhouettes,
        ..sampling(Jitter(2), SamplerKind::Independent, master())
    };
    let film = |silhouettes| {
        rendered(&scene, &path, frame, sampling(silhouettes), &[0..16]).expect("legal values")
    };
    let (with, without) = (film(true), film(false));
    let marked = silhouette_pixels(&scene, frame);
    let emitted = |x: f64, y: f64| {
        let ray = scene.camera().ray(frame, x, y);
        scene
            .intersect(&ray)
            .map_or(DVec3::ZERO, |hit| scene.emitted(&hit, ray.direction))
    };
    let mut errors = [0.0; 2];
    for (here, &marked) in marked.iter().enumerate() {
        let [x, y] = [here as u32 % frame[0], here as u32 / frame[0]].map(f64::from);
        if !marked {
            assert_eq!(with.pixels()[here], without.pixels()[here]);
            continue;
        }
        let mut expected = DVec3::ZERO;
        for (replication, index) in
            (0..16).flat_map(|replication| (0..4).map(move |index| (replication, index)))
        {
            let shown = points(master(), here as u32, replication, index)
                .map(|[u, v]| emitted(x + u, y + v));
            expected += with_supersampled_emission(DVec3::ZERO, DVec3::ZERO, shown) / 64.0;
        }
        let found = with.pixels()[here].mean();
        assert!(
            found.abs_diff_eq(expected, 1e-8),
            "{found} is not {expected}"
        );
        let fine = (0..128).map(|i| (f64::from(i) + 0.5) / 128.0);
        let exact: DVec3 = fine
            .clone()
            .flat_map(|u| fine.clone().map(move |v| emitted(x + u, y + v)))
            .sum();
        for (error, film) in errors.iter_mut().zip([&with, &without]) {
            *error += (film.pixels()[here].mean() - exact / 16_384.0).length_squared();
        }
    }
    assert!(errors[0] < 0.3 * errors[1], "{errors:?}");
    for pixel in [Centre, Grid(2)] {
        let sampling = Sampling {
            pixel,
            ..sampling(true)
        };
        let refused = rendered(&scene, &path, frame, sampling, &[0..1]);
        assert!(matches!(refused, Err(Error::Option(_))), "{refused:?}");
    }
}
