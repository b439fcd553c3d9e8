//! Tests that images have the same bits at any lane width, by scalar functions and by lane
//! functions.

pub mod kernels;
pub mod scenes;
mod walls;

use std::array::from_fn;

use whitefurnace::integrator::Sample;
use whitefurnace::material::Model;
use whitefurnace::math::real::Vector;
use whitefurnace::math::simd::{LANES, Lanes, Lanes3, SINGLES, Singles, Wide};
use whitefurnace::scene::lanes::{EightRayIntersector, PacketIntersector};

use scenes::{room_of_all_materials, scenes};

use crate::prelude::*;

fn assert_same_film(
    scene: &Scene,
    lanes: LaneEstimator,
    sampling: Sampling,
    window: Option<Window>,
) {
    let film =
        Film::new([23, 17], window, sampling.samples_per_replication()).expect("a legal size");
    assert_same(scene, lanes, sampling, film.clone());
    if matches!(sampling.sampler, SamplerKind::Sobol(_)) {
        let mut film = film;
        film.set_sample_counts(
            (0..film.pixels().len() as u32)
                .map(|at| 1 + at % 7)
                .collect(),
        );
        assert_same(scene, lanes, sampling, film);
    }
}

/// Asserts that both engines render the same bits into an empty film.
fn assert_same(scene: &Scene, lanes: LaneEstimator, sampling: Sampling, empty: Film) {
    let (mut alone, mut together) = (empty.clone(), empty);
    let replications = 5;
    for range in [0..1, 1..replications] {
        match lanes {
            LaneEstimator::Path(path) => {
                let path = path.with_parts(Parts::replaced(&ScalarParts));
                render(scene, &path, sampling, &mut alone, &range, &|_| true)
            }
            LaneEstimator::Report(report) => {
                let parts = Parts::replaced(&ScalarParts);
                let report = Report { parts, ..report };
                render(scene, &report, sampling, &mut alone, &range, &|_| true)
            }
            LaneEstimator::Whitted(whitted) => {
                let parts = Parts::replaced(&ScalarParts);
                let whitted = Whitted { parts, ..whitted };
                render(scene, &whitted, sampling, &mut alone, &range, &|_| true)
            }
        }
        .expect("legal values");
        render_lanes(scene, lanes, sampling, &mut together, &range, &|_| true)
            .expect("legal values");
    }
    assert!(
        alone == together,
        "{} by {lanes:?}, {sampling:?}",
        scene.name()
    );
    // A window may be black.
    assert!(
        alone.size() != alone.resolution() || alone.mean() > 0.0,
        "{} by {lanes:?}, {sampling:?}",
        scene.name()
    );
}

#[test]
fn images_have_the_same_bits() {
    let scenes = scenes();
    let seed = seed_for(master(), "lanes");
    let plain = sampling(Random, SamplerKind::Independent, seed);
    for scene in &scenes {
        let check = |lanes, sampling| assert_same_film(scene, lanes, sampling, None);
        for strategy in [PathStrategy::Bsdf, PathStrategy::Light, PathStrategy::Mis] {
            for (lights, heuristic) in [
                (LightSampling::Area, Heuristic::Balance),
                (LightSampling::SolidAngle, Heuristic::Power),
                (LightSampling::Importance, Heuristic::Power),
            ] {
                let path = Path {
                    lights,
                    heuristic,
                    ..Path::new(strategy)
                };
                check(LaneEstimator::Path(path), plain);
            }
        }
        let path = Path {
            rr_depth: 2,
            specular_nee: true,
            ..Path::new(PathStrategy::Mis)
        };
        for (lights, heuristic) in [
            (LightSampling::Area, Heuristic::Balance),
            (LightSampling::Importance, Heuristic::Power),
        ] {
            let path = Path {
                lights,
                heuristic,
                ..path
            };
            check(LaneEstimator::Path(path), plain);
        }
        for bounces in [0, 1, 2, 3] {
            let path = Path {
                bounces: Some(bounces),
                ..path
            };
            // So few pixels may be black.
            let window = Some(Window {
                corner: [0, 0],
                size: [23, 16],
            });
            let outlined = Sampling {
                silhouettes: true,
                ..plain
            };
            assert_same_film(scene, LaneEstimator::Path(path), outlined, window);
        }
        let path = LaneEstimator::Path(path);
        let report = |segments, rules| {
            LaneEstimator::Report(Report {
                segments,
                rules,
                ..Report::default()
            })
        };
        let whitted = |segments, rules| {
            LaneEstimator::Whitted(Whitted {
                segments,
                ..Whitted::new(rules)
            })
        };
        for segments in [0, 1, 2, 7] {
            check(report(segments, TransportRules::PHYSICAL), plain);
            check(whitted(segments, TransportRules::PHYSICAL), plain);
        }
        check(report(7, TransportRules::REPORT), plain);
        let branching = Report {
            rays: 3,
            segments: 4,
            rules: TransportRules::PHYSICAL,
            ..Report::default()
        };
        check(LaneEstimator::Report(branching), plain);
        check(whitted(7, TransportRules::REPORT), plain);
        // Other rules for light behind glass.
        for (shadows_pass_glass, caustics) in [(true, true), (false, false)] {
            let rules = TransportRules {
                shadows_pass_glass,
                caustics,
                ..TransportRules::PHYSICAL
            };
            check(report(20, rules), plain);
        }
        for (pixel, numbers, silhouettes) in [
            (Random, SamplerKind::Sobol(4), false),
            (Random, SamplerKind::Sobol(3), true),
            (Centre, SamplerKind::Independent, false),
            (Grid(2), SamplerKind::Independent, false),
            (Jitter(3), SamplerKind::Independent, true),
        ] {
            let sampling = Sampling {
                silhouettes,
                ..sampling(pixel, numbers, seed)
            };
            check(path, sampling);
            check(report(7, TransportRules::PHYSICAL), sampling);
            check(whitted(7, TransportRules::PHYSICAL), sampling);
        }
        let window = Some(Window {
            corner: [3, 4],
            size: [9, 2],
        });
        assert_same_film(scene, path, plain, window);
    }
}

/// Traces one ray at a time, by the same functions as all lanes.
#[test]
fn radiances_are_those_of_each_ray_alone() {
    for scene in scenes() {
        let camera = scene.camera();
        let sample = |i: u32| {
            let mut rng = stream(master(), i, 0);
            let ray = camera.ray([5, 4], 5.0 * uniform(&mut rng), 4.0 * uniform(&mut rng));
            Sample {
                ray,
                hit: scene.intersect(&ray),
                rng: rng.into(),
            }
        };
        let path = Path {
            specular_nee: true,
            ..Path::new(PathStrategy::Mis)
        };
        let each = |Sample { ray, hit, mut rng }| path.radiance(&scene, &ray, hit, &mut rng);
        let alone: Vec<DVec3> = (0..100).map(sample).map(each).collect();
        assert_eq!(
            path.radiances(&scene, &mut (0..100).map(sample)),
            alone,
            "{}",
            scene.name()
        );
    }
}

/// A BRDF with this value where light arrives from negative x, and 1 elsewhere.
#[derive(Debug)]
struct Broken(f64);

impl Model for Broken {
    fn eval(&self, _: DVec3, wi: DVec3) -> DVec3 {
        DVec3::splat(if wi.x < 0.0 { self.0 } else { 1.0 })
    }
    fn sample(&self, _: DVec3, random: [f64; 2]) -> Option<DVec3> {
        Some(cosine_hemisphere(random))
    }
    fn pdf(&self, _: DVec3, wi: DVec3) -> f64 {
        cosine_hemisphere_pdf(wi.z)
    }
    fn albedo(&self) -> DVec3 {
        DVec3::ONE
    }
}

/// An invalid radiance is an error at its pixel, even in one sample that the mean of its
/// replication would hide.
#[test]
fn what_is_no_radiance_is_an_error_at_its_pixel() {
    for wrong in [f64::NAN, 6e6] {
        let mut s = SceneBuilder::new("broken");
        s.background(DVec3::ONE);
        let surface = s.surface(Surface::new(Bsdf::model(Broken(wrong))));
        s.sphere(Sphere::new(DVec3::ZERO, 1.0), surface);
        let camera = Camera::new(DVec3::new(0.0, -3.5, 0.0), DVec3::ZERO, DVec3::Z, 0.2);
        let scene = s.build(camera).expect("a legal scene");
        let sampling = sampling(Jitter(4), SamplerKind::Independent, 1);
        let path = Path::new(PathStrategy::Mis);
        let film = || Film::new([1, 1], None, 16).expect("a legal size");
        let alone = render(&scene, &path, sampling, &mut film(), &(0..1), &|_| true)
            .expect_err("an invalid radiance");
        let together = render_lanes(
            &scene,
            LaneEstimator::Path(path),
            sampling,
            &mut film(),
            &(0..1),
            &|_| true,
        )
        .expect_err("an invalid radiance");
        assert_eq!(together.to_string(), alone.to_string());
        assert!(
            alone.to_string().contains("at pixel (0, 0), replication 0"),
            "{alone}"
        );
    }
}

/// Finished rows are reported, a run that is stopped says so, and a film of another kind is
/// refused.
#[test]
fn rows_are_reported() {
    let (scene, path) = (
        room_of_all_materials(),
        LaneEstimator::Path(Path::new(PathStrategy::Mis)),
    );
    let sampling = sampling(Random, SamplerKind::Independent, 1);
    let mut film = Film::new([8, 6], None, 1).expect("a legal size");
    let done = |samples| samples == 8 * 3;
    assert!(matches!(
        render_lanes(&scene, path, sampling, &mut film, &(0..3), &done),
        Ok(true)
    ));
    assert!(matches!(
        render_lanes(&scene, path, sampling, &mut film, &(3..4), &|_| false),
        Ok(false)
    ));
    let wrong = Sampling {
        pixel: Grid(2),
        ..sampling
    };
    assert!(matches!(
        render_lanes(&scene, path, wrong, &mut film, &(4..5), &|_| true),
        Err(Error::Option(_))
    ));
}

/// Eight rays at once have the distances of each alone.
#[test]
fn eight_rays_meet_what_each_meets() {
    let scene = simple::cornell().expect("a legal scene");
    let mut eight = EightRayIntersector::new(&scene);
    for k in 0..100 {
        let rays: [Ray; LANES] = from_fn(|i| {
            let mut rng = stream(9, k, i as u32);
            scene
                .camera()
                .ray([8, 6], 8.0 * uniform(&mut rng), 6.0 * uniform(&mut rng))
        });
        let [origins, directions] = [
            Lanes3::from_fn(|i| rays[i].origin),
            Lanes3::from_fn(|i| rays[i].direction),
        ];
        let together = eight.closest(&Ray::new(origins, directions));
        let alone = rays.map(|ray| scene.intersect(&ray).map_or(f64::INFINITY, |hit| hit.t));
        assert_eq!(together.to_array(), alone);
    }
}

/// Asserts that rays along the z axis miss small scenes of triangles beside it.
fn assert_slivers_are_missed<R: Wide<N>, const N: usize>(epsilon: f64) {
    let up = Ray::new(DVec3::ZERO, DVec3::Z);
    let ray = Ray::new(
        R::Vector::splat_vector(up.origin),
        R::Vector::splat_vector(up.direction),
    );
    for slivers in slivers_beside_z(epsilon).chunks(60) {
        let scene = scene_of(&Mesh {
            vertices: slivers.concat(),
            triangles: (0..slivers.len() as u32)
                .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
                .collect(),
        });
        let mut together = PacketIntersector::<R, N>::new(&scene);
        let t = together.closest(&ray);
        for lane in 0..N {
            assert_eq!(t.lane(lane), f64::INFINITY, "{slivers:?}");
        }
    }
}

/// Lists of triangles are missed by rays that pass them far away, as each alone is.
#[test]
fn slivers_are_missed_in_lists() {
    assert_slivers_are_missed::<Lanes, LANES>(f64::EPSILON);
    assert_slivers_are_missed::<Singles, SINGLES>(f32::EPSILON.into());
}
