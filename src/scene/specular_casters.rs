//! Specular next-event estimation through one mirror or glass caster: the casters of a scene, their
//! selection probabilities and their throughput.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::{PrimitiveShape, ScenePrimitive, Surface};
use crate::geometry::specular_connection::{
    Caster, CasterKind, SpecularConnection, SphereConnections, mirror_connection,
};
use crate::light::light_sampler;
use crate::material::{Bsdf, fresnel};
use crate::math::real::{MaskOf, Real, Vector};

/// Maximum number of casters in a scene, all of which are weighted at each vertex; of more, the
/// largest are kept.
pub const MAX_CASTERS: usize = 16;
/// Maximum number of triangles of a flat mirror used as a caster.
const MAX_MIRROR_TRIANGLES: usize = 16;
/// Rough average reflectance of glass, used only to weight reflections.
const GLASS_REFLECTANCE: f64 = 0.1;
/// Index that stands for no caster.
pub(crate) const NO_CASTER: u8 = u8::MAX;

impl<V: Vector> Caster<V> {
    /// Returns the selection weight from a point: approximately the solid angle times
    /// `selection_weight`; 0 from within a sphere and from behind a flat mirror.
    #[inline]
    pub fn selection_weight_from(&self, kind: CasterKind, from: V) -> V::Real {
        let zero = V::Real::splat(0.0);
        let away = from - self.centre;
        let squared = away.length_squared();
        if kind == CasterKind::Flat {
            let height = away.dot(self.normal);
            let solid_angle = self.area * height / (squared * squared.sqrt());
            let seen = solid_angle.minimum(V::Real::splat(TAU));
            return V::Real::select(height.cmpgt(zero), seen * self.selection_weight, zero);
        }
        let square = self.radius * self.radius;
        let seen = square * PI / squared;
        V::Real::select(squared.cmpgt(square), seen * self.selection_weight, zero)
    }

    /// Returns the throughput of the caster along a connection with this cosine outside, and the
    /// probability that a path samples that branch.
    #[inline]
    pub fn caster_throughput(&self, cosine: V::Real, is_refraction: MaskOf<V>) -> (V, V::Real) {
        let one = V::Real::splat(1.0);
        let is_glass = self.index.cmpgt(V::Real::splat(0.0));
        let index = V::Real::select(is_glass, self.index, one);
        // By symmetry the reflectance is the same where light leaves the sphere.
        let reflected = fresnel::reflectance(cosine, one, index);
        let passes = one - reflected;
        let share = V::Real::select(is_refraction, passes * passes, reflected);
        let white = V::splat_vector(DVec3::ONE);
        (
            V::select(is_glass, white * share, self.reflectance),
            V::Real::select(is_glass, share, one),
        )
    }
}

/// Edge of a half-plane: points with normal · p ≥ offset are inside.
type Edge = (DVec3, f64);

/// A specular caster of a scene.
#[derive(Clone, Debug)]
pub struct SpecularCaster {
    /// Kind of scattering.
    pub kind: CasterKind,
    /// Parameters of the caster.
    pub parameters: Caster<DVec3>,
    /// Triangles of a flat mirror, as edges.
    triangles: Vec<[Edge; 3]>,
}

impl SpecularCaster {
    /// Returns the connections between two points x and y, each with its index: 0 for reflection
    /// and for refraction across the axis.
    #[inline]
    pub fn connections(
        &self,
        x: DVec3,
        y: DVec3,
    ) -> impl Iterator<Item = (usize, SpecularConnection<DVec3>)> {
        let (is_flat, refracts) = (
            self.kind == CasterKind::Flat,
            self.kind == CasterKind::Refraction,
        );
        let flat = is_flat
            .then(|| mirror_connection(&self.parameters, x, y, true))
            .filter(|found| found.exists && self.contains(found.first.point));
        let curved = (!is_flat)
            .then(|| SphereConnections::new(&self.parameters, x, y, true, refracts).connections());
        let flat = flat.map(|connection| (0, connection));
        flat.into_iter().chain(curved.into_iter().flatten())
    }

    /// Returns whether a point in the plane of a flat mirror lies on the mirror.
    #[inline]
    pub fn contains<V: Vector>(&self, point: V) -> MaskOf<V> {
        let zero = V::Real::splat(0.0);
        let mut on = zero.cmpgt(zero);
        for edges in &self.triangles {
            let [a, b, c] = edges.map(|(normal, offset)| {
                !point
                    .dot(V::splat_vector(normal))
                    .cmplt(V::Real::splat(offset))
            });
            on = on | (a & b & c);
        }
        on
    }
}

/// Specular casters of a scene.
#[derive(Clone, Debug, Default)]
pub struct SpecularCasters {
    all: Vec<SpecularCaster>,
    /// Casters by which each primitive reflects and refracts; empty without casters.
    by_primitive: Vec<[u8; 2]>,
}

/// A caster, and the primitives that form it.
type Candidate = (SpecularCaster, Vec<usize>);

impl SpecularCasters {
    /// Finds the casters of a scene: whole spheres of mirror and of glass with outward normals, and
    /// flat mirrors.
    pub(crate) fn new(
        primitives: &[ScenePrimitive],
        surfaces: &[Surface],
        corners: impl Fn([u32; 3]) -> [DVec3; 3],
    ) -> Self {
        let mut found: Vec<Candidate> = Vec::new();
        for (i, primitive) in primitives.iter().enumerate() {
            match (primitive.shape, surfaces[primitive.surface as usize].bsdf) {
                (PrimitiveShape::Sphere(sphere), bsdf) if sphere.is_whole() && !sphere.inward => {
                    let casters = sphere_casters(sphere.centre, sphere.radius, bsdf);
                    found.extend(casters.into_iter().map(|caster| (caster, vec![i])));
                }
                (PrimitiveShape::Triangle { vertices, normal }, Bsdf::Mirror { reflectance }) => {
                    add_mirror_triangle(&mut found, i, corners(vertices), normal, reflectance);
                }
                _ => {}
            }
        }
        found.retain(|(caster, primitives)| {
            primitives.len() <= MAX_MIRROR_TRIANGLES && caster.parameters.selection_weight > 0.0
        });
        // Of equally large casters the first in the scene are kept.
        let seen = |candidate: &Candidate| {
            let SpecularCaster {
                kind, parameters, ..
            } = &candidate.0;
            let area = if *kind == CasterKind::Flat {
                parameters.area
            } else {
                parameters.radius * parameters.radius * PI
            };
            area * parameters.selection_weight
        };
        found.sort_by(|a, b| seen(b).total_cmp(&seen(a)));
        found.truncate(MAX_CASTERS);
        let mut by_primitive = if found.is_empty() {
            Vec::new()
        } else {
            vec![[NO_CASTER; 2]; primitives.len()]
        };
        for (number, (caster, primitives)) in found.iter().enumerate() {
            let column = usize::from(caster.kind == CasterKind::Refraction);
            primitives
                .iter()
                .for_each(|&primitive| by_primitive[primitive][column] = number as u8);
        }
        Self {
            all: found.into_iter().map(|(caster, _)| caster).collect(),
            by_primitive,
        }
    }

    /// Returns all casters.
    pub fn all(&self) -> &[SpecularCaster] {
        &self.all
    }

    /// Returns the indices of the casters by which a primitive reflects and refracts; [`NO_CASTER`]
    /// where it has none.
    #[inline]
    pub(crate) fn casters_of_primitive(&self, primitive: u32) -> [u8; 2] {
        self.by_primitive
            .get(primitive as usize)
            .copied()
            .unwrap_or([NO_CASTER; 2])
    }

    /// Returns the selection probabilities of all casters from a point: they sum to 1, or are all
    /// zero.
    #[inline]
    pub fn selection_probabilities<V: Vector>(&self, from: V) -> [V::Real; MAX_CASTERS] {
        let mut probabilities = [V::Real::splat(0.0); MAX_CASTERS];
        light_sampler::probabilities(
            |i| self.selection_weight(i, from),
            &mut probabilities[..self.all.len()],
        );
        probabilities
    }

    #[inline]
    fn selection_weight<V: Vector>(&self, i: usize, from: V) -> V::Real {
        let caster = &self.all[i];
        Caster::splat(&caster.parameters).selection_weight_from(caster.kind, from)
    }

    /// Returns the selection probability of the caster with this index.
    #[inline]
    pub fn selection_probability<R: Real>(&self, number: R, from: R::Vector) -> R {
        light_sampler::probability(|i| self.selection_weight(i, from), self.all.len(), number)
    }
}

/// Returns the casters of a sphere: one that reflects and, of glass, another one that refracts.
fn sphere_casters(centre: DVec3, radius: f64, bsdf: Bsdf) -> Vec<SpecularCaster> {
    use CasterKind::{Reflection, Refraction};
    let caster = |kind, inverse_ior, index, reflectance, selection_weight| SpecularCaster {
        kind,
        parameters: Caster {
            centre,
            radius,
            area: 0.0,
            normal: DVec3::ZERO,
            inverse_ior,
            index,
            reflectance,
            selection_weight,
        },
        triangles: Vec::new(),
    };
    let white = DVec3::ONE;
    match bsdf {
        Bsdf::Mirror { reflectance } => {
            let weight = reflectance.max_element();
            vec![caster(Reflection, 0.0, 0.0, reflectance, weight)]
        }
        // The connections through a bubble, whose index is below 1, are different.
        Bsdf::Glass { index } if index > 1.0 => vec![
            caster(Reflection, 0.0, index, white, GLASS_REFLECTANCE),
            caster(Refraction, index.recip(), index, white, 1.0),
        ],
        _ => Vec::new(),
    }
}

/// Adds a triangle of a mirror to the flat mirror in its plane, or as a new flat mirror.
fn add_mirror_triangle(
    found: &mut Vec<Candidate>,
    primitive: usize,
    corners: [DVec3; 3],
    normal: DVec3,
    reflectance: DVec3,
) {
    // Limit on flat mirrors, as the search for the plane of a triangle is linear; a mesh has no
    // common plane anyway.
    const MAX_FLAT_MIRRORS: usize = 256;
    // Tolerance for triangles of one rotated rectangle to lie in one plane.
    const PLANE_TOLERANCE: f64 = 1e-12;
    let [a, b, c] = corners;
    let area = 0.5 * (b - a).cross(c - a).length();
    let centre = (a + b + c) / 3.0;
    let edge = |from: DVec3, to: DVec3| {
        let across = normal.cross(to - from);
        (across, across.dot(from))
    };
    let edges = [edge(a, b), edge(b, c), edge(c, a)];
    let extent = corners
        .iter()
        .map(|corner| corner.abs().max_element())
        .fold(0.0, f64::max);
    let same = found.iter_mut().find(|(flat, _)| {
        flat.kind == CasterKind::Flat
            && flat.parameters.reflectance == reflectance
            && flat.parameters.normal.dot(normal) > 1.0 - PLANE_TOLERANCE
            && (centre - flat.parameters.centre).dot(normal).abs() <= PLANE_TOLERANCE * extent
    });
    if let Some((flat, primitives)) = same {
        let sum = flat.parameters.area + area;
        flat.parameters.centre = flat.parameters.centre.lerp(centre, area / sum);
        flat.parameters.area = sum;
        flat.triangles.push(edges);
        primitives.push(primitive);
    } else if found.len() < MAX_FLAT_MIRRORS {
        let selection_weight = reflectance.max_element();
        let parameters = Caster {
            centre,
            radius: 0.0,
            area,
            normal,
            inverse_ior: 0.0,
            index: 0.0,
            reflectance,
            selection_weight,
        };
        found.push((
            SpecularCaster {
                kind: CasterKind::Flat,
                parameters,
                triangles: vec![edges],
            },
            vec![primitive],
        ));
    }
}
