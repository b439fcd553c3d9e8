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
    // Of 1 − u, which is never 0, so that the pdf is not, either.
    let cosine = (1.0 - u).powf(1.0 / (EXPONENT + 1.0));
    let (sin, cos) = (TAU * v).sin_cos();
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let wi = sine * cos * across + sine * sin * along + cosine * mirrored;
    (wi.z > 0.0).then(|| SampledDirection {
        wi,
        weight: eval(wo, wi) * wi.z / pdf(wo, wi),
        pdf: pdf(wo, wi),
    })
}

/// Checks the BSDF with a pdf, prints all outcomes, and returns their verdicts.
fn on_trial(name: &str, pdf: fn(DVec3, DVec3) -> f64) -> Vec<Verdict> {
    let subject =
        BsdfSubject::new(eval, move |wo, random| sample(wo, random, pdf), pdf).loss(Loss::Allowed);
    let size = CheckUp {
        inclinations: vec![0.0, 30.0, 60.0],
        ..CheckUp::default()
    };
    let context = Context::new(2019, 1.0).expect("a valid scale").named(name);
    println!("{name}");
    let judged = check_up(&subject, &size, &context)
        .into_iter()
        .map(|outcome| {
            println!("  {:<35} {}", outcome.name, outcome.verdict().word());
            outcome.verdict()
        });
    judged.collect()
}

fn main() {
    let right = on_trial("Phong's lobe", pdf);
    let wrong = on_trial("Phong's lobe with a wrong pdf", wrong_pdf);
    let rejections = wrong.iter().filter(|verdict| **verdict == Verdict::Fails);
    let rejections = rejections.count();

    assert!(right.iter().all(|verdict| *verdict == Verdict::Holds));
    assert!(rejections > 0);
    println!(
        "\nverdict: the BSDF holds, and {rejections} of {} outcomes reject the wrong pdf",
        wrong.len()
    );
}
