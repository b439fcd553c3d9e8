//! Rough glass: its check-up from both sides, its reciprocity, the limit of smooth glass, and whole
//! estimators that render it under a sky and before lights.

mod faults;

use std::array;
use std::sync::LazyLock;

use whitefurnace::harness::bsdf_checkup::{BsdfSubject, Loss, SampledDirection};
use whitefurnace::harness::domain::MASS_TOLERANCE;
use whitefurnace::harness::pointwise::{LargestError, POINTWISE_TOLERANCE, relative, uniform3};
use whitefurnace::integrator::Heuristic;
use whitefurnace::light::emitter::LightSampling;
use whitefurnace::material::fresnel::{reflect, reflectance, refract};
use whitefurnace::material::rough_glass::{RoughGlass, refracting};
use whitefurnace::math::frame::from_spherical;
use whitefurnace::sampling::warp::uniform_hemisphere;

use crate::bsdf::check_up_sized;
use crate::environment_map::sky;
use crate::ggx::lambda;
use crate::glass::INDEX;
use crate::prelude::*;
use crate::scenes::{LIGHT, floor, hollow, light, ray_to_origin_at, scene};

/// The functions of the model, so that each can be replaced.
#[derive(Clone, Copy, Debug)]
pub struct RoughGlassParts {
    /// The surface as seen from outside (`true`) or inside.
    pub oriented: fn(RoughGlass, bool) -> RoughGlass,
    /// Evaluates f.
    pub eval: fn(&RoughGlass, DVec3, DVec3) -> f64,
    /// Samples a direction.
    pub sample: fn(&RoughGlass, DVec3, [f64; 3]) -> Option<DVec3>,
    /// The pdf of a sampled direction.
    pub pdf: fn(&RoughGlass, DVec3, DVec3) -> f64,
}

/// The program's functions.
const CORRECT: RoughGlassParts = RoughGlassParts {
    oriented: RoughGlass::oriented,
    eval: RoughGlass::eval,
    sample: RoughGlass::sample,
    pdf: RoughGlass::pdf,
};

const GLASS: RoughGlass = RoughGlass {
    index: INDEX,
    alpha: 0.4,
};
/// Inclinations of wo from both sides, degrees from the outer normal. Not along it, where cells are
/// cut by azimuth alone, which does not tell above from below, nor near the critical angle, where
/// quadrature is slow.
const BOTH_SIDES: [f64; 5] = [10.0, 40.0, 75.0, 105.0, 165.0];
/// Samples at each of [`BOTH_SIDES`].
const SAMPLES: [u64; BOTH_SIDES.len()] = [3_850_000, 2_800_000, 2_400_000, 4_500_000, 3_150_000];

/// Mirrors a direction in the plane of the surface.
fn flipped(w: DVec3) -> DVec3 {
    w.with_z(-w.z)
}

/// Converts directions relative to the outer normal to those relative to the side of wo. Returns
/// the surface as seen from there, wo and the other directions.
fn seen<const N: usize>(
    parts: RoughGlassParts,
    wo: DVec3,
    others: [DVec3; N],
) -> (RoughGlass, DVec3, [DVec3; N]) {
    let outside = wo.z > 0.0;
    let turned = |w| if outside { w } else { flipped(w) };
    (
        (parts.oriented)(GLASS, outside),
        turned(wo),
        others.map(turned),
    )
}

/// B(1 + a, 1 + b) as the integral of u^a (1 − u)^b over u, by the trapezoidal rule in s = ln(u/(1
/// − u)), whose error of about exp(−2π²/step) is below 1e-8.
pub(super) fn beta(a: f64, b: f64) -> f64 {
    /// −ln u and −ln(1 − u) at s = −20, −19, ..., 20.
    static LOGARITHMS: LazyLock<[[f64; 2]; 41]> = LazyLock::new(|| {
        array::from_fn(|k| [20.0 - k as f64, k as f64 - 20.0].map(|s| s.exp().ln_1p()))
    });
    LOGARITHMS
        .iter()
        .map(|[u, v]| (-(a + 1.0) * u - (b + 1.0) * v).exp())
        .sum()
}

/// Reflected and transmitted fractions of the flux, each within the tolerance. They are integrals
/// over microfacet normals, not over directions, so that no half vector and no Jacobian enters: ∫ F
/// G₂ D (o · m)/cos θ_o dm, with D in the slope of the microfacet.
pub fn shares(RoughGlass { index, alpha }: RoughGlass, wo: DVec3, tolerance: f64) -> [f64; 2] {
    let of_facets = |is_reflected: bool| {
        let of_facet = |m: DVec3| {
            let cosine = wo.dot(m);
            if cosine <= 0.0 {
                return 0.0;
            }
            let slope = m.truncate().length() / (alpha * m.z);
            let d = FRAC_1_PI / (alpha * m.z * m.z * (1.0 + slope * slope)).powi(2);
            let fresnel = reflectance(cosine, 1.0, index);
            let share = if is_reflected {
                let wi = 2.0 * cosine * m - wo;
                if wi.z > 0.0 {
                    fresnel / (1.0 + lambda(alpha, wo) + lambda(alpha, wi))
                } else {
                    0.0
                }
            } else {
                // Snell's law for the component along the microfacet.
                let along = (cosine * m - wo) / index;
                let wi = along - (1.0 - along.length_squared()).max(0.0).sqrt() * m;
                if fresnel < 1.0 && wi.z < 0.0 {
                    (1.0 - fresnel) * beta(lambda(alpha, wo), lambda(alpha, flipped(wi)))
                } else {
                    0.0
                }
            };
            share * d * cosine / wo.z
        };
        Domain::Hemisphere.integrate_all(tolerance, &of_facet).value
    };
    [true, false].map(of_facets)
}

/// Directional albedo of [`GLASS`] from each of [`BOTH_SIDES`], integrated once for all faults.
static ALBEDOS: LazyLock<[f64; BOTH_SIDES.len()]> = LazyLock::new(|| {
    BOTH_SIDES.map(|degrees| {
        let (glass, wo, []) = seen(CORRECT, from_spherical(degrees.to_radians(), 0.0), []);
        shares(glass, wo, 0.5 * MASS_TOLERANCE).iter().sum()
    })
});

fn on_both_sides(context: &Context, parts: RoughGlassParts) -> Vec<Outcome> {
    let pdf = move |wo, wi| {
        let (glass, wo, [wi]) = seen(parts, wo, [wi]);
        (parts.pdf)(&glass, wo, wi)
    };
    let eval = move |wo, wi| {
        let (glass, wo, [wi]) = seen(parts, wo, [wi]);
        (parts.eval)(&glass, wo, wi)
    };
    let sample = move |wo: DVec3, random| {
        let (glass, above, []) = seen(parts, wo, []);
        let local = (parts.sample)(&glass, above, random)?;
        let wi = if wo.z > 0.0 { local } else { flipped(local) };
        let pdf = pdf(wo, wi);
        (pdf != 0.0).then(|| SampledDirection {
            wi,
            weight: eval(wo, wi) * wi.z.abs() / pdf,
            pdf,
        })
    };
    let subject = BsdfSubject::new(eval, sample, pdf)
        .transmits(true)
        .reciprocal(false)
        .loss(Loss::Allowed)
        .albedo(|wo| {
            let is_seen = |degrees: &f64| (degrees.to_radians().cos() - wo.z).abs() < 1e-9;
            BOTH_SIDES
                .iter()
                .position(is_seen)
                .map_or(f64::NAN, |place| ALBEDOS[place])
        });
    let sizes: Vec<_> = BOTH_SIDES.into_iter().zip(SAMPLES).collect();
    check_up_sized(&subject, &sizes, context)
}

const PAIRS: u64 = 20_000;

/// Samples a direction above the horizon, not near grazing.
fn above(rng: &mut Stream) -> DVec3 {
    loop {
        let w = uniform_hemisphere(uniform2(rng));
        if w.z > 0.01 {
            return w;
        }
    }
}

/// Compares f with f of the reversed directions. For radiance divided by n², f is f/n² of the
/// medium that light comes from: f(o, i) n_o²/n_i² = f(i, o) across the surface, f(o, i) = f(i, o)
/// on one side.
fn reciprocity(context: &Context, parts: RoughGlassParts) -> Vec<Outcome> {
    let mut rng = context.rng("pairs");
    let mut largest = [LargestError::default(), LargestError::default()];
    for _ in 0..context.arguments(PAIRS) {
        let (wo, wi) = (above(&mut rng), above(&mut rng));
        let back = flipped(wi);
        let within = (parts.oriented)(GLASS, false);
        let pairs = [
            [(parts.eval)(&GLASS, wo, wi), (parts.eval)(&GLASS, wi, wo)],
            [
                (parts.eval)(&GLASS, wo, back) / (INDEX * INDEX),
                (parts.eval)(&within, wi, flipped(wo)),
            ],
        ];
        // Next to the critical angle 1 − F loses digits by conditioning, as R does in `fresnel`.
        let critical =
            refracting(INDEX, wo, back).is_some_and(|(m, _)| wo.dot(m).min(-back.dot(m)) < 1e-2);
        for (largest, [there, back]) in
            largest
                .iter_mut()
                .zip(pairs)
                .take(if critical { 1 } else { 2 })
        {
            largest.update(relative(there, back), || {
                format!("f = {there} and {back} with wo = {wo}, wi = {wi}")
            });
        }
    }
    let outcome = |(name, found): (&str, LargestError)| {
        Outcome::identity(name, PAIRS, found.error, POINTWISE_TOLERANCE, found.place)
    };
    ["reflection", "transmission"]
        .into_iter()
        .zip(largest)
        .map(outcome)
        .collect()
}

/// α of an almost smooth surface.
const SMOOTH_ALPHA: f64 = 1e-7;
/// Tolerance of its directions against those of smooth glass.
const SMOOTH_TOLERANCE: f64 = 1e-4;

/// Compares an almost smooth surface with smooth glass, from both sides: the third random number
/// selects reflection or refraction as for smooth glass, the directions are the same, and the
/// weight is 1.
fn smooth(context: &Context, parts: RoughGlassParts) -> Vec<Outcome> {
    let mut rng = context.rng("directions");
    let [mut direction, mut weight] = [(); 2].map(|()| LargestError::default());
    for _ in 0..context.arguments(PAIRS) {
        let wo = above(&mut rng);
        let [r1, r2, r3] = uniform3(&mut rng);
        let outside = uniform(&mut rng) < 0.5;
        let glass = (parts.oriented)(
            RoughGlass {
                alpha: SMOOTH_ALPHA,
                ..GLASS
            },
            outside,
        );
        let index = if outside { INDEX } else { 1.0 / INDEX };
        let share = reflectance(wo.z, 1.0, index);
        // Skipped: directions next to the critical angle, and choices that depend on rounding.
        if (r3 - share).abs() < 1e-3 || (wo.z * wo.z - 1.0 + index * index).abs() < 1e-2 {
            continue;
        }
        let expected = if r3 < share {
            None
        } else {
            refract(-wo, DVec3::Z, 1.0, index)
        };
        let expected = expected.unwrap_or(reflect(-wo, DVec3::Z));
        // 0.99 leaves out the few microfacets that are steep even at this α.
        let found = (parts.sample)(&glass, wo, [0.99 * r1, r2, r3]);
        let place = || format!("{found:?} for {expected} from {wo}, {outside}");
        direction.update(
            found.map_or(f64::INFINITY, |wi| wi.distance(expected)),
            place,
        );
        let error = |wi: DVec3| {
            relative(
                (parts.eval)(&glass, wo, wi) * wi.z.abs(),
                (parts.pdf)(&glass, wo, wi),
            )
        };
        weight.update(found.map_or(f64::INFINITY, error), place);
    }
    vec![
        Outcome::identity(
            "directions",
            PAIRS,
            direction.error,
            SMOOTH_TOLERANCE,
            direction.place,
        ),
        Outcome::identity(
            "weights",
            PAIRS,
            weight.error,
            SMOOTH_TOLERANCE,
            weight.place,
        ),
    ]
}

fn of_model() -> Vec<FamilyTrial<RoughGlassParts>> {
    vec![
        trial(
            "bsdf/rough-glass",
            "rough glass passes the check-up from both sides and has the albedo of its microfacets",
            "frosted glass is too bright, too dark or full of fireflies",
            &ROUGH_GLASS_PDF,
            "material::rough_glass::RoughGlass",
            "BSDF check-up",
            on_both_sides,
        ),
        trial(
            "bsdf/rough-glass-reciprocity",
            "f is reciprocal, across the surface up to the square of the index",
            "frosted glass is brighter or darker if traced from the lamp, as in mmp/pbrt-v4#30",
            &ROUGH_GLASS,
            "material::rough_glass::RoughGlass",
            "exact",
            reciprocity,
        ),
        trial(
            "bsdf/rough-glass-smooth",
            "for α near 0 rough glass scatters as smooth glass does",
            "the less frosted glass is, the less it looks like clear glass",
            &ROUGH_GLASS_REFRACTION,
            "material::rough_glass::RoughGlass",
            "exact",
            smooth,
        ),
    ]
}

/// Inclination of the view, radians: from outside and, upside down, from within.
const INCLINATION: f64 = 1.0;

/// Glass so rough that shadow rays to all sides have a bounded variance.
const ROUGHEST: RoughGlass = RoughGlass {
    index: INDEX,
    alpha: 1.0,
};

/// Radiance that leaves a surface of rough glass under a sky of radiance 1 on both sides: seen from
/// within, and from outside.
static UNDER_A_SKY: LazyLock<[f64; 2]> = LazyLock::new(|| {
    [false, true].map(|outside| {
        let glass = ROUGHEST.oriented(outside);
        let [reflected, transmitted] = shares(glass, from_spherical(INCLINATION, 0.0), 1e-5);
        reflected + transmitted / (glass.index * glass.index)
    })
});

/// Trials of rough glass through whole estimators.
pub fn trials() -> Vec<FamilyTrial<EstimatorSubject>> {
    let rough = Bsdf::RoughGlass(ROUGHEST);
    let [seen_from_within, seen_from_outside] = *UNDER_A_SKY;
    let uniform_sky = scene("rough glass under a sky", |s| {
        s.background(DVec3::ONE);
        floor(s, rough);
    });
    let lights = scene("rough glass within a light", |s| {
        floor(s, rough);
        hollow(s, 3.0, light(LIGHT));
    });
    let map = scene("rough glass in an environment map", |s| {
        floor(s, rough);
        sky(s, [1, 1], vec![DVec3::splat(LIGHT)]);
    });
    let by = |strategy| EstimatorKind::PathWith(strategy, LightSampling::Area, Heuristic::Balance);
    let from_outside: Rays = |_| ray_to_origin_at(INCLINATION);
    let from_within: Rays = |_| {
        let Ray {
            origin, direction, ..
        } = ray_to_origin_at(INCLINATION);
        Ray::new(flipped(origin), flipped(direction))
    };
    vec![
        radiance(
            "furnace/rough-glass",
            &ROUGH_GLASS_MASKING,
            &uniform_sky,
            EstimatorKind::Path,
            from_outside,
        )
        .states(
            "under a sky rough glass loses the light that meets a second microfacet, and no more",
            "frosted glass under an even sky glows, or is darker than its facets explain",
        )
        .by_scrambles(seen_from_outside, BOUNCES_DELTA, 32, 15_800),
        radiance(
            "glass/rough-by-both",
            &ROUGH_GLASS,
            &lights,
            by(Strategy::Mis),
            from_within,
        )
        .states(
            "from within, directions and shadow rays find the light before and behind rough glass",
            "a lamp behind frosted glass is counted twice or not at all",
        )
        .by_scrambles(LIGHT * seen_from_within, IMAGE_DELTA, 32, 9_400),
        radiance(
            "sky/rough-glass",
            &ROUGH_GLASS,
            &map,
            by(Strategy::Mis),
            from_outside,
        )
        .states(
            "directions and shadow rays find an environment map before and behind rough glass",
            "an environment map behind frosted glass is counted twice or not at all",
        )
        .by_scrambles(LIGHT * seen_from_outside, IMAGE_DELTA, 16, 9_500),
    ]
}

/// Trials and faults of the rough-glass model.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    vec![Box::new(Family {
        trials: of_model(),
        faults: faults::faults(),
        ..Family::new("rough-glass", CORRECT)
    })]
}
