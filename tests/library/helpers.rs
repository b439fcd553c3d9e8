//! Random geometry, meshes, quadrature, scenes and films that several modules use.

use std::ops::Range;

use whitefurnace::geometry::bvh::Primitive;
use whitefurnace::harness::quadrature::{Rectangle, integrate};
use whitefurnace::integrator::Quirks;

use crate::prelude::*;

/// Unit roundoff: one operation has a relative error of at most this.
pub const UNIT_ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// Draws a uniform number in [low, high).
pub fn between<R: Rng + ?Sized>(rng: &mut R, low: f64, high: f64) -> f64 {
    low + (high - low) * uniform(rng)
}

/// Draws a uniform unit vector.
pub fn unit_vector<R: Rng>(rng: &mut R) -> DVec3 {
    from_spherical(between(rng, -1.0, 1.0).acos(), between(rng, 0.0, TAU))
}

/// Draws a point of the cube [−half, half]³.
pub fn in_cube<R: Rng + ?Sized>(rng: &mut R, half: f64) -> DVec3 {
    DVec3::from_array([0; 3].map(|_| between(rng, -half, half)))
}

/// Generates unit vectors for property tests.
pub fn unit() -> impl Strategy<Value = DVec3> {
    (0.0..=PI, 0.0..TAU).prop_map(|(theta, phi)| from_spherical(theta, phi))
}

/// Generates unit vectors of the upper hemisphere with cos θ of at least `lowest`.
pub fn upper(lowest: f64) -> impl Strategy<Value = DVec3> {
    (lowest..=1.0, 0.0..TAU).prop_map(|(z, phi): (f64, f64)| from_spherical(z.acos(), phi))
}

/// Generates points of the cube [−half, half]³ for property tests.
pub fn point(half: f64) -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-half..=half).prop_map(DVec3::from_array)
}

/// Integrates f over [a, b].
pub fn integral(a: f64, b: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
    integrate(
        Rectangle {
            x: [a, b],
            y: [0.0, 1.0],
        },
        1e-10,
        &mut |x, _| f(x),
    )
    .value
}

/// An indexed triangle mesh.
#[derive(Clone)]
pub struct Mesh {
    pub vertices: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Returns the vertices of a triangle.
    pub fn corners(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|v| self.vertices[v as usize])
    }

    /// Returns the triangles as primitives of a hierarchy.
    pub fn primitives(&self) -> Vec<Primitive> {
        self.triangles
            .iter()
            .map(|&t| Primitive::Triangle(self.corners(t)))
            .collect()
    }

    /// Returns the mesh with every vertex mapped.
    pub fn map(mut self, f: impl Fn(DVec3) -> DVec3) -> Self {
        for vertex in &mut self.vertices {
            *vertex = f(*vertex);
        }
        self
    }

    /// Returns a closed prism over a convex outline, fronts outward, bottom and top as fans.
    pub fn prism(outline: &[[f64; 2]], [bottom, top]: [f64; 2]) -> Self {
        let n = outline.len() as u32;
        let ring = |z: f64| outline.iter().map(move |&[x, y]| DVec3::new(x, y, z));
        let mut triangles = Vec::new();
        for i in 1..n - 1 {
            triangles.extend([[0, i + 1, i], [n, n + i, n + i + 1]]);
        }
        for i in 0..n {
            let next = (i + 1) % n;
            triangles.extend([[i, next, next + n], [i, next + n, i + n]]);
        }
        Self {
            vertices: ring(bottom).chain(ring(top)).collect(),
            triangles,
        }
    }

    /// The cube [−1, 1]³.
    pub fn cube() -> Self {
        Self::prism(
            &[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]],
            [-1.0, 1.0],
        )
    }

    /// The walls, floor and ceiling of the report's room.
    pub fn room_shell() -> Self {
        Self::prism(&crate::scene::OUTLINE, [-5.0, 5.0])
    }

    /// Returns a unit sphere of `rows` × `columns` quadrilaterals, two triangles each except at the
    /// poles.
    pub fn globe(rows: u32, columns: u32) -> Self {
        let mut vertices = vec![DVec3::Z];
        for row in 1..rows {
            for column in 0..columns {
                let theta = PI * f64::from(row) / f64::from(rows);
                vertices.push(from_spherical(
                    theta,
                    TAU * f64::from(column) / f64::from(columns),
                ));
            }
        }
        vertices.push(-DVec3::Z);
        let south = vertices.len() as u32 - 1;
        let at = |row: u32, column: u32| 1 + (row - 1) * columns + column % columns;
        let mut triangles = Vec::new();
        for column in 0..columns {
            triangles.push([0, at(1, column), at(1, column + 1)]);
            for row in 1..rows - 1 {
                let (a, b) = (at(row, column), at(row, column + 1));
                let (c, d) = (at(row + 1, column), at(row + 1, column + 1));
                triangles.extend([[a, c, d], [a, d, b]]);
            }
            triangles.push([south, at(rows - 1, column + 1), at(rows - 1, column)]);
        }
        Self {
            vertices,
            triangles,
        }
    }
}

/// Returns triangles far from the z axis, whose edge values for rays along it are of the size of
/// their rounding errors: tiny ones, and large ones that are seen edge-on. `epsilon` is that of the
/// numbers.
pub fn slivers_beside_z(epsilon: f64) -> Vec<[DVec3; 3]> {
    // Corners are moved by multiples of the distance between numbers from 4 to 8.
    let moves = |place: usize| [place / 4, place % 4].map(|n| 4.0 * epsilon * n as f64);
    let corner = |scale: f64, place: usize| {
        let [x, y] = moves(place);
        DVec3::new(5.3, 6.1, 7.0) * scale + DVec3::new(x, y, 0.0)
    };
    let mut slivers = Vec::new();
    for scales in [[1.0; 3], [1.0, 1.5, 2.0], [1.0, 2.0, 3.0]] {
        for places in (0..16 * 16 * 16).map(|n| [n / 256, n / 16 % 16, n % 16]) {
            let [a, b, c] = [0, 1, 2].map(|n| corner(scales[n], places[n]));
            if places.is_sorted() && (b - a).cross(c - a) != DVec3::ZERO {
                slivers.push([a, b, c]);
            }
        }
    }
    slivers
}

/// Draws a vertex or a point on an edge, where watertightness is decided.
pub fn border<R: Rng>(rng: &mut R, mesh: &Mesh) -> DVec3 {
    let pick = between(rng, 0.0, mesh.triangles.len() as f64) as usize;
    let [a, b, c] = mesh.corners(mesh.triangles[pick]);
    let s = between(rng, -0.5, 1.0).max(0.0);
    let side = between(rng, 0.0, 3.0) as usize;
    let (p, q) = [(a, b), (b, c), (c, a)][side];
    p + s * (q - p)
}

/// Builds a scene of these parts, seen by [`any_camera`].
pub fn scene(parts: impl FnOnce(&mut SceneBuilder)) -> Scene {
    scene_from(any_camera(), parts)
}

/// Builds a scene of one black mesh.
pub fn scene_of(mesh: &Mesh) -> Scene {
    scene(|scene| {
        let surface = scene.surface(Surface::new(Bsdf::Black));
        scene.mesh(&mesh.vertices, &mesh.triangles, surface);
    })
}

/// Builds a scene of these parts and a camera.
pub fn scene_from(camera: Camera, parts: impl FnOnce(&mut SceneBuilder)) -> Scene {
    let mut scene = SceneBuilder::new("test");
    parts(&mut scene);
    scene.build(camera).expect("a valid scene")
}

/// The report's room.
pub fn report_room() -> Scene {
    room::report(Convention::Physical, OrenNayarForm::Corrected).expect("the room")
}

/// A closed cube whose walls all emit and reflect alike.
pub fn furnace(albedo: f64) -> Scene {
    simple::furnace_box(albedo).expect("a scene")
}

/// The inside of a sphere of radius 1.
pub fn within_sphere(surface: Surface) -> Scene {
    scene(|scene| ball(scene, inward(Sphere::new(DVec3::ZERO, 1.0)), surface))
}

/// A Lambertian surface of this albedo.
pub fn diffuse(albedo: f64) -> Surface {
    Surface::new(Bsdf::Lambert {
        albedo: DVec3::splat(albedo),
    })
}

/// A surface that reflects nothing and emits this radiance.
pub fn lamp(radiance: f64) -> Surface {
    Surface::new(Bsdf::Black).emitting(DVec3::splat(radiance))
}

/// Smooth glass.
pub fn glass(index: f64) -> Surface {
    Surface::new(Bsdf::Glass { index })
}

/// A mirror of this reflectance.
pub fn reflecting(reflectance: f64) -> Surface {
    Surface::new(Bsdf::Mirror {
        reflectance: DVec3::splat(reflectance),
    })
}

/// Adds a rectangle with a surface of its own.
pub fn panel(scene: &mut SceneBuilder, corner: DVec3, edges: [DVec3; 2], surface: Surface) {
    let surface = scene.surface(surface);
    scene.rectangle(corner, edges, surface);
}

/// Adds a horizontal square around the z-axis with this half side, its front up or down.
pub fn square(scene: &mut SceneBuilder, half: f64, height: f64, up: bool, surface: Surface) {
    let [x, y] = [2.0 * half * DVec3::X, 2.0 * half * DVec3::Y];
    panel(
        scene,
        DVec3::new(-half, -half, height),
        if up { [x, y] } else { [y, x] },
        surface,
    );
}

/// The part of a sphere between two heights above its centre.
pub fn between_heights(sphere: Sphere, zone: [f64; 2]) -> Sphere {
    Sphere { zone, ..sphere }
}

/// The same sphere with its front inside.
pub fn inward(sphere: Sphere) -> Sphere {
    Sphere {
        inward: true,
        ..sphere
    }
}

/// Adds a sphere with a surface of its own.
pub fn ball(scene: &mut SceneBuilder, sphere: Sphere, surface: Surface) {
    let surface = scene.surface(surface);
    scene.sphere(sphere, surface);
}

/// Runs a function in a pool of this many threads.
pub fn on_threads<T: Send>(threads: usize, run: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("a pool of threads").install(run)
}

/// Returns a sampling without points for silhouettes.
pub fn sampling(pixel: PixelSampling, sampler: SamplerKind, seed: u64) -> Sampling {
    Sampling {
        pixel,
        sampler,
        seed,
        silhouettes: false,
    }
}

/// Returns a lookup by final gathering with these caustic photons.
pub fn final_gather(caustic_particles: u32, caustic_radius: f64) -> Lookup {
    Lookup::FinalGather {
        caustic_particles,
        caustic_radius,
    }
}

/// Returns progressive photon mapping with these parts.
pub fn sppm(parts: Parts<'_>, particles: u32, radius: f64) -> Sppm<'_> {
    Sppm {
        parts,
        particles,
        radius,
    }
}

/// Returns the resolution of a mesh of patches.
pub fn resolution(patches: u32, halvings: u32) -> MeshResolution {
    MeshResolution { patches, halvings }
}

/// Renders these ranges of replications into a film of the frame.
pub fn rendered(
    scene: &Scene,
    estimator: &dyn Estimator,
    frame: [u32; 2],
    sampling: Sampling,
    ranges: &[Range<u32>],
) -> Result<Film, Error> {
    let mut film = Film::new(frame, None, sampling.samples_per_replication())?;
    for range in ranges {
        assert!(render(
            scene,
            estimator,
            sampling,
            &mut film,
            range,
            &|_| true
        )?);
    }
    Ok(film)
}

/// Returns a renderer that traces lanes of paths at a time.
pub fn lanes(
    estimator: LaneEstimator<'_>,
    sampling: Sampling,
    precision: Precision,
) -> LaneRenderer<'_> {
    LaneRenderer {
        estimator,
        sampling,
        precision,
    }
}

/// Adds these replications to a new film of the frame.
pub fn filled(
    renderer: &dyn Renderer,
    scene: &Scene,
    frame: [u32; 2],
    range: Range<u32>,
) -> Result<Film, Error> {
    let mut film = Film::new(frame, None, renderer.samples_per_replication())?;
    assert!(renderer.add(scene, &mut film, range, &|_| true)?);
    Ok(film)
}

/// Renders these ranges of passes into a film of the frame.
pub fn passes(
    scene: &Scene,
    estimator: &dyn ImageEstimator,
    frame: [u32; 2],
    ranges: &[Range<u32>],
) -> Result<Film, Error> {
    let mut film = Film::new(frame, None, 1)?;
    for range in ranges {
        assert!(render_passes(
            scene,
            estimator,
            SamplerKind::Independent,
            master(),
            &mut film,
            range.clone(),
            &|_| true
        )?);
    }
    Ok(film)
}

/// Returns the reconstruction with the quirks whose bits are set, in their order.
pub fn published(bits: u32) -> Published {
    let [roulette_by_cosine, end_loses_direct, extra_cosine] = [1, 2, 4].map(|bit| bits & bit != 0);
    Published {
        quirks: Quirks {
            roulette_by_cosine,
            end_loses_direct,
            extra_cosine,
        },
    }
}

/// A camera for scenes whose image does not matter.
pub fn any_camera() -> Camera {
    Camera::new(DVec3::ZERO, DVec3::X, DVec3::Z, 1.0)
}

/// Returns the message of a refusal, which is one line; `what` names the case.
pub fn refusal<T>(result: Result<T, Error>, what: &str) -> String {
    let Err(error) = result else {
        panic!("not refused: {what}");
    };
    let message = error.to_string();
    assert!(!message.contains('\n'), "{what}: {message}");
    message
}

/// Asserts a refusal, in one line that contains a hint.
pub fn assert_refused<T>(result: Result<T, Error>, hint: &str) {
    let message = refusal(result, hint);
    assert!(message.contains(hint), "{hint}: {message}");
}

/// Asserts that an option is refused, in one line that contains a hint.
pub fn assert_option_refused<T>(result: Result<T, Error>, hint: &str) {
    match result {
        Err(Error::Option(message)) => {
            assert!(
                message.contains(hint) && !message.contains('\n'),
                "{message}"
            );
        }
        Err(error) => panic!("{error}"),
        Ok(_) => panic!("not refused: {hint}"),
    }
}

/// Implements traits of parts by their defaults.
macro_rules! default_parts {
    ($kind:ty: $($group:ident),*) => {
        $(impl $group for $kind {})*
    };
}
pub(crate) use default_parts;

/// The standard parts as another type, so that their scalar functions are called lane by lane.
#[derive(Clone, Copy, Debug)]
pub struct ScalarParts;

default_parts!(ScalarParts: Scattering, Roulette, NextEvent, Photons, Bidirectional, FiniteElements);
