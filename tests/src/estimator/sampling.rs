//! Faults of sampling: directions (17)-(19), cosine-weighted directions, roulette.

use whitefurnace::sampling::roulette;
use whitefurnace::sampling::warp::{cosine_hemisphere, uniform_hemisphere, uniform_hemisphere_pdf};

use crate::hemisphere::faults::{
    half_circle, half_circle_cosine, linear_theta, no_root, shared_number,
};
use crate::prelude::*;

pub(super) fn faults() -> Vec<Fault<EstimatorSubject>> {
    vec![
        fault!("uniform-for-cosine", COSINE_HEMISPHERE, "uniform directions with the cosine pdf's weight",
            { cosine_hemisphere: uniform_hemisphere }, "irradiance/hits-alone"),
        fault!("cosine-no-root", COSINE_HEMISPHERE, "sin θ = r for sin θ = √r",
            { cosine_hemisphere: no_root }, "furnace/sky/path", "sky/overcast/bsdf"),
        fault!("cosine-half-circle", COSINE_HEMISPHERE, "φ over half the circle",
            { cosine_hemisphere: half_circle_cosine }, "furnace/sky/path"),
        fault!("shared-number", HEMISPHERE_PHI, "one random number in (18) and (19)",
            { uniform_hemisphere: shared_number }, "furnace/sky/report"),
        fault!("half-circle", HEMISPHERE_PHI, "φ = πr for 2πr",
            { uniform_hemisphere: half_circle }, "furnace/sky/report"),
        fault!("linear-theta", HEMISPHERE_THETA, "θ = rπ/2",
            { uniform_hemisphere: linear_theta }, "furnace/sky/report"),
        fault!("cosine-for-uniform", HEMISPHERE_THETA, "cosine-weighted directions with the weight of (17)",
            { uniform_hemisphere: cosine_hemisphere }, "furnace/report/absorption-0.25"),
        fault!("pdf-twice", HEMISPHERE_PDF, "p = 1/π",
            { uniform_hemisphere_pdf: |cos| 2.0 * uniform_hemisphere_pdf(cos) },
            "furnace/report/absorption-0.25", "furnace/report/seven-segments", "furnace/sky/report",
            "images/diffuse-room: image mean | p-values of pixels"),
        fault!("no-roulette-weight", ROULETTE, "survivors are not divided by the survival",
            { roulette_weight: |_| 1.0 }, "furnace/path/albedo-0.75", "furnace/path/early", "furnace/report/absorption-0.1",
            "furnace/mirrors/hall", "furnace/mirrors/facing", "furnace/cavity/policies: survival 0.9",
            "furnace/mirrors/infinite-variance: values of the law",
            "furnace/mirrors/infinite-variance: radiance", "glass/cube-outside", "images/white-furnace"),
        fault!("roulette-flipped", ROULETTE, "survives if r ≥ survival",
            { survives: |r, q| r >= q }, "furnace/path/albedo-0.9",
            "furnace/mirrors/infinite-variance: values of the law"),
        fault!("roulette-other-share", ROULETTE, "divides by α for 1 − α",
            { roulette_weight: |q| 1.0 / (1.0 - q) }, "furnace/sky/path"),
        fault!("number-not-rescaled", ROULETTE, "the number that decided a game decides the next one as it is",
            { rescaled: |r, _| r }, "furnace/path/albedo-0.75"),
        fault!("weight-of-one-policy", ROULETTE, "survivors are divided by 0.9 whatever the survival was",
            { roulette_weight: |_| 1.0 / 0.9 }, "furnace/cavity/policies: survival 1 − α"),
        fault!("sum-of-four-rays", ESTIMATOR, "the sum of N = 4 sample rays, without 1/N",
            { roulette_weight: |q| 4.0 * roulette::weight(q) }, "furnace/report/rays-4"),
        fault!("black-holes", ROULETTE,
            "survival 0 where the throughput is below 0.3: light is lost with the path",
            { survival_by_throughput: |t, _| if t.max_element() < 0.6 { 0.0 } else { t.max_element().min(0.95) } },
            "furnace/path/albedo-0.5"),
    ]
}
