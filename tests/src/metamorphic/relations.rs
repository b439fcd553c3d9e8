//! Relations between renders that need no reference: two sides, each the sum of some renders, whose
//! expectations are equal.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3, Vec3Swizzles as _};
use rand::RngExt as _;
use rand::seq::SliceRandom as _;
use whitefurnace::sampling::rng::{Stream, uniform};

use crate::mean_radiance::any_direction;

use super::reciprocity::reciprocity;
use super::scene::{Material, Object, SceneText, Similarity};
use super::technique::{RESOLUTION, Technique};

/// Makes the two sides of a relation on a scene, by random choices; `None` where the relation does
/// not apply.
pub type MakeSides = fn(&SceneText, Technique, &mut Stream) -> Option<[Vec<Part>; 2]>;

/// A relation that holds for every scene to which it applies.
pub struct Relation {
    /// Its name.
    pub name: &'static str,
    /// The relation in words.
    pub about: &'static str,
    /// Largest difference of a pixel under one seed, relative to the pixel's brightest channel;
    /// with 0 the sides are equal to the bit. `None` if only their expectations are equal.
    pub tolerance: Option<f64>,
    /// Makes the two sides.
    pub sides: MakeSides,
}

/// One of the renders of a side.
pub struct Part {
    /// The scene.
    pub scene: SceneText,
    /// The technique that renders it.
    pub technique: Technique,
    /// Changes the image before it is added.
    pub adjust: fn(Vec<DVec3>) -> Vec<DVec3>,
}

/// All relations.
pub static RELATIONS: [Relation; 12] = [
    Relation {
        name: "round-trip",
        about: "a scene that is written and read again is the same",
        tolerance: Some(0.0),
        sides: round_trip,
    },
    Relation {
        name: "colours",
        about: "exchanged colour channels exchange those of the image",
        tolerance: Some(0.0),
        sides: colours,
    },
    Relation {
        name: "doubled",
        about: "twice the emission gives twice the image",
        // The film's sums are in fixed units.
        tolerance: Some(1e-6),
        sides: doubled,
    },
    Relation {
        name: "unit",
        about: "another unit of length leaves the image",
        tolerance: None,
        sides: unit,
    },
    Relation {
        name: "rigid-motion",
        about: "scene and camera, turned and moved together, leave the image",
        tolerance: None,
        sides: rigid_motion,
    },
    Relation {
        name: "mirrored",
        about: "a mirrored scene gives the mirrored image",
        tolerance: None,
        sides: mirrored,
    },
    Relation {
        name: "split",
        about: "a surface cut in two leaves the image",
        tolerance: None,
        sides: split,
    },
    Relation {
        name: "permuted",
        about: "another order of objects and materials leaves the image",
        tolerance: None,
        sides: permuted,
    },
    Relation {
        name: "index-one",
        about: "a body of index 1 is invisible",
        tolerance: None,
        sides: index_one,
    },
    Relation {
        name: "lamps",
        about: "the images under each light alone add up to that under all",
        tolerance: None,
        sides: lamps,
    },
    Relation {
        name: "reciprocity",
        about: "two equal patches send each other the same flux (Helmholtz)",
        tolerance: None,
        sides: reciprocity,
    },
    Relation {
        name: "techniques",
        about: "two techniques agree",
        tolerance: None,
        sides: techniques,
    },
];

pub(super) fn part(scene: SceneText, technique: Technique) -> Part {
    Part {
        scene,
        technique,
        adjust: |image| image,
    }
}

/// Pairs the scene with a changed one; `None` where the technique does not take that.
fn pair(scene: &SceneText, changed: SceneText, technique: Technique) -> Option<[Vec<Part>; 2]> {
    technique
        .takes(&changed)
        .then(|| [scene.clone(), changed].map(|scene| vec![part(scene, technique)]))
}

fn round_trip(scene: &SceneText, technique: Technique, _: &mut Stream) -> Option<[Vec<Part>; 2]> {
    let read = SceneText::parse(&scene.text(), |_| scene.image()).ok()?;
    pair(scene, read, technique)
}

fn colours(scene: &SceneText, technique: Technique, _: &mut Stream) -> Option<[Vec<Part>; 2]> {
    let mut turned = scene.clone();
    turned
        .background
        .map_radiances(|radiance| radiance.rotate_left(1));
    for material in turned.materials.values_mut() {
        material.emission.rotate_left(1);
        for (_, value) in material.parameters.iter_mut() {
            if let toml::Value::Array(colour) = value {
                colour.rotate_left(1);
            }
        }
    }
    let mut sides = pair(scene, turned, technique)?;
    sides[1][0].adjust = |image| image.into_iter().map(|colour| colour.zxy()).collect();
    Some(sides)
}

fn doubled(scene: &SceneText, technique: Technique, _: &mut Stream) -> Option<[Vec<Part>; 2]> {
    let mut sides = pair(scene, scene.tinted(DVec3::splat(2.0)), technique)?;
    sides[1][0].adjust = |image| image.into_iter().map(|colour| 0.5 * colour).collect();
    Some(sides)
}

fn unit(scene: &SceneText, technique: Technique, rng: &mut Stream) -> Option<[Vec<Part>; 2]> {
    let by = Similarity {
        scale: 10f64.powf(4.0 * uniform(rng) - 2.0),
        ..Similarity::IDENTITY
    };
    pair(scene, scene.transformed(&by), technique)
}

/// Returns the largest distance of the camera, a vertex or a sphere from the origin.
pub(super) fn extent(scene: &SceneText) -> f64 {
    let length = |p: &[f64; 3]| DVec3::from(*p).length();
    let of_object = |object: &Object| match object {
        Object::Rectangle { corner, edges, .. } => length(corner) + length(&edges[0]),
        Object::Sphere { centre, radius, .. } => length(centre) + radius,
        Object::Mesh { vertices, .. } => vertices.iter().map(length).fold(0.0, f64::max),
    };
    let objects = scene.objects.iter().map(of_object);
    objects.fold(length(&scene.camera.eye), f64::max)
}

/// Returns the scene under no light but the emission of a material.
fn lit_by(scene: &SceneText, material: &str) -> SceneText {
    let mut one = scene.tinted(DVec3::ZERO);
    let emits = scene.materials[material].clone();
    one.materials.insert(material.to_owned(), emits);
    one
}

fn rigid_motion(
    scene: &SceneText,
    technique: Technique,
    rng: &mut Stream,
) -> Option<[Vec<Part>; 2]> {
    let any = any_direction(rng);
    let axis = if scene.has_zones() { DVec3::Z } else { any };
    let by = Similarity {
        rotation: DQuat::from_axis_angle(axis, std::f64::consts::PI * uniform(rng)),
        translation: extent(scene) * uniform(rng) * any_direction(rng),
        ..Similarity::IDENTITY
    };
    pair(scene, scene.transformed(&by), technique)
}

fn mirrored(scene: &SceneText, technique: Technique, _: &mut Stream) -> Option<[Vec<Part>; 2]> {
    let by = Similarity {
        mirrored: true,
        ..Similarity::IDENTITY
    };
    let mut sides = pair(scene, scene.transformed(&by), technique)?;
    sides[1][0].adjust = |mut image| {
        image
            .chunks_mut(RESOLUTION[0] as usize)
            .for_each(<[DVec3]>::reverse);
        image
    };
    Some(sides)
}

fn split(scene: &SceneText, technique: Technique, rng: &mut Stream) -> Option<[Vec<Part>; 2]> {
    let mut cut = scene.clone();
    let index = rng.random_range(0..scene.objects.len().max(1));
    let at = 0.2 + 0.6 * uniform(rng);
    let half = match cut.objects.get_mut(index)? {
        Object::Rectangle {
            material,
            corner,
            edges,
        } => {
            let edge = DVec3::from(edges[0]);
            let rest = Object::Rectangle {
                material: material.clone(),
                corner: (DVec3::from(*corner) + at * edge).to_array(),
                edges: [((1.0 - at) * edge).to_array(), edges[1]],
            };
            edges[0] = (at * edge).to_array();
            rest
        }
        Object::Sphere {
            material,
            centre,
            radius,
            zone,
            inward,
        } => {
            let ends = zone.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
            let [low, high] = [ends[0].max(-*radius), ends[1].min(*radius)];
            let cut = low + at * (high - low);
            // Beyond the poles, so that rounding opens no hole there.
            let [below, above] = [ends[0].max(-2.0 * *radius), ends[1].min(2.0 * *radius)];
            *zone = Some([below, cut]);
            Object::Sphere {
                material: material.clone(),
                centre: *centre,
                radius: *radius,
                zone: Some([cut, above]),
                inward: *inward,
            }
        }
        Object::Mesh { vertices, faces } => {
            let mut rest = BTreeMap::<_, Vec<_>>::new();
            for (name, of) in faces.iter_mut() {
                let kept = of.len().div_ceil(2);
                if kept < of.len() {
                    rest.insert(name.clone(), of.split_off(kept));
                }
            }
            if rest.is_empty() {
                return None;
            }
            Object::Mesh {
                vertices: vertices.clone(),
                faces: rest,
            }
        }
    };
    cut.objects.push(half);
    pair(scene, cut, technique)
}

fn permuted(scene: &SceneText, technique: Technique, rng: &mut Stream) -> Option<[Vec<Part>; 2]> {
    let mut other = scene.clone();
    other.objects.shuffle(rng);
    // Names in the opposite order: programs number materials by name.
    let count = scene.materials.len();
    let names = scene.materials.keys().enumerate();
    let names: BTreeMap<String, String> = names
        .map(|(i, name)| (name.clone(), format!("n{:03}", count - i)))
        .collect();
    let renamed = |(name, of)| (names[&name].clone(), of);
    other.materials = other.materials.into_iter().map(renamed).collect();
    for object in &mut other.objects {
        match object {
            Object::Rectangle { material, .. } | Object::Sphere { material, .. } => {
                *material = names[material].clone();
            }
            Object::Mesh { faces, .. } => {
                *faces = std::mem::take(faces)
                    .into_iter()
                    .map(|(name, of)| (names[&name].clone(), of))
                    .collect();
            }
        }
    }
    pair(scene, other, technique)
}

/// Least area of an emitter as a fraction of the scene's squared extent. A body of index 1 stops
/// shadow rays: behind it smaller emitters are hit by chance, too rarely for the images of a case.
const LEAST_EMITTER_AREA: f64 = 0.01;

fn index_one(scene: &SceneText, technique: Technique, rng: &mut Stream) -> Option<[Vec<Part>; 2]> {
    let size = extent(scene);
    let area = |name: &String| {
        let scene = lit_by(scene, name).build().ok()?;
        Some(scene.emitters().iter().map(|emitter| emitter.area).sum())
    };
    let least = LEAST_EMITTER_AREA * size * size;
    if scene
        .emitters()
        .filter_map(area)
        .any(|area: f64| area < least)
    {
        return None;
    }
    let mut other = scene.clone();
    let name = "air".to_owned();
    let air = Material::new("glass", [("index", 1.0.into())]);
    other.materials.insert(name.clone(), air);
    other.objects.push(Object::Sphere {
        material: name,
        centre: (size * uniform(rng) * any_direction(rng)).to_array(),
        radius: size * (0.1 + 0.4 * uniform(rng)),
        zone: None,
        inward: false,
    });
    pair(scene, other, technique)
}

fn lamps(scene: &SceneText, technique: Technique, _: &mut Stream) -> Option<[Vec<Part>; 2]> {
    let mut alone: Vec<SceneText> = scene.emitters().map(|name| lit_by(scene, name)).collect();
    if !scene.background.is_black() {
        alone.push(SceneText {
            background: scene.background.clone(),
            ..scene.tinted(DVec3::ZERO)
        });
    }
    (alone.len() > 1).then(|| {
        let alone = alone.into_iter().map(|one| part(one, technique));
        [vec![part(scene.clone(), technique)], alone.collect()]
    })
}

fn techniques(scene: &SceneText, technique: Technique, rng: &mut Stream) -> Option<[Vec<Part>; 2]> {
    let other = Technique::pick(scene, rng);
    (other != technique).then(|| [technique, other].map(|one| vec![part(scene.clone(), one)]))
}
