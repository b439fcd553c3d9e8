//! Tests of patches: their areas, sides, sizes and form factors.

use super::*;

/// Form factors of parts of a polygon add up, that of its back is negative, and clipping leaves the
/// part above the horizon.
#[test]
fn polygons_add_up_and_are_cut_at_the_horizon() {
    assert_eq!(equation::FORM_FACTOR.id, "form-factor");
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let whole = [
        at(1.0, -1.0, 0.2),
        at(1.0, -1.0, 2.0),
        at(1.5, 2.0, 2.5),
        at(1.5, 2.0, 0.4),
    ];
    let [a, b, c, d] = whole;
    let f = polygon(DVec3::Z, &whole);
    assert!(f > 0.0);
    assert_abs_diff_eq!(
        f,
        polygon(DVec3::Z, &[a, b, c]) + polygon(DVec3::Z, &[a, c, d]),
        epsilon = 1e-15
    );
    assert_abs_diff_eq!(polygon(DVec3::Z, &[d, c, b, a]), -f, epsilon = 1e-15);
    // A huge square overhead fills the hemisphere.
    let sky = [[-1e6, -1e6], [-1e6, 1e6], [1e6, 1e6], [1e6, -1e6]].map(|[x, y]| at(x, y, 1.0));
    assert_abs_diff_eq!(polygon(DVec3::Z, &sky), 1.0, epsilon = 1e-10);

    let sunk = [
        at(1.0, -1.0, -1.0),
        at(1.0, -1.0, 1.0),
        at(1.0, 1.0, 1.0),
        at(1.0, 1.0, -1.0),
    ];
    let seen = Polygon::new(&sunk).clip_to_horizon(DVec3::Z);
    assert_eq!(seen.corners().len(), 4);
    let risen = [at(1.0, -1.0, 0.0), sunk[1], sunk[2], at(1.0, 1.0, 0.0)];
    assert_abs_diff_eq!(
        polygon(DVec3::Z, seen.corners()),
        polygon(DVec3::Z, &risen),
        epsilon = 1e-15
    );
    assert!(
        Polygon::new(&sunk)
            .clip_to_horizon(-DVec3::X)
            .corners()
            .is_empty()
    );
    assert_eq!(
        Polygon::new(&sunk).clip_to_horizon(DVec3::X),
        Polygon::new(&sunk)
    );
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
        let mesh = Mesh::new(&scene, resolution(60, halvings)).expect("a mesh");
        let sum: f64 = mesh.elements().iter().map(|e| e.area).sum();
        assert_abs_diff_eq!(sum, area, epsilon = 1e-10);
        let count = mesh.elements().len();
        assert!(before == 0 || count == 4 * before, "{before}, then {count}");
        before = count;
    }
}

/// From a point a sphere has the form factor (R/d)²; those of its patches add up to that.
#[test]
fn patches_of_a_sphere_add_up_to_its_form_factor() {
    let scene = scene(|s| {
        ball(s, Sphere::new(DVec3::new(0.0, 0.0, 3.0), 1.0), lamp(1.0));
        square(s, 0.01, 0.0, true, diffuse(0.25));
    });
    let solved = solve(&scene, resolution(1000, 0)).expect("a solution");
    let seen = solved
        .irradiances()
        .map(|(_, e)| e.x / PI)
        .filter(|&f| f > 0.0)
        .collect::<Vec<_>>();
    assert_eq!(seen.len(), 2, "both triangles' fronts");
    for f in seen {
        assert_abs_diff_eq!(f, 1.0 / 9.0, epsilon = 5e-4);
    }
}

/// Every patch has its own area and side: of a triangle, and, by Archimedes' theorem, of a sphere
/// between two heights and two meridians, whose inner side faces the centre.
#[test]
fn every_patch_has_its_own_area_and_side() {
    for element in Mesh::new(&room_of_all_shapes(), resolution(60, 0))
        .expect("a mesh")
        .elements()
    {
        let expected = match &element.patch {
            Patch::Flat { polygon, .. } => {
                let [a, b, c] = [0, 1, 2].map(|i| polygon.corners()[i]);
                0.5 * (b - a).cross(c - a).length()
            }
            Patch::Curved(part) => {
                let node = nodes(&element.patch)[0];
                let side = if part.outward {
                    part.radius
                } else {
                    -part.radius
                };
                let off = (element.patch.normal(node) * side).distance(node - part.centre);
                assert!(off < 1e-12, "the normal at {node} is off by {off}");
                let [height, turn] =
                    [part.heights, part.azimuths].map(|[from, to]| (to - from).abs());
                part.radius * part.radius * height * turn
            }
        };
        assert_relative_eq!(element.area, expected, max_relative = 1e-12);
        assert!(element.area > 0.0);
    }
}

/// Bands and columns are as few as possible with none wider than the target.
#[test]
fn patches_are_about_as_large_as_was_aimed_at() {
    let zone = between_heights(Sphere::new(DVec3::new(0.0, 0.0, 3.0), 1.5), [-0.4, 1.3]);
    for (sphere, patches) in [(zone, 300), (Sphere::new(DVec3::ZERO, 0.7), 500), (zone, 3)] {
        let scene = scene(|s| ball(s, sphere, diffuse(0.5)));
        let side = (sphere.area() / f64::from(patches)).sqrt();
        let mut bands: Vec<Vec<SpherePatch>> = Vec::new();
        for element in Mesh::new(&scene, resolution(patches, 0))
            .expect("a mesh")
            .elements()
        {
            let Patch::Curved(patch) = element.patch else {
                panic!("part of a sphere");
            };
            if !patch.outward {
                break;
            }
            match bands
                .last_mut()
                .filter(|band| band[0].heights == patch.heights)
            {
                Some(band) => {
                    assert_eq!(band[band.len() - 1].azimuths[1], patch.azimuths[0]);
                    band.push(patch);
                }
                None => {
                    let end = bands
                        .last()
                        .map_or(sphere.heights()[1] / sphere.radius, |band| {
                            band[0].heights[1]
                        });
                    assert_abs_diff_eq!(end, patch.heights[0], epsilon = 1e-15);
                    bands.push(vec![patch]);
                }
            }
        }
        let about = |width: f64, least: usize, count: usize| {
            assert!(
                count >= least && width <= side * (1.0 + 1e-12),
                "{width} is more than {side}"
            );
            let fewer = width * count as f64 / (count - 1) as f64;
            assert!(
                count == least || fewer > side,
                "{count} of {width}, not {side}"
            );
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
