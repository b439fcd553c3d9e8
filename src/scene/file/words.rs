//! Words of other programs' scenes, and what says the same here.

use std::f64::consts::PI;

use glam::DVec3;

use super::reader::{LARGEST, Table, Value};
use crate::error::Error;

/// Keys of other programs, and keys or values of this one that may be meant: the first that is
/// valid where the word stands. Words are in lower case without `-`, `_` and blanks.
const SYNONYMS: [(&str, &[&str]); 32] = [
    (
        "ior eta refraction refractiveindex indexofrefraction intior n",
        &["index"],
    ),
    (
        "color colour diffuse diffusecolor kd rgb basecolor rho reflectance albedo diffusereflectance specular \
         specularreflectance ks tint f0",
        &["albedo", "reflectance"],
    ),
    (
        "roughness rough alpha sigma",
        &["alpha", "sigma", "roughness"],
    ),
    (
        "position pos centre center location origin",
        &["centre", "eye", "corner", "translate"],
    ),
    ("from lookfrom", &["eye"]),
    ("lookat to at interest", &["target"]),
    ("fov vfov yfov angle fieldofview", &["fov_deg"]),
    (
        "emit emits emissive emittance ke le emissioncolor radiance luminance intensity power strength",
        &["emission"],
    ),
    (
        "radiance sky environment envmap ambient world emission",
        &["background"],
    ),
    ("filename path src url mesh", &["file", "image"]),
    ("texture map file", &["image"]),
    ("rotation orientation", &["rotate"]),
    ("scaling size", &["scale"]),
    ("translation move offset", &["translate"]),
    ("r size", &["radius"]),
    ("type kind", &["model", "shape"]),
    ("bsdf brdf shader", &["model", "material"]),
    ("mat", &["material"]),
    ("verts points positions p", &["vertices"]),
    ("indices triangles tris polygons", &["faces"]),
    ("min max bounds aabb", &["corners"]),
    (
        "flip flipnormals reverse reverseorientation inside",
        &["inward"],
    ),
    ("shapes geometry primitives spheres meshes", &["objects"]),
    ("material bsdfs", &["materials"]),
    ("units", &["unit"]),
    ("matte lambertian diffuse", &["lambert"]),
    (
        "metal conductor roughconductor microfacet glossy metallic",
        &["ggx"],
    ),
    ("dielectric refractive water", &["glass"]),
    (
        "roughdielectric frosted frostedglass roughglass",
        &["rough-glass"],
    ),
    ("specular reflective perfectmirror", &["mirror"]),
    ("ball uvsphere icosphere", &["sphere"]),
    ("null none", &["black"]),
];

/// Words without an equal here, and what to do instead.
const INSTEAD: [(&str, &str); 7] = [
    (
        "plastic roughplastic principled disney uber pbr phong blinn blinnphong coated standard",
        "no model has a coat: take \"lambert\" or \"eon\" for the body, \"ggx\" for metal",
    ),
    (
        "emissive emitter light area arealight diffuselight emission",
        "take \"black\" with emission = a radiance",
    ),
    (
        "plane quad square rect ground parallelogram",
        "take \"rectangle\" with a corner and two edges",
    ),
    ("cube cuboid aabb", "take \"box\" with two corners"),
    (
        "triangle polygon tri trimesh trianglemesh polymesh",
        "take \"mesh\" with vertices and faces",
    ),
    (
        "disc disk circle cylinder cone torus curve tube capsule",
        "take a \"mesh\" or \"obj\" that approximates it; a face may have any number of corners",
    ),
    (
        "ply stl gltf glb fbx usd wavefront",
        "convert the file to Wavefront OBJ and take \"obj\"",
    ),
];

/// Kinds of lights without extent.
const LIGHTS: [(&str, Light); 3] = [
    ("point pointlight omni bulb", Light::Point),
    (
        "directional directionallight distant distantlight sun sunlight parallel",
        Light::Directional,
    ),
    ("spot spotlight", Light::Spot),
];

#[derive(Clone, Copy)]
enum Light {
    Point,
    Directional,
    Spot,
}

fn plain(word: &str) -> String {
    word.chars()
        .filter(|c| !"-_ ".contains(*c))
        .take(64)
        .flat_map(char::to_lowercase)
        .collect()
}

fn find<T: Copy>(table: &[(&str, T)], word: &str) -> Vec<T> {
    let word = plain(word);
    table
        .iter()
        .filter(|(words, _)| words.split(' ').any(|known| known == word))
        .map(|(_, meaning)| *meaning)
        .collect()
}

/// A tail for messages about a word that is not valid, if other programs know it.
pub(super) fn advice(wrong: &str, valid: &[&str]) -> Option<String> {
    let meant = find(&SYNONYMS, wrong)
        .concat()
        .into_iter()
        .find(|meant| valid.contains(meant));
    let Some(meant) = meant else {
        // Advice on models and shapes, not on keys.
        let takes = |instead: &&str| {
            valid
                .iter()
                .any(|valid| instead.contains(&format!("\"{valid}\"")))
        };
        return find(&INSTEAD, wrong)
            .into_iter()
            .find(takes)
            .map(|instead| format!("; {instead}"));
    };
    let more = match (plain(wrong).as_str(), meant) {
        ("roughness" | "rough", "alpha") => {
            " It is the square of the roughness in Blender, glTF and Disney's model"
        }
        ("sigma" | "roughness" | "rough", "sigma") => " It is in radians",
        ("intensity" | "power" | "strength", "emission") => " It is a radiance: power / (π area)",
        (_, "fov_deg") => " It is the vertical angle in degrees",
        _ => "",
    };
    Some(format!("; did you mean \"{meant}\"?{more}"))
}

/// Refuses a table that describes a light without extent, whichever of its keys says so.
pub(super) fn refuse_light(table: &Table) -> Result<(), Error> {
    for value in ["shape", "model", "type", "kind", "light"]
        .iter()
        .filter_map(|key| table.get(key))
    {
        if let Some(light) = value
            .text()
            .ok()
            .and_then(|text| find(&LIGHTS, text).first().copied())
        {
            return Err(value.fault(instead(light, Some(table))));
        }
    }
    Ok(())
}

/// Refuses a key for lights, with what says the same here.
pub(super) fn refuse_lights(key: &str, value: &Value) -> Result<(), Error> {
    let first = value.array().ok().and_then(|mut items| items.next());
    let table = first.as_ref().unwrap_or(value).table().ok();
    if let Some(light) = find(&LIGHTS, key).first() {
        return Err(value.fault(instead(*light, table.as_ref())));
    }
    if !["light", "lights", "lamp", "lamps", "emitter", "emitters"].contains(&&*plain(key)) {
        return Ok(());
    }
    table.as_ref().map_or(Ok(()), refuse_light)?;
    Err(value.fault(
        "says nothing here: a light is an object whose material has emission = a radiance; background = a radiance is \
         light from everywhere; in place of a point light take a small sphere",
    ))
}

fn instead(light: Light, table: Option<&Table>) -> String {
    let get = |keys: &[&str]| keys.iter().find_map(|key| table?.get(key));
    let colour = |keys: &[&str]| get(keys).and_then(|value| value.colour(0.0..=LARGEST).ok());
    let point = |keys: &[&str]| get(keys).and_then(|value| value.point().ok());
    let intensity = || colour(&["intensity", "I"]);
    match light {
        Light::Point => {
            let centre = point(&["position", "pos", "location", "centre", "center", "from", "origin", "translate"]);
            let power = colour(&["power", "watts", "flux", "energy"]).map(|power| power / (4.0 * PI));
            let emission = intensity().or(power).map(|intensity| intensity / (PI * RADIUS * RADIUS));
            format!(
                "is a point light, which has no surface and no radiance: take a small sphere, {{ shape = \"sphere\", \
                 material = \"bulb\", centre = {}, radius = {RADIUS} }}, of bulb = {{ model = \"black\", emission = {} }}: \
                 intensity / (π radius²), or power / (4 π² radius²), for a radius in metres",
                place(centre.unwrap_or(DVec3::Z * 3.0)),
                emission.map_or_else(|| format!("{} for 1 W/sr", 1.0 / (PI * RADIUS * RADIUS)), written),
            )
        }
        Light::Directional => {
            let away = point(&["direction", "dir"]).map(|direction| -direction);
            let towards = away.and_then(DVec3::try_normalize).unwrap_or(DVec3::Z);
            let squared_sine = (SUN_RADIUS / SUN_DISTANCE).powi(2);
            let irradiance = colour(&["irradiance", "strength", "radiance"]).or_else(intensity);
            let emission = irradiance.map(|irradiance| irradiance / (PI * squared_sine));
            format!(
                "is a directional light, which has no solid angle and no radiance: take a distant sphere, {{ shape = \
                 \"sphere\", material = \"sun\", centre = {}, radius = {SUN_RADIUS} }}, of sun = {{ model = \"black\", \
                 emission = {} }}: irradiance · distance² / (π radius²), for a scene that is small and near the origin",
                place(towards * SUN_DISTANCE),
                emission.map_or_else(|| format!("{} for 1 W/m²", 1.0 / (PI * squared_sine)), written),
            )
        }
        Light::Spot => "is a spot light, which has no surface and no radiance: take a small rectangle or sphere whose \
                        material emits, and black rectangles or a black \"mesh\" around it with an opening for the beam"
            .to_owned(),
    }
}

/// The radius of the sphere in place of a point.
const RADIUS: f64 = 0.01;
/// The radius of the sphere in place of a direction, and its distance: 0.29°, as the sun.
const SUN_RADIUS: f64 = 5.0;
const SUN_DISTANCE: f64 = 1000.0;

/// A point as a scene file has it.
fn place(v: DVec3) -> String {
    let [x, y, z] = v.to_array().map(|x| x + 0.0);
    format!("[{x}, {y}, {z}]")
}

/// A colour as a scene file has it.
fn written(v: DVec3) -> String {
    if v == DVec3::splat(v.x) {
        v.x.to_string()
    } else {
        place(v)
    }
}
