//! The BSDF check-ups on a rough conductor, and on faulty versions of it, each of which must be rejected.

use whitefurnace::harness::trial::refused;

use whitefurnace::bsdf::ggx::Ggx;

use super::*;

fn subject() -> BsdfSubject {
    BsdfSubject::of(Bsdf::model(Ggx { reflectance: DVec3::ONE, alpha: 0.5 })).loss(Loss::Allowed)
}

fn in_words(outcome: &Outcome) -> String {
    format!("{}: {}", outcome.name, outcome.worst)
}

/// Asserts that all outcomes of a right subject hold and pass the guard; below scale 1 what is undecided
/// will do.
pub fn assert_passes(name: &str, outcomes: &[Outcome], context: &Context) {
    let red = |outcome: &&Outcome| match outcome.verdict() {
        Verdict::Holds => false,
        Verdict::Fails => true,
        Verdict::Undecided { .. } => context.scale >= 1.0,
    };
    let red: Vec<String> = outcomes.iter().filter(red).map(in_words).collect();
    assert!(red.is_empty(), "{name}: {}", red.join("\n"));
    assert_eq!(refused(name, outcomes, context), "");
}

/// Asserts that a faulty subject is rejected, for certain, by an outcome whose name begins so; below scale 1
/// one that does not decide will do.
pub fn assert_rejection(name: &str, outcomes: &[Outcome], expected: &str, context: &Context) {
    let small = context.scale < 1.0;
    let rejects = |outcome: &&Outcome| match outcome.verdict() {
        Verdict::Holds => false,
        Verdict::Fails => small || may_hold(outcome).is_none(),
        Verdict::Undecided { .. } => small,
    };
    let found: Vec<String> = outcomes.iter().filter(rejects).map(in_words).collect();
    let meant = found.iter().any(|rejection| rejection.starts_with(expected));
    assert!(meant, "{name}: no complaint about {expected} among {found:?}");
}

/// Asserts that a faulty subject is rejected. Faults are far larger than δ: one inclination and a tenth of
/// the samples show them.
pub fn assert_rejected(name: &str, subject: &BsdfSubject, expected: &str) {
    let context = context(name);
    let size = CheckUp { inclinations: vec![40.0], samples: 400_000, ..CheckUp::default() };
    assert_rejection(name, &check_up(subject, &size, &context), expected, &context);
}

/// Where samplers lose what is absorbed, the weights vary more than those of Lambert.
pub fn large() -> CheckUp {
    CheckUp { samples: 6_000_000, ..CheckUp::default() }
}

#[test]
fn a_right_microfacet_bsdf_passes() {
    let context = context("GGX");
    assert_passes("GGX", &check_up(&subject(), &large(), &context), &context);
}

/// The right BSDF with `eval` multiplied by something.
fn multiplied(by: fn(DVec3) -> f64) -> BsdfSubject {
    let right = subject();
    BsdfSubject { eval: Box::new(move |wo, wi| (right.eval)(wo, wi) * by(wo)), ..subject() }
}

/// The right BSDF with a sampler that asks it.
fn sampled(sample: fn(&BsdfSubject, DVec3, [f64; 3]) -> Option<SampledDirection>) -> BsdfSubject {
    let right = subject();
    BsdfSubject { sample: Box::new(move |wo, random| sample(&right, wo, random)), ..subject() }
}

/// A name, a faulty subject, and how some complaint about it begins.
type Faulty = (&'static str, fn() -> BsdfSubject, &'static str);

const BELOW: Option<SampledDirection> = Some(SampledDirection { wi: DVec3::NEG_Z, weight: 0.0, pdf: 1.0 });

/// Faulty versions, each of which must be rejected.
pub const FAULTY: [Faulty; 9] = [
    ("factor", || multiplied(|_| 1.01), "weight = f cos/pdf"),
    ("factor, furnace", || multiplied(|_| 1.05), "furnace"),
    ("asymmetric", || multiplied(|wo| wo.z), "reciprocity"),
    ("gain", || multiplied(|_| 1.5), "energy bound"),
    ("negative", || multiplied(|_| -1.0), "finite and not negative"),
    ("undeclared loss", || subject().loss(Loss::None), "integral of the pdf"),
    ("scaled pdf", || BsdfSubject { pdf: Box::new(|wo, wi| 0.9 * (subject().pdf)(wo, wi)), ..subject() }, "chi-square"),
    // The classic slip: the sampled half vector's distribution without the visible normals.
    ("wrong sampler", || sampled(|right, wo, [r1, r2, r3]| (right.sample)(wo, [r1 * r1, r2, r3])), "chi-square"),
    // Below the horizon instead of lost.
    ("leaking sampler", || sampled(|right, wo, u| (right.sample)(wo, u).or(BELOW)), "chi-square"),
];

#[test]
fn faulty_microfacet_bsdfs_are_rejected() {
    for (name, subject, expected) in FAULTY {
        assert_rejected(name, &subject(), expected);
    }
}
