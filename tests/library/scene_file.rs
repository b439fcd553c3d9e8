//! Tests of scene files: the effect of each key, the errors with their words, and that no file
//! makes the loader panic.

mod page;
mod sky;

use std::fs;
use std::path::{Path, PathBuf};

use exr::meta::attribute::Chromaticities;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, ImageAttributes, IntegerBounds, Layer,
    LayerAttributes, Vec2, WritableImage as _,
};
use whitefurnace::light::environment::{Environment, EnvironmentMap};
use whitefurnace::material::MODELS;
use whitefurnace::material::ggx::Ggx;
use whitefurnace::material::named::{Parameter, ParameterKind, table};
use whitefurnace::material::rough_glass::RoughGlass;
use whitefurnace::scene::file::{Description, LARGEST_FILE, Object, SceneFile};
use whitefurnace::suggest::did_you_mean;

use crate::prelude::*;

const EVERY_KEY: &str = include_str!("data/scenes/every-key.toml");
const PYRAMID: &str = include_str!("data/scenes/pyramid.obj");

/// Writes a scene and its mesh to a folder of the running test's own.
fn written(scene: &[u8], mesh: &[u8]) -> PathBuf {
    let folder = folder();
    fs::write(folder.join("pyramid.obj"), mesh).expect("written");
    let path = folder.join("scene.toml");
    fs::write(&path, scene).expect("written");
    path
}

fn every_key() -> SceneFile {
    SceneFile::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("data/scenes/every-key.toml"))
        .expect("a scene")
}

/// A file with every key gives the scene that the library's functions build.
#[test]
fn every_key_says_what_the_page_says() {
    let rust = DVec3::new(0.25, 0.125, 0.0625);
    let surface = |bsdf| Surface::new(bsdf);
    let quarter = DVec3::splat(0.25);
    let steel = Bsdf::model(Ggx {
        reflectance: rust,
        alpha: 0.25,
    });
    let materials = [
        (
            "black",
            surface(Bsdf::Black).emitting(DVec3::new(4.0, 2.0, 1.0)),
        ),
        (
            "floor",
            surface(Bsdf::Lambert {
                albedo: DVec3::new(0.25, 0.125, 0.5),
            })
            .absorbing(0.25),
        ),
        (
            "chalk",
            surface(Bsdf::oren_nayar(
                DVec3::splat(0.5),
                0.25,
                OrenNayarForm::Printed,
            )),
        ),
        (
            "plaster",
            surface(Bsdf::oren_nayar(quarter, 0.25, OrenNayarForm::Corrected)),
        ),
        (
            "clay",
            surface(Bsdf::Eon {
                albedo: quarter,
                roughness: 0.75,
            }),
        ),
        ("mirror", reflecting(0.25)),
        ("glass", glass(1.25)),
        (
            "frosted",
            surface(Bsdf::RoughGlass(RoughGlass {
                index: 1.75,
                alpha: 0.5,
            })),
        ),
        ("brushed steel", surface(steel)),
    ];
    let SceneFile {
        description, notes, ..
    } = every_key();
    assert_eq!(description.name, "every key");
    assert_eq!(
        description.background,
        Environment::Uniform(DVec3::new(0.25, 0.5, 1.0))
    );
    let (eye, target) = (DVec3::new(0.0, -6.0, 2.0), DVec3::new(0.0, 0.0, 0.5));
    let camera = Camera::new(eye, target, DVec3::Z, (0.5 * FRAC_PI_2).tan());
    assert_eq!(description.camera, camera);
    assert_eq!(
        format!("{:?}", description.materials),
        format!("{:?}", materials.map(|(n, s)| (n.to_owned(), s)))
    );
    let half = |x, y, z| 0.5 * DVec3::new(x, y, z);
    let [rectangle, sphere, mesh, cuboid, obj] = &description.objects[..] else {
        panic!("five objects")
    };
    let lamp = Object::Rectangle {
        corner: half(-1.0, -1.0, 10.0),
        edges: [half(0.0, 2.0, 0.0), half(2.0, 0.0, 0.0)],
        material: "black".to_owned(),
    };
    assert_eq!(*rectangle, lamp);
    let bowl = inward(between_heights(
        Sphere::new(half(4.0, 0.0, 2.0), 0.5),
        [f64::NEG_INFINITY, 0.25],
    ));
    assert_eq!(
        *sphere,
        Object::Sphere {
            sphere: bowl,
            material: "glass".to_owned()
        }
    );
    let corners = [
        (-8.0, -8.0, -0.5),
        (8.0, -8.0, -0.5),
        (8.0, 8.0, -0.5),
        (-8.0, 8.0, -0.5),
        (0.0, 0.0, 5.5),
    ];
    let ground = Object::Mesh {
        vertices: corners.map(|(x, y, z)| half(x, y, z)).to_vec(),
        triangles: vec![
            ("floor".to_owned(), vec![[0, 1, 2], [0, 2, 3]]),
            ("chalk".to_owned(), vec![[2, 3, 4]]),
            ("plaster".to_owned(), vec![]),
        ],
    };
    assert_eq!(*mesh, ground);
    // Scaled to 1 × 2 × 4, rotated from x to y, then translated: x from −2 − 2 to −2, y from 0 to
    // 1, z from 1 to 5.
    let (low, high, volume, area) = measures(cuboid);
    assert_abs_diff_eq!(low, half(-4.0, 0.0, 1.0), epsilon = 1e-15);
    assert_abs_diff_eq!(high, half(-2.0, 1.0, 5.0), epsilon = 1e-15);
    assert_abs_diff_eq!(volume, 1.0, epsilon = 1e-14);
    assert_abs_diff_eq!(area, 28.0 / 4.0, epsilon = 1e-14);
    // A pyramid of side and height 2, without its degenerate triangle, in the same unit.
    let (low, high, volume, area) = measures(obj);
    assert_eq!((low, high), (half(0.0, -4.0, 0.0), half(2.0, -2.0, 2.0)));
    assert_abs_diff_eq!(volume, 8.0 / 3.0 / 8.0, epsilon = 1e-15);
    assert_abs_diff_eq!(area, (4.0 + 4.0 * 5f64.sqrt()) / 4.0, epsilon = 1e-15);
    let said = [
        "its mtllib is not read: the scene file has the materials, which usemtl names",
        "lines of other kinds are left out: \"l\" (1)",
        "it uses materials that the scene lacks: \"stone\"; these faces are of the object's material, \"brushed steel\"",
        "1 of 7 triangles have no area and are left out",
    ];
    assert_eq!(notes.len(), said.len());
    for (note, said) in notes.iter().zip(said) {
        assert!(note.ends_with(&format!("pyramid.obj: {said}")), "{note}");
    }
    assert_eq!(
        description.build().expect("a scene").primitives().count(),
        2 + 1 + 3 + 12 + 6
    );
}

/// Measures the least and greatest coordinates, the volume within outward fronts, and the area of
/// an object.
fn measures(object: &Object) -> (DVec3, DVec3, f64, f64) {
    let Object::Mesh {
        vertices,
        triangles,
    } = object
    else {
        panic!("a mesh")
    };
    let corners = triangles
        .iter()
        .flat_map(|(_, triangles)| triangles)
        .map(|t| t.map(|v| vertices[v as usize]));
    let (mut volume, mut area) = (0.0, 0.0);
    for [a, b, c] in corners {
        volume += a.dot(b.cross(c)) / 6.0;
        area += 0.5 * (b - a).cross(c - a).length();
    }
    let low = vertices.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    (
        low,
        vertices
            .iter()
            .copied()
            .fold(DVec3::NEG_INFINITY, DVec3::max),
        volume,
        area,
    )
}

/// The scenes that were compared with another renderer load with all their parts, except the foot
/// of a box that the floor covers.
#[test]
fn scenes_with_larger_meshes_load() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/scenes");
    for (name, parts) in [
        ("knot.toml", 12 + 72 * 8 * 2 + 12 + 2 + 2 + 1),
        ("glass-ball.toml", 3 + 2 + 2 + 8 * 4 * 4 * 4 + 1 + 12 - 2),
        ("hollow.toml", 1 + 7 + 5 + 4 + 8 * 4 * 4 * 4),
    ] {
        let SceneFile {
            description, notes, ..
        } = SceneFile::load(&folder.join(name)).expect("a scene");
        assert_eq!(
            description.build().expect("a scene").primitives().count(),
            parts,
            "{name}"
        );
        let bent = notes
            .iter()
            .all(|note| note.contains("576 of 576 faces are not flat"));
        assert_eq!(
            (notes.len(), bent),
            (usize::from(name == "knot.toml"), true),
            "{name}: {notes:?}"
        );
    }
}

/// Each case replaces a text of the scene above, or of its mesh if it begins with `OBJ`, and states
/// the resulting message.
#[test]
fn what_is_wrong_is_said_in_one_line_with_its_place() {
    for case in include_str!("data/scenes/refusals.txt")
        .lines()
        .filter(|line| !line.starts_with('#'))
    {
        let [what, instead, said] = case.split(" => ").collect::<Vec<_>>()[..] else {
            panic!("{case}")
        };
        let (in_mesh, what) = what
            .strip_prefix("OBJ ")
            .map_or((false, what), |what| (true, what));
        let [what, instead] = [what, instead].map(|text| text.replace("\\n", "\n"));
        let of = if in_mesh { PYRAMID } else { EVERY_KEY };
        assert_eq!(of.matches(&what).count(), 1, "{case}");
        let changed = of.replace(&what, &instead);
        let line = 1 + of[..of.find(&what).expect("there")].matches('\n').count();
        let (scene, mesh) = if in_mesh {
            (EVERY_KEY, &*changed)
        } else {
            (&*changed, PYRAMID)
        };
        let path = written(scene.as_bytes(), mesh.as_bytes());
        let message = refusal(SceneFile::load(&path), case);
        let file = if in_mesh {
            path.with_file_name("pyramid.obj")
        } else {
            path
        };
        // Some messages name the line where the table begins, as the key is missing.
        let at = said
            .split_once("; line ")
            .and_then(|(_, line)| line.parse().ok())
            .unwrap_or(line);
        let said = said.split("; line ").next().expect("a message");
        assert_eq!(
            message,
            format!("scene {}, line {at}: {said}", file.display()),
            "{case}"
        );
    }
}

#[test]
fn files_that_are_no_scenes_are_refused() {
    let scene = written(b"", b"");
    let folder = scene.parent().expect("a folder");
    let refused = |path: &Path, hint: &str| {
        let message = refusal(SceneFile::load(path), hint);
        assert!(message.contains(hint), "{message}");
        assert!(message.contains(&path.display().to_string()), "{message}");
    };
    refused(&folder.join("scene.toml"), "the file needs the key camera");
    refused(&folder.join("none.toml"), "cannot read");
    refused(folder, "no ordinary file");
    let big = folder.join("big.toml");
    fs::write(&big, vec![b'\n'; LARGEST_FILE as usize + 1]).expect("written");
    refused(&big, "more than 4194304 bytes");
    fs::write(&big, b"\n\nname = \"\xff\"").expect("written");
    refused(&big, "line 3: this is no text in UTF-8");
    let path = written(EVERY_KEY.replace("pyramid.obj", "none.obj").as_bytes(), b"");
    refused(&path, "line 58: objects.file \"none.obj\" cannot be read: ");
    for (mesh, said) in [
        (
            "v 0 0 0\nv 1 0 0\n\n",
            "pyramid.obj, line 3: the file ends without a face",
        ),
        (
            "",
            "pyramid.obj, line 1: the file is empty; a Wavefront OBJ file is needed",
        ),
        (
            "v 0 0 0\nv 1 0 0\nf 1 2 1\n",
            "scene.toml, line 58: objects.file has no triangle with an area",
        ),
    ] {
        let path = written(EVERY_KEY.as_bytes(), mesh.as_bytes());
        let message = refusal(SceneFile::load(&path), said);
        assert!(message.ends_with(said), "{message}");
    }
}

/// Scenes that differ in any of their files have different digests.
#[test]
fn the_digest_is_of_all_files() {
    let digest = |scene: &str, mesh: &str| {
        SceneFile::load(&written(scene.as_bytes(), mesh.as_bytes()))
            .expect("a scene")
            .digest
    };
    let base = digest(EVERY_KEY, PYRAMID);
    assert_eq!(base, every_key().digest);
    assert_eq!(base.len(), 64);
    assert_ne!(
        base,
        digest(&EVERY_KEY.replace("every key", "any key"), PYRAMID)
    );
    assert_ne!(
        base,
        digest(EVERY_KEY, &PYRAMID.replace("0.5 0.5 1", "0.5 0.5 2"))
    );
}

/// Values that a hostile file may hold in place of a number.
const VALUES: [&str; 16] = [
    "nan",
    "inf",
    "-1",
    "0",
    "1e308",
    "1e-320",
    "1e999",
    "99999999999999999999",
    "-0.0",
    "[]",
    "{}",
    "\"\"",
    "true",
    "1979-05-27",
    "0x7fffffffffffffff",
    "[[0]]",
];

/// Replaces the n-th number of a text, or some of its bytes.
fn mutated(text: &str, changes: &[(f64, usize, Vec<u8>)]) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    for (place, kind, noise) in changes {
        let at = ((bytes.len() - 1) as f64 * place) as usize;
        if *kind < VALUES.len() {
            let digit = |byte: &u8| byte.is_ascii_digit() || *byte == b'.';
            let Some(start) = bytes[at..].iter().position(digit).map(|after| at + after) else {
                continue;
            };
            let end = start
                + bytes[start..]
                    .iter()
                    .position(|byte| !digit(byte))
                    .unwrap_or(bytes.len() - start);
            bytes.splice(start..end, VALUES[*kind].bytes());
        } else {
            let end = bytes.len().min(at + kind - VALUES.len());
            bytes.splice(at..end, noise.iter().copied());
        }
    }
    bytes
}

#[test]
fn no_file_brings_the_loader_down() {
    let change = || {
        (
            0.0..1.0,
            0..VALUES.len() + 12,
            proptest::collection::vec(any::<u8>(), 0..6),
        )
    };
    let changes = || proptest::collection::vec(change(), 0..4);
    let counts = [0, 1].map(std::sync::atomic::AtomicU32::new);
    property(
        "hostile scenes",
        context("").arguments(3000) as u32,
        &(changes(), changes()),
        |(scene, mesh)| {
            let path = written(&mutated(EVERY_KEY, &scene), &mutated(PYRAMID, &mesh));
            let loaded = SceneFile::load(&path);
            counts[usize::from(loaded.is_ok())].fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            match loaded {
                Ok(file) => match file.description.build() {
                    Ok(scene) => {
                        for (x, y) in [(0.5, 0.5), (3.5, 2.5), (2.0, 1.5)] {
                            scene.intersect(&scene.camera().ray([4, 3], x, y));
                        }
                    }
                    // Numbers may be changed so that surfaces coincide, but not otherwise.
                    Err(error) => {
                        let message = error.to_string();
                        assert!(message.contains("lie in the same place"), "{message}");
                    }
                },
                Err(error) => {
                    let message = error.to_string();
                    let folder = path.parent().expect("a folder").display().to_string();
                    assert!(
                        message.contains(&folder) && message.contains(", line "),
                        "{message}"
                    );
                    assert!(
                        !message.contains(['\n', '\r']) && message.len() < 1000,
                        "{message}"
                    );
                }
            }
        },
    );
    // Both acceptance and refusal happen often.
    for count in counts {
        assert!(count.into_inner() > 150);
    }
}

#[test]
fn more_triangles_than_fit_are_refused_at_once() {
    // A polygon of 4097 corners, 1025 times over.
    let vertices: String = (0..4098)
        .map(|i| format!("v {} {} 0\n", i, i * i))
        .collect();
    let polygon: String = (1..4099).map(|i| format!(" {i}")).collect();
    let mesh = vertices + &format!("f{polygon}\n").repeat(1025);
    let path = written(EVERY_KEY.as_bytes(), mesh.as_bytes());
    assert_refused(SceneFile::load(&path), "more than 4194304 triangles");
}

#[test]
fn a_near_name_is_suggested_and_a_far_one_is_not() {
    assert_eq!(
        did_you_mean("fresnell", ["fresnel", "sphere"]),
        "; did you mean \"fresnel\"?"
    );
    assert_eq!(did_you_mean("xyz", ["fresnel"]), "; there is fresnel");
    assert_eq!(did_you_mean("xyz", [""; 0]), "; there are none yet");
    assert_eq!(did_you_mean("xyz", ["long name"; 13]), "");
    assert_eq!(
        did_you_mean(&"x".repeat(10_000_000), ["fresnel"]),
        "; there is fresnel"
    );
}
