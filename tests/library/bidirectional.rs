//! Tests of bidirectional paths: their densities, their MIS weights on real paths, and the
//! importance of the camera against its definition.

use std::sync::Mutex;

use whitefurnace::integrator::{Connections, Density, weight};
use whitefurnace::light::emitter::EmitterPoint;
use whitefurnace::material::{BsdfSample, Model, Vertex};

use crate::prelude::*;

const FRAME: [u32; 2] = [12, 9];

/// Records every path whose weight is asked for, with its number of light vertices.
#[derive(Default)]
struct Recorder(Mutex<Vec<(Vec<Density>, usize)>>);

impl Bidirectional for Recorder {
    fn strategy_weight(&self, path: &[Density], s: usize) -> f64 {
        let mut paths = self.0.lock().expect("no thread has panicked");
        paths.push((path.to_vec(), s));
        weight(path, s)
    }
}

impl Scattering for Recorder {}
impl Roulette for Recorder {}
impl NextEvent for Recorder {}

/// Returns the paths of a few passes.
fn paths(scene: &Scene) -> Vec<(Vec<Density>, usize)> {
    let bdpt = Bdpt::new(Recorder::default());
    for index in 0..8 {
        bdpt.pass(scene, FRAME, master(), index)
            .expect("legal values");
    }
    bdpt.parts.0.into_inner().expect("no thread has panicked")
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

impl Roulette for StraightThrough {}
impl NextEvent for StraightThrough {}

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
    let bdpt = Bdpt::new(StraightThrough::default());
    // The camera sees the end of about one light path in a hundred.
    for index in 0..200 {
        bdpt.pass(&scene, FRAME, master(), index)
            .expect("legal values");
    }
    let found = bdpt.parts.0.0.into_inner().expect("no thread has panicked");
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

/// Vertices of one path, from a point of a lamp to the camera.
const PATH: [DVec3; 5] = [
    DVec3::new(0.0, 0.0, 0.0),
    DVec3::new(0.5, 0.3, 1.0),
    DVec3::new(1.4, -0.2, 0.0),
    DVec3::new(1.6, 0.4, 1.0),
    DVec3::new(2.3, 0.1, 0.4),
];

/// Makes walks follow [`PATH`] in either direction, and lets one strategy count it in full and no
/// other path.
struct FixedPath(Recorder, usize);

impl Bidirectional for FixedPath {
    fn strategy_weight(&self, path: &[Density], s: usize) -> f64 {
        self.0.strategy_weight(path, s);
        f64::from(path.len() == 4 && s == self.1)
    }
}

impl Scattering for FixedPath {
    fn cosine_hemisphere(&self, _: [f64; 2]) -> DVec3 {
        (PATH[1] - PATH[0]).normalize()
    }
    fn sample<R: Rng>(&self, bsdf: &Bsdf, at: &Vertex, _: &mut R) -> Option<BsdfSample> {
        let i = (1..4).find(|&i| at.point.distance(PATH[i]) < 1e-3)?;
        let ways = [i - 1, i + 1].map(|j| (PATH[j] - at.point).normalize());
        let direction = ways[usize::from(ways[0].dot(at.direction) < -0.99)];
        if matches!(bsdf, Bsdf::Mirror { .. }) {
            return Some(BsdfSample {
                direction,
                weight: DVec3::ONE,
                pdf: None,
                radiance_factor: 1.0,
            });
        }
        let wi = at.frame.local(direction);
        Some(BsdfSample {
            direction,
            ..self.weighted(bsdf, at.wo, wi, self.pdf(bsdf, at.wo, wi))
        })
    }
}

impl Roulette for FixedPath {
    fn survives(&self, _: f64, _: f64) -> bool {
        true
    }
    fn roulette_weight(&self, _: f64) -> f64 {
        1.0
    }
}

impl NextEvent for FixedPath {
    fn sample_emitter(&self, _: &Emitter, _: [f64; 2]) -> EmitterPoint {
        EmitterPoint {
            point: PATH[0],
            normal: DVec3::Z,
        }
    }
}

/// A model whose pdf depends on both directions.
#[derive(Debug)]
struct Skewed;

impl Model for Skewed {
    fn eval(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        DVec3::splat(0.1 + 0.3 * wo.z * wi.z)
    }
    fn sample(&self, _: DVec3, _: [f64; 2]) -> Option<DVec3> {
        None
    }
    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        0.5 + 0.3 * wo.z + 0.6 * wi.z + 0.2 * wo.dot(wi)
    }
    fn albedo(&self) -> DVec3 {
        DVec3::ONE
    }
}

/// A lamp and three surfaces where [`PATH`] turns, seen by a pixel so small that all its rays are
/// one; optionally with a screen in the middle of the path.
fn along_the_path(surfaces: [Bsdf; 4], screen: bool) -> Scene {
    scene_from(Camera::new(PATH[4], PATH[3], DVec3::Y, 1e-4), |scene| {
        let mut level = |centre: DVec3, up: bool, surface: Surface| {
            let [x, y] = [0.2 * DVec3::X, 0.2 * DVec3::Y];
            panel(
                scene,
                centre - 0.5 * (x + y),
                if up { [x, y] } else { [y, x] },
                surface,
            );
        };
        for (i, bsdf) in surfaces.into_iter().enumerate() {
            let emission = if i == 0 {
                DVec3::splat(2.0)
            } else {
                DVec3::ZERO
            };
            level(PATH[i], i % 2 == 0, Surface::new(bsdf).emitting(emission));
        }
        if screen {
            level(0.5 * (PATH[1] + PATH[2]), true, Surface::new(Bsdf::Black));
        }
    })
}

/// No strategy connects through a screen.
#[test]
fn nothing_is_connected_through_a_screen() {
    let scene = along_the_path(
        [
            Bsdf::Black,
            Bsdf::model(Skewed),
            Bsdf::model(Skewed),
            Bsdf::model(Skewed),
        ],
        true,
    );
    let bdpt = Bdpt::new(FixedPath(Recorder::default(), 2));
    assert_eq!(
        bdpt.pass(&scene, [1, 1], master(), 0)
            .expect("legal values"),
        [DVec3::ZERO]
    );
    assert!(
        bdpt.parts
            .0
            .0
            .into_inner()
            .expect("no thread has panicked")
            .iter()
            .all(|(path, _)| path.len() < 4)
    );
}

/// Every strategy that makes one path finds the densities of its vertices, and a contribution equal
/// to the path's measurement over the product of the densities that the strategy used.
#[test]
fn strategies_of_one_path_agree() {
    let lambert = || Bsdf::Lambert {
        albedo: DVec3::splat(0.6),
    };
    let mirror = || Bsdf::Mirror {
        reflectance: DVec3::ONE,
    };
    let skewed = || Bsdf::model(Skewed);
    for surfaces in [
        [Bsdf::Black, skewed(), skewed(), skewed()],
        [mirror(), lambert(), skewed(), lambert()],
        [Bsdf::Black, mirror(), skewed(), lambert()],
        [Bsdf::Black, skewed(), mirror(), skewed()],
        [Bsdf::Black, lambert(), skewed(), mirror()],
    ] {
        let scene = along_the_path(surfaces, false);
        let distance = |i: usize, j: usize| PATH[i].distance(PATH[j]);
        let cosine = |i: usize, j: usize| (PATH[j] - PATH[i]).z.abs() / distance(i, j);
        let per_area = |i: usize, j: usize| cosine(j, i) / distance(i, j).powi(2);
        let specular = |i: usize| i > 0 && matches!(surfaces[i], Bsdf::Mirror { .. });
        // Normals are ±z, so angles are the same after reflection in the surface.
        let local = |i: usize, j: usize| {
            let way = (PATH[j] - PATH[i]).normalize();
            way.with_z(way.z.abs())
        };
        // Pdf of the direction from i to j for a path that came from k.
        let pdf = |k: Option<usize>, i: usize, j: usize| match (surfaces[i], k) {
            (Bsdf::Model(model), Some(k)) => model.pdf(local(i, k), local(i, j)),
            _ if specular(i) => cosine(i, j),
            _ => cosine(i, j) * FRAC_1_PI,
        };
        let importance = 1.0 / (2e-4f64).powi(2);
        let path: Vec<Density> = (0..4)
            .map(|i: usize| Density {
                light: if i == 0 {
                    25.0
                } else {
                    pdf(i.checked_sub(2), i - 1, i) * per_area(i - 1, i)
                },
                eye: if i == 3 {
                    importance * per_area(4, 3)
                } else {
                    pdf(Some(i + 2), i + 1, i) * per_area(i + 1, i)
                },
                connectible: f64::from(!specular(i) && (i == 3 || !specular(i + 1))),
            })
            .collect();
        for s in 0..=4 {
            for connections in [Connections::All, Connections::Endpoints] {
                let bdpt = Bdpt {
                    parts: FixedPath(Recorder::default(), s),
                    connections,
                };
                let image = bdpt
                    .pass(&scene, [1, 1], master(), 0)
                    .expect("legal values");
                let paths = bdpt.parts.0.0.into_inner().expect("no thread has panicked");
                let found: Vec<_> = paths
                    .iter()
                    .filter(|(path, by)| path.len() == 4 && *by == s)
                    .collect();
                let all = connections == Connections::All;
                let exists = (all || s < 2 || s == 4) && (s == 0 || path[s - 1].connectible > 0.0);
                assert_eq!(
                    found.len(),
                    usize::from(exists),
                    "{s} of {surfaces:?}, {connections:?}"
                );
                let Some((found, _)) = found.first() else {
                    assert_eq!(image[0], DVec3::ZERO);
                    continue;
                };
                for (i, (found, known)) in found.iter().zip(&path).enumerate() {
                    assert_relative_eq!(found.light, known.light, max_relative = 1e-3);
                    assert_relative_eq!(found.eye, known.eye, max_relative = 1e-3);
                    // On one flat light, shadow rays pick points with the density of particles.
                    let connectible = if all || i == 0 || i == 3 {
                        known.connectible
                    } else {
                        0.0
                    };
                    assert_abs_diff_eq!(found.connectible, connectible, epsilon = 1e-12);
                }
                let f = |i: usize| match surfaces[i] {
                    Bsdf::Model(model) => {
                        model
                            .eval(cosine(i, i - 1) * DVec3::Z, cosine(i, i + 1) * DVec3::Z)
                            .x
                    }
                    _ => 0.6 * FRAC_1_PI,
                };
                if (1..4).any(specular) {
                    continue;
                }
                let geometry =
                    (0..4).map(|i| cosine(i, i + 1) * if i < 3 { per_area(i, i + 1) } else { 1.0 });
                let last = importance / distance(3, 4).powi(2);
                let measured = 2.0 * f(1) * f(2) * f(3) * geometry.product::<f64>() * last;
                let pdf: f64 = path
                    .iter()
                    .enumerate()
                    .map(|(i, v)| if i < s { v.light } else { v.eye })
                    .product();
                assert_relative_eq!(image[0].x, measured / pdf, max_relative = 1e-3);
            }
        }
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
    let bdpt = Bdpt::new(DefaultParts);
    let mut film = Film::new(FRAME, None, 1).expect("a film");
    assert!(matches!(
        render_passes(
            &scene,
            &bdpt,
            SamplerKind::Independent,
            1,
            &mut film,
            0..3,
            &|_| true
        ),
        Ok(true)
    ));
    assert!(film.pixels().iter().all(|pixel| pixel.replications() == 3));
    assert!(matches!(
        render_passes(
            &scene,
            &bdpt,
            SamplerKind::Independent,
            1,
            &mut film,
            3..9,
            &|_| false
        ),
        Ok(false)
    ));
    assert!(film.pixels().iter().all(|pixel| pixel.replications() == 4));
    let mut part = Film::new(
        FRAME,
        Some(Window {
            corner: [1, 1],
            size: [4, 4],
        }),
        1,
    )
    .expect("a film");
    assert!(matches!(
        render_passes(
            &scene,
            &bdpt,
            SamplerKind::Independent,
            1,
            &mut part,
            0..1,
            &|_| true
        ),
        Err(Error::Option(_))
    ));
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

impl NextEvent for Opaque {
    fn visible(&self, scene: &Scene, x: SurfacePoint, y: SurfacePoint, glass: bool) -> bool {
        assert!(!glass, "glass bends what passes it");
        DefaultParts.visible(scene, x, y, glass)
    }
}

impl Scattering for Opaque {}
impl Roulette for Opaque {}
impl Bidirectional for Opaque {}

/// Shadow rays and connections stop at glass; paths are followed through it.
#[test]
fn nothing_is_connected_through_glass() {
    let (tracer, bdpt) = (LightTracer { parts: Opaque }, Bdpt::new(Opaque));
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
