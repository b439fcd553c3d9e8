//! Radiosity and form factors: closed forms, refusals, order of convergence, threads.

use std::sync::Mutex;

use whitefurnace::emitter::EmitterPoint;
use whitefurnace::equation;
use whitefurnace::estimator::FiniteElements;
use whitefurnace::estimator::radiosity::{
    FormFactors, MOST_MEMORY, Mesh, Patch, RESIDUAL, ReadOut, SpherePatch, check_memory, is_near,
};
use whitefurnace::form_factor::{Polygon, polygon};
use whitefurnace::frame::azimuth;

use crate::prelude::*;

fn fineness(patches: u32, halvings: u32) -> Fineness {
    Fineness { patches, halvings }
}

fn scene(parts: impl FnOnce(&mut SceneBuilder)) -> Scene {
    scene_from(Camera::new(DVec3::new(0.5, -2.0, 0.6), DVec3::ZERO, DVec3::Z, 0.5), parts)
}

fn solve(scene: &Scene, fineness: Fineness) -> Result<Radiosity, Error> {
    Radiosity::new(Standard, scene, fineness, &|_| true)
}

/// Parts of a polygon add up, its back is negative, and the cut leaves what is above.
#[test]
fn polygons_add_up_and_are_cut_at_the_horizon() {
    assert_eq!(equation::FORM_FACTOR.id, "form-factor");
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let whole = [at(1.0, -1.0, 0.2), at(1.0, -1.0, 2.0), at(1.5, 2.0, 2.5), at(1.5, 2.0, 0.4)];
    let [a, b, c, d] = whole;
    let f = polygon(DVec3::Z, &whole);
    assert!(f > 0.0);
    assert_abs_diff_eq!(f, polygon(DVec3::Z, &[a, b, c]) + polygon(DVec3::Z, &[a, c, d]), epsilon = 1e-15);
    assert_abs_diff_eq!(polygon(DVec3::Z, &[d, c, b, a]), -f, epsilon = 1e-15);
    // A hemisphere's worth: a huge square overhead.
    let sky = [[-1e6, -1e6], [-1e6, 1e6], [1e6, 1e6], [1e6, -1e6]].map(|[x, y]| at(x, y, 1.0));
    assert_abs_diff_eq!(polygon(DVec3::Z, &sky), 1.0, epsilon = 1e-10);

    let sunk = [at(1.0, -1.0, -1.0), at(1.0, -1.0, 1.0), at(1.0, 1.0, 1.0), at(1.0, 1.0, -1.0)];
    let seen = Polygon::new(&sunk).above(DVec3::Z);
    assert_eq!(seen.corners().len(), 4);
    let risen = [at(1.0, -1.0, 0.0), sunk[1], sunk[2], at(1.0, 1.0, 0.0)];
    assert_abs_diff_eq!(polygon(DVec3::Z, seen.corners()), polygon(DVec3::Z, &risen), epsilon = 1e-15);
    assert!(Polygon::new(&sunk).above(-DVec3::X).corners().is_empty());
    assert_eq!(Polygon::new(&sunk).above(DVec3::X), Polygon::new(&sunk));
}

#[test]
fn the_mesh_keeps_the_area_of_both_sides() {
    let scene = scene(|s| {
        ball(s, Sphere::new(DVec3::new(3.0, 0.0, 0.0), 1.5), diffuse(0.5));
        panel(s, DVec3::ZERO, [DVec3::X, 2.0 * DVec3::Y], diffuse(0.5));
        panel(s, DVec3::Z, [DVec3::X, DVec3::Y], Surface::new(Bsdf::Black));
    });
    let area = 2.0 * (4.0 * PI * 1.5 * 1.5 + 2.0);
    let mut before = 0;
    for halvings in 0..3 {
        let mesh = Mesh::new(&scene, fineness(60, halvings)).expect("a mesh");
        let sum: f64 = mesh.elements().iter().map(|e| e.area).sum();
        assert_abs_diff_eq!(sum, area, epsilon = 1e-10);
        let count = mesh.elements().len();
        assert!(before == 0 || count == 4 * before, "{before}, then {count}");
        before = count;
    }
}

/// A point sees a sphere under (R/d)²; the form factors of its patches add up to that.
#[test]
fn patches_of_a_sphere_add_up_to_its_form_factor() {
    let scene = scene(|s| {
        ball(s, Sphere::new(DVec3::new(0.0, 0.0, 3.0), 1.0), lamp(1.0));
        square(s, 0.01, 0.0, true, diffuse(0.25));
    });
    let solved = solve(&scene, fineness(1000, 0)).expect("a solution");
    let seen = solved.irradiances().map(|(_, e)| e.x / PI).filter(|&f| f > 0.0).collect::<Vec<_>>();
    assert_eq!(seen.len(), 2, "both triangles' fronts");
    for f in seen {
        assert_abs_diff_eq!(f, 1.0 / 9.0, epsilon = 5e-4);
    }
}

/// A room of surfaces of every kind with lights of every kind: triangles and rectangles, a ball, a zone of
/// a cavity, each reflecting on both sides.
fn medley() -> Scene {
    scene(|s| {
        let [pale, dark, red] = [0.7, 0.2, 0.5].map(|albedo| s.surface(diffuse(albedo)));
        let lamp = s.surface(diffuse(0.4).emitting(DVec3::new(3.0, 2.0, 1.0)));
        s.rectangle(DVec3::ZERO, [3.0 * DVec3::X, 2.0 * DVec3::Y], pale);
        s.rectangle(DVec3::ZERO, [2.0 * DVec3::Y, DVec3::new(0.3, 0.0, 2.0)], dark);
        let corners = [DVec3::new(0.5, 1.9, 0.1), DVec3::new(2.9, 1.8, 0.2), DVec3::new(1.0, 1.5, 1.8)];
        s.mesh(&corners, &[[0, 1, 2]], red);
        s.sphere(Sphere::new(DVec3::new(1.6, 0.7, 0.6), 0.5), red);
        let zone = Sphere { zone: [-0.2, 0.7], inward: true, ..Sphere::new(DVec3::new(1.5, 1.0, 1.2), 2.5) };
        s.sphere(zone, dark);
        s.rectangle(DVec3::new(0.6, 0.4, 2.2), [DVec3::Y, DVec3::new(0.8, 0.3, 0.1)], lamp);
        s.sphere(Sphere::new(DVec3::new(2.6, 0.4, 1.7), 0.2), lamp);
    })
}

/// The points at which the mean of a quadratic over a patch is exact: those next to a triangle's corners,
/// or Gauss's in height and azimuth of a sphere's patch.
fn nodes(patch: &Patch) -> Vec<DVec3> {
    match patch {
        Patch::Flat { polygon, .. } => {
            let [a, b, c] = [0, 1, 2].map(|i| polygon.corners()[i]);
            [(a, b, c), (b, c, a), (c, a, b)].map(|(near, p, q)| (4.0 * near + p + q) / 6.0).to_vec()
        }
        Patch::Curved(part) => {
            let gauss = [0.5 - 12f64.sqrt().recip(), 0.5 + 12f64.sqrt().recip()];
            let at = |[from, to]: [f64; 2], share: f64| from + share * (to - from);
            let place = |s, t| {
                let (z, turn) = (at(part.heights, s), at(part.azimuths, t));
                let rho = (1.0 - z * z).sqrt();
                part.centre + part.radius * DVec3::new(rho * turn.cos(), rho * turn.sin(), z)
            };
            gauss.iter().flat_map(|&s| gauss.map(|t| place(s, t))).collect()
        }
    }
}

/// At the nodes of every side of every patch, interpolation is what is gathered there: each point finds
/// its patch, side and node again. And the mean over a patch is that of its nodes.
#[test]
fn at_its_nodes_interpolation_is_exact() {
    let scene = medley();
    for (patches, halvings) in [(40, 0), (8, 1)] {
        let interpolated = solve(&scene, fineness(patches, halvings)).expect("a solution");
        let gathered = interpolated.clone().read(ReadOut::Gathered);
        let (mut compared, mut largest) = (0, 0.0_f64);
        for (element, mean) in interpolated.irradiances() {
            let mut sum = DVec3::ZERO;
            let points = nodes(&element.patch);
            for &point in &points {
                let normal = element.patch.normal(point);
                let ray = Ray::new(point + 1e-7 * normal, -normal);
                let hit = scene.intersect(&ray).expect("the patch");
                assert!((hit.point - point).length() < 1e-9, "{point} is hidden");
                let [a, b] = [&interpolated, &gathered].map(|solved| solved.irradiance(&scene, &ray, &hit));
                assert!((a - b).abs().max_element() < 1e-4, "{a}, not {b}, at {point}");
                sum += a;
                compared += 1;
                largest = largest.max(a.x);
            }
            let off = (sum / points.len() as f64 - mean).abs().max_element();
            assert!(off < 1e-4, "{mean} is not the mean of the nodes");
        }
        assert!(compared > 300 && largest > 1.0, "{compared}, {largest}");
    }
}

/// Of a triangle, and by Archimedes of a sphere between two heights and two meridians, of which the inner side faces the
/// centre.
#[test]
fn every_patch_has_its_own_area_and_side() {
    for element in Mesh::new(&medley(), fineness(60, 0)).expect("a mesh").elements() {
        let expected = match &element.patch {
            Patch::Flat { polygon, .. } => {
                let [a, b, c] = [0, 1, 2].map(|i| polygon.corners()[i]);
                0.5 * (b - a).cross(c - a).length()
            }
            Patch::Curved(part) => {
                let node = nodes(&element.patch)[0];
                let side = if part.outward { part.radius } else { -part.radius };
                let off = (element.patch.normal(node) * side).distance(node - part.centre);
                assert!(off < 1e-12, "the normal at {node} is off by {off}");
                let [height, turn] = [part.heights, part.azimuths].map(|[from, to]| (to - from).abs());
                part.radius * part.radius * height * turn
            }
        };
        assert_relative_eq!(element.area, expected, max_relative = 1e-12);
        assert!(element.area > 0.0);
    }
}

/// The irradiance where a ray along `direction` meets a surface at `point`.
fn irradiance<P>(solved: &Radiosity<P>, scene: &Scene, point: DVec3, direction: DVec3) -> DVec3
where
    P: FiniteElements + NextEvent + Scattering,
{
    let ray = Ray::new(point - 0.01 * direction, direction);
    solved.irradiance(scene, &ray, &scene.intersect(&ray).expect("a surface"))
}

/// Notes what is looked for, hides what `hides` says, and divides all of a sphere's patches or none.
struct Noted {
    hides: fn(DVec3) -> bool,
    divides: bool,
    points: Mutex<Vec<[f64; 2]>>,
    targets: Mutex<Vec<(DVec3, DVec3)>>,
}

impl Noted {
    fn new(hides: fn(DVec3) -> bool, divides: bool) -> Self {
        Self { hides, divides, points: Mutex::default(), targets: Mutex::default() }
    }
}

impl Scattering for &Noted {}

impl NextEvent for &Noted {
    fn sample_emitter(&self, emitter: &Emitter, random: [f64; 2]) -> EmitterPoint {
        self.points.lock().expect("no panic").push(random);
        emitter.sample(random)
    }
    fn visible(&self, _: &Scene, _: (DVec3, DVec3), y: (DVec3, DVec3), _: bool) -> bool {
        self.targets.lock().expect("no panic").push(y);
        !(self.hides)(y.0)
    }
}

impl FiniteElements for &Noted {
    fn is_near(&self, _: f64, _: f64) -> bool {
        self.divides
    }
}

/// What is seen of a flat light is looked for at 64 points of which each elementary interval of the square
/// holds one, and each counts by its geometry term.
#[test]
fn the_seen_share_of_a_light_is_that_of_its_geometry_terms() {
    let corner = DVec3::new(1.0, -1.0, -0.6);
    let edges = [DVec3::new(0.2, 0.3, 2.0), DVec3::new(-0.1, 2.2, 0.4)];
    let [a, b] = edges;
    let triangle = [corner, corner + a, corner + b];
    let radiance = DVec3::new(3.0, 2.0, 1.0);
    let outlines: [&[DVec3]; 2] = [&[corner, corner + a, corner + a + b, corner + b], &triangle];
    for (outline, flat) in outlines.into_iter().zip([false, true]) {
        let scene = scene(|s| {
            square(s, 0.5, 0.0, true, diffuse(0.5));
            let light = s.surface(Surface::new(Bsdf::Black).emitting(radiance));
            if flat { s.mesh(&triangle, &[[0, 1, 2]], light) } else { s.rectangle(corner, edges, light) }
        });
        let hides = |y: DVec3| y.y + y.z > 0.4;
        let noted = Noted::new(hides, false);
        let solved = Radiosity::new(&noted, &scene, fineness(1, 0), &|_| true).expect("a solution");
        noted.points.lock().expect("no panic").clear();
        let x = DVec3::new(0.1, 0.2, 0.0);
        let found = irradiance(&solved, &scene, x, -DVec3::Z);

        let points = noted.points.lock().expect("no panic");
        assert_eq!(points.len(), 64);
        for columns in [1, 2, 4, 8, 16, 32, 64] {
            let cell = |&[u, v]: &[f64; 2]| {
                assert!(u + v != 1.0 && (0.0..1.0).contains(&u) && (0.0..1.0).contains(&v), "{u}, {v}");
                ((u * f64::from(columns)) as usize, (v * f64::from(64 / columns)) as usize)
            };
            let cells: std::collections::BTreeSet<_> = points.iter().map(cell).collect();
            assert_eq!(cells.len(), 64, "{columns} columns");
        }
        let (mut seen, mut all) = (0.0, 0.0);
        for &random in points.iter() {
            let y = scene.emitters()[0].sample(random);
            let offset = y.point - x;
            let term = offset.z.max(0.0) * y.normal.dot(-offset).max(0.0) / offset.length_squared().powi(2);
            all += term;
            seen += if hides(y.point) { 0.0 } else { term };
        }
        assert!(0.2 * all < seen && seen < 0.8 * all, "{seen} of {all}");
        let relative: Vec<_> = outline.iter().map(|corner| corner - x).collect();
        let factor = polygon(DVec3::Z, Polygon::new(&relative).above(DVec3::Z).corners());
        assert_relative_eq!(found.x, PI * factor * seen / all * radiance.x, max_relative = 1e-12);
        assert_relative_eq!((found / found.x).y, 2.0 / 3.0, max_relative = 1e-12);
    }
    // Where nothing above the horizon is seen there is no share of it.
    let dark = scene(|s| {
        square(s, 0.5, 0.0, true, diffuse(0.5));
        square(s, 0.5, -1.0, true, lamp(1.0));
    });
    let noted = Noted::new(|_| false, false);
    let solved = Radiosity::new(&noted, &dark, fineness(1, 0), &|_| true).expect("a solution");
    assert_eq!(irradiance(&solved, &dark, DVec3::ZERO, -DVec3::Z), DVec3::ZERO);
    // Points in the plane of a light but for a billionth of the distance see nothing of it.
    let far = scene(|s| {
        square(s, 0.5, 0.0, true, diffuse(0.5));
        panel(s, DVec3::new(0.0, 5e3, 0.0), [1e4 * DVec3::Y, 1e4 * DVec3::Z], lamp(1e9));
    });
    let solved = solve(&far, fineness(1, 0)).expect("a solution");
    for (distance, seen) in [(1e-6, false), (1e-4, true)] {
        let e = irradiance(&solved, &far, DVec3::new(distance, 0.0, 0.0), -DVec3::Z);
        assert_eq!(e.x > 1e-6, seen, "{e} at {distance}");
    }
}

/// The light of a sphere is the sum of cos θ cos θ′ A/(πd²) over parts of equal area of its patches, each patch looked
/// for at its brightest part: one part that is far, 8 × 8 that are near.
#[test]
fn the_light_of_a_sphere_is_that_of_its_parts() {
    let ball = Sphere { zone: [-0.3, 0.5], ..Sphere::new(DVec3::new(0.9, -0.8, 0.9), 0.95) };
    let with = |surface| {
        scene(|s| {
            square(s, 0.5, -0.45, true, diffuse(0.5));
            crate::helpers::ball(s, ball, surface);
        })
    };
    let mesh = Mesh::new(&with(diffuse(0.5).emitting(DVec3::ONE)), fineness(50, 0)).expect("a mesh");
    let lights = mesh.elements().iter().filter(|element| element.emission != DVec3::ZERO);
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
        let noted = Noted::new(|y| y.x > 0.7, divides);
        let solved = Radiosity::new(&noted, &scene, fineness(50, 0), &|_| true).expect("a solution");
        noted.targets.lock().expect("no panic").clear();
        let found = irradiance(&solved, &scene, x, -DVec3::Z);
        let (mut expected, mut targets) = (0.0, Vec::new());
        for patch in &patches {
            let at = |[from, to]: [f64; 2], i: u32| from + (to - from) * (f64::from(i) + 0.5) / f64::from(side);
            let area = patch.radius.powi(2)
                * (patch.heights[0] - patch.heights[1]).abs()
                * (patch.azimuths[1] - patch.azimuths[0])
                / f64::from(side * side);
            let (mut sum, mut brightest) = (0.0, (0.0, DVec3::ZERO));
            for (i, j) in (0..side * side).map(|k| (k / side, k % side)) {
                let (z, turn) = (at(patch.heights, i), at(patch.azimuths, j));
                let normal = DVec3::new((1.0 - z * z).sqrt() * turn.cos(), (1.0 - z * z).sqrt() * turn.sin(), z);
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
        let looked = noted.targets.lock().expect("no panic");
        assert_eq!(looked.len(), targets.len());
        for (a, b) in looked.iter().zip(&targets) {
            assert!(a.0.distance(b.0) < 1e-12 && a.1.distance(b.1) < 1e-12, "{a:?}, not {b:?}");
        }
    }
    // What is nearer than four times its side.
    for (area, near) in [(0.99, false), (1.0, false), (1.01, true)] {
        assert_eq!([is_near(area, 16.0), Standard.is_near(area, 16.0)], [near; 2], "{area}");
    }
}

/// Every patch sends 1, and under the panel at [`CORNER`] points receive what `field` says: if that is linear on a
/// triangle or bilinear in height and azimuth on a sphere, interpolation between nodes is exact, on edges and at poles
/// as well.
#[derive(Clone)]
struct Field<F>(F);

const CORNER: DVec3 = DVec3::new(-0.05, -0.05, 2.0);

impl<F: Sync> Scattering for Field<F> {}

impl<F: Sync> NextEvent for Field<F> {
    fn visible(&self, _: &Scene, _: (DVec3, DVec3), (y, normal): (DVec3, DVec3), _: bool) -> bool {
        y.z > 1.5 && normal.z < 0.0
    }
}

impl<F: Fn(DVec3) -> f64 + Sync> FiniteElements for Field<F> {
    fn horizon(&self, _: DVec3, polygon: &Polygon) -> Polygon {
        *polygon
    }
    fn form_factor(&self, _: DVec3, corners: &[DVec3]) -> f64 {
        self.0(CORNER - corners[0])
    }
    fn exchanged(&self, _: DVec3, _: DVec3) -> DVec3 {
        DVec3::ONE
    }
}

#[test]
fn interpolation_between_nodes_is_exact_for_what_is_linear() {
    let corners = [DVec3::new(-1.0, -0.8, 0.0), DVec3::new(1.2, -0.5, 0.0), DVec3::new(0.1, 0.9, 0.0)];
    let whole = Sphere::new(DVec3::new(0.0, 0.1, 0.2), 0.8);
    let zone = Sphere { zone: [-0.5, 0.3], ..whole };
    // How often a triangle, or else a sphere, is divided; whether what it receives depends on azimuth.
    for (patches, sphere, turns) in [
        (1, None, 0.0),
        (7, None, 0.0),
        (30, None, 0.0),
        (1, Some(whole), 0.0),
        (1, Some(whole), 0.5),
        (40, Some(whole), 0.5),
        (40, Some(zone), 0.5),
    ] {
        let scene = scene(|s| {
            let pale = s.surface(diffuse(0.5));
            s.rectangle(CORNER, [0.1 * DVec3::Y, 0.1 * DVec3::X], pale);
            match sphere {
                Some(sphere) => s.sphere(sphere, pale),
                None => s.mesh(&corners, &[[0, 1, 2]], pale),
            }
        });
        let field = |x: DVec3| match sphere {
            Some(sphere) => {
                let [z, turn] = [(x - sphere.centre).z, azimuth(x - sphere.centre)];
                3.0 + z + turns * (turn + 0.4 * z * turn)
            }
            None => 3.0 + x.x + 0.7 * x.y,
        };
        let interpolated = Radiosity::new(Field(field), &scene, fineness(patches, 0), &|_| true).expect("a solution");
        let gathered = interpolated.clone().read(ReadOut::Gathered);
        for (i, j) in (0..13 * 13).map(|k| (k / 13, k % 13)) {
            let [u, v] = [i, j].map(|k| f64::from(k) / 12.0);
            let (point, normal) = match sphere {
                // Poles have no azimuth.
                Some(_) if turns != 0.0 && (i == 0 || i == 12) => continue,
                Some(sphere) => {
                    let turn = TAU * (f64::from(j) + 0.5) / 13.0;
                    let [low, high] = sphere.heights().map(|z| z / sphere.radius);
                    let z = low + (high - low) * u;
                    let rho = (1.0 - z * z).sqrt();
                    let normal = DVec3::new(rho * turn.cos(), rho * turn.sin(), z);
                    (sphere.centre + sphere.radius * normal, normal)
                }
                None if i + j > 12 => continue,
                None => (corners[0] + u * (corners[1] - corners[0]) + v * (corners[2] - corners[0]), DVec3::Z),
            };
            for side in [1.0, -1.0] {
                let ray = Ray::new(point + 0.1 * side * normal, -side * normal);
                let hit = Hit { t: 0.1, point, normal, primitive: 2, surface: 0, emitter: None };
                let [found, expected] =
                    [&interpolated, &gathered].map(|solved| solved.irradiance(&scene, &ray, &hit).x);
                assert!(expected > 1.0);
                assert_relative_eq!(found, expected, max_relative = 1e-6);
            }
        }
    }
}

/// F between two flat patches that see each other, by the nodes of one.
#[test]
fn form_factors_of_elements_are_those_of_their_nodes() {
    let scene = furnace(0.5);
    let mesh = Mesh::new(&scene, fineness(1, 0)).expect("a mesh");
    let factors = FormFactors::new(&Standard, &scene, &mesh, &|_| true).expect("form factors");
    let elements = mesh.elements();
    assert_eq!((elements.len(), mesh.nodes()), (24, 72));
    for (i, element) in elements.iter().enumerate() {
        let row = factors.of_element(&mesh, i);
        for (other, found) in elements.iter().zip(&row) {
            let Patch::Flat { polygon: whole, normal } = &other.patch else {
                panic!("a triangle");
            };
            let points = nodes(&element.patch);
            let mean = points.iter().map(|x| {
                let own = element.patch.normal(*x);
                let relative = whole.corners().iter().map(|corner| corner - x).collect::<Vec<_>>();
                // The cube is convex: its insides see all of each other but their own plane.
                let faces = element.emission != DVec3::ZERO && other.emission != DVec3::ZERO && *normal != own;
                if faces { polygon(own, &relative) } else { 0.0 }
            });
            assert_abs_diff_eq!(*found, mean.sum::<f64>() / 3.0, epsilon = 1e-7);
        }
        let closed = f64::from(u8::from(element.emission != DVec3::ZERO));
        assert_abs_diff_eq!(row.iter().sum::<f64>(), closed, epsilon = 1e-6);
    }
}

/// E = E_direct + π Σ F ρE/π of every patch and channel: what arrives from emitters is what arrives if
/// surfaces reflect all but nothing.
#[test]
fn irradiances_solve_the_equation_by_hand() {
    let emitted = DVec3::new(0.5, 0.25, 0.0);
    let with = |albedos: [DVec3; 2], light: f64| {
        scene(|s| {
            let [a, b] = albedos.map(|albedo| Surface::new(Bsdf::Lambert { albedo }));
            square(s, 0.5, 0.0, true, a.emitting(light * emitted));
            square(s, 0.5, 0.4, false, b);
            panel(s, DVec3::new(0.6, -0.5, 0.1), [0.2 * DVec3::Z, DVec3::Y], lamp(2.0 * light));
        })
    };
    let albedos = [DVec3::new(0.9, 0.5, 0.2), DVec3::new(0.3, 0.8, 0.0)];
    let scene = with(albedos, 1.0);
    let solved = solve(&scene, fineness(8, 0)).expect("a solution");
    let mesh = Mesh::new(&scene, fineness(8, 0)).expect("a mesh");
    let factors = FormFactors::new(&Standard, &scene, &mesh, &|_| true).expect("form factors");
    let direct = solve(&with([DVec3::splat(1e-30); 2], 1.0), fineness(8, 0)).expect("a solution");
    assert!((1..5).contains(&direct.sweeps()) && solved.sweeps() > 5, "{}, {}", direct.sweeps(), solved.sweeps());
    assert!(0.0 < solved.residual() && solved.residual() < RESIDUAL, "{}", solved.residual());
    let reflected: Vec<_> = solved.irradiances().map(|(element, e)| element.albedo * e).collect();
    for (i, ((_, e), (_, direct))) in solved.irradiances().zip(direct.irradiances()).enumerate() {
        let row = factors.of_element(&mesh, i);
        let arriving: DVec3 = row.iter().zip(&reflected).map(|(f, reflected)| *f * reflected).sum();
        assert!((direct + arriving - e).abs().max_element() < 1e-5, "{e}, not {direct} + {arriving}");
    }
    assert!(reflected.iter().any(|e| e.z > 0.1));
    // Between nodes: gathered by hand, and interpolated nearly that.
    let x = DVec3::new(0.13, -0.21, 0.0);
    let mut arriving = irradiance(&direct, &scene, x, -DVec3::Z);
    for (element, reflected) in mesh.elements().iter().zip(&reflected) {
        if let Patch::Flat { polygon: whole, normal } = &element.patch
            && normal.z < -0.9
            && whole.corners()[0].z > 0.0
        {
            let relative: Vec<_> = whole.corners().iter().map(|corner| corner - x).collect();
            arriving += polygon(DVec3::Z, &relative) * reflected;
        }
    }
    let gathered = irradiance(&solved.clone().read(ReadOut::Gathered), &scene, x, -DVec3::Z);
    let interpolated = irradiance(&solved, &scene, x, -DVec3::Z);
    assert!((gathered - arriving).abs().max_element() < 1e-5, "{gathered}, not {arriving}");
    let off = (interpolated - gathered).abs().max_element();
    assert!(1e-4 < off && off < 0.1, "{off}");
    let ray = Ray::new(x + 0.1 * DVec3::Z, -DVec3::Z);
    let radiance = solved.radiance(&scene, &ray, scene.intersect(&ray), &mut rng("radiosity"));
    assert!((radiance - emitted - albedos[0] * interpolated / PI).abs().max_element() < 1e-12, "{radiance}");
    // A residual is relative.
    let bright = solve(&with(albedos, 1024.0), fineness(8, 0)).expect("a solution");
    assert_eq!((bright.residual(), bright.sweeps()), (solved.residual(), solved.sweeps()));
    // No light is a solution as well.
    let dark = crate::helpers::scene(|s| square(s, 0.5, 0.0, true, diffuse(0.5)));
    let solved = solve(&dark, fineness(1, 0)).expect("a solution");
    assert_eq!((solved.residual(), solved.sweeps()), (0.0, 1));
    assert!(solved.irradiances().all(|(_, e)| e == DVec3::ZERO));
}

/// Bands and columns are as few as may be if none is wider than was aimed at.
#[test]
fn patches_are_about_as_large_as_was_aimed_at() {
    let zone = Sphere { zone: [-0.4, 1.3], ..Sphere::new(DVec3::new(0.0, 0.0, 3.0), 1.5) };
    for (sphere, patches) in [(zone, 300), (Sphere::new(DVec3::ZERO, 0.7), 500), (zone, 3)] {
        let scene = scene(|s| ball(s, sphere, diffuse(0.5)));
        let side = (sphere.area() / f64::from(patches)).sqrt();
        let mut bands: Vec<Vec<SpherePatch>> = Vec::new();
        for element in Mesh::new(&scene, fineness(patches, 0)).expect("a mesh").elements() {
            let Patch::Curved(patch) = element.patch else {
                panic!("part of a sphere");
            };
            if !patch.outward {
                break;
            }
            match bands.last_mut().filter(|band| band[0].heights == patch.heights) {
                Some(band) => {
                    assert_eq!(band[band.len() - 1].azimuths[1], patch.azimuths[0]);
                    band.push(patch);
                }
                None => {
                    let end = bands.last().map_or(sphere.heights()[1] / sphere.radius, |band| band[0].heights[1]);
                    assert_abs_diff_eq!(end, patch.heights[0], epsilon = 1e-15);
                    bands.push(vec![patch]);
                }
            }
        }
        let about = |width: f64, least: usize, count: usize| {
            assert!(count >= least && width <= side * (1.0 + 1e-12), "{width} is more than {side}");
            let fewer = width * count as f64 / (count - 1) as f64;
            assert!(count == least || fewer > side, "{count} of {width}, not {side}");
        };
        for band in &bands {
            let [top, bottom] = band[0].heights.map(f64::acos);
            about(sphere.radius * (bottom - top), 2, bands.len());
            let around = sphere.radius * (0.5 * (top + bottom)).sin() * TAU;
            about(around / band.len() as f64, 3, band.len());
            assert_eq!(band[0].azimuths[0], 0.0);
            assert_relative_eq!(band[band.len() - 1].azimuths[1], TAU, max_relative = 1e-15);
        }
    }
}

#[test]
fn the_solution_satisfies_its_equation_and_converges() {
    let solved = solve(&furnace(0.9), fineness(40, 0)).expect("a solution");
    assert!(solved.residual() <= RESIDUAL && solved.sweeps() > 2);
    for (element, irradiance) in solved.irradiances() {
        let inside = irradiance != DVec3::ZERO;
        let expected = if inside { 10.0 * PI } else { 0.0 };
        assert_abs_diff_eq!(irradiance.x, expected, epsilon = 1e-3);
        assert_eq!(inside, element.emission != DVec3::ZERO);
    }
}

/// The mean irradiance of a floor under a light, both with a wall beside them: differences fall by four
/// or more as patches are halved.
#[test]
fn halving_patches_divides_the_error_by_four() {
    let scene = scene(|s| {
        panel(s, DVec3::ZERO, [DVec3::X, DVec3::Y], diffuse(0.5));
        panel(s, DVec3::new(-0.2, 0.0, 0.1), [DVec3::Y, DVec3::Z], diffuse(0.5));
        panel(s, DVec3::new(0.2, 0.2, 1.0), [0.6 * DVec3::Y, 0.6 * DVec3::X], lamp(1.0));
    });
    let flux = |halvings| {
        let solved = solve(&scene, fineness(8, halvings)).expect("a solution");
        solved.irradiances().map(|(e, irradiance)| e.area * irradiance.x).sum::<f64>()
    };
    let [a, b, c] = [0, 1, 2].map(flux);
    let order = ((a - b) / (b - c)).abs().log2();
    assert!(order > 1.5, "order {order:.2} from {a}, {b}, {c}");
}

#[test]
fn what_it_cannot_do_is_refused_in_one_line() {
    let refused = |scene: &Scene, fineness, hint: &str| {
        let message = solve(scene, fineness).expect_err("refused").to_string();
        assert!(message.contains(hint) && !message.contains('\n'), "{message}");
    };
    let default = Fineness::default();
    refused(&report_room(), default, "mirrors");
    refused(&scene(|s| square(s, 1.0, 0.0, true, glass(1.5))), default, "glass");
    let rough = Surface::new(Bsdf::OrenNayar {
        albedo: DVec3::ONE,
        constants: OrenNayar::new(0.5),
        form: OrenNayarForm::Corrected,
    });
    refused(&scene(|s| square(s, 1.0, 0.0, true, rough)), default, "rough surfaces");
    refused(&simple::glass_cube(false).expect("a scene"), default, "background");
    let cube = furnace(0.5);
    refused(&cube, fineness(0, 0), "at least one");
    refused(&cube, fineness(2, 9), "at most 8 halvings");
    refused(&cube, fineness(2, 8), "of 131072 patches take up to 64.0 GiB of memory, more than 3.0");
    refused(&cube, fineness(1_000_000, 0), "of 1000000 patches take up to 3725.3 GiB");
    refused(&furnace(1.0), fineness(12, 0), "settle");
    // So bright that sums overflow, and what a black channel reflects of them is no number.
    let plates = [DVec3::splat(0.9), DVec3::new(0.9, 0.9, 0.0)];
    let plates = plates.map(|albedo| Surface::new(Bsdf::Lambert { albedo }).emitting(DVec3::splat(1e308)));
    refused(
        &scene(|s| {
            square(s, 9.0, 0.0, true, plates[0]);
            square(s, 9.0, 0.1, false, plates[1]);
        }),
        fineness(1, 0),
        "settle",
    );
    assert!(matches!(Radiosity::new(Standard, &cube, default, &|_| false), Err(Error::Interrupted)));
}

/// Three nodes and one element of each patch's side, and eight bytes of each pair of them.
#[test]
fn meshes_are_refused_beyond_their_memory() {
    let scene = scene(|s| {
        let pale = s.surface(diffuse(0.5));
        let far = DVec3::new(7.0, -3.0, 2.0);
        s.mesh(&[far, far + DVec3::X, far + DVec3::Y], &[[0, 1, 2]], pale);
    });
    for parts in [107_u64, 108] {
        // A triangle is divided into a square number of parts, of at least as many.
        let mesh = Mesh::new(&scene, fineness((parts * parts) as u32 - 9, 0)).expect("a mesh");
        let patches = parts * parts;
        assert_eq!((mesh.elements().len() as u64, mesh.nodes() as u64), (2 * patches, 6 * patches));
        assert_eq!(check_memory(&mesh).is_ok(), 24 * patches * patches <= MOST_MEMORY, "{parts}");
    }
}

#[test]
fn threads_change_nothing() {
    let scene = simple::cornell().expect("a scene");
    let solved = |threads| {
        on_threads(threads, || {
            let solved = solve(&scene, fineness(100, 0)).expect("a solution");
            solved.irradiances().map(|(_, e)| e.to_array().map(f64::to_bits)).collect::<Vec<_>>()
        })
    };
    assert!(solved(1) == solved(3));
}
