//! Tests of `metamorphic`: the hunt, one scene file, refusals, the generator and the reducer.

use std::collections::BTreeSet;

use std::path::Path;

use experiments::metamorphic::write_finding;
use trials::metamorphic::{
    Background, Case, Found, Material, Object, SceneText, generate, reduce, relation_named,
};
use whitefurnace::light::environment::Environment;
use whitefurnace::scene::file::SceneFile;

use crate::{folder, run, text};

/// A ball under a sky.
const BALL: &str = r#"
background = [1.0, 0.5, 0.2]
camera = { eye = [0.0, -5.0, 0.0], target = [0.0, 0.0, 0.0], up = [0.0, 0.0, 1.0], half_height = 0.4 }
materials.clay = { model = "lambert", albedo = [0.8, 0.4, 0.2] }
objects = [{ shape = "sphere", material = "clay", centre = [0.0, 0.0, 0.0], radius = 1.0 }]
"#;

#[test]
fn scenes_are_tested_and_counted() {
    let folder = folder("metamorphic");
    let run = |options: &str| run(env!("CARGO_BIN_EXE_metamorphic"), &folder, options);
    let output = run("--scenes 2 --seed 3 --relation colours");
    let lines = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{lines}");
    assert!(lines.starts_with("2 scenes from seed 3\n"), "{lines}");
    let row = |lines: &str| -> Vec<String> {
        let last = lines.lines().last().expect("a row");
        last.split_whitespace().map(str::to_owned).collect()
    };
    assert_eq!(row(&lines)[0], "colours");
    let counts: u32 = row(&lines)[1..]
        .iter()
        .map(|n| n.parse::<u32>().expect("a count"))
        .sum();
    assert_eq!(counts, 2, "{lines}");

    std::fs::write(folder.join("ball.toml"), BALL).expect("written");
    let output = run("--scene ball.toml --relation doubled --technique bsdf");
    assert_eq!(
        row(&text(&output.stdout)),
        ["doubled", "1", "0", "0", "0", "0"]
    );

    let refused = |options: &str, hint: &str| {
        let output = run(options);
        let lines = text(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{options}: {lines}");
        assert!(
            lines.starts_with("error: ") && lines.lines().count() == 1,
            "{lines}"
        );
        assert!(lines.contains(hint), "{hint}: {lines}");
    };
    refused("--relation splt", "split");
    refused("--technique bdtp", "bdpt");
    refused("--time 10x", "10m");
    refused("--scene none.toml", "none.toml");
    std::fs::write(folder.join("bad.toml"), BALL.replace("half_height", "fov")).expect("written");
    refused("--scene bad.toml", "bad.toml, line 3: ");
    let two = BALL.replace("[1.0, 0.5, 0.2]", "[1.0, 0.5]");
    std::fs::write(folder.join("two.toml"), two).expect("written");
    refused(
        "--scene two.toml",
        "two.toml, line 2: background needs three radiances",
    );
}

#[test]
fn generated_scenes_are_valid_and_of_all_kinds() {
    let folder = folder("generated");
    let mut refused = 0;
    let mut kinds = BTreeSet::new();
    for seed in 0..120 {
        let scene = generate(seed);
        let read = SceneText::parse(&scene.text(), |_| scene.image());
        let read = read.expect("a scene that can be read");
        assert_eq!(read, scene);
        if let Background::Sky(_) = scene.background {
            assert_read_as_file(&folder, &scene);
            kinds.insert("sky".to_owned());
        }
        refused += u32::from(scene.build().is_err());
        kinds.extend(scene.materials.values().map(|of| of.model.clone()));
        kinds.extend(scene.objects.iter().map(|object| {
            let kind = match object {
                Object::Rectangle { .. } => "rectangle",
                Object::Sphere { zone: Some(_), .. } => "zone",
                Object::Sphere { zone: None, .. } => "sphere",
                Object::Mesh { .. } => "mesh",
            };
            kind.to_owned()
        }));
    }
    assert!(refused <= 12, "{refused} of 120 scenes are refused");
    assert_eq!(kinds.len(), 13, "{kinds:?}");
}

/// Programs read the scene's file and the image of its sky as the scene says.
fn assert_read_as_file(folder: &Path, scene: &SceneText) {
    let Background::Sky(sky) = &scene.background else {
        panic!("no sky");
    };
    let path = folder.join("sky.toml");
    std::fs::write(folder.join(&sky.image), sky.file()).expect("written");
    std::fs::write(&path, scene.text()).expect("written");
    let file = SceneFile::load(&path).expect("a scene file");
    let expected = scene.description().expect("a description");
    assert_eq!(file.description.background, expected.background);
    assert_eq!(file.description.objects, expected.objects);
    assert!(matches!(expected.background, Environment::Map(_)));
}

/// A lamp that few paths hit by chance hides whether a body of index 1 is invisible.
#[test]
fn index_one_leaves_out_small_lamps() {
    let ball = SceneText::parse(BALL, |_| unreachable!()).expect("a scene");
    let lit = |radius: f64| {
        let mut scene = ball.clone();
        let lamp = Material {
            model: "black".to_owned(),
            emission: [1.0; 3],
            parameters: Default::default(),
        };
        scene.materials.insert("lamp".to_owned(), lamp);
        scene.objects.push(Object::Sphere {
            material: "lamp".to_owned(),
            centre: [0.0, 0.0, 3.0],
            radius,
            zone: None,
            inward: false,
        });
        scene
    };
    let relation = relation_named("index-one").expect("a relation");
    let applies = |scene| Case::of(relation, &scene, 1).sides().is_some();
    assert!(!applies(lit(0.05)));
    assert!(applies(lit(0.5)));
}

/// A finding comes with the scenes of both sides, which programs read.
#[test]
fn findings_are_written_with_both_sides() {
    let folder = folder("finding");
    let written = |relation: &str, sides: &[&str]| {
        let relation = relation_named(relation).expect("a relation");
        let applies = |case: &Case| {
            matches!(case.scene.background, Background::Sky(_))
                && case
                    .sides()
                    .is_some_and(|[a, b]| a.len() + b.len() == sides.len())
        };
        let mut cases = (0..).map(|seed| Case::of(relation, &generate(seed), seed));
        let case = cases.find(applies).expect("a case");
        let path = folder.join(format!("{}.toml", relation.name));
        write_finding(&path, &case, "a reason").expect("written");
        let text = std::fs::read_to_string(&path).expect("the case");
        assert!(text.starts_with(&format!("# Breaks \"{}\": a reason\n", relation.about)));
        let [a, b] = case.sides().expect("sides");
        for (name, part) in sides.iter().zip(a.iter().chain(&b)) {
            let path = folder.join(format!("{}-{name}.toml", relation.name));
            let file = SceneFile::load(&path).expect("a scene file");
            let expected = part.scene.description().expect("a description");
            assert_eq!(file.description.background, expected.background);
            assert_eq!(file.description.objects, expected.objects);
        }
    };
    written("split", &["a", "b"]);
    written("lamps", &["a", "b-1", "b-2"]);
}

/// The reducer is told that a scene fails if it has a zone of a sphere that emits.
#[test]
fn reduction_leaves_what_fails() {
    let fails = |scene: &SceneText| {
        scene.objects.iter().any(|object| {
            matches!(object, Object::Sphere { zone: Some(_), material, .. }
                if scene.materials[material].emission != [0.0; 3])
        })
    };
    let scenes = (0..).map(generate);
    let scene = scenes
        .filter(|scene| scene.objects.len() > 3)
        .find(fails)
        .expect("a scene");
    let relation = relation_named("split").expect("a relation");
    let check = |case: &Case| match fails(&case.scene) {
        true => Found::Fails(String::new()),
        false => Found::Holds,
    };
    let smallest = reduce(&Case::of(relation, &scene, 1), &check).scene;
    assert!(fails(&smallest));
    assert_eq!(smallest.objects.len(), 1);
    assert_eq!(smallest.materials.len(), 1);
    let material = smallest.materials.values().next().expect("a material");
    assert_eq!((&*material.model, material.emission), ("black", [1.0; 3]));
    assert_eq!(smallest.background, Background::BLACK);
}
