//! Directions, their variances, interfaces and pixel strategies.

use trials::convergence::{PROFILES, Profile, squared_error};
use trials::hemisphere::Method;
use whitefurnace::material::fresnel::{reflectance, reflectance_p, reflectance_s};

use super::critical;
use crate::experiments::prelude::*;
use crate::plot::chart::rows;

/// Draws the directions of three samplers, seen from above.
pub fn hemispheres(run: &mut Run, file: &str) -> Result<(), Error> {
    type Sampler = fn(&mut Stream) -> DVec3;
    let samplers: [(&str, Sampler); 3] = [
        ("uniform, two numbers", |rng| {
            uniform_hemisphere(uniform2(rng))
        }),
        ("cosine-weighted", |rng| cosine_hemisphere(uniform2(rng))),
        ("as printed: one number r", |rng| {
            hemisphere_printed(uniform(rng))
        }),
    ];
    let panel = |(k, (title, sampler)): (usize, (&str, Sampler))| {
        let mut rng = stream(seed_for(run.seed(), title), 0, 0);
        let dots = (0..600).map(|_| {
            let w = sampler(&mut rng);
            [w.x, w.y]
        });
        let horizon = (0..=180).map(|i| {
            let (sin, cos) = f64::from(2 * i).to_radians().sin_cos();
            [cos, sin]
        });
        let series = vec![
            Series::new("", 6, Mark::Faint, horizon),
            Series::new("", k, Mark::Dots, dots),
        ];
        Chart::new(title, ["x", "y"], [[-1.05, 1.05]; 2], series)
    };
    let panels: Vec<Chart> = samplers.into_iter().enumerate().map(panel).collect();
    let description = "Uniform directions thicken towards the rim, cosine-weighted ones fill the disc evenly, those of the \
               printed formulas lie on a spiral.";
    rows(&run.figure(file), description, [1080, 348], 3, &panels)
}

/// Constant radiance, and a band at the horizon: profiles that the trials leave out because a ratio
/// is infinite or takes too many samples to judge finely.
const MORE: [Profile; 2] = [
    Profile {
        name: "1",
        light: "the same from all directions",
        radiance: |_| 1.0,
        mean: 1.0,
        uniform: 1.0 / 3.0,
        cosine: 0.0,
    },
    Profile {
        name: "band",
        light: "in a band at the horizon",
        radiance: |w| if w.z < 0.1 { 1.0 } else { 0.0 },
        mean: 0.01,
        uniform: 4.0 / 3.0 * 0.001 - 0.0001,
        cosine: 0.01 - 0.0001,
    },
];

/// Tests "Importance sampling reduces noise", which holds where light comes from above.
pub fn importance(run: &mut Run, file: &str) -> Result<(), Error> {
    let n = run.count(run.by_tier(200_000, 4_000_000));
    let mut series = Vec::new();
    let mut all_hold = true;
    let profiles: Vec<Profile> = PROFILES.into_iter().chain(MORE).collect();
    for (colour, label, method, cosine) in [
        (2, "uniform", Method::UNIFORM, false),
        (0, "cosine-weighted", Method::COSINE, true),
    ] {
        let (mut closed, mut found) = (Vec::new(), Vec::new());
        for (k, profile) in profiles.iter().enumerate() {
            let mut rng = stream(
                seed_for(run.seed(), &format!("{label} {}", profile.name)),
                0,
                0,
            );
            let squares: Moments = (0..n)
                .map(|_| (profile.estimate(method, uniform2(&mut rng)) - profile.mean).powi(2))
                .collect();
            let known = if cosine {
                profile.cosine
            } else {
                profile.uniform
            };
            let half = critical() * squares.standard_error();
            // Constant light has no variance at all; the rest is rounding.
            all_hold &= (squares.mean() - known).abs() <= half.max(1e-20);
            run.number(
                &format!("importance.{}.{label}", profile.name),
                squares.mean(),
            );
            let x = k as f64 + if cosine { 0.1 } else { -0.1 };
            if known > 0.0 {
                closed.push(Series::new(
                    "",
                    6,
                    Mark::Line,
                    [[x - 0.09, known], [x + 0.09, known]],
                ));
                found.push([x, squares.mean(), half]);
            }
        }
        series.push(Series::measured(label, colour, found));
        series.extend(closed);
    }
    let value = format!("{} profiles, {n} samples each", profiles.len());
    run.claim(
        "importance sampling: variances are their closed forms",
        value,
        all_hold,
    );
    let named = |(k, profile): (usize, &Profile)| format!("{k} is {}", profile.name);
    let names: Vec<String> = profiles.iter().enumerate().map(named).collect();
    for profile in &profiles {
        let ratio = profile.uniform / profile.cosine;
        let value = if ratio.is_finite() {
            format!("{ratio:.3}")
        } else {
            "no variance left".to_owned()
        };
        run.note(
            &format!("radiance {}: uniform over cosine variance", profile.name),
            value,
        );
    }
    let title = "Variance of one sample; closed forms as black bars; cosine leaves none of L = 1";
    let across = format!("profile of incoming radiance: {}", names.join(", "));
    let chart = Chart::new(
        title,
        [&across, "variance"],
        [[-0.5, 5.5], [1e-3, 10.0]],
        series,
    )
    .log([false, true]);
    let description = "For light from above cosine-weighted directions have less variance, for light from the horizon more.";
    charts(run, file, description, 500, &[chart])
}

/// Plots (10)-(12) into glass and out of it, with Brewster's and the critical angle.
pub fn fresnel(run: &mut Run, file: &str) -> Result<(), Error> {
    let panel = |title: &str, n1: f64, n2: f64, marks: &[f64]| {
        type Reflectance = fn(f64, f64, f64) -> f64;
        let curves: [(&str, Reflectance); 3] = [
            ("perpendicular (10)", reflectance_s),
            ("parallel (11)", reflectance_p),
            ("unpolarised (12)", reflectance),
        ];
        let series = curves.into_iter().enumerate().map(|(k, (label, r))| {
            Series::curve(label, k, [0.0, 90.0], 900, |degrees| {
                r(degrees.to_radians().cos(), n1, n2)
            })
        });
        let marks = marks
            .iter()
            .map(|&x| Series::new("", 6, Mark::Faint, [[x, 0.0], [x, 1.0]]));
        let axes = ["angle of incidence (degrees)", "reflectance"];
        Chart::new(
            title,
            axes,
            [[0.0, 90.0], [0.0, 1.02]],
            series.chain(marks).collect(),
        )
    };
    let brewster = 1.5f64.atan().to_degrees();
    let critical = (1.0f64 / 1.5).asin().to_degrees();
    run.numbers("fresnel", [("brewster", brewster), ("critical", critical)]);
    let title = format!("Air to glass, n = 1.5: Brewster {brewster:.2}°");
    let into = panel(&title, 1.0, 1.5, &[brewster]);
    let within = 90.0 - brewster;
    let title = format!("Glass to air: Brewster {within:.2}°, critical {critical:.2}°");
    let out = panel(&title, 1.5, 1.0, &[within, critical]);
    let description = "Parallel light is not reflected at Brewster's angle; from within, all light is beyond the critical one.";
    rows(&run.figure(file), description, [1080, 500], 2, &[into, out])
}

/// Tests "Combining supersampling and randomisation is best": the error of each strategy on edges,
/// against 1/(12N), 1/(6N) and 1/(6N^1.5).
pub fn edges(run: &mut Run, file: &str) -> Result<(), Error> {
    let n = run.count(run.by_tier(40_000, 400_000));
    type Strategy = fn(u32) -> PixelSampling;
    type Law = fn(f64) -> f64;
    let strategies: [(&str, Strategy, Law); 3] = [
        ("random", |_| PixelSampling::Random, |n| 1.0 / (6.0 * n)),
        ("grid", PixelSampling::Grid, |n| 1.0 / (12.0 * n)),
        ("jittered", PixelSampling::Jitter, |n| {
            1.0 / (6.0 * n.powf(1.5))
        }),
    ];
    const SIDES: [u32; 5] = [1, 2, 4, 8, 16];
    let mut series = Vec::new();
    let mut all_hold = true;
    for (colour, (label, strategy, law)) in strategies.into_iter().enumerate() {
        let mut found = Vec::new();
        for side in SIDES {
            let samples = side * side;
            let mut rng = stream(seed_for(run.seed(), label), samples, 0);
            let errors: Moments = (0..n)
                .map(|_| squared_error(&mut rng, strategy(side), samples))
                .collect();
            let half = critical() * errors.standard_error();
            all_hold &= (errors.mean() - law(f64::from(samples))).abs() <= half;
            run.number(&format!("edges.{label}.{samples}"), errors.mean());
            found.push([f64::from(samples), errors.mean(), half]);
        }
        let line = SIDES
            .map(|side| f64::from(side * side))
            .map(|n| [n, law(n)]);
        series.push(Series::measured(label, colour, found));
        series.push(Series::new("", colour, Mark::Line, line));
    }
    let value = format!("{n} edges for each of {} cases", 3 * SIDES.len());
    run.claim(
        "supersampling: errors on edges are their closed forms",
        value,
        all_hold,
    );
    let title = "Mean squared error of a pixel cut by an upright edge anywhere";
    let (axes, ranges) = (
        ["samples N", "mean squared error"],
        [[0.8, 400.0], [1e-5, 1.0]],
    );
    let chart = Chart::new(title, axes, ranges, series).log([true; 2]);
    let description = "Jittered samples gain faster with their number than random ones and grids.";
    charts(run, file, description, 500, &[chart])
}
