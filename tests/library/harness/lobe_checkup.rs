//! End-to-end check-ups of BSDFs that transmit or have Dirac lobes, and of faulty versions, each of
//! which must be rejected: a sheet of paper that absorbs and transmits light, a mirror that
//! absorbs, glass. (Models that reflect are on trial in the registry: `bsdf/ggx` and its faults.)

use whitefurnace::harness::trial::power_objections;
use whitefurnace::material::fresnel::{radiance_factor, reflect, reflectance, refract};

use super::*;

/// Numbers of random outcomes of the correct subjects: paper, mirror and glass.
pub const PASSES: [usize; 3] = [4, 8, 22];
/// Number of faulty subjects, each of which must be rejected.
pub const FAULTY: usize = 16;

fn in_words(outcome: &Outcome) -> String {
    format!("{}: {}", outcome.name, outcome.worst)
}

/// Asserts that all outcomes of a correct subject hold and pass the guard; below scale 1 they may
/// be undecided.
fn assert_passes(name: &str, outcomes: &[Outcome], context: &Context) {
    let red = |outcome: &&Outcome| match outcome.verdict() {
        Verdict::Holds => false,
        Verdict::Fails => true,
        Verdict::Undecided { .. } => context.scale >= 1.0,
    };
    let red: Vec<String> = outcomes.iter().filter(red).map(in_words).collect();
    assert!(red.is_empty(), "{name}: {}", red.join("\n"));
    assert_eq!(power_objections(name, outcomes, context), "");
}

/// Asserts that a faulty subject is rejected by an outcome whose name begins so, with certainty at
/// planned sizes; below scale 1 it may be undecided.
fn assert_rejection(name: &str, outcomes: &[Outcome], expected: &str, context: &Context) {
    let small = context.scale < 1.0;
    let rejects = |outcome: &&Outcome| match outcome.verdict() {
        Verdict::Holds => false,
        Verdict::Fails => !context.guard_applies() || fault_objection(outcome, 1.0).is_none(),
        Verdict::Undecided { .. } => small,
    };
    let found: Vec<String> = outcomes.iter().filter(rejects).map(in_words).collect();
    let meant = found
        .iter()
        .any(|rejection| rejection.starts_with(expected));
    assert!(
        meant,
        "{name}: no complaint about {expected} among {found:?}"
    );
}

/// Asserts that a faulty subject is rejected. Faults are far larger than δ: one inclination and a
/// tenth of the samples are enough.
fn assert_rejected(name: &str, subject: &BsdfSubject, expected: &str) {
    let context = context(name);
    let size = CheckUp {
        inclinations: vec![40.0],
        samples: 400_000,
        ..CheckUp::default()
    };
    assert_rejection(
        name,
        &check_up(subject, &size, &context),
        expected,
        &context,
    );
}

/// A larger check-up: where samplers lose the absorbed part, weights vary more than Lambert's.
fn large() -> CheckUp {
    CheckUp {
        samples: 6_000_000,
        ..CheckUp::default()
    }
}

fn random(outcomes: &[Outcome]) -> usize {
    outcomes
        .iter()
        .filter(|outcome| outcome.is_random())
        .count()
}

/// Reflects a half and lets through a quarter, both diffusely. The sampler ends the path with the
/// probability of absorption.
const PAPER_REFLECTANCE: f64 = 0.5;
const PAPER_TRANSMITTANCE: f64 = 0.25;

/// Returns the throughput of light that is scattered to the side of wi.
fn paper_share(wo: DVec3, wi: DVec3) -> f64 {
    if (wo.z > 0.0) == (wi.z > 0.0) {
        PAPER_REFLECTANCE
    } else {
        PAPER_TRANSMITTANCE
    }
}

fn paper_sample(wo: DVec3, [r1, r2, r3]: [f64; 3]) -> Option<SampledDirection> {
    let up = cosine_hemisphere([r1, r2]);
    let side = if r3 < PAPER_REFLECTANCE {
        wo.z.signum()
    } else {
        -wo.z.signum()
    };
    let wi = up.with_z(side * up.z);
    (r3 < PAPER_REFLECTANCE + PAPER_TRANSMITTANCE).then(|| SampledDirection {
        wi,
        weight: 1.0,
        pdf: paper_share(wo, wi) * cosine_hemisphere_pdf(up.z),
    })
}

/// Returns paper whose sampler loses `loss` by declaration.
fn paper(loss: f64) -> BsdfSubject {
    let eval = |wo: DVec3, wi: DVec3| paper_share(wo, wi) / PI;
    let pdf = |wo: DVec3, wi: DVec3| paper_share(wo, wi) * cosine_hemisphere_pdf(wi.z.abs());
    BsdfSubject::new(eval, paper_sample, pdf)
        .transmits(true)
        .loss(Loss::Declared(Box::new(move |_| loss)))
        .albedo(|_| PAPER_REFLECTANCE + PAPER_TRANSMITTANCE)
}

#[test]
fn paper_that_absorbs_and_lets_light_through_passes() {
    let size = CheckUp {
        inclinations: vec![40.0, 140.0],
        ..large()
    };
    let context = context("paper");
    let outcomes = check_up(&paper(0.25), &size, &context);
    assert!(random(&outcomes) <= PASSES[0], "{}", random(&outcomes));
    assert_passes("paper", &outcomes, &context);
}

#[test]
fn faulty_paper_is_rejected() {
    let sampled = |sample: fn(DVec3, [f64; 3]) -> Option<SampledDirection>| BsdfSubject {
        sample: Box::new(sample),
        ..paper(0.25)
    };
    let one_way = |wo: DVec3, wi| paper_share(wo, wi) / PI * if wo.z < 0.0 { 0.9 } else { 1.0 };
    for (name, subject, expected) in [
        ("paper, loss", paper(0.2), "integral of the pdf"),
        (
            "paper, loses more",
            sampled(|wo, [r1, r2, r3]| paper_sample(wo, [r1, r2, 1.05 * r3])),
            "chi-square",
        ),
        (
            "paper, other side",
            sampled(|wo, u| paper_sample(-wo, u)),
            "weight = f cos/pdf",
        ),
        (
            "paper, one way",
            BsdfSubject {
                eval: Box::new(one_way),
                ..paper(0.25)
            },
            "reciprocity",
        ),
        (
            "paper, called opaque",
            paper(0.25).transmits(false),
            "integral of the pdf",
        ),
    ] {
        assert_rejected(name, &subject, expected);
    }
}

fn assert_lobes_rejected(name: &str, subject: &LobeSubject, expected: &str) {
    let context = context(name);
    let size = CheckUp {
        samples: 400_000,
        ..CheckUp::default()
    };
    assert_rejection(
        name,
        &check_up_lobes(subject, &size, &context),
        expected,
        &context,
    );
}

const REFLECTANCE: f64 = 0.8;

fn mirror_sample(wo: DVec3, [r, ..]: [f64; 3]) -> Option<LobeSample> {
    (r < REFLECTANCE).then(|| LobeSample {
        wi: reflect(-wo, DVec3::Z),
        weight: 1.0,
    })
}

/// Returns a mirror on which paths end with the probability of absorption.
fn absorbing_mirror() -> LobeSubject {
    let lobes = |wo: DVec3| {
        vec![Lobe {
            direction: DVec3::new(-wo.x, -wo.y, wo.z),
            probability: REFLECTANCE,
            throughput: REFLECTANCE,
        }]
    };
    LobeSubject::new(lobes, mirror_sample).loss(Loss::Declared(Box::new(|_| 1.0 - REFLECTANCE)))
}

const INDEX: f64 = 1.5;

/// Returns the indices of refraction on the side of wo and on the other side, and the normal on the
/// side of wo.
fn sides(wo: DVec3) -> (f64, f64, DVec3) {
    if wo.z > 0.0 {
        (1.0, INDEX, DVec3::Z)
    } else {
        (INDEX, 1.0, -DVec3::Z)
    }
}

/// Returns the lobes of glass in coordinates: Snell's law for the tangential part.
fn glass_lobes(wo: DVec3) -> Vec<Lobe> {
    let (n1, n2, normal) = sides(wo);
    let r = reflectance(wo.z.abs(), n1, n2);
    let mirrored = Lobe {
        direction: DVec3::new(-wo.x, -wo.y, wo.z),
        probability: r,
        throughput: r,
    };
    let tangential = -(n1 / n2) * wo.with_z(0.0);
    let squared = 1.0 - tangential.length_squared();
    if squared <= 0.0 {
        return vec![mirrored];
    }
    let refracted = Lobe {
        direction: tangential - squared.sqrt() * normal,
        probability: 1.0 - r,
        throughput: (1.0 - r) * (n1 / n2).powi(2),
    };
    vec![mirrored, refracted]
}

/// Samples glass with the library's functions, as its estimators do; `choice` is the probability of
/// reflection.
fn glass_sample(wo: DVec3, r: f64, choice: impl Fn(f64) -> f64) -> Option<LobeSample> {
    let (n1, n2, normal) = sides(wo);
    let throughput = reflectance(wo.z.abs(), n1, n2);
    match refract(-wo, normal, n1, n2) {
        Some(wi) if r >= choice(throughput) => Some(LobeSample {
            wi,
            weight: radiance_factor(n1, n2) * (1.0 - throughput) / (1.0 - choice(throughput)),
        }),
        Some(_) => Some(LobeSample {
            wi: reflect(-wo, normal),
            weight: throughput / choice(throughput),
        }),
        None => Some(LobeSample {
            wi: reflect(-wo, normal),
            weight: 1.0,
        }),
    }
}

fn glass() -> LobeSubject {
    LobeSubject::new(glass_lobes, |wo, [r, ..]| {
        glass_sample(wo, r, |throughput| throughput)
    })
    .transmits(true)
    .energy_bound(INDEX * INDEX)
}

#[test]
fn an_absorbing_mirror_and_glass_pass() {
    for (name, subject, passes) in [
        ("mirror", absorbing_mirror(), PASSES[1]),
        ("glass", glass(), PASSES[2]),
    ] {
        let context = context(name);
        let outcomes = check_up_lobes(&subject, &large(), &context);
        assert!(random(&outcomes) <= passes, "{}", random(&outcomes));
        assert_passes(name, &outcomes, &context);
    }
}

#[test]
fn faulty_mirrors_are_rejected() {
    let lossless = || absorbing_mirror().loss(Loss::None);
    // Changes the results of the sampler.
    let changed = |change: fn(LobeSample) -> LobeSample| LobeSubject {
        sample: Box::new(move |wo, u| mirror_sample(wo, u).map(change)),
        ..absorbing_mirror()
    };
    let back = || changed(|s| LobeSample { wi: -s.wi, ..s });
    let rarely = LobeSubject {
        sample: Box::new(|wo, [r, s, t]| mirror_sample(wo, [1.1 * r, s, t])),
        ..absorbing_mirror()
    };
    for (name, subject, expected) in [
        ("mirror, loss", lossless(), "sum of probabilities"),
        ("mirror, lost", lossless(), "samples of no lobe"),
        ("mirror, sign", back(), "weight = throughput/probability"),
        ("mirror, sign", back(), "samples of no lobe"),
        (
            "mirror, absorbs twice",
            changed(|s| LobeSample {
                weight: REFLECTANCE,
                ..s
            }),
            "furnace",
        ),
        ("mirror, survives too rarely", rarely, "samples towards"),
        (
            "mirror, too bright",
            absorbing_mirror().energy_bound(0.5),
            "energy bound",
        ),
        (
            "mirror, NaN",
            changed(|s| LobeSample {
                weight: f64::NAN,
                ..s
            }),
            "finite and not negative",
        ),
    ] {
        assert_lobes_rejected(name, &subject, expected);
    }
}

#[test]
fn faulty_glass_is_rejected() {
    let sampled = |sample: fn(DVec3, f64) -> Option<LobeSample>| LobeSubject {
        sample: Box::new(move |wo, [r, ..]| sample(wo, r)),
        ..glass()
    };
    let unweighted = |wo, r| {
        glass_sample(wo, r, |throughput| throughput).map(|s| LobeSample { weight: 1.0, ..s })
    };
    let bent = |wo: DVec3| {
        let mut lobes = glass_lobes(wo);
        // Straight through, from inside only: the lobes are not reciprocal.
        if let (true, Some(refracted)) = (wo.z < 0.0, lobes.get_mut(1)) {
            refracted.direction = -wo;
        }
        lobes
    };
    for (name, subject, expected) in [
        (
            "glass, even choice",
            sampled(|wo, r| glass_sample(wo, r, |_| 0.5)),
            "samples towards",
        ),
        ("glass, no factor", sampled(unweighted), "furnace"),
        (
            "glass, one way",
            LobeSubject {
                lobes: Box::new(bent),
                ..glass()
            },
            "way back",
        ),
    ] {
        assert_lobes_rejected(name, &subject, expected);
    }
}
