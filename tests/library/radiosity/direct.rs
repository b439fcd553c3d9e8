//! Tests of the direct irradiance of patches.

use std::sync::Mutex;

use super::*;

/// Records visibility tests, hides points according to `hides`, and subdivides all of a sphere's
/// patches or none.
struct VisibilityRecorder {
    hides: fn(DVec3) -> bool,
    divides: bool,
    points: Mutex<Vec<[f64; 2]>>,
    targets: Mutex<Vec<SurfacePoint>>,
}

impl VisibilityRecorder {
    fn new(hides: fn(DVec3) -> bool, divides: bool) -> Self {
        Self {
            hides,
            divides,
            points: Mutex::default(),
            targets: Mutex::default(),
        }
    }
}

default_parts!(VisibilityRecorder: Scattering, Roulette, Photons, Bidirectional);

impl NextEvent for VisibilityRecorder {
    fn sample_emitter(&self, emitter: &Emitter, random: [f64; 2]) -> EmitterPoint {
        self.points.lock().expect("no panic").push(random);
        emitter.sample(random)
    }
    fn visible(&self, _: &Scene, _: SurfacePoint, y: SurfacePoint, _: bool) -> bool {
        self.targets.lock().expect("no panic").push(y);
        !(self.hides)(y.point)
    }
}

impl FiniteElements for VisibilityRecorder {
    fn is_near(&self, _: f64, _: f64) -> bool {
        self.divides
    }
}

/// The visible part of a flat light is tested at 64 points, one in each elementary interval of the
/// square, each with its geometry term as weight.
#[test]
fn the_seen_share_of_a_light_is_that_of_its_geometry_terms() {
    let corner = DVec3::new(1.0, -1.0, -0.6);
    let edges = [DVec3::new(0.2, 0.3, 2.0), DVec3::new(-0.1, 2.2, 0.4)];
    let [a, b] = edges;
    let triangle = [corner, corner + a, corner + b];
    let radiance = DVec3::new(3.0, 2.0, 1.0);
    let polygons: [&[DVec3]; 2] = [&[corner, corner + a, corner + a + b, corner + b], &triangle];
    for (outline, flat) in polygons.into_iter().zip([false, true]) {
        let scene = scene(|s| {
            square(s, 0.5, 0.0, true, diffuse(0.5));
            let light = s.surface(Surface::new(Bsdf::Black).emitting(radiance));
            if flat {
                s.mesh(&triangle, &[[0, 1, 2]], light);
            } else {
                s.rectangle(corner, edges, light);
            }
        });
        let hides = |y: DVec3| y.y + y.z > 0.4;
        let recorder = VisibilityRecorder::new(hides, false);
        let solved = solve_with(Parts::replaced(&recorder), &scene, 1);
        recorder.points.lock().expect("no panic").clear();
        let x = DVec3::new(0.1, 0.2, 0.0);
        let found = irradiance(&solved, &scene, x, -DVec3::Z);

        let points = recorder.points.lock().expect("no panic");
        assert_eq!(points.len(), 64);
        for columns in [1, 2, 4, 8, 16, 32, 64] {
            let cell = |&[u, v]: &[f64; 2]| {
                assert!(
                    u + v != 1.0 && (0.0..1.0).contains(&u) && (0.0..1.0).contains(&v),
                    "{u}, {v}"
                );
                (
                    (u * f64::from(columns)) as usize,
                    (v * f64::from(64 / columns)) as usize,
                )
            };
            let cells: std::collections::BTreeSet<_> = points.iter().map(cell).collect();
            assert_eq!(cells.len(), 64, "{columns} columns");
        }
        let (mut seen, mut all) = (0.0, 0.0);
        for &random in points.iter() {
            let y = scene.emitters()[0].sample(random);
            let offset = y.point - x;
            let term = offset.z.max(0.0) * y.normal.dot(-offset).max(0.0)
                / offset.length_squared().powi(2);
            all += term;
            seen += if hides(y.point) { 0.0 } else { term };
        }
        assert!(0.2 * all < seen && seen < 0.8 * all, "{seen} of {all}");
        let relative: Vec<_> = outline.iter().map(|corner| corner - x).collect();
        let factor = polygon(
            DVec3::Z,
            Polygon::new(&relative).clip_to_horizon(DVec3::Z).corners(),
        );
        assert_relative_eq!(
            found.x,
            PI * factor * seen / all * radiance.x,
            max_relative = 1e-12
        );
        assert_relative_eq!((found / found.x).y, 2.0 / 3.0, max_relative = 1e-12);
    }
    // Nothing visible above the horizon means no irradiance.
    let dark = scene(|s| {
        square(s, 0.5, 0.0, true, diffuse(0.5));
        square(s, 0.5, -1.0, true, lamp(1.0));
    });
    let recorder = VisibilityRecorder::new(|_| false, false);
    let solved = solve_with(Parts::replaced(&recorder), &dark, 1);
    assert_eq!(
        irradiance(&solved, &dark, DVec3::ZERO, -DVec3::Z),
        DVec3::ZERO
    );
    // Points in the plane of a light, up to a billionth of the distance, receive nothing from it.
    let far = scene(|s| {
        square(s, 0.5, 0.0, true, diffuse(0.5));
        panel(
            s,
            DVec3::new(0.0, 5e3, 0.0),
            [1e4 * DVec3::Y, 1e4 * DVec3::Z],
            lamp(1e9),
        );
    });
    let solved = solve(&far, resolution(1, 0)).expect("a solution");
    for (distance, seen) in [(1e-6, false), (1e-4, true)] {
        let e = irradiance(&solved, &far, DVec3::new(distance, 0.0, 0.0), -DVec3::Z);
        assert_eq!(e.x > 1e-6, seen, "{e} at {distance}");
    }
}

/// The irradiance from a sphere is the sum of cos θ cos θ′ A/(πd²) over parts of equal area of its
/// patches; the visibility of a patch is tested at its brightest part. A far patch is one part, a
/// near one 8 × 8.
#[test]
fn the_light_of_a_sphere_is_that_of_its_parts() {
    let ball = between_heights(Sphere::new(DVec3::new(0.9, -0.8, 0.9), 0.95), [-0.3, 0.5]);
    let with = |surface| {
        scene(|s| {
            square(s, 0.5, -0.45, true, diffuse(0.5));
            crate::helpers::ball(s, ball, surface);
        })
    };
    let mesh =
        Mesh::new(&with(diffuse(0.5).emitting(DVec3::ONE)), resolution(50, 0)).expect("a mesh");
    let lights = mesh
        .elements()
        .iter()
        .filter(|element| element.emission != DVec3::ZERO);
    let patches: Vec<SpherePatch> = lights
        .filter_map(|element| match element.patch {
            Patch::Curved(patch) => Some(patch),
            Patch::Flat { .. } => None,
        })
        .collect();
    assert!(patches.len() > 20);
    let scene = with(lamp(2.0));
    let x = DVec3::new(-0.45, 0.4, -0.45);
    for (divides, side) in [(false, 1), (true, 8)] {
        let recorder = VisibilityRecorder::new(|y| y.x > 0.7, divides);
        let solved = solve_with(Parts::replaced(&recorder), &scene, 50);
        recorder.targets.lock().expect("no panic").clear();
        let found = irradiance(&solved, &scene, x, -DVec3::Z);
        let (mut expected, mut targets) = (0.0, Vec::new());
        for patch in &patches {
            let at = |[from, to]: [f64; 2], i: u32| {
                from + (to - from) * (f64::from(i) + 0.5) / f64::from(side)
            };
            let area = patch.radius.powi(2)
                * (patch.heights[0] - patch.heights[1]).abs()
                * (patch.azimuths[1] - patch.azimuths[0])
                / f64::from(side * side);
            let (mut sum, mut brightest) = (0.0, (0.0, DVec3::ZERO));
            for (i, j) in (0..side * side).map(|k| (k / side, k % side)) {
                let (z, turn) = (at(patch.heights, i), at(patch.azimuths, j));
                let normal = DVec3::new(
                    (1.0 - z * z).sqrt() * turn.cos(),
                    (1.0 - z * z).sqrt() * turn.sin(),
                    z,
                );
                let offset = ball.centre + ball.radius * normal - x;
                let cosines = offset.z.max(0.0) * normal.dot(-offset).max(0.0);
                let part = cosines / offset.length_squared().powi(2) * area / PI;
                sum += part;
                if part > brightest.0 {
                    brightest = (part, normal);
                }
            }
            if sum > 0.0 {
                let target = ball.centre + ball.radius * brightest.1;
                targets.push((target, brightest.1));
                expected += if target.x > 0.7 { 0.0 } else { sum };
            }
        }
        assert_relative_eq!(found.x, 2.0 * PI * expected, max_relative = 1e-12);
        let looked = recorder.targets.lock().expect("no panic");
        assert_eq!(looked.len(), targets.len());
        for (a, b) in looked.iter().zip(&targets) {
            assert!(
                a.point.distance(b.0) < 1e-12 && a.normal.distance(b.1) < 1e-12,
                "{a:?}, not {b:?}"
            );
        }
    }
    // Patches nearer than four times their side.
    for (area, near) in [(0.99, false), (1.0, false), (1.01, true)] {
        assert_eq!(
            [is_near(area, 16.0), DefaultParts.is_near(area, 16.0)],
            [near; 2],
            "{area}"
        );
    }
}
