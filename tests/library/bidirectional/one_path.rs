//! Tests of the strategies of bidirectional path tracing on one path that walks are made to follow.

use whitefurnace::integrator::{Connections, Density};
use whitefurnace::light::emitter::EmitterPoint;
use whitefurnace::material::{BsdfSample, Model, Vertex};

use super::Recorder;
use crate::prelude::*;

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

default_parts!(FixedPath: Photons, FiniteElements);

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
    fn sample(&self, bsdf: &Bsdf, at: &Vertex, _: &mut dyn Rng) -> Option<BsdfSample> {
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
    let parts = FixedPath(Recorder::default(), 2);
    let bdpt = Bdpt::new(Parts::replaced(&parts));
    assert_eq!(
        bdpt.pass(&scene, [1, 1], master(), 0)
            .expect("legal values"),
        [DVec3::ZERO]
    );
    assert!(
        parts
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
                let parts = FixedPath(Recorder::default(), s);
                let bdpt = Bdpt {
                    parts: Parts::replaced(&parts),
                    connections,
                };
                let image = bdpt
                    .pass(&scene, [1, 1], master(), 0)
                    .expect("legal values");
                let paths = parts.0.0.into_inner().expect("no thread has panicked");
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
