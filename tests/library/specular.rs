//! Tests of paths through mirrors and glass, where a path has one value or zero.

use whitefurnace::integrator::Density;

use crate::prelude::*;

const STREAMS: u32 = 200;

/// Returns the values of an estimator along a ray, one for each stream.
fn values(scene: &Scene, estimator: &dyn Estimator, ray: &Ray) -> Vec<f64> {
    let hit = scene.intersect(ray);
    (0..STREAMS)
        .map(|i| {
            estimator
                .radiance(scene, ray, hit, &mut stream(master(), i, 0))
                .x
        })
        .collect()
}

/// Glass that reflects all or nothing, and paths that end at their first diffuse surface.
#[derive(Clone, Copy)]
struct All(f64);

default_parts!(All: NextEvent, Photons, FiniteElements);

impl Scattering for All {
    fn fresnel(&self, _: f64, _: f64, _: f64) -> f64 {
        self.0
    }
}

impl Roulette for All {
    fn survives(&self, _: f64, survival: f64) -> bool {
        survival > 0.9
    }
    fn roulette_weight(&self, _: f64) -> f64 {
        1.0
    }
}

/// Counts only next-event estimation among the strategies of bidirectional path tracing.
impl Bidirectional for All {
    fn strategy_weight(&self, _: &[Density], s: usize) -> f64 {
        f64::from(s == 1)
    }
}

/// A floor and a tiny light within glass, seen from outside, have n² less radiance than without the
/// glass, by shadow rays, by both strategies, and by bidirectional path tracing.
#[test]
fn shadow_rays_in_glass_have_the_radiance_factor() {
    // A pixel so small that all its rays are one.
    let camera = Camera::new(3.0 * DVec3::Z, DVec3::ZERO, DVec3::X, 1e-6);
    let lit = |index| {
        scene(|s| {
            // Too dark for paths to survive.
            square(s, 9.0, 0.0, true, diffuse(0.4));
            panel(
                s,
                DVec3::new(1.0, 0.0, 0.2),
                [1e-6 * DVec3::Z, 1e-6 * DVec3::Y],
                lamp(4e9),
            );
            square(s, 9.0, 2.0, true, glass(index));
        })
    };
    let [air, dense] = [1.0, 1.5].map(|index| lit(index).with_camera(camera).expect("a scene"));
    let down = Ray::new(3.0 * DVec3::Z, -DVec3::Z);
    for strategy in [PathStrategy::Light, PathStrategy::Mis] {
        let path = Path::new(strategy).with_parts(Parts::replaced(&All(0.0)));
        let [found, known] = [&dense, &air].map(|scene| values(scene, &path, &down));
        assert!(known.iter().all(|value| *value > 0.0));
        let without: Vec<f64> = found.iter().map(|value| 2.25 * value).collect();
        assert_relative_eq!(without[..], known[..], max_relative = 1e-12);
    }
    let bdpt = Bdpt::new(Parts::replaced(&All(0.0)));
    for index in 0..20 {
        let [found, known] = [&dense, &air]
            .map(|scene| bdpt.pass(scene, [1, 1], master(), index).expect("legal")[0]);
        assert!(known.x > 0.0);
        assert_relative_eq!(2.25 * found.x, known.x, max_relative = 1e-4);
    }
}

/// Shadow rays that pass through glass see the light behind it, not its reflections.
#[test]
fn what_glass_reflects_counts_where_shadow_rays_pass_it() {
    let scene = scene(|s| {
        square(s, 1e-3, 0.0, true, diffuse(0.5));
        square(s, 9.0, -0.2, true, lamp(4.0));
        square(s, 99.0, 0.4, false, glass(1.5));
    });
    let report = Report {
        parts: Parts::replaced(&All(1.0)),
        rays: 1,
        segments: 3,
        rules: TransportRules {
            shadows_pass_glass: true,
            ..TransportRules::PHYSICAL
        },
    };
    let ray = Ray::new(
        DVec3::new(0.1, 0.0, 0.1),
        DVec3::new(-1.0, 0.0, -1.0).normalize(),
    );
    assert!(
        values(&scene, &report, &ray)
            .iter()
            .any(|value| *value > 0.0)
    );
}

/// The caustic map stores each particle that a mirror reflects onto a floor once, though the floor
/// reflects it and the mirror throws it back.
#[test]
fn a_caustic_ends_at_its_first_diffuse_surface() {
    let scene = scene(|s| {
        square(s, 99.0, 0.0, true, diffuse(0.9));
        square(s, 99.0, 0.5, false, reflecting(1.0));
        square(s, 0.1, 0.2, true, lamp(4.0));
    });
    let map = PhotonMap::new(
        Parts::default(),
        &scene,
        PhotonMapKind::Caustic,
        STREAMS,
        ImagePass::independent(master(), 0),
    );
    let kept = map.expect("a map").photons().count() as u32;
    assert!((STREAMS / 2..=STREAMS).contains(&kept), "{kept}");
}

/// Every method of the report sees the background directly, in a mirror times its reflectance, and
/// from within glass with n² if its rules are physical.
#[test]
fn the_background_is_seen_straight_in_mirrors_and_through_glass() {
    let sky = |surface: Surface| {
        scene(|s| {
            s.background(DVec3::splat(3.0));
            square(s, 1.0, 0.0, true, surface);
        })
    };
    let (mirror, glass) = (sky(reflecting(0.5)), sky(glass(1.5)));
    let [up, down] = [1.0, -1.0].map(|z| Ray::new(DVec3::Z, DVec3::new(0.0, 0.1, z).normalize()));
    let within = Ray::new(-DVec3::Z, up.direction);
    for (rules, squared) in [
        (TransportRules::PHYSICAL, 2.25),
        (TransportRules::REPORT, 1.0),
    ] {
        let report = Report {
            rules,
            parts: Parts::replaced(&All(0.0)),
            rays: 1,
            segments: 7,
        };
        let whitted = Whitted {
            rules,
            parts: Parts::replaced(&All(0.0)),
            segments: 7,
        };
        for (scene, ray, seen) in [
            (&mirror, &up, 3.0),
            (&mirror, &down, 1.5),
            (&glass, &within, 3.0 * squared),
        ] {
            let all = [values(scene, &report, ray), values(scene, &whitted, ray)].concat();
            assert!(all.iter().all(|value| (value - seen).abs() <= 1e-12));
        }
    }
    for (ray, seen) in [(&up, 3.0), (&down, 1.5)] {
        assert!(
            values(&mirror, &Published::default(), ray)
                .iter()
                .all(|value| *value == seen)
        );
    }
}
