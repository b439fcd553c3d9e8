//! Crops of the room: pixel strategies magnified, and noise at growing numbers of samples.

use crate::experiments::prelude::*;
use crate::render::PixelName;

/// Renders a part of the room in a frame of 400 × 300.
fn crop(run: &Run, job: Job, label: &str, corner: [u32; 2], size: [u32; 2]) -> Result<Film, Error> {
    let job = Job {
        size: [400, 300],
        window: Some(Window { corner, size }),
        seed: run.seed(),
        ..job
    };
    run.render(&job, label)
}

/// Renders the rim of the white sphere by four strategies: one ray through the centre, then 16 rays
/// each; the first and the last also as single pictures.
pub fn antialiasing(run: &mut Run, [file, first, last]: [&str; 3]) -> Result<(), Error> {
    let strategies = [
        (PixelName::Centre, 1),
        (PixelName::Grid, 16),
        (PixelName::Random, 16),
        (PixelName::Jitter, 16),
    ];
    let mut films = Vec::new();
    for (pixel, spp) in strategies {
        // Whitted's estimator has almost no noise of its own, which would hide that of the edges.
        let job = Job {
            estimator: EstimatorName::Whitted,
            pixel,
            spp,
            ..Job::report(ConventionName::Physical)
        };
        films.push(crop(run, job, &name(pixel), [185, 105], [40, 40])?);
    }
    let display = Job::default().display(0.0);
    write_row(&run.figure(file), &films, display, 6)?;
    for (file, film) in [(first, &films[0]), (last, &films[3])] {
        write_png(&run.figure(file), film, display, 12)?;
    }
    let value =
        "left to right: 1 ray through the centre; 16 rays on a grid, at random, jittered; ×6"
            .to_owned();
    run.note(file, value);
    Ok(())
}

/// Samples per pixel of the pictures.
const SAMPLES: [u32; 4] = [1, 8, 64, 512];

/// Tests "64 samples rather than 512: eight times less": the noise is √8 times less. `few` and
/// `many` show 8 and 512 samples as single pictures.
pub fn noise(run: &mut Run, [picture, plot, few, many]: [&str; 4]) -> Result<(), Error> {
    let side = run.by_tier(64, 120);
    let (mut films, mut errors) = (Vec::new(), Vec::new());
    for spp in SAMPLES {
        // Without mirrors and glass, whose rare bright paths add noise.
        let job = Job {
            scene: SceneName::DiffuseRoom.into(),
            spp,
            ..Job::default()
        };
        let film = crop(run, job, &format!("{spp} spp"), [150, 100], [side, side])?;
        // One sample has no spread.
        if spp > 1 {
            let squares = film
                .pixels()
                .iter()
                .map(|pixel| pixel.standard_error().length_squared());
            let error = (squares.sum::<f64>() / film.pixels().len() as f64).sqrt();
            run.number(&format!("noise.{spp}"), error);
            errors.push([f64::from(spp), error]);
        }
        films.push(film);
    }
    let magnification = run.by_tier(3, 2);
    let display = Job::default().display(0.0);
    write_row(&run.figure(picture), &films, display, magnification)?;
    for (file, film) in [(few, &films[1]), (many, &films[3])] {
        write_png(&run.figure(file), film, display, 2 * magnification)?;
    }
    let ratio = errors[1][1] / errors[2][1];
    run.number("noise.64_over_512", ratio);
    run.claim(
        "noise at 64 samples over noise at 512",
        format!("{ratio:.3}; √8 = {:.3}, not 8", 8f64.sqrt()),
        (ratio / 8f64.sqrt() - 1.0).abs() < 0.05,
    );
    let [n, error] = errors[2];
    let law = |x: f64| [x, error * (n / x).sqrt()];
    let series = vec![
        Series::new(
            "N^(−1/2) through the last point",
            6,
            Mark::Line,
            [law(4.0), law(1000.0)],
        ),
        Series::new("crop", 0, Mark::Points, errors),
    ];
    let title = "Noise of a crop of the all-diffuse room";
    let axes = [
        "samples per pixel N",
        "standard error of a pixel (radiance, rms)",
    ];
    let chart = Chart::new(
        title,
        axes,
        [[4.0, 1000.0], [error * 0.5, error * 20.0]],
        series,
    )
    .log([true; 2]);
    charts(
        run,
        plot,
        "The points lie on a line of slope −1/2.",
        460,
        &[chart],
    )
}
