//! Tests of specular connections through one mirror or glass object: all are found, obey the laws
//! of reflection and refraction, and have the geometry term that finite differences give.

use std::f64::consts::{FRAC_PI_2, PI};

use whitefurnace::geometry::specular_connection::{
    Caster, CasterKind, SpecularConnection, SphereConnections, geometry_term,
};
use whitefurnace::integrator::{Path, Strategy as Finds};
use whitefurnace::material::fresnel::{reflect, refract};
use whitefurnace::render::{LaneEstimator, render_lanes};
use whitefurnace::scene::specular_casters::MAX_CASTERS;

use crate::lanes::scenes::specular_casters;
use crate::prelude::*;

const CASES: u32 = 20_000;

/// A sphere, and two points outside.
#[derive(Debug)]
struct Case {
    caster: Caster<DVec3>,
    refracts: bool,
    x: DVec3,
    y: DVec3,
}

impl Case {
    fn new(i: u32) -> Self {
        let mut rng = stream(master(), i, 77);
        let mut unit = || uniform(&mut rng);
        let refracts = unit() < 0.7;
        let radius = 10_f64.powf(2.0 * unit() - 1.0);
        let centre = DVec3::new(unit(), unit(), unit()) * 4.0 - 2.0;
        let index = 1.0 + 10_f64.powf(1.6 * unit() - 1.6);
        let mut point = || {
            let [r1, r2] = [unit(), unit()];
            let away = from_spherical((1.0 - 2.0 * r1).acos(), 2.0 * PI * r2);
            // Both near and far.
            centre + away * radius * (1.0 + 10_f64.powf(4.0 * unit() - 3.0))
        };
        let (x, y) = (point(), point());
        // Often nearly opposite, where there are three connections.
        let y = if unit() < 0.5 {
            let across = centre - (x - centre).normalize() * (y - centre).length();
            let moved = across + (y - centre) * 0.3 * unit();
            centre + (moved - centre).normalize() * (y - centre).length()
        } else {
            y
        };
        let inverse_ior = if refracts { index.recip() } else { 0.0 };
        let caster = Caster {
            centre,
            radius,
            area: 0.0,
            normal: DVec3::ZERO,
            inverse_ior,
            index: if refracts { index } else { 0.0 },
            reflectance: DVec3::ONE,
            selection_weight: 1.0,
        };
        Self {
            caster,
            refracts,
            x,
            y,
        }
    }

    /// Returns the case with y at this offset from the line through x and the centre.
    fn in_line(self, offset: f64) -> Self {
        let Caster { centre, .. } = self.caster;
        let y = centre + (centre - self.x) + (self.y - centre) * offset;
        Self { y, ..self }
    }

    fn connections(&self) -> Vec<SpecularConnection<DVec3>> {
        SphereConnections::new(&self.caster, self.x, self.y, true, self.refracts)
            .connections()
            .map(|(_, connection)| connection)
            .collect()
    }

    /// Returns x, y and Θ of the equation.
    fn relative_positions(&self) -> [f64; 3] {
        let [x, y] = [self.x, self.y].map(|v| v - self.caster.centre);
        [
            x.length() / self.caster.radius,
            y.length() / self.caster.radius,
            x.angle_between(y),
        ]
    }

    /// Evaluates f of the equation through arc sines.
    fn turned_angle(&self, alpha: f64) -> f64 {
        let ([x, y, _], sin) = (self.relative_positions(), alpha.sin());
        2.0 * alpha
            - 2.0 * (sin * self.caster.inverse_ior).asin()
            - (sin / x).asin()
            - (sin / y).asin()
    }

    /// Estimates the solid angle per area between the connections to four points around y.
    fn geometry_term_by_differences(
        &self,
        connection: &SpecularConnection<DVec3>,
        step: f64,
    ) -> Option<f64> {
        let frame = Frame::new(connection.arriving);
        let moved = |by: DVec3| {
            let moved = Self {
                caster: self.caster,
                refracts: self.refracts,
                x: self.x,
                y: self.y + by,
            };
            let apart = |direction: &DVec3| (*direction - connection.direction).length();
            let directions = moved
                .connections()
                .into_iter()
                .map(|connection| connection.direction);
            directions.min_by(|a, b| apart(a).total_cmp(&apart(b)))
        };
        let [across, along] =
            [frame.x, frame.y].map(|axis| Some(moved(axis * step)? - moved(axis * -step)?));
        Some(across?.cross(along?).length() / (4.0 * step * step))
    }

    /// Returns where a ray from x leaves the sphere, and in which direction.
    fn follow(&self, direction: DVec3) -> Option<(DVec3, DVec3)> {
        let sphere = Sphere::new(self.caster.centre, self.caster.radius);
        let ray = Ray::new(self.x, direction);
        let first = ray.at(sphere.intersect(&ray, f64::INFINITY)?);
        let normal = sphere.normal(first);
        if !self.refracts {
            return Some((first, reflect(direction, normal)));
        }
        let inside = refract(direction, normal, 1.0, self.caster.index)?;
        let last = first - inside * (2.0 * inside.dot(normal)) * self.caster.radius;
        Some((
            last,
            refract(inside, -sphere.normal(last), self.caster.index, 1.0)?,
        ))
    }
}

#[test]
fn every_connection_through_a_sphere_is_found() {
    let mut found = [0; 4];
    for case in (0..CASES / 10).map(Case::new) {
        let [.., angle] = case.relative_positions();
        let targets = if case.refracts {
            vec![PI - angle, angle - PI]
        } else {
            vec![angle]
        };
        const STEPS: u32 = 4_000;
        let grid = |i: u32| FRAC_PI_2 * f64::from(i) / f64::from(STEPS);
        let values: Vec<f64> = (0..=STEPS).map(|i| case.turned_angle(grid(i))).collect();
        let crossings = |target: f64| {
            values
                .windows(2)
                .filter(|w| (w[0] < target) != (w[1] < target))
                .count()
        };
        // Two roots in one step of the grid are not detected.
        let near_fold = targets.iter().any(|target| {
            values
                .windows(3)
                .any(|w| w[1] <= w[0] && w[1] <= w[2] && (w[1] - target).abs() < 1e-6)
        });
        let expected: usize = targets.into_iter().map(crossings).sum();
        let count = case.connections().len();
        if !near_fold {
            assert_eq!(count, expected, "{case:?}");
        }
        found[count] += 1;
    }
    assert!(
        found.iter().all(|&cases| cases > 20),
        "{found:?} cases with 0 to 3 connections"
    );
}

#[test]
fn no_connection_ends_within_the_sphere() {
    for case in (0..CASES / 10).map(Case::new) {
        let within = |v: DVec3, share: f64| {
            case.caster.centre + (v - case.caster.centre).normalize() * case.caster.radius * share
        };
        for share in [0.1, 0.5, 0.9, 0.999] {
            for (x, y) in [
                (within(case.x, share), case.y),
                (case.x, within(case.y, share)),
            ] {
                let case = Case {
                    caster: case.caster,
                    refracts: case.refracts,
                    x,
                    y,
                };
                assert!(case.connections().is_empty(), "{case:?}");
            }
        }
    }
}

#[test]
fn connections_obey_the_laws_of_reflection_and_refraction() {
    let mut count = 0;
    let in_line = |i: u32| Case::new(i).in_line(0.1_f64.powi(1 + i as i32 % 6));
    for case in (0..CASES).flat_map(|i| [Case::new(i), in_line(i)]) {
        for connection in case.connections() {
            let Some((last, direction)) = case.follow(connection.direction) else {
                // At grazing incidence.
                assert!(
                    connection.cosine < 1e-5,
                    "misses, cosine {} of {case:?}",
                    connection.cosine
                );
                continue;
            };
            let towards = case.y - last;
            let miss = towards.cross(direction).length();
            let scale = (case.y - case.x).length() + case.caster.radius;
            // A rounding of the ray moves its end by that over the geometry term.
            let growth = 1.0 + (connection.geometry_term * scale * scale).sqrt().recip();
            assert!(
                miss < 1e-10 * scale * growth,
                "misses by {miss} of {scale}, {growth}, seen {:?} cosine {}: {case:?}",
                case.relative_positions(),
                connection.cosine
            );
            assert!(
                towards.dot(direction) > 0.0
                    && (connection.arriving - direction).length() < 1e-7 * growth,
                "{case:?}"
            );
            count += 1;
        }
    }
    assert!(count > CASES / 2, "{count} connections");
}

#[test]
fn geometry_terms_are_those_of_finite_differences() {
    let mut count = 0;
    for case in (0..CASES).map(Case::new) {
        for connection in case.connections() {
            let [x_distance, y_distance, angle] = case.relative_positions();
            let gap = (x_distance.min(y_distance) - 1.0) * case.caster.radius;
            let step = 1e-5
                * (case.y - case.x)
                    .length()
                    .min(case.caster.radius * angle.sin())
                    .min(gap);
            let differences =
                [step, step / 4.0].map(|step| case.geometry_term_by_differences(&connection, step));
            // Next to a caustic finite differences depend on the step and say little.
            if let [Some(a), Some(b)] = differences
                && (a / b - 1.0).abs() < 1e-3
            {
                assert!(
                    (b / connection.geometry_term - 1.0).abs() < 0.01,
                    "{b} and {} of {case:?}",
                    connection.geometry_term
                );
                count += 1;
            }
            let kind = if case.refracts {
                CasterKind::Refraction
            } else {
                CasterKind::Reflection
            };
            let (of_ray, _) =
                geometry_term(&case.caster, kind, case.x, connection.direction, case.y);
            let grazing = 1e-10 / (connection.cosine * connection.cosine);
            assert!(
                (of_ray / connection.geometry_term - 1.0).abs() < 1e-5 + grazing,
                "{of_ray} and {} of {case:?}",
                connection.geometry_term
            );
        }
    }
    assert!(count > CASES / 2, "{count} connections");
}

#[test]
fn a_flat_mirror_has_connections_at_its_front() {
    let (corner, edges) = (
        DVec3::new(-0.4, 0.1, -0.3),
        [DVec3::new(0.9, 0.2, 0.1), DVec3::new(-0.1, 0.3, 0.8)],
    );
    let scene = scene_from(
        Camera::new(DVec3::new(0.0, -9.0, 0.0), DVec3::ZERO, DVec3::Z, 0.5),
        |s| {
            let mirror = mirror_surface(s, 0.5);
            s.rectangle(corner, edges, mirror);
        },
    );
    let [caster] = scene.specular_casters().all() else {
        panic!("one caster")
    };
    let normal = edges[0].cross(edges[1]).normalize();
    let mut rng = rng("points");
    let mut found = [0; 2];
    for _ in 0..20_000 {
        let [x, y] = [0, 1].map(|_| in_cube(&mut rng, 1.5));
        let [height_x, height_y] = [x, y].map(|v| (v - corner).dot(normal));
        // Intersection of the line from x to the image of y with the plane, in coordinates along
        // the edges.
        let image = y - 2.0 * height_y * normal;
        let met = x + (image - x) * (height_x / (height_x + height_y));
        let across = edges.map(|edge| edge - edge.dot(normal) * normal);
        let along = |k: usize| {
            let dual = across[1 - k].cross(normal);
            (met - corner).dot(dual) / across[k].dot(dual)
        };
        let lies = |share: f64| (0.0..1.0).contains(&share);
        let expected = height_x > 0.0 && height_y > 0.0 && lies(along(0)) && lies(along(1));
        let connections: Vec<_> = caster.connections(x, y).collect();
        assert_eq!(
            connections.len(),
            usize::from(expected),
            "from {x:?} to {y:?}"
        );
        found[usize::from(expected)] += 1;
        for (_, connection) in connections {
            assert!(
                (connection.first.point - met).length() < 1e-12
                    && connection.first == connection.last
            );
            assert!((reflect(connection.direction, normal) - connection.arriving).length() < 1e-9);
            assert!((connection.direction - (met - x).normalize()).length() < 1e-9);
            assert_relative_eq!(
                connection.geometry_term,
                1.0 / (image - x).length_squared(),
                max_relative = 1e-12
            );
            assert_relative_eq!(
                connection.cosine,
                -connection.direction.dot(normal),
                max_relative = 1e-12
            );
            let of_ray = geometry_term(&caster.parameters, caster.kind, x, connection.direction, y);
            assert_relative_eq!(of_ray.0, connection.geometry_term, max_relative = 1e-12);
        }
    }
    assert!(
        found.iter().all(|&cases| cases > 200),
        "{found:?} without and with a connection"
    );
}

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
    let sampling = Sampling {
        pixel: Random,
        sampler: SamplerKind::Independent,
        seed: master(),
        silhouettes: false,
    };
    let path = Path {
        specular_nee: true,
        bounces,
        ..Path::new(DefaultParts, Finds::Mis)
    };
    let one_by_one = Path {
        specular_nee: true,
        bounces,
        ..Path::new(ScalarParts, Finds::Mis)
    };
    let alone = rendered(&scene, &one_by_one, [16, 16], sampling, &[0..40]).expect("legal values");
    let mut together = Film::new([16, 16], None, 1).expect("a film");
    let lanes = LaneEstimator::Path(path);
    render_lanes(&scene, lanes, sampling, &mut together, &(0..40), &|_| true)
        .expect("legal values");
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

impl NextEvent for NoWeight {
    fn mis_weight(&self, _: f64, _: f64) -> f64 {
        f64::NAN
    }
}

impl Roulette for NoWeight {}
impl Scattering for NoWeight {}

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
        ..Path::new(NoWeight, Finds::Mis)
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

fn mirror_surface(s: &mut SceneBuilder, reflectance: f64) -> SurfaceId {
    s.surface(Surface::new(Bsdf::Mirror {
        reflectance: DVec3::splat(reflectance),
    }))
}

#[test]
fn casters_are_whole_spheres_and_flat_mirrors() {
    let ball = |index: f64, sphere: Sphere| {
        kinds(|s| {
            let glass = s.surface(Surface::new(Bsdf::Glass { index }));
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
    assert_eq!(
        ball(
            1.5,
            Sphere {
                inward: true,
                ..whole
            }
        ),
        []
    );
    assert_eq!(
        ball(
            1.5,
            Sphere {
                zone: [0.0, f64::INFINITY],
                ..whole
            }
        ),
        []
    );
    let mirrors = |reflectance: f64| {
        kinds(|s| {
            let mirror = mirror_surface(s, reflectance);
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
                let mirror = mirror_surface(s, reflectance);
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
        let mirror = mirror_surface(s, 0.5);
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
