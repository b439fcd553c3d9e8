//! Tests of the book's page on scene files: it has every model, key and range, and its example
//! renders.

use super::*;

/// Returns the book's page on scene files.
fn page() -> &'static str {
    include_str!("../../../book/pages/scenes.md")
}

/// Every named model is built from values at the ends of its ranges, and refuses the others; the
/// page's table has its name, keys and ranges.
#[test]
fn every_named_model_is_read_with_its_ranges() {
    let table = table();
    for model in MODELS {
        let scene = |bad: Option<&Parameter>, high: bool| {
            let mut text = format!("model = \"{}\"", model.name);
            for parameter in model.parameters {
                let is_bad = bad.is_some_and(|bad| bad.name == parameter.name);
                let value = match parameter.kind {
                    ParameterKind::Colour => {
                        (if is_bad { "1.5" } else { "[0, 0.5, 1]" }).to_owned()
                    }
                    ParameterKind::Number(_, top) if high => {
                        (if is_bad { top + 0.5 } else { top }).to_string()
                    }
                    ParameterKind::Number(low, _) => {
                        (if is_bad { low - 0.5 } else { low }).to_string()
                    }
                    ParameterKind::Choice(words) => {
                        format!("\"{}\"", if is_bad { "neither" } else { words[1] })
                    }
                };
                text += &format!(", {} = {value}", parameter.name);
            }
            Description::parse(
                "named",
                &format!(
                    "camera = {{ eye = [0, -5, 0], target = [0, 0, 0], \
                up = [0, 0, 1], fov_deg = 40 }}\nmaterials.it = {{ {text} }}\n\
                objects = [{{ shape = \"sphere\", material = \"it\", centre = [0, 0, 0], radius = 1 }}]"
                ),
            )
        };
        assert!(
            table.contains(&format!("| `{}` |", model.name)),
            "{}",
            model.name
        );
        for high in [false, true] {
            let built = scene(None, high).map(|description| description.build());
            assert!(matches!(built, Ok(Ok(_))), "{}: {built:?}", model.name);
            for parameter in model.parameters {
                assert!(
                    table.contains(&format!("`{}`", parameter.name)),
                    "{}",
                    parameter.name
                );
                assert_refused(scene(Some(parameter), high), parameter.name);
            }
        }
    }
}

/// The page's example is a scene that renders and has the properties that the page states.
#[test]
fn the_pages_example_renders() {
    let example = page()
        .split("```toml\n")
        .nth(1)
        .and_then(|rest| rest.split("```").next())
        .expect("an example");
    let description = Description::parse("example", example).expect("a scene");
    let sampling = sampling(Random, SamplerKind::Independent, master());
    let path = whitefurnace::integrator::Path::default();
    let scene = description.build().expect("a scene");
    let film = rendered(&scene, &path, [16, 12], sampling, &[0..16]).expect("rendered");
    assert!(
        film.pixels()
            .iter()
            .all(|pixel| pixel.mean().min_element() > 0.0),
        "light falls everywhere"
    );
}

/// The page names every key, model and shape that the loader accepts; the loader lists them when a
/// wrong one is given.
#[test]
fn the_page_has_every_key() {
    let mut seen = 0;
    for (what, instead) in [
        ("name = \"every key\"", "qqqqqqqqq = 1"),
        ("fov_deg = 90", "qqqqqqqqqqqq = 1"),
        ("axis = [0, 0, 2]", "qqqqqqqqqqqqqq = 1"),
        (
            "model = \"black\",",
            "model = \"qqqqqqqqqqqqqqqqqqqqqqqqq\",",
        ),
        ("shape = \"box\"", "shape = \"qqqqqqqqqqqqqqqqqqqqqqq\""),
        ("form = \"printed\"", "form = \"qqqqqqqqqqqqqqqqqqqqqq\""),
        ("emission", "qqqqqqqqqqqqqqqqqqqqq"),
        ("absorption", "qqqqqqqqqqqqqqqqqqqqq"),
        ("form =", "qqqqqqqqqqqqqqqqqqqqq ="),
        ("roughness", "qqqqqqqqqqqqqqqqqqqqq"),
        (
            "model = \"mirror\"",
            "model = \"mirror\", qqqqqqqqqqqqqqqqqqqqq = 1",
        ),
        ("index", "qqqqqqqqqqqqqqqqqqqqq"),
        ("alpha", "qqqqqqqqqqqqqqqqqqqqq"),
        ("edges", "qqqqqqqqqqqqqqqqqqqqqqqqqqqqq"),
        ("zone", "qqqqqqqqqqqqqqqqqqqqqqqqqqqqq"),
        ("vertices", "qqqqqqqqqqqqqqqqqqqqqqqqqqqqq"),
        ("corners", "qqqqqqqqqqqqqqqqqqqqqqqqqqqqq"),
        ("file", "qqqqqqqqqqqqqqqqqqqqqqqqqqqqq"),
    ] {
        let scene = EVERY_KEY
            .split_once('\n')
            .expect("a first line")
            .1
            .replacen(what, instead, 1);
        let path = written(scene.as_bytes(), PYRAMID.as_bytes());
        let message = refusal(SceneFile::load(&path), what);
        let (_, names) = message
            .split_once("; there is ")
            .unwrap_or_else(|| panic!("{what}: {message}"));
        for name in names.split(", ") {
            assert!(
                page().contains(&format!("`{name}`")) || table().contains(&format!("`{name}`")),
                "the page lacks {name}"
            );
            seen += 1;
        }
    }
    assert!(seen > 70, "{seen}");
}
