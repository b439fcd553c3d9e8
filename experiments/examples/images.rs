//! Two renderers on trial: do their images agree, pixel by pixel and on the whole?
//!
//! `cargo run --example images`. The images are those of this library, but the comparison takes any
//! slices of numbers; for files there is `cargo run --bin compare`.

use whitefurnace::error::Error;
use whitefurnace::film::Film;
use whitefurnace::harness::images::{Comparison, Rules, Side, compare};
use whitefurnace::harness::outcome::Verdict;
use whitefurnace::integrator::{Path, Strategy};
use whitefurnace::render::render;
use whitefurnace::sampling::Sampling;
use whitefurnace::sampling::pixel::PixelSampling;
use whitefurnace::sampling::sampler::SamplerKind;
use whitefurnace::scene::simple::cornell;

/// Width and height, pixels.
const SIZE: [u32; 2] = [32, 32];
/// Number of images of each renderer.
const IMAGES: u64 = 16;

/// Renders independent images of Cornell's box, and returns the green channel of each.
fn images(renderer: &Path, seeds: std::ops::Range<u64>) -> Result<Vec<Vec<f64>>, Error> {
    let scene = cornell()?;
    seeds
        .map(|seed| {
            let sampling = Sampling {
                pixel: PixelSampling::Random,
                sampler: SamplerKind::Independent,
                seed,
                silhouettes: false,
            };
            let mut film = Film::new(SIZE, None, 1)?;
            render(&scene, renderer, sampling, &mut film, &(0..64), &|_| true)?;
            Ok(film.pixels().iter().map(|pixel| pixel.mean().y).collect())
        })
        .collect()
}

/// Compares the images of two renderers, and prints how their means differ.
fn on_trial(name: &str, a: &[Vec<f64>], b: &[Vec<f64>]) -> Comparison {
    let [a, b] = [a, b].map(|images| Side::Images(images.iter().map(Vec::as_slice).collect()));
    let rules = Rules {
        margin: 0.05,
        ..Rules::default()
    };
    let comparison = compare(SIZE[0] as usize, &[[a, b]], &rules);
    println!("{name}: {}", comparison.verdict.word());
    for kind in &comparison.kinds {
        println!(
            "  {:<10} {} of {} differ",
            kind.name,
            kind.rejected().count(),
            kind.tests.len()
        );
    }
    comparison
}

fn main() -> Result<(), Error> {
    // Shadow rays to the lamp, and rays that find it by themselves, weighted against each other.
    let reference = Path::new(Strategy::Light);
    let renderer = Path::new(Strategy::Mis);
    // The same with at most two reflections: the corners are too dark.
    let wrong = Path {
        bounces: Some(2),
        ..renderer
    };
    let [reference, renderer, wrong] = [
        images(&reference, 0..IMAGES)?,
        images(&renderer, IMAGES..2 * IMAGES)?,
        images(&wrong, 2 * IMAGES..3 * IMAGES)?,
    ];
    let right = on_trial("with all reflections", &renderer, &reference);
    let wrong = on_trial("with two reflections", &wrong, &reference);

    assert_eq!(right.verdict, Verdict::Holds);
    assert_eq!(wrong.verdict, Verdict::Fails);
    println!("\nverdict: the two agree, and the one that stops too early is rejected");
    Ok(())
}
