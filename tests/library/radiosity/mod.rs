//! Tests of radiosity: the equation, its order of convergence, refusals, threads; and shared
//! helpers.

mod direct; // irradiance from lights
mod interpolation; // between the nodes of a patch
mod mesh; // patches and form factors

use whitefurnace::equation;
use whitefurnace::geometry::form_factor::{Polygon, polygon};
use whitefurnace::integrator::radiosity::{
    FormFactors, MAX_MEMORY, Mesh, Patch, RESIDUAL, ReadOut, SpherePatch, check_memory, is_near,
};
use whitefurnace::light::emitter::EmitterPoint;

use crate::prelude::*;

fn scene(parts: impl FnOnce(&mut SceneBuilder)) -> Scene {
    scene_from(
        Camera::new(DVec3::new(0.5, -2.0, 0.6), DVec3::ZERO, DVec3::Z, 0.5),
        parts,
    )
}

fn solve(scene: &Scene, resolution: MeshResolution) -> Result<Radiosity<'static>, Error> {
    Radiosity::new(Parts::default(), scene, resolution, &|_| true)
}

/// Solves for this number of patches with replaced parts.
fn solve_with<'a>(parts: Parts<'a>, scene: &Scene, patches: u32) -> Radiosity<'a> {
    Radiosity::new(parts, scene, resolution(patches, 0), &|_| true).expect("a solution")
}

/// Returns a room of surfaces of every kind with lights of every kind: triangles and rectangles, a
/// ball, a zone of a cavity, each reflecting on both sides.
fn room_of_all_shapes() -> Scene {
    scene(|s| {
        let [pale, dark, red] = [0.7, 0.2, 0.5].map(|albedo| s.surface(diffuse(albedo)));
        let lamp = s.surface(diffuse(0.4).emitting(DVec3::new(3.0, 2.0, 1.0)));
        s.rectangle(DVec3::ZERO, [3.0 * DVec3::X, 2.0 * DVec3::Y], pale);
        s.rectangle(
            DVec3::ZERO,
            [2.0 * DVec3::Y, DVec3::new(0.3, 0.0, 2.0)],
            dark,
        );
        let corners = [
            DVec3::new(0.5, 1.9, 0.1),
            DVec3::new(2.9, 1.8, 0.2),
            DVec3::new(1.0, 1.5, 1.8),
        ];
        s.mesh(&corners, &[[0, 1, 2]], red);
        s.sphere(Sphere::new(DVec3::new(1.6, 0.7, 0.6), 0.5), red);
        let zone = inward(between_heights(
            Sphere::new(DVec3::new(1.5, 1.0, 1.2), 2.5),
            [-0.2, 0.7],
        ));
        s.sphere(zone, dark);
        s.rectangle(
            DVec3::new(0.6, 0.4, 2.2),
            [DVec3::Y, DVec3::new(0.8, 0.3, 0.1)],
            lamp,
        );
        s.sphere(Sphere::new(DVec3::new(2.6, 0.4, 1.7), 0.2), lamp);
    })
}

/// Returns the points at which the mean of a quadratic over a patch is exact: those next to a
/// triangle's corners, or Gauss's in height and azimuth of a sphere's patch.
fn nodes(patch: &Patch) -> Vec<DVec3> {
    match patch {
        Patch::Flat { polygon, .. } => {
            let [a, b, c] = [0, 1, 2].map(|i| polygon.corners()[i]);
            [(a, b, c), (b, c, a), (c, a, b)]
                .map(|(near, p, q)| (4.0 * near + p + q) / 6.0)
                .to_vec()
        }
        Patch::Curved(part) => {
            let gauss = [0.5 - 12f64.sqrt().recip(), 0.5 + 12f64.sqrt().recip()];
            let at = |[from, to]: [f64; 2], share: f64| from + share * (to - from);
            let place = |s, t| {
                let (z, turn) = (at(part.heights, s), at(part.azimuths, t));
                let rho = (1.0 - z * z).sqrt();
                part.centre + part.radius * DVec3::new(rho * turn.cos(), rho * turn.sin(), z)
            };
            gauss
                .iter()
                .flat_map(|&s| gauss.map(|t| place(s, t)))
                .collect()
        }
    }
}

/// Returns the irradiance where a ray along `direction` meets a surface at `point`.
fn irradiance(solved: &Radiosity<'_>, scene: &Scene, point: DVec3, direction: DVec3) -> DVec3 {
    let ray = Ray::new(point - 0.01 * direction, direction);
    solved.irradiance(scene, &ray, &scene.intersect(&ray).expect("a surface"))
}

/// E = E_direct + π Σ F ρE/π for every patch and channel; the direct irradiance is that of a scene
/// whose surfaces reflect almost nothing.
#[test]
fn irradiances_solve_the_equation_by_hand() {
    let emitted = DVec3::new(0.5, 0.25, 0.0);
    let with = |albedos: [DVec3; 2], light: f64| {
        scene(|s| {
            let [a, b] = albedos.map(|albedo| Surface::new(Bsdf::Lambert { albedo }));
            square(s, 0.5, 0.0, true, a.emitting(light * emitted));
            square(s, 0.5, 0.4, false, b);
            panel(
                s,
                DVec3::new(0.6, -0.5, 0.1),
                [0.2 * DVec3::Z, DVec3::Y],
                lamp(2.0 * light),
            );
        })
    };
    let albedos = [DVec3::new(0.9, 0.5, 0.2), DVec3::new(0.3, 0.8, 0.0)];
    let scene = with(albedos, 1.0);
    let solved = solve(&scene, resolution(8, 0)).expect("a solution");
    let mesh = Mesh::new(&scene, resolution(8, 0)).expect("a mesh");
    let factors =
        FormFactors::new(Parts::default(), &scene, &mesh, &|_| true).expect("form factors");
    let direct = solve(&with([DVec3::splat(1e-30); 2], 1.0), resolution(8, 0)).expect("a solution");
    assert!(
        (1..5).contains(&direct.sweeps()) && solved.sweeps() > 5,
        "{}, {}",
        direct.sweeps(),
        solved.sweeps()
    );
    assert!(
        0.0 < solved.residual() && solved.residual() < RESIDUAL,
        "{}",
        solved.residual()
    );
    let reflected: Vec<_> = solved
        .irradiances()
        .map(|(element, e)| element.albedo * e)
        .collect();
    for (i, ((_, e), (_, direct))) in solved.irradiances().zip(direct.irradiances()).enumerate() {
        let row = factors.of_element(&mesh, i);
        let arriving: DVec3 = row
            .iter()
            .zip(&reflected)
            .map(|(f, reflected)| *f * reflected)
            .sum();
        assert!(
            (direct + arriving - e).abs().max_element() < 1e-5,
            "{e}, not {direct} + {arriving}"
        );
    }
    assert!(reflected.iter().any(|e| e.z > 0.1));
    // Between nodes the value is gathered by hand, and interpolation is close to it.
    let x = DVec3::new(0.13, -0.21, 0.0);
    let mut arriving = irradiance(&direct, &scene, x, -DVec3::Z);
    for (element, reflected) in mesh.elements().iter().zip(&reflected) {
        if let Patch::Flat {
            polygon: whole,
            normal,
        } = &element.patch
            && normal.z < -0.9
            && whole.corners()[0].z > 0.0
        {
            let relative: Vec<_> = whole.corners().iter().map(|corner| corner - x).collect();
            arriving += polygon(DVec3::Z, &relative) * reflected;
        }
    }
    let gathered = irradiance(
        &solved.clone().read(ReadOut::Gathered),
        &scene,
        x,
        -DVec3::Z,
    );
    let interpolated = irradiance(&solved, &scene, x, -DVec3::Z);
    assert!(
        (gathered - arriving).abs().max_element() < 1e-5,
        "{gathered}, not {arriving}"
    );
    let off = (interpolated - gathered).abs().max_element();
    assert!(1e-4 < off && off < 0.1, "{off}");
    let ray = Ray::new(x + 0.1 * DVec3::Z, -DVec3::Z);
    let radiance = solved.radiance(&scene, &ray, scene.intersect(&ray), &mut rng("radiosity"));
    assert!(
        (radiance - emitted - albedos[0] * interpolated / PI)
            .abs()
            .max_element()
            < 1e-12,
        "{radiance}"
    );
    // Residuals are relative.
    let bright = solve(&with(albedos, 1024.0), resolution(8, 0)).expect("a solution");
    assert_eq!(
        (bright.residual(), bright.sweeps()),
        (solved.residual(), solved.sweeps())
    );
    // A scene without light has a solution as well.
    let dark = crate::helpers::scene(|s| square(s, 0.5, 0.0, true, diffuse(0.5)));
    let solved = solve(&dark, resolution(1, 0)).expect("a solution");
    assert_eq!((solved.residual(), solved.sweeps()), (0.0, 1));
    assert!(solved.irradiances().all(|(_, e)| e == DVec3::ZERO));
}

#[test]
fn the_solution_satisfies_its_equation_and_converges() {
    let solved = solve(&furnace(0.9), resolution(40, 0)).expect("a solution");
    assert!(solved.residual() <= RESIDUAL && solved.sweeps() > 2);
    for (element, irradiance) in solved.irradiances() {
        let inside = irradiance != DVec3::ZERO;
        let expected = if inside { 10.0 * PI } else { 0.0 };
        assert_abs_diff_eq!(irradiance.x, expected, epsilon = 1e-3);
        assert_eq!(inside, element.emission != DVec3::ZERO);
    }
}

/// The mean irradiance of a floor under a light, both next to a wall: differences fall by at least
/// four as patches are halved.
#[test]
fn halving_patches_divides_the_error_by_four() {
    let scene = scene(|s| {
        panel(s, DVec3::ZERO, [DVec3::X, DVec3::Y], diffuse(0.5));
        panel(
            s,
            DVec3::new(-0.2, 0.0, 0.1),
            [DVec3::Y, DVec3::Z],
            diffuse(0.5),
        );
        panel(
            s,
            DVec3::new(0.2, 0.2, 1.0),
            [0.6 * DVec3::Y, 0.6 * DVec3::X],
            lamp(1.0),
        );
    });
    let flux = |halvings| {
        let solved = solve(&scene, resolution(8, halvings)).expect("a solution");
        solved
            .irradiances()
            .map(|(e, irradiance)| e.area * irradiance.x)
            .sum::<f64>()
    };
    let [a, b, c] = [0, 1, 2].map(flux);
    let order = ((a - b) / (b - c)).abs().log2();
    assert!(order > 1.5, "order {order:.2} from {a}, {b}, {c}");
}

#[test]
fn what_it_cannot_do_is_refused_in_one_line() {
    let refused =
        |scene: &Scene, resolution, hint: &str| assert_refused(solve(scene, resolution), hint);
    let default = MeshResolution::default();
    refused(&report_room(), default, "mirrors");
    refused(
        &scene(|s| square(s, 1.0, 0.0, true, glass(1.5))),
        default,
        "glass",
    );
    let rough = Surface::new(Bsdf::OrenNayar {
        albedo: DVec3::ONE,
        constants: OrenNayar::new(0.5),
        form: OrenNayarForm::Corrected,
    });
    refused(
        &scene(|s| square(s, 1.0, 0.0, true, rough)),
        default,
        "rough surfaces",
    );
    refused(
        &simple::glass_cube(false).expect("a scene"),
        default,
        "background",
    );
    let cube = furnace(0.5);
    refused(&cube, resolution(0, 0), "at least one");
    refused(&cube, resolution(2, 9), "at most 8 halvings");
    refused(
        &cube,
        resolution(2, 8),
        "of 131072 patches take up to 64.0 GiB of memory, more than 3.0",
    );
    refused(
        &cube,
        resolution(1_000_000, 0),
        "of 1000000 patches take up to 3725.3 GiB",
    );
    refused(&furnace(1.0), resolution(12, 0), "does not converge");
    assert!(matches!(
        Radiosity::new(Parts::default(), &cube, default, &|_| false),
        Err(Error::Interrupted)
    ));
}

/// The memory counts three nodes and one element for each side of a patch, and eight bytes for each
/// pair of them.
#[test]
fn meshes_are_refused_beyond_their_memory() {
    let scene = scene(|s| {
        let pale = s.surface(diffuse(0.5));
        let far = DVec3::new(7.0, -3.0, 2.0);
        s.mesh(&[far, far + DVec3::X, far + DVec3::Y], &[[0, 1, 2]], pale);
    });
    for parts in [107_u64, 108] {
        // A triangle is divided into a square number of parts, no fewer than requested.
        let mesh = Mesh::new(&scene, resolution((parts * parts) as u32 - 9, 0)).expect("a mesh");
        let patches = parts * parts;
        assert_eq!(
            (mesh.elements().len() as u64, mesh.nodes() as u64),
            (2 * patches, 6 * patches)
        );
        assert_eq!(
            check_memory(&mesh).is_ok(),
            24 * patches * patches <= MAX_MEMORY,
            "{parts}"
        );
    }
}

#[test]
fn threads_change_nothing() {
    let scene = simple::cornell().expect("a scene");
    let solved = |threads| {
        on_threads(threads, || {
            let solved = solve(&scene, resolution(100, 0)).expect("a solution");
            solved
                .irradiances()
                .map(|(_, e)| e.to_array().map(f64::to_bits))
                .collect::<Vec<_>>()
        })
    };
    assert!(solved(1) == solved(3));
}
