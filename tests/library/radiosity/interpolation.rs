//! Tests of interpolation between the nodes of a patch, and of form factors by nodes.

use whitefurnace::math::frame::azimuth;

use super::*;

/// At the nodes of every side of every patch, interpolation equals what is gathered there: each
/// point finds its patch, side and node again. The mean over a patch is that of its nodes.
#[test]
fn at_its_nodes_interpolation_is_exact() {
    let scene = room_of_all_shapes();
    for (patches, halvings) in [(40, 0), (8, 1)] {
        let interpolated = solve(&scene, resolution(patches, halvings)).expect("a solution");
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
                let [a, b] =
                    [&interpolated, &gathered].map(|solved| solved.irradiance(&scene, &ray, &hit));
                assert!(
                    (a - b).abs().max_element() < 1e-4,
                    "{a}, not {b}, at {point}"
                );
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

/// Every patch sends 1, and under the panel at [`CORNER`] points receive the values of the field:
/// if that is linear on a triangle or bilinear in height and azimuth on a sphere, interpolation
/// between nodes is exact, on edges and at poles as well.
#[derive(Clone)]
struct Field<F>(F);

const CORNER: DVec3 = DVec3::new(-0.05, -0.05, 2.0);

impl<F: Sync> Scattering for Field<F> {}
impl<F: Sync> Roulette for Field<F> {}
impl<F: Sync> Photons for Field<F> {}
impl<F: Sync> Bidirectional for Field<F> {}

impl<F: Sync> NextEvent for Field<F> {
    fn visible(&self, _: &Scene, _: SurfacePoint, y: SurfacePoint, _: bool) -> bool {
        y.point.z > 1.5 && y.normal.z < 0.0
    }
}

impl<F: Fn(DVec3) -> f64 + Sync> FiniteElements for Field<F> {
    fn clip_to_horizon(&self, _: DVec3, polygon: &Polygon) -> Polygon {
        *polygon
    }
    fn form_factor(&self, _: DVec3, corners: &[DVec3]) -> f64 {
        self.0(CORNER - corners[0])
    }
    fn reflected(&self, _: DVec3, _: DVec3) -> DVec3 {
        DVec3::ONE
    }
}

#[test]
fn interpolation_between_nodes_is_exact_for_what_is_linear() {
    let corners = [
        DVec3::new(-1.0, -0.8, 0.0),
        DVec3::new(1.2, -0.5, 0.0),
        DVec3::new(0.1, 0.9, 0.0),
    ];
    let whole = Sphere::new(DVec3::new(0.0, 0.1, 0.2), 0.8);
    let zone = between_heights(whole, [-0.5, 0.3]);
    // Number of patches of a triangle, or else of a sphere; whether the field depends on azimuth.
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
        let parts = Field(field);
        let interpolated = solve_with(Parts::replaced(&parts), &scene, patches);
        let gathered = interpolated.clone().read(ReadOut::Gathered);
        for (i, j) in (0..13 * 13).map(|k| (k / 13, k % 13)) {
            let [u, v] = [i, j].map(|k| f64::from(k) / 12.0);
            let (point, normal) = match sphere {
                // The azimuth is undefined at poles.
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
                None => (
                    corners[0] + u * (corners[1] - corners[0]) + v * (corners[2] - corners[0]),
                    DVec3::Z,
                ),
            };
            for side in [1.0, -1.0] {
                let ray = Ray::new(point + 0.1 * side * normal, -side * normal);
                let hit = Hit {
                    t: 0.1,
                    point,
                    normal,
                    primitive: 2,
                    surface: 0,
                    emitter: None,
                };
                let [found, expected] = [&interpolated, &gathered]
                    .map(|solved| solved.irradiance(&scene, &ray, &hit).x);
                assert!(expected > 1.0);
                assert_relative_eq!(found, expected, max_relative = 1e-6);
            }
        }
    }
}

/// The form factor between two flat patches that see each other equals that of the nodes of one.
#[test]
fn form_factors_of_elements_are_those_of_their_nodes() {
    let scene = furnace(0.5);
    let mesh = Mesh::new(&scene, resolution(1, 0)).expect("a mesh");
    let factors =
        FormFactors::new(Parts::default(), &scene, &mesh, &|_| true).expect("form factors");
    let elements = mesh.elements();
    assert_eq!((elements.len(), mesh.nodes()), (24, 72));
    for (i, element) in elements.iter().enumerate() {
        let row = factors.of_element(&mesh, i);
        for (other, found) in elements.iter().zip(&row) {
            let Patch::Flat {
                polygon: whole,
                normal,
            } = &other.patch
            else {
                panic!("a triangle");
            };
            let points = nodes(&element.patch);
            let mean = points.iter().map(|x| {
                let own = element.patch.normal(*x);
                let relative = whole
                    .corners()
                    .iter()
                    .map(|corner| corner - x)
                    .collect::<Vec<_>>();
                // The cube is convex: each inner side sees all others outside its own plane.
                let faces = element.emission != DVec3::ZERO
                    && other.emission != DVec3::ZERO
                    && *normal != own;
                if faces { polygon(own, &relative) } else { 0.0 }
            });
            assert_abs_diff_eq!(*found, mean.sum::<f64>() / 3.0, epsilon = 1e-7);
        }
        let closed = f64::from(u8::from(element.emission != DVec3::ZERO));
        assert_abs_diff_eq!(row.iter().sum::<f64>(), closed, epsilon = 1e-6);
    }
}
