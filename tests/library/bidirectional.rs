//! Tests of bidirectional paths: their densities, their MIS weights on real paths, and the
//! importance of the camera against its definition.

mod one_path; // every strategy on one path that walks are made to follow

use std::sync::Mutex;

use whitefurnace::integrator::{Density, weight};

use crate::prelude::*;

const FRAME: [u32; 2] = [12, 9];

/// Records every path whose weight is asked for, with its number of light vertices.
#[derive(Default)]
struct Recorder(Mutex<Vec<(Vec<Density>, usize)>>);

default_parts!(Recorder: Scattering, Roulette, NextEvent, Photons, FiniteElements);

impl Bidirectional for Recorder {
    fn strategy_weight(&self, path: &[Density], s: usize) -> f64 {
        let mut paths = self.0.lock().expect("no thread has panicked");
        paths.push((path.to_vec(), s));
        weight(path, s)
    }
}

/// Returns the paths of a few passes.
fn paths(scene: &Scene) -> Vec<(Vec<Density>, usize)> {
    let parts = Recorder::default();
    let bdpt = Bdpt::new(Parts::replaced(&parts));
    for index in 0..8 {
        bdpt.pass(scene, FRAME, master(), index)
            .expect("legal values");
    }
    parts.0.into_inner().expect("no thread has panicked")
}

/// In a sphere of radius 1 that emits and reflects by Lambert's law, every vertex is uniformly
/// distributed whatever the one before it: all densities except that of the camera's first hit are
/// 1/4π.
#[test]
fn densities_in_a_sphere_are_uniform() {
    let scene = within_sphere(diffuse(0.6).emitting(DVec3::ONE));
    let camera = Camera::new(DVec3::new(0.3, -0.5, 0.1), DVec3::ZERO, DVec3::Z, 0.7);
    let found = paths(&scene.with_camera(camera).expect("a scene"));
    for length in 1..=4 {
        for s in 0..=length {
            let is_by = |(path, by): &&(Vec<Density>, usize)| path.len() == length && *by == s;
            assert!(found.iter().any(|path| is_by(&path)), "{s} of {length}");
        }
    }
    let uniform = 0.25 / PI;
    for (path, _) in &found {
        // Vertices closer than 1e-6 would round their cosines more than this.
        for vertex in path {
            assert_abs_diff_eq!(vertex.light, uniform, epsilon = 1e-6);
        }
        for vertex in &path[..path.len() - 1] {
            assert_abs_diff_eq!(vertex.eye, uniform, epsilon = 1e-6);
        }
    }
}

/// Records paths, which go straight on through every surface.
#[derive(Default)]
struct StraightThrough(Recorder);

default_parts!(StraightThrough: Roulette, NextEvent, Photons, FiniteElements);

impl Bidirectional for StraightThrough {
    fn strategy_weight(&self, path: &[Density], s: usize) -> f64 {
        self.0.strategy_weight(path, s)
    }
}

impl Scattering for StraightThrough {
    fn fresnel(&self, _: f64, _: f64, _: f64) -> f64 {
        0.0
    }
    fn cosine_hemisphere(&self, _: [f64; 2]) -> DVec3 {
        DVec3::Z
    }
}

/// From a lamp in glass straight up to paper in air, the densities at the glass, which stand for
/// Dirac distributions, have the ratio of n² on its two sides, whichever end a path starts from.
#[test]
fn densities_at_glass_have_the_ratio_of_squared_indices() {
    let camera = Camera::new(1.5 * DVec3::Z, 2.0 * DVec3::Z, DVec3::X, 0.5);
    let scene = scene_from(camera, |scene| {
        square(scene, 2.0, 0.0, true, lamp(1.0));
        square(scene, 9.0, 1.0, true, glass(1.5));
        square(scene, 9.0, 2.0, false, diffuse(0.9));
    });
    let parts = StraightThrough::default();
    let bdpt = Bdpt::new(Parts::replaced(&parts));
    // The camera sees the end of about one light path in a hundred.
    for index in 0..200 {
        bdpt.pass(&scene, FRAME, master(), index)
            .expect("legal values");
    }
    let found = parts.0.0.into_inner().expect("no thread has panicked");
    for by in [0, 3] {
        let is_by = |(path, s): &&(Vec<Density>, usize)| path.len() == 3 && *s == by;
        let mut count = 0;
        for (path, _) in found.iter().filter(is_by) {
            assert_relative_eq!(path[2].light / path[0].eye, 1.0 / 2.25, max_relative = 1e-9);
            // At a distance of 1 the cosine's density 1/π is that of the area.
            assert_relative_eq!(path[1].light, FRAC_1_PI, max_relative = 1e-9);
            assert_relative_eq!(path[1].eye, FRAC_1_PI, max_relative = 1e-9);
            assert_relative_eq!(path[0].light, 1.0 / 16.0, max_relative = 1e-9);
            assert_eq!(
                [
                    path[0].connectible,
                    path[1].connectible,
                    path[2].connectible
                ],
                [0.0, 0.0, 1.0]
            );
            count += 1;
        }
        assert!(count > 0, "none by {by}");
    }
}

/// On paths of the report's room, with mirror and glass, no strategy connects at specular vertices,
/// and the weights of all strategies sum to one.
#[test]
fn weights_sum_to_one_on_real_paths() {
    let found = paths(&report_room());
    let exists = |path: &[Density], s: usize| s == 0 || path[s - 1].connectible > 0.0;
    let mut specular = 0;
    for (path, s) in &found {
        assert!(exists(path, *s), "{s} of {path:?}");
        let all = (0..=path.len()).filter(|&s| exists(path, s));
        let weights: Vec<f64> = all.map(|s| weight(path, s)).collect();
        assert!(
            weights.iter().all(|w| (0.0..=1.0).contains(w)),
            "{weights:?}"
        );
        let sum: f64 = weights.iter().sum();
        // Each ratio of a path of up to fifty vertices rounds twice.
        assert_abs_diff_eq!(sum, 1.0, epsilon = 400.0 * UNIT_ROUNDOFF);
        specular += usize::from(path.iter().any(|vertex| vertex.connectible == 0.0));
    }
    assert!(specular > 100, "{specular} paths meet mirror or glass");
}

#[test]
fn passes_fill_whole_films_only() {
    let scene = report_room();
    let bdpt = Bdpt::new(Parts::default());
    let add = |film: &mut Film, range, goes_on: bool| {
        let numbers = SamplerKind::Independent;
        render_passes(&scene, &bdpt, numbers, 1, film, range, &|_| goes_on)
    };
    let mut film = Film::new(FRAME, None, 1).expect("a film");
    for (range, goes_on, passes) in [(0..3, true, 3), (3..9, false, 4)] {
        let done = add(&mut film, range, goes_on);
        assert!(done.is_ok_and(|done| done == goes_on));
        assert!(
            film.pixels()
                .iter()
                .all(|pixel| pixel.replications() == passes)
        );
    }
    let window = Window {
        corner: [1, 1],
        size: [4, 4],
    };
    let mut part = Film::new(FRAME, Some(window), 1).expect("a film");
    assert!(matches!(add(&mut part, 0..1, true), Err(Error::Option(_))));
}

/// A point on a camera ray is seen in the ray's pixel, and the importance is the reciprocal of the
/// solid angle of a small pixel: the area that the ray's direction sweeps as it crosses the pixel.
#[test]
fn the_camera_sees_what_its_rays_meet() {
    let size = [700, 300];
    let eye = DVec3::new(0.3, -2.0, 1.0);
    let strategy = (0.1..2.0, 0.01..699.99, 0.01..299.99, 0.1..10.0);
    property(
        "camera projection",
        500,
        &strategy,
        |(half, x, y, distance)| {
            let camera = Camera::new(eye, DVec3::new(0.5, 1.0, 0.2), DVec3::Z, half);
            let ray = camera.ray(size, x, y);
            let seen = camera
                .project(size, ray.at(distance))
                .expect("in the image");
            for (pixel, at) in seen.pixel.map(f64::from).into_iter().zip([x, y]) {
                assert!((pixel..=pixel + 1.0).contains(&at) || (at - at.round()).abs() < 1e-9);
            }
            assert!((seen.to_eye + ray.direction).length() <= 1e-12);
            assert!((seen.distance_squared.sqrt() / distance - 1.0).abs() <= 1e-12);
            assert!(
                camera.project(size, ray.at(-distance)).is_none(),
                "behind the eye"
            );
            let step = |dx: f64, dy: f64| camera.ray(size, x + dx, y + dy).direction;
            let across = step(0.5, 0.0) - step(-0.5, 0.0);
            let solid_angle = across.cross(step(0.0, 0.5) - step(0.0, -0.5)).length();
            let share = camera.importance(size, ray.direction) * solid_angle;
            // Central differences over a pixel of at most 2/150 have an error of second order.
            assert!((share - 1.0).abs() <= 1e-3, "{share}");
        },
    );
}

/// Panics when visibility through glass is asked for.
struct Opaque;

default_parts!(Opaque: Scattering, Roulette, Photons, Bidirectional, FiniteElements);

impl NextEvent for Opaque {
    fn visible(&self, scene: &Scene, x: SurfacePoint, y: SurfacePoint, glass: bool) -> bool {
        assert!(!glass, "glass bends what passes it");
        DefaultParts.visible(scene, x, y, glass)
    }
}

/// Shadow rays and connections stop at glass; paths are followed through it.
#[test]
fn nothing_is_connected_through_glass() {
    let parts = Parts::replaced(&Opaque);
    let (tracer, bdpt) = (LightTracer { parts }, Bdpt::new(parts));
    let (scene, seed) = (report_room(), master());
    assert!(tracer.pass(&scene, FRAME, seed, 0).is_ok());
    assert!(bdpt.pass(&scene, FRAME, seed, 0).is_ok());
}

/// An edge that lies in a surface has a density of 0 at both ends; the weights are still numbers.
#[test]
fn edges_within_surfaces_leave_weights_that_are_numbers() {
    // Shadow rays may or may not reach the light.
    for connectible in [1.0, 0.0] {
        let density = |light, eye| Density {
            light,
            eye,
            connectible,
        };
        let path = [
            density(1.0, 1.0),
            density(3.0, 0.0),
            density(0.0, 4.0),
            density(1.0, 0.0),
            density(0.0, 2.0),
        ];
        for s in (0..=path.len()).filter(|&s| s == 0 || connectible > 0.0) {
            let weight = DefaultParts.strategy_weight(&path, s);
            assert!((0.0..=1.0).contains(&weight), "{s}: {weight}");
        }
        // Where the camera's walk cannot go, the light's may.
        let path = [density(1.0, 1.0), density(2.0, 0.0)];
        assert_eq!(
            DefaultParts.strategy_weight(&path, 0),
            if connectible == 0.0 { 1.0 } else { 0.0 }
        );
        let path = [
            density(1.0, 1.0),
            Density {
                light: 0.0,
                eye: 2.0,
                connectible: 1.0,
            },
        ];
        assert_eq!(DefaultParts.strategy_weight(&path, 2), 0.0);
    }
}
