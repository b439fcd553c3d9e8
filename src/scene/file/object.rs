//! Objects of a scene file.

use glam::{DQuat, DVec3};

use super::keys::refuse_light;
use super::obj::Name;
use super::polygon::Polygons;
use super::reader::{LARGEST, Table, Value, error_at_line, quote};
use super::schema::Reading;
use super::{Description, Object, obj};
use crate::error::Error;
use crate::geometry::shape::Sphere;
use crate::scene::builder::{cuboid, is_sound, triangle_normal};

/// Shapes with their own keys.
const SHAPES: [(&str, &[&str]); 5] = [
    ("rectangle", &["material", "corner", "edges"]),
    (
        "sphere",
        &["material", "centre", "radius", "zone", "inward"],
    ),
    (
        "mesh",
        &["vertices", "faces", "scale", "rotate", "translate"],
    ),
    (
        "box",
        &[
            "material",
            "corners",
            "inward",
            "scale",
            "rotate",
            "translate",
        ],
    ),
    ("obj", &["material", "file", "scale", "rotate", "translate"]),
];

/// Placement of a mesh in the scene: scaled, rotated and moved, then in the file's unit.
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
            let axis = axis.ok_or_else(|| rotation.error("needs an axis that is not zero"))?;
            let angle = rotation
                .need("degrees")?
                .number(-360.0..=360.0)?
                .to_radians();
            Ok(DQuat::from_axis_angle(axis, angle))
        };
        let scale = |value: Value| {
            let scale = value.colour(-LARGEST..=LARGEST)?;
            if scale.abs().min_element() < 1e-9 {
                let range = format!("must not be nearer to 0 than 1e-9, nor beyond {LARGEST}");
                return Err(value.error(range));
            }
            Ok(scale)
        };
        Ok(Self {
            scale: table.read_or("scale", DVec3::ONE, scale)?,
            rotation: table.get("rotate").map(rotation).transpose()?,
            translation: table.read_or("translate", DVec3::ZERO, |value| value.point())?,
            unit,
        })
    }

    /// Returns whether it turns counter-clockwise into clockwise.
    fn mirrors(&self) -> bool {
        self.scale.element_product() < 0.0
    }

    /// Returns a triangle whose front stays on the mirror image of its front.
    fn reoriented(&self, [a, b, c]: [u32; 3]) -> [u32; 3] {
        if self.mirrors() { [a, c, b] } else { [a, b, c] }
    }

    fn apply(&self, vertices: &mut [DVec3]) {
        for vertex in vertices {
            let scaled = self.scale * *vertex;
            *vertex = (self.rotation.map_or(scaled, |q| q * scaled) + self.translation) * self.unit;
        }
    }
}

impl Reading<'_> {
    pub(super) fn object(
        &mut self,
        table: &Table,
        description: &Description,
    ) -> Result<Object, Error> {
        refuse_light(table)?;
        let (shape, keys) = table.need("shape")?.choice(&SHAPES)?;
        table.keys(&[keys, &["shape"]])?;
        let wrong = |message: String| table.error(message);
        let known = |name: &str, value: &Value| {
            let material = self.materials.get(name).cloned();
            material
                .ok_or_else(|| value.error(format!("is not known: {}", description.unknown(name))))
        };
        let named = |value: Value| known(value.text()?, &value);
        let material = || table.need("material").and_then(named);
        let point = |key| Ok(table.need(key)?.point()? * self.unit);
        let inward = || table.read_or("inward", false, |inward| inward.truth());
        Ok(match shape {
            "rectangle" => {
                let (corner, material) = (point("corner")?, material()?);
                let edges = table
                    .need("edges")?
                    .two(Value::point)?
                    .map(|edge| edge * self.unit);
                let [right, left] = edges.map(|edge| corner + edge);
                let opposite = right + edges[1];
                let halves = [[corner, right, opposite], [corner, opposite, left]];
                if halves.iter().any(|half| triangle_normal(*half).is_none()) {
                    return Err(table.error("needs two edges that span an area"));
                }
                self.limits.triangles(2).map_err(wrong)?;
                Object::Rectangle {
                    corner,
                    edges,
                    material,
                }
            }
            "sphere" => {
                let any = f64::NEG_INFINITY..=f64::INFINITY;
                let zone = |zone: Value| zone.two(|z| z.number(any.clone()));
                let whole = [*any.start(), *any.end()];
                let zone = table.read_or("zone", whole, zone)?.map(|z| z * self.unit);
                let radius = table.need("radius")?.number(1e-9..=LARGEST)? * self.unit;
                let sphere = Sphere {
                    centre: point("centre")?,
                    radius,
                    zone,
                    inward: inward()?,
                };
                if !is_sound(&sphere) {
                    return Err(table
                        .error("needs a zone from a lower to a higher z that meets the sphere"));
                }
                Object::Sphere {
                    sphere,
                    material: material()?,
                }
            }
            "box" => {
                let [low, high] = table.need("corners")?.two(Value::point)?;
                if !low.cmplt(high).all() {
                    return Err(table.error(
                        "needs the corner of the least x, y and z first, then that of the greatest",
                    ));
                }
                let placement = Placement::of(table, self.unit)?;
                let (mut vertices, triangles) = cuboid(low, high, inward()? != placement.mirrors());
                placement.apply(&mut vertices);
                if triangles
                    .iter()
                    .any(|t| triangle_normal(t.map(|i| vertices[i as usize])).is_none())
                {
                    return Err(table.error("is so flat or so small that a side has no area"));
                }
                let triangles = vec![(material()?, triangles.to_vec())];
                self.limits.triangles(12).map_err(wrong)?;
                Object::Mesh {
                    vertices: vertices.to_vec(),
                    triangles,
                }
            }
            "mesh" => {
                let list = table.need("vertices")?.array()?;
                self.limits.vertices(list.len()).map_err(wrong)?;
                let mut vertices = list
                    .map(|vertex| vertex.point())
                    .collect::<Result<Vec<_>, _>>()?;
                let placement = Placement::of(table, self.unit)?;
                placement.apply(&mut vertices);
                let (mut triangles, mut polygons) = (Vec::new(), Polygons::default());
                for (name, faces) in table.need("faces")?.table()?.entries() {
                    let mut all = Vec::new();
                    for face in faces.array()? {
                        let corners = face.array()?.map(|corner| corner.index(vertices.len()));
                        let corners = corners.collect::<Result<Vec<u32>, _>>()?;
                        if corners.len() < 3 {
                            return Err(face.error("needs at least three corners for each face"));
                        }
                        self.limits
                            .triangles(corners.len() - 2)
                            .map_err(|message| face.error(message))?;
                        let divided = polygons.add(&vertices, &corners);
                        for triangle in divided
                            .map_err(|message| face.error(format!("has a face that {message}")))?
                        {
                            if triangle_normal(triangle.map(|i| vertices[i as usize])).is_none() {
                                return Err(face.error(format!(
                                    "has the triangle {triangle:?} without area: remove it"
                                )));
                            }
                            all.push(placement.reoriented(triangle));
                        }
                    }
                    triangles.push((known(name, &faces)?, all));
                }
                self.notes
                    .extend(polygons.notes().map(|note| table.note(note)));
                Object::Mesh {
                    vertices,
                    triangles,
                }
            }
            _ => {
                let value = table.need("file")?;
                let default = table.get("material").map(named).transpose()?;
                let (path, bytes) = self.bytes_of(table, "file")?;
                let file = path.display().to_string();
                let mut mesh = obj::parse(&file, &bytes, &mut self.limits)?;
                self.notes.append(&mut mesh.notes);
                let (mut names, mut lacking) = (Vec::new(), Vec::new());
                for Name { name, line } in mesh.materials {
                    let own = name.as_ref().filter(|name| self.materials.contains(*name));
                    match (own.or(default.as_ref()), &name) {
                        (Some(material), _) => names.push(material.clone()),
                        (None, Some(_)) => {}
                        (None, None) => {
                            let message = "a face before any usemtl, in an object of the scene file without a material";
                            return Err(error_at_line(file, line, message));
                        }
                    }
                    let foreign = name.as_ref().filter(|_| own.is_none());
                    lacking.extend(foreign.map(|name| quote(name)));
                }
                if !lacking.is_empty() {
                    let more = if lacking.len() > 8 {
                        format!(" and {} others", lacking.len() - 8)
                    } else {
                        String::new()
                    };
                    let lacking = format!(
                        "materials that the scene lacks: {}{more}",
                        lacking[..lacking.len().min(8)].join(", ")
                    );
                    let Some(material) = default else {
                        return Err(value.error(format!(
                            "uses {lacking}; add them, or give the object a material"
                        )));
                    };
                    self.notes.push(format!(
                        "{file}: it uses {lacking}; these faces are of the object's material, {}",
                        quote(&material)
                    ));
                }
                let placement = Placement::of(table, self.unit)?;
                let mut vertices = mesh.vertices;
                placement.apply(&mut vertices);
                let mut triangles = Vec::<(String, Vec<_>)>::new();
                // Index in `triangles` of each name.
                let place = |name: String| {
                    let known = triangles.iter().position(|(known, _)| *known == name);
                    known.unwrap_or_else(|| {
                        triangles.push((name, Vec::new()));
                        triangles.len() - 1
                    })
                };
                let places: Vec<usize> = names.into_iter().map(place).collect();
                let (before, mut flat) = (mesh.triangles.len(), 0);
                for (name, triangle) in mesh.triangles {
                    if triangle_normal(triangle.map(|i| vertices[i as usize])).is_some() {
                        let (_, of_name) = &mut triangles[places[name]];
                        of_name.push(placement.reoriented(triangle));
                    } else {
                        flat += 1;
                    }
                }
                if flat == before {
                    return Err(value.error("has no triangle with an area"));
                }
                if flat > 0 {
                    self.notes.push(format!(
                        "{file}: {flat} of {before} triangles have no area and are left out"
                    ));
                }
                Object::Mesh {
                    vertices,
                    triangles,
                }
            }
        })
    }
}
