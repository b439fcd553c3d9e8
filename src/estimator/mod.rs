//! Estimators of the rendering equation (8), composed from plain parts.
//!
//! Every random decision and every equation that an estimator uses is a method of [`Parts`], whose
//! default is the library's own function. [`Standard`] overrides nothing and is what programs run; a
//! trial puts a faulty part in by overriding one method. All of it is resolved by the compiler.

mod path;
mod published;
mod report;
mod whitted;

use glam::DVec3;
use rand::Rng;

pub use path::Path;
pub use published::Published;
pub use report::Report;
pub use whitted::Whitted;

use crate::bsdf::Bsdf;
use crate::emitter::{Emitter, EmitterPoint};
use crate::frame::Frame;
use crate::rng::{uniform, uniform2};
use crate::scene::{Hit, Scene};
use crate::shape::Ray;
use crate::{fresnel, radiometry, roulette, sampling};

/// An unbiased or stated-bias estimate of the radiance that arrives along a ray.
pub trait Estimator: Sync {
    /// One estimate of the radiance that arrives at `ray.origin` from `ray.direction` (a unit vector),
    /// where `hit` is what [`Scene::intersect`] returns for the ray.
    fn radiance<R: Rng>(&self, scene: &Scene, ray: &Ray, hit: Option<Hit>, rng: &mut R) -> DVec3;
}

/// The replaceable parts of the estimators.
pub trait Parts: Sync {
    /// R of (12).
    #[inline]
    fn fresnel(&self, cos_1: f64, n1: f64, n2: f64) -> f64 {
        fresnel::reflectance(cos_1, n1, n2)
    }
    /// The refracted direction.
    #[inline]
    fn refract(&self, d: DVec3, n: DVec3, n1: f64, n2: f64) -> Option<DVec3> {
        fresnel::refract(d, n, n1, n2)
    }
    /// The factor of refracted radiance.
    #[inline]
    fn radiance_factor(&self, n1: f64, n2: f64) -> f64 {
        fresnel::radiance_factor(n1, n2)
    }
    /// The mirror direction.
    #[inline]
    fn mirror(&self, d: DVec3, n: DVec3) -> DVec3 {
        fresnel::mirror(d, n)
    }
    /// f_r of (13) or (14), local directions.
    #[inline]
    fn brdf(&self, bsdf: &Bsdf, wo: DVec3, wi: DVec3) -> DVec3 {
        bsdf.eval(wo, wi)
    }
    /// cos θ of (9).
    #[inline]
    fn cosine(&self, normal: DVec3, direction: DVec3) -> f64 {
        radiometry::cosine(normal, direction)
    }
    /// A direction by (18) and (19), local.
    #[inline]
    fn uniform_hemisphere(&self, random: [f64; 2]) -> DVec3 {
        sampling::uniform_hemisphere(random)
    }
    /// Its pdf (17) with respect to solid angle.
    #[inline]
    fn uniform_hemisphere_pdf(&self, cos_theta: f64) -> f64 {
        sampling::uniform_hemisphere_pdf(cos_theta)
    }
    /// A cosine-weighted direction, local.
    #[inline]
    fn cosine_hemisphere(&self, random: [f64; 2]) -> DVec3 {
        sampling::cosine_hemisphere(random)
    }
    /// Its pdf with respect to solid angle.
    #[inline]
    fn cosine_hemisphere_pdf(&self, cos_theta: f64) -> f64 {
        sampling::cosine_hemisphere_pdf(cos_theta)
    }
    /// The path tracer's survival policy.
    #[inline]
    fn survival_by_throughput(&self, throughput: DVec3) -> f64 {
        roulette::by_throughput(throughput)
    }
    /// The report's survival policy.
    #[inline]
    fn survival_by_absorption(&self, absorption: f64) -> f64 {
        roulette::by_absorption(absorption)
    }
    /// Whether a path survives.
    #[inline]
    fn survives(&self, r: f64, survival: f64) -> bool {
        roulette::survives(r, survival)
    }
    /// What a survivor is multiplied by.
    #[inline]
    fn roulette_weight(&self, survival: f64) -> f64 {
        roulette::weight(survival)
    }
    /// Which of `count` ≥ 1 emitters a shadow ray picks; each with probability 1/count.
    #[inline]
    fn pick_emitter(&self, r: f64, count: usize) -> usize {
        ((r * count as f64) as usize).min(count - 1)
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
    /// Whether two points see each other.
    #[inline]
    fn visible(&self, scene: &Scene, x: (DVec3, DVec3), y: (DVec3, DVec3), glass: bool) -> bool {
        scene.visible(x, y, glass)
    }
    /// The weight of a sample in multiple importance sampling.
    #[inline]
    fn mis_weight(&self, pdf: f64, other: f64) -> f64 {
        radiometry::balance(pdf, other)
    }
}

/// The parts that programs run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Standard;

impl Parts for Standard {}

/// What light the conventions let through and show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightRules {
    /// What a ray that has met only mirrors and glass sees of an emitter; `None` for its radiance.
    pub seen: Option<f64>,
    /// Whether shadow rays pass through glass, straight and unweakened.
    pub shadows_pass_glass: bool,
    /// Whether refraction scales radiance by (n₁/n₂)².
    pub radiance_factor: bool,
}

impl LightRules {
    /// Energy-consistent.
    pub const PHYSICAL: Self = Self {
        seen: None,
        shadows_pass_glass: false,
        radiance_factor: true,
    };
    /// What the report's figures show: an emitter that is seen shows 1, glass casts no shadow, and
    /// T = 1 − R is all that refraction does.
    pub const REPORT: Self = Self {
        seen: Some(1.0),
        shadows_pass_glass: true,
        radiance_factor: false,
    };
}

/// A hit as a scattering surface sees it: the frame around the normal on the ray's side.
struct Vertex {
    point: DVec3,
    frame: Frame,
    /// Towards where the ray came from, local.
    wo: DVec3,
}

impl Vertex {
    #[inline]
    fn new(hit: &Hit, ray: &Ray) -> Self {
        let facing = hit.normal * -hit.normal.dot(ray.direction).signum();
        let frame = Frame::new(facing);
        Self {
            point: hit.point,
            frame,
            wo: frame.local(-ray.direction),
        }
    }
}

/// Light that arrives at a vertex from a point picked on an emitter.
struct DirectLight {
    /// Towards the emitter, local.
    wi: DVec3,
    /// f_r L cos θ / p, before any weight.
    reflected: DVec3,
    /// p with respect to solid angle.
    pdf: f64,
}

/// Next-event estimation: one shadow ray from a diffuse vertex to a point picked on an emitter.
/// `None` if nothing arrives.
#[inline]
fn direct_light<P: Parts, R: Rng>(
    parts: &P,
    scene: &Scene,
    bsdf: &Bsdf,
    vertex: &Vertex,
    rules: &LightRules,
    rng: &mut R,
) -> Option<DirectLight> {
    let emitters = scene.emitters();
    if emitters.is_empty() {
        return None;
    }
    let emitter = &emitters[parts.pick_emitter(uniform(rng), emitters.len())];
    let light = parts.sample_emitter(emitter, uniform2(rng));
    let to_light = light.point - vertex.point;
    let distance_squared = to_light.length_squared();
    let direction = to_light * distance_squared.sqrt().recip();
    let cosine = parts.cosine(vertex.frame.z, direction);
    let cosine_at_light = parts.cosine(light.normal, -direction);
    if cosine <= 0.0 || cosine_at_light <= 0.0 {
        return None;
    }
    let wi = vertex.frame.local(direction);
    let brdf = parts.brdf(bsdf, vertex.wo, wi);
    let pdf = emitter_pdf(parts, scene, emitter, cosine_at_light, distance_squared);
    let ends = ((vertex.point, vertex.frame.z), (light.point, light.normal));
    if brdf == DVec3::ZERO || !parts.visible(scene, ends.0, ends.1, rules.shadows_pass_glass) {
        return None;
    }
    Some(DirectLight {
        wi,
        reflected: radiometry::reflected(brdf, emitter.radiance, cosine, pdf),
        pdf,
    })
}

/// The pdf, with respect to solid angle, with which [`direct_light`] picks a point on an emitter.
#[inline]
fn emitter_pdf<P: Parts>(
    parts: &P,
    scene: &Scene,
    emitter: &Emitter,
    cosine_at_light: f64,
    distance_squared: f64,
) -> f64 {
    parts.emitter_pdf_area(emitter)
        / scene.emitters().len() as f64
        / parts.solid_angle_per_area(cosine_at_light, distance_squared)
}

/// What an emitter shows along a ray that hit it; zero for its back and for other surfaces.
#[inline]
fn emitted(scene: &Scene, hit: &Hit, ray: &Ray) -> DVec3 {
    match hit.emitter {
        Some(emitter) if hit.normal.dot(ray.direction) < 0.0 => {
            scene.emitters()[emitter as usize].radiance
        }
        _ => DVec3::ZERO,
    }
}

/// [`emitted`] under light rules that show every emitter alike.
#[inline]
fn seen(scene: &Scene, hit: &Hit, ray: &Ray, rules: &LightRules) -> DVec3 {
    let radiance = emitted(scene, hit, ray);
    match rules.seen {
        Some(shown) if radiance != DVec3::ZERO => DVec3::splat(shown),
        _ => radiance,
    }
}

/// The ray that leaves a hit in a direction, and what it meets.
#[inline]
fn onward(scene: &Scene, here: &Hit, direction: DVec3) -> (Ray, Option<Hit>) {
    let ray = scene.leave(here.point, here.normal, direction);
    (ray, scene.intersect(&ray))
}

/// Radiance that arrives at a hit from a direction, by `arriving` with one of the `segments` fewer; zero
/// where this was the last.
#[inline]
fn next(
    scene: &Scene,
    here: &Hit,
    direction: DVec3,
    segments: u32,
    arriving: impl FnOnce(&Ray, Option<Hit>, u32) -> DVec3,
) -> DVec3 {
    if segments == 1 {
        return DVec3::ZERO;
    }
    let (ray, hit) = onward(scene, here, direction);
    arriving(&ray, hit, segments - 1)
}

/// The indices on the ray's side and beyond it, and the unit normal on the ray's side.
#[inline]
fn interface(hit: &Hit, ray: &Ray, index: f64) -> (f64, f64, DVec3) {
    if hit.normal.dot(ray.direction) < 0.0 {
        (1.0, index, hit.normal)
    } else {
        (index, 1.0, -hit.normal)
    }
}

/// One branch of a glass surface, chosen with probability R: its direction and radiance factor.
#[inline]
fn scatter_glass<P: Parts>(
    parts: &P,
    (n1, n2, normal): (f64, f64, DVec3),
    direction: DVec3,
    r: f64,
) -> (DVec3, f64) {
    let reflectance = parts.fresnel(-direction.dot(normal), n1, n2);
    if r >= reflectance
        && let Some(refracted) = parts.refract(direction, normal, n1, n2)
    {
        return (refracted, parts.radiance_factor(n1, n2));
    }
    (parts.mirror(direction, normal), 1.0)
}
