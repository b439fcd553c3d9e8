//! Variance reduction by specular next-event estimation through mirrors and glass spheres, and
//! equality of the means.

use super::variants::{Variant, VariantResult, claim_gain, judge_above, ratio_interval};
use crate::experiments::prelude::*;
use crate::render::{AdaptiveName, SamplerName, SilhouettesName, SpecularNeeName};

pub(super) const SPECULAR: Experiment = Experiment {
    id: "specular",
    title: "shadow rays by way of mirrors and balls of glass: variance, and the same mean",
    headline: "shadow rays through mirrors and glass: variance {gain %.1f} times smaller, the same mean within {half-width %.2%}",
    version: 1,
    equations: &[&equation::SPECULAR_ANGLE, &equation::SPECULAR_SPREAD],
    run,
};

/// Samples per pixel, by tier.
const SAMPLES: [u32; 2] = [32, 128];
/// Relative margins of the means, by tier.
const MARGINS: [f64; 2] = [0.005, 0.001];

fn run(run: &mut Run) -> Result<(), Error> {
    let groups = run.by_tier(4, 24);
    let job = |specular_nee, spp, size| {
        let (sampler, silhouettes, adaptive) =
            (SamplerName::Sobol, SilhouettesName::Yes, AdaptiveName::No);
        Job {
            sampler,
            silhouettes,
            adaptive,
            spp,
            specular_nee,
            size,
            ..Job::default()
        }
    };
    let mut results = Vec::new();
    for (specular_nee, file) in [
        (SpecularNeeName::No, "without.png"),
        (SpecularNeeName::Yes, "with.png"),
    ] {
        let variant = Variant {
            label: format!("{specular_nee:?}"),
            bar: name(specular_nee),
            job: job(specular_nee, run.by_tier(SAMPLES[0], SAMPLES[1]), [128, 96]),
        };
        results.push(variant.render(run, groups)?);
        let shown = run
            .with_run_options(job(specular_nee, 16, run.by_tier([128, 96], [256, 192])))
            .render(file)?
            .into_complete()?;
        write_png(&run.figure(file), &shown, Job::default().display(0.0), 2)?;
    }
    let level = FAMILYWISE_LEVEL / 2.0;
    let gain = claim_gain(
        run,
        "shadow rays by way of mirrors and glass gain",
        [&results[0].variance, &results[1].variance],
        level,
    );
    run.number("gain", gain);
    same(run, &results[0], &results[1], level);
    Ok(())
}

/// Claims that the means are equal within the margin.
fn same(run: &mut Run, without: &VariantResult, with: &VariantResult, level: f64) {
    let (quotient, half) = ratio_interval([&with.mean, &without.mean], level);
    let apart = quotient - 1.0;
    run.number("apart", apart);
    run.number("half-width", half);
    let (far, margin) = (apart.abs(), run.by_tier(MARGINS[0], MARGINS[1]));
    let value = format!("{apart:+.1e} ± {half:.1e} of the mean without, {margin} allowed");
    let verdict = judge_above([margin - far - half, margin - far + half], 0.0);
    run.claim("and leave the mean of the image as it is", value, verdict);
}
