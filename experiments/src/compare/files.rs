//! Which files are compared, and whether they can be.

use std::path::{Path, PathBuf};

use sha2::{Digest as _, Sha256};
use whitefurnace::error::Error;
use whitefurnace::image::read::{Picture, decode};

/// An image and where it is from.
pub(super) struct Input {
    pub path: PathBuf,
    /// SHA-256 of the file.
    pub digest: String,
    pub picture: Picture,
}

/// How many there are, in words.
pub(super) fn count(inputs: &[Input]) -> String {
    match inputs {
        [one] => one.path.display().to_string(),
        several => format!("{} images", several.len()),
    }
}

/// Reads the files of these names and patterns.
pub(super) fn read(option: &str, patterns: &[String], layer: Option<&str>) -> Result<Vec<Input>, Error> {
    let mut inputs = Vec::new();
    for pattern in patterns {
        // A file may be called a[1].exr.
        if Path::new(pattern).is_file() {
            inputs.push(read_one(Path::new(pattern), layer)?);
            continue;
        }
        let fault = |error: String| Error::Option(format!("{option} {pattern}: {error}"));
        let mut paths = glob::glob(pattern).map_err(|error| fault(error.to_string()))?.peekable();
        if paths.peek().is_none() {
            return Err(fault("no such file".to_owned()));
        }
        for path in paths {
            inputs.push(read_one(&path.map_err(|error| fault(error.to_string()))?, layer)?);
        }
    }
    Ok(inputs)
}

/// Reads one file.
pub(super) fn read_one(path: &Path, layer: Option<&str>) -> Result<Input, Error> {
    let bytes = std::fs::read(path).map_err(Error::file("read", path))?;
    let digest = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
    Ok(Input { path: path.to_owned(), digest, picture: decode(path, &bytes, layer)? })
}

/// Whether all images are of one frame, and no two are the same.
pub(super) fn check(a: &[Input], b: &[Input]) -> Result<(), Error> {
    let all: Vec<&Input> = a.iter().chain(b).collect();
    for (i, input) in all.iter().enumerate() {
        let fault = |other: &Input, what: &str| {
            Err(Error::Option(format!("{} and {} {what}", other.path.display(), input.path.display())))
        };
        let (picture, first) = (&input.picture, &all[0].picture);
        if (picture.size, picture.corner) != (first.size, first.corner) {
            let frame = |p: &Picture| format!("{} × {} at ({}, {})", p.size[0], p.size[1], p.corner[0], p.corner[1]);
            return fault(all[0], &format!("differ in size or place: {}, {}", frame(first), frame(picture)));
        }
        if picture.channels != first.channels {
            let names = |p: &Picture| p.channels.join(", ");
            return fault(all[0], &format!("have different channels: {}; {}", names(first), names(picture)));
        }
        if let Some(same) = all[..i].iter().find(|other| other.picture.values == picture.values) {
            return fault(same, "have the same pixels: a file given twice, or a seed used twice");
        }
    }
    Ok(())
}
