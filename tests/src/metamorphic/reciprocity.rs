//! Helmholtz reciprocity: two patches of a scene that see each other by any paths.

use glam::{DQuat, DVec3};
use whitefurnace::geometry::shape::Ray;
use whitefurnace::material::Bsdf;
use whitefurnace::sampling::rng::{Stream, uniform};
use whitefurnace::scene::Scene;

use crate::mean_radiance::any_direction;

use super::relations::{Part, extent, part};
use super::scene::{Material, Object, SceneText, View};
use super::technique::{RESOLUTION, Technique};

/// Places two equal patches in the air of the scene, without its own light. Each side is the
/// irradiance of one under the emission of the other, seen by a camera whose image it fills.
pub(super) fn reciprocity(
    scene: &SceneText,
    technique: Technique,
    rng: &mut Stream,
) -> Option<[Vec<Part>; 2]> {
    let mut dark = scene.tinted(DVec3::ZERO);
    let built = scene.build().ok()?;
    let size = extent(scene);
    let half = 0.03 * size;
    let mut patches = Vec::new();
    for name in ["patch 1", "patch 2"] {
        let patch = (0..64).find_map(|_| {
            let patch = Patch {
                centre: 0.6 * size * uniform(rng) * any_direction(rng),
                rotation: DQuat::from_axis_angle(
                    any_direction(rng),
                    std::f64::consts::PI * uniform(rng),
                ),
                half,
            };
            patch.is_free(&built).then_some(patch)
        })?;
        let material = Material::new("lambert", [("albedo", vec![0.5; 3].into())]);
        dark.materials.insert(name.to_owned(), material);
        dark.objects.push(patch.object(name));
        patches.push(patch);
    }
    if patches[0].centre.distance(patches[1].centre) < 6.0 * half {
        return None;
    }
    let side = |seen: usize| {
        let mut one = dark.clone();
        one.camera = patches[seen].camera();
        let emitter = format!("patch {}", 2 - seen);
        one.materials.get_mut(&emitter)?.emission = [30.0, 20.0, 10.0];
        Some(vec![part(one, technique)])
    };
    let mean = |image: Vec<DVec3>| {
        let mean = image.iter().sum::<DVec3>() / image.len() as f64;
        vec![mean; image.len()]
    };
    let mut sides = [side(0)?, side(1)?];
    sides.iter_mut().for_each(|side| side[0].adjust = mean);
    Some(sides)
}

/// A rectangular patch of the image's shape.
struct Patch {
    centre: DVec3,
    rotation: DQuat,
    /// Half of its width.
    half: f64,
}

impl Patch {
    fn normal(&self) -> DVec3 {
        self.rotation * DVec3::Z
    }

    fn object(&self, material: &str) -> Object {
        let [width, height] = RESOLUTION.map(f64::from);
        let sides = [DVec3::X, DVec3::Y * (height / width)];
        let edges = sides.map(|side| self.rotation * side * 2.0 * self.half);
        Object::Rectangle {
            material: material.to_owned(),
            corner: (self.centre - 0.5 * (edges[0] + edges[1])).to_array(),
            edges: edges.map(|edge| edge.to_array()),
        }
    }

    /// Returns a camera in front of the patch, whose image it fills.
    fn camera(&self) -> View {
        let [width, height] = RESOLUTION.map(f64::from);
        View {
            eye: (self.centre + self.half * self.normal()).to_array(),
            target: self.centre.to_array(),
            up: (self.rotation * DVec3::Y).to_array(),
            half_height: height / width,
        }
    }

    /// Returns whether nothing is within twice its size, and no glass is around it.
    fn is_free(&self, scene: &Scene) -> bool {
        let clear = |direction: DVec3| {
            let ray = Ray::new(self.centre, direction);
            scene.intersect(&ray).is_none_or(|hit| {
                let bsdf = scene.surface(&hit).bsdf;
                let is_glass = matches!(bsdf, Bsdf::Glass { .. } | Bsdf::RoughGlass(_));
                let inside = is_glass && hit.normal.dot(direction) > 0.0;
                hit.t > 3.0 * self.half && !inside
            })
        };
        let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
        (0..256).all(|i| {
            let z = (2.0 * f64::from(i) + 1.0) / 256.0 - 1.0;
            let (sin, cos) = (golden * f64::from(i)).sin_cos();
            let r = (1.0 - z * z).sqrt();
            clear(DVec3::new(r * cos, r * sin, z))
        })
    }
}
