//! Models by name, with their parameters: the scene files' vocabulary, and the table on the book's
//! page about them.

use std::fmt::Write as _;

use glam::DVec3;

use super::{Bsdf, OrenNayarForm};

/// A reflection model that scene files know by its name.
#[derive(Clone, Copy, Debug)]
pub struct NamedModel {
    /// The name, as in `model = "lambert"`.
    pub name: &'static str,
    /// A clause on the model for the table of models; empty if its name says all.
    pub about: &'static str,
    /// All parameters, in the order in which they are read. A key means the same in all models.
    pub parameters: &'static [Parameter],
    /// Makes the model from values of all its parameters.
    ///
    /// # Errors
    /// The name of the parameter whose value does not go with the others, and why.
    pub build: fn(&Values) -> Result<Bsdf, BadValue>,
}

/// A parameter of a [`NamedModel`].
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// The key in scene files.
    pub name: &'static str,
    /// The values that it takes.
    pub kind: ParameterKind,
    /// A clause with its meaning and unit; empty if its name says all.
    pub about: &'static str,
}

/// The values that a parameter takes.
#[derive(Clone, Copy, Debug)]
pub enum ParameterKind {
    /// A colour from 0 to 1 per channel, which is multiplied by the key `coefficient`.
    Colour,
    /// A number from the first to the second, both included.
    Number(f64, f64),
    /// One of these words; the first if there is none.
    Choice(&'static [&'static str]),
}

/// A value of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// A value of [`ParameterKind::Colour`], times the coefficient.
    Colour(DVec3),
    /// A value of [`ParameterKind::Number`].
    Number(f64),
    /// A word of [`ParameterKind::Choice`].
    Choice(&'static str),
}

/// The parameter whose value is refused, and the reason.
pub type BadValue = (&'static str, &'static str);

/// Values of all parameters of a model, by name.
#[derive(Clone, Debug, Default)]
pub struct Values(pub Vec<(&'static str, Value)>);

impl Values {
    /// Returns the value of a parameter.
    ///
    /// # Panics
    /// If the model has no such parameter.
    fn get(&self, name: &str) -> Value {
        let found = self.0.iter().find(|(other, _)| *other == name);
        found.expect("a parameter of the model").1
    }

    /// Returns the value of a colour.
    ///
    /// # Panics
    /// If the model has no colour of this name.
    pub fn colour(&self, name: &str) -> DVec3 {
        match self.get(name) {
            Value::Colour(colour) => colour,
            other => panic!("{name} is no colour: {other:?}"),
        }
    }

    /// Returns the value of a number.
    ///
    /// # Panics
    /// If the model has no number of this name.
    pub fn number(&self, name: &str) -> f64 {
        match self.get(name) {
            Value::Number(number) => number,
            other => panic!("{name} is no number: {other:?}"),
        }
    }

    /// Returns the word of a choice.
    ///
    /// # Panics
    /// If the model has no choice of this name.
    pub fn choice(&self, name: &str) -> &'static str {
        match self.get(name) {
            Value::Choice(word) => word,
            other => panic!("{name} is no choice: {other:?}"),
        }
    }
}

/// The albedo of a diffuse model.
pub(super) const ALBEDO: Parameter = colour("albedo", "");
/// The reflectance of a mirror.
const REFLECTANCE: Parameter = colour("reflectance", "");
/// The index of refraction of glass.
pub(super) const INDEX: Parameter = number(
    "index",
    [0.1, 10.0],
    "of refraction behind the front; in front of it is 1",
);
/// The roughness α of microfacets.
pub(super) const ALPHA: Parameter = number(
    "alpha",
    [0.001, 1.0],
    "the GGX roughness (width of the facets' slopes)",
);

/// A colour.
pub(super) const fn colour(name: &'static str, about: &'static str) -> Parameter {
    Parameter {
        name,
        kind: ParameterKind::Colour,
        about,
    }
}

/// A number in a range, both ends included.
pub(super) const fn number(
    name: &'static str,
    [low, high]: [f64; 2],
    about: &'static str,
) -> Parameter {
    Parameter {
        name,
        kind: ParameterKind::Number(low, high),
        about,
    }
}

pub(super) const BLACK: NamedModel = NamedModel {
    name: "black",
    about: "reflects nothing",
    parameters: &[],
    build: |_| Ok(Bsdf::Black),
};

pub(super) const LAMBERT: NamedModel = NamedModel {
    name: "lambert",
    about: "",
    parameters: &[ALBEDO],
    build: |values| {
        Ok(Bsdf::Lambert {
            albedo: values.colour("albedo"),
        })
    },
};

pub(super) const OREN_NAYAR: NamedModel = NamedModel {
    name: "oren-nayar",
    about: "",
    parameters: &[
        ALBEDO,
        number(
            "sigma",
            [0.0, 1.5],
            "the standard deviation of the facets' slope angle in radians",
        ),
        Parameter {
            name: "form",
            kind: ParameterKind::Choice(&["corrected", "printed"]),
            about: "printed as the report has equation (14)",
        },
    ],
    build: |values| {
        let form = match values.choice("form") {
            "printed" => OrenNayarForm::Printed,
            _ => OrenNayarForm::Corrected,
        };
        Ok(Bsdf::oren_nayar(
            values.colour("albedo"),
            values.number("sigma"),
            form,
        ))
    },
};

pub(super) const MIRROR: NamedModel = NamedModel {
    name: "mirror",
    about: "",
    parameters: &[REFLECTANCE],
    build: |values| {
        Ok(Bsdf::Mirror {
            reflectance: values.colour("reflectance"),
        })
    },
};

pub(super) const GLASS: NamedModel = NamedModel {
    name: "glass",
    about: "",
    parameters: &[INDEX],
    build: |values| {
        Ok(Bsdf::Glass {
            index: values.number("index"),
        })
    },
};

/// Returns the models as rows of a Markdown table: name, meaning and parameters with their ranges.
pub fn table() -> String {
    let mut rows = String::from("| `model` | keys |\n|---|---|\n");
    for model in super::MODELS {
        let parameter = |parameter: &Parameter| {
            let mut text = format!("`{}`", parameter.name);
            let about = match parameter.about {
                about if about.starts_with("of ") => format!(" {about}"),
                "" => String::new(),
                about => format!(", {about}"),
            };
            text += &about;
            match parameter.kind {
                ParameterKind::Colour => {}
                ParameterKind::Number(low, high) => {
                    let _ = write!(text, ", {low} to {high}");
                }
                ParameterKind::Choice(words) => {
                    let words = words.iter().enumerate().map(|(i, word)| match i {
                        0 => format!("`{word}` (default)"),
                        _ => format!("`{word}`"),
                    });
                    let _ = write!(text, ": {}", words.collect::<Vec<_>>().join(" or "));
                }
            }
            text
        };
        let keys: Vec<String> = model.parameters.iter().map(parameter).collect();
        let about = match (model.about, keys.is_empty()) {
            (about, true) => format!("none: {about}"),
            ("", false) => String::new(),
            (about, false) => format!("{about}: "),
        };
        let _ = writeln!(rows, "| `{}` | {about}{} |", model.name, keys.join("; "));
    }
    rows
}
