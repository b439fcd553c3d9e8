//! The program `export`: writes scenes in the formats of other renderers. A scene that the other
//! renderer cannot express is refused by name, never approximated.

mod mitsuba;
mod pbrt;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, ValueEnum};
use glam::DVec3;
use whitefurnace::error::Error;
use whitefurnace::geometry::shape::Sphere;
use whitefurnace::integrator::MAX_PATH_VERTICES;
use whitefurnace::light::environment::Environment;
use whitefurnace::scene::{Geometry, Scene, Surface};

use crate::print_line;
use crate::render::{DiffuseName, Job, SceneSource};
use crate::run::cli::{self, Ending, integer, parse_size};

/// Write a scene for another renderer, with the same camera, image size and box filter.
///
/// Examples:
///   export --scene cornell --to mitsuba --size 256x256
///   mitsuba -m scalar_rgb out/export/scene.xml
///
///   export --scene room.toml --to pbrt --out out/room
///   pbrt out/room/scene.pbrt
///
/// A scene with a feature that the other renderer lacks is refused by name, never approximated.
/// `absorption` is left out, because only the report's own estimator uses it.
#[derive(Parser)]
#[command(name = "export", version, verbatim_doc_comment)]
pub struct Export {
    /// The scene: a built-in one, or a scene file that ends in .toml
    #[arg(long, default_value = "report", value_name = "NAME|FILE.toml")]
    scene: SceneSource,
    /// Diffuse model of the report's white sphere
    #[arg(long, value_enum, default_value_t = DiffuseName::Corrected)]
    diffuse: DiffuseName,
    /// The renderer to write for
    #[arg(long, value_enum)]
    to: Renderer,
    /// Width x height in pixels; from 1x1 to 100000000 pixels in all
    #[arg(long, allow_hyphen_values = true, value_parser = parse_size, default_value = "1024x768")]
    size: [u32; 2],
    /// Samples per pixel; from 1 to 4294967295
    #[arg(long, default_value_t = 64, allow_hyphen_values = true, value_parser = integer::<u32>(1..=u64::from(u32::MAX)))]
    spp: u32,
    /// Most scattering events between a light and the camera; from 0 to 8192 [default: no limit]
    #[arg(long, allow_hyphen_values = true, value_parser = integer::<u32>(0..=u64::from(MAX_PATH_VERTICES)))]
    bounces: Option<u32>,
    /// Folder for the scene and its meshes
    #[arg(long, value_name = "DIR", default_value = "out/export")]
    out: PathBuf,
}

/// The renderers for which scenes can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Renderer {
    /// Mitsuba 3, in a variant whose colours are RGB
    Mitsuba,
    /// pbrt-v4, which is spectral: grey surfaces and lights only
    Pbrt,
}

/// Runs the whole program.
pub fn main() -> ExitCode {
    cli::exit(run(&cli::parse()))
}

fn run(options: &Export) -> Result<Ending, Error> {
    let Export {
        scene,
        diffuse,
        to,
        size,
        spp,
        bounces,
        ref out,
    } = *options;
    let job = Job {
        scene,
        diffuse,
        ..Job::default()
    };
    scene.print_notes();
    let files = files(&job.build_scene()?, to, size, spp, bounces)?;
    std::fs::create_dir_all(out).map_err(Error::file("create", out))?;
    for (name, text) in &files {
        let path = out.join(name);
        std::fs::write(&path, text).map_err(Error::file("write", &path))?;
    }
    print_line!("{}: {} files", out.join(&files[0].0).display(), files.len());
    Ok(Ending::Done)
}

/// Returns the files of a scene by name, the scene file first. `spp` is the number of paths per
/// pixel, `bounces` their largest number of bounces, `None` for no limit.
pub fn files(
    scene: &Scene,
    to: Renderer,
    size: [u32; 2],
    spp: u32,
    bounces: Option<u32>,
) -> Result<Vec<(String, String)>, Error> {
    let files = match scene.coincident_in_singles() {
        Some(coincidence) => Err(format!(
            "it computes in single precision, in which {coincidence}"
        )),
        None => match to {
            Renderer::Mitsuba => mitsuba::files(scene, size, spp, bounces),
            Renderer::Pbrt => pbrt::file(scene, size, spp, bounces)
                .map(|text| vec![("scene.pbrt".to_owned(), text)]),
        },
    };
    files.map_err(|what| {
        let renderer = crate::render::name(to);
        Error::Option(format!(
            "--to {renderer} cannot express scene {}: {what}",
            scene.name()
        ))
    })
}

/// Geometry with one surface: all triangles of the surface, or a single sphere.
struct SurfaceGeometry<'s> {
    surface: &'s Surface,
    shape: Shape,
}

enum Shape {
    Triangles(Vec<[DVec3; 3]>),
    Sphere(Sphere),
}

fn parts(scene: &Scene) -> Vec<SurfaceGeometry<'_>> {
    let mut parts: Vec<SurfaceGeometry> = Vec::new();
    for (geometry, surface) in scene.primitives() {
        match geometry {
            Geometry::Sphere(sphere) => parts.push(SurfaceGeometry {
                surface,
                shape: Shape::Sphere(sphere),
            }),
            Geometry::Triangle(corners) => {
                let same = parts.iter_mut().find_map(|part| match &mut part.shape {
                    Shape::Triangles(triangles) if std::ptr::eq(part.surface, surface) => {
                        Some(triangles)
                    }
                    _ => None,
                });
                match same {
                    Some(triangles) => triangles.push(corners),
                    None => parts.push(SurfaceGeometry {
                        surface,
                        shape: Shape::Triangles(vec![corners]),
                    }),
                }
            }
        }
    }
    parts
}

/// Returns the radiance of the background, or `None` if it is black.
fn background(scene: &Scene) -> Result<Option<DVec3>, String> {
    match scene.background() {
        Environment::Uniform(radiance) => Ok((*radiance != DVec3::ZERO).then_some(*radiance)),
        Environment::Map(_) => {
            Err("it has an environment map, and others put its pixels elsewhere".to_owned())
        }
    }
}

/// Returns true if the sphere is not clipped.
fn is_unclipped(sphere: &Sphere) -> bool {
    sphere.heights() == [-sphere.radius, sphere.radius]
}

/// Formats three numbers with a separator, each with all its digits.
fn numbers(v: DVec3, separator: &str) -> String {
    v.to_array().map(|x| x.to_string()).join(separator)
}
