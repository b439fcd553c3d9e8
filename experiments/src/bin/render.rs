//! Renders one image: a linear EXR with error bars, and a PNG beside it.

use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use clap::CommandFactory as _;
use experiments::print_line;
use experiments::render::checkpoint::{Checkpoint, CheckpointWriter, difference};
use experiments::render::command::Render;
use experiments::render::pilot::Target;
use experiments::render::{Observer, Rendered};
use experiments::run::cli::{self, Ending};
use whitefurnace::error::Error;
use whitefurnace::film::Film;
use whitefurnace::image::{check_writable, write_exr, write_png};
use whitefurnace::math::moments::FIXED_POINT_UNIT;
use whitefurnace::render::checkpoint::write_checkpoint;

fn main() -> ExitCode {
    cli::start(|| {
        let start = Instant::now();
        let matches = cli::matches(Render::command());
        let mut options = cli::unwrap_or_exit(Render::from_matches(&matches));
        // Checks may build the scene, on all threads.
        cli::exit(
            cli::use_threads(options.threads)
                .and_then(|()| options.check(&matches))
                .and_then(|()| run(&mut options, start)),
        )
    })
}

fn run(options: &mut Render, start: Instant) -> Result<Ending, Error> {
    // An unfinished image never replaces a finished one.
    let partial = options.out.with_extension("partial.exr");
    let mut previews = options.previews()?;
    options.preview.as_deref().map_or(Ok(()), check_writable)?;
    for exr in [&options.out, &partial] {
        check_writable(exr)?;
        check_writable(&exr.with_extension("png"))?;
    }
    let saved = if options.resume && partial.exists() {
        Some(Checkpoint::read(&partial)?)
    } else {
        None
    };
    cli::begin();
    options.job.scene.print_notes();
    decide(options, saved.as_ref(), start)?;
    let (job, part, camera) = (
        options.job,
        options.replication_range()?,
        options.job.camera()?,
    );
    let film = saved.map_or_else(
        || job.film(),
        |saved| checked_film(&partial, options, saved),
    )?;
    let before = samples(&film);

    let attributes = Checkpoint::attributes(&job, &camera, &part, options.exposure);
    let mut saves = CheckpointWriter::new(partial.clone(), attributes.clone());
    let mut observers: Vec<&mut dyn Observer> = vec![&mut saves];
    observers.extend(
        previews
            .iter_mut()
            .map(|preview| preview as &mut dyn Observer),
    );
    let Rendered { film, complete } =
        match job.render_onto("render", film, &part.range, &mut observers) {
            Ok(rendered) => rendered,
            Err(Error::Interrupted) => {
                eprintln!("interrupted before the first sample of this run: no file is written");
                return Ok(Ending::Interrupted);
            }
            Err(error) => return Err(error),
        };
    saves.finish();
    // Free the copy of the film that was saved last: writing the files needs memory.
    drop(saves);
    let exr = if complete { &options.out } else { &partial };
    let png = exr.with_extension("png");
    let written = if complete && options.shard.is_none() {
        write_exr(exr, &film, &camera, &job.provenance(&camera, true))
    } else {
        write_checkpoint(exr, &film, &attributes)
    };
    let shown = written.and_then(|()| write_png(&png, &film, job.display(options.exposure), 1));
    shown.inspect_err(|_| {
        if partial.exists() {
            eprintln!(
                "{} holds the saved samples: --resume continues from there",
                partial.display()
            );
        }
    })?;
    previews
        .into_iter()
        .for_each(|preview| preview.finish(&film));
    print_result(exr, &film, samples(&film) - before, start);
    if let Some(note) = rounding_note(&film) {
        eprintln!("note: {note}");
    }
    if !complete {
        eprintln!(
            "interrupted: these files hold the samples done so far (channel samples.Y); --resume continues from there"
        );
        return Ok(Ending::Interrupted);
    }
    for file in [partial.with_extension("png"), partial] {
        if file.exists() {
            std::fs::remove_file(&file).map_err(Error::file("remove", &file))?;
        }
    }
    Ok(Ending::Done)
}

/// Decides the number of samples, where a time or an error is asked for.
fn decide(options: &mut Render, saved: Option<&Checkpoint>, start: Instant) -> Result<(), Error> {
    let time = options.time.map(|time| Target::Time(start, time));
    let Some(target) = time.or(options.target_error.map(Target::Error)) else {
        return Ok(());
    };
    let decided = saved.and_then(|saved| {
        saved
            .job
            .lines()
            .find_map(|line| line.strip_prefix("spp=")?.parse().ok())
    });
    let (spp, how) = match decided {
        Some(spp) => (spp, "decided when this run began"),
        None => (options.job.decide(target)?, "decided by a pilot"),
    };
    options.set_spp(spp);
    print_line!("{how}: --spp {spp}");
    options.job.check()
}

/// Returns the saved film if it belongs to this very image.
fn checked_film(path: &Path, options: &Render, saved: Checkpoint) -> Result<Film, Error> {
    let (here, part) = (
        options.job.provenance(&options.job.camera()?, false),
        options.replication_range()?,
    );
    let parts =
        (saved.part != part).then(|| format!("replications {} there, {part} here", saved.part));
    match difference(&saved.job, &here).or(parts) {
        None if saved.film.is_compatible(&options.job.film()?) => Ok(saved.film),
        None => Err(Error::Option(format!(
            "--resume: {} has another size than it states",
            path.display()
        ))),
        Some(difference) => Err(Error::Option(format!(
            "--resume: {} is of another run: {difference}; repeat its options, choose another --out, or begin afresh without \
             --resume",
            path.display()
        ))),
    }
}

fn samples(film: &Film) -> u64 {
    film.pixels()
        .iter()
        .map(|pixel| u64::from(pixel.samples()))
        .sum()
}

/// Returns a note, with a remedy, if the image is so dark that the rounding of its pixels is
/// visible.
fn rounding_note(film: &Film) -> Option<String> {
    let (mean, error) = (film.mean(), film.rounding_error());
    let rounds = format!("pixels are rounded to multiples of {FIXED_POINT_UNIT:.1e}");
    if mean == 0.0 {
        return Some(format!(
            "the image is black: no sample found light, or only light that is rounded to 0, for {rounds}; if some is missed, \
             multiply every emission and the background by a large number, as 1e9, and divide the image by it"
        ));
    }
    (error > MAX_ROUNDING_ERROR).then(|| {
        let factor = 10_f64.powi(-mean.log10().floor() as i32);
        format!(
            "the mean of the image is {mean:.1e} and {rounds}: it may be off by {:.2} %; multiply every emission and the \
             background by {factor:e}, and divide the image by it",
            100.0 * error
        )
    })
}

/// Largest relative rounding error of the mean without a note.
const MAX_ROUNDING_ERROR: f64 = 1e-4;

/// Prints what the files hold; `new` is the number of samples that this run took.
fn print_result(exr: &Path, film: &Film, new: u64, start: Instant) {
    let seconds = start.elapsed().as_secs_f64();
    let error = film.relative_error();
    let error = if error.is_finite() {
        format!("mean relative standard error {:.2} %", 100.0 * error)
    } else {
        "no standard error: a pixel has fewer than two replications, or the image is black"
            .to_owned()
    };
    let samples = samples(film);
    let earlier = if new < samples {
        format!(" ({new} of them now)")
    } else {
        String::new()
    };
    print_line!(
        "{} and {}: {samples} samples{earlier} in {seconds:.1} s, {:.2} million/s, {error}",
        exr.display(),
        exr.with_extension("png").display(),
        new as f64 / seconds / 1e6
    );
}
