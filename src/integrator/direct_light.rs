//! Next-event estimation: light that shadow rays find at a surface.

use glam::DVec3;

use super::lanewise::{Lanewise, each, vectors, visible};
use super::light_sampling::{LightNumbers, LightView, PickedLight, PickedPoint, light_pdf};
use super::{PathParts, ScalarShadingPoint, ShadingPoint};
use crate::geometry::radiometry;
use crate::light::emitter::{EmitterPoint, LightSampling};
use crate::light::environment::EnvironmentMap;
use crate::material::{Bsdf, Vertex};
use crate::math::real::{Mask, Real, Vector};
use crate::math::simd::Wide;
use crate::sampling::lanes::LaneSampler;
use crate::sampling::rng::{uniform, uniform2};
use crate::sampling::sampler::Sampler;
use crate::scene::Scene;
use crate::scene::lanes::{IntersectionScratch, LaneScene};

/// How shadow rays pick emitters and points on them, and whether glass blocks them.
#[derive(Clone, Copy)]
pub(crate) struct ShadowRays {
    pub lights: LightSampling,
    /// Whether they pass through glass, straight and unattenuated.
    pub pass_glass: bool,
}

impl ShadowRays {
    /// Settings of estimators without options for shadow rays.
    pub const DEFAULT: Self = Self {
        lights: LightSampling::Importance,
        pass_glass: false,
    };
}

/// Light that arrives along a shadow ray in each lane.
#[derive(Clone, Copy)]
pub(crate) struct LightSample<R: Real> {
    /// Lanes in which light arrives.
    pub arrives: R::Mask,
    /// Directions towards the light, in local coordinates.
    pub wi: R::Vector,
    /// f_r L cos θ / p, before MIS weights.
    pub reflected: R::Vector,
    /// p with respect to solid angle.
    pub pdf: R,
}

impl<R: Real> LightSample<R> {
    /// Creates a sample without light in any lane.
    #[inline]
    fn none() -> Self {
        let none = R::Vector::zero();
        Self {
            arrives: R::Mask::splat(false),
            wi: none,
            reflected: none,
            pdf: R::splat(0.0),
        }
    }

    /// Scales the pdf and the estimate of a kind of light that was picked with this probability.
    #[inline]
    fn picked(self, probability: f64) -> Self {
        let all = R::splat(probability);
        Self {
            reflected: self.reflected * all.recip(),
            pdf: self.pdf * all,
            ..self
        }
    }

    /// Returns this sample in the lanes of the mask, and `other` elsewhere.
    #[inline]
    fn or(self, mask: R::Mask, other: Self) -> Self {
        Self {
            arrives: (mask & self.arrives) | (!mask & other.arrives),
            wi: Vector::select(mask, self.wi, other.wi),
            reflected: Vector::select(mask, self.reflected, other.reflected),
            pdf: R::select(mask, self.pdf, other.pdf),
        }
    }
}

/// Traces one shadow ray from each active lane to a point picked on an emitter.
#[inline(always)]
pub(super) fn sample_light<
    P: PathParts + ?Sized,
    X: ShadingPoint<R>,
    S: LaneSampler<R>,
    R: Wide<N>,
    const N: usize,
>(
    parts: &P,
    scene: LaneScene<'_, R, N>,
    at: &X,
    shadow_rays: ShadowRays,
    active: R::Mask,
    random: &mut S,
    scratch: &mut IntersectionScratch<R, N>,
) -> LightSample<R> {
    let numbers = LightNumbers::new(scene.scene, active, random);
    sample_light_by(parts, scene, at, shadow_rays, &numbers, active, scratch)
}

/// Traces shadow rays as [`sample_light`], with given random numbers.
#[inline(always)]
pub(super) fn sample_light_by<
    P: PathParts + ?Sized,
    X: ShadingPoint<R>,
    R: Wide<N>,
    const N: usize,
>(
    parts: &P,
    scene: LaneScene<'_, R, N>,
    at: &X,
    shadow_rays: ShadowRays,
    random: &LightNumbers<R>,
    active: R::Mask,
    scratch: &mut IntersectionScratch<R, N>,
) -> LightSample<R> {
    if scene.scene.emitters().is_empty() || !active.any() {
        return LightSample::none();
    }
    let (lights, from) = (shadow_rays.lights, at.vertex().point);
    let picked = PickedLight::new(parts, scene.scene, lights, from, random, active);
    light_from(parts, scene, at, &picked, shadow_rays.pass_glass, scratch)
}

/// Returns the light that arrives from points picked on emitters.
#[inline(always)]
fn light_from<P: PathParts + ?Sized, X: ShadingPoint<R>, R: Wide<N>, const N: usize>(
    parts: &P,
    scene: LaneScene<'_, R, N>,
    at: &X,
    picked: &PickedLight<R, N>,
    pass_glass: bool,
    scratch: &mut IntersectionScratch<R, N>,
) -> LightSample<R> {
    let (zero, vertex) = (R::splat(0.0), at.vertex());
    let (on_emitter, active) = (&picked.on_emitter, picked.active);
    let point = on_emitter.point;
    let to_light = point.point - vertex.point;
    let distance_squared = to_light.length_squared();
    let direction = to_light * distance_squared.sqrt().recip();
    let cosine_at_light = parts.lanes_cosine(point.normal, -direction, active);
    let cosine = at.cosine(parts, direction, active);
    let active = active & cosine.cmpgt(zero) & cosine_at_light.cmpgt(zero);
    if !active.any() {
        return LightSample::none();
    }
    let wi = vertex.frame.local(direction);
    let brdf = at.brdf(parts, wi, active);
    let pdf = on_emitter.pdf(parts, cosine_at_light, distance_squared, active);
    let pdf = parts.lanes_pdf_of_pick(pdf, picked.probability, active);
    let active = active & !brdf.is_zero();
    let arrives = if active.any() {
        let from = at.ray_origin();
        let to = scene.scene.ray_origin(point.point, point.normal);
        visible(parts, scene, &from, &to, pass_glass, active, scratch)
    } else {
        active
    };
    let reflected = radiometry::reflected(brdf, on_emitter.radiance, cosine, pdf);
    let reflected = at.to_radiance(parts, reflected, wi, arrives);
    LightSample {
        arrives,
        wi,
        reflected,
        pdf,
    }
}

/// Traces one shadow ray from each active lane towards the environment map.
#[inline]
fn sample_map<P: PathParts + ?Sized, X: ShadingPoint<R>, R: Wide<N>, const N: usize>(
    parts: &P,
    scene: &Scene,
    map: &EnvironmentMap,
    at: &X,
    random: [R; 2],
    active: R::Mask,
) -> LightSample<R> {
    let vertex = at.vertex();
    let sample = |i: usize| parts.sample_map(map, random.map(|r| r.lane(i)));
    let samples: [_; N] = each(active, (DVec3::Z, 1.0), sample);
    let direction = R::Vector::from_fn(|i| samples[i].0);
    let pdf = R::from_lanes(|i| samples[i].1);
    let cosine = at.cosine(parts, direction, active);
    let wi = vertex.frame.local(direction);
    let brdf = at.brdf(parts, wi, active);
    let active = active & cosine.cmpgt(R::splat(0.0)) & !brdf.is_zero();
    let origin = at.ray_origin();
    let ray = origin.spawn_ray(direction);
    let sees_background = |i: usize| {
        if parts.is_default() {
            return scene.escapes(&ray.lane(i));
        }
        parts.sees_background(scene, origin.lane(i), samples[i].0)
    };
    let arrives = R::Mask::from_fn(|i| active.lane(i) && sees_background(i));
    let radiance = vectors(arrives, |i| map.radiance(samples[i].0));
    let reflected = radiometry::reflected(brdf, radiance, cosine, pdf);
    let reflected = at.to_radiance(parts, reflected, wi, arrives);
    LightSample {
        arrives,
        wi,
        reflected,
        pdf,
    }
}

/// Traces a shadow ray from each active lane towards the environment map or an emitter, one of
/// which is picked at random.
#[inline]
pub(super) fn sample_light_or_map<
    P: PathParts + ?Sized,
    X: ShadingPoint<R>,
    S: LaneSampler<R>,
    R: Wide<N>,
    const N: usize,
>(
    parts: &P,
    scene: LaneScene<'_, R, N>,
    at: &X,
    shadow_rays: ShadowRays,
    active: R::Mask,
    random: &mut S,
    scratch: &mut IntersectionScratch<R, N>,
) -> LightSample<R> {
    let Some(map) = scene.scene.background().map() else {
        return LightSample::none();
    };
    let share = parts.map_probability(scene.scene.emitters().len());
    let to_map = active & random.uniform(active).cmplt(R::splat(share));
    let numbers = [random.uniform(to_map), random.uniform(to_map)];
    let of_map = sample_map(parts, scene.scene, map, at, numbers, to_map).picked(share);
    let to_light = active & !to_map;
    let light = sample_light(parts, scene, at, shadow_rays, to_light, random, scratch);
    of_map.or(to_map, light.picked(1.0 - share))
}

/// Light that arrives at one surface point from an emitter.
pub(super) struct DirectLight {
    /// f_r L cos θ / p.
    pub reflected: DVec3,
    /// Index of the emitter, and the point on it.
    pub emitter: usize,
    pub point: EmitterPoint,
}

/// Traces one shadow ray as [`sample_light`], from a single surface; `None` if nothing arrives.
#[inline]
pub(super) fn direct_light<P: PathParts + ?Sized, R: Sampler + ?Sized>(
    parts: &P,
    scene: &Scene,
    bsdf: &Bsdf,
    vertex: &Vertex,
    shadow_rays: ShadowRays,
    rng: &mut R,
) -> Option<DirectLight> {
    if scene.emitters().is_empty() {
        return None;
    }
    let at = ScalarShadingPoint {
        scene,
        bsdf,
        vertex,
    };
    let random = LightNumbers {
        pick: uniform(rng),
        point: uniform2(rng),
    };
    let (lights, from) = (shadow_rays.lights, vertex.point);
    let picked = PickedLight::new(parts, scene, lights, from, &random, true);
    let (lanes, scratch) = (LaneScene::new(scene), &mut IntersectionScratch::new());
    let light: LightSample<f64> =
        light_from(parts, lanes, &at, &picked, shadow_rays.pass_glass, scratch);
    let (PickedPoint { point, .. }, [emitter]) = (picked.on_emitter, picked.emitter);
    light.arrives.then_some(DirectLight {
        reflected: light.reflected,
        emitter,
        point,
    })
}

/// Returns the pdf, with respect to area, with which [`direct_light`] at a point picks a point on
/// the emitter with this index; 0 from behind.
#[inline]
pub(super) fn light_sampling_pdf<P: PathParts + ?Sized>(
    parts: &P,
    scene: &Scene,
    index: usize,
    light: &Vertex,
    from: DVec3,
) -> f64 {
    let offset = light.point - from;
    let distance_squared = offset.length_squared();
    let cosine = parts.cosine(light.frame.z, -offset.normalize());
    if cosine <= 0.0 {
        return 0.0;
    }
    let view = LightView {
        emitter: [index],
        cosine,
        distance_squared,
    };
    light_pdf(parts, scene, ShadowRays::DEFAULT.lights, from, view, true)
        * parts.solid_angle_per_area(cosine, distance_squared)
}
