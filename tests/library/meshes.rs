//! Tests of meshes in scene files and OBJ files of other programs: area, side and material of faces
//! by closed forms, and the errors of invalid files.

use std::fs;

use glam::DVec2;
use whitefurnace::scene::file::{Description, Object, SceneFile};

use crate::prelude::*;

const HEAD: &str = "camera = { eye = [0, -4, 0], target = [0, 0, 0], up = [0, 0, 1], fov_deg = 40 }\n\
                    materials.lamp = { model = \"black\", emission = 1 }\n\
                    materials.\"dark red\" = { model = \"lambert\", albedo = [0.5, 0.1, 0.1] }\n";
const SQUARE: &str = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\n";
const CONCAVE: &str =
    "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv 0.5 0 1\nv 0.5 0 -0.5\nv -0.5 0 -0.5\nv -0.5 0 1\nv -1 0 1\n";

/// Loads a scene of one OBJ file, whose object has these additional keys.
fn loaded(mesh: &[u8], keys: &str) -> Result<SceneFile, Error> {
    let folder = folder();
    fs::write(folder.join("a.obj"), mesh).expect("written");
    let path = folder.join("scene.toml");
    fs::write(
        &path,
        format!("{HEAD}objects = [{{ shape = \"obj\", file = \"a.obj\"{keys} }}]"),
    )
    .expect("written");
    SceneFile::load(&path)
}

/// Returns the vector sum of the areas of a material's triangles, and the sum of their absolute
/// areas.
fn areas(description: &Description, material: &str) -> (DVec3, f64) {
    let (mut sum, mut size) = (DVec3::ZERO, 0.0);
    for object in &description.objects {
        let Object::Mesh {
            vertices,
            triangles,
        } = object
        else {
            panic!("a mesh")
        };
        for t in triangles
            .iter()
            .filter(|(name, _)| name == material)
            .flat_map(|(_, triangles)| triangles)
        {
            let [a, b, c] = t.map(|i| vertices[i as usize]);
            sum += 0.5 * (b - a).cross(c - a);
            size += 0.5 * (b - a).cross(c - a).length();
        }
    }
    (sum, size)
}

/// Compares the area of the faces of an OBJ file as seen from −y, and the notes in their order.
fn assert_faces(text: &str, area: f64, notes: &[&str]) {
    let file = loaded(text.as_bytes(), ", material = 'lamp'")
        .unwrap_or_else(|error| panic!("{text}: {error}"));
    let (found, (sum, size)) = (file.notes, areas(&file.description, "lamp"));
    assert_abs_diff_eq!(-sum.y, area, epsilon = 1e-12);
    assert!(size < area.abs() + 0.5, "{text}: {size}");
    assert!(
        found.len() <= notes.len() && found.iter().zip(notes).all(|(f, n)| f.contains(n)),
        "{text}: {found:?}"
    );
    assert_eq!(found.is_empty(), notes.is_empty(), "{text}: {found:?}");
}

#[test]
fn faces_have_their_area_and_side() {
    let square = |rest: &str| format!("{SQUARE}{rest}");
    for text in [
        square("f 1 2 3 4\n"),
        format!("\u{feff}{SQUARE}f 1 2 3 4"),
        format!("# two files in a row\n\u{feff}{SQUARE}f 1 2 3 4"),
        square("f 1 2 \\\n  3 4\n"),
        square("f 1 2 \\ \t\r\n3 4\n"),
        square("f 1 2\\\n\\\n3 4 \\"),
        square("# C:\\meshes\\\nf 1 2 3 # C:\\\no C:\\\nf 1 3 4 # C:\\\n"),
        square("f 1 2 3 4\n").replace('\n', "\r"),
        square("f 1 2 3 4\n").replace('\n', "\r\n"),
        square("f\t1/1/1\t2//1 3/3 4\n").replace("v -1 0", " v\t-1.0e+0 -0 "),
        // Invalid colours.
        square("f 1 2 3 4\n").replace(" -1\n", " -1 nan nan nan\n"),
        square("v 0 0 -1\nf 1 5 2 3 4\n"),
    ] {
        assert_faces(&text, 4.0, &[]);
    }
    for (face, area) in [
        ("f 1 2 3 4 5 6 7 8\n", 2.5),
        ("f 6 7 8 1 2 3 4 5\n", 2.5),
        ("f 8 7 6 5 4 3 2 1\n", -2.5),
        ("f 1 2 2 3 4 5 5 5 6 7 8 1\n", 2.5),
    ] {
        assert_faces(&format!("{CONCAVE}{face}"), area, &[]);
    }
    for face in ["f 1 2 3 4\n", "f 2 3 4 1\n"] {
        let dart = "v 0 0 -0.5\nv 1 0 -1\nv 0 0 1\nv -1 0 -1\n";
        assert_faces(&format!("{dart}{face}"), 1.5, &[]);
    }
    let weighted = "v 0 0 0 1.0\nv 2 0 0 0.5 0.5 0.5\nv 2 0 1 1\nf -3 -2 -1\n";
    assert_faces(weighted, 1.0, &[]);
    // Groups whose indices count back from their place.
    let groups = square("f -4 -3 -2 -1\n").repeat(2);
    assert_faces(
        &groups.replacen("v -1 0 -1", "v -3 0 -1", 1),
        6.0 + 4.0,
        &[],
    );
    // A frame: a square of side 2 whose hole of side 1 is joined by an edge traversed both ways.
    let frame = "v -0.5 0 -0.5\nv 0.5 0 -0.5\nv 0.5 0 0.5\nv -0.5 0 0.5\nf 1 2 3 4 1 5 8 7 6 5\n";
    assert_faces(&square(frame), 3.0, &[]);
}

#[test]
fn faces_that_are_odd_are_noted() {
    let weighted = "v 0 0 0 0.5\nv 2 0 0\nv 2 0 1\nfo 1 2 3\n";
    assert_faces(weighted, 1.0, &["1 vertices have a weight other than 1"]);
    let turned = "1 of 2 faces repeat an earlier one, 1 of them turned over";
    let left_out = "left out: \"cstype\" (1), \"l\" (2), \"p\" (1)";
    for (rest, area, notes) in [
        ("f 1 2 3 4\nf 4 3 2 1\n", 4.0, &[turned][..]),
        (
            "f 1 2 3 4\nf 2 3 4 1\nf 3 2 1 4\n",
            4.0,
            &["2 of 3 faces repeat an earlier one, 1 of them"],
        ),
        (
            "v 1 -0 1\nf 1 2 3\nf 5 2 1\n",
            2.0,
            &["1 of 2 faces repeat"],
        ),
        ("f 1 1 2 3\nf 3 2 1\n", 2.0, &[turned]),
        (
            "v 1 0.5 1\nf 1 2 5 4\n",
            4.0,
            &["1 of 1 faces are not flat"],
        ),
        (
            "mtllib a.mtl\nmtllib b.mtl\ng x\ns 1\nvt 0 0\nvn 0 1 0\nl 1 2\nl 2 3\np 1\ncstype bezier\nf 1 2 3 4\n",
            4.0,
            &["its mtllib is not read", left_out],
        ),
        (
            "f 1 2 3 4 4\nf 1 2 2\n",
            4.0,
            &["1 of 3 triangles have no area", "left out"],
        ),
    ] {
        assert_faces(&format!("{SQUARE}{rest}"), area, notes);
    }
}

/// Invalid OBJ files are refused with a message that ends in these words.
#[test]
fn what_is_no_face_and_no_obj_is_refused() {
    let utf16 =
        |order: fn(u16) -> [u8; 2]| SQUARE.encode_utf16().flat_map(order).collect::<Vec<u8>>();
    let stl = [&[b'x'; 80][..], &2u32.to_le_bytes(), &[0; 100]].concat();
    for (bytes, said) in [
        (
            format!("{SQUARE}f 1 3 2 4").into_bytes(),
            "line 5: the face crosses itself or folds back on itself",
        ),
        (
            format!("{CONCAVE}f 1 2 3 4 6 5 7 8").into_bytes(),
            "line 9: the face crosses itself or folds back on itself",
        ),
        (
            format!("{SQUARE}f 1 2 3 4 1 2 3 4").into_bytes(),
            "line 5: the face crosses itself or folds back",
        ),
        (
            format!("{SQUARE}f 1 2 \\\n3 5").into_bytes(),
            "line 5: a face's corner \"5\" is none of the 4 vertices",
        ),
        (
            format!("{SQUARE}f 1 2 0").into_bytes(),
            "line 5: a face's corner \"0\" is none of the 4 vertices",
        ),
        (
            b"v 0 0 -1.#IND\n".to_vec(),
            "line 1: a vertex needs three numbers",
        ),
        (
            b"\rv 0 0\r".to_vec(),
            "line 2: a vertex needs three numbers",
        ),
        (
            b"v 0,5 0 1,5".to_vec(),
            "line 1: a vertex needs three numbers",
        ),
        (
            b"newmtl red\nKd 1 0 0\n".to_vec(),
            "the file ends without a face: it is a library of materials (MTL)",
        ),
        (
            b"V 0 0 0\nF 1 1 1\n".to_vec(),
            "the file ends without a face; its other lines begin with \"F\" (1), \"V\" (1)",
        ),
        (b" \n".to_vec(), "the file is empty"),
        (
            b"ply\nformat ascii 1.0\n".to_vec(),
            "the file is a PLY mesh",
        ),
        (
            b"solid cube\nfacet normal 0 0 1\n".to_vec(),
            "the file is an STL mesh",
        ),
        (stl, "the file is an STL mesh"),
        (b"glTF\x02\0\0\0".to_vec(), "the file is a glTF scene (GLB)"),
        (
            b"{ \"asset\": {} }".to_vec(),
            "the file is JSON, perhaps a glTF scene",
        ),
        (
            b"Kaydara FBX Binary  \0".to_vec(),
            "the file is an FBX scene",
        ),
        (
            b"PK\x03\x04\0".to_vec(),
            "the file is a zip archive: unpack it",
        ),
        (b"\x89PNG\r\n".to_vec(), "the file is a PNG image"),
        (
            b"<!DOCTYPE html>\n".to_vec(),
            "the file is a web page (HTML)",
        ),
        (
            b"version https://git-lfs.github.com/spec/v1\n".to_vec(),
            "the file is a pointer of Git LFS",
        ),
        (
            [b"\xff\xfe".to_vec(), utf16(u16::to_le_bytes)].concat(),
            "the file is text in UTF-16: save it as UTF-8",
        ),
        (
            [b"\xfe\xff".to_vec(), utf16(u16::to_be_bytes)].concat(),
            "the file is text in UTF-16: save it as UTF-8",
        ),
        (
            utf16(u16::to_le_bytes),
            "the file is text in UTF-16, or binary: save it as UTF-8",
        ),
    ] {
        let message = refusal(loaded(&bytes, ", material = 'lamp'"), said);
        assert!(
            message.contains("a.obj, line ") && message.contains(said),
            "{said}: {message}"
        );
    }
}

/// Faces take the material that `usemtl` names if the scene has it, else the object's.
#[test]
fn usemtl_names_materials_of_the_scene() {
    let mesh = format!(
        "{SQUARE}{}",
        "f 1 2 3\nusemtl dark red # a comment\nf 1 3 4\nusemtl #glass\nf 2 3 4\n"
    );
    let load = |mesh: &str, keys: &str| loaded(mesh.as_bytes(), keys);
    let sizes =
        |file: &SceneFile| ["dark red", "lamp"].map(|name| areas(&file.description, name).1);
    let file = load(&mesh, ", material = 'lamp'").expect("a scene");
    assert_eq!((sizes(&file), file.notes.len()), ([2.0, 4.0], 1));
    let said = "a.obj: it uses materials that the scene lacks: \"#glass\"; these faces are of the object's material, \"lamp\"";
    assert!(file.notes[0].ends_with(said), "{:?}", file.notes);
    for (mesh, said) in [
        (&mesh[..], "a.obj, line 5: a face before any usemtl"),
        (
            &mesh.replace("f 1 2 3\n", ""),
            "scene.toml, line 4: objects.file uses materials that the scene lacks: \"#glass\"; add them, or give the object",
        ),
    ] {
        assert_refused(load(mesh, ""), said);
    }
    // A name that is a Windows path does not continue on the next line.
    let path = mesh.replace("dark red # a comment", "C:\\red\\");
    let file = load(&path, ", material = 'lamp'").expect("a scene");
    assert_eq!(sizes(&file), [0.0, 6.0]);
    assert!(
        file.notes[0].contains("lacks: \"C:\\\\red\\\\\", \"#glass\""),
        "{:?}",
        file.notes
    );
    let known = mesh.replace("f 1 2 3\n", "").replace("#glass", "lamp");
    let file = load(&known, "").expect("a scene");
    assert_eq!(sizes(&file), [2.0, 2.0]);
    assert!(file.notes.is_empty(), "{:?}", file.notes);
}

/// Triangulates polygons around the origin with random radii, corners within edges, repeated
/// corners, and some with a hole.
#[test]
fn random_polygons_are_divided_without_overlap() {
    let radii = || proptest::collection::vec((0.2..1.0, 0..3), 3..40);
    let frame = (
        any::<u32>(),
        (-1.0..1.0, -1.0..1.0, -1.0..1.0),
        any::<bool>(),
    );
    let count = context("").arguments(200) as u32;
    property(
        "polygons",
        count,
        &(radii(), radii(), frame),
        |(outer, inner, (first, axis, reversed))| {
            let ring = |radii: &[(f64, i32)], scale: f64| {
                let n = radii.len();
                let at = |i: usize| {
                    DVec2::from_angle(i as f64 / n as f64 * TAU) * (radii[i % n].0 * scale)
                };
                let corners = (0..n).flat_map(|i| match radii[i].1 {
                    0 => vec![at(i)],
                    1 => vec![at(i), 0.5 * (at(i) + at(i + 1))],
                    _ => vec![at(i), at(i)],
                });
                corners.collect::<Vec<DVec2>>()
            };
            // The hole's radii are below the distances of the outer chords.
            let mut polygon = ring(&outer, 1.0);
            if first % 2 == 0 && outer.len() > 8 {
                let mut hole = ring(&inner, 0.1);
                hole.push(hole[0]);
                polygon.push(polygon[0]);
                polygon.extend(hole.iter().rev());
            }
            let n = polygon.len();
            polygon.rotate_left(first as usize % n);
            if reversed {
                polygon.reverse();
            }
            let shoelace: f64 = (0..n)
                .map(|i| 0.5 * polygon[i].perp_dot(polygon[(i + 1) % n]))
                .sum();
            let normal = DVec3::new(axis.0, axis.1, axis.2)
                .try_normalize()
                .unwrap_or(DVec3::Z);
            let (u, v) = normal.any_orthonormal_pair();
            let list: Vec<String> = polygon
                .iter()
                .map(|p| format!("{:?}", (u * p.x + v * p.y).to_array()))
                .collect();
            let face: Vec<usize> = (0..n).collect();
            let text = format!(
                "{HEAD}objects = [{{ shape = 'mesh', vertices = [{}], faces = {{ lamp = [{face:?}] }} }}]",
                list.join(", ")
            );
            let description = Description::parse("polygon", &text)
                .unwrap_or_else(|error| panic!("{polygon:?}: {error}"));
            let (sum, size) = areas(&description, "lamp");
            assert_abs_diff_eq!(sum, normal * shoelace, epsilon = 1e-9);
            assert_abs_diff_eq!(size, shoelace.abs(), epsilon = 1e-9);
        },
    );
}

/// Fronts of mirrored meshes stay outside.
#[test]
fn a_negative_scale_mirrors() {
    let tetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    let mesh = "shape = 'mesh', vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], \
                faces = { lamp = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] }";
    for (scale, factor, corner) in [
        ("-1", 1.0, DVec3::NEG_ONE),
        ("[-1, 1, 1]", 1.0, DVec3::new(-1.0, 1.0, 1.0)),
        ("[1, -2, -3]", 6.0, DVec3::new(1.0, -2.0, -3.0)),
        ("2", 8.0, DVec3::splat(2.0)),
    ] {
        let obj = loaded(
            tetrahedron.as_bytes(),
            &format!(", material = 'lamp', scale = {scale}"),
        );
        let parsed = |object: &str| {
            Description::parse(
                "mirrored",
                &format!("{HEAD}objects = [{{ {object}, scale = {scale} }}]"),
            )
            .expect("a scene")
        };
        let cuboid = "shape = 'box', material = 'lamp', corners = [[0, 0, 0], [1, 1, 1]]";
        let inward = format!("{cuboid}, inward = true");
        for (scene, volume) in [
            (obj.expect("a scene").description, 1.0 / 6.0),
            (parsed(mesh), 1.0 / 6.0),
            (parsed(cuboid), 1.0),
            (parsed(&inward), -1.0),
        ] {
            let Object::Mesh {
                vertices,
                triangles,
            } = &scene.objects[0]
            else {
                panic!("a mesh")
            };
            let corners = triangles[0]
                .1
                .iter()
                .map(|t| t.map(|i| vertices[i as usize]));
            let found: f64 = corners.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum();
            assert_abs_diff_eq!(found, volume * factor, epsilon = 1e-12);
            let reach = vertices
                .iter()
                .fold(DVec3::ZERO, |reach, v| reach.max(v.abs()));
            assert_abs_diff_eq!(reach, corner.abs(), epsilon = 1e-12);
            assert!(
                vertices
                    .iter()
                    .all(|v| (*v * corner).cmpge(DVec3::ZERO).all())
            );
        }
    }
    for scale in ["0", "[1, 0, 1]", "-1e-10", "1e10", "nan"] {
        let keys = format!(", material = 'lamp', scale = {scale}");
        let refused = loaded(tetrahedron.as_bytes(), &keys);
        assert_refused(refused, "line 4: objects.scale must ");
    }
}
