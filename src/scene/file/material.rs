//! Materials of a scene file.

use glam::DVec3;

use super::keys::refuse_light;
use super::reader::{LARGEST, Table};
use crate::error::Error;
use crate::material::MODELS;
use crate::material::named::{Parameter, ParameterKind, Value, Values};
use crate::scene::Surface;

/// Reads a surface: a model of [`MODELS`] with its parameters, emission and absorption.
pub(super) fn surface(table: &Table) -> Result<Surface, Error> {
    refuse_light(table)?;
    let (_, model) = table
        .need("model")?
        .choice(&MODELS.map(|model| (model.name, model)))?;
    let has_colour = |parameter: &Parameter| matches!(parameter.kind, ParameterKind::Colour);
    let coefficient: &[&str] = if model.parameters.iter().any(has_colour) {
        &["coefficient"]
    } else {
        &[]
    };
    let keys: Vec<&str> = model.parameters.iter().map(|key| key.name).collect();
    table.keys(&[&keys, coefficient, &["model", "emission", "absorption"]])?;
    let or = |key, default| table.read_or(key, default, |value| value.number(0.0..=1.0));
    let value_of = |parameter: &Parameter| -> Result<(&'static str, Value), Error> {
        let name = parameter.name;
        let value = match parameter.kind {
            ParameterKind::Colour => {
                let colour = table.need(name)?.colour(0.0..=1.0)?;
                Value::Colour(colour * or("coefficient", 1.0)?)
            }
            ParameterKind::Number(low, high) => {
                Value::Number(table.need(name)?.number(low..=high)?)
            }
            ParameterKind::Choice(words) => {
                let choices: Vec<_> = words.iter().map(|word| (*word, ())).collect();
                let chosen = table.get(name).map(|value| value.choice(&choices));
                Value::Choice(chosen.transpose()?.map_or(words[0], |(word, ())| word))
            }
        };
        Ok((name, value))
    };
    let values: Result<Vec<_>, _> = model.parameters.iter().map(value_of).collect();
    let bsdf = match (model.build)(&Values(values?)) {
        Ok(bsdf) => bsdf,
        Err((key, why)) => return Err(table.need(key)?.error(why)),
    };
    Ok(Surface {
        bsdf,
        emission: table.read_or("emission", DVec3::ZERO, |v| v.colour(0.0..=LARGEST))?,
        absorption: or("absorption", 0.0)?,
    })
}
