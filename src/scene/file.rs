//! Scenes as data, and the files they are read from: TOML, with meshes from OBJ files. The page
//! "Scene files" of the book (`book/pages/scenes.md`) has every key with its unit, range and
//! default.
//!
//! ```
//! use whitefurnace::scene::file::Description;
//!
//! # fn main() -> Result<(), whitefurnace::error::Error> {
//! let mut ball = Description::parse(
//!     "ball",
//!     r#"
//!     background = 1
//!     camera = { eye = [0, -5, 0], target = [0, 0, 0], up = [0, 0, 1], fov_deg = 40 }
//!     materials.clay = { model = "lambert", albedo = [0.8, 0.4, 0.2] }
//!     objects = [{ shape = "sphere", material = "clay", centre = [0, 0, 0], radius = 1 }]
//!     "#,
//! )?;
//! ball.surface("clay")?.absorption = 0.1;
//! assert_eq!(ball.build()?.primitives().count(), 1);
//! # Ok(())
//! # }
//! ```

mod keys;
mod material;
mod obj;
mod object;
mod polygon;
mod reader;
mod schema;
mod signatures;
mod synonyms;

use std::collections::HashMap;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use glam::DVec3;
use sha2::Digest as _;

use super::builder::invalid;
use super::{Scene, SceneBuilder, Surface};
use crate::camera::Camera;
use crate::error::Error;
use crate::geometry::shape::Sphere;
use crate::light::environment::Environment;
use crate::suggest::did_you_mean;
use reader::{Source, quote};
use schema::Reading;

/// Largest size of a scene file, bytes: larger meshes belong in an OBJ file.
pub const LARGEST_FILE: u64 = 4 << 20;
/// Largest total size of all other files of a scene, bytes: OBJ and images.
pub const LARGEST_OTHER: u64 = 256 << 20;
/// Largest number of vertices of a scene, and of triangles.
pub const MAX_VERTICES: usize = 4 << 20;

/// A scene as plain data; [`build`](Self::build) turns it into one that can be rendered.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// Name of the scene.
    pub name: String,
    /// Environment: the radiance of rays that hit nothing.
    pub background: Environment,
    /// Camera.
    pub camera: Camera,
    /// Surfaces by name.
    pub materials: Vec<(String, Surface)>,
    /// Objects of the scene.
    pub objects: Vec<Object>,
}

/// An object of a scene; materials by name.
#[derive(Clone, Debug, PartialEq)]
pub enum Object {
    /// A rectangle: see [`SceneBuilder::rectangle`].
    Rectangle {
        /// One corner.
        corner: DVec3,
        /// Edges from that corner.
        edges: [DVec3; 2],
        /// Name of the material.
        material: String,
    },
    /// A sphere: see [`SceneBuilder::sphere`].
    Sphere {
        /// The sphere or zone.
        sphere: Sphere,
        /// Name of the material.
        material: String,
    },
    /// A mesh: see [`SceneBuilder::mesh`].
    Mesh {
        /// Vertices shared by all its triangles.
        vertices: Vec<DVec3>,
        /// Triangles of each material.
        triangles: Vec<(String, Vec<[u32; 3]>)>,
    },
}

/// A scene that was read from files.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneFile {
    /// Contents of the files.
    pub description: Description,
    /// Path of the scene file.
    pub path: PathBuf,
    /// SHA-256 of its bytes and those of the files it names, each after its length: different
    /// scenes have different ones.
    pub digest: String,
    /// Notes about the reading that a user should know, one line each, such as parts that were left
    /// out.
    pub notes: Vec<String>,
}

impl SceneFile {
    /// Reads a scene file and the files that it names.
    ///
    /// [`Error::File`] if it cannot be read, [`Error::Scene`] with the file and line of the error
    /// in it.
    pub fn load(path: &Path) -> Result<Self, Error> {
        let bytes = read(path, LARGEST_FILE).map_err(Error::file("read", path))?;
        let file = path.display().to_string();
        let text = str::from_utf8(&bytes).map_err(|error| {
            let line = 1 + bytes[..error.valid_up_to()]
                .iter()
                .filter(|byte| **byte == b'\n')
                .count();
            reader::error_at_line(&file, line, "this is no text in UTF-8")
        })?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let folder = path.parent().unwrap_or(Path::new(""));
        let (description, reading) = Reading::of(&Source { file: &file, text }, &name, folder)?;
        let digest = reading
            .digest
            .finalize()
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect();
        Ok(Self {
            description,
            path: path.to_owned(),
            digest,
            notes: reading.notes,
        })
    }
}

/// Reads an ordinary file of at most this size.
fn read(path: &Path, largest: u64) -> std::io::Result<Vec<u8>> {
    use std::io::{Error, ErrorKind};
    // Opening a pipe would wait for its writer.
    if !std::fs::metadata(path)?.is_file() {
        return Err(Error::new(
            ErrorKind::InvalidInput,
            "this is no ordinary file",
        ));
    }
    let mut bytes = Vec::new();
    std::fs::File::open(path)?
        .take(largest + 1)
        .read_to_end(&mut bytes)?;
    if bytes.len() as u64 > largest {
        return Err(Error::new(
            ErrorKind::FileTooLarge,
            format!("it has more than {largest} bytes"),
        ));
    }
    Ok(bytes)
}

impl Description {
    /// Parses a text into a scene, with this name if the text has none. OBJ files are looked for in
    /// the current folder.
    ///
    /// # Errors
    /// [`Error::Scene`] with the line of the error.
    pub fn parse(name: &str, text: &str) -> Result<Self, Error> {
        Ok(Reading::of(&Source { file: name, text }, name, Path::new(""))?.0)
    }

    /// Returns the surface of a material.
    ///
    /// # Errors
    /// [`Error::Scene`] if there is no material of this name.
    pub fn surface(&mut self, material: &str) -> Result<&mut Surface, Error> {
        let found = self.materials.iter().position(|(name, _)| name == material);
        match found {
            Some(i) => Ok(&mut self.materials[i].1),
            None => Err(invalid(&self.name, self.unknown(material))),
        }
    }

    fn unknown(&self, material: &str) -> String {
        let names = self.materials.iter().map(|(name, _)| name);
        format!(
            "there is no material {}{}",
            quote(material),
            did_you_mean(material, names)
        )
    }

    /// Builds the scene for rendering.
    ///
    /// # Errors
    /// [`Error::Scene`] for an unknown material, and as [`SceneBuilder::build`] and
    /// [`Scene::check_details`].
    pub fn build(&self) -> Result<Scene, Error> {
        let mut scene = SceneBuilder::new(&self.name);
        scene.environment(self.background.clone());
        let surfaces: HashMap<&str, _> = self
            .materials
            .iter()
            .map(|(name, surface)| {
                (
                    &**name,
                    scene.named_surface(format!("material {name}"), *surface),
                )
            })
            .collect();
        let surface = |material: &str| {
            surfaces
                .get(material)
                .copied()
                .ok_or_else(|| invalid(&self.name, self.unknown(material)))
        };
        for object in &self.objects {
            match object {
                Object::Rectangle {
                    corner,
                    edges,
                    material,
                } => scene.rectangle(*corner, *edges, surface(material)?),
                Object::Sphere { sphere, material } => scene.sphere(*sphere, surface(material)?),
                Object::Mesh {
                    vertices,
                    triangles,
                } => {
                    scene.begin_object();
                    let first = scene.vertices(vertices);
                    for (material, triangles) in triangles {
                        scene.triangles(first, triangles, surface(material)?);
                    }
                }
            }
        }
        let scene = scene.build(self.camera)?;
        scene.check_details()?;
        Ok(scene)
    }
}
