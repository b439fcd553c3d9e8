//! A BSDF on trial: do its value, its sampler and its pdf agree, and does it conserve energy?
//!
//! It needs the harness alone: `cargo run -p whitefurnace --no-default-features --example bsdf`.

use std::f64::consts::TAU;

use whitefurnace::glam::DVec3;
use whitefurnace::harness::bsdf_checkup::{BsdfSubject, CheckUp, Loss, SampledDirection, check_up};
use whitefurnace::harness::outcome::Verdict;
use whitefurnace::harness::trial::Context;

/// Exponent n of the lobe.
const EXPONENT: f64 = 20.0;

/// Returns cosⁿ α, where α is the angle from the mirrored direction.
fn lobe(wo: DVec3, wi: DVec3) -> f64 {
    let cosine = wi.dot(DVec3::new(-wo.x, -wo.y, wo.z));
    if wo.z > 0.0 && wi.z > 0.0 {
        cosine.max(0.0).powf(EXPONENT)
    } else {
        0.0
    }
}

/// Phong's lobe in its reciprocal form (Lafortune and Willems 1994): (n + 2)/(2π) cosⁿ α.
fn eval(wo: DVec3, wi: DVec3) -> f64 {
    (EXPONENT + 2.0) / TAU * lobe(wo, wi)
}

/// The pdf of a direction of the lobe: (n + 1)/(2π) cosⁿ α.
fn pdf(wo: DVec3, wi: DVec3) -> f64 {
    (EXPONENT + 1.0) / TAU * lobe(wo, wi)
}

/// Takes the factor of the BSDF for that of the pdf: 5 % too much.
fn wrong_pdf(wo: DVec3, wi: DVec3) -> f64 {
    eval(wo, wi)
}

/// Samples a direction of the lobe; the part below the horizon is lost.
fn sample(
    wo: DVec3,
    [u, v, _]: [f64; 3],
    pdf: fn(DVec3, DVec3) -> f64,
) -> Option<SampledDirection> {
    let mirrored = DVec3::new(-wo.x, -wo.y, wo.z);
    let (across, along) = mirrored.any_orthonormal_pair();
    let cosine = u.powf(1.0 / (EXPONENT + 1.0));
    let (sin, cos) = (TAU * v).sin_cos();
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let wi = sine * cos * across + sine * sin * along + cosine * mirrored;
    (wi.z > 0.0).then(|| SampledDirection {
        wi,
        weight: eval(wo, wi) * wi.z / pdf(wo, wi),
        pdf: pdf(wo, wi),
    })
}

/// Checks the BSDF with a pdf; prints all outcomes, and returns the names of those that reject it
/// and whether the others hold.
fn on_trial(name: &str, pdf: fn(DVec3, DVec3) -> f64) -> (Vec<String>, bool) {
    let subject =
        BsdfSubject::new(eval, move |wo, random| sample(wo, random, pdf), pdf).loss(Loss::Allowed);
    let context = Context::new(2019, 1.0).expect("a valid scale").named(name);
    let size = CheckUp {
        inclinations: vec![0.0, 30.0, 60.0],
        ..CheckUp::default()
    };
    let outcomes = check_up(&subject, &size, &context);
    println!("{name}");
    for outcome in &outcomes {
        println!("  {:<33} {}", outcome.name, outcome.verdict().word());
    }
    let with = |verdict| {
        outcomes
            .iter()
            .filter(move |outcome| outcome.verdict() == verdict)
    };
    (
        with(Verdict::Fails)
            .map(|outcome| outcome.name.clone())
            .collect(),
        with(Verdict::Holds).count() == outcomes.len(),
    )
}

fn main() {
    let (_, holds) = on_trial("Phong's lobe", pdf);
    let (rejected_by, _) = on_trial("Phong's lobe with a wrong pdf", wrong_pdf);

    assert!(holds);
    assert!(!rejected_by.is_empty());
    println!(
        "\nverdict: the BSDF holds, and the one with the wrong pdf is rejected by {}",
        rejected_by.join(", ")
    );
}
