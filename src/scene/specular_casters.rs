//! Specular next-event estimation: shadow rays by way of one mirror or glass body. Which bodies
//! there are, how often each is tried, and what it lets on.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::{Part, PartShape, Surface};
use crate::geometry::specular_connection::{Body, BySphere, Kind, Route, by_flat};
use crate::light::light_sampler;
use crate::material::{Bsdf, fresnel};
use crate::math::real::{Real, Vector};

/// So many bodies at most are asked at a vertex how large they are seen; of more the largest.
pub const MOST: usize = 16;
/// A flat mirror of more triangles is left to paths.
const MOST_TRIANGLES: usize = 16;
/// Of glass that reflects: about the share of light that it does.
const GLINT: f64 = 0.1;
/// No body.
pub(crate) const NONE: u8 = u8::MAX;

impl<V: Vector> Body<V> {
    /// About the solid angle under which it is seen from a point, times what it lets on; 0 from
    /// within a sphere and from behind a flat mirror.
    #[inline]
    pub fn share(&self, kind: Kind, from: V) -> V::Real {
        let zero = V::Real::splat(0.0);
        let away = from - self.centre;
        let squared = away.length_squared();
        if kind == Kind::Flat {
            let height = away.dot(self.normal);
            let solid_angle = self.area * height / (squared * squared.sqrt());
            let seen = solid_angle.at_most(V::Real::splat(TAU));
            return V::Real::choose(height.above(zero), seen * self.strength, zero);
        }
        let square = self.radius * self.radius;
        let seen = square * PI / squared;
        V::Real::choose(squared.above(square), seen * self.strength, zero)
    }

    /// What of the light goes on along a route whose cosine outside is this, and with what chance a
    /// path does that gets there.
    #[inline]
    pub fn lets_on(&self, cosine: V::Real, is_refraction: <V::Real as Real>::Mask) -> (V, V::Real) {
        let one = V::Real::splat(1.0);
        let is_glass = self.index.above(V::Real::splat(0.0));
        let index = V::Real::choose(is_glass, self.index, one);
        // Where light leaves the sphere it is reflected as where it enters.
        let reflected = fresnel::reflectance(cosine, one, index);
        let passes = one - reflected;
        let share = V::Real::choose(is_refraction, passes * passes, reflected);
        let white = V::splat_vector(DVec3::ONE);
        (
            V::choose(is_glass, white * share, self.reflectance),
            V::Real::choose(is_glass, share, one),
        )
    }
}

/// A half-plane's edge: inside where normal · p ≥ offset.
type Edge = (DVec3, f64);

/// A body of a scene.
#[derive(Clone, Debug)]
pub struct SceneBody {
    /// How light goes on.
    pub kind: Kind,
    /// Its numbers.
    pub body: Body<DVec3>,
    /// The triangles of a flat mirror by their edges.
    triangles: Vec<[Edge; 3]>,
}

impl SceneBody {
    /// The routes between two points; each has a number, of light that is bent beyond the axis or
    /// reflected 0.
    #[inline]
    pub fn routes(&self, ends: (DVec3, DVec3)) -> impl Iterator<Item = (usize, Route<DVec3>)> {
        let (flat, curved) = if self.kind == Kind::Flat {
            let route = by_flat(&self.body, ends, true);
            (
                Some(Route {
                    exists: route.exists && self.holds(route.first.0),
                    ..route
                }),
                None,
            )
        } else {
            (
                None,
                Some(BySphere::new(
                    &self.body,
                    ends,
                    (true, self.kind == Kind::Refraction),
                )),
            )
        };
        let curved = curved.into_iter().flat_map(BySphere::routes);
        flat.into_iter()
            .filter(|route| route.exists)
            .map(|route| (0, route))
            .chain(curved)
    }

    /// Whether a point of its plane lies on a flat mirror.
    #[inline]
    pub fn holds<V: Vector>(&self, point: V) -> <V::Real as Real>::Mask {
        let zero = V::Real::splat(0.0);
        let mut on = zero.above(zero);
        for edges in &self.triangles {
            let [a, b, c] = edges.map(|(normal, offset)| {
                !point
                    .dot(V::splat_vector(normal))
                    .below(V::Real::splat(offset))
            });
            on = on | (a & b & c);
        }
        on
    }
}

/// The bodies of a scene.
#[derive(Clone, Debug, Default)]
pub struct Bodies {
    all: Vec<SceneBody>,
    /// Of each primitive that by which it reflects and that by which it refracts; empty without
    /// bodies.
    of: Vec<[u8; 2]>,
}

/// A body, and the primitives that it is made of.
type Found = (SceneBody, Vec<usize>);

impl Bodies {
    /// Whole spheres of mirror and of glass with their normals outside, and flat mirrors.
    pub(crate) fn new(
        parts: &[Part],
        surfaces: &[Surface],
        corners: impl Fn([u32; 3]) -> [DVec3; 3],
    ) -> Self {
        let mut found: Vec<Found> = Vec::new();
        for (i, part) in parts.iter().enumerate() {
            match (part.shape, surfaces[part.surface as usize].bsdf) {
                (PartShape::Sphere(sphere), bsdf) if sphere.is_whole() && !sphere.inward => {
                    found.extend(
                        of_sphere(sphere.centre, sphere.radius, bsdf).map(|body| (body, vec![i])),
                    );
                }
                (PartShape::Triangle { vertices, normal }, Bsdf::Mirror { reflectance }) => {
                    add_flat(&mut found, i, (corners(vertices), normal, reflectance));
                }
                _ => {}
            }
        }
        found.retain(|(body, primitives)| {
            primitives.len() <= MOST_TRIANGLES && body.body.strength > 0.0
        });
        // Of pairs that are as large the first stay: the order is that of the scene.
        let seen = |(SceneBody { kind, body, .. }, _): &Found| {
            let area = if *kind == Kind::Flat {
                body.area
            } else {
                body.radius * body.radius * PI
            };
            area * body.strength
        };
        found.sort_by(|a, b| seen(b).total_cmp(&seen(a)));
        found.truncate(MOST);
        let mut of = if found.is_empty() {
            Vec::new()
        } else {
            vec![[NONE; 2]; parts.len()]
        };
        for (number, (body, primitives)) in found.iter().enumerate() {
            let column = usize::from(body.kind == Kind::Refraction);
            primitives
                .iter()
                .for_each(|&primitive| of[primitive][column] = number as u8);
        }
        Self {
            all: found.into_iter().map(|(body, _)| body).collect(),
            of,
        }
    }

    /// All of them.
    pub fn all(&self) -> &[SceneBody] {
        &self.all
    }

    /// The numbers of the bodies by which a primitive reflects and refracts; [`NONE`] where it has
    /// none.
    #[inline]
    pub(crate) fn of(&self, primitive: u32) -> [u8; 2] {
        self.of
            .get(primitive as usize)
            .copied()
            .unwrap_or([NONE; 2])
    }

    /// The shares of the picks from a point, one for each body; they sum to 1, or all are 0.
    #[inline]
    pub fn shares<V: Vector>(&self, from: V) -> [V::Real; MOST] {
        let mut shares = [V::Real::splat(0.0); MOST];
        light_sampler::share_all(|i| self.share(i, from), &mut shares[..self.all.len()]);
        shares
    }

    #[inline]
    fn share<V: Vector>(&self, i: usize, from: V) -> V::Real {
        let SceneBody { kind, body, .. } = &self.all[i];
        Body::splat(body).share(*kind, from)
    }

    /// The share of the body of this number.
    #[inline]
    pub fn share_of<R: Real>(&self, number: R, from: R::Vector) -> R {
        light_sampler::share(|i| self.share(i, from), self.all.len(), number)
    }
}

fn of_sphere(centre: DVec3, radius: f64, bsdf: Bsdf) -> impl Iterator<Item = SceneBody> {
    let body = |kind, bending, index, reflectance, strength| SceneBody {
        kind,
        body: Body {
            centre,
            radius,
            area: 0.0,
            normal: DVec3::ZERO,
            bending,
            index,
            reflectance,
            strength,
        },
        triangles: Vec::new(),
    };
    let [reflection, refraction] = match bsdf {
        Bsdf::Mirror { reflectance } => [
            Some(body(
                Kind::Reflection,
                0.0,
                0.0,
                reflectance,
                reflectance.max_element(),
            )),
            None,
        ],
        // Of a bubble, whose index is below 1, the routes are others.
        Bsdf::Glass { index } if index > 1.0 => [
            Some(body(Kind::Reflection, 0.0, index, DVec3::ONE, GLINT)),
            Some(body(
                Kind::Refraction,
                index.recip(),
                index,
                DVec3::ONE,
                1.0,
            )),
        ],
        _ => [None, None],
    };
    reflection.into_iter().chain(refraction)
}

/// Adds a triangle of a mirror to the flat mirror in whose plane it lies, or as a new one.
fn add_flat(
    found: &mut Vec<Found>,
    primitive: usize,
    (corners, normal, reflectance): ([DVec3; 3], DVec3, DVec3),
) {
    // Beyond these it takes long to find the one in whose plane a triangle lies; a mesh has no
    // plane anyway.
    const MOST_FLATS: usize = 256;
    // Triangles of one rectangle that was turned lie in one plane but for this.
    const ROUNDING: f64 = 1e-12;
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
        flat.kind == Kind::Flat
            && flat.body.reflectance == reflectance
            && flat.body.normal.dot(normal) > 1.0 - ROUNDING
            && (centre - flat.body.centre).dot(normal).abs() <= ROUNDING * extent
    });
    if let Some((flat, primitives)) = same {
        let sum = flat.body.area + area;
        flat.body.centre = flat.body.centre.lerp(centre, area / sum);
        flat.body.area = sum;
        flat.triangles.push(edges);
        primitives.push(primitive);
    } else if found.len() < MOST_FLATS {
        let strength = reflectance.max_element();
        let body = Body {
            centre,
            radius: 0.0,
            area,
            normal,
            bending: 0.0,
            index: 0.0,
            reflectance,
            strength,
        };
        found.push((
            SceneBody {
                kind: Kind::Flat,
                body,
                triangles: vec![edges],
            },
            vec![primitive],
        ));
    }
}
