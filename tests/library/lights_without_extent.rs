//! Tests of scene files with point, spot and directional lights, which the renderer does not have.

use whitefurnace::scene::file::{Description, Object};

use crate::prelude::*;

/// Three lines, so that messages name line 4.
const HEAD: &str =
    "camera = { eye = [0, -4, 0], target = [0, 0, 0], up = [0, 0, 1], fov_deg = 40 }\n\n\n";

/// A light without extent is refused with a sphere of the same intensity or irradiance, which can
/// be loaded.
#[test]
fn lights_without_extent_are_answered_with_numbers() {
    let parsed = |text: &str| Description::parse("lights", &format!("{HEAD}{text}"));
    let sphere = |text: &str| {
        let message = refusal(parsed(text), text);
        assert!(message.starts_with("scene lights, line 4: "), "{message}");
        let braced = |from: usize| {
            let start = from + message[from..].find('{').expect("{");
            message[start..=start + message[start..].find('}').expect("}")].to_owned()
        };
        let object = braced(0);
        let (name, of) = message
            .split_once("}, of ")
            .expect("its material")
            .1
            .split_once(" = ")
            .expect("its name");
        let material = braced(message.len() - of.len());
        let scene = format!("{HEAD}materials.{name} = {material}\nobjects = [{object}]");
        let mut scene = Description::parse("answer", &scene)
            .unwrap_or_else(|error| panic!("{message}: {error}"));
        let emission = scene.surface(name).expect("there").emission;
        let [Object::Sphere { sphere, .. }] = scene.objects[..] else {
            panic!("a sphere")
        };
        (
            sphere.centre,
            emission * (PI * sphere.radius * sphere.radius),
        )
    };
    let [point, five] = [DVec3::new(0.0, 1.0, 3.0), DVec3::splat(5.0)];
    for text in [
        "lights = [{ type = 'point', position = [0, 1, 3], intensity = 5 }]",
        "light = { kind = 'point', position = [0, 1, 3], intensity = [5, 5, 5] }",
        "point_light = { location = [0, 1, 3], intensity = 5 }",
        "objects = [{ shape = 'point', position = [0, 1, 3], intensity = 5 }]",
        "objects = [{ type = 'PointLight', position = [0, 1, 3], power = 62.83185307179586 }]",
    ] {
        let (centre, intensity) = sphere(text);
        assert_eq!(centre, point);
        assert_abs_diff_eq!(intensity, five, epsilon = 1e-12);
    }
    for text in [
        "lights = [{ type = 'directional', direction = [0, 0, -3], irradiance = 5 }]",
        "sun = { direction = [0, 0, -1], strength = 5 }",
    ] {
        let (centre, intensity) = sphere(text);
        assert_eq!(centre.normalize(), DVec3::Z);
        assert_abs_diff_eq!(intensity / centre.length_squared(), five, epsilon = 1e-12);
    }
    assert_refused(
        parsed("lights = [{ type = 'spot', angle = 30 }]"),
        "is a spot light",
    );
    assert_refused(
        parsed("lights = [{ type = 'area' }]"),
        "a light is an object whose material has emission",
    );
}
