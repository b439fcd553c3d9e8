//! Hemisphere samplers (17)-(19) and the cosine-weighted one: cells, moments, laws of the angles,
//! single-surface furnaces.

use std::f64::consts::{FRAC_1_PI, PI, TAU};

use glam::DVec3;

use crate::equation::{
    COSINE_HEMISPHERE, ESTIMATOR, Equation, HEMISPHERE_PDF, HEMISPHERE_PHI, HEMISPHERE_THETA,
};
use crate::frame::to_spherical;
use crate::harness::chi_square::{CELL_DELTA, sampler_against_partition};
use crate::harness::domain::{Domain, Partition};
use crate::harness::ks::kolmogorov_smirnov;
use crate::harness::mean::{Values, mean};
use crate::harness::outcome::{Claim, Outcome};
use crate::harness::trial::{Context, Control, Trial};
use crate::rng::uniform2;
use crate::sampling::{
    cosine_hemisphere, cosine_hemisphere_pdf, hemisphere_printed, uniform_hemisphere,
    uniform_hemisphere_pdf,
};

/// A map from two random numbers to a direction.
pub type Sampler = fn([f64; 2]) -> DVec3;
/// A pdf as a function of cos θ, 1/sr.
pub type Pdf = fn(f64) -> f64;

/// Samples per statistic: enough for δ of each (see the standard errors in the functions' comments).
const CELL_SAMPLES: u64 = 8_000_000;
const MEAN_SAMPLES: u64 = 16_000_000;
const KS_SAMPLES: u64 = 1_000_000;

/// δ of direction moments, absolute.
const MOMENT_DELTA: f64 = 0.002;
/// δ of furnaces, relative.
const FURNACE_DELTA: f64 = 0.003;
/// δ of Kolmogorov's distance.
const KS_DELTA: f64 = 0.007;

/// What is right of a sampler.
#[derive(Clone, Copy)]
struct Law {
    name: &'static str,
    subject: &'static str,
    sampler: Sampler,
    pdf: Pdf,
    /// Cells of equal probability under the law.
    domain: Domain,
    /// E[cos θ] and E[cos² θ].
    moments: [f64; 2],
    /// P(cos θ ≤ c).
    cos_cdf: fn(f64) -> f64,
    angles: &'static Equation,
}

const UNIFORM: Law = Law {
    name: "uniform",
    subject: "sampling::uniform_hemisphere",
    sampler: uniform_hemisphere,
    pdf: uniform_hemisphere_pdf,
    domain: Domain::Hemisphere,
    moments: [1.0 / 2.0, 1.0 / 3.0],
    cos_cdf: |c| c,
    angles: &HEMISPHERE_THETA,
};

const COSINE: Law = Law {
    name: "cosine",
    subject: "sampling::cosine_hemisphere",
    sampler: cosine_hemisphere,
    pdf: cosine_hemisphere_pdf,
    domain: Domain::CosineHemisphere,
    moments: [2.0 / 3.0, 1.0 / 2.0],
    cos_cdf: |c| c * c,
    angles: &COSINE_HEMISPHERE,
};

/// Chi-square of a sampler over 3 × 4 cells of equal probability.
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

/// `E[x]` = `E[y]` = 0, `E[z]` and `E[z²]`. Standard deviations are at most 0.58: 1.4e-4 standard error.
pub fn moments(context: &Context, expected: [f64; 2], sampler: Sampler) -> Vec<Outcome> {
    let mut rng = context.rng("moments");
    let references = [0.0, 0.0, expected[0], expected[1]];
    let mut values = references.map(Values::new);
    for _ in 0..context.n(MEAN_SAMPLES) {
        let w = sampler(uniform2(&mut rng));
        for (values, value) in values.iter_mut().zip([w.x, w.y, w.z, w.z * w.z]) {
            values.push(value);
        }
    }
    let claim = Claim::Exact {
        delta: MOMENT_DELTA,
    };
    ["mean of x", "mean of y", "mean of z", "mean of z²"]
        .iter()
        .zip(values.iter().zip(references))
        .map(|(name, (values, reference))| mean(name, values, reference, claim))
        .collect()
}

/// The laws of cos θ and φ, each alone.
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

/// A furnace's incoming radiance and what a white Lambert surface then reflects.
type Furnace = (&'static str, fn(DVec3) -> f64, f64);

/// The constant one, and three that are not blind to weights and azimuths.
const FURNACES: [Furnace; 4] = [
    ("furnace, radiance 1", |_| 1.0, 1.0),
    ("furnace, radiance cos θ", |w| w.z, 2.0 / 3.0),
    ("furnace, radiance 1 + x", |w| 1.0 + w.x, 1.0),
    ("furnace, radiance 1 + y", |w| 1.0 + w.y, 1.0),
];

/// A white Lambert surface in four furnaces by (16): mean of L cos θ/(π p).
pub fn furnaces(context: &Context, sampler: Sampler, pdf: Pdf) -> Vec<Outcome> {
    let mut rng = context.rng("furnaces");
    let mut values = FURNACES.map(|(_, _, reference)| Values::new(reference));
    for _ in 0..context.n(MEAN_SAMPLES) {
        let w = sampler(uniform2(&mut rng));
        let weight = FRAC_1_PI * w.z / pdf(w.z);
        for (values, (_, radiance, _)) in values.iter_mut().zip(&FURNACES) {
            values.push(radiance(w) * weight);
        }
    }
    FURNACES
        .iter()
        .zip(&values)
        .map(|((name, _, reference), values)| {
            let delta = FURNACE_DELTA * reference;
            mean(name, values, *reference, Claim::Exact { delta })
        })
        .collect()
}

/// ∫ p dω = 1 by quadrature.
pub fn normalised(pdf: Pdf) -> Vec<Outcome> {
    let tolerance = 1e-6;
    let integral = Domain::Hemisphere.integrate_all(0.1 * tolerance, &|w| pdf(w.z));
    vec![Outcome::exact(
        "integral of the pdf",
        1,
        (integral.value - 1.0).abs(),
        tolerance,
        format!("the pdf integrates to {:.9}", integral.value),
    )]
}

// The faults.

/// (18) without the inverse cosine, θ = rπ/2.
fn linear_theta([r1, r2]: [f64; 2]) -> DVec3 {
    crate::frame::from_spherical(r1 * PI / 2.0, TAU * r2)
}

/// (19) over half the circle.
fn half_circle([r1, r2]: [f64; 2]) -> DVec3 {
    crate::frame::from_spherical(crate::sampling::uniform_theta(r1), PI * r2)
}

/// (18) and (19) with one random number.
fn shared_number([r, _]: [f64; 2]) -> DVec3 {
    hemisphere_printed(r)
}

/// The cosine map with one random number.
fn shared_number_cosine([r, _]: [f64; 2]) -> DVec3 {
    cosine_hemisphere([r, r])
}

/// The cosine map without its root: sin θ = r.
fn no_root([r1, r2]: [f64; 2]) -> DVec3 {
    let (sin, cos) = (TAU * r2).sin_cos();
    DVec3::new(r1 * cos, r1 * sin, (1.0 - r1 * r1).sqrt())
}

/// Every trial of the two samplers.
pub fn trials() -> Vec<Trial> {
    [UNIFORM, COSINE].into_iter().flat_map(law_trials).collect()
}

/// Samplers that are wrong under a law, with what is wrong.
fn faults(law: &Law) -> [(&'static str, &'static str, Sampler); 2] {
    if law.name == "uniform" {
        [
            (
                "shared-number",
                "one random number for θ and φ, as printed",
                shared_number,
            ),
            ("linear-theta", "θ = rπ/2", linear_theta),
        ]
    } else {
        [
            (
                "shared-number",
                "one random number for θ and φ",
                shared_number_cosine,
            ),
            ("no-root", "sin θ = r for sin θ = √r", no_root),
        ]
    }
}

fn law_trials(law: Law) -> Vec<Trial> {
    let name = |what: &str| format!("hemisphere/{}/{what}", law.name);
    let with_faults = |run: fn(&Context, Law, Sampler) -> Vec<Outcome>| -> Vec<Control> {
        faults(&law)
            .into_iter()
            .map(|(name, wrong, sampler)| Control::new(name, wrong, move |c| run(c, law, sampler)))
            .collect()
    };
    let trial = |what: &str, property: String, statistic, samples, delta, assertions| Trial {
        name: name(what),
        property,
        equation: law.angles,
        subject: law.subject,
        statistic,
        samples,
        delta,
        assertions,
        run: Box::new(|_| Vec::new()),
        controls: Vec::new(),
    };
    vec![
        Trial {
            run: Box::new(move |c| cells(c, law.domain, law.sampler)),
            controls: with_faults(|c, law, sampler| cells(c, law.domain, sampler)),
            ..trial(
                "cells",
                format!("directions have the {} density", law.name),
                "chi-square",
                CELL_SAMPLES,
                CELL_DELTA,
                1,
            )
        },
        Trial {
            run: Box::new(move |c| moments(c, law.moments, law.sampler)),
            controls: with_faults(|c, law, sampler| moments(c, law.moments, sampler)),
            ..trial(
                "moments",
                format!(
                    "E[x] = E[y] = 0, E[z] = {:.4}, E[z²] = {:.4}",
                    law.moments[0], law.moments[1]
                ),
                "t",
                MEAN_SAMPLES,
                MOMENT_DELTA,
                4,
            )
        },
        Trial {
            equation: &HEMISPHERE_PHI,
            run: Box::new(move |c| angles(c, law.cos_cdf, law.sampler)),
            controls: vec![Control::new(
                "half-circle",
                "φ over half the circle",
                move |c| angles(c, law.cos_cdf, half_circle),
            )],
            ..trial(
                "angles",
                String::from("cos θ and φ follow their laws"),
                "Kolmogorov-Smirnov",
                KS_SAMPLES,
                KS_DELTA,
                2,
            )
        },
        Trial {
            equation: &ESTIMATOR,
            run: Box::new(move |c| furnaces(c, law.sampler, law.pdf)),
            controls: furnace_controls(law),
            ..trial(
                "furnaces",
                String::from(
                    "a white Lambert surface reflects 1, 2/3, 1, 1 in furnaces 1, cos θ, 1 + x, 1 + y",
                ),
                "t",
                MEAN_SAMPLES,
                FURNACE_DELTA,
                4,
            )
        },
        Trial {
            equation: &HEMISPHERE_PDF,
            run: Box::new(move |_| normalised(law.pdf)),
            controls: vec![Control::new("twice", "the pdf is twice too large", |_| {
                normalised(|cos| 2.0 * uniform_hemisphere_pdf(cos))
            })],
            ..trial(
                "pdf",
                String::from("the pdf integrates to one"),
                "exact",
                1,
                1e-6,
                0,
            )
        },
    ]
}

fn furnace_controls(law: Law) -> Vec<Control> {
    if law.name == "uniform" {
        vec![
            Control::new(
                "cosine-weight",
                "uniform directions with the weight of the cosine pdf: radiance 1 does not see it",
                |c| furnaces(c, uniform_hemisphere, cosine_hemisphere_pdf),
            ),
            Control::new("shared-number", "one random number for θ and φ", |c| {
                furnaces(c, shared_number, uniform_hemisphere_pdf)
            }),
            Control::new("half-circle", "φ over half the circle", |c| {
                furnaces(c, half_circle, uniform_hemisphere_pdf)
            }),
        ]
    } else {
        vec![
            Control::new(
                "uniform-weight",
                "cosine directions with the weight 2 cos θ",
                |c| furnaces(c, cosine_hemisphere, uniform_hemisphere_pdf),
            ),
            Control::new(
                "uniform-sampler",
                "uniform directions with the cosine pdf's weight",
                |c| furnaces(c, uniform_hemisphere, cosine_hemisphere_pdf),
            ),
        ]
    }
}
