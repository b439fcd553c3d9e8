//! Hemisphere samplers (17)-(19) and the cosine-weighted one: cells, moments, distributions of the
//! angles, single-surface furnaces.

pub mod faults;

use whitefurnace::harness::chi_square::sampler_against_partition;
use whitefurnace::harness::ks::kolmogorov_smirnov;
use whitefurnace::math::frame::to_spherical;
use whitefurnace::sampling::warp::{
    cosine_hemisphere, cosine_hemisphere_pdf, uniform_hemisphere, uniform_hemisphere_pdf,
};

use crate::prelude::*;

/// A map from two random numbers to a direction.
pub type Sampler = fn([f64; 2]) -> DVec3;
/// A pdf as a function of cos θ, 1/sr.
pub type Pdf = fn(f64) -> f64;
/// A sampling method.
#[derive(Clone, Copy)]
pub struct Method {
    /// Samples a direction.
    pub sampler: Sampler,
    /// The pdf by which samples are weighted.
    pub pdf: Pdf,
}

impl Method {
    /// Uniform directions and their pdf.
    pub const UNIFORM: Self = Self {
        sampler: uniform_hemisphere,
        pdf: uniform_hemisphere_pdf,
    };
    /// Cosine-weighted directions and their pdf.
    pub const COSINE: Self = Self {
        sampler: cosine_hemisphere,
        pdf: cosine_hemisphere_pdf,
    };
}

/// Samples per statistic, enough for each δ (see the standard errors in the functions' comments).
const CELL_SAMPLES: u64 = 5_300_000;
const MEAN_SAMPLES: u64 = 13_600_000;
const KS_SAMPLES: u64 = 1_000_000;

/// δ of direction moments, absolute.
const MOMENT_DELTA: f64 = 0.002;
/// δ of furnaces, relative.
const FURNACE_DELTA: f64 = 0.003;
/// δ of Kolmogorov's distance.
const KS_DELTA: f64 = 0.007;

/// A sampler and the distribution that it should have.
#[derive(Clone, Copy)]
struct Law {
    name: &'static str,
    subject: &'static str,
    method: Method,
    /// Domain whose cells of equal probability follow the distribution.
    domain: Domain,
    /// E[cos θ] and E[cos² θ].
    moments: [f64; 2],
    /// P(cos θ ≤ c).
    cos_cdf: fn(f64) -> f64,
    angles: &'static Equation,
}

const UNIFORM: Law = Law {
    name: "uniform",
    subject: "sampling::warp::uniform_hemisphere",
    method: Method::UNIFORM,
    domain: Domain::Hemisphere,
    moments: [1.0 / 2.0, 1.0 / 3.0],
    cos_cdf: |c| c,
    angles: &HEMISPHERE_THETA,
};

const COSINE: Law = Law {
    name: "cosine",
    subject: "sampling::warp::cosine_hemisphere",
    method: Method::COSINE,
    domain: Domain::CosineHemisphere,
    moments: [2.0 / 3.0, 1.0 / 2.0],
    cos_cdf: |c| c * c,
    angles: &COSINE_HEMISPHERE,
};

/// Tests a sampler by chi-square over 3 × 4 cells of equal probability.
pub fn cells(context: &Context, domain: Domain, sampler: Sampler) -> Vec<Outcome> {
    let mut rng = context.rng("cells");
    let partition = Partition::equal(domain, 3, 4);
    vec![sampler_against_partition(
        "cells of equal probability",
        &partition,
        context.n(CELL_SAMPLES),
        || Some(sampler(uniform2(&mut rng))),
    )]
}

/// Tests the means of x and y, which are 0, and of z and z². Standard deviations are at most 0.58:
/// 1.4e-4 standard error.
pub fn moments(context: &Context, expected: [f64; 2], sampler: Sampler) -> Vec<Outcome> {
    let mut rng = context.rng("moments");
    let about = [
        ("mean of x", 0.0),
        ("mean of y", 0.0),
        ("mean of z", expected[0]),
        ("mean of z²", expected[1]),
    ];
    means(
        about.map(|(name, reference)| (name, reference, MOMENT_DELTA)),
        context.n(MEAN_SAMPLES),
        || {
            let w = sampler(uniform2(&mut rng));
            [w.x, w.y, w.z, w.z * w.z]
        },
    )
}

/// Tests the distributions of cos θ and φ, each alone, by Kolmogorov-Smirnov.
pub fn angles(context: &Context, cos_cdf: fn(f64) -> f64, sampler: Sampler) -> Vec<Outcome> {
    let mut rng = context.rng("angles");
    let directions: Vec<DVec3> = (0..context.n(KS_SAMPLES))
        .map(|_| sampler(uniform2(&mut rng)))
        .collect();
    let mut cosines: Vec<f64> = directions.iter().map(|w| w.z).collect();
    let mut azimuths: Vec<f64> = directions.iter().map(|&w| to_spherical(w).1).collect();
    vec![
        kolmogorov_smirnov("law of cos θ", &mut cosines, cos_cdf, KS_DELTA),
        kolmogorov_smirnov("law of φ", &mut azimuths, |phi| phi / TAU, KS_DELTA),
    ]
}

/// Name of a furnace, its incoming radiance, and the radiance that a white Lambert surface
/// reflects.
type Furnace = (&'static str, fn(DVec3) -> f64, f64);

/// A constant furnace, and three that reveal wrong weights and azimuths.
const FURNACES: [Furnace; 4] = [
    ("furnace, radiance 1", |_| 1.0, 1.0),
    ("furnace, radiance cos θ", |w| w.z, 2.0 / 3.0),
    ("furnace, radiance 1 + x", |w| 1.0 + w.x, 1.0),
    ("furnace, radiance 1 + y", |w| 1.0 + w.y, 1.0),
];

/// Tests the reflected radiance of a white Lambert surface in four furnaces by (16), the mean of L
/// cos θ/(π p). If the density is proportional to cos θ, every value of the constant furnace is 1.
fn furnaces(context: &Context, law: Domain, method: Method) -> Vec<Outcome> {
    let mut rng = context.rng("furnaces");
    let mut about =
        FURNACES.map(|(name, _, reference)| (name, reference, FURNACE_DELTA * reference));
    let mut samples = MEAN_SAMPLES;
    if law == Domain::CosineHemisphere {
        about[0].2 = 0.0;
        // The weights are all the same.
        samples /= 3;
    }
    means(about, context.n(samples), || {
        let w = (method.sampler)(uniform2(&mut rng));
        let weight = FRAC_1_PI * w.z / (method.pdf)(w.z);
        FURNACES.map(|(_, radiance, _)| radiance(w) * weight)
    })
}

/// Tests ∫ p dω = 1 by quadrature.
pub fn normalised(pdf: Pdf) -> Vec<Outcome> {
    let tolerance = 1e-6;
    let integral = Domain::Hemisphere.integrate_all(0.1 * tolerance, &|w| pdf(w.z));
    let found = format!("the pdf integrates to {:.9}", integral.value);
    vec![Outcome::identity(
        "integral of the pdf",
        1,
        (integral.value - 1.0).abs(),
        tolerance,
        found,
    )]
}

fn trials(law: Law) -> Vec<FamilyTrial<Method>> {
    let name = |what: &str| format!("hemisphere/{}/{what}", law.name);
    let [z, z2] = law.moments;
    let by = format!("with {} directions", law.name);
    vec![
        trial(
            name("cells"),
            format!("directions have the {} density", law.name),
            format!("lamps in one part of the sky are too bright, in others too dim {by}"),
            law.angles,
            law.subject,
            "chi-square",
            move |c, method: Method| cells(c, law.domain, method.sampler),
        ),
        trial(
            name("moments"),
            format!("E[x] = E[y] = 0, E[z] = {z:.4}, E[z²] = {z2:.4}"),
            format!("light from one side, or low over the horizon, counts too much {by}"),
            law.angles,
            law.subject,
            "t",
            move |c, method: Method| moments(c, law.moments, method.sampler),
        ),
        trial(
            name("angles"),
            "cos θ and φ follow their laws",
            format!("shading leans to one side, or lamps overhead are too bright or dim {by}"),
            &HEMISPHERE_PHI,
            law.subject,
            "Kolmogorov-Smirnov",
            move |c, method: Method| angles(c, law.cos_cdf, method.sampler),
        ),
        trial(
            name("furnaces"),
            "a white Lambert surface reflects 1, 2/3, 1, 1 in furnaces 1, cos θ, 1 + x, 1 + y",
            format!("walls under an uneven sky are too bright or too dark {by}"),
            &ESTIMATOR,
            law.subject,
            "t",
            move |c, method: Method| furnaces(c, law.domain, method),
        ),
        trial(
            name("pdf"),
            "the pdf integrates to one",
            format!("everything lit {by} is too bright or too dark by the same factor"),
            &HEMISPHERE_PDF,
            law.subject,
            "exact",
            |_, method: Method| normalised(method.pdf),
        ),
    ]
}

/// Trials and faults of the two samplers, each under its own distribution; each is a fault under
/// the other's.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    let family = |law: Law, faults, equivalents| -> Box<dyn AnyFamily> {
        Box::new(Family {
            trials: trials(law),
            faults,
            equivalents,
            ..Family::new(law.name, law.method)
        })
    };
    vec![
        family(
            UNIFORM,
            faults::uniform_faults(),
            faults::uniform_equivalents(),
        ),
        family(
            COSINE,
            faults::cosine_faults(),
            faults::cosine_equivalents(),
        ),
    ]
}
