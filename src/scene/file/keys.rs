//! Refusals of unknown keys, and of lights without extent, with what to write in their place.

use std::f64::consts::PI;

use glam::DVec3;

use super::reader::{LARGEST, Table, Value, quote};
use super::synonyms::{advice, matches, normalized};
use crate::error::Error;
use crate::suggest::did_you_mean;

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

impl Table<'_> {
    /// Refuses keys other than these.
    pub fn keys(&self, valid: &[&[&str]]) -> Result<(), Error> {
        let valid = valid.concat();
        let mut keys = self.entries.keys();
        let Some(key) = keys.find(|key| !valid.contains(&key.get_ref().as_ref())) else {
            return Ok(());
        };
        let name = key.get_ref();
        refuse_lights(name, &self.value(name, &self.entries[key]))?;
        let place = if self.path.is_empty() {
            "a scene"
        } else {
            &self.path
        };
        let hint = advice(name, &valid).unwrap_or_else(|| did_you_mean(name, valid));
        let message = format!("{place} has no key {}{hint}", quote(name));
        Err(self.source.error_at(key.span().start, message))
    }
}

/// Refuses a table that describes a light without extent, whichever of its keys says so.
pub(super) fn refuse_light(table: &Table) -> Result<(), Error> {
    let keys = ["shape", "model", "type", "kind", "light"];
    for value in keys.iter().filter_map(|key| table.get(key)) {
        let lights = value
            .text()
            .map_or(Vec::new(), |text| matches(&LIGHTS, text));
        if let Some(light) = lights.first() {
            return Err(value.error(replacement(*light, Some(table))));
        }
    }
    Ok(())
}

/// Refuses a key for lights, and names the equivalent here.
pub(super) fn refuse_lights(key: &str, value: &Value) -> Result<(), Error> {
    let first = value.array().ok().and_then(|mut items| items.next());
    let table = first.as_ref().unwrap_or(value).table().ok();
    if let Some(light) = matches(&LIGHTS, key).first() {
        return Err(value.error(replacement(*light, table.as_ref())));
    }
    if !["light", "lights", "lamp", "lamps", "emitter", "emitters"].contains(&&*normalized(key)) {
        return Ok(());
    }
    table.as_ref().map_or(Ok(()), refuse_light)?;
    Err(value.error(
        "says nothing here: a light is an object whose material has emission = a radiance; background = a radiance is \
         light from everywhere; in place of a point light take a small sphere",
    ))
}

fn replacement(light: Light, table: Option<&Table>) -> String {
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
                format_point(centre.unwrap_or(DVec3::Z * 3.0)),
                emission.map_or_else(|| format!("{} for 1 W/sr", 1.0 / (PI * RADIUS * RADIUS)), format_colour),
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
                format_point(towards * SUN_DISTANCE),
                emission.map_or_else(|| format!("{} for 1 W/m²", 1.0 / (PI * squared_sine)), format_colour),
            )
        }
        Light::Spot => "is a spot light, which has no surface and no radiance: take a small rectangle or sphere whose \
                        material emits, and black rectangles or a black \"mesh\" around it with an opening for the beam"
            .to_owned(),
    }
}

/// Radius of the sphere that replaces a point.
const RADIUS: f64 = 0.01;
/// Radius (`SUN_RADIUS`) and distance of the sphere that replaces a direction: 0.29°, as the sun.
const SUN_RADIUS: f64 = 5.0;
const SUN_DISTANCE: f64 = 1000.0;

/// Writes a point as in a scene file.
fn format_point(v: DVec3) -> String {
    let [x, y, z] = v.to_array().map(|x| x + 0.0);
    format!("[{x}, {y}, {z}]")
}

/// Writes a colour as in a scene file.
fn format_colour(v: DVec3) -> String {
    if v == DVec3::splat(v.x) {
        v.x.to_string()
    } else {
        format_point(v)
    }
}
