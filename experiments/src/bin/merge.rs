//! Joins the parts of an image that `render --shard` made.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use experiments::print_line;
use experiments::render::checkpoint::{Checkpoint, ReplicationRange, difference};
use experiments::run::cli::{self, Ending};
use whitefurnace::error::Error;
use whitefurnace::image::{check_writable, write_exr, write_png};

/// Join the parts of an image that render --shard made, to the bytes of the whole: EXR and PNG.
///
/// Example:
///   render --scene cornell --shard 1/2 --out part-1.exr
///   render --scene cornell --shard 2/2 --out part-2.exr
///   merge --out whole.exr part-1.exr part-2.exr
///
/// A part that is missing, there twice, not finished or of another image is refused: exit code 2
/// and its name.
#[derive(Parser)]
#[command(name = "merge", version, verbatim_doc_comment)]
struct Merge {
    /// The EXR file; the PNG has the same name
    #[arg(long)]
    out: PathBuf,
    /// All the parts, in any order
    #[arg(required = true)]
    parts: Vec<PathBuf>,
}

fn main() -> ExitCode {
    cli::start(|| cli::exit(merge(&cli::parse())))
}

fn merge(Merge { out, parts }: &Merge) -> Result<Ending, Error> {
    cli::check_image_name(out)?;
    let png = out.with_extension("png");
    check_writable(out)?;
    check_writable(&png)?;
    let mut paths = parts.iter();
    let Some(first) = paths.next() else {
        return Ok(Ending::Done);
    };
    let mut whole = Checkpoint::read(first)?;
    let mut read: Vec<(&Path, ReplicationRange)> = Vec::new();
    add(&mut read, first, &whole)?;
    for path in paths {
        let part = Checkpoint::read(path)?;
        let total = (whole.part.total != part.part.total)
            .then(|| format!("{} there, {} here", part.part, whole.part));
        if let Some(difference) = difference(&part.job, &whole.job).or(total) {
            return refuse(format!(
                "{} is of another image than {}: {difference}",
                path.display(),
                first.display()
            ));
        }
        add(&mut read, path, &part)?;
        whole.film.merge(&part.film)?;
    }
    read.sort_by_key(|(_, part)| part.range.start);
    let mut end = 0;
    for (_, ReplicationRange { range, .. }) in read.iter().chain([&(
        first.as_path(),
        ReplicationRange {
            range: whole.part.total..0,
            total: 0,
        },
    )]) {
        if range.start > end {
            return refuse(format!(
                "no part has the replications {end}..{} of {}",
                range.start, whole.part.total
            ));
        }
        end = range.end;
    }
    write_exr(
        out,
        &whole.film,
        &whole.camera,
        &whole.job.replace("\ncomplete=no\n", "\ncomplete=yes\n"),
    )?;
    write_png(&png, &whole.film, whole.display, 1)?;
    print_line!(
        "{} and {}: {} parts",
        out.display(),
        png.display(),
        parts.len()
    );
    Ok(Ending::Done)
}

/// Adds a part to the film; refuses one that is unfinished or overlaps another.
fn add<'a>(
    read: &mut Vec<(&'a Path, ReplicationRange)>,
    path: &'a Path,
    Checkpoint { film, part, .. }: &Checkpoint,
) -> Result<(), Error> {
    if !film.has_exactly(part.range.end - part.range.start) {
        return refuse(format!(
            "{} is not finished: finish it with render --resume",
            path.display()
        ));
    }
    let overlaps = |other: &ReplicationRange| {
        other.range.start < part.range.end && part.range.start < other.range.end
    };
    if let Some((other, _)) = read.iter().find(|(_, other)| overlaps(other)) {
        return refuse(format!(
            "{} and {} have the same replications",
            other.display(),
            path.display()
        ));
    }
    read.push((path, part.clone()));
    Ok(())
}

fn refuse<T>(why: String) -> Result<T, Error> {
    Err(Error::Option(why))
}
