//! Radiosity and form factors: closed forms, refusals, order of convergence, threads.

use whitefurnace::equation;
use whitefurnace::estimator::radiosity::{FormFactors, Mesh, Patch, RESIDUAL, ReadOut};
use whitefurnace::form_factor::{Polygon, polygon};

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
        ball(s, Sphere::new(DVec3::new(0.0, 0.0, 3.0), 1.0), diffuse(0.5));
        square(s, 0.01, 0.0, true, diffuse(0.25));
    });
    let mesh = Mesh::new(&scene, fineness(1000, 0)).expect("a mesh");
    let factors = FormFactors::new(&Standard, &scene, &mesh, &|_| true).expect("form factors");
    let floor = |albedo: f64| albedo == 0.25;
    let seen: Vec<f64> = (0..mesh.elements().len())
        .filter(|&i| floor(mesh.elements()[i].albedo.x))
        .map(|i| factors.of_element(&mesh, i).iter().sum())
        .collect();
    assert_eq!(seen.iter().filter(|&&f| f > 0.0).count(), 2, "both triangles' fronts");
    for f in seen.iter().filter(|&&f| f > 0.0) {
        assert_abs_diff_eq!(*f, 1.0 / 9.0, epsilon = 5e-4);
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
    for halvings in [0, 1] {
        let [interpolated, gathered] = [ReadOut::Interpolated, ReadOut::Gathered]
            .map(|way| solve(&scene, fineness(40, halvings)).expect("a solution").read(way));
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

/// Of a triangle, and by Archimedes of a sphere between two heights and two meridians.
#[test]
fn every_patch_has_its_own_area() {
    for element in Mesh::new(&medley(), fineness(60, 0)).expect("a mesh").elements() {
        let expected = match &element.patch {
            Patch::Flat { polygon, .. } => {
                let [a, b, c] = [0, 1, 2].map(|i| polygon.corners()[i]);
                0.5 * (b - a).cross(c - a).length()
            }
            Patch::Curved(part) => {
                let [height, turn] = [part.heights, part.azimuths].map(|[from, to]| (to - from).abs());
                part.radius * part.radius * height * turn
            }
        };
        assert_relative_eq!(element.area, expected, max_relative = 1e-12);
        assert!(element.area > 0.0);
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
    refused(&simple::glass_cube(false).expect("a scene"), default, "background");
    let cube = furnace(0.5);
    refused(&cube, fineness(0, 0), "at least one");
    refused(&cube, fineness(1_000_000, 0), "memory");
    refused(&furnace(1.0), fineness(12, 0), "settle");
    assert!(matches!(Radiosity::new(Standard, &cube, default, &|_| false), Err(Error::Interrupted)));
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
