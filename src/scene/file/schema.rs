//! What each key of a scene file says.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};
use sha2::{Digest as _, Sha256};

use super::obj::{self, Obj};
use super::reader::{LARGEST, Source, Table, Value, shown};
use super::{Description, LARGEST_OTHER, MOST, Object, read};
use crate::bsdf::ggx::Ggx;
use crate::bsdf::rough_glass::RoughGlass;
use crate::bsdf::{Bsdf, OrenNayarForm};
use crate::camera::{Camera, WIDEST};
use crate::environment::{Environment, EnvironmentMap};
use crate::error::Error;
use crate::image;
use crate::scene::Surface;
use crate::scene::builder::{cuboid, is_sound, triangle_normal};
use crate::shape::Sphere;

/// The models with their own keys.
const MODELS: [(&str, &[&str]); 8] = [
    ("black", &[]),
    ("lambert", &["albedo", "coefficient"]),
    ("oren-nayar", &["albedo", "coefficient", "sigma", "form"]),
    ("eon", &["albedo", "coefficient", "roughness"]),
    ("mirror", &["reflectance", "coefficient"]),
    ("glass", &["index"]),
    ("rough-glass", &["index", "alpha"]),
    ("ggx", &["reflectance", "coefficient", "alpha"]),
];

/// The shapes with their own keys.
const SHAPES: [(&str, &[&str]); 5] = [
    ("rectangle", &["material", "corner", "edges"]),
    ("sphere", &["material", "centre", "radius", "zone", "inward"]),
    ("mesh", &["vertices", "faces", "scale", "rotate", "translate"]),
    ("box", &["material", "corners", "inward", "scale", "rotate", "translate"]),
    ("obj", &["material", "file", "scale", "rotate", "translate"]),
];

fn surface(table: &Table) -> Result<Surface, Error> {
    let (model, keys) = table.need("model")?.choice(&MODELS)?;
    table.keys(&[keys, &["model", "emission", "absorption"]])?;
    let or = |key, default| table.get(key).map_or(Ok(default), |value| value.number(0.0..=1.0));
    let share = |key| Ok(table.need(key)?.colour(0.0..=1.0)? * or("coefficient", 1.0)?);
    let number = |key, range| table.need(key)?.number(range);
    let bsdf = match model {
        "black" => Bsdf::Black,
        "lambert" => Bsdf::Lambert { albedo: share("albedo")? },
        "oren-nayar" => {
            let forms = [("corrected", OrenNayarForm::Corrected), ("printed", OrenNayarForm::Printed)];
            let form = table.get("form").map_or(Ok(OrenNayarForm::Corrected), |form| Ok(form.choice(&forms)?.1))?;
            Bsdf::oren_nayar(share("albedo")?, number("sigma", 0.0..=1.5)?, form)
        }
        "eon" => Bsdf::Eon { albedo: share("albedo")?, roughness: number("roughness", 0.0..=1.0)? },
        "mirror" => Bsdf::Mirror { reflectance: share("reflectance")? },
        "glass" => Bsdf::Glass { index: number("index", 0.1..=10.0)? },
        "rough-glass" => {
            let glass = RoughGlass { index: number("index", 0.1..=10.0)?, alpha: number("alpha", 0.001..=1.0)? };
            if !glass.is_valid() {
                return Err(table
                    .need("index")?
                    .fault("must differ from 1 by 0.001 at least: no facet bends light there"));
            }
            Bsdf::RoughGlass(glass)
        }
        _ => Bsdf::model(Ggx { reflectance: share("reflectance")?, alpha: number("alpha", 0.001..=1.0)? }),
    };
    let emission = table.get("emission").map_or(Ok(DVec3::ZERO), |value| value.colour(0.0..=LARGEST))?;
    Ok(Surface { bsdf, emission, absorption: or("absorption", 0.0)? })
}

fn camera(table: &Table, unit: f64) -> Result<Camera, Error> {
    table.keys(&[&["eye", "target", "up", "fov_deg", "half_height"]])?;
    let half_height = match (table.get("fov_deg"), table.get("half_height")) {
        (Some(angle), None) => (0.5 * angle.number(0.001..=179.0)?.to_radians()).tan(),
        (None, Some(half)) => half.number(1e-5..=WIDEST)?,
        _ => return Err(table.fault("needs one of fov_deg and half_height, and not both")),
    };
    let point = |key| table.need(key)?.point();
    let camera = Camera::new(point("eye")? * unit, point("target")? * unit, point("up")?, half_height);
    let needs = || table.fault("needs a target away from the eye and an upright that is not the line of sight");
    if camera.is_valid() { Ok(camera) } else { Err(needs()) }
}

/// How a mesh is put into the scene: scaled, rotated and moved, then taken in the file's unit.
struct Placement {
    scale: DVec3,
    rotation: Option<DQuat>,
    translation: DVec3,
    unit: f64,
}

impl Placement {
    fn of(table: &Table, unit: f64) -> Result<Self, Error> {
        let rotation = |value: Value| {
            let rotation = value.table()?;
            rotation.keys(&[&["axis", "degrees"]])?;
            let axis = rotation.need("axis")?.point()?.try_normalize();
            let axis = axis.ok_or_else(|| rotation.fault("needs an axis that is not zero"))?;
            let angle = rotation.need("degrees")?.number(-360.0..=360.0)?.to_radians();
            Ok(DQuat::from_axis_angle(axis, angle))
        };
        Ok(Self {
            scale: table.get("scale").map_or(Ok(DVec3::ONE), |scale| scale.colour(1e-9..=LARGEST))?,
            rotation: table.get("rotate").map(rotation).transpose()?,
            translation: table.get("translate").map_or(Ok(DVec3::ZERO), |value| value.point())?,
            unit,
        })
    }

    fn place(&self, vertices: &mut [DVec3]) {
        for vertex in vertices {
            let scaled = self.scale * *vertex;
            *vertex = (self.rotation.map_or(scaled, |q| q * scaled) + self.translation) * self.unit;
        }
    }
}

/// What may still be read.
pub(super) struct Limits {
    bytes: u64,
    vertices: usize,
    triangles: usize,
}

impl Limits {
    pub(super) fn vertices(&mut self, count: usize) -> Result<(), String> {
        spend(&mut self.vertices, count, "vertices")
    }

    pub(super) fn triangles(&mut self, count: usize) -> Result<(), String> {
        spend(&mut self.triangles, count, "triangles")
    }
}

fn spend(left: &mut usize, count: usize, what: &str) -> Result<(), String> {
    *left = left.checked_sub(count).ok_or_else(|| format!("the scene has more than {MOST} {what}: use fewer"))?;
    Ok(())
}

/// The triangles of a polygon, from its first corner.
pub(super) fn fan(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    corners[1..].windows(2).map(|edge| [corners[0], edge[0], edge[1]])
}

/// What has been read so far.
pub(super) struct Reading<'a> {
    folder: &'a Path,
    unit: f64,
    materials: HashSet<String>,
    limits: Limits,
    pub(super) digest: Sha256,
    pub(super) notes: Vec<String>,
}

impl<'a> Reading<'a> {
    pub(super) fn of(source: &Source, name: &str, folder: &'a Path) -> Result<(Description, Self), Error> {
        let limits = Limits { bytes: LARGEST_OTHER, vertices: MOST, triangles: MOST };
        let (digest, notes, materials) = (Sha256::new(), Vec::new(), HashSet::new());
        let mut reading = Self { folder, unit: 1.0, materials, limits, digest, notes };
        reading.hash(source.text.as_bytes());
        let parsed = source.parse()?;
        let root = Table::root(source, &parsed);
        root.keys(&[&["name", "unit", "background", "camera", "materials", "objects"]])?;
        if let Some(unit) = root.get("unit") {
            reading.unit = unit.number(1e-6..=1e6)?;
        }
        let mut description = Description {
            name: root.get("name").map_or(Ok(name), |name| name.text())?.to_owned(),
            background: root
                .get("background")
                .map_or(Ok(Environment::Uniform(DVec3::ZERO)), |value| reading.background(&value))?,
            camera: camera(&root.need("camera")?.table()?, reading.unit)?,
            materials: Vec::new(),
            objects: Vec::new(),
        };
        if let Some(materials) = root.get("materials") {
            for (name, value) in materials.table()?.rows() {
                if name.is_empty() || name.chars().count() > 64 || name.chars().any(char::is_control) {
                    return Err(value.fault("needs a name of 1 to 64 printable characters"));
                }
                reading.materials.insert(name.to_owned());
                description.materials.push((name.to_owned(), surface(&value.table()?)?));
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

    /// One radiance, or an image of all directions.
    fn background(&mut self, value: &Value) -> Result<Environment, Error> {
        if !value.is_table() {
            return Ok(Environment::Uniform(value.colour(0.0..=LARGEST)?));
        }
        let table = value.table()?;
        table.keys(&[&["image", "scale", "up", "front"]])?;
        let (image, bytes) = self.bytes_of(&table, "image")?;
        let picture = image::read::decode(&image, &bytes, None).map_err(|error| table.fault(error))?;
        let scale = table.get("scale").map_or(Ok(1.0), |scale| scale.number(1e-9..=LARGEST))?;
        let axis = |key, default| table.get(key).map_or(Ok(default), |axis| axis.point());
        let planes = &picture.values;
        let pixel =
            |i: usize| DVec3::new(planes[0][i], planes[1 % planes.len()][i], planes[2 % planes.len()][i]) * scale;
        let pixels = (0..planes[0].len()).map(pixel).collect();
        let map = EnvironmentMap::new(picture.size, pixels, axis("up", DVec3::Z)?, axis("front", DVec3::X)?);
        map.map(Environment::Map).map_err(|message| table.fault(format!("is no environment map: {message}")))
    }

    /// The bytes of the file that a key names, which become a part of what tells scenes apart.
    fn bytes_of(&mut self, table: &Table, key: &str) -> Result<(PathBuf, Vec<u8>), Error> {
        let value = table.need(key)?;
        let name = value.text()?;
        let path = self.folder.join(name);
        let bytes = read(&path, self.limits.bytes)
            .map_err(|error| value.fault(format!("{} cannot be read: {error}", shown(name))))?;
        self.limits.bytes -= bytes.len() as u64;
        self.hash(&bytes);
        Ok((path, bytes))
    }

    fn object(&mut self, table: &Table, description: &Description) -> Result<Object, Error> {
        let (shape, keys) = table.need("shape")?.choice(&SHAPES)?;
        table.keys(&[keys, &["shape"]])?;
        let known = |name: &str, value: &Value| {
            let is_known = self.materials.contains(name);
            if is_known {
                Ok(name.to_owned())
            } else {
                Err(value.fault(format!("is not known: {}", description.unknown(name))))
            }
        };
        let material = || table.need("material").and_then(|value| known(value.text()?, &value));
        let point = |key| Ok(table.need(key)?.point()? * self.unit);
        let inward = || table.get("inward").map_or(Ok(false), |inward| inward.truth());
        Ok(match shape {
            "rectangle" => {
                let (corner, material) = (point("corner")?, material()?);
                let edges = table.need("edges")?.two(Value::point)?.map(|edge| edge * self.unit);
                let [right, left] = edges.map(|edge| corner + edge);
                let opposite = right + edges[1];
                let halves = [[corner, right, opposite], [corner, opposite, left]];
                if halves.iter().any(|half| triangle_normal(*half).is_none()) {
                    return Err(table.fault("needs two edges that span an area"));
                }
                self.limits.triangles(2).map_err(|message| table.fault(message))?;
                Object::Rectangle { corner, edges, material }
            }
            "sphere" => {
                let any = f64::NEG_INFINITY..=f64::INFINITY;
                let zone = |zone: Value| zone.two(|z| z.number(any.clone()));
                let zone = table.get("zone").map_or(Ok([*any.start(), *any.end()]), zone)?.map(|z| z * self.unit);
                let radius = table.need("radius")?.number(1e-9..=LARGEST)? * self.unit;
                let sphere = Sphere { centre: point("centre")?, radius, zone, inward: inward()? };
                if !is_sound(&sphere) {
                    return Err(table.fault("needs a zone from a lower to a higher z that meets the sphere"));
                }
                Object::Sphere { sphere, material: material()? }
            }
            "box" => {
                let [low, high] = table.need("corners")?.two(Value::point)?;
                if !low.cmplt(high).all() {
                    return Err(
                        table.fault("needs the corner of the least x, y and z first, then that of the greatest")
                    );
                }
                let (mut vertices, triangles) = cuboid(low, high, inward()?);
                Placement::of(table, self.unit)?.place(&mut vertices);
                if triangles.iter().any(|t| triangle_normal(t.map(|i| vertices[i as usize])).is_none()) {
                    return Err(table.fault("is so flat or so small that a side has no area"));
                }
                let triangles = vec![(material()?, triangles.to_vec())];
                self.limits.triangles(12).map_err(|message| table.fault(message))?;
                Object::Mesh { vertices: vertices.to_vec(), triangles }
            }
            "mesh" => {
                let list = table.need("vertices")?.array()?;
                self.limits.vertices(list.len()).map_err(|message| table.fault(message))?;
                let mut vertices = list.map(|vertex| vertex.point()).collect::<Result<Vec<_>, _>>()?;
                Placement::of(table, self.unit)?.place(&mut vertices);
                let mut triangles = Vec::new();
                for (name, faces) in table.need("faces")?.table()?.rows() {
                    let mut all = Vec::new();
                    for face in faces.array()? {
                        let corners = face.array()?.map(|corner| corner.index(vertices.len()));
                        let corners = corners.collect::<Result<Vec<u32>, _>>()?;
                        if corners.len() < 3 {
                            return Err(face.fault("needs at least three corners for each face"));
                        }
                        self.limits.triangles(corners.len() - 2).map_err(|message| face.fault(message))?;
                        for triangle in fan(&corners) {
                            if triangle_normal(triangle.map(|i| vertices[i as usize])).is_none() {
                                return Err(
                                    face.fault(format!("has the triangle {triangle:?} without area: remove it"))
                                );
                            }
                            all.push(triangle);
                        }
                    }
                    triangles.push((known(name, &faces)?, all));
                }
                Object::Mesh { vertices, triangles }
            }
            _ => {
                let (value, material) = (table.need("file")?, material()?);
                let (path, bytes) = self.bytes_of(table, "file")?;
                let file = path.display().to_string();
                let Obj { mut vertices, mut triangles } =
                    obj::parse(&file, &String::from_utf8_lossy(&bytes), &mut self.limits)?;
                Placement::of(table, self.unit)?.place(&mut vertices);
                let before = triangles.len();
                triangles.retain(|triangle| triangle_normal(triangle.map(|i| vertices[i as usize])).is_some());
                let flat = before - triangles.len();
                if triangles.is_empty() {
                    return Err(value.fault("has no triangle with an area"));
                }
                if flat > 0 {
                    self.notes.push(format!("{file}: {flat} of {before} triangles have no area and are left out"));
                }
                Object::Mesh { vertices, triangles: vec![(material, triangles)] }
            }
        })
    }

    /// Adds the bytes of a file to what tells scenes apart.
    fn hash(&mut self, bytes: &[u8]) {
        self.digest.update((bytes.len() as u64).to_le_bytes());
        self.digest.update(bytes);
    }
}
