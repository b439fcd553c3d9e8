//! The MIS weights of BSDF and light samples in the path tracer, taken from its own estimates: one
//! path at a time, with chosen random numbers, against densities in closed form.

use whitefurnace::harness::pointwise::LargestError;
use whitefurnace::integrator::Heuristic;
use whitefurnace::light::emitter::{Emitter, EmitterShape, LightSampling};
use whitefurnace::light::light_sampler::UNIFORM_FRACTION;
use whitefurnace::math::frame::Frame;
use whitefurnace::sampling::warp::cosine_hemisphere_inverse;

use crate::mean_radiance::any_direction;
use crate::prelude::*;
use crate::scenes::{
    FLOOR, LIGHT, NEAR, ball, lambert, light, panel, pick_probabilities, scene, square, triangle,
};
use crate::script::Scripted;

/// A path tracer from which weights are taken: its components, and the heuristic and light sampling
/// that it uses when these are asked for.
#[derive(Clone, Copy)]
pub struct Tracer {
    parts: PartTable,
    heuristic: fn(Heuristic) -> Heuristic,
    lights: fn(LightSampling) -> LightSampling,
}

/// The path tracers that give the weights of hits and of shadow rays: one and the same, or two that
/// differ.
#[derive(Clone, Copy)]
pub struct Tracers {
    /// The weights of hits.
    pub hits: Tracer,
    /// The weights of shadow rays.
    pub shadows: Tracer,
}

const TRACER: Tracer = Tracer {
    parts: CORRECT,
    heuristic: |heuristic| heuristic,
    lights: |lights| lights,
};
const TRACERS: Tracers = Tracers {
    hits: TRACER,
    shadows: TRACER,
};

/// A floor that emits, a square so near that most directions hit it, and farther lights of every
/// shape, so that few of the densities agree.
fn lights() -> Arc<Scene> {
    scene("lights near and far", |s| {
        // Rounding decides whether points of this floor are before or behind each other.
        square(
            s,
            DVec3::ZERO,
            2.0,
            true,
            Surface::new(lambert(FLOOR)).emitting(DVec3::splat(0.1 * LIGHT)),
        );
        square(s, NEAR[0].z * DVec3::Z, 2.0, false, light(LIGHT));
        let corner = DVec3::new(3.0, -1.0, 0.5);
        triangle(
            s,
            &[corner, corner + 2.0 * DVec3::Y, corner + DVec3::ONE],
            light(3.0 * LIGHT),
        );
        ball(
            s,
            Sphere::new(DVec3::new(-4.0, 0.0, 1.0), 0.5),
            light(5.0 * LIGHT),
        );
        // These two cannot be sampled by solid angle and fall back to area.
        let skewed = [2.0 * DVec3::Y + 0.7 * DVec3::X, DVec3::new(1.0, 0.0, 1.5)];
        panel(s, DVec3::new(3.0, 3.0, 0.4), skewed, light(LIGHT));
        ball(
            s,
            Sphere {
                zone: [-0.2, 0.4],
                ..Sphere::new(DVec3::new(-1.0, -4.0, 0.8), 0.6)
            },
            light(LIGHT),
        );
    })
}

/// The solid angle of a triangle by Girard's theorem: the excess of its angles.
fn girard(from: DVec3, corners: [DVec3; 3]) -> f64 {
    let [a, b, c] = corners.map(|corner| (corner - from).normalize());
    let angle = |at: DVec3, p: DVec3, q: DVec3| at.cross(p).angle_between(at.cross(q));
    angle(a, b, c) + angle(b, c, a) + angle(c, a, b) - PI
}

fn area(shape: &EmitterShape) -> f64 {
    match *shape {
        EmitterShape::Rectangle { edges: [a, b], .. } => a.cross(b).length(),
        EmitterShape::Triangle([a, b, c]) => 0.5 * (b - a).cross(c - a).length(),
        EmitterShape::Sphere(sphere) => {
            let [low, high] = sphere.zone.map(|z| z.clamp(-sphere.radius, sphere.radius));
            TAU * sphere.radius * (high - low)
        }
    }
}

/// Returns the probability with which a shadow ray from a point picks each emitter.
pub(crate) fn probabilities(emitters: &[Emitter], lights: LightSampling, from: DVec3) -> Vec<f64> {
    if lights != LightSampling::Importance {
        let fluxes: Vec<f64> = emitters
            .iter()
            .map(|emitter| area(&emitter.shape) * emitter.radiance.element_sum())
            .collect();
        return pick_probabilities(&fluxes);
    }
    let irradiance = |emitter: &Emitter| {
        let flat = |middle: DVec3, across: DVec3, area: f64| {
            let (d, a) = (middle.distance(from), (area * FRAC_1_PI).sqrt());
            let height = (from - middle).dot(across.normalize());
            // A point on the light is not in front of it.
            if height > 1e-9 {
                area * (height + a).powi(2) / (d * d + a * a).powi(2)
            } else {
                0.0
            }
        };
        let per_radiance = match emitter.shape {
            EmitterShape::Rectangle {
                corner,
                edges: [a, b],
            } => flat(corner + 0.5 * a + 0.5 * b, a.cross(b), a.cross(b).length()),
            EmitterShape::Triangle([a, b, c]) => {
                let across = (b - a).cross(c - a);
                flat((a + b + c) / 3.0, across, 0.5 * across.length())
            }
            EmitterShape::Sphere(sphere) => {
                emitter.area / (4.0 * sphere.centre.distance_squared(from))
            }
        };
        per_radiance * emitter.radiance.element_sum()
    };
    let each: Vec<f64> = emitters.iter().map(irradiance).collect();
    let sum: f64 = each.iter().sum();
    let contributing = each.iter().filter(|&&incident| incident > 0.0).count() as f64;
    let probability = |incident| {
        if incident > 0.0 {
            (1.0 - UNIFORM_FRACTION) * incident / sum + UNIFORM_FRACTION / contributing
        } else {
            0.0
        }
    };
    each.into_iter().map(probability).collect()
}

/// Density, with respect to solid angle, of a shadow ray towards a point of an emitter that is
/// picked with this probability.
pub(crate) fn density(
    emitter: &Emitter,
    lights: LightSampling,
    from: DVec3,
    to: (DVec3, DVec3),
    probability: f64,
) -> f64 {
    let away = to.0 - from;
    // NaN if the shape cannot be sampled by solid angle.
    let angle = match emitter.shape {
        EmitterShape::Rectangle {
            corner,
            edges: [a, b],
        } => (a.dot(b).abs() < 1e-9).then(|| {
            girard(from, [corner, corner + a, corner + b])
                + girard(from, [corner + a + b, corner + a, corner + b])
        }),
        EmitterShape::Triangle(corners) => Some(girard(from, corners)),
        EmitterShape::Sphere(sphere) => {
            let sine = sphere.radius / sphere.centre.distance(from);
            let whole = area(&emitter.shape)
                == area(&EmitterShape::Sphere(Sphere::new(
                    sphere.centre,
                    sphere.radius,
                )));
            whole.then(|| TAU * (1.0 - (1.0 - sine * sine).sqrt()))
        }
    };
    let by_area = || away.length().powi(3) / (area(&emitter.shape) * -away.dot(to.1));
    probability
        * angle
            .filter(|_| by_angle(lights, emitter))
            .map_or_else(by_area, f64::recip)
}

/// Returns whether an emitter is sampled by solid angle.
fn by_angle(lights: LightSampling, emitter: &Emitter) -> bool {
    let is_sphere = matches!(emitter.shape, EmitterShape::Sphere(_));
    match lights {
        LightSampling::Area => false,
        LightSampling::SolidAngle => true,
        LightSampling::SphereAngle | LightSampling::Importance => is_sphere,
    }
}

/// MIS weights of both samples of a path from the floor to a light, and the two densities.
struct Found {
    hit: f64,
    shadow: f64,
    bsdf: f64,
    light: f64,
}

/// Samples a path to a random point of a random light and takes both weights from estimates; `None`
/// if the point is not visible from the floor.
fn weights_of_path(
    scene: &Scene,
    tracers: &Tracers,
    heuristic: Heuristic,
    lights: LightSampling,
    rng: &mut Stream,
) -> Option<Found> {
    let x = DVec3::new(2.0 * uniform(rng) - 1.0, 2.0 * uniform(rng) - 1.0, 0.0);
    let down = (any_direction(rng) - 1.5 * DVec3::Z).normalize();
    let ray = Ray::new(x - 0.1 * down, down);
    let first = scene.intersect(&ray)?;
    let (pick, random) = (uniform(rng), uniform2(rng));
    let emitters = scene.emitters();
    let probabilities = probabilities(emitters, lights, first.point);
    let mut left = pick;
    let picked = probabilities.iter().position(|probability| {
        left -= probability;
        left < 0.0
    })?;
    let emitter = &emitters[picked];
    let seen = emitter
        .sample_solid_angle(first.point, random)
        .filter(|_| by_angle(lights, emitter));
    let point = seen.map_or_else(|| emitter.sample(random), |(point, _)| point);
    let free = scene.visible(
        SurfacePoint::new(first.point, first.normal),
        SurfacePoint::new(point.point, point.normal),
        false,
    );
    let wi = (point.point - first.point).normalize();
    if !free || wi.z < 1e-3 || wi.dot(point.normal) > -1e-3 {
        return None;
    }
    let local = Frame::new(first.normal).local(wi);
    let onward = cosine_hemisphere_inverse(local);
    // Numbers follow in this order: the light's, the direction's, the roulette's. `ENDS` ends the
    // path, 0 does not.
    let direction = |roulette: f64| [onward[0], onward[1], roulette];
    let shadow = [pick, random[0], random[1]];
    const ENDS: f64 = 0.999;
    let estimate = |tracer: &Tracer, strategy, numbers: &[f64]| {
        let path = Path::new(strategy).with_parts(Parts::replaced(&tracer.parts));
        Path {
            lights: (tracer.lights)(lights),
            heuristic: (tracer.heuristic)(heuristic),
            ..path
        }
        .radiance(scene, &ray, Some(first), &mut Scripted(numbers.iter()))
        .x - scene.emitted(&first, ray.direction).x
    };
    let both = |roulette| [shadow, direction(roulette)].concat();
    let shadows = |strategy| estimate(&tracers.shadows, strategy, &both(ENDS));
    let hits = |strategy| {
        estimate(&tracers.hits, strategy, &both(0.0))
            - estimate(&tracers.hits, strategy, &both(ENDS))
    };
    Some(Found {
        hit: hits(Strategy::Mis) / estimate(&tracers.hits, Strategy::Bsdf, &direction(0.0)),
        shadow: shadows(Strategy::Mis) / shadows(Strategy::Light),
        bsdf: local.z * FRAC_1_PI,
        light: density(
            emitter,
            lights,
            first.point,
            (point.point, point.normal),
            probabilities[picked],
        ),
    })
}

const LIGHT_SAMPLINGS: [LightSampling; 4] = [
    LightSampling::Area,
    LightSampling::SolidAngle,
    LightSampling::SphereAngle,
    LightSampling::Importance,
];
const PATHS: u64 = 4000;
/// Tolerance of weights. A path's ray starts 2⁻⁴⁰ of the scene beside its vertex, 5·10⁻¹² here.
/// Where it grazes a sphere, that moves the cosine there by as much over radius and cosine, and a
/// weight of at most half the cosine by 5·10⁻⁹.
const TOLERANCE: f64 = 1e-8;

fn weights(context: &Context, scene: &Scene, tracers: &Tracers) -> Vec<Outcome> {
    let mut rng = context.rng("paths");
    let [mut sum, mut hits, mut shadows]: [LargestError; 3] = Default::default();
    for heuristic in [Heuristic::Balance, Heuristic::Power] {
        for lights in LIGHT_SAMPLINGS {
            let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
            for _ in 0..PATHS {
                let Some(found) = weights_of_path(scene, tracers, heuristic, lights, &mut rng)
                else {
                    continue;
                };
                let ratio = found.light / found.bsdf;
                (least, most) = (least.min(ratio), most.max(ratio));
                let power = if heuristic == Heuristic::Power { 2 } else { 1 };
                let known = 1.0 / (1.0 + ratio.powi(power));
                let place = || format!("{heuristic:?}, {lights:?}, light over BSDF {ratio:.4}");
                sum.update((found.hit + found.shadow - 1.0).abs(), place);
                hits.update((found.hit - known).abs(), place);
                shadows.update((found.shadow - (1.0 - known)).abs(), place);
            }
            // Weights near a half would prove nothing.
            if least > 1.0 / 3.0 || most < 3.0 {
                sum.update(1.0, || {
                    format!("{heuristic:?}, {lights:?}: ratios only from {least:.3} to {most:.3}")
                });
            }
        }
    }
    let n = 2 * LIGHT_SAMPLINGS.len() as u64 * PATHS;
    let exact = |name, largest: LargestError| {
        Outcome::identity(name, n, largest.error, TOLERANCE, largest.place)
    };
    vec![
        exact("weight of a hit", hits),
        exact("weight of a shadow ray", shadows),
        exact("sum of both", sum),
    ]
}

/// Trial and faults of the path tracer's MIS weights.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    let scene = lights();
    let on = move |context: &Context, tracers: Tracers| weights(context, &scene, &tracers);
    let hits = |tracer| Tracers {
        hits: tracer,
        ..TRACERS
    };
    let shadows = |tracer| Tracers {
        shadows: tracer,
        ..TRACERS
    };
    let both = |tracer| Tracers {
        hits: tracer,
        shadows: tracer,
    };
    let with = |parts| Tracer { parts, ..TRACER };
    let other = |lights| match lights {
        LightSampling::Area => LightSampling::SolidAngle,
        _ => LightSampling::Area,
    };
    let balance = Tracer {
        heuristic: |_| Heuristic::Balance,
        ..TRACER
    };
    const BY_HIT: &str = "irradiance/path-weights: weight of a hit | sum of both";
    const BY_SHADOW: &str = "irradiance/path-weights: weight of a shadow ray | sum of both";
    vec![Box::new(Family {
        trials: vec![trial(
            "irradiance/path-weights",
            "on every path a hit and a shadow ray have the heuristic's weights, which sum to one",
            "lamps look wrong as two pdfs disagree, as in gkjohnson/three-gpu-pathtracer#847",
            &MIS,
            "integrator::Path",
            "exact",
            on,
        )],
        faults: vec![
            fault!("hits-by-balance", MIS_POWER,
                "hits have the weight of balance where shadow rays have that of power", = hits(balance), BY_HIT),
            fault!("shadow-rays-by-balance", MIS_POWER,
                "shadow rays have the weight of balance where hits have that of power",
                = shadows(balance), BY_SHADOW),
            fault!("density-of-the-other-light-sampling", SOLID_ANGLE,
                "hits are weighted by area where shadow rays pick by solid angle, and the reverse",
                = hits(Tracer { lights: other, ..TRACER }), BY_HIT),
            fault!("number-of-lights-forgotten", MIS,
                "the density of a shadow ray ignores at a hit that one of six lights was picked",
                = hits(with(PartTable { pdf_of_pick: |pdf, _| pdf, ..CORRECT })), BY_HIT),
            fault!("share-as-seen-from-elsewhere", LIGHT_PICK,
                "a light's probability at a hit is that from the middle of the scene, not from the path's last vertex",
                = hits(with(PartTable { emitter_importance: |light, _| light.importance(DVec3::ZERO), ..CORRECT })),
                BY_HIT),
            fault!("own-light-in-front", LIGHT_PICK,
                "on an illuminated light, rounding and the start of a ray decide whether it is in front of itself",
                = both(with(PartTable {
                    emitter_importance: |light, from| Emitter::new(light.shape, light.radiance).importance(from),
                    ..CORRECT
                })),
                BY_HIT),
            fault!("hits-weighted-as-shadow-rays", MIS, "the two densities change places at a hit",
                = hits(with(PartTable {
                    mis_weight: |p, q| q / (p + q),
                    mis_power_weight: |p, q| q * q / (p * p + q * q),
                    ..CORRECT
                })),
                BY_HIT),
            fault!("density-of-the-other-direction", MIS,
                "a shadow ray is weighted by the uniform density of directions, not the cosine's",
                = shadows(with(PartTable { cosine_hemisphere_pdf: |_| 0.5 * FRAC_1_PI, ..CORRECT })), BY_SHADOW),
        ],
        ..Family::whole("path weights", TRACERS)
    })]
}
