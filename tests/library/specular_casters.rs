//! Tests of the specular casters of a scene: which there are, how they are picked, and that their
//! connections are the paths through one of them.

use whitefurnace::geometry::specular_connection::{Caster, CasterKind, geometry_term};
use whitefurnace::scene::specular_casters::MAX_CASTERS;

use crate::lanes::scenes::specular_casters;
use crate::prelude::*;

/// Follows a ray that left a surface through up to two mirrors or glass surfaces, whose branches
/// are sampled at random, and returns their hits and the first hit beyond.
fn follow(scene: &Scene, ray: &Ray, rng: &mut impl Rng) -> Option<(Vec<Hit>, Hit)> {
    let (mut met, mut ray) = (Vec::new(), *ray);
    loop {
        let hit = scene.intersect(&ray)?;
        let bsdf = &scene.surface(&hit).bsdf;
        if hit.emitter.is_some() || bsdf.is_non_delta() {
            return (hit.emitter.is_some() && hit.normal.dot(ray.direction) < 0.0)
                .then_some((met, hit));
        }
        let sample = bsdf.sample(&whitefurnace::material::Vertex::new(&hit, &ray), rng)?;
        met.push(hit);
        if met.len() > 2 {
            return None;
        }
        ray = scene.spawn_ray(hit.point, hit.normal, sample.direction);
    }
}

#[test]
fn connections_include_every_sampled_specular_path() {
    let scene = specular_casters(0);
    let all = scene.specular_casters().all();
    let mut found = [0; 3];
    let mut rng = rng("paths");
    for _ in 0..400_000 {
        let x = in_cube(&mut rng, 0.99).with_z(-0.999);
        let w = uniform_hemisphere(uniform2(&mut rng));
        let Some((met, light)) = follow(&scene, &Ray::new(x, w), &mut rng) else {
            continue;
        };
        let kind = match met[..] {
            [only]
                if matches!(
                    scene.primitives().nth(only.primitive as usize),
                    Some((Geometry::Triangle(_), _))
                ) =>
            {
                CasterKind::Flat
            }
            [only] if only.normal.dot(w) < 0.0 => CasterKind::Reflection,
            [first, last] if first.primitive == last.primitive => CasterKind::Refraction,
            _ => continue,
        };
        let is_here = |caster: &Caster<DVec3>| {
            let distance = met[0].point.distance(caster.centre);
            if kind == CasterKind::Flat {
                distance < 1.0
            } else {
                (distance - caster.radius).abs() < 1e-9
            }
        };
        let caster = all
            .iter()
            .find(|caster| caster.kind == kind && is_here(&caster.parameters))
            .expect("a caster");
        let (term, cosine) = geometry_term(&caster.parameters, kind, x, w, light.point);
        // On a caustic two connections merge up to rounding, and the path keeps its full weight.
        if term > 1e4 {
            continue;
        }
        let connections = caster.connections(x, light.point);
        let near = connections
            .map(|(_, connection)| connection)
            .min_by(|a, b| {
                (a.direction - w)
                    .length()
                    .total_cmp(&(b.direction - w).length())
            });
        let near = near.expect("a connection");
        // Near a caustic the direction is known to the square root of a rounding.
        let blur = 1e-9 + 1e-12 * term;
        assert!(
            (near.direction - w).length() < 1e3 * blur,
            "{:?} for {w:?} from {x:?} to {light:?} by {caster:?}, {term} {cosine} {}",
            near.direction,
            near.geometry_term
        );
        assert!(
            (near.geometry_term / term - 1.0).abs() < 1e-4 * (1.0 + term)
                && (near.cosine - cosine).abs() < 1e-4
        );
        found[kind as usize] += 1;
    }
    assert!(
        found.iter().all(|&paths| paths > 100),
        "{found:?} by flat mirrors, reflected and refracted"
    );
}

/// Returns the mean over a patch at the origin that faces up, with parts of a scene around it,
/// computed in all lanes and by scalar functions.
fn on_patch(bounces: Option<u32>, parts: &[&dyn Fn(&mut SceneBuilder)]) -> f64 {
    let camera = Camera::new(DVec3::new(0.0, -0.05, 0.05), DVec3::ZERO, DVec3::Z, 0.1);
    let scene = scene_from(camera, |s| {
        square(s, 0.02, 0.0, true, diffuse(0.5));
        parts.iter().for_each(|add| add(s));
    });
    let sampling = sampling(Random, SamplerKind::Independent, master());
    let path = Path {
        specular_nee: true,
        bounces,
        ..Path::new(PathStrategy::Mis)
    };
    let one_by_one = path.with_parts(Parts::replaced(&ScalarParts));
    let alone = rendered(&scene, &one_by_one, [16, 16], sampling, &[0..40]).expect("legal values");
    let lanes = lanes(LaneEstimator::Path(path), sampling, Precision::Double);
    let together = filled(&lanes, &scene, [16, 16], 0..40).expect("legal values");
    assert!(alone == together);
    alone.mean()
}

/// Opaque objects that block every connection, in any segment, leave the patch dark, and so does a
/// bounce limit below the length of all connections.
#[test]
fn every_segment_of_a_connection_is_tested_for_visibility_and_counted() {
    let wall = |corner, edges| move |s: &mut SceneBuilder| panel(s, corner, edges, diffuse(0.0));
    let sphere = |centre, radius, surface: fn() -> Surface| {
        move |s: &mut SceneBuilder| ball(s, Sphere::new(centre, radius), surface())
    };
    // Through a ball to a light above it, with the blocker before, within and behind the ball. No
    // light that enters from outside comes nearer to the centre than 1/1.5.
    let centre = DVec3::new(0.0, 0.0, 1.3);
    let lens = sphere(centre, 1.0, || glass(1.5));
    let above = |s: &mut SceneBuilder| square(s, 0.7, 3.2, false, lamp(1.0));
    let level = |z| wall(DVec3::new(-2.0, -2.0, z), [4.0 * DVec3::X, 4.0 * DVec3::Y]);
    assert!(on_patch(None, &[&lens, &above]) > 0.0);
    assert_eq!(on_patch(None, &[&lens, &above, &level(0.15)]), 0.0);
    assert_eq!(
        on_patch(
            None,
            &[&lens, &above, &sphere(centre, 0.9, || diffuse(0.0))]
        ),
        0.0
    );
    assert_eq!(on_patch(None, &[&lens, &above, &level(2.7)]), 0.0);
    // By a mirror at the side to a light that faces it: blocked before and behind.
    let mirror = || reflecting(0.9);
    let flat = |s: &mut SceneBuilder| {
        panel(
            s,
            DVec3::new(1.0, -2.0, 0.0),
            [2.0 * DVec3::Z, 4.0 * DVec3::Y],
            mirror(),
        );
    };
    let round = sphere(DVec3::new(1.5, 0.0, 0.55), 0.5, mirror);
    let aside = |s: &mut SceneBuilder| {
        panel(
            s,
            DVec3::new(0.2, -0.1, 0.9),
            [0.2 * DVec3::Y, 0.2 * DVec3::Z],
            lamp(1.0),
        );
    };
    let upright = |low: f64, high: f64| {
        wall(
            DVec3::new(0.6, -3.0, low),
            [6.0 * DVec3::Y, (high - low) * DVec3::Z],
        )
    };
    for mirror in [&flat as &dyn Fn(&mut SceneBuilder), &round] {
        assert!(on_patch(None, &[mirror, &aside]) > 0.0);
        assert_eq!(on_patch(None, &[mirror, &aside, &upright(0.0, 0.55)]), 0.0);
        assert_eq!(on_patch(None, &[mirror, &aside, &upright(0.56, 3.0)]), 0.0);
        // The patch and a mirror scatter light once each, the ball of glass twice.
        assert!(on_patch(Some(2), &[mirror, &aside]) > 0.0);
        assert_eq!(on_patch(Some(1), &[mirror, &aside]), 0.0);
    }
    assert!(on_patch(Some(3), &[&lens, &above]) > 0.0);
    assert_eq!(on_patch(Some(2), &[&lens, &above]), 0.0);
}

/// Returns NaN for every MIS weight: no path may be weighted.
#[derive(Clone, Copy, Debug, Default)]
struct NoWeight;

default_parts!(NoWeight: Scattering, Roulette, Photons, Bidirectional, FiniteElements);

impl NextEvent for NoWeight {
    fn mis_weight(&self, _: f64, _: f64) -> f64 {
        f64::NAN
    }
}

/// A path that enters a ball and leaves another that overlaps it is no specular connection: it
/// keeps its weight.
#[test]
fn a_path_between_two_overlapping_balls_is_no_connection() {
    let scene = scene(|s| {
        panel(
            s,
            DVec3::new(-0.2, -0.1, -0.1),
            [0.2 * DVec3::Y, 0.2 * DVec3::Z],
            diffuse(0.5),
        );
        for (x, radius) in [(0.0, 1.0), (1.0, 0.6)] {
            ball(s, Sphere::new(DVec3::new(x, 0.0, 0.0), radius), glass(1.5));
        }
        // In the second ball, beyond the first.
        panel(
            s,
            DVec3::new(1.3, -0.3, -0.3),
            [0.6 * DVec3::Z, 0.6 * DVec3::Y],
            lamp(1.0),
        );
    });
    assert_eq!(scene.specular_casters().all().len(), 4);
    let ray = Ray::new(DVec3::new(0.2, 0.0, 0.0), -DVec3::X);
    let path = Path {
        specular_nee: true,
        ..Path::new(PathStrategy::Mis).with_parts(Parts::replaced(&NoWeight))
    };
    let mut rng = rng("paths");
    let sum: f64 = (0..10_000)
        .map(|_| {
            path.radiance(&scene, &ray, scene.intersect(&ray), &mut rng)
                .x
        })
        .sum();
    assert!(sum > 0.0, "{sum}");
}

/// Returns the kinds of a scene's specular casters, each with the radius of a sphere or the area of
/// a flat mirror.
fn kinds(parts: impl FnOnce(&mut SceneBuilder)) -> Vec<(CasterKind, f64)> {
    let scene = scene_from(
        Camera::new(DVec3::new(0.0, -9.0, 0.0), DVec3::ZERO, DVec3::Z, 0.5),
        parts,
    );
    scene
        .specular_casters()
        .all()
        .iter()
        .map(|caster| {
            (
                caster.kind,
                caster.parameters.radius + caster.parameters.area,
            )
        })
        .collect()
}

#[test]
fn casters_are_whole_spheres_and_flat_mirrors() {
    let ball = |index: f64, sphere: Sphere| {
        kinds(|s| {
            let glass = s.surface(glass(index));
            s.sphere(sphere, glass);
        })
    };
    let whole = Sphere::new(DVec3::ZERO, 2.0);
    assert_eq!(
        ball(1.5, whole),
        [(CasterKind::Refraction, 2.0), (CasterKind::Reflection, 2.0)]
    );
    // A bubble, a ball of air, a shell seen from within, and a part of a ball.
    assert_eq!(ball(0.7, whole), []);
    assert_eq!(ball(1.0, whole), []);
    assert_eq!(ball(1.5, inward(whole)), []);
    assert_eq!(ball(1.5, between_heights(whole, [0.0, f64::INFINITY])), []);
    let mirrors = |reflectance: f64| {
        kinds(|s| {
            let mirror = s.surface(reflecting(reflectance));
            s.sphere(whole, mirror);
            simple::closed_cube(s, 3.0, false, mirror);
        })
    };
    let mut sides = vec![(CasterKind::Flat, 36.0); 6];
    sides.push((CasterKind::Reflection, 2.0));
    assert_eq!(mirrors(0.5), sides);
    assert_eq!(mirrors(0.0), []);
    // Triangles of another colour or height are separate mirrors; a mesh of many triangles is none.
    let flat = |parts: &[(f64, f64)], count: u32| {
        kinds(|s| {
            for (row, &(reflectance, z)) in (0..).zip(parts) {
                let mirror = s.surface(reflecting(reflectance));
                for i in 0..count {
                    s.rectangle(
                        DVec3::new(f64::from(i), f64::from(row), z),
                        [DVec3::X, DVec3::Y],
                        mirror,
                    );
                }
            }
        })
    };
    assert_eq!(flat(&[(0.5, 0.0)], 3), [(CasterKind::Flat, 3.0)]);
    assert_eq!(
        flat(&[(0.5, 0.0), (0.5, 0.1)], 3),
        [(CasterKind::Flat, 3.0); 2]
    );
    assert_eq!(
        flat(&[(0.5, 0.0), (0.6, 0.0)], 3),
        [(CasterKind::Flat, 3.0); 2]
    );
    assert_eq!(flat(&[(0.5, 0.0)], 8), [(CasterKind::Flat, 8.0)]);
    assert_eq!(flat(&[(0.5, 0.0)], 9), []);
    // The largest are taken.
    let balls = kinds(|s| {
        let mirror = s.surface(reflecting(0.5));
        for i in 1..=20 {
            s.sphere(
                Sphere::new(DVec3::new(0.0, 0.0, 50.0 * f64::from(i)), f64::from(i)),
                mirror,
            );
        }
    });
    let largest: Vec<_> = (5..=20)
        .rev()
        .map(|i| (CasterKind::Reflection, f64::from(i)))
        .collect();
    assert_eq!((balls.len(), balls), (MAX_CASTERS, largest));
}

#[test]
fn selection_probabilities_are_zero_for_invisible_casters() {
    let scene = specular_casters(0);
    let all = scene.specular_casters().all();
    let mut rng = rng("points");
    for _ in 0..1000 {
        let from = in_cube(&mut rng, 1.0);
        let shares: [f64; MAX_CASTERS] = scene.specular_casters().selection_probabilities(from);
        let sum: f64 = shares.iter().sum();
        assert!((sum - 1.0).abs() < 1e-12 || sum == 0.0, "{sum}");
        for (i, caster) in all.iter().enumerate() {
            let away = from - caster.parameters.centre;
            let faces = if caster.kind == CasterKind::Flat {
                away.dot(caster.parameters.normal) > 0.0
            } else {
                away.length() > caster.parameters.radius
            };
            assert_eq!(shares[i] > 0.0, faces, "{caster:?} from {from:?}");
            assert_eq!(
                scene
                    .specular_casters()
                    .selection_probability(i as f64, from),
                shares[i]
            );
        }
    }
}
