//! Renders one image: linear EXR with error bars, and a PNG beside it.

use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use clap::CommandFactory as _;
use experiments::render::command::Render;
use experiments::render::{Rendered, SceneSource};
use experiments::run::cli::{self, Ending};
use experiments::say;
use whitefurnace::error::Error;
use whitefurnace::image::{check_writable, write_exr, write_png};

fn main() -> ExitCode {
    cli::start(|| {
        let matches = cli::matches(Render::command());
        let options = cli::or_one_line(Render::of(&matches));
        cli::exit(options.check(&matches).and_then(|()| run(&options)))
    })
}

fn run(options: &Render) -> Result<Ending, Error> {
    // A finished image is never replaced by a part of one.
    let partial = options.out.with_extension("partial.exr");
    cli::use_threads(options.threads)?;
    for exr in [&options.out, &partial] {
        check_writable(exr)?;
        check_writable(&exr.with_extension("png"))?;
    }
    cli::begin();
    if let SceneSource::File(file) = options.job.scene {
        file.left_out.iter().for_each(|what| eprintln!("note: {what}"));
    }

    let start = Instant::now();
    let rendered = match options.job.render("render") {
        Ok(rendered) => rendered,
        Err(Error::Interrupted) => {
            eprintln!("interrupted before the first sample: nothing is written");
            return Ok(Ending::Interrupted);
        }
        Err(error) => return Err(error),
    };
    if rendered.complete {
        write(&options.out, options, &rendered, start)?;
        return Ok(Ending::Done);
    }
    write(&partial, options, &rendered, start)?;
    eprintln!("interrupted: these files hold the samples done so far (channel samples.Y)");
    Ok(Ending::Interrupted)
}

/// Writes the EXR and the PNG, and says what they hold.
fn write(exr: &Path, options: &Render, Rendered { film, complete }: &Rendered, start: Instant) -> Result<(), Error> {
    let seconds = start.elapsed().as_secs_f64();
    let png = exr.with_extension("png");
    write_exr(exr, film, &options.job.provenance(*complete))?;
    write_png(&png, film, options.job.display(options.exposure), 1)?;
    let replications = film.pixels().iter().map(|p| u64::from(p.replications()));
    let samples = replications.sum::<u64>() * u64::from(film.samples_per_replication());
    let error = film.relative_error();
    let error = if error.is_finite() {
        format!("mean relative standard error {:.2} %", 100.0 * error)
    } else {
        "no standard error: a pixel has fewer than two replications, or all is black".to_owned()
    };
    say!(
        "{} and {}: {samples} samples in {seconds:.1} s, {:.2} million/s, {error}",
        exr.display(),
        png.display(),
        samples as f64 / seconds / 1e6
    );
    Ok(())
}
