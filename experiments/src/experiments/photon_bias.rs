//! Bias of photon lookups against their radius, and of the mean of passes against their number.

use trials::photon::scenes::{at_point, disc_average, over_floor, point_camera, ray_to_origin};
use whitefurnace::integrator::{ImageEstimator, radius_squared};
use whitefurnace::sampling::sampler::ImagePass;

use crate::experiments::prelude::*;

pub(super) const PHOTON_BIAS: Experiment = Experiment {
    id: "photon-bias",
    title: "bias of photon lookups against radius, and of progressive passes against their number",
    headline: "bias of a photon lookup grows as its radius to the power {radius.slope %.2f}",
    version: 1,
    equations: &[&equation::PHOTON_DENSITY, &equation::PHOTON_RADIUS],
    run,
};

const RADII: [f64; 7] = [0.04, 0.08, 0.12, 0.2, 0.35, 0.7, 1.5];
/// Indices of the radii between which the slope is measured: the next order of the bias is small
/// there, and the noise is, too.
const SLOPE: [usize; 2] = [2, 3];
/// Particles of a map or pass.
const PARTICLES: u32 = 1000;
const PASSES: u32 = 64;
/// Radius of the first pass.
const FIRST: f64 = 0.2;
/// Least number of replications that estimate a spread.
const MIN_COUNT: u64 = 8;

fn run(run: &mut Run) -> Result<(), Error> {
    let radii = radii(run)?;
    let passes = passes(run)?;
    let description = "Measured biases lie on their closed forms: they fall with the square of the radius, and slowly \
               with the number of passes.";
    charts(run, "photon-bias.svg", description, 860, &[radii, passes])
}

/// Returns the allowed distance of the mean of replications from its expectation, at the
/// experiment's family-wise level.
fn half_width(moments: &Moments, family: usize) -> f64 {
    student_upper(
        FAMILYWISE_LEVEL / family as f64 / 2.0,
        moments.count() as f64 - 1.0,
    ) * moments.standard_error()
}

/// Plots the relative bias −(1 − L_r/L) of lookups at one point, for each radius.
fn radii(run: &mut Run) -> Result<Chart, Error> {
    let scene = over_floor();
    let point = at_point();
    let maps = run.count(run.by_tier(1_000, 40_000)).max(MIN_COUNT) as u32;
    let mut found = Vec::new();
    let mut rows = Vec::new();
    for radius in RADII {
        let seed = seed_for(run.seed(), &format!("radius {radius}"));
        let values = parallel_map(0..maps, |index| looked_up(&scene, radius, seed, index))?;
        let moments = values.into_iter().collect::<Result<Moments, Error>>()?;
        let expected = disc_average(radius, f64::INFINITY);
        let bias = 1.0 - moments.mean() / point;
        let half = half_width(&moments, RADII.len() + 1) / point;
        let closed = 1.0 - expected / point;
        let value = format!(
            "bias {:+.5} ± {half:.5}, closed form {:+.5}",
            -bias, -closed
        );
        run.claim(
            &format!("radius {radius}"),
            value,
            (bias - closed).abs() <= half,
        );
        rows.push(format!("{radius},{bias:e},{closed:e},{half:e}"));
        found.push((radius, bias, closed, half));
    }
    let [a, b] = SLOPE.map(|i| found[i]);
    let span = (b.0 / a.0).ln();
    let slope = (b.1 / a.1).ln() / span;
    let error = (a.3 / a.1).hypot(b.3 / b.1) / span;
    let closed = (b.2 / a.2).ln() / span;
    run.number("radius.slope", slope);
    run.number("radius.slope_error", error);
    let what = format!("slope of the bias between radii {} and {}", a.0, b.0);
    let value = format!("{slope:.3} ± {error:.3}, closed form {closed:.3}, 2 for small radii");
    run.claim(&what, value, (slope - closed).abs() <= error);
    run.csv("radii.csv", "radius,bias,closed,reach", &rows)?;
    let measured = found
        .iter()
        .map(|&(radius, bias, _, half)| [radius, bias, half]);
    let [low, high] = [RADII[0], RADII[RADII.len() - 1]];
    let closed = (0..=200).map(|k| low * (high / low).powf(f64::from(k) / 200.0));
    let closed = closed.map(|r| [r, 1.0 - disc_average(r, f64::INFINITY) / point]);
    let series = vec![
        Series::new("closed form: mean over the disc", 2, Mark::Line, closed),
        Series::measured("measured", 0, measured),
    ];
    let title = "What a lookup lacks of the radiance at a point under a light";
    let axes = [
        "radius (the light, 0.4 wide, is 0.5 above the floor)",
        "relative bias",
    ];
    Ok(Chart::new(title, axes, [[0.03, 2.0], [1e-3, 1.5]], series).log([true, true]))
}

fn looked_up(scene: &Scene, radius: f64, seed: u64, index: u32) -> Result<f64, Error> {
    let photons = PhotonMapping::new(
        Parts::default(),
        scene,
        Lookup::DirectVisualization,
        PARTICLES,
        radius,
        ImagePass::independent(seed, index),
    )?;
    let ray = ray_to_origin();
    let mut rng = stream(seed, index, 0);
    Ok(photons
        .radiance(scene, &ray, scene.intersect(&ray), &mut rng)
        .x)
}

/// Plots bias and root-mean-square error of the mean of the first n passes.
fn passes(run: &mut Run) -> Result<Chart, Error> {
    let scene = point_camera();
    let point = at_point();
    let runs = run.count(run.by_tier(30, 1_000)).max(MIN_COUNT) as u32;
    let sppm = Sppm {
        parts: Parts::default(),
        particles: PARTICLES,
        radius: FIRST,
    };
    let seed = seed_for(run.seed(), "passes");
    // For each run the mean of the first n passes, for each n.
    let means = parallel_map(0..runs, |k| {
        let seed = seed_for(seed, &k.to_string());
        let mut sum = 0.0;
        let mean = |index| {
            sum += sppm.pass(&scene, [1, 1], seed, index)?[0].x;
            Ok(sum / f64::from(index + 1))
        };
        (0..PASSES).map(mean).collect()
    })?;
    let means = means
        .into_iter()
        .collect::<Result<Vec<Vec<f64>>, Error>>()?;
    let mut expected = 0.0;
    let mut rows = Vec::new();
    let (mut closed, mut bias, mut error) = (Vec::new(), Vec::new(), Vec::new());
    let mut worst = 0.0f64;
    let mut spreads = Vec::new();
    for index in 0..PASSES {
        let radius = radius_squared(FIRST * FIRST, index).sqrt();
        expected += disc_average(radius, f64::INFINITY);
        let n = f64::from(index + 1);
        let moments: Moments = means.iter().map(|means| means[index as usize]).collect();
        let rms: Moments = means
            .iter()
            .map(|means| (means[index as usize] / point - 1.0).powi(2))
            .collect();
        let found = 1.0 - moments.mean() / point;
        let stated = 1.0 - expected / n / point;
        let half = half_width(&moments, PASSES as usize) / point;
        worst = worst.max((found - stated).abs() / half);
        spreads.push(moments.variance().sqrt() / point);
        rows.push(format!(
            "{n},{found:e},{stated:e},{half:e},{:e}",
            rms.mean().sqrt()
        ));
        closed.push([n, stated]);
        // All of them would be too many to tell apart.
        if (index + 1).is_power_of_two() {
            bias.push([n, found, half]);
        }
        error.push([n, rms.mean().sqrt()]);
    }
    let value = format!("{worst:.2} of the reach of chance from the closed form at worst");
    run.claim("bias of the mean of passes", value, worst <= 1.0);
    let spread = (spreads[PASSES as usize - 1] / spreads[PASSES as usize / 8 - 1]).ln() / 8f64.ln();
    let [first, last] = [bias[0][1], bias[bias.len() - 1][1]];
    let last_error = error[error.len() - 1][1];
    run.numbers(
        "passes",
        [
            ("bias_first", first),
            ("bias_last", last),
            ("error_last", last_error),
        ],
    );
    run.number("passes.spread_slope", spread);
    let value = format!(
        "{PASSES} passes: bias {:+.4} (first pass {:+.4}), root-mean-square error {last_error:.4}; standard deviation \
         falls as n^{spread:.2} (theory −1/3)",
        -last, -first
    );
    run.note("error against passes", value);
    run.csv("passes.csv", "passes,bias,closed,reach,rms", &rows)?;
    let series = vec![
        Series::new("bias, closed form", 2, Mark::Line, closed),
        Series::measured("bias, measured", 0, bias),
        Series::new("root-mean-square error", 1, Mark::Line, error),
    ];
    let title = format!("The mean of n passes, first radius {FIRST}, α = 2/3");
    let ranges = [[0.9, f64::from(PASSES) * 1.1], [0.01, 0.5]];
    Ok(Chart::new(title, ["passes n", "relative error"], ranges, series).log([true, true]))
}
