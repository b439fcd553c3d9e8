//! Scenes that relations transform: the parts of a scene file that they know.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};
use whitefurnace::error::Error;
use whitefurnace::scene::Scene;
use whitefurnace::scene::file::Description;

use super::background::Background;

/// A scene file without unit, boxes, OBJ files and placements. Lengths, radiances
/// and angles are those of scene files.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneText {
    /// Radiance of rays that hit nothing.
    pub background: Background,
    /// The camera.
    pub camera: View,
    /// Materials by name.
    #[serde(default)]
    pub materials: BTreeMap<String, Material>,
    /// The objects.
    #[serde(default)]
    pub objects: Vec<Object>,
}

/// Three numbers: a point, a direction or a colour.
pub type Triple = [f64; 3];

/// A camera as scene files describe it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct View {
    /// Origin of the rays.
    pub eye: Triple,
    /// A point in the middle of the image.
    pub target: Triple,
    /// Direction that is upright in the image.
    pub up: Triple,
    /// Half of the image's height at distance 1.
    pub half_height: f64,
}

/// A material: its model's name and parameters, and what it emits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Material {
    /// Name of the model.
    pub model: String,
    /// Radiance emitted by the front.
    #[serde(default)]
    pub emission: Triple,
    /// Parameters of the model.
    #[serde(flatten)]
    pub parameters: toml::Table,
}

impl Material {
    /// Returns a material that emits nothing.
    pub(super) fn new<const N: usize>(model: &str, parameters: [(&str, toml::Value); N]) -> Self {
        let parameters = parameters.map(|(name, value)| (name.to_owned(), value));
        Self {
            model: model.to_owned(),
            emission: [0.0; 3],
            parameters: parameters.into_iter().collect(),
        }
    }
}

/// An object; materials by name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "shape", rename_all = "lowercase", deny_unknown_fields)]
pub enum Object {
    /// A parallelogram.
    Rectangle {
        /// Name of the material.
        material: String,
        /// One corner.
        corner: Triple,
        /// Edges from that corner.
        edges: [Triple; 2],
    },
    /// A sphere, or the part of one between two heights.
    Sphere {
        /// Name of the material.
        material: String,
        /// The centre.
        centre: Triple,
        /// The radius.
        radius: f64,
        /// Lowest and highest z, from the centre.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        zone: Option<[f64; 2]>,
        /// Whether its front is inside.
        #[serde(default)]
        inward: bool,
    },
    /// A mesh.
    Mesh {
        /// Vertices of all faces.
        vertices: Vec<Triple>,
        /// Faces of each material.
        faces: BTreeMap<String, Vec<Vec<u32>>>,
    },
}

/// A similarity: turned, then scaled, mirrored in x if so asked, and moved.
#[derive(Clone, Copy, Debug)]
pub struct Similarity {
    /// The rotation.
    pub rotation: DQuat,
    /// The scale, more than 0.
    pub scale: f64,
    /// Whether x changes its sign.
    pub mirrored: bool,
    /// The translation.
    pub translation: DVec3,
}

impl Similarity {
    /// The identity.
    pub const IDENTITY: Self = Self {
        rotation: DQuat::IDENTITY,
        scale: 1.0,
        mirrored: false,
        translation: DVec3::ZERO,
    };

    pub(super) fn direction(&self, v: Triple) -> Triple {
        let [x, y, z] = (self.rotation * DVec3::from(v)).to_array();
        [if self.mirrored { -x } else { x }, y, z]
    }

    fn vector(&self, v: Triple) -> Triple {
        self.direction(v).map(|x| x * self.scale)
    }

    fn point(&self, p: Triple) -> Triple {
        (DVec3::from(self.vector(p)) + self.translation).to_array()
    }
}

impl SceneText {
    /// Reads a scene file. `file` returns the bytes of the image that it names.
    ///
    /// # Errors
    /// The line and the message of the TOML reader, the message of `file`, or that of the image's
    /// reader.
    pub fn parse(
        text: &str,
        file: impl FnOnce(&str) -> Result<Vec<u8>, String>,
    ) -> Result<Self, String> {
        let mut scene: Self = toml::from_str(text).map_err(|error| {
            let at = error.span().map_or(0, |span| span.start);
            let line = 1 + text.bytes().take(at).filter(|byte| *byte == b'\n').count();
            format!("line {line}: {}", error.message())
        })?;
        if let Background::Sky(sky) = &mut scene.background {
            let bytes = file(&sky.image)?;
            sky.read(&bytes)?;
        }
        Ok(scene)
    }

    /// Returns the bytes of the image that the scene file names.
    ///
    /// # Errors
    /// A message if it names none.
    pub fn image(&self) -> Result<Vec<u8>, String> {
        match &self.background {
            Background::Sky(sky) => Ok(sky.file()),
            Background::Uniform(_) => Err("the scene has no image".to_owned()),
        }
    }

    /// Returns the scene file, without its [image](Self::image).
    ///
    /// # Panics
    /// Never: all of it has a form in TOML.
    pub fn text(&self) -> String {
        toml::to_string(self).expect("a scene in TOML")
    }

    /// Reads the scene file as programs do, but for the image of its sky.
    ///
    /// # Errors
    /// Those of [`Description::parse`], and [`Error::Option`] for a sky that is no environment map.
    pub fn description(&self) -> Result<Description, Error> {
        let without_sky = Self {
            background: Background::BLACK,
            ..self.clone()
        };
        let mut description = Description::parse("scene", &without_sky.text())?;
        description.background = self.background.environment().map_err(Error::Option)?;
        Ok(description)
    }

    /// Builds the scene as programs do.
    ///
    /// # Errors
    /// Those of [`Description::parse`] and [`Description::build`].
    pub fn build(&self) -> Result<Scene, Error> {
        self.description()?.build()
    }

    /// Returns whether a part of a sphere is cut out by heights.
    pub fn has_zones(&self) -> bool {
        let is_zone = |object: &Object| matches!(object, Object::Sphere { zone: Some(_), .. });
        self.objects.iter().any(is_zone)
    }

    /// Transforms camera and objects. Where the scene [has zones](Self::has_zones) the rotation
    /// must be about z.
    #[must_use]
    pub fn transformed(&self, by: &Similarity) -> Self {
        let mut scene = self.clone();
        let View {
            eye, target, up, ..
        } = &mut scene.camera;
        [*eye, *target, *up] = [by.point(*eye), by.point(*target), by.direction(*up)];
        scene.background.transform(by);
        for object in &mut scene.objects {
            match object {
                Object::Rectangle { corner, edges, .. } => {
                    *corner = by.point(*corner);
                    *edges = edges.map(|edge| by.vector(edge));
                    // A mirror image turns counter-clockwise into clockwise.
                    if by.mirrored {
                        edges.swap(0, 1);
                    }
                }
                Object::Sphere {
                    centre,
                    radius,
                    zone,
                    ..
                } => {
                    *centre = by.point(*centre);
                    *radius *= by.scale;
                    *zone = zone.map(|zone| zone.map(|z| by.scale * z));
                }
                Object::Mesh { vertices, faces } => {
                    vertices.iter_mut().for_each(|v| *v = by.point(*v));
                    if by.mirrored {
                        faces.values_mut().flatten().for_each(|face| face.reverse());
                    }
                }
            }
        }
        scene
    }

    /// Multiplies all emission, and the background, by a factor for each channel.
    #[must_use]
    pub fn tinted(&self, factor: DVec3) -> Self {
        let mut scene = self.clone();
        let tint = |colour: &mut Triple| *colour = (DVec3::from(*colour) * factor).to_array();
        scene.background.map_radiances(tint);
        scene
            .materials
            .values_mut()
            .for_each(|material| tint(&mut material.emission));
        scene
    }

    /// Returns the names of the materials that emit.
    pub fn emitters(&self) -> impl Iterator<Item = &String> {
        let emits = |material: &Material| material.emission != [0.0; 3];
        self.materials
            .iter()
            .filter(move |(_, material)| emits(material))
            .map(|(name, _)| name)
    }

    /// Returns whether a material has one of these models.
    pub fn uses(&self, models: &[&str]) -> bool {
        let is_one = |material: &Material| models.contains(&&*material.model);
        self.materials.values().any(is_one)
    }
}
