//! Images of renderers with a mistake each, beside those of the right renderer.

use std::collections::HashMap;

use ::trials::symptoms::{SIZE, ShownBy, Symptom, all};
use whitefurnace::harness::images::{Comparison, Rules};

use crate::experiments::prelude::*;
use crate::run::pictures::write_pixels;

pub(super) const SYMPTOMS: Experiment = Experiment {
    id: "symptoms",
    title: "what a wrong image shows: mistakes beside the right parts",
    headline: "symptoms: {differ %d} of {symptoms %d} mistakes differ from the right parts by more than chance, {alarms %d} pairs of right ones",
    version: 1,
    equations: &[&equation::RENDERING],
    run,
};

/// Images of each side.
const IMAGES: u32 = 16;
/// Side of a tile, pixels.
const TILE: usize = 8;
/// Magnification of the pictures.
const MAGNIFICATION: u32 = 2;

/// Images of one renderer, each row by row.
type Images = Vec<Vec<DVec3>>;

/// Renders images of consecutive seeds.
fn images(
    run: &Run,
    seeds: &str,
    image: impl Fn(u64) -> Result<Vec<DVec3>, Error>,
) -> Result<Images, Error> {
    let seed = |i| seed_for(run.seed(), &format!("symptoms {seeds} {i}"));
    (0..IMAGES)
        .map(|i| match interrupted() {
            true => Err(Error::Interrupted),
            false => image(seed(i)),
        })
        .collect()
}

fn run(run: &mut Run) -> Result<(), Error> {
    let samples = run.count(run.by_tier(2, 12)) as u32;
    let symptoms = all();
    let level = FAMILYWISE_LEVEL / (2 * symptoms.len()) as f64;
    let mut right_images: HashMap<String, [Images; 2]> = HashMap::new();
    let (mut rows, mut differ, mut alarms) = (Vec::new(), 0, 0);
    for symptom in &symptoms {
        let key = symptom.key;
        // The first set has the seeds of the wrong images, for the pictures; the second others, for
        // the tests.
        let setup = symptom.setup();
        if !right_images.contains_key(&setup) {
            let right = |seed| symptom.right(seed, samples);
            let both = [images(run, "wrong", right)?, images(run, "right", right)?];
            right_images.insert(setup.clone(), both);
        }
        let [same, other] = &right_images[&setup];
        let wrong = images(run, "wrong", |seed| symptom.wrong(seed, samples))?;
        let found = judge(symptom.shown_by, &wrong, other, level);
        let chance = judge(symptom.shown_by, same, other, level);
        let noise = noise(&wrong) / noise(other);
        let difference = mean(&wrong) / mean(other) - 1.0;
        let tiles = differing_tiles(&found);
        run.numbers(
            key,
            [("mean", difference), ("tiles", tiles), ("noise", noise)],
        );
        differ += usize::from(found.verdict == Verdict::Fails);
        alarms += usize::from(chance.verdict == Verdict::Fails);
        let value = format!(
            "{}: image mean {:+.1} %, {:.0} % of tiles differ, variance × {noise:.2}",
            symptom.wrong,
            100.0 * difference,
            100.0 * tiles
        );
        rows.push((key, value, found.verdict == Verdict::Fails));
        picture(run, symptom, same, &wrong)?;
    }
    let count = symptoms.len();
    run.number("symptoms", count as f64);
    run.number("differ", differ as f64);
    run.number("alarms", alarms as f64);
    run.number("images", f64::from(IMAGES));
    run.number("samples", f64::from(samples));
    run.number("level", FAMILYWISE_LEVEL);
    if run.by_tier(false, true) {
        run.claim(
            "each mistake differs from the right parts by more than chance",
            format!("{differ} of {count}, familywise level {FAMILYWISE_LEVEL}"),
            differ == count,
        );
        for (key, value, differs) in rows {
            run.detail(key, value, differs);
        }
        run.claim(
            "right parts under other seeds do not",
            format!("{alarms} of {count} do"),
            alarms == 0,
        );
    } else {
        rows.into_iter()
            .for_each(|(key, value, _)| run.note(key, value));
    }
    Ok(())
}

/// Writes the right picture beside the wrong one: means of all images, or the first images if the
/// noise is what they show.
fn picture(run: &mut Run, symptom: &Symptom, right: &Images, wrong: &Images) -> Result<(), Error> {
    let shown = |images: &Images| match symptom.shown_by {
        ShownBy::Mean => mean_image(images),
        ShownBy::Noise | ShownBy::Pattern => images[0].clone(),
    };
    let mut greens: Vec<f64> = mean_image(right).iter().map(|pixel| pixel.y).collect();
    greens.retain(|green| *green > 0.0);
    greens.sort_by(f64::total_cmp);
    let bright = greens.get(greens.len() * 9 / 10).copied().unwrap_or(1.0);
    let exposure = (BRIGHT_SHOWN / bright).log2();
    let path = run.figure(&format!("{}.png", symptom.key));
    let display = Display::Srgb { exposure };
    write_pixels(
        &path,
        &[shown(right), shown(wrong)],
        SIZE,
        display,
        MAGNIFICATION,
    )
}

/// Linear value at which the 90 % quantile of the right image is shown.
const BRIGHT_SHOWN: f64 = 0.45;

fn mean_image(images: &Images) -> Vec<DVec3> {
    (0..images[0].len())
        .map(|i| images.iter().map(|image| image[i]).sum::<DVec3>() / images.len() as f64)
        .collect()
}

fn mean(images: &Images) -> f64 {
    images
        .iter()
        .flatten()
        .map(|pixel| pixel.element_sum())
        .sum()
}

/// Returns the sum of the variances of all pixels between images, from differences of two images
/// each.
fn noise(images: &Images) -> f64 {
    let pairs = differences(images);
    pairs
        .iter()
        .flatten()
        .map(|d| (*d * *d).element_sum())
        .sum()
}

/// Returns the differences of the first and second image, the third and fourth, and so on.
fn differences(images: &Images) -> Images {
    images
        .chunks_exact(2)
        .map(|two| two[0].iter().zip(&two[1]).map(|(a, b)| *a - *b).collect())
        .collect()
}

/// Returns the images of a quantity whose mean is to be judged.
fn shown_quantity(by: ShownBy, images: &Images) -> Images {
    let width = SIZE[0] as usize;
    let of_differences = |quantity: &dyn Fn(&[DVec3], usize) -> DVec3| {
        let image = |image: Vec<DVec3>| (0..image.len()).map(|i| quantity(&image, i)).collect();
        differences(images).into_iter().map(image).collect()
    };
    match by {
        ShownBy::Mean => images.clone(),
        ShownBy::Noise => of_differences(&|image, i| image[i] * image[i]),
        // Whether two neighbours err to the same side: half of them if they are independent.
        ShownBy::Pattern => of_differences(&|image, i| {
            let left = i - i % width % 2;
            let product = image[left] * image[left + 1];
            product
                .to_array()
                .map(|channel| f64::from(channel > 0.0))
                .into()
        }),
    }
}

/// Returns the result of `compare` on two sides.
fn judge(by: ShownBy, a: &Images, b: &Images, level: f64) -> Comparison {
    let sides = [a, b].map(|images| -> Vec<Planes> {
        let quantity = shown_quantity(by, images);
        quantity
            .iter()
            .map(|image| planes(image, DVec3::clone))
            .collect()
    });
    let rules = Rules {
        level,
        tile: TILE,
        ..Rules::default()
    };
    compare_planes(SIZE[0], sides.each_ref().map(Vec::as_slice), &rules)
}

/// Returns the fraction of tiles of which a channel differs.
fn differing_tiles(found: &Comparison) -> f64 {
    let [_, _, tiles, _] = &found.kinds;
    let count = tiles.grid[0] * tiles.grid[1];
    let differs = |i: &usize| {
        let mut channels = tiles.tests.iter().skip(*i).step_by(count);
        channels.any(|test| tiles.rejects(test))
    };
    (0..count).filter(differs).count() as f64 / count as f64
}
