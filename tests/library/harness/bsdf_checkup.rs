//! The BSDF check-ups on right BSDFs and on faulty versions of them, each of which must be rejected: a
//! microfacet conductor that is not ours (GGX, visible normals).

use whitefurnace::harness::trial::refused;

use super::*;

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
    let t1 = if across > 0.0 { DVec3::new(-v.y, v.x, 0.0) / across } else { DVec3::X };
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
fn multiplied(by: impl Fn(DVec3) -> f64 + Send + Sync + 'static) -> BsdfSubject {
    BsdfSubject { eval: Box::new(move |wo, wi| eval(wo, wi) * by(wo)), ..subject() }
}

/// A name, a faulty subject, and how some complaint about it begins.
type Faulty = (&'static str, fn() -> BsdfSubject, &'static str);

/// Faulty versions, each of which must be rejected.
pub const FAULTY: [Faulty; 9] = [
    ("factor", || multiplied(|_| 1.01), "weight = f cos/pdf"),
    ("factor, furnace", || multiplied(|_| 1.05), "furnace"),
    ("asymmetric", || multiplied(|wo| wo.z), "reciprocity"),
    ("gain", || multiplied(|_| 1.5), "energy bound"),
    ("negative", || multiplied(|_| -1.0), "finite and not negative"),
    ("undeclared loss", || subject().loss(Loss::None), "integral of the pdf"),
    ("scaled pdf", || BsdfSubject { pdf: Box::new(|wo, wi| 0.9 * pdf(wo, wi)), ..subject() }, "chi-square"),
    // The classic slip: the sampled half vector's distribution without the visible normals.
    (
        "wrong sampler",
        || BsdfSubject { sample: Box::new(|wo, [r1, r2, r3]| sample(wo, [r1 * r1, r2, r3])), ..subject() },
        "chi-square",
    ),
    // Below the horizon instead of lost.
    (
        "leaking sampler",
        || BsdfSubject {
            sample: Box::new(|wo, u| sample(wo, u).or(Some(BsdfSample { wi: DVec3::NEG_Z, weight: 0.0, pdf: 1.0 }))),
            ..subject()
        },
        "chi-square",
    ),
];

#[test]
fn faulty_microfacet_bsdfs_are_rejected() {
    for (name, subject, expected) in FAULTY {
        assert_rejected(name, &subject(), expected);
    }
}
