//! Hemisphere samplers against their claimed densities: a map of residuals for each.

use whitefurnace::harness::tails::chi_square_sf;
use whitefurnace::sampling::warp::{cosine_hemisphere_inverse, uniform_hemisphere_inverse};

use crate::experiments::prelude::*;

/// Cells of azimuth and of inclination.
const CELLS: [usize; 2] = [32, 16];

/// A claimed density: its cumulative probability below a direction's inclination, and the azimuth
/// in turns. Both are uniform if the claim is right, so that cells of equal size have equal
/// probability. The text labels the axis of the former.
type Density = (fn(DVec3) -> [f64; 2], &'static str);

const UNIFORM: Density = (uniform_hemisphere_inverse, "1 − cos θ");
const COSINE: Density = (cosine_hemisphere_inverse, "sin² θ");

type Sampler = fn(&mut Stream) -> DVec3;

/// Samplers: names in titles and in keys, claimed densities, and whether the claims are right.
const SAMPLERS: [(&str, &str, Sampler, Density, bool); 3] = [
    (
        "Uniform, two numbers",
        "uniform",
        |rng| uniform_hemisphere(uniform2(rng)),
        UNIFORM,
        true,
    ),
    (
        "Cosine-weighted",
        "cosine",
        |rng| cosine_hemisphere(uniform2(rng)),
        COSINE,
        true,
    ),
    (
        "As printed, one number",
        "printed",
        |rng| hemisphere_printed(uniform(rng)),
        UNIFORM,
        false,
    ),
];

/// Bound of the scale for correct samplers, standard deviations.
const BOUND: f64 = 4.0;

/// Plots standardised residuals of equally probable cells.
pub fn residuals(run: &mut Run, file: &str) -> Result<(), Error> {
    let cells = CELLS[0] * CELLS[1];
    let expected = run.count(run.by_tier(200, 20_000)) as f64;
    let n = expected as u64 * cells as u64;
    run.numbers(
        "residuals",
        [
            ("samples", n as f64),
            ("expected", expected),
            ("cells", cells as f64),
        ],
    );
    let mut panels = Vec::new();
    for (title, name, sample, (place, share), right) in SAMPLERS {
        let mut rng = stream(seed_for(run.seed(), &format!("residuals {name}")), 0, 0);
        let mut counts = vec![0_u64; cells];
        for _ in 0..n {
            counts[cell(place(sample(&mut rng)))] += 1;
        }
        let values: Vec<f64> = counts
            .iter()
            .map(|&count| (count as f64 - expected) / expected.sqrt())
            .collect();
        let statistic: f64 = values.iter().map(|r| r * r).sum();
        let p = chi_square_sf(statistic, cells as f64 - 1.0);
        let worst = values.iter().fold(0.0_f64, |worst, r| worst.max(r.abs()));
        run.numbers(
            &format!("residuals.{name}"),
            [("chi_square", statistic), ("p", p), ("worst", worst)],
        );
        let verdict = if right {
            "agrees with"
        } else {
            "is rejected by"
        };
        let level = FAMILYWISE_LEVEL / SAMPLERS.len() as f64;
        let value = format!(
            "{verdict} its density: chi-square {statistic:.1} of {} degrees of freedom, p = {p:.2e}, \
             greatest residual {worst:.1} standard deviations",
            cells - 1
        );
        run.claim(&format!("residuals, {title}"), value, (p >= level) == right);
        // An empty cell has the full colour of the faulty sampler's scale.
        let (bound, scale) = if right {
            (BOUND, format!("scale ±{BOUND} σ"))
        } else {
            let empty = expected.sqrt().round();
            (empty, format!("own scale, cut at ±{empty} σ"))
        };
        panels.push(Map {
            title: format!("{title}: greatest residual {worst:.1} σ ({scale})"),
            axes: ["azimuth φ (turns)".into(), share.into()],
            ranges: [[0.0, 1.0]; 2],
            size: CELLS.map(|n| n as u32),
            values,
            bound,
            unit: "residual (σ)".into(),
        });
    }
    let description = "Noise without a pattern in the first two panels; in the third all directions lie on a diagonal.";
    maps(run, file, description, [900, 1050], 1, &panels)
}

/// Returns the index of a cell, row by row from the horizon, which is at the top, to the pole.
fn cell([share, turns]: [f64; 2]) -> usize {
    let at = |x: f64, n: usize| ((x * n as f64) as usize).min(n - 1);
    (CELLS[1] - 1 - at(share, CELLS[1])) * CELLS[0] + at(turns, CELLS[0])
}
