//! Intersection and shading data of primitives and specular casters.

use std::array::from_fn;

use glam::DVec3;

use super::material::{EMITTER, Material, SPHERE};
use super::{PrimitiveShape, Scene, ScenePrimitive};
use crate::film::FixedPointFeatures;
use crate::geometry::shape::Sphere;
use crate::geometry::specular_connection::{Caster, CasterKind};
use crate::math::simd::{AlignedArray, Scalar};

/// Intersection and shading data of a primitive.
pub(crate) struct PrimitiveData<T> {
    /// Three corners of a triangle, the first of which is the centre of a sphere; the normal of a
    /// triangle's front; the margin of a triangle for
    /// [`inner_point`](crate::geometry::offsets::inner_point), or the radius of a sphere, negative
    /// if its normal points to its centre; the colour and the numbers of its [`Material`]; the
    /// height above it at which rays start. The remaining entries are padding.
    pub numbers: AlignedArray<T, 24>,
    /// Kinds of its material, with [`EMITTER`] and [`SPHERE`].
    pub kinds: u16,
    /// Features of a triangle, for the film.
    pub features: Option<FixedPointFeatures>,
    pub surface: u32,
    pub emitter: Option<u32>,
    /// Indices of the [specular casters](Scene::specular_casters) by which it reflects and
    /// refracts.
    pub casters: [u8; 2],
}

/// Distances that rays keep from a primitive and its edges.
#[derive(Clone, Copy)]
pub(super) struct RayMargins {
    /// Margin at the edges of a triangle: [`EDGE_MARGIN`], or its counterpart in single precision.
    pub(super) margin: f64,
    /// Height above the primitive at which rays start.
    pub(super) offset: f64,
}

/// A specular caster in the precision of the lanes.
pub(crate) struct CasterData<T> {
    pub kind: CasterKind,
    pub numbers: AlignedArray<T, 16>,
}

impl<T: Scalar> CasterData<T> {
    pub fn new(kind: CasterKind, caster: &Caster<DVec3>) -> Self {
        let [a, b, c] = [caster.centre, caster.normal, caster.reflectance].map(|v| v.to_array());
        let numbers = [
            a,
            b,
            c,
            [caster.radius, caster.area, caster.selection_weight],
            [caster.inverse_ior, caster.index, 0.0],
            [0.0; 3],
        ];
        Self {
            kind,
            numbers: AlignedArray(from_fn(|i| T::rounded(numbers[i / 3][i % 3]))),
        }
    }
}

impl<T: Scalar> PrimitiveData<T> {
    pub(super) fn new(
        scene: &Scene,
        id: u32,
        &ScenePrimitive {
            surface,
            emitter,
            shape,
            ..
        }: &ScenePrimitive,
        margins: RayMargins,
    ) -> Self {
        let ([a, b, c], normal, radius) = match shape {
            PrimitiveShape::Triangle { vertices, normal } => {
                (scene.corners(vertices), normal, margins.margin)
            }
            PrimitiveShape::Sphere(Sphere {
                centre,
                radius,
                inward,
                ..
            }) => ([centre; 3], DVec3::Z, if inward { -radius } else { radius }),
        };
        let is_sphere = matches!(shape, PrimitiveShape::Sphere(_));
        let of = &scene.surfaces()[surface as usize];
        let (material, colour) = (Material::new(of), of.bsdf.albedo());
        let kind = |kind: u16, is: bool| if is { kind } else { 0 };
        let kinds = material.kinds | kind(EMITTER, emitter.is_some()) | kind(SPHERE, is_sphere);
        let mut numbers = [T::default(); 24];
        let all = [a, b, c, normal]
            .into_iter()
            .flat_map(|vector| vector.to_array());
        let all = all
            .chain([radius])
            .chain(colour.to_array())
            .chain(material.numbers)
            .chain([margins.offset]);
        numbers
            .iter_mut()
            .zip(all)
            .for_each(|(number, value)| *number = T::rounded(value));
        let features = if is_sphere {
            None
        } else {
            FixedPointFeatures::new(colour, normal)
        };
        Self {
            numbers: AlignedArray(numbers),
            kinds,
            features,
            surface,
            emitter,
            casters: scene.specular_casters().casters_of_primitive(id),
        }
    }
}
