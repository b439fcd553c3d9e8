//! Reduction of a scene that breaks a relation to a smaller one that still does.

use std::collections::BTreeSet;

use super::background::Background;
use super::scene::{Material, Object, SceneText};
use super::{Case, Found};

/// Reduces a case that `check` rejects: objects and faces are removed, materials become Lambert,
/// emission grey, zones whole, and numbers round, as long as the case fails. Returns the case at
/// which none of these steps fails any more.
pub fn reduce(case: &Case, check: &dyn Fn(&Case) -> Found) -> Case {
    let mut best = case.clone();
    loop {
        let smaller = steps(&best.scene).into_iter().find_map(|scene| {
            let case = Case {
                scene,
                ..best.clone()
            };
            matches!(check(&case), Found::Fails(_)).then_some(case)
        });
        match smaller {
            Some(case) => best = case,
            None => return best,
        }
    }
}

/// Returns scenes that are simpler by one step, the largest steps first. No step undoes another, so
/// that a reduction ends.
fn steps(scene: &SceneText) -> Vec<SceneText> {
    let mut all = Vec::new();
    let mut step = |change: &dyn Fn(&mut SceneText)| {
        let mut simpler = scene.clone();
        change(&mut simpler);
        drop_unused(&mut simpler);
        if simpler != *scene {
            all.push(simpler);
        }
    };
    let count = scene.objects.len();
    if count > 3 {
        step(&|s| drop(s.objects.drain(..count / 2)));
        step(&|s| s.objects.truncate(count / 2));
    }
    for i in 0..count {
        step(&|s| drop(s.objects.remove(i)));
    }
    step(&|s| s.background = Background::BLACK);
    step(&|s| {
        if let Background::Sky(_) = s.background {
            s.background = Background::Uniform([1.0; 3]);
        }
    });
    step(&|s| {
        s.background.map_radiances(|radiance| {
            if *radiance != [0.0; 3] {
                *radiance = [1.0; 3];
            }
        });
    });
    for i in 0..count {
        step(&|s| simplify(&mut s.objects[i]));
        if let Object::Mesh { faces, .. } = &scene.objects[i] {
            for (name, of) in faces {
                for face in 0..of.len() {
                    step(&|s| {
                        if let Object::Mesh { faces, .. } = &mut s.objects[i] {
                            faces.entry(name.clone()).and_modify(|of| {
                                of.remove(face);
                            });
                            faces.retain(|_, of| !of.is_empty());
                        }
                    });
                }
            }
        }
    }
    for name in scene.materials.keys() {
        let with = |change: fn(&mut Material)| {
            move |s: &mut SceneText| {
                s.materials.entry(name.clone()).and_modify(change);
            }
        };
        step(&with(|material| material.emission = [0.0; 3]));
        step(&with(|material| {
            if material.emission != [0.0; 3] {
                material.emission = [1.0; 3];
            }
        }));
        step(&with(|material| {
            remodel(material, Material::new("black", []));
        }));
        step(&with(|material| {
            // Black is simpler still.
            if material.model != "black" {
                let grey = [("albedo", vec![0.5; 3].into())];
                remodel(material, Material::new("lambert", grey));
            }
        }));
        step(&with(|material| {
            if material.model == "glass" {
                remodel(material, Material::new("glass", [("index", 1.5.into())]));
            }
        }));
    }
    for digits in [1, 2, 3] {
        step(&|s| round(s, digits));
    }
    all
}

/// Gives a material another model with its parameters; it emits as before.
fn remodel(material: &mut Material, to: Material) {
    let emission = material.emission;
    *material = Material { emission, ..to };
}

/// Makes a sphere whole.
fn simplify(object: &mut Object) {
    if let Object::Sphere { zone, inward, .. } = object {
        (*zone, *inward) = (None, false);
    }
}

/// Removes the materials and vertices that no object uses.
fn drop_unused(scene: &mut SceneText) {
    let mut used = BTreeSet::new();
    for object in &mut scene.objects {
        match object {
            Object::Rectangle { material, .. } | Object::Sphere { material, .. } => {
                used.insert(material.clone());
            }
            Object::Mesh { vertices, faces } => {
                used.extend(faces.keys().cloned());
                let corners: BTreeSet<u32> = faces.values().flatten().flatten().copied().collect();
                let kept = corners.iter().map(|i| vertices[*i as usize]).collect();
                *vertices = kept;
                let number = |old: &u32| corners.range(..old).count() as u32;
                for corner in faces.values_mut().flatten().flatten() {
                    *corner = number(corner);
                }
            }
        }
    }
    scene
        .objects
        .retain(|object| !matches!(object, Object::Mesh { faces, .. } if faces.is_empty()));
    scene.materials.retain(|name, _| used.contains(name));
}

/// Rounds lengths to this many significant digits.
fn round(scene: &mut SceneText, digits: usize) {
    let rounded = |x: f64| format!("{x:.*e}", digits - 1).parse().unwrap_or(x);
    let point = |p: &mut [f64; 3]| *p = p.map(rounded);
    let camera = &mut scene.camera;
    [&mut camera.eye, &mut camera.target, &mut camera.up]
        .into_iter()
        .for_each(point);
    camera.half_height = rounded(camera.half_height);
    for object in &mut scene.objects {
        match object {
            Object::Rectangle { corner, edges, .. } => {
                point(corner);
                edges.iter_mut().for_each(point);
            }
            Object::Sphere {
                centre,
                radius,
                zone,
                ..
            } => {
                point(centre);
                *radius = rounded(*radius);
                *zone = zone.map(|zone| zone.map(rounded));
            }
            Object::Mesh { vertices, .. } => vertices.iter_mut().for_each(point),
        }
    }
}
