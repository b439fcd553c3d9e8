//! Tests that previews and saved states at any moment equal a render of as many samples.

use std::collections::BTreeMap;
use std::path::Path;

use experiments::render::checkpoint::{Checkpoint, CheckpointWriter, ReplicationRange};
use experiments::render::preview::Preview;
use experiments::render::{Job, Observer};
use whitefurnace::film::{Film, Pixel};
use whitefurnace::image::{Display, write_rgb};
use whitefurnace::integrator::{Bdpt, ImageEstimator as _, Parts};
use whitefurnace::sampling::sampler::{ImagePass, SamplerKind};

use crate::{folder, job};

/// Records the film at every call.
#[derive(Default)]
struct Watch {
    films: Vec<Film>,
}

impl Observer for Watch {
    fn is_due(&self) -> bool {
        true
    }
    fn observe(&mut self, film: &Film) {
        self.films.push(film.clone());
    }
}

/// Returns the films of a job at every moment when an observer is called, and the last.
fn moments(job: &Job) -> Vec<Film> {
    let mut watch = Watch::default();
    let film = job.film().expect("a film");
    let rendered = job
        .render_onto("", film, &(0..job.all_replications()), &mut [&mut watch])
        .expect("rendered");
    watch.films.push(rendered.film);
    watch.films
}

/// Returns the pixels of a render with this many replications.
fn pixels_of(job: &Job, replications: u32) -> Vec<Pixel> {
    let film = job
        .render_onto("", job.film().expect("a film"), &(0..replications), &mut [])
        .expect("rendered")
        .film;
    film.pixels().to_vec()
}

/// Returns a checkpoint that saves films of a job in a file.
fn saver(job: &Job, path: &Path) -> CheckpointWriter {
    let camera = job.camera().expect("a scene");
    let part = ReplicationRange {
        range: 0..job.all_replications(),
        total: job.all_replications(),
    };
    CheckpointWriter::new(
        path.to_owned(),
        Checkpoint::attributes(job, &camera, &part, 0.0),
    )
}

/// Asserts that a checkpoint, which may have saved other films before, saves this one.
fn assert_saves(saver: &mut CheckpointWriter, film: &Film, path: &Path) {
    saver.observe(film);
    saver.finish();
    assert!(
        Checkpoint::read(path).expect("a file").film == *film,
        "{}",
        path.display()
    );
}

/// Tall and wide, with independent and with Sobol' numbers, in each precision: at every moment each
/// pixel equals that of a render of as many replications. All moments are saved into one file by
/// the same checkpoint, and shown.
#[test]
fn every_moment_is_a_render_of_as_many_samples() {
    let folder = folder("moments");
    for words in [
        "--size 7x33 --spp 9 --adaptive no --sampler independent",
        "--size 33x7 --spp 24 --sampler sobol --scrambles 6",
        "--size 9x5 --spp 6 --sampler independent --precision single --scene cornell",
        "--size 5x9 --spp 5 --sampler independent --estimator sppm --photons 500 --radius 0.5",
    ] {
        let job = job(&format!("render {words}"));
        let path = folder.join("a.partial.exr");
        let mut saver = saver(&job, &path);
        let display = Display::Srgb { exposure: 0.0 };
        let [shown, expected] = ["shown.png", "expected.png"].map(|file| folder.join(file));
        let mut renders: BTreeMap<u32, Vec<Pixel>> = BTreeMap::new();
        let films = moments(&job);
        assert!(films.len() > 4, "{words}: {}", films.len());
        for (moment, film) in films.iter().enumerate() {
            let mut means = Vec::new();
            for (i, pixel) in film.pixels().iter().enumerate() {
                let count = pixel.replications();
                let same = renders
                    .entry(count)
                    .or_insert_with(|| pixels_of(&job, count));
                assert!(*pixel == same[i], "{words}: pixel {i} at moment {moment}");
                means.push(same[i].mean());
            }
            assert!(film.means_so_far() == means, "{words}: moment {moment}");
            assert_saves(&mut saver, film, &path);
            // Two moments with one preview.
            let mut preview = Preview::png(shown.clone(), job.size, display);
            preview.observe(&films[moment.saturating_sub(1)]);
            preview.finish(film);
            let rgb: Vec<u8> = means
                .iter()
                .flat_map(|mean| mean.to_array().map(|value| display.encode(value)))
                .collect();
            write_rgb(&expected, job.size, &rgb).expect("written");
            let bytes = [&shown, &expected].map(|path| std::fs::read(path).expect("there"));
            assert!(bytes[0] == bytes[1], "{words}: moment {moment}");
        }
    }
}

/// A scramble with some of its passes done is shown as their mean, and saved.
#[test]
fn a_begun_scramble_is_shown_as_the_mean_of_its_passes() {
    let path = folder("begun").join("a.partial.exr");
    let job = job("render --scene cornell --estimator bdpt --size 6x11 --spp 12 --scrambles 3");
    let scene = job.build_scene().expect("a scene");
    let mut sums = vec![glam::DVec3::ZERO; 66];
    let films = moments(&job);
    assert!(films.len() >= 12, "{}", films.len());
    let mut saver = saver(&job, &path);
    for (index, film) in films.iter().take(12).enumerate() {
        assert_saves(&mut saver, film, &path);
        let pass = ImagePass {
            sampler: SamplerKind::Sobol(4),
            seed: job.seed,
            index: index as u32,
        };
        let image = Bdpt::new(Parts::default())
            .image(&scene, job.size, pass)
            .expect("an image");
        sums.iter_mut()
            .zip(image)
            .for_each(|(sum, value)| *sum += value);
        for (shown, sum) in film.means_so_far().into_iter().zip(&sums) {
            let expected = *sum / (index + 1) as f64;
            assert!(
                (shown - expected).abs().max_element() <= 1e-9 * (1.0 + expected.max_element()),
                "pass {index}"
            );
        }
    }
}
