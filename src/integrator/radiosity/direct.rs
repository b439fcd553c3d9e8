//! Direct light: form factors of the emitters times their visible fraction.

use std::f64::consts::PI;

use glam::DVec3;

use super::FiniteElements;
use super::patch::{Patch, PatchView};
use crate::geometry::shape::SurfacePoint;
use crate::integrator::NextEvent;
use crate::light::emitter::{Emitter, EmitterShape};
use crate::material::Scattering;
use crate::scene::Scene;

/// Number of visibility samples on a flat emitter.
const VISIBILITY_SAMPLES: u32 = 64;

/// An emitter as patches; a flat one is a single patch.
#[derive(Clone, Debug)]
pub(super) enum Light {
    Flat {
        patch: Box<Patch>,
        emitter: Emitter,
    },
    Curved {
        patches: Vec<Patch>,
        radiance: DVec3,
    },
}

impl Light {
    /// Returns the emitters of a scene; spheres are divided into patches of about this area.
    pub fn of(scene: &Scene, target: f64) -> Vec<Self> {
        let light = |emitter: &Emitter| match emitter.shape {
            EmitterShape::Rectangle {
                corner,
                edges: [a, b],
            } => Self::Flat {
                patch: Box::new(Patch::flat(
                    [corner, corner + a, corner + a + b, corner + b],
                    true,
                )),
                emitter: *emitter,
            },
            EmitterShape::Triangle(corners) => Self::Flat {
                patch: Box::new(Patch::flat(corners, true)),
                emitter: *emitter,
            },
            EmitterShape::Sphere(sphere) => Self::Curved {
                patches: crate::integrator::radiosity::mesh::sphere_patches(
                    &sphere, true, target, 0,
                )
                .into_iter()
                .flatten()
                .map(Patch::Curved)
                .collect(),
                radiance: emitter.radiance,
            },
        };
        scene.emitters().iter().map(light).collect()
    }

    /// Returns the irradiance from the emitter at a node.
    pub fn irradiance<P: FiniteElements + NextEvent + Scattering + ?Sized>(
        &self,
        parts: &P,
        scene: &Scene,
        at: &SurfacePoint,
    ) -> DVec3 {
        match self {
            Self::Flat { patch, emitter } => {
                let Some(PatchView { factor, .. }) = patch.view(parts, at.point, at.normal) else {
                    return DVec3::ZERO;
                };
                PI * factor * visible_fraction(parts, scene, emitter, at) * emitter.radiance
            }
            Self::Curved { patches, radiance } => {
                let seen = patches
                    .iter()
                    .filter_map(|patch| patch.view(parts, at.point, at.normal))
                    .filter(|view| parts.visible(scene, *at, view.target, false));
                PI * seen.map(|view| view.factor).sum::<f64>() * *radiance
            }
        }
    }
}

/// Returns the visible fraction of a flat emitter's light, from a Hammersley set weighted by the
/// geometry term. Exact where all or nothing is visible.
fn visible_fraction<P: FiniteElements + NextEvent + Scattering + ?Sized>(
    parts: &P,
    scene: &Scene,
    emitter: &Emitter,
    at: &SurfacePoint,
) -> f64 {
    let (mut seen, mut all) = (0.0, 0.0);
    for index in 0..VISIBILITY_SAMPLES {
        let y = parts.sample_emitter(emitter, hammersley(index));
        let offset = y.point - at.point;
        let distance_squared = offset.length_squared();
        let direction = offset / distance_squared.sqrt();
        let across = parts.cosine(y.normal, -direction);
        let weight = parts.visibility_weight(
            parts.cosine(at.normal, direction),
            parts.solid_angle_per_area(across, distance_squared),
        );
        all += weight;
        if weight > 0.0 && parts.visible(scene, *at, y, false) {
            seen += weight;
        }
    }
    if all == 0.0 { 0.0 } else { seen / all }
}

/// Returns point `index` of [`VISIBILITY_SAMPLES`] in the unit square (Hammersley 1960), shifted so
/// that none lies on the second diagonal, which folding makes an edge of a triangle.
fn hammersley(index: u32) -> [f64; 2] {
    let strip = 1.0 / f64::from(VISIBILITY_SAMPLES);
    let reversed = f64::from(index.reverse_bits()) / 2f64.powi(32);
    [(f64::from(index) + 0.5) * strip, reversed + 0.25 * strip]
}
