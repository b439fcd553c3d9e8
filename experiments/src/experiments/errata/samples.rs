//! Directions and rays of a pixel: the samples of sections 2.6 and 2.7, and their variance.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, TAU};

use whitefurnace::harness::quadrature::{Rectangle, integrate};
use whitefurnace::sampling::warp::{cosine_hemisphere_pdf, uniform_hemisphere_pdf};

use super::size;
use crate::experiments::prelude::*;

/// (18) and (19) with one r: the mean of x and y, which should be 0.
pub(super) fn one_number(run: &mut Run) {
    for (axis, name) in ["x", "y"].into_iter().enumerate() {
        let mean = along(|r| hemisphere_printed(r)[axis]);
        size(
            run,
            &format!("one_number.{name}"),
            mean,
            "is the mean of that coordinate of directions by one r",
        );
    }
}

/// Radiance as a function of the cosine of its direction.
type Radiance = fn(f64) -> f64;

const PROFILES: [(&str, Radiance); 4] = [
    ("constant", |_| 1.0),
    ("cosine", |c| c),
    ("horizon", |c| 1.0 - c),
    ("band", |c| f64::from(u8::from(c < 0.1))),
];

/// 2.6.1, half corrected: uniform directions, divided by the pdf of cosine-weighted ones.
pub(super) fn mixed(run: &mut Run) {
    for (name, radiance) in &PROFILES[..3] {
        let found = along(radiance);
        let right = along(|c| 2.0 * c * radiance(c));
        let what = "relative error of uniform directions with the density of cosine-weighted ones";
        size(run, &format!("mixed.{name}"), found / right - 1.0, what);
    }
}

/// 2.6.1: variance of one sample of ∫ L cos θ dω, uniform against cosine-weighted directions.
pub(super) fn importance(run: &mut Run) {
    for (name, radiance) in PROFILES {
        let variance = |pdf: fn(f64) -> f64| {
            // dω = 2π d(cos θ). Split at the band's border, where the profile jumps.
            let over = |power: i32| {
                let part = |from: f64, to: f64| {
                    along(|r| {
                        let c = from + r * (to - from);
                        TAU * (to - from)
                            * pdf(c)
                            * (radiance(c) * c * FRAC_1_PI / pdf(c)).powi(power)
                    })
                };
                part(0.0, 0.1) + part(0.1, 1.0)
            };
            over(2) - over(1).powi(2)
        };
        let [uniform, cosine] = [
            variance(uniform_hemisphere_pdf),
            variance(cosine_hemisphere_pdf),
        ];
        let what = "is the variance by uniform directions";
        size(run, &format!("importance.{name}.uniform"), uniform, what);
        let what = "is the variance by cosine-weighted directions";
        size(
            run,
            &format!("importance.{name}.cosine"),
            cosine.max(0.0),
            what,
        );
    }
}

/// 2.7: mean squared error of a pixel with 16 rays, cut by a straight edge of any slope.
pub(super) fn slanted_edges(run: &mut Run) {
    let edges = run.count(run.by_tier(100_000, 2_000_000));
    for (name, strategy) in [
        ("grid", PixelSampling::Grid(4)),
        ("jittered", PixelSampling::Jitter(4)),
        ("random", PixelSampling::Random),
    ] {
        let mut rng = stream(seed_for(run.seed(), &format!("errata {name}")), 0, 0);
        let mut errors = Moments::default();
        for _ in 0..edges {
            let (b, a) = (FRAC_PI_2 * uniform(&mut rng)).sin_cos();
            let [x, y] = uniform2(&mut rng);
            let c = a * x + b * y;
            // The part of the unit square where a x + b y < c.
            let square = |length: f64| length.max(0.0).powi(2);
            let area =
                (square(c) - square(c - a) - square(c - b) + square(c - a - b)) / (2.0 * a * b);
            let inside = (0..16).filter(|&i| {
                let [x, y] = strategy.position(i, uniform2(&mut rng));
                a * x + b * y < c
            });
            errors.push((inside.count() as f64 / 16.0 - area).powi(2));
        }
        let what = "is the mean squared error of 16 rays for edges of any slope";
        size(run, &format!("slanted.{name}"), errors.mean(), what);
    }
    size(
        run,
        "upright.grid",
        0.5 / 4.0,
        "is the largest error of a 4 × 4 grid for an upright edge",
    );
}

/// Returns ∫ f(r) dr over [0, 1].
fn along(f: impl Fn(f64) -> f64) -> f64 {
    integrate(
        Rectangle {
            x: [0.0, 1.0],
            y: [0.0, 1.0],
        },
        1e-12,
        &mut |x, _| f(x),
    )
    .value
}
