//! Check-ups of BSDFs with narrow lobes: right samples hold; samples with another distribution
//! within the lobe fail.

use std::f64::consts::PI;

use whitefurnace::harness::bsdf_checkup::at_direction;
use whitefurnace::material::Model as _;
use whitefurnace::material::ggx::{Ggx, sample_visible_normal};

use super::*;

type Pdf = fn(DVec3, DVec3) -> f64;
type Sample = fn(DVec3, [f64; 2]) -> DVec3;

const ALPHA_X: f64 = 0.02;
const POWER: f64 = 1000.0;
const G: f64 = 0.99;

fn around(axis: DVec3, cosine: f64, turn: f64) -> DVec3 {
    let (x, y) = axis.any_orthonormal_pair();
    let (sin, cos) = (TAU * turn).sin_cos();
    cosine * axis + (1.0 - cosine * cosine).max(0.0).sqrt() * (cos * x + sin * y)
}

fn facets() -> Ggx {
    Ggx {
        reflectance: DVec3::ONE,
        alpha: ALPHA_X,
    }
}

/// Lobes that hold all of the light: name, pdf, sampler, whether they transmit, and degrees from
/// the normal.
const LOBES: [(&str, Pdf, Sample, bool, f64); 4] = [
    (
        "power of the cosine",
        |_, wi| (POWER + 1.0) / TAU * wi.z.max(0.0).powf(POWER),
        |_, [r, turn]| around(DVec3::Z, (1.0 - r).powf(1.0 / (POWER + 1.0)), turn),
        false,
        30.0,
    ),
    ("facets", facet_pdf, facet_sample, false, 0.0),
    ("facets aslant", facet_pdf, facet_sample, false, 60.0),
    (
        "Henyey and Greenstein",
        |wo, wi| (1.0 - G * G) / (4.0 * PI * (1.0 + G * G + 2.0 * G * wo.dot(wi)).powf(1.5)),
        |wo, [r, turn]| {
            let square = (1.0 - G * G) / (1.0 - G + 2.0 * G * r);
            around(-wo, (1.0 + G * G - square * square) / (2.0 * G), turn)
        },
        true,
        60.0,
    ),
];

fn facet_pdf(wo: DVec3, wi: DVec3) -> f64 {
    if wi.z > 0.0 {
        facets().pdf(wo, wi)
    } else {
        0.0
    }
}

fn facet_sample(wo: DVec3, random: [f64; 2]) -> DVec3 {
    let m = sample_visible_normal(ALPHA_X, wo, random);
    2.0 * wo.dot(m) * m - wo
}

/// Number of random verdicts: the histograms of right samples.
pub const ASSERTIONS: usize = LOBES.len();

/// Returns the histogram of samples whose first random number is changed.
fn histogram(
    pdf: Pdf,
    sample: Sample,
    transmits: bool,
    degrees: f64,
    change: fn(f64) -> f64,
) -> Outcome {
    let subject = BsdfSubject::new(
        move |wo, wi| {
            if wi.z == 0.0 {
                0.0
            } else {
                pdf(wo, wi) / wi.z.abs()
            }
        },
        move |wo, [r, turn, _]| {
            let wi = sample(wo, [change(r), turn]);
            (transmits || wi.z > 0.0).then(|| SampledDirection {
                wi,
                weight: 1.0,
                pdf: pdf(wo, wi),
            })
        },
        pdf,
    );
    let subject = subject.transmits(transmits).loss(Loss::Allowed);
    let size = CheckUp {
        samples: 30_000,
        ..CheckUp::default()
    };
    // Too few samples to hold, enough to fail.
    let context = at_scale_1("narrow lobes");
    let wo = from_spherical(degrees.to_radians(), 0.7);
    let outcomes = at_direction(&subject, &size, &context, wo, degrees);
    outcomes
        .into_iter()
        .find(|outcome| outcome.name.starts_with("chi-square"))
        .expect("a histogram")
}

#[test]
fn rings_of_a_lobe_are_told_from_the_lobe() {
    for (name, pdf, sample, transmits, degrees) in LOBES {
        let found = |change| histogram(pdf, sample, transmits, degrees, change);
        let right = found(|r| r);
        assert!(
            right.p >= ALPHA && matches!(right.verdict(), Verdict::Undecided { .. }),
            "{name}: {right}"
        );
        let cells = right
            .cells
            .iter()
            .map(|cell| cell.expected / right.n as f64);
        assert!(
            cells.clone().all(|share| (0.15..0.18).contains(&share)),
            "{name}: {:?}",
            cells.collect::<Vec<_>>()
        );
        // All samples at the quartiles of the radius: two rings.
        let two = found(|r| if r < 0.5 { 0.25 } else { 0.75 });
        assert_eq!(two.verdict(), Verdict::Fails, "{name}: {two}");
        // In eight steps: too fine for few cells to detect.
        let eight = found(|r| (8.0 * r).floor() / 8.0 + 1.0 / 16.0);
        assert_eq!(eight.verdict(), Verdict::Fails, "{name}: {eight}");
    }
}
