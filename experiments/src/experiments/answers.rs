//! Answers to the exercises of the book that need a run: its commands, and the numbers that they
//! give.

use ::trials::metamorphic::{FaultyParts, faults};
use clap::CommandFactory as _;
use whitefurnace::film::Pixel;
use whitefurnace::harness::images::Rules;

use crate::experiments::prelude::*;
use crate::render::command::Render;

pub(super) const ANSWERS: Experiment = Experiment {
    id: "answers",
    title: "answers to the book's exercises",
    headline: "answers to exercises: Whitted loses {whitted.red-wall %.0%} of the red wall, the furnace is {box.mean %.3f}, 4 samples decide nothing",
    version: 1,
    equations: &[
        &equation::RENDERING,
        &equation::ESTIMATOR,
        &equation::PATH_LENGTH,
    ],
    run,
};

/// Options of `render` in the answers, as on the pages; a test compares.
pub const COMMANDS: [&str; 11] = [
    "--estimator mis --size 128x96 --spp 256",
    "--estimator whitted --size 128x96 --spp 16",
    "--estimator bsdf --size 128x96 --spp 64 --sampler independent",
    "--estimator light --size 128x96 --spp 64 --sampler independent",
    "--estimator mis --size 128x96 --spp 64 --sampler independent",
    "--scene cornell --size 64x64 --spp 4",
    "--scene cornell --size 64x64 --spp 64",
    "--scene cornell --size 64x64 --spp 64 --seed 2",
    "--scene diffuse-room --size 64x48 --spp 64",
    "--scene diffuse-room --size 64x48 --spp 64 --precision single",
    "--scene furnace-box --size 32x32 --spp 64 --sampler independent",
];

/// Renders a command of [`COMMANDS`], perhaps with another seed.
fn rendered(run: &Run, command: &str, seed: Option<u64>) -> Result<Film, Error> {
    let words = ["render"].into_iter().chain(command.split_whitespace());
    let matches = Render::command().try_get_matches_from(words);
    let render = matches.and_then(|matches| Render::from_matches(&matches));
    let mut job = render
        .map_err(|error| Error::Option(error.to_string()))?
        .job;
    if let Some(seed) = seed {
        job.seed = seed;
    }
    run.render(&job, "")
}

fn run(run: &mut Run) -> Result<(), Error> {
    whitted(run)?;
    strategies(run)?;
    few_samples(run)?;
    seeds(run)?;
    single(run)?;
    furnace(run)?;
    shining_backs(run)?;
    // The albedo a at which the light lost by seven bounces, a⁸, is one per cent.
    run.number("cut.albedo", 0.01_f64.powf(1.0 / 8.0));
    Ok(())
}

/// Parts of the report's room in an image of 128 × 96 pixels: left, top, and the first column and
/// row outside.
const PARTS: [(&str, [u32; 4]); 6] = [
    ("red-wall", [10, 37, 22, 50]),
    ("blue-wall", [44, 35, 54, 47]),
    ("floor", [75, 86, 83, 92]),
    ("ceiling", [20, 4, 45, 12]),
    ("white-sphere", [69, 46, 75, 52]),
    ("glass-sphere", [50, 60, 72, 80]),
];

/// Returns the mean over a part of a film, of all channels.
fn mean_in(film: &Film, [x0, y0, x1, y1]: [u32; 4]) -> f64 {
    let places = (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y)));
    let sum: f64 = places
        .map(|(x, y)| film.pixel(x, y).mean().element_sum())
        .sum();
    sum / f64::from(3 * (x1 - x0) * (y1 - y0))
}

/// Compares Whitted's image of the report's room with the path tracer's, by parts.
fn whitted(run: &mut Run) -> Result<(), Error> {
    let [path, whitted] = [0, 1].map(|i| rendered(run, COMMANDS[i], None));
    let (path, whitted) = (path?, whitted?);
    let mut lost = Vec::new();
    for (name, part) in PARTS {
        let share = 1.0 - mean_in(&whitted, part) / mean_in(&path, part);
        run.number(&format!("whitted.{name}"), share);
        lost.push((share, name));
    }
    lost.sort_by(|a, b| b.0.total_cmp(&a.0));
    let names: Vec<String> = lost
        .iter()
        .map(|(share, name)| format!("{name} {:.0} %", 100.0 * share))
        .collect();
    let loses = lost.iter().all(|(share, _)| *share > -0.05);
    run.claim(
        "whitted leaves out light, and adds none",
        names.join(", "),
        loses,
    );
    Ok(())
}

/// Side of a tile in which variances are summed, pixels.
const TILE: u32 = 16;

/// Returns the variance of each tile's pixels, summed.
fn tile_noise(film: &Film) -> Vec<f64> {
    let [width, height] = film.size();
    let across = width.div_ceil(TILE);
    let mut sums = vec![0.0; (across * height.div_ceil(TILE)) as usize];
    for y in 0..height {
        for x in 0..width {
            let error = film.pixel(x, y).standard_error();
            sums[(y / TILE * across + x / TILE) as usize] += error.length_squared();
        }
    }
    sums
}

/// Compares the noise of the three strategies, tile by tile.
fn strategies(run: &mut Run) -> Result<(), Error> {
    let films = [2, 3, 4].map(|i| rendered(run, COMMANDS[i], None));
    let [bsdf, light, mis] = films;
    let [bsdf, light, mis] = [bsdf?, light?, mis?].map(|film| tile_noise(&film));
    let share = |is: &dyn Fn(usize) -> bool| {
        (0..mis.len()).filter(|i| is(*i)).count() as f64 / mis.len() as f64
    };
    let bsdf_better = share(&|i| bsdf[i] < light[i]);
    let light_better = share(&|i| light[i] < bsdf[i]);
    let mis_worst = share(&|i| mis[i] > bsdf[i].max(light[i]));
    let ratios = |other: &[f64]| other.iter().sum::<f64>() / mis.iter().sum::<f64>();
    run.numbers(
        "strategies",
        [
            ("bsdf-better", bsdf_better),
            ("light-better", light_better),
            ("mis-worst", mis_worst),
            ("bsdf-variance", ratios(&bsdf)),
            ("light-variance", ratios(&light)),
        ],
    );
    run.note(
        "strategies",
        format!(
            "less variance without shadow rays in {bsdf_better:.2} of tiles, with them alone in {light_better:.2}; \
             both are worst in {mis_worst:.2}"
        ),
    );
    Ok(())
}

/// Compares eight images of four samples with eight others.
fn few_samples(run: &mut Run) -> Result<(), Error> {
    let images = |first: u64| -> Result<Vec<Film>, Error> {
        (first..first + 8)
            .map(|seed| rendered(run, COMMANDS[5], Some(seed)))
            .collect()
    };
    let films = [images(1)?, images(9)?];
    let width = films[0][0].size()[0];
    let planes = |film: &Film| planes(film.pixels(), Pixel::mean);
    let sides = films.map(|films| films.iter().map(planes).collect::<Vec<_>>());
    let found = compare_planes(
        width,
        sides.each_ref().map(Vec::as_slice),
        &Rules::default(),
    );
    let [means, ..] = &found.kinds;
    let largest = means
        .tests
        .iter()
        .flat_map(|test| test.interval(means.level));
    let reach = largest.map(f64::abs).fold(0.0, f64::max);
    run.number("four-samples.reach", reach);
    let undecided = matches!(found.verdict, Verdict::Undecided { .. });
    if let Verdict::Undecided { needed } = found.verdict {
        run.number("four-samples.times", needed as f64);
    }
    run.claim(
        "eight images of four samples do not decide",
        format!(
            "{:?}; an interval reaches {:.1} %",
            found.verdict,
            100.0 * reach
        ),
        undecided,
    );
    Ok(())
}

/// Returns the mean over a film of all channels, and its standard error.
fn image_mean(film: &Film) -> [f64; 2] {
    let count = 3.0 * film.pixels().len() as f64;
    let sum = |of: &dyn Fn(&Pixel) -> f64| film.pixels().iter().map(of).sum::<f64>();
    let variance = sum(&|pixel| pixel.standard_error().element_sum().powi(2));
    [
        sum(&|pixel| pixel.mean().element_sum()) / count,
        variance.sqrt() / count,
    ]
}

/// Compares the image means of two seeds.
fn seeds(run: &mut Run) -> Result<(), Error> {
    let [one, other] = [6, 7].map(|i| rendered(run, COMMANDS[i], None));
    let [one, other] = [image_mean(&one?), image_mean(&other?)];
    let error = one[1].hypot(other[1]);
    let sigmas = (one[0] - other[0]).abs() / error;
    run.numbers(
        "seeds",
        [
            ("first", one[0]),
            ("second", other[0]),
            ("error", one[1]),
            ("sigmas", sigmas),
        ],
    );
    let limit = normal_upper(0.5 * FAMILYWISE_LEVEL);
    run.claim(
        "means of two seeds",
        format!("{sigmas:.2} standard errors apart, {limit:.2} allowed"),
        sigmas <= limit,
    );
    Ok(())
}

/// Compares single with double precision, pixel by pixel, in standard errors.
fn single(run: &mut Run) -> Result<(), Error> {
    let [double, single] = [8, 9].map(|i| rendered(run, COMMANDS[i], None));
    let (double, single) = (double?, single?);
    let pixels = double.pixels().iter().zip(single.pixels());
    let mut differences: Vec<f64> = pixels
        .map(|(a, b)| {
            let error = a.standard_error();
            let difference = (a.mean() - b.mean()).abs();
            (difference / error.max(DVec3::splat(1e-12))).max_element()
        })
        .collect();
    differences.sort_by(f64::total_cmp);
    let below = differences.partition_point(|z| *z < 0.01) as f64 / differences.len() as f64;
    let largest = differences.last().copied().unwrap_or(0.0);
    run.numbers("single", [("below", below), ("largest", largest)]);
    run.note(
        "single precision",
        format!("{below:.3} of pixels within 0.01 standard errors, at most {largest:.2}"),
    );
    Ok(())
}

/// Measures the furnace, and the samples that it takes to detect a deviation of half a per cent.
fn furnace(run: &mut Run) -> Result<(), Error> {
    let film = rendered(run, COMMANDS[10], None)?;
    let [mean, error] = image_mean(&film);
    let samples = 64.0 * film.pixels().len() as f64;
    let sigma = error * samples.sqrt();
    let needed = 147.0 * (sigma / (0.005 * 4.0)).powi(2);
    run.numbers(
        "box",
        [
            ("mean", mean),
            ("error", error),
            ("sigma", sigma),
            ("needed", needed.ceil()),
        ],
    );
    let limit = normal_upper(0.5 * FAMILYWISE_LEVEL);
    let sigmas = (mean - 4.0).abs() / error;
    run.claim(
        "the furnace has radiance 4",
        format!("{mean:.4} ± {error:.4}"),
        sigmas <= limit,
    );
    Ok(())
}

/// Returns the fault of this name.
pub(super) fn faulty_parts(name: &str) -> Result<FaultyParts, Error> {
    let found = faults().into_iter().find(|fault| fault.name == name);
    found.ok_or_else(|| Error::Option(format!("no fault {name}")))
}

/// Compares a path tracer with the magnitude of the cosine for the cosine with the right one.
fn shining_backs(run: &mut Run) -> Result<(), Error> {
    let fault = faulty_parts("back-shines")?;
    let scene = room::diffuse()?;
    let seed = seed_for(run.seed(), "back-shines");
    let film = |of: &dyn Fn() -> Result<Film, Error>| of().map(|film| image_mean(&film));
    let (sampling, size) = (random_points(seed), [64, 48]);
    let wrong = Path::new(Strategy::Mis).with_parts(Parts::replaced(&fault.parts));
    let right = Path::new(Strategy::Mis);
    let wrong = film(&|| render_samples(&scene, &wrong, sampling, size, 16))?;
    let right = film(&|| render_samples(&scene, &right, sampling, size, 16))?;
    let difference = wrong[0] / right[0] - 1.0;
    let error = right[1] / right[0];
    run.numbers("back", [("difference", difference), ("error", error)]);
    run.claim(
        "backs of lamps are seen nowhere in the diffuse room",
        format!("image means differ by {difference:.1e}, standard error {error:.1e}"),
        difference.abs() <= error,
    );
    Ok(())
}
