//! The BSDF check-ups on right BSDFs and on faulty versions of them, each of which must be rejected: a
//! microfacet conductor that is not ours (GGX, visible normals), a sheet of paper that absorbs and lets
//! light through, a mirror that absorbs, glass.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use whitefurnace::fresnel::{mirror, radiance_factor, reflectance, refract};
use whitefurnace::harness::bsdf_checkup::{BsdfSample, BsdfSubject, CheckUp, Loss, check_up};
use whitefurnace::harness::lobe_checkup::{Lobe, LobeSample, LobeSubject, check_up_lobes};
use whitefurnace::harness::outcome::{Outcome, Verdict};
use whitefurnace::harness::trial::Context;
use whitefurnace::sampling::{cosine_hemisphere, cosine_hemisphere_pdf};

use crate::support::context;

const ROUGHNESS: f64 = 0.5;
fn lambda(w: DVec3) -> f64 {
    let tan2 = (w.x * w.x + w.y * w.y) / (w.z * w.z);
    0.5 * ((1.0 + ROUGHNESS * ROUGHNESS * tan2).sqrt() - 1.0)
}
fn distribution(h: DVec3) -> f64 {
    let d = (h.x * h.x + h.y * h.y) / (ROUGHNESS * ROUGHNESS) + h.z * h.z;
    1.0 / (PI * ROUGHNESS * ROUGHNESS * d * d)
}
fn eval(wo: DVec3, wi: DVec3) -> f64 {
    if wo.z <= 0.0 || wi.z <= 0.0 {
        return 0.0;
    }
    let g2 = 1.0 / (1.0 + lambda(wo) + lambda(wi));
    distribution((wo + wi).normalize()) * g2 / (4.0 * wo.z * wi.z)
}
fn pdf(wo: DVec3, wi: DVec3) -> f64 {
    if wo.z <= 0.0 || wi.z <= 0.0 {
        return 0.0;
    }
    distribution((wo + wi).normalize()) / (1.0 + lambda(wo)) / (4.0 * wo.z)
}
fn sample(wo: DVec3, [r1, r2, _]: [f64; 3]) -> Option<BsdfSample> {
    let v = DVec3::new(ROUGHNESS * wo.x, ROUGHNESS * wo.y, wo.z).normalize();
    let across = v.x.hypot(v.y);
    let t1 = if across > 0.0 {
        DVec3::new(-v.y, v.x, 0.0) / across
    } else {
        DVec3::X
    };
    let t2 = v.cross(t1);
    let (radius, (sin, cos)) = (r1.sqrt(), (TAU * r2).sin_cos());
    let s = 0.5 * (1.0 + v.z);
    let a = radius * cos;
    let b = (1.0 - s) * (1.0 - a * a).sqrt() + s * radius * sin;
    let n = a * t1 + b * t2 + (1.0 - a * a - b * b).max(0.0).sqrt() * v;
    let h = DVec3::new(ROUGHNESS * n.x, ROUGHNESS * n.y, n.z).normalize();
    let wi = 2.0 * wo.dot(h) * h - wo;
    (wi.z > 0.0).then(|| BsdfSample {
        wi,
        // f cos/pdf = G₂/G₁, derived on its own.
        weight: (1.0 + lambda(wo)) / (1.0 + lambda(wo) + lambda(wi)),
        pdf: pdf(wo, wi),
    })
}

fn subject() -> BsdfSubject {
    BsdfSubject::new(eval, sample, pdf).loss(Loss::Allowed)
}

fn complaints(name: &str, subject: &BsdfSubject) -> Vec<String> {
    let context = context(name);
    red(check_up(subject, &CheckUp::default(), &context), &context)
}

/// The outcomes that do not hold.
fn red(outcomes: Vec<Outcome>, context: &Context) -> Vec<String> {
    outcomes
        .into_iter()
        .filter(|outcome| match outcome.verdict() {
            Verdict::Holds => false,
            Verdict::Fails => true,
            Verdict::Undecided { .. } => context.scale >= 1.0,
        })
        .map(|outcome| format!("{}: {}", outcome.name, outcome.worst))
        .collect()
}

/// Asserts that some complaint begins with `expected`.
fn assert_rejected(name: &str, subject: &BsdfSubject, expected: &str) {
    assert_complaint(name, &complaints(name, subject), expected);
}

fn assert_complaint(name: &str, complaints: &[String], expected: &str) {
    assert!(
        complaints.iter().any(|c| c.starts_with(expected)),
        "{name}: no complaint about {expected} among {complaints:?}"
    );
}

#[test]
fn a_right_microfacet_bsdf_passes() {
    let complaints = complaints("GGX", &subject());
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

#[test]
fn faulty_microfacet_bsdfs_are_rejected() {
    let faulty_eval = |wrong: fn(DVec3, DVec3) -> f64| {
        let right = subject();
        BsdfSubject {
            eval: Box::new(move |wo, wi| eval(wo, wi) * wrong(wo, wi)),
            ..right
        }
    };
    assert_rejected("factor", &faulty_eval(|_, _| 1.01), "weight = f cos/pdf");
    assert_rejected("factor, furnace", &faulty_eval(|_, _| 1.01), "furnace");
    assert_rejected("asymmetric", &faulty_eval(|wo, _| wo.z), "reciprocity");
    assert_rejected("gain", &faulty_eval(|_, _| 1.5), "energy bound");
    assert_rejected(
        "negative",
        &faulty_eval(|_, _| -1.0),
        "finite and not negative",
    );
    let lossless = subject().loss(Loss::None);
    assert_rejected("undeclared loss", &lossless, "integral of the pdf");
    let wrong_pdf = BsdfSubject {
        pdf: Box::new(|wo, wi| 0.9 * pdf(wo, wi)),
        ..subject()
    };
    assert_rejected("scaled pdf", &wrong_pdf, "chi-square");
    // The classic slip: the sampled half vector's distribution without the visible normals.
    let wrong_sampler = BsdfSubject {
        sample: Box::new(|wo, [r1, r2, r3]| sample(wo, [r1 * r1, r2, r3])),
        ..subject()
    };
    assert_rejected("wrong sampler", &wrong_sampler, "chi-square");
    // Below the horizon instead of lost.
    let leaking = BsdfSubject {
        sample: Box::new(|wo, u| {
            sample(wo, u).or(Some(BsdfSample {
                wi: DVec3::NEG_Z,
                weight: 0.0,
                pdf: 1.0,
            }))
        }),
        ..subject()
    };
    assert_rejected("leaking sampler", &leaking, "chi-square");
}

/// Reflects a half and lets through a quarter, both diffusely. The sampler ends the path with the
/// probability of absorption.
const REFLECTED: f64 = 0.5;
const LET_THROUGH: f64 = 0.25;

/// The share of light that goes to the side of wi.
fn paper_share(wo: DVec3, wi: DVec3) -> f64 {
    if (wo.z > 0.0) == (wi.z > 0.0) {
        REFLECTED
    } else {
        LET_THROUGH
    }
}

fn paper_sample(wo: DVec3, [r1, r2, r3]: [f64; 3]) -> Option<BsdfSample> {
    let up = cosine_hemisphere([r1, r2]);
    let side = if r3 < REFLECTED {
        wo.z.signum()
    } else {
        -wo.z.signum()
    };
    let wi = up.with_z(side * up.z);
    (r3 < REFLECTED + LET_THROUGH).then(|| BsdfSample {
        wi,
        weight: 1.0,
        pdf: paper_share(wo, wi) * cosine_hemisphere_pdf(up.z),
    })
}

/// Paper whose sampler loses `loss` by declaration.
fn paper(loss: f64) -> BsdfSubject {
    let eval = |wo: DVec3, wi: DVec3| paper_share(wo, wi) / PI;
    let pdf = |wo: DVec3, wi: DVec3| paper_share(wo, wi) * cosine_hemisphere_pdf(wi.z.abs());
    BsdfSubject::new(eval, paper_sample, pdf)
        .transmits(true)
        .loss(Loss::Declared(Box::new(move |_| loss)))
        .albedo(|_| REFLECTED + LET_THROUGH)
}

#[test]
fn paper_that_absorbs_and_lets_light_through_passes() {
    let size = CheckUp {
        inclinations: vec![40.0, 140.0],
        ..CheckUp::default()
    };
    let context = context("paper");
    let red = red(check_up(&paper(0.25), &size, &context), &context);
    assert!(red.is_empty(), "{}", red.join("\n"));
}

#[test]
fn faulty_paper_is_rejected() {
    assert_rejected("paper, loss", &paper(0.2), "integral of the pdf");
    let loses_more = BsdfSubject {
        sample: Box::new(|wo, [r1, r2, r3]| paper_sample(wo, [r1, r2, 1.05 * r3])),
        ..paper(0.25)
    };
    assert_rejected("paper, loses more", &loses_more, "chi-square");
    let other_side = BsdfSubject {
        sample: Box::new(|wo, u| paper_sample(-wo, u)),
        ..paper(0.25)
    };
    assert_rejected("paper, other side", &other_side, "weight = f cos/pdf");
    let one_way = BsdfSubject {
        eval: Box::new(|wo, wi| paper_share(wo, wi) / PI * if wo.z < 0.0 { 0.9 } else { 1.0 }),
        ..paper(0.25)
    };
    assert_rejected("paper, one way", &one_way, "reciprocity");
    let opaque = paper(0.25).transmits(false);
    assert_rejected("paper, called opaque", &opaque, "integral of the pdf");
}

fn lobe_complaints(name: &str, subject: &LobeSubject, size: &CheckUp) -> Vec<String> {
    let context = context(name);
    red(check_up_lobes(subject, size, &context), &context)
}

fn assert_lobes_rejected(name: &str, subject: &LobeSubject, expected: &str) {
    let size = CheckUp {
        samples: 400_000,
        ..CheckUp::default()
    };
    assert_complaint(name, &lobe_complaints(name, subject, &size), expected);
}

const REFLECTANCE: f64 = 0.8;

fn mirror_sample(wo: DVec3, [r, ..]: [f64; 3]) -> Option<LobeSample> {
    (r < REFLECTANCE).then(|| LobeSample {
        wi: mirror(-wo, DVec3::Z),
        weight: 1.0,
    })
}

/// A mirror on which paths end with the probability of absorption.
fn absorbing_mirror() -> LobeSubject {
    let lobes = |wo: DVec3| {
        vec![Lobe {
            direction: DVec3::new(-wo.x, -wo.y, wo.z),
            probability: REFLECTANCE,
            share: REFLECTANCE,
        }]
    };
    LobeSubject::new(lobes, mirror_sample).loss(Loss::Declared(Box::new(|_| 1.0 - REFLECTANCE)))
}

const INDEX: f64 = 1.5;

/// The indices on the side of wo and beyond, and the normal on the side of wo.
fn sides(wo: DVec3) -> (f64, f64, DVec3) {
    if wo.z > 0.0 {
        (1.0, INDEX, DVec3::Z)
    } else {
        (INDEX, 1.0, -DVec3::Z)
    }
}

/// Glass, its lobes written out in coordinates: Snell's law for the tangential part.
fn glass_lobes(wo: DVec3) -> Vec<Lobe> {
    let (n1, n2, normal) = sides(wo);
    let r = reflectance(wo.z.abs(), n1, n2);
    let mirrored = Lobe {
        direction: DVec3::new(-wo.x, -wo.y, wo.z),
        probability: r,
        share: r,
    };
    let tangential = -(n1 / n2) * wo.with_z(0.0);
    let squared = 1.0 - tangential.length_squared();
    if squared <= 0.0 {
        return vec![mirrored];
    }
    let refracted = Lobe {
        direction: tangential - squared.sqrt() * normal,
        probability: 1.0 - r,
        share: (1.0 - r) * (n1 / n2).powi(2),
    };
    vec![mirrored, refracted]
}

/// The library's functions, as its estimators use them; `choice` is the probability of reflection.
fn glass_sample(wo: DVec3, r: f64, choice: impl Fn(f64) -> f64) -> Option<LobeSample> {
    let (n1, n2, normal) = sides(wo);
    let share = reflectance(wo.z.abs(), n1, n2);
    match refract(-wo, normal, n1, n2) {
        Some(wi) if r >= choice(share) => Some(LobeSample {
            wi,
            weight: radiance_factor(n1, n2) * (1.0 - share) / (1.0 - choice(share)),
        }),
        Some(_) => Some(LobeSample {
            wi: mirror(-wo, normal),
            weight: share / choice(share),
        }),
        None => Some(LobeSample {
            wi: mirror(-wo, normal),
            weight: 1.0,
        }),
    }
}

fn glass() -> LobeSubject {
    LobeSubject::new(glass_lobes, |wo, [r, ..]| {
        glass_sample(wo, r, |share| share)
    })
    .transmits(true)
    .energy_bound(INDEX * INDEX)
}

#[test]
fn an_absorbing_mirror_and_glass_pass() {
    for (name, subject) in [("mirror", absorbing_mirror()), ("glass", glass())] {
        let complaints = lobe_complaints(name, &subject, &CheckUp::default());
        assert!(complaints.is_empty(), "{name}: {}", complaints.join("\n"));
    }
}

#[test]
fn faulty_mirrors_are_rejected() {
    let lossless = absorbing_mirror().loss(Loss::None);
    assert_lobes_rejected("mirror, loss", &lossless, "sum of probabilities");
    assert_lobes_rejected("mirror, lost", &lossless, "samples of no lobe");
    let sampled = |sample: fn(DVec3, [f64; 3]) -> Option<LobeSample>| LobeSubject {
        sample: Box::new(sample),
        ..absorbing_mirror()
    };
    let back = sampled(|wo, u| mirror_sample(wo, u).map(|s| LobeSample { wi: -s.wi, ..s }));
    assert_lobes_rejected("mirror, sign", &back, "weight = share/probability");
    assert_lobes_rejected("mirror, sign", &back, "samples of no lobe");
    let twice = sampled(|wo, u| {
        mirror_sample(wo, u).map(|s| LobeSample {
            weight: REFLECTANCE,
            ..s
        })
    });
    assert_lobes_rejected("mirror, absorbs twice", &twice, "furnace");
    let rarely = sampled(|wo, [r, s, t]| mirror_sample(wo, [1.1 * r, s, t]));
    assert_lobes_rejected("mirror, survives too rarely", &rarely, "samples towards");
    let bright = absorbing_mirror().energy_bound(0.5);
    assert_lobes_rejected("mirror, too bright", &bright, "energy bound");
    let broken = sampled(|wo, u| {
        mirror_sample(wo, u).map(|s| LobeSample {
            weight: f64::NAN,
            ..s
        })
    });
    assert_lobes_rejected("mirror, NaN", &broken, "finite and not negative");
}

#[test]
fn faulty_glass_is_rejected() {
    let sampled = |sample: fn(DVec3, f64) -> Option<LobeSample>| LobeSubject {
        sample: Box::new(move |wo, [r, ..]| sample(wo, r)),
        ..glass()
    };
    let even = sampled(|wo, r| glass_sample(wo, r, |_| 0.5));
    assert_lobes_rejected("glass, even choice", &even, "samples towards");
    let without_factor = sampled(|wo, r| {
        glass_sample(wo, r, |share| share).map(|s| LobeSample { weight: 1.0, ..s })
    });
    assert_lobes_rejected("glass, no factor", &without_factor, "furnace");
    let bent = LobeSubject {
        lobes: Box::new(|wo| {
            let mut lobes = glass_lobes(wo);
            // Straight through, from inside only: light does not find its way back.
            if let (true, Some(refracted)) = (wo.z < 0.0, lobes.get_mut(1)) {
                refracted.direction = -wo;
            }
            lobes
        }),
        ..glass()
    };
    assert_lobes_rejected("glass, one way", &bent, "way back");
}
