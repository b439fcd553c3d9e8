//! Faults of sampling: directions (17)-(19), cosine-weighted directions, roulette.

use crate::equation::{
    COSINE_HEMISPHERE, ESTIMATOR, HEMISPHERE_PDF, HEMISPHERE_PHI, HEMISPHERE_THETA, ROULETTE,
};
use crate::roulette;
use crate::sampling::{cosine_hemisphere, uniform_hemisphere, uniform_hemisphere_pdf};
use crate::trials::hemisphere::faults::{
    half_circle, half_circle_cosine, linear_theta, no_root, shared_number,
};
use crate::trials::subject::{RIGHT, Subject, Table, parts};
use crate::zoo::{Mutant, mutant};

pub(super) fn faults() -> Vec<Mutant<Subject>> {
    vec![
        mutant(
            "uniform-for-cosine",
            &COSINE_HEMISPHERE,
            "uniform directions with the cosine pdf's weight",
            parts(Table {
                cosine_hemisphere: uniform_hemisphere,
                ..RIGHT
            }),
            &["irradiance/hits-alone"],
        ),
        mutant(
            "cosine-no-root",
            &COSINE_HEMISPHERE,
            "sin θ = r for sin θ = √r",
            parts(Table {
                cosine_hemisphere: no_root,
                ..RIGHT
            }),
            &["furnace/sky/path"],
        ),
        mutant(
            "cosine-half-circle",
            &COSINE_HEMISPHERE,
            "φ over half the circle",
            parts(Table {
                cosine_hemisphere: half_circle_cosine,
                ..RIGHT
            }),
            &["furnace/sky/path"],
        ),
        mutant(
            "shared-number",
            &HEMISPHERE_PHI,
            "one random number in (18) and (19)",
            parts(Table {
                uniform_hemisphere: shared_number,
                ..RIGHT
            }),
            &["furnace/sky/report"],
        ),
        mutant(
            "half-circle",
            &HEMISPHERE_PHI,
            "φ = πr for 2πr",
            parts(Table {
                uniform_hemisphere: half_circle,
                ..RIGHT
            }),
            &["furnace/sky/report"],
        ),
        mutant(
            "linear-theta",
            &HEMISPHERE_THETA,
            "θ = rπ/2",
            parts(Table {
                uniform_hemisphere: linear_theta,
                ..RIGHT
            }),
            &["furnace/sky/report"],
        ),
        mutant(
            "cosine-for-uniform",
            &HEMISPHERE_THETA,
            "cosine-weighted directions with the weight of (17)",
            parts(Table {
                uniform_hemisphere: cosine_hemisphere,
                ..RIGHT
            }),
            &["furnace/report/absorption-0.25"],
        ),
        mutant(
            "pdf-twice",
            &HEMISPHERE_PDF,
            "p = 1/π",
            parts(Table {
                uniform_hemisphere_pdf: |cos| 2.0 * uniform_hemisphere_pdf(cos),
                ..RIGHT
            }),
            &[
                "furnace/report/absorption-0.25",
                "furnace/report/seven-segments",
                "furnace/sky/report",
                "images/diffuse-room: image mean",
                "images/diffuse-room: p-values of pixels",
            ],
        ),
        mutant(
            "no-roulette-weight",
            &ROULETTE,
            "survivors are not divided by the survival",
            parts(Table {
                roulette_weight: |_| 1.0,
                ..RIGHT
            }),
            &[
                "furnace/path/albedo-0.75",
                "furnace/report/absorption-0.1",
                "furnace/mirrors/hall",
                "furnace/mirrors/facing",
                "furnace/cavity/policies: survival 0.9",
                "furnace/mirrors/infinite-variance: values of the law",
                "furnace/mirrors/infinite-variance: radiance",
                "glass/cube-outside",
                "images/white-furnace",
            ],
        ),
        mutant(
            "roulette-flipped",
            &ROULETTE,
            "survives if r ≥ survival",
            parts(Table {
                survives: |r, q| r >= q,
                ..RIGHT
            }),
            &[
                "furnace/path/albedo-0.9",
                "furnace/mirrors/infinite-variance: values of the law",
            ],
        ),
        mutant(
            "roulette-other-share",
            &ROULETTE,
            "divides by α for 1 − α",
            parts(Table {
                roulette_weight: |q| 1.0 / (1.0 - q),
                ..RIGHT
            }),
            &["furnace/sky/path"],
        ),
        mutant(
            "weight-of-one-policy",
            &ROULETTE,
            "survivors are divided by 0.9 whatever the survival was",
            parts(Table {
                roulette_weight: |_| 1.0 / 0.9,
                ..RIGHT
            }),
            &["furnace/cavity/policies: survival 1 − α"],
        ),
        mutant(
            "sum-of-four-rays",
            &ESTIMATOR,
            "the sum of N = 4 sample rays, without 1/N",
            parts(Table {
                roulette_weight: |q| 4.0 * roulette::weight(q),
                ..RIGHT
            }),
            &["furnace/report/rays-4"],
        ),
        mutant(
            "black-holes",
            &ROULETTE,
            "survival 0 where the throughput is below 0.6: light is lost with the path",
            parts(Table {
                survival_by_throughput: |t| {
                    let q = t.max_element();
                    if q < 0.6 { 0.0 } else { q.min(0.95) }
                },
                ..RIGHT
            }),
            &["furnace/path/albedo-0.5"],
        ),
    ]
}
