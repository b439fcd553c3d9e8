//! Reference values for the scripts of the explorables (`pages/explore`): each page that uses these
//! scripts compares its own functions with the library's values, and says so.

use serde_json::{Value, json};
use trials::hemisphere::faults::linear_theta;
use trials::roulette;
use whitefurnace::glam::DVec3;
use whitefurnace::harness::chi_square::{chi_square, count};
use whitefurnace::harness::domain::{Domain, Partition};
use whitefurnace::harness::outcome::ALPHA;
use whitefurnace::harness::tails::{chi_square_sf, normal_upper};
use whitefurnace::math::moments::Moments;
use whitefurnace::sampling::rng::{stream, uniform, uniform2};
use whitefurnace::sampling::warp::*;

/// Largest distance of a script's value from the library's, relative to the library's.
const BOUND: f64 = 1e-12;
/// Seed of the samples that are compared.
const SEED: u64 = 46;
/// Samples of a comparison: enough that no cell of the chi-square test is pooled.
const SAMPLES: u64 = 20_000;
/// Rings and sectors of the chi-square test, as in the script.
const CELLS: [usize; 2] = [5, 9];

type Sampler = fn([f64; 2]) -> DVec3;

const SAMPLERS: [(&str, Sampler); 4] = [
    ("uniform", uniform_hemisphere),
    ("cosine", cosine_hemisphere),
    ("printed", |[r, _]| hemisphere_printed(r)),
    ("linear", linear_theta),
];

/// A density that a sampler may claim.
struct Density {
    name: &'static str,
    pdf: fn(f64) -> f64,
    inverse: fn(DVec3) -> [f64; 2],
    domain: Domain,
}

const DENSITIES: [Density; 2] = [
    Density {
        name: "uniform",
        pdf: uniform_hemisphere_pdf,
        inverse: uniform_hemisphere_inverse,
        domain: Domain::Hemisphere,
    },
    Density {
        name: "cosine",
        pdf: cosine_hemisphere_pdf,
        inverse: cosine_hemisphere_inverse,
        domain: Domain::CosineHemisphere,
    },
];

/// Returns the script that defines `reference`: the bound, the level of the trials, and cases of
/// function, arguments and value. An infinite value is `null`.
pub fn reference() -> String {
    let cases: Vec<Value> = [numbers(), warps(), tails(), samplers(), walks()].concat();
    let reference = json!({
        "bound": BOUND,
        "level": ALPHA,
        "sigmas": normal_upper(ALPHA / 2.0),
        "cases": cases,
    });
    format!("globalThis.reference = {reference};\n")
}

fn numbers() -> Vec<Value> {
    let streams = [(0, 0, 0), (SEED, 1, 2), (u64::from(u32::MAX), 3, u32::MAX)];
    streams
        .map(|(seed, high, low)| {
            let mut rng = stream(seed, high, low);
            let values: Vec<f64> = (0..16).map(|_| uniform(&mut rng)).collect();
            json!(["uniforms", [seed, high, low, 16], values])
        })
        .into()
}

/// Evaluates samplers, pdfs and inverses over a grid of random numbers.
fn warps() -> Vec<Value> {
    let grid = [0.001, 0.1, 0.3, 0.49, 0.62, 0.8, 0.97];
    let random = grid.into_iter().flat_map(|r1| grid.map(|r2| [r1, r2]));
    let at = |random: [f64; 2]| {
        let mut cases = Vec::new();
        for (name, sampler) in SAMPLERS {
            let w = sampler(random);
            cases.push(json!(["direction", [name, random], w.to_array()]));
            for Density {
                name, pdf, inverse, ..
            } in &DENSITIES
            {
                cases.push(json!(["pdf", [name, w.z], pdf(w.z)]));
                cases.push(json!(["inverse", [name, w.to_array()], inverse(w)]));
            }
        }
        cases
    };
    random.flat_map(at).collect()
}

/// Evaluates p-values from 1 to 1e-290.
fn tails() -> Vec<Value> {
    let degrees = [2.0, 8.0, (CELLS[0] * CELLS[1] - 1) as f64, 128.0];
    let case = |dof: f64| {
        [0.1, 0.5, 1.0, 1.5, 3.0, 6.0, 9.0].map(|times| {
            json!([
                "chiSquareTail",
                [times * dof, dof],
                chi_square_sf(times * dof, dof)
            ])
        })
    };
    degrees.into_iter().flat_map(case).collect()
}

/// Tests every sampler against every density as the trials do: chi-square, its p-value, and mean
/// and standard error in three environments.
fn samplers() -> Vec<Value> {
    let environments: [fn(DVec3) -> f64; 3] = [|_| 1.0, |w| w.z, |w| 1.0 + w.y];
    let case = |name: &str, sampler: Sampler, density: &Density| {
        let mut moments = [Moments::default(); 3];
        let mut rng = stream(SEED, 0, 0);
        let sample = || {
            let w = sampler(uniform2(&mut rng));
            for (moments, radiance) in moments.iter_mut().zip(environments) {
                moments.push(radiance(w) * cosine_hemisphere_pdf(w.z) / (density.pdf)(w.z));
            }
            Some(w)
        };
        let partition = Partition::equal(density.domain, CELLS[0], CELLS[1]);
        let counts = count(&partition, SAMPLES, sample, |_| true);
        let outcome = chi_square(name, &partition, &counts, 1.0);
        let mut values = vec![outcome.value, outcome.p];
        values.extend(moments.iter().flat_map(|m| [m.mean(), m.standard_error()]));
        json!([
            "hemisphereNumbers",
            [name, density.name, SEED, SAMPLES],
            values
        ])
    };
    let pairs = SAMPLERS
        .into_iter()
        .flat_map(|sampler| DENSITIES.iter().map(move |density| (sampler, density)));
    pairs
        .map(|((name, sampler), density)| case(name, sampler, density))
        .collect()
}

/// Evaluates mean and variance of roulette over a grid, and walks.
fn walks() -> Vec<Value> {
    let mut cases = Vec::new();
    for a in [0.1, 0.25, 0.5, 0.75, 0.9] {
        cases.push(json!(["mean", [a], 1.0 / (1.0 - a)]));
        for q in [0.05, 0.25, 0.5, 0.6, 0.75, 0.9, 0.95] {
            cases.push(json!(["variance", [a, q], roulette::variance(a, q)]));
            let mut rng = stream(SEED, 0, 0);
            let walk = |_| roulette::walk(&mut rng, roulette::CORRECT, a, q);
            let moments: Moments = (0..500).map(walk).collect();
            let found = [moments.mean(), moments.standard_error()];
            cases.push(json!(["walks", [a, q, SEED, 500], found]));
        }
    }
    cases
}
