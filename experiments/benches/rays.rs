//! Rays per second of the hierarchy by number of triangles, for camera rays, two diffuse bounces
//! and shadow rays: `cargo bench -p experiments --bench rays`. With `-- --out FOLDER` meshes and
//! rays are written as raw arrays, for another ray tracer: `experiments/peers/rays.py` reads them.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use glam::DVec3;
use serde::Serialize;
use whitefurnace::geometry::bvh::{Bvh, Primitive};
use whitefurnace::geometry::shape::Ray;
use whitefurnace::math::frame::{Frame, from_spherical};
use whitefurnace::sampling::rng::{stream, uniform2};
use whitefurnace::sampling::warp::cosine_hemisphere;

/// Rays per side of the camera's square image.
const IMAGE_SIDE: u32 = 256;
/// Passes over all rays, of which the fastest counts.
const PASSES: usize = 5;
/// Half the side of the room around the mesh.
const ROOM: f64 = 2.0;
/// Distance that rays keep from where they start and end.
const GAP: f64 = 1e-5;

/// A mesh of a room with its rays, in kinds.
struct Workload {
    triangles: Vec<[DVec3; 3]>,
    rays: Vec<RayKind>,
}

/// Rays that are traced together.
struct RayKind {
    name: &'static str,
    /// Whether any hit up to t = 1 is asked for, else the closest.
    is_shadow: bool,
    rays: Vec<Ray>,
}

/// Measurements of a mesh.
#[derive(Serialize)]
struct Row {
    mesh: String,
    triangles: usize,
    build_seconds: f64,
    kinds: Vec<KindRow>,
}

#[derive(Serialize)]
struct KindRow {
    name: &'static str,
    rays: usize,
    hits: usize,
    /// Millions of rays per second on one thread.
    rate: f64,
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let out = words.iter().position(|word| word == "--out");
    let folder = out.and_then(|at| words.get(at + 1)).map(PathBuf::from);
    // Without `--bench`, which `cargo bench` gives, it only has to run.
    let counts: &[u32] = if words.iter().any(|word| word == "--bench") {
        &[1_000, 10_000, 100_000, 1_000_000]
    } else {
        &[1_000]
    };
    match measure_all(counts, folder.as_deref()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

/// Measures all meshes, prints a line each, and writes the arrays into a folder.
fn measure_all(counts: &[u32], folder: Option<&Path>) -> std::io::Result<()> {
    for &count in counts {
        for (name, mesh) in [("sphere", sphere(count)), ("clutter", clutter(count))] {
            let workload = Workload::new(mesh);
            let row = workload.measure(format!("{name}-{count}"));
            if let Some(folder) = folder {
                workload.write(&folder.join(&row.mesh))?;
            }
            println!("{}", serde_json::to_string(&row)?);
        }
    }
    Ok(())
}

/// Returns a wavy sphere of about `count` triangles.
fn wavy_sphere(count: u32, centre: DVec3, radius: f64) -> Vec<[DVec3; 3]> {
    let side = f64::from(count / 2).sqrt().round().max(3.0) as u32;
    let at = |row: u32, column: u32| {
        let theta = std::f64::consts::PI * f64::from(row) / f64::from(side);
        let phi = std::f64::consts::TAU * f64::from(column % side) / f64::from(side);
        let height = 1.0 + 0.1 * (8.0 * theta).sin() * (9.0 * phi).cos();
        rounded(centre + from_spherical(theta, phi) * height * radius)
    };
    (0..side * side)
        .flat_map(|i| {
            let (row, column) = (i / side, i % side);
            let [a, b] = [at(row, column), at(row, column + 1)];
            let [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
            [[a, c, d], [a, d, b]]
        })
        .collect()
}

fn sphere(count: u32) -> Vec<[DVec3; 3]> {
    wavy_sphere(count, DVec3::ZERO, 1.2)
}

/// Returns small wavy spheres of 200 triangles in the room, of about `count` in all.
fn clutter(count: u32) -> Vec<[DVec3; 3]> {
    let spheres = (count / 200).max(1);
    let size = 1.2 * f64::from(spheres).cbrt().recip();
    (0..spheres)
        .flat_map(|i| {
            let ([x, y], [z, r]) = (
                uniform2(&mut stream(1, 0, i)),
                uniform2(&mut stream(1, 1, i)),
            );
            let centre = DVec3::new(x, y, z) * 3.4 - 1.7;
            wavy_sphere(200, centre, size * (0.3 + 0.7 * r))
        })
        .collect()
}

/// Returns the walls of the room.
fn walls() -> Vec<[DVec3; 3]> {
    let corner = |bits: u32| {
        DVec3::from_array([0, 1, 2].map(|axis| if bits >> axis & 1 == 1 { ROOM } else { -ROOM }))
    };
    [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ]
    .into_iter()
    .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
    .map(|triangle| triangle.map(corner))
    .collect()
}

/// Rounds to single precision, so that another ray tracer has the same numbers.
fn rounded(v: DVec3) -> DVec3 {
    v.as_vec3().as_dvec3()
}

fn bvh(triangles: &[[DVec3; 3]]) -> Bvh {
    let primitives: Vec<Primitive> = triangles.iter().copied().map(Primitive::Triangle).collect();
    Bvh::new(&primitives)
}

impl Workload {
    fn new(mut triangles: Vec<[DVec3; 3]>) -> Self {
        triangles.extend(walls());
        let bvh = bvh(&triangles);
        let eye = DVec3::new(0.1, -1.9, 0.2);
        let camera: Vec<Ray> = (0..IMAGE_SIDE * IMAGE_SIDE)
            .map(|i| {
                let [x, z] = [i % IMAGE_SIDE, i / IMAGE_SIDE]
                    .map(|place| (f64::from(place) + 0.5) / f64::from(IMAGE_SIDE) - 0.5);
                Ray::new(
                    rounded(eye),
                    rounded(DVec3::new(1.6 * x, 1.0, 1.6 * z).normalize()),
                )
            })
            .collect();
        let first = bounce(&bvh, &triangles, &camera, 1);
        let second = bounce(&bvh, &triangles, &first, 2);
        let shadow = camera
            .iter()
            .zip(0..)
            .filter_map(|(ray, i)| {
                let (point, _) = hit(&bvh, &triangles, ray)?;
                let [x, y] = uniform2(&mut stream(3, 0, i)).map(|r| r - 0.5);
                let light = DVec3::new(x, y, ROOM - GAP);
                Some(Ray::new(rounded(point), rounded(light - point)))
            })
            .collect();
        let kind = |name, is_shadow, rays| RayKind {
            name,
            is_shadow,
            rays,
        };
        Self {
            triangles,
            rays: vec![
                kind("camera", false, camera),
                kind("first-bounce", false, first),
                kind("second-bounce", false, second),
                kind("shadow", true, shadow),
            ],
        }
    }

    fn measure(&self, mesh: String) -> Row {
        let mut build_seconds = f64::INFINITY;
        let mut built = None;
        for _ in 0..PASSES.min(3) {
            let start = Instant::now();
            built = Some(bvh(&self.triangles));
            build_seconds = build_seconds.min(start.elapsed().as_secs_f64());
        }
        let kinds = built
            .iter()
            .flat_map(|bvh| self.rays.iter().map(|kind| kind.measure(bvh)));
        Row {
            mesh,
            triangles: self.triangles.len(),
            build_seconds,
            kinds: kinds.collect(),
        }
    }

    /// Writes vertices of triangles and, for each kind, origins and directions of rays, as
    /// little-endian single-precision numbers.
    fn write(&self, folder: &Path) -> std::io::Result<()> {
        std::fs::create_dir_all(folder)?;
        let write = |name: &str, vectors: &mut dyn Iterator<Item = DVec3>| {
            let bytes: Vec<u8> = vectors
                .flat_map(|v| v.as_vec3().to_array())
                .flat_map(f32::to_le_bytes)
                .collect();
            std::fs::write(folder.join(format!("{name}.f32")), bytes)
        };
        write("triangles", &mut self.triangles.iter().flatten().copied())?;
        for kind in &self.rays {
            let numbers = kind.rays.iter().flat_map(|ray| [ray.origin, ray.direction]);
            write(kind.name, &mut { numbers })?;
        }
        Ok(())
    }
}

impl RayKind {
    fn measure(&self, bvh: &Bvh) -> KindRow {
        let mut seconds = f64::INFINITY;
        let mut hits = 0;
        for _ in 0..PASSES {
            let start = Instant::now();
            hits = if self.is_shadow {
                self.rays
                    .iter()
                    .filter(|ray| bvh.occluded(ray, 1.0, |_| true))
                    .count()
            } else {
                let is_hit = |ray: &&Ray| bvh.closest(ray, f64::INFINITY).is_some();
                self.rays.iter().filter(is_hit).count()
            };
            seconds = seconds.min(start.elapsed().as_secs_f64());
        }
        KindRow {
            name: self.name,
            rays: self.rays.len(),
            hits,
            rate: self.rays.len() as f64 / seconds / 1e6,
        }
    }
}

/// Returns the point that a ray hits, off the surface, and the normal on the ray's side.
fn hit(bvh: &Bvh, triangles: &[[DVec3; 3]], ray: &Ray) -> Option<(DVec3, DVec3)> {
    let hit = bvh.closest(ray, f64::INFINITY)?;
    let [a, b, c] = triangles[hit.primitive as usize];
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let normal = if normal.dot(ray.direction) > 0.0 {
        -normal
    } else {
        normal
    };
    Some((ray.at(hit.t) + GAP * normal, normal))
}

/// Returns a diffuse bounce of each ray that hits.
fn bounce(bvh: &Bvh, triangles: &[[DVec3; 3]], rays: &[Ray], seed: u64) -> Vec<Ray> {
    rays.iter()
        .zip(0..)
        .filter_map(|(ray, i)| {
            let (point, normal) = hit(bvh, triangles, ray)?;
            let local = cosine_hemisphere(uniform2(&mut stream(2, seed as u32, i)));
            let direction = Frame::new(normal).world(local);
            Some(Ray::new(rounded(point), rounded(direction)))
        })
        .collect()
}
