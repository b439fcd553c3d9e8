//! Scattering at a surface: one interface for all models, with parts that a trial can replace.

use std::any::Any;
use std::fmt::Debug;

use glam::DVec3;
use rand::Rng;

use super::{Bsdf, fresnel};
use crate::geometry::radiometry;
use crate::geometry::radiometry::reflected;
use crate::geometry::shape::{Hit, Ray};
use crate::math::frame::Frame;
use crate::math::real::{Mask, MaskOf, Real, Vector};
use crate::sampling::rng::{uniform, uniform2};
use crate::sampling::warp;

/// A surface point at which a path scatters, with the frame around the normal on the side from
/// which the ray came.
#[derive(Clone, Copy, Debug)]
pub struct Vertex<V: Vector = DVec3> {
    /// The point, world space.
    pub point: V,
    /// Frame whose z is the unit normal on the ray's side.
    pub frame: Frame<V>,
    /// Unit direction of the incoming ray, world space.
    pub direction: V,
    /// Unit direction towards the ray's origin, local.
    pub wo: V,
    /// Whether the ray came from the side to which the surface's own normal points.
    pub outside: MaskOf<V>,
}

impl Vertex {
    /// Creates the vertex where a ray hit a surface.
    #[inline]
    pub fn new(hit: &Hit, ray: &Ray) -> Self {
        Self::of(hit.point, hit.normal, ray.direction)
    }

    /// Creates a vertex at the origin with normal z, whose world space is its local space: `wo` is
    /// a unit vector above the horizon, `outside` as in [`Vertex`].
    pub fn local(wo: DVec3, outside: bool) -> Self {
        Self::of(DVec3::ZERO, if outside { DVec3::Z } else { -DVec3::Z }, -wo)
    }

    /// Creates the vertex of a light path on an emitter.
    #[inline]
    pub(crate) fn emitting(point: DVec3, normal: DVec3) -> Self {
        Self::of(point, normal, -normal)
    }
}

impl<V: Vector> Vertex<V> {
    #[inline]
    pub(crate) fn of(point: V, normal: V, direction: V) -> Self {
        let cosine = normal.dot(direction);
        let frame = Frame::new(normal * -V::Real::splat(1.0).copysign(cosine));
        let wo = frame.local(-direction);
        Self {
            point,
            frame,
            direction,
            wo,
            outside: cosine.cmplt(V::Real::splat(0.0)),
        }
    }

    /// Returns the vertex of a lane.
    pub(crate) fn lane(&self, lane: usize) -> Vertex {
        let [x, y, z] = [self.frame.x, self.frame.y, self.frame.z].map(|v| v.lane(lane));
        Vertex {
            point: self.point.lane(lane),
            frame: Frame { x, y, z },
            direction: self.direction.lane(lane),
            wo: self.wo.lane(lane),
            outside: self.outside.lane(lane),
        }
    }

    /// Returns the indices of refraction on the ray's side and beyond, for an object of index
    /// `index` in air.
    #[inline]
    pub fn indices(&self, index: V::Real) -> (V::Real, V::Real) {
        let air = V::Real::splat(1.0);
        (
            Real::select(self.outside, air, index),
            Real::select(self.outside, index, air),
        )
    }
}

/// A sampled direction of scattering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// Unit direction away from the surface: in world space from a [`Vertex`], local from local
    /// directions.
    pub direction: DVec3,
    /// f_r cos θ / p per colour channel; the reflectance of a mirror, 1 for the branch of glass
    /// that is chosen with its probability. Without the radiance factor.
    pub weight: DVec3,
    /// p with respect to solid angle, 1/sr; `None` for directions of a discrete choice (mirror,
    /// glass).
    pub pdf: Option<f64>,
    /// Factor of radiance due to refraction, which particles that carry flux omit; 1 elsewhere.
    pub radiance_factor: f64,
}

/// A user-defined reflection model: opaque, reciprocal, without Dirac distributions. Local unit
/// directions away from the surface, the normal is z; both are above the horizon.
pub trait Model: Any + Debug + Send + Sync {
    /// Returns f_r per colour channel, 1/sr.
    fn eval(&self, wo: DVec3, wi: DVec3) -> DVec3;
    /// Samples a direction from two uniform numbers in [0, 1); `None`, or a direction below the
    /// horizon, ends the path.
    fn sample(&self, wo: DVec3, random: [f64; 2]) -> Option<DVec3>;
    /// Returns the pdf of [`sample`](Self::sample) with respect to solid angle, 1/sr.
    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64;
    /// Returns the albedo for a denoiser, in [0, 1] per colour channel.
    fn albedo(&self) -> DVec3;
}

/// Models are equal if they are the same object.
impl PartialEq for dyn Model {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::addr_eq(self, other)
    }
}

/// Replaceable parts of scattering, and the functions built on them.
pub trait Scattering: Sync {
    /// Returns whether nothing is replaced, here and in the other traits of parts: then all lanes
    /// are computed at once.
    #[inline]
    fn is_default(&self) -> bool {
        false
    }
    /// Returns R of (12).
    #[inline]
    fn fresnel(&self, cos_1: f64, n1: f64, n2: f64) -> f64 {
        fresnel::reflectance(cos_1, n1, n2)
    }
    /// Returns the refracted direction; `None` in total reflection.
    #[inline]
    fn refract(&self, d: DVec3, n: DVec3, n1: f64, n2: f64) -> Option<DVec3> {
        fresnel::refract(d, n, n1, n2)
    }
    /// Returns the factor of refracted radiance.
    #[inline]
    fn radiance_factor(&self, n1: f64, n2: f64) -> f64 {
        fresnel::radiance_factor(n1, n2)
    }
    /// Returns the mirror direction.
    #[inline]
    fn mirror(&self, d: DVec3, n: DVec3) -> DVec3 {
        fresnel::reflect(d, n)
    }
    /// Returns f_r of (13) or (14), for local directions.
    #[inline]
    fn brdf(&self, bsdf: &Bsdf, wo: DVec3, wi: DVec3) -> DVec3 {
        bsdf.eval(wo, wi)
    }
    /// Returns cos θ of (9).
    #[inline]
    fn cosine(&self, normal: DVec3, direction: DVec3) -> f64 {
        radiometry::cosine(normal, direction)
    }
    /// Samples a local direction by (18) and (19).
    #[inline]
    fn uniform_hemisphere(&self, random: [f64; 2]) -> DVec3 {
        warp::uniform_hemisphere(random)
    }
    /// Returns the pdf (17) of [`uniform_hemisphere`](Self::uniform_hemisphere) with respect to
    /// solid angle.
    #[inline]
    fn uniform_hemisphere_pdf(&self, cos_theta: f64) -> f64 {
        warp::uniform_hemisphere_pdf(cos_theta)
    }
    /// Samples a cosine-weighted local direction.
    #[inline]
    fn cosine_hemisphere(&self, random: [f64; 2]) -> DVec3 {
        warp::cosine_hemisphere(random)
    }
    /// Returns the pdf of [`cosine_hemisphere`](Self::cosine_hemisphere) with respect to solid
    /// angle.
    #[inline]
    fn cosine_hemisphere_pdf(&self, cos_theta: f64) -> f64 {
        warp::cosine_hemisphere_pdf(cos_theta)
    }

    /// Returns the pdf of [`sample`](Self::sample) with respect to solid angle, for local
    /// directions; 0 for mirror and glass.
    #[inline]
    fn pdf(&self, bsdf: &Bsdf, wo: DVec3, wi: DVec3) -> f64 {
        if bsdf.is_sampled_by_cosine() {
            return self.cosine_hemisphere_pdf(wi.z);
        }
        match bsdf {
            Bsdf::Model(model) if wo.z > 0.0 && wi.z > 0.0 => model.pdf(wo, wi),
            Bsdf::RoughGlass(glass) if wo.z > 0.0 => glass.pdf(wo, wi),
            _ => 0.0,
        }
    }

    /// Samples a local direction at a surface whose model has a density, from uniform numbers, of
    /// which the third counts for rough glass only; `None` where the density is zero.
    #[inline]
    fn sample_non_delta(&self, bsdf: &Bsdf, wo: DVec3, random: [f64; 3]) -> Option<BsdfSample> {
        let [r1, r2, _] = random;
        let wi = if bsdf.is_sampled_by_cosine() {
            self.cosine_hemisphere([r1, r2])
        } else {
            bsdf.sample_direction(wo, random)?
        };
        let pdf = self.pdf(bsdf, wo, wi);
        (pdf != 0.0).then(|| self.weighted(bsdf, wo, wi, pdf))
    }

    /// Samples a local direction uniformly over the hemisphere, whatever the model.
    #[inline]
    fn sample_uniform(&self, bsdf: &Bsdf, wo: DVec3, random: [f64; 2]) -> BsdfSample {
        let wi = self.uniform_hemisphere(random);
        self.weighted(bsdf, wo, wi, self.uniform_hemisphere_pdf(wi.z))
    }

    /// Returns the factor of radiance that arrives from a direction: that of refraction for rough
    /// glass, from behind.
    #[inline]
    fn radiance_factor_from(&self, bsdf: &Bsdf, wi: DVec3) -> f64 {
        match bsdf {
            Bsdf::RoughGlass(glass) if wi.z < 0.0 => self.radiance_factor(1.0, glass.index),
            _ => 1.0,
        }
    }

    /// Returns a direction of this pdf with its weight.
    #[inline]
    fn weighted(&self, bsdf: &Bsdf, wo: DVec3, wi: DVec3, pdf: f64) -> BsdfSample {
        let brdf = self.brdf(bsdf, wo, wi);
        let cosine = self.cosine(DVec3::Z, wi.with_z(wi.z.abs()));
        BsdfSample {
            direction: wi,
            weight: reflected(brdf, DVec3::ONE, cosine, pdf),
            pdf: Some(pdf),
            radiance_factor: self.radiance_factor_from(bsdf, wi),
        }
    }

    /// Samples a scattered direction at a vertex, in world space; `None` where light is absorbed.
    /// Draws two numbers for a model with a density, three for rough glass, one for glass, none for
    /// a mirror.
    #[inline]
    fn sample(&self, bsdf: &Bsdf, at: &Vertex, rng: &mut dyn Rng) -> Option<BsdfSample> {
        match *bsdf {
            Bsdf::Black => None,
            Bsdf::Mirror { reflectance } => Some(BsdfSample {
                direction: self.mirror(at.direction, at.frame.z),
                weight: reflectance,
                pdf: None,
                radiance_factor: 1.0,
            }),
            Bsdf::Glass { index } => Some(self.sample_glass(index, at, uniform(rng))),
            _ => {
                let [r1, r2] = uniform2(rng);
                let local = if bsdf.is_rough_glass() {
                    let (bsdf, random) = (bsdf.oriented(at.outside), [r1, r2, uniform(rng)]);
                    self.sample_non_delta(&bsdf, at.wo, random)?
                } else {
                    self.sample_non_delta(bsdf, at.wo, [r1, r2, 0.0])?
                };
                Some(BsdfSample {
                    direction: at.frame.world(local.direction),
                    ..local
                })
            }
        }
    }

    /// Samples one branch of a glass surface: reflection with probability R, from one uniform
    /// number.
    #[inline]
    fn sample_glass(&self, index: f64, at: &Vertex, random: f64) -> BsdfSample {
        let (n1, n2) = at.indices(index);
        let normal = at.frame.z;
        let reflectance = self.fresnel(-at.direction.dot(normal), n1, n2);
        let refracted = (random >= reflectance)
            .then(|| self.refract(at.direction, normal, n1, n2))
            .flatten();
        let (direction, radiance_factor) = match refracted {
            Some(refracted) => (refracted, self.radiance_factor(n1, n2)),
            None => (self.mirror(at.direction, normal), 1.0),
        };
        BsdfSample {
            direction,
            weight: DVec3::ONE,
            pdf: None,
            radiance_factor,
        }
    }
}

/// Default parts: the library's own functions.
#[derive(Clone, Copy, Debug, Default)]
pub struct DefaultParts;

impl Scattering for DefaultParts {
    #[inline]
    fn is_default(&self) -> bool {
        true
    }
}
