//! A sampler on trial: do its directions have the density that it claims?
//!
//! It needs the harness alone: `cargo run -p whitefurnace --no-default-features --example sampler`.

use std::f64::consts::TAU;

use whitefurnace::harness::chi_square::sampler_against_partition;
use whitefurnace::harness::domain::{Domain, Partition};
use whitefurnace::harness::outcome::{Outcome, Verdict};
use whitefurnace::sampling::rng::{seed_for, stream, uniform2};

/// Samples directions by their cosine, as Malley does: a uniform point of the unit disk is
/// projected up to the hemisphere.
fn malley([u, v]: [f64; 2]) -> [f64; 3] {
    projected(u.sqrt(), TAU * v)
}

/// Forgets the square root, so that points crowd at the centre of the disk.
fn without_root([u, v]: [f64; 2]) -> [f64; 3] {
    projected(u, TAU * v)
}

/// Returns the direction above a point of the unit disk.
fn projected(radius: f64, azimuth: f64) -> [f64; 3] {
    let (sin, cos) = azimuth.sin_cos();
    [
        radius * cos,
        radius * sin,
        (1.0 - radius * radius).max(0.0).sqrt(),
    ]
}

/// Counts directions in twelve cells that are equally probable under the density cos θ/π, and
/// tests the counts by Pearson's chi-square.
fn on_trial(name: &str, sampler: fn([f64; 2]) -> [f64; 3]) -> Outcome {
    let cells = Partition::equal(Domain::CosineHemisphere, 3, 4);
    let mut rng = stream(seed_for(2019, name), 0, 0);
    sampler_against_partition(name, &cells, 2_000_000, || {
        Some(sampler(uniform2(&mut rng)))
    })
}

fn main() {
    let right = on_trial("Malley's method", malley);
    println!("{right}\n");
    let wrong = on_trial("Malley's method without the root", without_root);
    println!("{wrong}");

    assert_eq!(right.verdict(), Verdict::Holds);
    assert_eq!(wrong.verdict(), Verdict::Fails);
    println!("\nverdict: the sampler holds, and the one without the root is rejected");
}
