//! Tests that `export` writes the scene, by reading it back, and refuses by name the features that
//! a format lacks.

use std::collections::BTreeSet;
use std::path::Path;

use experiments::export::{Renderer, files};
use glam::DVec3;
use roxmltree::{Document, Node};
use whitefurnace::camera::Camera;
use whitefurnace::error::Error;
use whitefurnace::geometry::shape::Sphere;
use whitefurnace::material::Bsdf;
use whitefurnace::scene::file::{Description, Object, SceneFile};
use whitefurnace::scene::simple::{Cap, cavity_cap, cornell, environment, furnace_box, glass_cube};
use whitefurnace::scene::{Geometry, Scene, Surface, room};

use crate::{folder, refused, run, text};

const EVERY_KEY: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../tests/library/data/scenes/every-key.toml"
);

/// Tests which renderer can represent which scene, or which feature is refused.
#[test]
fn what_cannot_be_said_is_refused_by_name() {
    let folder = folder("export");
    let frosted = "camera = { eye = [0, 0, 5], target = [0, 0, 0], up = [0, 1, 0], fov_deg = 40 }\n\
                   materials.pane = { model = \"rough-glass\", index = 1.5, alpha = 0.3 }\n\
                   objects = [{ shape = \"sphere\", material = \"pane\", centre = [0, 0, 0], radius = 1 }]\n";
    std::fs::write(folder.join("frosted.toml"), frosted).expect("written");
    // A lamp so near to the ceiling that both coincide in single precision.
    let near = "camera = { eye = [0, 0, 0], target = [0, 0, 1], up = [0, 1, 0], fov_deg = 40 }\n\
                materials.wall = { model = \"lambert\", albedo = 0.5 }\n\
                materials.lamp = { model = \"black\", emission = 1 }\n\
                objects = [{ shape = \"box\", material = \"wall\", corners = [[-1, -1, -1], [1, 1, 1]], inward = true },\n\
                { shape = \"rectangle\", material = \"lamp\", corner = [0, 0, 0.99999], edges = [[0, 0.5, 0], [0.5, 0, 0]] }]\n";
    std::fs::write(folder.join("near.toml"), near).expect("written");
    std::fs::write(folder.join("far.toml"), near.replace("0.99999", "0.9999")).expect("written");
    let together = Err(
        "it computes in single precision, in which object 1 (material wall) and object 2 (material lamp)",
    );
    let (oren_nayar, colour) = (Err("Oren-Nayar"), Err("spectral"));
    for (scene, [mitsuba, pbrt]) in [
        ("report", [oren_nayar, colour]),
        ("report --diffuse eon", [Err("EON"), colour]),
        ("report --diffuse ggx", [Err("GGX"), colour]),
        ("report --diffuse lambert", [Ok(()), colour]),
        ("diffuse-room", [Ok(()), colour]),
        ("environment", [Ok(()), Err("mirror")]),
        ("furnace-box", [Ok(()), Ok(())]),
        ("cavity-cap", [Err("zone"), Ok(())]),
        ("glass-cube", [Ok(()), Ok(())]),
        ("cornell", [Ok(()), colour]),
        (EVERY_KEY, [Err("zone"), colour]),
        ("near.toml", [together, together]),
        ("far.toml", [Ok(()), Ok(())]),
        ("frosted.toml", [Err("rough glass"), Err("rough glass")]),
    ] {
        for (to, file, expected) in [
            ("mitsuba", "scene.xml", mitsuba),
            ("pbrt", "scene.pbrt", pbrt),
        ] {
            let output = run(
                env!("CARGO_BIN_EXE_export"),
                &folder,
                &format!("--scene {scene} --to {to} --out {to}"),
            );
            let path = folder.join(to).join(file);
            match expected {
                Ok(()) => assert!(
                    output.status.success() && path.is_file(),
                    "{scene}: {}",
                    text(&output.stderr)
                ),
                Err(what) => refused(&output, what),
            }
            let _ = std::fs::remove_file(path);
        }
    }
    refused(
        &run(env!("CARGO_BIN_EXE_export"), &folder, "--scene cornell"),
        "--to",
    );
}

/// Writes a surface as the library's code; a surface that reflects nothing is black in two ways.
fn surface(surface: &Surface) -> String {
    let Surface { bsdf, emission, .. } = surface;
    let bsdf = if *bsdf == Bsdf::Black {
        Bsdf::Lambert {
            albedo: DVec3::ZERO,
        }
    } else {
        *bsdf
    };
    format!("{bsdf:?} {emission:?}")
}

fn is_named<'a>(node: &Node<'a, 'a>, name: &str) -> bool {
    node.attribute("name") == Some(name)
}

fn value<'a>(node: &Node<'a, 'a>, name: &str) -> &'a str {
    let child = node.descendants().find(|child| is_named(child, name));
    child
        .unwrap_or_else(|| panic!("no {name}"))
        .attribute("value")
        .expect("a value")
}

fn vector(text: &str) -> DVec3 {
    let numbers: Vec<f64> = text
        .split(", ")
        .map(|number| number.parse().expect("a number"))
        .collect();
    DVec3::from_slice(&numbers)
}

/// Returns the reflection model of the first `bsdf` in a node; all except glass are within a
/// two-sided one.
fn bsdf(node: &Node) -> Bsdf {
    let outer = node
        .descendants()
        .find(|node| node.has_tag_name("bsdf"))
        .expect("a model");
    if outer.attribute("type") == Some("dielectric") {
        assert_eq!(value(&outer, "ext_ior"), "1");
        return Bsdf::Glass {
            index: value(&outer, "int_ior").parse().expect("a number"),
        };
    }
    assert_eq!(outer.attribute("type"), Some("twosided"));
    let inner = outer.first_element_child().expect("a model");
    match inner.attribute("type") {
        Some("diffuse") => Bsdf::Lambert {
            albedo: vector(value(&inner, "reflectance")),
        },
        Some("conductor") => {
            assert_eq!(value(&inner, "material"), "none");
            Bsdf::Mirror {
                reflectance: vector(value(&inner, "specular_reflectance")),
            }
        }
        other => panic!("{other:?}"),
    }
}

/// Reads the parts of a scene, its background and its camera from XML.
fn read_back(files: &[(String, String)]) -> (BTreeSet<String>, DVec3, Camera) {
    let document = Document::parse(&files[0].1).expect("XML");
    let root = document.root_element();
    let children = |tag: &'static str| root.children().filter(move |node| node.has_tag_name(tag));
    let mut parts = BTreeSet::new();
    for shape in children("shape") {
        let emission = shape.children().find(|node| node.has_tag_name("emitter"));
        let emission = emission.map_or(DVec3::ZERO, |emitter| vector(value(&emitter, "radiance")));
        let surface = surface(&Surface::new(bsdf(&shape)).emitting(emission));
        if shape.attribute("type") == Some("sphere") {
            let centre = shape
                .children()
                .find(|node| is_named(node, "center"))
                .expect("a centre");
            let centre = ["x", "y", "z"].map(|axis| {
                centre
                    .attribute(axis)
                    .expect("a number")
                    .parse()
                    .expect("a number")
            });
            let radius = value(&shape, "radius").parse().expect("a number");
            let inward = value(&shape, "flip_normals") == "true";
            let sphere = Sphere {
                inward,
                ..Sphere::new(DVec3::from_array(centre), radius)
            };
            parts.insert(format!("{:?} {surface}", Geometry::Sphere(sphere)));
            continue;
        }
        assert_eq!(value(&shape, "face_normals"), "true");
        let name = value(&shape, "filename");
        let (_, mesh) = files
            .iter()
            .find(|(file, _)| file == name)
            .expect("its mesh");
        for triangle in triangles(mesh) {
            parts.insert(format!("{:?} {surface}", Geometry::Triangle(triangle)));
        }
    }
    let background = children("emitter")
        .next()
        .map_or(DVec3::ZERO, |sky| vector(value(&sky, "radiance")));
    let sensor = children("sensor").next().expect("a camera");
    assert_eq!(value(&sensor, "fov_axis"), "y");
    let look = sensor
        .descendants()
        .find(|node| node.has_tag_name("lookat"))
        .expect("where it looks");
    let [eye, target, up] =
        ["origin", "target", "up"].map(|name| vector(look.attribute(name).expect("a vector")));
    let degrees: f64 = value(&sensor, "fov").parse().expect("a number");
    (
        parts,
        background,
        Camera::new(eye, target, up, (0.5 * degrees).to_radians().tan()),
    )
}

/// Returns the triangles of an OBJ file, as the library's loader reads them.
fn triangles(mesh: &str) -> Vec<[DVec3; 3]> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    std::fs::write(folder.join("exported.obj"), mesh).expect("written");
    let scene = "camera = { eye = [0, 0, 5], target = [0, 0, 0], up = [0, 1, 0], fov_deg = 40 }\n\
                 materials.any = { model = \"black\" }\n\
                 objects = [{ shape = \"obj\", material = \"any\", file = \"exported.obj\" }]\n";
    let path = folder.join("exported.toml");
    std::fs::write(&path, scene).expect("written");
    let Description { objects, .. } = SceneFile::load(&path).expect("a mesh").description;
    let [
        Object::Mesh {
            vertices,
            triangles,
        },
    ] = &objects[..]
    else {
        panic!("one mesh")
    };
    triangles[0]
        .1
        .iter()
        .map(|triangle| triangle.map(|v| vertices[v as usize]))
        .collect()
}

#[test]
fn what_mitsuba_gets_is_the_scene() {
    let every_key = SceneFile::load(EVERY_KEY.as_ref())
        .expect("a scene")
        .description;
    // Without the features that Mitsuba lacks.
    let mut sayable = every_key;
    for material in ["chalk", "plaster", "clay", "brushed steel"] {
        sayable.surface(material).expect("there").bsdf = Bsdf::Mirror {
            reflectance: DVec3::new(0.25, 0.5, 1.0),
        };
    }
    for object in &mut sayable.objects {
        if let Object::Sphere { sphere, .. } = object {
            sphere.zone = [f64::NEG_INFINITY, f64::INFINITY];
        }
    }
    let scenes: [Result<Scene, Error>; 6] = [
        cornell(),
        room::diffuse(),
        environment(),
        furnace_box(0.75),
        glass_cube(false),
        sayable.build(),
    ];
    for scene in scenes {
        let scene = scene.expect("a scene");
        let files = files(&scene, Renderer::Mitsuba, [40, 30], 7, Some(2)).expect("files");
        let (parts, background, camera) = read_back(&files);
        let own: BTreeSet<String> = scene
            .primitives()
            .map(|(geometry, of)| format!("{geometry:?} {}", surface(of)))
            .collect();
        assert_eq!(parts, own, "{}", scene.name());
        assert_eq!(background, scene.background().radiance(DVec3::Z));
        for (x, y) in [(0.0, 0.0), (40.0, 0.0), (13.0, 30.0)] {
            let [a, b] = [&camera, scene.camera()].map(|camera| camera.ray([40, 30], x, y));
            assert!(
                a.origin == b.origin && a.direction.distance(b.direction) < 1e-12,
                "{}",
                scene.name()
            );
        }
        let xml = &files[0].1;
        for (name, value) in [("width", 40), ("height", 30), ("spp", 7), ("max_depth", 3)] {
            assert!(
                xml.contains(&format!("name=\"{name}\" value=\"{value}\"")),
                "{xml}"
            );
        }
    }
}

#[test]
fn what_pbrt_gets_is_the_scene() {
    let text = |scene: Result<Scene, Error>, size| {
        files(&scene.expect("a scene"), Renderer::Pbrt, size, 7, None)
            .expect("a file")
            .remove(0)
            .1
    };
    let cavity = text(cavity_cap(0.5, Cap::Black), [30, 40]);
    for part in [
        "Scale -1 1 1\nLookAt 0.3 -0.5 0.1  ",
        "\"integer xresolution\" [ 30 ] \"integer yresolution\" [ 40 ]",
        "Sampler \"independent\" \"integer pixelsamples\" [ 7 ]\nIntegrator \"path\" \"integer maxdepth\" [ 1000000 ]",
        "Material \"diffuse\" \"rgb reflectance\" [ 0.5 0.5 0.5 ]\nTranslate 0 0 0\nReverseOrientation\n\
         Shape \"sphere\" \"float radius\" [ 1 ] \"float zmin\" [ -1 ] \"float zmax\" [ 0.5 ]\n",
        "Material \"diffuse\" \"rgb reflectance\" [ 0 0 0 ]\nAreaLightSource \"diffuse\" \"rgb L\" [ 1 1 1 ]\n\
         Translate 0 0 0\nReverseOrientation\n\
         Shape \"sphere\" \"float radius\" [ 1 ] \"float zmin\" [ 0.5 ] \"float zmax\" [ 1 ]\n",
    ] {
        assert!(cavity.contains(part), "{part}: {cavity}");
    }
    // The angle of the shorter side: of the width in one case, of the height in the other.
    let angle = |text: &str| {
        text.split("\"float fov\" [ ")
            .nth(1)
            .expect("an angle")
            .split(' ')
            .next()
            .map(str::parse)
    };
    let expected = |half: f64| 2.0 * half.atan().to_degrees();
    for (text, half) in [
        (cavity, 0.3 * 0.75),
        (text(cavity_cap(0.5, Cap::Black), [40, 30]), 0.3),
    ] {
        let angle: f64 = angle(&text).expect("an angle").expect("a number");
        assert!((angle - expected(half)).abs() < 1e-12);
    }
    let cube = text(glass_cube(false), [4, 3]);
    let points = cube
        .split("\"point3 P\" [\n")
        .nth(1)
        .expect("points")
        .split(" ]")
        .next()
        .expect("points");
    let points: Vec<f64> = points
        .split_whitespace()
        .map(|number| number.parse().expect("a number"))
        .collect();
    let corners: Vec<DVec3> = points.chunks_exact(3).map(DVec3::from_slice).collect();
    let own = glass_cube(false).expect("a scene");
    let own: Vec<DVec3> = own
        .primitives()
        .flat_map(|(geometry, _)| match geometry {
            Geometry::Triangle(corners) => corners,
            Geometry::Sphere(_) => panic!("no sphere"),
        })
        .collect();
    assert_eq!(corners, own);
    assert!(cube.contains("Material \"dielectric\" \"float eta\" [ 1.5 ]"));
    assert!(cube.contains("LightSource \"infinite\" \"rgb L\" [ 1 1 1 ]"));
}
