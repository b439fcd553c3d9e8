//! Materials of a scene file.

use glam::DVec3;

use super::keys::refuse_light;
use super::reader::{LARGEST, Table};
use crate::error::Error;
use crate::material::ggx::Ggx;
use crate::material::rough_glass::RoughGlass;
use crate::material::{Bsdf, OrenNayarForm};
use crate::scene::Surface;

/// Models with their own keys.
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

pub(super) fn surface(table: &Table) -> Result<Surface, Error> {
    refuse_light(table)?;
    let (model, keys) = table.need("model")?.choice(&MODELS)?;
    table.keys(&[keys, &["model", "emission", "absorption"]])?;
    let or = |key, default| {
        table
            .get(key)
            .map_or(Ok(default), |value| value.number(0.0..=1.0))
    };
    let share = |key| Ok(table.need(key)?.colour(0.0..=1.0)? * or("coefficient", 1.0)?);
    let number = |key, range| table.need(key)?.number(range);
    let bsdf = match model {
        "black" => Bsdf::Black,
        "lambert" => Bsdf::Lambert {
            albedo: share("albedo")?,
        },
        "oren-nayar" => {
            let forms = [
                ("corrected", OrenNayarForm::Corrected),
                ("printed", OrenNayarForm::Printed),
            ];
            let form = table
                .get("form")
                .map_or(Ok(OrenNayarForm::Corrected), |form| {
                    Ok(form.choice(&forms)?.1)
                })?;
            Bsdf::oren_nayar(share("albedo")?, number("sigma", 0.0..=1.5)?, form)
        }
        "eon" => Bsdf::Eon {
            albedo: share("albedo")?,
            roughness: number("roughness", 0.0..=1.0)?,
        },
        "mirror" => Bsdf::Mirror {
            reflectance: share("reflectance")?,
        },
        "glass" => Bsdf::Glass {
            index: number("index", 0.1..=10.0)?,
        },
        "rough-glass" => {
            let glass = RoughGlass {
                index: number("index", 0.1..=10.0)?,
                alpha: number("alpha", 0.001..=1.0)?,
            };
            if !glass.is_valid() {
                return Err(table
                    .need("index")?
                    .error("must differ from 1 by 0.001 at least: no facet bends light there"));
            }
            Bsdf::RoughGlass(glass)
        }
        _ => Bsdf::model(Ggx {
            reflectance: share("reflectance")?,
            alpha: number("alpha", 0.001..=1.0)?,
        }),
    };
    let emission = table
        .get("emission")
        .map_or(Ok(DVec3::ZERO), |value| value.colour(0.0..=LARGEST))?;
    Ok(Surface {
        bsdf,
        emission,
        absorption: or("absorption", 0.0)?,
    })
}
