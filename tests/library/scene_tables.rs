//! Tests every built-in scene against its table in `data/scenes.txt`: shapes, materials, emitters,
//! background and camera, in whatever order the scene lists them. A relative error of 1e-9 in a
//! constant is detected.

use std::collections::BTreeSet;

use whitefurnace::scene::file::{Description, Object};
use whitefurnace::scene::room::Walls;

use crate::camera::assert_rays;
use crate::prelude::*;

/// Normalises a text to words and numbers, the latter rounded to 1e-12, however they are written
/// and separated.
fn plain(text: &str) -> String {
    let words = text.split(|c: char| c.is_whitespace() || "()[]{},:".contains(c));
    let round = |x: f64| ((x * 1e12).round() / 1e12 + 0.0).to_string();
    let word = |word: &str| word.parse().map_or(word.to_owned(), round);
    words
        .filter(|word| !["", "DVec3"].contains(word))
        .map(word)
        .collect::<Vec<_>>()
        .join(" ")
}

/// Describes a shape in words; a triangle may start at any corner, but its orientation counts.
fn shape(geometry: Geometry) -> String {
    match geometry {
        Geometry::Triangle([a, b, c]) => {
            let turned = [[a, b, c], [b, c, a], [c, a, b]]
                .map(|corners| plain(&format!("triangle {corners:?}")));
            turned.into_iter().min().expect("three texts")
        }
        Geometry::Sphere(sphere) => plain(&format!("{sphere:?}")),
    }
}

fn light(emitter: &Emitter) -> String {
    let shape = match emitter.shape {
        EmitterShape::Triangle(corners) => shape(Geometry::Triangle(corners)),
        EmitterShape::Sphere(sphere) => shape(Geometry::Sphere(sphere)),
        EmitterShape::Rectangle { corner, edges } => {
            format!(
                "light {corner} {edges:?} normal {}",
                emitter.sample([0.25, 0.5]).normal
            )
        }
    };
    plain(&format!(
        "{shape} radiance {} area {}",
        emitter.radiance, emitter.area
    ))
}

/// Returns the lines of a section of the file.
fn section(name: &str) -> &'static str {
    let all = include_str!("data/scenes.txt");
    let sections = all
        .split("\n[")
        .filter_map(|section| section.strip_prefix(name)?.strip_prefix("]\n"));
    sections.last().expect("a section of this name")
}

/// Asserts that a scene consists of these sections of the file and of `more`.
fn check(scene: Result<Scene, Error>, name: &str, sections: &[&str], more: &str) {
    let scene = scene.expect("a scene");
    assert_eq!(scene.name(), name);
    let text = sections
        .iter()
        .map(|name| section(name))
        .chain([more])
        .collect::<Vec<_>>()
        .join("\n");
    let of = |what: &str| text.lines().find_map(|line| line.strip_prefix(what));
    let mut expected = vec![format!(
        "background {}",
        of("background").unwrap_or(" 0 0 0")
    )];
    for line in text.lines() {
        let numbers: Vec<f64> = line
            .split(' ')
            .filter_map(|word| word.parse().ok())
            .collect();
        let points: Vec<DVec3> = numbers.chunks_exact(3).map(DVec3::from_slice).collect();
        let [kind, name] = [0, 1].map(|i| line.split(' ').nth(i).unwrap_or_default());
        let mut part = |geometry| {
            let surface = of(&format!("surface {name} ")).expect("a surface");
            expected.push(format!("{} Surface bsdf {surface}", shape(geometry)));
            expected.extend(
                of(&format!("shining {name} "))
                    .map(|shining| format!("{} {shining}", shape(geometry))),
            );
        };
        match kind {
            "polygon" => {
                for edge in points[1..].windows(2) {
                    part(Geometry::Triangle([points[0], edge[0], edge[1]]));
                }
            }
            "ball" => {
                let zone = numbers
                    .get(4..6)
                    .map_or([f64::NEG_INFINITY, f64::INFINITY], |zone| {
                        [zone[0], zone[1]]
                    });
                let inward = line.ends_with("inward");
                part(Geometry::Sphere(Sphere {
                    zone,
                    inward,
                    ..Sphere::new(points[0], numbers[3])
                }));
            }
            "light" => expected.push(line.to_owned()),
            "camera" => assert_rays(
                scene.camera(),
                [points[0], points[1], points[2]],
                numbers[9],
            ),
            _ => {}
        }
    }
    let mut found = vec![format!(
        "background {}",
        scene.background().radiance(DVec3::Z)
    )];
    found.extend(
        scene
            .primitives()
            .map(|(geometry, surface)| format!("{} {surface:?}", shape(geometry))),
    );
    found.extend(scene.emitters().iter().map(light));
    assert_eq!(found.len(), expected.len(), "{name}");
    let [found, expected] = [found, expected].map(|lines| {
        lines
            .iter()
            .map(|line| plain(line))
            .collect::<BTreeSet<_>>()
    });
    let [lacks, has] =
        [expected.difference(&found), found.difference(&expected)].map(Vec::from_iter);
    assert!(
        lacks.is_empty() && has.is_empty(),
        "{name} lacks {lacks:#?} and has {has:#?}"
    );
}

#[test]
fn simple_scenes() {
    check(simple::environment(), "environment", &["environment"], "");
    check(simple::cornell(), "cornell", &["cornell"], "");
    for (inside, eye) in [
        (false, "glass-cube, from outside"),
        (true, "glass-cube, from inside"),
    ] {
        check(
            simple::glass_cube(inside),
            "glass-cube",
            &["glass-cube", eye],
            "",
        );
    }
    for a in [0.0, 0.5, 0.75] {
        let lit = format!(
            "Lambert albedo {a} {a} {a} emission 1 1 1 absorption {}",
            1.0 - a
        );
        check(
            simple::furnace_box(a),
            "furnace-box",
            &["furnace-box"],
            &format!("surface wall {lit}"),
        );
        let dark = format!(
            "surface dark Lambert albedo {a} {a} {a} emission 0 0 0 absorption {}",
            1.0 - a
        );
        for (cap, lit) in [
            (Cap::Reflecting, &*lit),
            (Cap::Black, "Black emission 1 1 1 absorption 0"),
        ] {
            check(
                simple::cavity_cap(a, cap),
                "cavity-cap",
                &["cavity-cap"],
                &format!("{dark}\nsurface lit {lit}"),
            );
        }
    }
    assert_eq!(simple::CAP_SHARE, 0.25);
}

/// The file of the report's room is the room with physical rules, before a convention or a trial
/// changes it.
#[test]
fn the_rooms_file_is_the_physical_room() {
    let file = Description::parse("report", include_str!("../../src/scene/files/report.toml"))
        .expect("a scene");
    let room = room::report(Convention::Physical, OrenNayarForm::Corrected).expect("a scene");
    let parts = |scene: &Scene| {
        scene
            .primitives()
            .map(|part| format!("{part:?}"))
            .collect::<Vec<_>>()
    };
    assert_eq!(parts(&file.build().expect("a scene")), parts(&room));
    assert!(file.objects.contains(&Object::Sphere {
        sphere: room::WHITE_SPHERE,
        material: "white".to_owned()
    }));
}

#[test]
fn rooms() {
    for (walls, colours) in [(Walls::Coloured, "coloured"), (Walls::Grey, "grey")] {
        check(
            room::diffuse_with(walls),
            "diffuse-room",
            &["room", colours, "diffuse-room"],
            "",
        );
        for form in [OrenNayarForm::Corrected, OrenNayarForm::Printed] {
            // A and B of Oren and Nayar at σ = 0.3: σ² = 0.09.
            let rough = [0.55, 1.0 - 0.5 * 0.09 / 0.42, 0.45 * 0.09 / 0.18];
            for (convention, [albedo, a, b]) in [
                (Convention::Physical, rough),
                (Convention::Report, rough),
                (Convention::Published, [1.0, 1.0, 0.0]),
            ] {
                let white = format!(
                    "surface white OrenNayar albedo {albedo} {albedo} {albedo} constants OrenNayar a {a} b {b} \
                     form {form:?} emission 0 0 0 absorption 0"
                );
                let scene = room::report_with(convention, form, walls);
                check(scene, "report", &["room", colours, "report"], &white);
            }
        }
    }
}
