//! Checks of a BSDF without statistics: finite values, sampled weights, reciprocity.

use super::*;

/// Names of the outcomes.
pub(super) const FINITE: &str = "finite and not negative";
pub(super) const WEIGHTS: &str = "weight = f cos/pdf";
pub(super) const RECIPROCITY: &str = "reciprocity";

/// Checks that no value is NaN, infinite or negative and that sampled directions are unit, corners
/// of the domain included (normal and grazing incidence, both; retroreflection; random numbers at 0
/// and near 1).
pub(super) fn check_finite(
    subject: &BsdfSubject,
    size: &CheckUp,
    rounding: RoundoffBounds,
    rng: &mut Stream,
) -> Outcome {
    let mut worst = format!(
        "every value is finite and not negative; judged as {}",
        rounding.words()
    );
    let mut bad = 0.0;
    let last = rounding.round_down(ONE_MINUS_EPSILON);
    let ok = |x: f64| x.is_finite() && x >= 0.0;
    for _ in 0..size.pairs {
        let [wo, wi] = [(); 2].map(|()| fuzzed_direction(rng, subject.transmits));
        let u = [(); 3].map(|()| rounding.round_down(fuzzed_number(rng)));
        let [f, pdf] = [subject.eval(wo, wi), subject.pdf(wo, wi)];
        let sample = subject.sample(wo, u);
        let sample_ok = sample.is_none_or(|s| {
            // In single precision a pdf may round to 0 at corners.
            let corner = wo.z.abs().min(s.wi.z.abs()) <= rounding.horizon()
                || u.iter().any(|&u| u == 0.0 || u == last);
            let dense = s.pdf > 0.0 || (s.pdf == 0.0 && corner && rounding.is_coarse());
            ok(s.weight)
                && dense
                && s.pdf.is_finite()
                && (s.wi.length() - 1.0).abs() < rounding.tolerance()
        });
        if !(ok(f) && ok(pdf) && sample_ok) {
            bad = 1.0;
            worst = format!("wo = {wo}, wi = {wi}: f = {f}, pdf = {pdf}; random {u:?}: {sample:?}");
        }
    }
    Outcome::identity(FINITE, size.pairs, bad, 0.0, worst)
}

/// Checks pointwise that weight · pdf = f cos and that the sample's pdf is the pdf.
pub(super) fn check_weights(
    subject: &BsdfSubject,
    size: &CheckUp,
    rounding: RoundoffBounds,
    rng: &mut Stream,
) -> Outcome {
    let mut largest = LargestError::default();
    let [mut compared, mut skipped] = [0; 2];
    for _ in 0..size.pairs {
        let wo = inner_direction(rng, subject.transmits);
        let Some(s) = subject.sample(wo, uniform3(rng).map(|u| rounding.round_down(u))) else {
            continue;
        };
        if s.wi.z.abs() < MIN_COSINE {
            continue;
        }
        let [pdf, f_cos] = [subject.pdf(wo, s.wi), subject.f_cos(wo, s.wi)];
        let pdf_conditioning = || rounding.conditioning(wo, s.wi, &|wo, wi| subject.pdf(wo, wi));
        let f_cos_conditioning =
            || rounding.conditioning(wo, s.wi, &|wo, wi| subject.f_cos(wo, wi));
        let errors = [
            rounding.relative(s.weight * pdf, f_cos),
            rounding.relative(s.pdf, pdf),
        ];
        let weight = rounding.excess(errors[0], || pdf_conditioning() + f_cos_conditioning());
        let (Some(weight), Some(density)) = (weight, rounding.excess(errors[1], pdf_conditioning))
        else {
            skipped += 1;
            continue;
        };
        compared += 1;
        largest.update(weight, || {
            let quotient = f_cos / pdf;
            format!(
                "weight {} but f cos/pdf = {quotient}, off by {:.1e}, at wo = {wo}, wi = {}",
                s.weight, errors[0], s.wi
            )
        });
        largest.update(density, || {
            let error = errors[1];
            format!(
                "the sample says pdf = {}, pdf() says {pdf}, off by {error:.1e}, at wo = {wo}, wi = {}",
                s.pdf, s.wi
            )
        });
    }
    rounding.outcome(WEIGHTS, compared, skipped, largest)
}

pub(super) fn check_reciprocity(
    subject: &BsdfSubject,
    size: &CheckUp,
    rounding: RoundoffBounds,
    rng: &mut Stream,
) -> Outcome {
    let mut largest = LargestError::default();
    let mut skipped = 0;
    for _ in 0..size.pairs {
        let [wo, wi] = [(); 2].map(|()| inner_direction(rng, subject.transmits));
        let [there, back] = [subject.eval(wo, wi), subject.eval(wi, wo)];
        let error = rounding.relative(there, back);
        let Some(excess) = rounding.excess(error, || {
            rounding.conditioning(wo, wi, &|wo, wi| subject.eval(wo, wi))
        }) else {
            skipped += 1;
            continue;
        };
        largest.update(excess, || {
            format!("f = {there} and {back}, off by {error:.1e}, with wo = {wo}, wi = {wi} and exchanged")
        });
    }
    let compared = size.pairs - skipped;
    rounding.outcome(RECIPROCITY, compared, skipped, largest)
}
