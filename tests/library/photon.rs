//! Tests of the kd-tree against brute force, and of photon maps and lookups, photon by photon.

use statrs::function::gamma::ln_gamma;
use whitefurnace::integrator::photon::photon_map::{MAX_MAP_MEMORY, Photon, same_side};
use whitefurnace::integrator::{Sample, radius_squared};
use whitefurnace::light::emitter::EmitterPoint;
use whitefurnace::math::kd_tree::KdTree;
use whitefurnace::math::simd::LANES;

use crate::prelude::*;

/// Returns the indices of the points that a tree finds within a radius, as it visits them.
fn found(tree: &KdTree, order: &[u32], centre: DVec3, radius_squared: f64) -> Vec<usize> {
    let mut found = Vec::new();
    tree.within(centre, radius_squared, |chunk, near| {
        assert_ne!(near, 0);
        let near = (0..32).filter(|lane| near >> lane & 1 == 1);
        found.extend(near.map(|lane| order[chunk * LANES + lane] as usize));
    });
    found
}

/// Finds every point within the radius once and no other, ties and equal points included, in the
/// tree's order.
#[test]
fn a_kd_tree_finds_what_brute_force_finds() {
    let grid = prop::array::uniform3((-4i32..=4).prop_map(|i| f64::from(i) * 0.25))
        .prop_map(DVec3::from_array);
    let points = prop_oneof![
        prop::collection::vec(point(1.0), 0..200),
        prop::collection::vec(grid.clone(), 0..200),
    ];
    // On the grid many points are just as far as the radius.
    let balls = prop_oneof![
        (point(1.2), 0.0..1.5f64),
        (grid, (0i32..=6).prop_map(|i| f64::from(i) * 0.25)),
    ];
    property(
        "kd-tree",
        256,
        &(points, balls),
        |(points, (centre, radius))| {
            let (tree, order) = KdTree::new(points.iter().copied());
            assert_eq!([tree.len(), order.len()], [points.len(); 2]);
            assert_eq!(tree.is_empty(), points.is_empty());
            let r2 = radius * radius;
            let mut found = found(&tree, &order, centre, r2);
            let found_in_order = order
                .iter()
                .map(|&i| i as usize)
                .filter(|i| found.contains(i));
            assert!(found_in_order.eq(found.iter().copied()), "{found:?}");
            found.sort_unstable();
            let expected: Vec<usize> = (0..points.len())
                .filter(|&i| points[i].distance_squared(centre) <= r2)
                .collect();
            assert_eq!(found, expected);
        },
    );
}

/// Enough points for threads to share the work.
#[test]
fn a_large_kd_tree_does_not_depend_on_the_threads() {
    let mut rng = stream(7, 0, 0);
    let points: Vec<DVec3> = (0..50_000)
        .map(|_| DVec3::from_array([0; 3].map(|_| uniform(&mut rng))))
        .collect();
    let order = |threads| {
        let (tree, order) = on_threads(threads, || KdTree::new(points.iter().copied()));
        found(&tree, &order, DVec3::splat(0.5), 0.1)
    };
    let one = order(1);
    let within = |p: &&DVec3| p.distance_squared(DVec3::splat(0.5)) <= 0.1;
    assert_eq!(one.len(), points.iter().filter(within).count());
    assert_eq!(one, order(3));
}

/// `place` gives the approximate index of a point, in the tree's order.
#[test]
fn a_kd_tree_knows_about_where_points_are() {
    let mut rng = stream(master(), 0, 0);
    let points: Vec<DVec3> = (0..5000)
        .map(|_| DVec3::from_array([0; 3].map(|_| uniform(&mut rng))))
        .collect();
    let (tree, order) = KdTree::new(points.iter().copied());
    let mut places: Vec<usize> = order
        .iter()
        .map(|&i| tree.approximate_index(points[i as usize]))
        .collect();
    assert!(places.is_sorted());
    assert!(
        places
            .iter()
            .enumerate()
            .all(|(i, &place)| (place..place + 512).contains(&i))
    );
    places.dedup();
    assert_eq!(places.len(), 16);
}

fn photons(kept: PhotonMapKind, scene: &Scene, emitted: u32) -> Vec<Photon> {
    PhotonMap::new(
        Parts::default(),
        scene,
        kept,
        emitted,
        ImagePass::independent(3, 1),
    )
    .expect("a small map")
    .photons()
    .collect()
}

#[test]
fn without_mirrors_and_glass_there_are_no_caustic_photons() {
    assert!(
        photons(
            PhotonMapKind::Caustic,
            &room::diffuse().expect("a scene"),
            2000
        )
        .is_empty()
    );
    let found = photons(PhotonMapKind::Caustic, &report_room(), 2000).len();
    assert!(found > 0 && found < 2000, "{found}");
}

/// In a furnace whose walls absorb everything each particle leaves one photon, of flux π L A/N.
#[test]
fn flux_is_shared_among_the_particles_that_were_emitted() {
    let found = photons(PhotonMapKind::All, &furnace(0.0), 100);
    assert_eq!(found.len(), 100);
    for photon in found {
        assert_relative_eq!(photon.flux.x, PI * 24.0 / 100.0, max_relative = 1e-12);
        assert_relative_eq!(photon.normal.length(), 1.0, max_relative = 1e-12);
        assert!(photon.normal.dot(photon.from) > 0.0);
    }
}

/// Each particle leaves one photon here: as many as fit are accepted, and no more.
#[test]
fn a_map_that_would_not_fit_memory_is_refused_before_it_is_made() {
    let scene = furnace(0.0);
    let each = size_of::<(DVec3, Photon)>() + size_of::<Photon>() + KdTree::BYTES;
    let most = (MAX_MAP_MEMORY / each) as u32;
    let check = |emitted| {
        PhotonMap::check(
            Parts::default(),
            &scene,
            PhotonMapKind::All,
            emitted,
            ImagePass::independent(1, 0),
        )
    };
    assert!(check(most).is_ok());
    assert_option_refused(check(most + 1), "about 4 GB of photons, more than the 4 GB");
    assert_option_refused(
        PhotonMap::new(
            Parts::default(),
            &scene,
            PhotonMapKind::All,
            u32::MAX,
            ImagePass::independent(1, 0),
        ),
        "GB",
    );
}

/// Lookups for a whole tile return those of each sample alone, in any order, and those by parts that
/// are asked about each photon.
#[test]
fn photons_are_looked_up_for_many_samples_as_for_one() {
    let scene = report_room();
    let gather = final_gather(500, 0.2);
    for lookup in [Lookup::DirectVisualization, gather] {
        let [photons, asked] = [Parts::default(), Parts::replaced(&ScalarParts)].map(|parts| {
            let pass = ImagePass::independent(master(), 0);
            PhotonMapping::new(parts, &scene, lookup, 4000, 0.2, pass).expect("a map")
        });
        let samples = || {
            (0..400).map(|i| {
                let ray =
                    scene
                        .camera()
                        .ray([20, 20], f64::from(i % 20) + 0.5, f64::from(i / 20) + 0.5);
                Sample {
                    ray,
                    hit: scene.intersect(&ray),
                    rng: ImagePass::independent(master(), 1).pixel_stream(i),
                }
            })
        };
        let alone = samples()
            .map(|Sample { ray, hit, mut rng }| photons.radiance(&scene, &ray, hit, &mut rng));
        let alone: Vec<DVec3> = alone.collect();
        for photons in [&photons, &asked] {
            assert_eq!(photons.radiances(&scene, &mut samples()), alone);
        }
        assert!(
            alone
                .iter()
                .filter(|radiance| **radiance != DVec3::ZERO)
                .count()
                > 300
        );
    }
}

#[test]
fn photons_behind_and_round_the_corner_are_on_other_surfaces() {
    assert!(same_side(DVec3::Z, DVec3::Z));
    assert!(same_side(DVec3::new(0.3, 0.0, 1.0).normalize(), DVec3::Z));
    assert!(!same_side(-DVec3::Z, DVec3::Z));
    assert!(!same_side(DVec3::X, DVec3::Z));
}

/// The product of [`whitefurnace::equation::PHOTON_RADIUS`] is r² Γ(n + α)/(Γ(1 + α) Γ(n + 1)).
#[test]
fn the_radius_of_a_pass_is_a_quotient_of_gamma_functions() {
    let alpha = 2.0 / 3.0;
    for n in [1u32, 2, 3, 10, 1000] {
        let x = f64::from(n);
        let log = ln_gamma(x + alpha) - ln_gamma(1.0 + alpha) - ln_gamma(x + 1.0);
        assert_relative_eq!(
            radius_squared(0.25, n - 1),
            0.25 * log.exp(),
            max_relative = 1e-9
        );
    }
}

/// One particle, from the middle of a lamp: all directions follow the normal, and glass reflects
/// nothing. The field says whether final gathering counts emitters.
#[derive(Clone, Copy)]
struct SinglePhoton(bool);

default_parts!(SinglePhoton: Bidirectional, FiniteElements);

impl Scattering for SinglePhoton {
    fn fresnel(&self, _: f64, _: f64, _: f64) -> f64 {
        0.0
    }
    fn cosine_hemisphere(&self, _: [f64; 2]) -> DVec3 {
        DVec3::Z
    }
}

impl Roulette for SinglePhoton {
    fn survives(&self, _: f64, _: f64) -> bool {
        true
    }
    fn roulette_weight(&self, _: f64) -> f64 {
        1.0
    }
}

impl NextEvent for SinglePhoton {
    fn sample_emitter(&self, _: &Emitter, _: [f64; 2]) -> EmitterPoint {
        EmitterPoint {
            point: DVec3::ZERO,
            normal: DVec3::Z,
        }
    }
}

impl Photons for SinglePhoton {
    fn gathers_emission(&self) -> bool {
        self.0 || DefaultParts.gathers_emission()
    }
}

/// Checks the radiance of one photon on a ceiling, seen directly, in a mirror, from within glass,
/// by a ray of final gathering, and as a caustic; and of the shadow ray that comes with it.
#[test]
fn one_photon_is_seen_in_every_way() {
    let (side, radius, caustic_radius, rho) = (0.02, 0.1, 0.2, 0.6);
    let small = |s: &mut SceneBuilder, half: f64, x: f64, z: f64, surface: Surface| {
        panel(
            s,
            DVec3::new(x - half, -half, z),
            [2.0 * half * DVec3::X, 2.0 * half * DVec3::Y],
            surface,
        );
    };
    let lit = |add: &dyn Fn(&mut SceneBuilder)| {
        scene(|s| {
            small(s, 0.5 * side, 0.0, 0.0, lamp(2.0));
            square(s, 0.2, 1.0, false, diffuse(rho));
            add(s);
        })
    };
    let plain = lit(&|_| {});
    let mirror = lit(&|s| square(s, 1.0, -0.1, true, reflecting(0.5)));
    let glass_before = lit(&|s| small(s, 0.02, 0.05, 0.7, glass(1.5)));
    let paper_below = lit(&|s| {
        small(s, 0.02, 0.05, 0.7, glass(1.5));
        small(s, 0.02, 0.05, 0.2, diffuse(0.5));
    });
    let glass_above = lit(&|s| small(s, 0.04, 0.0, 0.5, glass(1.5)));
    let flux = 2.0 * PI * side * side;
    let by_photon = |radius: f64| rho * FRAC_1_PI * flux / (PI * radius * radius);
    let by_shadow_ray = rho * FRAC_1_PI * 2.0 * side * side / (1.0f64 + 0.05 * 0.05).powi(2);
    let gather = final_gather(1, caustic_radius);
    let seen = |scene: &Scene, parts: SinglePhoton, lookup: Lookup, ray: &Ray| {
        let parts = Parts::replaced(&parts);
        let photons = PhotonMapping::new(
            parts,
            scene,
            lookup,
            1,
            radius,
            ImagePass::independent(1, 0),
        )
        .expect("a map");
        photons
            .radiance(scene, ray, scene.intersect(ray), &mut stream(1, 0, 0))
            .x
    };
    let (up, down) = (DVec3::Z, -DVec3::Z);
    for (scene, lookup, direction, known) in [
        (&plain, Lookup::DirectVisualization, up, by_photon(radius)),
        (
            &mirror,
            Lookup::DirectVisualization,
            down,
            0.5 * by_photon(radius),
        ),
        (
            &glass_before,
            Lookup::DirectVisualization,
            up,
            2.25 * by_photon(radius),
        ),
        (&plain, gather, up, by_shadow_ray),
        (&paper_below, gather, down, 0.5 * 2.25 * by_photon(radius)),
        (&glass_above, gather, up, by_photon(caustic_radius)),
    ] {
        let ray = Ray::new(DVec3::new(0.05, 0.0, 0.6), direction);
        assert_relative_eq!(
            seen(scene, SinglePhoton(false), lookup, &ray),
            known,
            max_relative = 1e-9
        );
    }
    let behind = Ray::new(DVec3::new(0.05, 0.0, 1.5), down);
    assert_eq!(
        seen(
            &plain,
            SinglePhoton(false),
            Lookup::DirectVisualization,
            &behind
        ),
        0.0
    );
    // The radius of a pass, and a pixel so small that all its rays are one.
    let camera = Camera::new(
        DVec3::new(0.05, 0.0, 0.6),
        DVec3::new(0.05, 0.0, 1.0),
        DVec3::X,
        1e-6,
    );
    let scene = plain.with_camera(camera).expect("a scene");
    for index in 0..3 {
        let sppm = sppm(Parts::replaced(&SinglePhoton(false)), 1, radius);
        let found = sppm.pass(&scene, [1, 1], 1, index).expect("a pass")[0];
        let known = by_photon(radius_squared(radius * radius, index).sqrt());
        assert_relative_eq!(found.x, known, max_relative = 1e-9);
    }
    // From the ceiling straight down to the lamp.
    let ray = Ray::new(DVec3::new(0.005, 0.0, 0.6), up);
    let [without, with] =
        [false, true].map(|gathers| seen(&scene, SinglePhoton(gathers), gather, &ray));
    assert_relative_eq!(with - without, rho * 2.0, max_relative = 1e-9);
}
