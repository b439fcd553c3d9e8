//! Reading of each key of a scene file.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use glam::DVec3;
use sha2::{Digest as _, Sha256};

use super::material::surface;
use super::reader::{LARGEST, Source, Table, Value, quote};
use super::{Description, LARGEST_OTHER, MAX_VERTICES, read};
use crate::camera::{Camera, MAX_HALF_HEIGHT};
use crate::error::Error;
use crate::image::read::{self as image, ChannelKind, REC_709};
use crate::light::environment::{Environment, EnvironmentMap};

fn camera(table: &Table, unit: f64) -> Result<Camera, Error> {
    table.keys(&[&["eye", "target", "up", "fov_deg", "half_height"]])?;
    let half_height = match (table.get("fov_deg"), table.get("half_height")) {
        (Some(angle), None) => (0.5 * angle.number(0.001..=179.0)?.to_radians()).tan(),
        (None, Some(half)) => half.number(1e-5..=MAX_HALF_HEIGHT)?,
        _ => return Err(table.error("needs one of fov_deg and half_height, and not both")),
    };
    let point = |key| table.need(key)?.point();
    let [eye, target] = [point("eye")?, point("target")?].map(|p| p * unit);
    let camera = Camera::new(eye, target, point("up")?, half_height);
    let needs = "needs a target away from the eye and an upright that is not the line of sight";
    Some(camera)
        .filter(Camera::is_valid)
        .ok_or_else(|| table.error(needs))
}

/// Remaining budget of bytes, vertices and triangles.
pub(super) struct Limits {
    bytes: u64,
    vertices: usize,
    triangles: usize,
}

impl Limits {
    pub(super) fn vertices(&mut self, count: usize) -> Result<(), String> {
        consume(&mut self.vertices, count, "vertices")
    }

    pub(super) fn triangles(&mut self, count: usize) -> Result<(), String> {
        consume(&mut self.triangles, count, "triangles")
    }
}

fn consume(left: &mut usize, count: usize, what: &str) -> Result<(), String> {
    *left = left
        .checked_sub(count)
        .ok_or_else(|| format!("the scene has more than {MAX_VERTICES} {what}: use fewer"))?;
    Ok(())
}

/// State of the reading.
pub(super) struct Reading<'a> {
    folder: &'a Path,
    pub(super) unit: f64,
    pub(super) materials: HashSet<String>,
    pub(super) limits: Limits,
    pub(super) digest: Sha256,
    pub(super) notes: Vec<String>,
}

impl<'a> Reading<'a> {
    pub(super) fn of(
        source: &Source,
        name: &str,
        folder: &'a Path,
    ) -> Result<(Description, Self), Error> {
        let mut reading = Self {
            folder,
            unit: 1.0,
            materials: HashSet::new(),
            limits: Limits {
                bytes: LARGEST_OTHER,
                vertices: MAX_VERTICES,
                triangles: MAX_VERTICES,
            },
            digest: Sha256::new(),
            notes: Vec::new(),
        };
        reading.hash(source.text.as_bytes());
        let parsed = source.parse()?;
        let root = Table::root(source, &parsed);
        root.keys(&[&[
            "name",
            "unit",
            "background",
            "camera",
            "materials",
            "objects",
        ]])?;
        reading.unit = root.read_or("unit", 1.0, |unit| unit.number(1e-6..=1e6))?;
        let black = Environment::Uniform(DVec3::ZERO);
        let mut description = Description {
            name: root.read_or("name", name, |name| name.text())?.to_owned(),
            background: root.read_or("background", black, |value| reading.background(&value))?,
            camera: camera(&root.need("camera")?.table()?, reading.unit)?,
            materials: Vec::new(),
            objects: Vec::new(),
        };
        if let Some(materials) = root.get("materials") {
            for (name, value) in materials.table()?.entries() {
                if name.is_empty()
                    || name.chars().count() > 64
                    || name.chars().any(char::is_control)
                {
                    return Err(value.error("needs a name of 1 to 64 printable characters"));
                }
                reading.materials.insert(name.to_owned());
                description
                    .materials
                    .push((name.to_owned(), surface(&value.table()?)?));
            }
        }
        if let Some(objects) = root.get("objects") {
            for object in objects.array()? {
                let object = reading.object(&object.table()?, &description)?;
                description.objects.push(object);
            }
        }
        Ok((description, reading))
    }

    /// Reads the background: one radiance, or an image of all directions.
    fn background(&mut self, value: &Value) -> Result<Environment, Error> {
        if !value.is_table() {
            return Ok(Environment::Uniform(value.colour(0.0..=LARGEST)?));
        }
        let table = value.table()?;
        table.keys(&[&["image", "layer", "scale", "up", "front"]])?;
        let (image, bytes) = self.bytes_of(&table, "image")?;
        let layer = table.get("layer").map(|layer| layer.text()).transpose()?;
        let picture =
            image::decode(&image, &bytes, layer, "layer").map_err(|error| table.error(error))?;
        if !picture.has_primaries(REC_709) {
            let found = picture.primaries;
            return Err(table.error(format!(
                "has primaries {found:?}, not those of Rec. 709 and sRGB: convert its image"
            )));
        }
        if picture.is_cube {
            return Err(table.error("is a cube map: convert its image to longitude and latitude"));
        }
        if !matches!(
            picture.kind,
            ChannelKind::Rgb | ChannelKind::Luminance | ChannelKind::Grey
        ) {
            return Err(table.error(format!(
                "is no radiance in R, G, B, or of one channel: {}",
                picture.describe()
            )));
        }
        let [width, height] = picture.size;
        if width != 2 * height {
            self.notes.push(format!(
                "{} is {width} × {height} pixels and read by longitude and latitude, as the whole sphere, which is twice as \
                 wide as high; if it is another map, convert it",
                image.display()
            ));
        }
        let scale = table.read_or("scale", 1.0, |scale| scale.number(1e-9..=LARGEST))?;
        let axis = |key, default| table.read_or(key, default, |axis| axis.point());
        let (up, front) = (axis("up", DVec3::Z)?, axis("front", DVec3::X)?);
        let planes = &picture.values;
        let pixel =
            |i: usize| DVec3::from_array([0, 1, 2].map(|c| planes[c % planes.len()][i])) * scale;
        let pixels = (0..planes[0].len()).map(pixel).collect();
        EnvironmentMap::new(picture.size, pixels, up, front)
            .map(Environment::Map)
            .map_err(|message| table.error(format!("is no environment map: {message}")))
    }

    /// Reads the file that a key names, and adds its bytes to the scene's digest.
    pub(super) fn bytes_of(
        &mut self,
        table: &Table,
        key: &str,
    ) -> Result<(PathBuf, Vec<u8>), Error> {
        let value = table.need(key)?;
        let name = value.text()?;
        let path = self.folder.join(name);
        let bytes = read(&path, self.limits.bytes)
            .map_err(|error| value.error(format!("{} cannot be read: {error}", quote(name))))?;
        self.limits.bytes -= bytes.len() as u64;
        self.hash(&bytes);
        Ok((path, bytes))
    }

    /// Adds the bytes of a file to the scene's digest.
    fn hash(&mut self, bytes: &[u8]) {
        self.digest.update((bytes.len() as u64).to_le_bytes());
        self.digest.update(bytes);
    }
}
