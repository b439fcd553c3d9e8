//! What happens at one hit: the steps that the estimators share.

use glam::DVec3;

use super::{LightRules, Parts, sample_cosine};
use crate::bsdf::Bsdf;
use crate::emitter::{Emitter, EmitterPoint, LightSampling};
use crate::frame::Frame;
use crate::radiometry;
use crate::rng::{uniform, uniform2};
use crate::sampler::Sampler;
use crate::scene::{Hit, Scene};
use crate::shape::Ray;

/// A hit as a scattering surface sees it: the frame around the normal on the ray's side.
pub(super) struct Vertex {
    pub point: DVec3,
    pub frame: Frame,
    /// Towards where the ray came from, local.
    pub wo: DVec3,
}

impl Vertex {
    #[inline]
    pub fn new(hit: &Hit, ray: &Ray) -> Self {
        let facing = hit.normal * -hit.normal.dot(ray.direction).signum();
        let frame = Frame::new(facing);
        Self { point: hit.point, frame, wo: frame.local(-ray.direction) }
    }
}

/// Light that arrives at a vertex from a point picked on an emitter.
pub(super) struct DirectLight {
    /// Towards the emitter, local.
    pub wi: DVec3,
    /// f_r L cos θ / p, before any weight.
    pub reflected: DVec3,
    /// p with respect to solid angle.
    pub pdf: f64,
    /// The point.
    pub point: EmitterPoint,
    /// The pdf of the point with respect to area, the pick included.
    pub pdf_area: f64,
}

/// A point on an emitter that is picked among all; `None` without emitters.
#[inline]
pub(super) fn pick_point<'a, P: Parts, R: Sampler>(
    parts: &P,
    scene: &'a Scene,
    rng: &mut R,
) -> Option<(&'a Emitter, EmitterPoint)> {
    let emitters = scene.emitters();
    if emitters.is_empty() {
        return None;
    }
    let emitter = &emitters[parts.pick_emitter(uniform(rng), emitters.len())];
    Some((emitter, parts.sample_emitter(emitter, uniform2(rng))))
}

/// The pdf, with respect to area, of a point that [`pick_point`] returns.
#[inline]
pub(super) fn point_pdf<P: Parts>(parts: &P, scene: &Scene, emitter: &Emitter) -> f64 {
    parts.emitter_pdf_area(emitter) / scene.emitters().len() as f64
}

/// Next-event estimation: one shadow ray from a diffuse vertex to a point picked on an emitter, by
/// `lights`. `None` if nothing arrives.
#[inline]
pub(super) fn direct_light<P: Parts, R: Sampler>(
    parts: &P,
    scene: &Scene,
    bsdf: &Bsdf,
    vertex: &Vertex,
    rules: &LightRules,
    lights: LightSampling,
    rng: &mut R,
) -> Option<DirectLight> {
    let emitters = scene.emitters();
    if emitters.is_empty() {
        return None;
    }
    let emitter = &emitters[parts.pick_emitter(uniform(rng), emitters.len())];
    let random = uniform2(rng);
    let by_solid_angle = match lights {
        LightSampling::SolidAngle => parts.sample_solid_angle(emitter, vertex.point, random),
        LightSampling::Area => None,
    };
    let light = match by_solid_angle {
        Some((light, _)) => light,
        None => parts.sample_emitter(emitter, random),
    };
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
    let pdf = match by_solid_angle {
        Some((_, pdf)) => pdf,
        None => area_pdf(parts, emitter, cosine_at_light, distance_squared),
    } / scene.emitters().len() as f64;
    let ends = ((vertex.point, vertex.frame.z), (light.point, light.normal));
    if brdf == DVec3::ZERO || !parts.visible(scene, ends.0, ends.1, rules.shadows_pass_glass) {
        return None;
    }
    Some(DirectLight {
        wi,
        reflected: radiometry::reflected(brdf, emitter.radiance, cosine, pdf),
        pdf,
        point: light,
        pdf_area: point_pdf(parts, scene, emitter),
    })
}

/// The pdf, with respect to solid angle, of a point uniform in area on an emitter.
#[inline]
fn area_pdf<P: Parts>(
    parts: &P,
    emitter: &Emitter,
    cosine_at_light: f64,
    distance_squared: f64,
) -> f64 {
    parts.emitter_pdf_area(emitter) / parts.solid_angle_per_area(cosine_at_light, distance_squared)
}

/// The pdf, with respect to solid angle, with which [`direct_light`] picks the point of an emitter that
/// a ray has hit.
#[inline]
pub(super) fn emitter_pdf<P: Parts>(
    parts: &P,
    scene: &Scene,
    emitter: &Emitter,
    lights: LightSampling,
    (ray, hit): (&Ray, &Hit),
) -> f64 {
    let by_solid_angle = match lights {
        LightSampling::SolidAngle => parts.pdf_solid_angle(emitter, ray.origin),
        LightSampling::Area => None,
    };
    let pdf = by_solid_angle.unwrap_or_else(|| {
        let cosine_at_light = parts.cosine(hit.normal, -ray.direction);
        area_pdf(parts, emitter, cosine_at_light, hit.t * hit.t)
    });
    pdf / scene.emitters().len() as f64
}

/// What an emitter shows along a ray that hit it; zero for its back and for other surfaces.
#[inline]
pub(super) fn emitted(scene: &Scene, hit: &Hit, ray: &Ray) -> DVec3 {
    match hit.emitter {
        Some(emitter) if hit.normal.dot(ray.direction) < 0.0 => {
            scene.emitters()[emitter as usize].radiance
        }
        _ => DVec3::ZERO,
    }
}

/// [`emitted`] under light rules that show every emitter alike.
#[inline]
pub(super) fn seen(scene: &Scene, hit: &Hit, ray: &Ray, rules: &LightRules) -> DVec3 {
    let radiance = emitted(scene, hit, ray);
    match rules.seen {
        Some(shown) if radiance != DVec3::ZERO => DVec3::splat(shown),
        _ => radiance,
    }
}

/// The ray that leaves a hit in a direction, and what it meets.
#[inline]
pub(super) fn onward(scene: &Scene, here: &Hit, direction: DVec3) -> (Ray, Option<Hit>) {
    let ray = scene.leave(here.point, here.normal, direction);
    (ray, scene.intersect(&ray))
}

/// Radiance that arrives at a hit from a direction, by `arriving` with one of the `segments` fewer; zero
/// where none is left. The first is always followed, even of none.
#[inline]
pub(super) fn next(
    scene: &Scene,
    here: &Hit,
    direction: DVec3,
    segments: u32,
    arriving: impl FnOnce(&Ray, Option<Hit>, u32) -> DVec3,
) -> DVec3 {
    if segments <= 1 {
        return DVec3::ZERO;
    }
    let (ray, hit) = onward(scene, here, direction);
    arriving(&ray, hit, segments - 1)
}

/// The indices on the ray's side and beyond it, and the unit normal on the ray's side.
#[inline]
pub(super) fn interface(hit: &Hit, ray: &Ray, index: f64) -> (f64, f64, DVec3) {
    if hit.normal.dot(ray.direction) < 0.0 {
        (1.0, index, hit.normal)
    } else {
        (index, 1.0, -hit.normal)
    }
}

/// One branch of a glass surface, chosen with probability R: its direction and radiance factor.
#[inline]
pub(super) fn scatter_glass<P: Parts>(
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

/// One way on from a hit.
pub(super) struct Scattered {
    /// World space, unit.
    pub direction: DVec3,
    /// f_r cos θ / p of the direction; for mirror and glass the weight of the branch taken.
    pub throughput: DVec3,
    /// The radiance factor of refraction, which particles that carry flux do without; 1 elsewhere.
    pub factor: f64,
    /// p with respect to solid angle; `None` if the direction had no choice but a few.
    pub pdf: Option<f64>,
}

/// Continues a path at a hit; `None` where it is absorbed. Diffuse surfaces take cosine-weighted
/// directions.
#[inline]
pub(super) fn scatter<P: Parts, R: Sampler>(
    parts: &P,
    scene: &Scene,
    here: &Hit,
    ray: &Ray,
    rng: &mut R,
) -> Option<Scattered> {
    match scene.surface(here).bsdf {
        Bsdf::Black => None,
        Bsdf::Mirror { reflectance } => Some(Scattered {
            direction: parts.mirror(ray.direction, here.normal),
            throughput: reflectance,
            factor: 1.0,
            pdf: None,
        }),
        Bsdf::Glass { index } => {
            let sides = interface(here, ray, index);
            let (direction, factor) = scatter_glass(parts, sides, ray.direction, uniform(rng));
            Some(Scattered { direction, throughput: DVec3::ONE, factor, pdf: None })
        }
        ref bsdf @ (Bsdf::Lambert { .. } | Bsdf::OrenNayar { .. } | Bsdf::Eon { .. }) => {
            let vertex = Vertex::new(here, ray);
            let sample = sample_cosine(parts, bsdf, vertex.wo, uniform2(rng))?;
            Some(Scattered {
                direction: vertex.frame.world(sample.wi),
                throughput: sample.weight,
                factor: 1.0,
                pdf: Some(sample.pdf),
            })
        }
    }
}

/// Russian roulette by throughput; `None` if the path ends here, else what the survivor's throughput
/// is multiplied by.
#[inline]
pub(super) fn survive<P: Parts, R: Sampler>(
    parts: &P,
    throughput: DVec3,
    rng: &mut R,
) -> Option<f64> {
    let survival = parts.survival_by_throughput(throughput);
    parts.survives(uniform(rng), survival).then(|| parts.roulette_weight(survival))
}
