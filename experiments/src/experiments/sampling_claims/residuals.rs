//! Hemisphere samplers against the densities that they claim: a map of residuals for each.

use whitefurnace::harness::tails::chi_square_sf;
use whitefurnace::sampling::{cosine_hemisphere_inverse, uniform_hemisphere_inverse};

use crate::experiments::prelude::*;

/// Cells of azimuth and of inclination.
const CELLS: [usize; 2] = [32, 16];

/// A sampler on trial.
struct Sampler {
    /// In the titles.
    title: &'static str,
    /// In the keys.
    name: &'static str,
    /// A direction.
    sample: fn(&mut Stream) -> DVec3,
    /// The share of its claimed density below a direction's inclination, and the azimuth in turns: both are
    /// uniform if the claim is right, so that cells of equal size have equal probability.
    cell: fn(DVec3) -> [f64; 2],
    /// How the axis names that share.
    share: &'static str,
    /// Whether the claim is right.
    right: bool,
}

const SAMPLERS: [Sampler; 3] = [
    Sampler {
        title: "Uniform, two numbers",
        name: "uniform",
        sample: |rng| uniform_hemisphere(uniform2(rng)),
        cell: uniform_hemisphere_inverse,
        share: "1 − cos θ",
        right: true,
    },
    Sampler {
        title: "Cosine-weighted",
        name: "cosine",
        sample: |rng| cosine_hemisphere(uniform2(rng)),
        cell: cosine_hemisphere_inverse,
        share: "sin² θ",
        right: true,
    },
    Sampler {
        title: "As printed, one number",
        name: "printed",
        sample: |rng| hemisphere_printed(uniform(rng)),
        cell: uniform_hemisphere_inverse,
        share: "1 − cos θ",
        right: false,
    },
];

/// Bound of the scale for samplers that are right, standard deviations.
const BOUND: f64 = 4.0;

/// Standardised residuals of equally probable cells.
pub fn residuals(run: &mut Run, file: &str) -> Result<(), Error> {
    let cells = CELLS[0] * CELLS[1];
    let expected = run.count(run.by_tier(200, 20_000)) as f64;
    let n = expected as u64 * cells as u64;
    run.numbers("residuals", [("samples", n as f64), ("expected", expected), ("cells", cells as f64)]);
    let mut panels = Vec::new();
    for sampler in &SAMPLERS {
        let mut rng = stream(seed_for(run.seed(), &format!("residuals {}", sampler.name)), 0, 0);
        let mut counts = vec![0_u64; cells];
        for _ in 0..n {
            counts[cell((sampler.cell)((sampler.sample)(&mut rng)))] += 1;
        }
        let values: Vec<f64> = counts.iter().map(|&count| (count as f64 - expected) / expected.sqrt()).collect();
        let statistic: f64 = values.iter().map(|r| r * r).sum();
        let p = chi_square_sf(statistic, cells as f64 - 1.0);
        let worst = values.iter().fold(0.0_f64, |worst, r| worst.max(r.abs()));
        let numbers = [("chi_square", statistic), ("p", p), ("worst", worst)];
        run.numbers(&format!("residuals.{}", sampler.name), numbers);
        let verdict = if sampler.right { "agrees with" } else { "is rejected by" };
        let level = FAMILY / SAMPLERS.len() as f64;
        let value = format!(
            "{verdict} its density: chi-square {statistic:.1} of {} degrees of freedom, p = {p:.2e}, \
             greatest residual {worst:.1} standard deviations",
            cells - 1
        );
        run.claim(&format!("residuals, {}", sampler.title), value, (p >= level) == sampler.right);
        // An empty cell has the full colour of the faulty sampler's scale.
        let (bound, scale) = if sampler.right {
            (BOUND, format!("scale ±{BOUND} σ"))
        } else {
            let empty = expected.sqrt().round();
            (empty, format!("own scale, cut at ±{empty} σ"))
        };
        panels.push(Map {
            title: format!("{}: greatest residual {worst:.1} σ ({scale})", sampler.title),
            axes: ["azimuth φ (turns)".into(), sampler.share.into()],
            ranges: [[0.0, 1.0]; 2],
            size: CELLS.map(|n| n as u32),
            values,
            bound,
            unit: "residual (σ)".into(),
        });
    }
    let see = "Noise without a pattern in the first two panels; in the third all directions lie on a diagonal.";
    maps(&run.figure(file), see, [900, 1050], 1, &panels)
}

/// The place of a cell, row by row from the horizon, which is at the top, to the pole.
fn cell([share, turns]: [f64; 2]) -> usize {
    let at = |x: f64, n: usize| ((x * n as f64) as usize).min(n - 1);
    (CELLS[1] - 1 - at(share, CELLS[1])) * CELLS[0] + at(turns, CELLS[0])
}
