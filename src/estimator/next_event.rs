//! Next-event estimation: light that shadow rays find at a vertex, and how it is combined with light that
//! paths find by hitting it.

use glam::DVec3;

use super::LightRules;
use super::path::Strategy;
use crate::bsdf::{Bsdf, Scattering, Vertex};
use crate::emitter::{Emitter, EmitterPoint, LightSampling};
use crate::environment::EnvironmentMap;
use crate::light_pick::FluxPicks;
use crate::rng::{uniform, uniform2};
use crate::sampler::Sampler;
use crate::scene::{Hit, Scene};
use crate::shape::Ray;
use crate::specular::{Kind, Route, SceneBody};
use crate::{light_pick, radiometry};

/// The replaceable parts of next-event estimation.
pub trait NextEvent: Sync {
    /// Which emitter a particle starts from, or a shadow ray picks wherever it starts.
    #[inline]
    fn pick_emitter(&self, r: f64, picks: &FluxPicks) -> usize {
        picks.pick(r)
    }
    /// What an emitter may contribute at a point.
    #[inline]
    fn contribution(&self, emitter: &Emitter, from: DVec3) -> f64 {
        emitter.contribution(from)
    }
    /// Which emitter a shadow ray picks by shares, and its share.
    #[inline]
    fn pick_by_share(&self, r: f64, shares: &[f64]) -> (usize, f64) {
        let (index, share) = light_pick::pick(shares, r);
        (index as usize, share)
    }
    /// The pdf of a point on an emitter that is picked with this probability, from its pdf on that emitter, with
    /// respect to the same measure.
    #[inline]
    fn pdf_of_pick(&self, pdf: f64, probability: f64) -> f64 {
        pdf * probability
    }
    /// A point on an emitter.
    #[inline]
    fn sample_emitter(&self, emitter: &Emitter, random: [f64; 2]) -> EmitterPoint {
        emitter.sample(random)
    }
    /// Its pdf with respect to area.
    #[inline]
    fn emitter_pdf_area(&self, emitter: &Emitter) -> f64 {
        emitter.pdf_area()
    }
    /// Solid angle per area of an emitter.
    #[inline]
    fn solid_angle_per_area(&self, cosine_at_emitter: f64, distance_squared: f64) -> f64 {
        radiometry::solid_angle_per_area(cosine_at_emitter, distance_squared)
    }
    /// A point on an emitter whose direction is uniform in the solid angle seen from a point, and its
    /// pdf with respect to that; `None` for emitters that are sampled by area alone.
    #[inline]
    fn sample_solid_angle(&self, emitter: &Emitter, from: DVec3, random: [f64; 2]) -> Option<(EmitterPoint, f64)> {
        emitter.sample_solid_angle(from, random)
    }
    /// The same pdf for any point of the emitter's front.
    #[inline]
    fn pdf_solid_angle(&self, emitter: &Emitter, from: DVec3) -> Option<f64> {
        emitter.pdf_solid_angle(from)
    }
    /// The probability that a shadow ray looks for the light of an environment map, not for that of one of `count`
    /// emitters.
    #[inline]
    fn share_of_map(&self, count: usize) -> f64 {
        if count == 0 { 1.0 } else { 0.5 }
    }
    /// A direction towards an environment map, and its pdf with respect to solid angle.
    #[inline]
    fn sample_map(&self, map: &EnvironmentMap, random: [f64; 2]) -> (DVec3, f64) {
        map.sample(random)
    }
    /// The same pdf for any direction.
    #[inline]
    fn map_pdf(&self, map: &EnvironmentMap, direction: DVec3) -> f64 {
        map.pdf(direction)
    }
    /// Whether a point with its normal sees the background in a direction.
    #[inline]
    fn sees_background(&self, scene: &Scene, x: (DVec3, DVec3), direction: DVec3) -> bool {
        scene.sees_background(x, direction)
    }
    /// Whether two points see each other.
    #[inline]
    fn visible(&self, scene: &Scene, x: (DVec3, DVec3), y: (DVec3, DVec3), glass: bool) -> bool {
        scene.visible(x, y, glass)
    }
    /// The weight of a sample in multiple importance sampling by the balance heuristic.
    #[inline]
    fn mis_weight(&self, pdf: f64, other: f64) -> f64 {
        radiometry::balance(pdf, other)
    }
    /// The same by the power heuristic.
    #[inline]
    fn mis_power_weight(&self, pdf: f64, other: f64) -> f64 {
        radiometry::power(pdf, other)
    }
    /// What is made of a route by way of a body, one of up to three; `None` if it is left out.
    #[inline]
    fn route(&self, _: &SceneBody, _number: usize, route: Route<DVec3>) -> Option<Route<DVec3>> {
        Some(route)
    }
    /// What a body lets on where it is met at this cosine, and with what chance a path goes on there.
    #[inline]
    fn lets_on(&self, body: &SceneBody, cosine: f64) -> (DVec3, f64) {
        body.body.lets_on(cosine, body.kind == Kind::Refraction)
    }
    /// Whether light that a path hits counts if it is not weighted by pdfs; `sampled` if shadow rays
    /// look for the same light (in [`Report`](super::Report): or if its rules leave it out).
    #[inline]
    fn hit_counts(&self, strategy: Strategy, sampled: bool) -> bool {
        !(sampled && strategy == Strategy::Light)
    }
}

/// How shadow rays of estimators that leave no choice pick emitters and points on them.
pub(super) const SHADOW_RAYS: LightSampling = LightSampling::ByContribution;

/// Light that arrives at a vertex along a shadow ray.
pub(super) struct LightSample {
    /// Towards the emitter, local.
    pub wi: DVec3,
    /// f_r L cos θ / p, before any weight.
    pub reflected: DVec3,
    /// p with respect to solid angle.
    pub pdf: f64,
    /// The point on an emitter, and the emitter's number; `None` from the background.
    pub point: Option<(EmitterPoint, usize)>,
}

impl LightSample {
    /// The same as one of two kinds of light, picked with this probability.
    #[inline]
    pub fn picked(self, probability: f64) -> Self {
        Self { reflected: self.reflected / probability, pdf: self.pdf * probability, ..self }
    }
}

/// A point on an emitter that is picked among all, and the emitter's number; `None` without emitters.
#[inline]
pub(super) fn pick_point<P: NextEvent, R: Sampler>(
    parts: &P,
    scene: &Scene,
    rng: &mut R,
) -> Option<(usize, EmitterPoint)> {
    if scene.emitters().is_empty() {
        return None;
    }
    let index = parts.pick_emitter(uniform(rng), scene.flux_picks());
    Some((index, parts.sample_emitter(&scene.emitters()[index], uniform2(rng))))
}

/// The pdf, with respect to area, of a point that [`pick_point`] returns on the emitter of this number.
#[inline]
pub(super) fn point_pdf<P: NextEvent>(parts: &P, scene: &Scene, index: usize) -> f64 {
    parts.pdf_of_pick(parts.emitter_pdf_area(&scene.emitters()[index]), scene.flux_picks().probability(index))
}

/// The number of the emitter that a shadow ray from a point picks, by `lights`, and the probability of that.
#[inline]
pub(crate) fn pick_from<P: NextEvent>(
    parts: &P,
    scene: &Scene,
    lights: LightSampling,
    from: DVec3,
    r: f64,
) -> (usize, f64) {
    let emitters = scene.emitters();
    let count = emitters.len();
    if !lights.by_contribution(count) {
        let index = parts.pick_emitter(r, scene.flux_picks());
        return (index, scene.flux_picks().probability(index));
    }
    let contribution = |i: usize| parts.contribution(&emitters[i], from);
    scene.light_groups().pick(r, from, contribution, |r, shares| parts.pick_by_share(r, shares))
}

/// The same probability, of the emitter of this number.
#[inline]
pub(crate) fn probability_of_pick<P: NextEvent>(
    parts: &P,
    scene: &Scene,
    lights: LightSampling,
    from: DVec3,
    index: usize,
) -> f64 {
    let emitters = scene.emitters();
    let count = emitters.len();
    if !lights.by_contribution(count) {
        return scene.flux_picks().probability(index);
    }
    scene.light_groups().probability(index, from, |i| parts.contribution(&emitters[i], from))
}

/// Next-event estimation: one shadow ray from a diffuse vertex to a point picked on an emitter, by
/// `lights`. `None` if nothing arrives.
#[inline]
pub(super) fn direct_light<P: NextEvent + Scattering, R: Sampler>(
    parts: &P,
    scene: &Scene,
    bsdf: &Bsdf,
    vertex: &Vertex,
    rules: &LightRules,
    lights: LightSampling,
    rng: &mut R,
) -> Option<LightSample> {
    if scene.emitters().is_empty() {
        return None;
    }
    light_from(parts, scene, (bsdf, vertex), rules, lights, LightNumbers::new(rng))
}

/// The uniform numbers of a shadow ray.
#[derive(Clone, Copy)]
pub(super) struct LightNumbers {
    /// Which emitter.
    pub pick: f64,
    /// Which point.
    pub point: [f64; 2],
}

impl LightNumbers {
    #[inline]
    pub fn new<R: Sampler>(rng: &mut R) -> Self {
        Self { pick: uniform(rng), point: uniform2(rng) }
    }
}

/// [`direct_light`] by these numbers in a scene with emitters.
#[inline]
pub(super) fn light_from<P: NextEvent + Scattering>(
    parts: &P,
    scene: &Scene,
    (bsdf, vertex): (&Bsdf, &Vertex),
    rules: &LightRules,
    lights: LightSampling,
    LightNumbers { pick, point: random }: LightNumbers,
) -> Option<LightSample> {
    let emitters = scene.emitters();
    let (index, probability) = pick_from(parts, scene, lights, vertex.point, pick);
    if probability == 0.0 {
        return None;
    }
    let emitter = &emitters[index];
    let by_solid_angle =
        if lights.by_solid_angle(emitter) { parts.sample_solid_angle(emitter, vertex.point, random) } else { None };
    let light = match by_solid_angle {
        Some((light, _)) => light,
        None => parts.sample_emitter(emitter, random),
    };
    let to_light = light.point - vertex.point;
    let distance_squared = to_light.length_squared();
    let direction = to_light * distance_squared.sqrt().recip();
    let cosine_at_light = parts.cosine(light.normal, -direction);
    let cosine = cosine_towards(parts, bsdf, vertex, direction);
    if cosine <= 0.0 || cosine_at_light <= 0.0 {
        return None;
    }
    let wi = vertex.frame.local(direction);
    let brdf = parts.brdf(bsdf, vertex.wo, wi);
    let pdf_on_emitter = match by_solid_angle {
        Some((_, pdf)) => pdf,
        None => area_pdf(parts, emitter, cosine_at_light, distance_squared),
    };
    let pdf = parts.pdf_of_pick(pdf_on_emitter, probability);
    let ends = ((vertex.point, vertex.frame.z), (light.point, light.normal));
    if brdf == DVec3::ZERO || !parts.visible(scene, ends.0, ends.1, rules.shadows_pass_glass) {
        return None;
    }
    Some(LightSample {
        wi,
        reflected: parts.radiance_factor_from(bsdf, wi) * radiometry::reflected(brdf, emitter.radiance, cosine, pdf),
        pdf,
        point: Some((light, index)),
    })
}

/// The cosine between the normal and a direction towards light; rough glass takes light from behind as well.
#[inline]
fn cosine_towards<P: Scattering>(parts: &P, bsdf: &Bsdf, vertex: &Vertex, direction: DVec3) -> f64 {
    let normal = vertex.frame.z;
    let behind = bsdf.is_rough_glass() && normal.dot(direction) < 0.0;
    parts.cosine(if behind { -normal } else { normal }, direction)
}

/// One shadow ray from a diffuse vertex towards the environment map. `None` if nothing arrives.
#[inline]
pub(super) fn light_of_map<P: NextEvent + Scattering>(
    parts: &P,
    (scene, map): (&Scene, &EnvironmentMap),
    bsdf: &Bsdf,
    vertex: &Vertex,
    random: [f64; 2],
) -> Option<LightSample> {
    let (direction, pdf) = parts.sample_map(map, random);
    let cosine = cosine_towards(parts, bsdf, vertex, direction);
    let wi = vertex.frame.local(direction);
    let brdf = parts.brdf(bsdf, vertex.wo, wi);
    if cosine <= 0.0 || brdf == DVec3::ZERO || !parts.sees_background(scene, (vertex.point, vertex.frame.z), direction)
    {
        return None;
    }
    let reflected =
        parts.radiance_factor_from(bsdf, wi) * radiometry::reflected(brdf, map.radiance(direction), cosine, pdf);
    Some(LightSample { wi, reflected, pdf, point: None })
}

/// The pdf, with respect to solid angle, of a point uniform in area on an emitter.
#[inline]
fn area_pdf<P: NextEvent>(parts: &P, emitter: &Emitter, cosine_at_light: f64, distance_squared: f64) -> f64 {
    parts.emitter_pdf_area(emitter) / parts.solid_angle_per_area(cosine_at_light, distance_squared)
}

/// The pdf, with respect to solid angle, with which [`direct_light`] picks the point of the emitter of this number
/// that a ray has hit.
#[inline]
pub(super) fn emitter_pdf<P: NextEvent + Scattering>(
    parts: &P,
    scene: &Scene,
    index: usize,
    lights: LightSampling,
    (ray, hit): (&Ray, &Hit),
) -> f64 {
    let cosine_at_light = parts.cosine(hit.normal, -ray.direction);
    pdf_from(parts, scene, index, lights, ray.origin, (cosine_at_light, hit.t * hit.t))
}

/// The same from a point at which its emitter is seen at this cosine and squared distance.
#[inline]
fn pdf_from<P: NextEvent>(
    parts: &P,
    scene: &Scene,
    index: usize,
    lights: LightSampling,
    from: DVec3,
    (cosine_at_light, distance_squared): (f64, f64),
) -> f64 {
    let emitter = &scene.emitters()[index];
    let probability = probability_of_pick(parts, scene, lights, from, index);
    if probability == 0.0 {
        return 0.0;
    }
    let by_solid_angle = if lights.by_solid_angle(emitter) { parts.pdf_solid_angle(emitter, from) } else { None };
    let pdf = by_solid_angle.unwrap_or_else(|| area_pdf(parts, emitter, cosine_at_light, distance_squared));
    parts.pdf_of_pick(pdf, probability)
}

/// The pdf, with respect to area, with which [`direct_light`] at a point picks a place on the emitter of this number by
/// [`SHADOW_RAYS`]; 0 from behind.
#[inline]
pub(super) fn picked_pdf<P: NextEvent + Scattering>(
    parts: &P,
    scene: &Scene,
    (index, light): (usize, &Vertex),
    from: DVec3,
) -> f64 {
    let offset = light.point - from;
    let distance_squared = offset.length_squared();
    let cosine_at_light = parts.cosine(light.frame.z, -offset.normalize());
    if cosine_at_light <= 0.0 {
        return 0.0;
    }
    pdf_from(parts, scene, index, SHADOW_RAYS, from, (cosine_at_light, distance_squared))
        * parts.solid_angle_per_area(cosine_at_light, distance_squared)
}
